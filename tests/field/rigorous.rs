//! The scalar theory against a rigorous solver.
//!
//! `rigorous/README.md` says how the solver's numbers were made. Its tables were printed by a program with its own formulas
//! of the scalar theory. Here they must follow from the library.

use std::f64::consts::TAU;

use diffraction_shaders::field::rigorous::{Departure, Solved, SolvedOrder, WEAK, solved};
use diffraction_shaders::optics::{Index, reflectances};
use diffraction_shaders::plan::{Medium, Obliquity};

const README: &str = include_str!("../../rigorous/README.md");

/// The README has ratios of orders with more than this by both ways.
const STRONG: f64 = 0.1;

fn named(name: &str) -> Solved {
    solved().unwrap().into_iter().find(|grating| grating.name == name).unwrap()
}

/// Least and greatest ratio of rigorous to scalar.
fn span(pairs: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    let ratios = pairs.map(|[rigorous, scalar]| rigorous / scalar);
    ratios.fold([f64::INFINITY, 0.0], |[low, high], v| [low.min(v), high.max(v)])
}

#[track_caller]
fn within([low, high]: [f64; 2], [from, to]: [f64; 2]) {
    assert!(low >= from && high <= to, "{low:.4} to {high:.4}, not within {from} to {to}");
}

/// The cosines of light and viewer inside the cover, and the product of the sines.
fn inside(order: &SolvedOrder) -> [f64; 3] {
    let [si, sr] = [order.theta_i_deg, order.theta_r_deg]
        .map(|degrees| degrees.to_radians().sin() / order.cover_index);
    [(1.0 - si * si).sqrt(), (1.0 - sr * sr).sqrt(), si * sr]
}

/// Efficiencies of one polarisation with Stam's obliquity in place of its own.
fn with_stam(order: &SolvedOrder, of: Obliquity) -> [f64; 2] {
    let [ci, cr, sines] = inside(order);
    let [rigorous, scalar] = order.efficiencies(of);
    let root = if of == Obliquity::Te { ci * cr } else { 1.0 + sines };
    [rigorous, scalar * ((1.0 + sines + ci * cr) / (2.0 * root)).powi(2)]
}

/// The same for an order ±1 of a sinusoidal relief, with the phase that the relief would have in air.
fn with_phase_of_air(order: &SolvedOrder, of: Obliquity, height_um: f64) -> [f64; 2] {
    let [ci, cr, _] = inside(order);
    let cos = |degrees: f64| degrees.to_radians().cos();
    let square = |w: f64| {
        let z = TAU / (order.wavelength_nm * 1e-3) * w;
        libm::jn(1, z * height_um / 2.0).powi(2)
    };
    let air = cos(order.theta_i_deg) + cos(order.theta_r_deg);
    let [rigorous, scalar] = with_stam(order, of);
    [rigorous, scalar * square(air) / square(order.cover_index * (ci + cr))]
}

/// A relief of 5 nm under a cover of index 1.58 leaves obliquity and phase. In the orders ±1 the solver differs from
/// Stam's obliquity by 0.949 to 0.985 in TE and 1.015 to 1.053 in TM, from those of TE and TM by 0.9945 to 1.0015 for
/// aluminium and 1e-4 for a perfect conductor. In unpolarised light both obliquities differ by at most 0.0023.
#[test]
fn under_a_cover_each_order_has_the_solvers_phase_and_obliquity() {
    for (name, own) in [("covered relief", 7e-3), ("covered relief perfect", 2e-4)] {
        let grating = named(name);
        let of_order = |m: i64| grating.orders.iter().filter(move |o| o.order.abs() == m);
        assert!(of_order(0).count() == 9 && of_order(1).count() >= 15, "{name}");
        for (m, own, mean) in [(0, 2e-4, 3e-5), (1, own, 3e-3)] {
            for of in [Obliquity::Te, Obliquity::Tm] {
                let exact = span(of_order(m).map(|o| o.efficiencies(of)));
                within(exact, [1.0 - own, 1.0 + own]);
                within(span(of_order(m).map(|o| with_stam(o, of))), [0.94, 1.06]);
            }
            for of in [Obliquity::Unpolarised, Obliquity::Stam] {
                within(span(of_order(m).map(|o| o.efficiencies(of))), [1.0 - mean, 1.0 + mean]);
            }
        }
        // negative control: the phase of air
        let air = |of| span(of_order(1).map(|o| with_phase_of_air(o, of, grating.height_um)));
        assert!(air(Obliquity::Te)[0] > 2.0 && air(Obliquity::Tm)[0] > 2.0);
    }
}

/// The first orders of a relief of 5 nm take at most 0.7 %, and both ways leave the rest of Fresnel's reflectance to the
/// mirror order.
#[test]
fn a_nearly_flat_surface_has_the_reflectance_of_fresnel() {
    let grating = named("covered relief");
    let metal = Index::new("metal", &Medium::Named("aluminium")).unwrap();
    for order in grating.orders.iter().filter(|o| o.order == 0) {
        let (nm, [cos, ..]) = (order.wavelength_nm, inside(order));
        let [s, p] = reflectances(order.cover_index, cos, &[], metal.at(nm), nm);
        for (of, flat) in [(Obliquity::Te, s), (Obliquity::Tm, p)] {
            for efficiency in order.efficiencies(of) {
                let lost = 1.0 - efficiency / flat;
                assert!(lost > 0.0 && lost < 0.008, "{order:?} {of:?}: {efficiency} of {flat}");
            }
        }
    }
}

/// The greatest and the mean difference of efficiencies in unpolarised light. Those of deep or fine reliefs are where the
/// theory fails.
#[test]
fn gratings_are_as_far_from_the_solver_as_documented() {
    const LIMITS: [(&str, f64, f64); 8] = [
        ("holographic shallow", 0.03, 0.002),
        ("holographic deep", 0.3, 0.08),
        ("blazed", 0.16, 0.04),
        ("CD", 0.11, 0.025),
        ("DVD", 0.15, 0.05),
        ("covered relief", 1e-4, 1e-5),
        ("covered relief perfect", 1e-4, 1e-5),
        ("fine and deep", 1.0, 0.35),
    ];
    let all = solved().unwrap();
    assert_eq!(all.len(), LIMITS.len());
    for (grating, (name, worst, mean)) in all.iter().zip(LIMITS) {
        assert_eq!(grating.name, name);
        let found = grating.departure(Obliquity::Stam);
        assert!(found.worst < worst && found.mean < mean, "{name}: {found:?}");
    }
    // the comparison sees what is wrong
    assert!(named("fine and deep").departure(Obliquity::Stam).worst > 0.3);
}

/// Directions follow the equation of gratings with the orders' sign, and blazed facets look to the same side.
#[test]
fn orders_have_the_same_sign() {
    for grating in solved().unwrap() {
        for order in &grating.orders {
            let [si, sr] = [order.theta_i_deg, order.theta_r_deg].map(|a| a.to_radians().sin());
            let shift = order.order as f64 * order.wavelength_nm * 1e-3 / grating.period_um;
            assert!((si + sr + shift).abs() < 1e-6, "{}: {order:?}", grating.name);
        }
    }
    let blazed = named("blazed");
    let straight = blazed.orders.iter().filter(|o| o.theta_i_deg == 0.0);
    let efficiencies = |order: &SolvedOrder| order.efficiencies(Obliquity::Stam);
    // negative control: scalar orders of the other sign
    let mirrored = straight.flat_map(|order| {
        let is_other = |o: &&SolvedOrder| {
            o.theta_i_deg == 0.0
                && (o.wavelength_nm, o.order) == (order.wavelength_nm, -order.order)
        };
        let other = blazed.orders.iter().find(is_other)?;
        Some((efficiencies(order)[0] - efficiencies(other)[1]).abs())
    });
    assert!(mirrored.fold(0.0, f64::max) > 0.5);
}

/// The cells of the README's lines with a number of cells.
fn cells(count: usize) -> impl Iterator<Item = Vec<&'static str>> {
    let lines = README.lines().filter(|line| line.starts_with("| "));
    let cells = lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect());
    cells.filter(move |cells: &Vec<_>| {
        cells.len() == count && ["TE", "TM", "both"].contains(&cells[1])
    })
}

/// A number with its digits, or two of them. The solver's numbers in the table have five digits.
#[track_caller]
fn printed(text: &str, values: &[f64], what: &str) {
    let numbers: Vec<&str> = text.split(" – ").collect();
    assert_eq!(numbers.len(), values.len(), "{what}: {text}");
    for (number, value) in numbers.iter().zip(values) {
        let digits = number.split('.').nth(1).map_or(0, str::len);
        let off = (number.parse::<f64>().unwrap() - value).abs();
        let rounding = 0.5 * 0.1_f64.powi(digits as i32) + 1e-4 * value;
        assert!(off < rounding, "{what}: {text}, found {values:?}");
    }
}

fn departure(pairs: &[[f64; 2]]) -> Departure {
    let off: Vec<f64> = pairs.iter().map(|[rigorous, scalar]| (rigorous - scalar).abs()).collect();
    let worst = off.iter().copied().fold(0.0, f64::max);
    Departure { count: off.len(), worst, mean: off.iter().sum::<f64>() / off.len() as f64 }
}

#[test]
fn the_tables_of_the_readme_follow_from_the_library() {
    let all = solved().unwrap();
    let mut lines = 0;
    for row in cells(9) {
        let [name, light, count, worst, mean, own_worst, own_mean, ratio, own_ratio] = row[..]
        else {
            unreachable!("nine cells")
        };
        let what = format!("{name}, {light}");
        let grating = all.iter().find(|grating| grating.name == name).unwrap();
        let own = match light {
            "TE" => Obliquity::Te,
            "TM" => Obliquity::Tm,
            _ => Obliquity::Unpolarised,
        };
        let stam = |order: &SolvedOrder| match own {
            Obliquity::Unpolarised => order.efficiencies(Obliquity::Stam),
            _ => with_stam(order, own),
        };
        let strong = |pair: &[f64; 2]| pair[0] > WEAK;
        let stam: Vec<_> = grating.orders.iter().map(stam).filter(strong).collect();
        let exact = grating.orders.iter().map(|order| order.efficiencies(own));
        let exact: Vec<_> = exact.filter(strong).collect();
        assert_eq!(count.parse::<usize>().unwrap(), stam.len(), "{what}");
        assert_eq!(departure(&exact), grating.departure(own), "{what}");
        for ([worst, mean, ratio], pairs) in
            [([worst, mean, ratio], &stam), ([own_worst, own_mean, own_ratio], &exact)]
        {
            let found = departure(pairs);
            printed(worst, &[found.worst], &what);
            printed(mean, &[found.mean], &what);
            let strong = pairs.iter().copied().filter(|pair| pair[0].min(pair[1]) > STRONG);
            printed(ratio, &span(strong), &what);
        }
        lines += 1;
    }
    for row in cells(5) {
        let [metal, light, stam, own, air] = row[..] else { unreachable!("five cells") };
        let what = format!("{metal}, {light}");
        let is_meant = |g: &&Solved| g.name.starts_with("covered") && g.metal == metal;
        let grating = all.iter().find(is_meant).unwrap();
        let of = if light == "TE" { Obliquity::Te } else { Obliquity::Tm };
        let first = || grating.orders.iter().filter(|order| order.order.abs() == 1);
        printed(stam, &span(first().map(|o| with_stam(o, of))), &what);
        printed(own, &span(first().map(|o| o.efficiencies(of))), &what);
        printed(air, &span(first().map(|o| with_phase_of_air(o, of, grating.height_um))), &what);
        lines += 1;
    }
    assert_eq!(lines, 24 + 4);
}
