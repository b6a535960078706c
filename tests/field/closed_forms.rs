//! The exact field against the closed forms of gratings, Parseval's theorem and the grating equation.
//!
//! `m` is the order, `d` the period, `z = k·w` (negative on the visible side).

use std::f64::consts::{PI, TAU};

use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::field::{Domain, Field, Scratch, coefficient_brute};
use diffraction_shaders::optics::spectrum::Spectrum;
use diffraction_shaders::optics::{direction, path_difference};
use diffraction_shaders::plan::{Coherence, Grating, Optics};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use glam::{DVec2, DVec3};

const SIGMA_UM: f64 = 65.0 / 4.0;
const PERIOD_UM: f64 = 2.5;
const HEIGHT_UM: f64 = 0.3;
const Z: [f64; 4] = [-32.0, -22.2, -9.1, -0.7];

fn make(grating: Grating) -> HeightField {
    synthesise(&grating, "grating").expect("valid grating").field
}

fn field(height: &HeightField) -> Field {
    let domain = Domain {
        coherence: Coherence::Single,
        sigma_um: (SIGMA_UM, SIGMA_UM),
        z: (-33.1, -0.1),
        reach_cpum: 5.3,
    };
    Field::new(height, &domain)
}

/// `|c_m|²` as the windowed response at the order's own frequency.
fn order(field: &Field, m: i32, n: i32, period_um: [f64; 2], z: f64) -> f64 {
    let f = DVec2::new(f64::from(m) / period_um[0], f64::from(n) / period_um[1]);
    field.intensity(f, z, SIGMA_UM, &mut Scratch::default())
}

fn sinc(t: f64) -> f64 {
    if t == 0.0 { 1.0 } else { (PI * t).sin() / (PI * t) }
}

/// Greatest difference from a closed form over orders and `z`.
fn worst(height: &HeightField, closed: impl Fn(i32, f64) -> f64) -> f64 {
    let field = field(height);
    let error = |m: i32, z: f64| (order(&field, m, 0, [PERIOD_UM, 1e9], z) - closed(m, z)).abs();
    (-8..=8).flat_map(|m| Z.map(|z| error(m, z))).fold(0.0, f64::max)
}

#[test]
fn flat_has_the_zero_order_only() {
    let height = make(Grating::Flat { period_um: PERIOD_UM, pixels: 100 });
    assert!(worst(&height, |m, _| f64::from(u8::from(m == 0))) < 1e-12);
}

#[test]
fn sinusoidal_is_a_bessel_function() {
    let height =
        make(Grating::Sinusoidal { period_um: PERIOD_UM, height_um: HEIGHT_UM, pixels: 100 });
    let error = worst(&height, |m, z| libm::jn(m, z * HEIGHT_UM / 2.0).powi(2));
    assert!(error < 1e-9, "{error:e}");
    // negative control: one order off
    assert!(worst(&height, |m, z| libm::jn(m + 1, z * HEIGHT_UM / 2.0).powi(2)) > 0.1);
}

#[test]
fn crossed_is_the_product_of_its_gratings() {
    let x = Grating::Sinusoidal { period_um: 2.0, height_um: 0.2, pixels: 80 };
    let y = Grating::Sinusoidal { period_um: 1.5, height_um: 0.1, pixels: 75 };
    let height = make(Grating::Crossed { x: Box::new(x), y: Box::new(y) });
    let field = field(&height);
    for z in Z {
        for (m, n) in [(0, 0), (1, 0), (0, -1), (2, 1), (-3, 2), (1, -2)] {
            let closed = (libm::jn(m, z * 0.1) * libm::jn(n, z * 0.05)).powi(2);
            let got = order(&field, m, n, [2.0, 1.5], z);
            assert!((got - closed).abs() < 1e-9, "{m},{n} z={z}: {got} against {closed}");
        }
    }
}

/// Errors at N, 2N, 4N pixels per period.
fn errors(make_with: impl Fn(usize) -> Grating, closed: impl Fn(i32, f64) -> f64) -> [f64; 3] {
    [100, 200, 400].map(|pixels| worst(&make(make_with(pixels)), &closed))
}

#[test]
fn triangle_converges_quadratically() {
    let apex = 0.3;
    let closed = |m: i32, z: f64| {
        let (m, psi) = (f64::from(m), z * HEIGHT_UM);
        let (rising, falling) = (psi + TAU * m * apex, psi - TAU * m * (1.0 - apex));
        let (a, b) = (apex * sinc(rising / TAU), (1.0 - apex) * sinc(falling / TAU));
        let phase = 0.5 * (rising - falling);
        a * a + b * b + 2.0 * a * b * phase.cos()
    };
    let e = errors(
        |pixels| Grating::Triangle { period_um: PERIOD_UM, height_um: HEIGHT_UM, pixels, apex },
        closed,
    );
    assert!(e[0] < 1e-2 && e[1] < e[0] / 3.5 && e[2] < e[1] / 3.5, "{e:?}");
}

#[test]
fn blazed_converges() {
    let closed = |m: i32, z: f64| sinc(z * HEIGHT_UM / TAU + f64::from(m)).powi(2);
    let e = errors(
        |pixels| Grating::Blazed { period_um: PERIOD_UM, height_um: HEIGHT_UM, pixels },
        closed,
    );
    assert!(e[0] < 1e-2 && e[1] < e[0] / 1.9 && e[2] < e[1] / 1.9, "{e:?}");
    // negative control: blazed the other way
    let mirrored = |m: i32, z: f64| sinc(z * HEIGHT_UM / TAU - f64::from(m)).powi(2);
    let height = make(Grating::Blazed { period_um: PERIOD_UM, height_um: HEIGHT_UM, pixels: 100 });
    assert!(worst(&height, mirrored) > 0.5);
}

#[test]
fn lamellar_converges() {
    let duty = 0.35;
    let closed = |m: i32, z: f64| {
        let psi = z * HEIGHT_UM;
        match m {
            0 => (1.0 - duty + duty * psi.cos()).powi(2) + (duty * psi.sin()).powi(2),
            m => {
                4.0 * (psi / 2.0).sin().powi(2) * (PI * f64::from(m) * duty).sin().powi(2)
                    / (PI * f64::from(m)).powi(2)
            }
        }
    };
    let e = errors(
        |pixels| Grating::Lamellar { period_um: PERIOD_UM, height_um: HEIGHT_UM, pixels, duty },
        closed,
    );
    assert!(e[0] < 1e-2 && e[1] < e[0] / 1.9 && e[2] < e[1] / 1.9, "{e:?}");
}

#[test]
fn small_heights_give_the_spectrum_of_the_heights() {
    let height_um = 1e-5;
    let height = make(Grating::Sinusoidal { period_um: PERIOD_UM, height_um, pixels: 100 });
    let field = field(&height);
    let got = order(&field, 1, 0, [PERIOD_UM, 1e9], -20.0);
    let first_order = (20.0 * height_um / 4.0_f64).powi(2);
    assert!((got / first_order - 1.0).abs() < 1e-6, "{got:e}");
}

#[test]
fn energy_is_conserved() {
    let heights_um: Vec<f64> = (0..12 * 9).map(|i| f64::from((i * 7919) % 101) * 0.004).collect();
    let height = HeightField::new(12, 9, 0.06, 0.07, heights_um).expect("valid");
    for z in Z {
        let sum: f64 = (0..9)
            .flat_map(|s| (0..12).map(move |r| (r, s)))
            .map(|(r, s)| coefficient_brute(&height, r, s, z).norm_sqr())
            .sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }
}

#[test]
fn a_mirror_at_normal_incidence_is_white() {
    let height = make(Grating::Flat { period_um: PERIOD_UM, pixels: 100 });
    let up = Directions { wi: DVec3::Z, wr: DVec3::Z };
    let reference = Reference::new(&height, 0.0, &Optics::standard(), Reference::VISIBLE_NM, [up])
        .expect("small");
    let got = reference.tristimulus(up, &mut Scratch::default());
    let white = Spectrum::new(&"D65".into()).expect("D65").white();
    assert!(got.iter().zip(white).all(|(g, w)| (g - w).abs() < 1e-9), "{got:?} against {white:?}");
    assert!((got[1] - 1.0).abs() < 1e-9);
}

/// `|c_m|²` at the direction where the grating equation puts the order, nothing a few widths beside it; in the plane of
/// incidence across the grooves, and with light along them (the orders then lie on a cone).
#[test]
fn orders_lie_where_the_grating_equation_puts_them() {
    let height =
        make(Grating::Sinusoidal { period_um: PERIOD_UM, height_um: HEIGHT_UM, pixels: 100 });
    let optics = Optics::standard();
    let mut seen = 0;
    for (theta_i, phi_i) in [(20.0, 0.0), (20.0, 180.0), (35.0, 90.0), (50.0, 37.0)] {
        let wi = direction(theta_i, phi_i);
        for (m, lambda_um) in [(0, 0.55), (1, 0.45), (-1, 0.65), (2, 0.5), (-2, 0.55)] {
            let viewer = |u: f64| {
                let (x, y) = (-wi.x - u, -wi.y);
                DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())
            };
            let u = f64::from(m) * lambda_um / PERIOD_UM;
            let (peak, beside) = (viewer(u), viewer(u + 0.02));
            if !(peak.z > 0.1 && beside.z > 0.1) {
                continue; // evanescent, or nearly so
            }
            seen += 1;
            let both = [peak, beside].map(|wr| Directions { wi, wr });
            let reference =
                Reference::new(&height, 0.0, &optics, Reference::VISIBLE_NM, both).expect("small");
            let mut scratch = Scratch::default();
            let [peak, beside] = both.map(|d| reference.response(d, lambda_um * 1e3, &mut scratch));
            let z = TAU / lambda_um * path_difference(wi, both[0].wr, 0.0).z;
            let closed = libm::jn(m, z * HEIGHT_UM / 2.0).powi(2);
            assert!(
                (peak - closed).abs() < 1e-9,
                "order {m} from {theta_i},{phi_i}: {peak} against {closed}"
            );
            assert!(beside < 1e-3 * closed, "order {m} is not narrow: {beside}");
        }
    }
    assert!(seen > 15, "{seen} orders");
}

/// The facets of `h = H x/d` lean towards `-x`; so does their reflection, whichever side the light comes from.
#[test]
fn a_blaze_throws_light_to_its_own_side() {
    let height = make(Grating::Blazed { period_um: PERIOD_UM, height_um: HEIGHT_UM, pixels: 100 });
    for phi_i in [0.0, 180.0] {
        let wi = direction(20.0, phi_i);
        let lambda_um = 0.55;
        let orders: Vec<(f64, Directions)> = (-8..=8)
            .filter_map(|m| {
                let x = -wi.x - f64::from(m) * lambda_um / PERIOD_UM;
                (x.abs() < 1.0)
                    .then(|| (x, Directions { wi, wr: DVec3::new(x, 0.0, (1.0 - x * x).sqrt()) }))
            })
            .collect();
        let reference = Reference::new(
            &height,
            0.0,
            &Optics::standard(),
            Reference::VISIBLE_NM,
            orders.iter().map(|o| o.1),
        )
        .expect("small");
        let mut scratch = Scratch::default();
        let weights: Vec<f64> =
            orders.iter().map(|o| reference.response(o.1, lambda_um * 1e3, &mut scratch)).collect();
        let mean: f64 = orders.iter().zip(&weights).map(|(o, w)| o.0 * w).sum::<f64>()
            / weights.iter().sum::<f64>();
        // reflection at a facet: the path difference is along its normal (-H/d, 0, 1)
        let facet = DVec3::new(-HEIGHT_UM / PERIOD_UM, 0.0, 1.0).normalize();
        let reflected = 2.0 * wi.dot(facet) * facet - wi;
        assert!(reflected.x < -wi.x - 0.1, "geometry");
        assert!(
            (mean - reflected.x).abs() < 0.05,
            "light from {phi_i}: mean {mean}, facet {}",
            reflected.x
        );
    }
}

/// Full width at half maximum of an isolated order, `λ √(ln 2)/(π σs)`: 0.00897 at 550 nm. A sinc's or another
/// variance's width is not that.
#[test]
fn the_lobe_is_the_coherence_windows() {
    let height = make(Grating::Flat { period_um: PERIOD_UM, pixels: 100 });
    let field = field(&height);
    let lambda_um = 0.55;
    let width = lambda_um * 2.0_f64.ln().sqrt() / (PI * SIGMA_UM);
    assert!((width - 0.00897).abs() < 1e-5);
    let at = |u: f64| {
        field.intensity(DVec2::new(u / lambda_um, 0.0), -20.0, SIGMA_UM, &mut Scratch::default())
    };
    assert!((at(width / 2.0) - 0.5).abs() < 1e-12);
    assert!((at(width) - 0.0625).abs() < 1e-12, "a Gaussian falls to 1/16 at twice its half width");
}
