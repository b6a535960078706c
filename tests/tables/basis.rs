//! The bases whose coefficients are a table: stated bounds against true errors, numbers of terms, colours, shaders.

use crate::support::data;
use crate::support::package;

use std::path::Path;

use diffraction_shaders::field::comparison_directions::on_orders;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::field::transform::Bins;
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::optics::brdf_map::view_directions;
use diffraction_shaders::optics::colour_difference::{ColourDifference, colour_difference};
use diffraction_shaders::optics::direction;
use diffraction_shaders::optics::spectrum::Spectrum;
use diffraction_shaders::plan::{
    Basis, Mode, Plan, Reconstruction, Sampling, Variant, Wavelengths,
};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner};
use diffraction_shaders::shader::emit::emit;
use diffraction_shaders::shader::specialise;
use diffraction_shaders::shader::template::Sources;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::basis::Expansion;
use diffraction_shaders::tables::terms::Terms;
use diffraction_shaders::tables::{Table, coefficients_table};
use diffraction_shaders::variant::Form;
use diffraction_shaders::variant::Twin;
use rustfft::num_complex::Complex64;

const FINGERS: &str = "grating = { kind = \"fingers\", size_um = 6, pixels = 96, pitch_um = 1.1, height_um = 0.36, seed = 1 }";
const BLAZED: &str =
    "grating = { kind = \"blazed\", period_um = 2.5, height_um = 0.36, pixels = 100 }";
const BASES: [Basis; 2] = [Basis::Chebyshev, Basis::Optimal];

fn plan(surface: &str, keys: &str) -> (HeightField, Plan) {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "a"
{surface}
[variants]
{keys}
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{keys}: {e}"));
    (load(&plan.surfaces[0]).unwrap().field, plan)
}

fn height(surface: &str) -> HeightField {
    plan(surface, "mode = \"full\"").0
}

/// The phase function as a shader makes it: interpolated coefficients times the functions of the height.
fn phase_function(expansion: &Expansion, table: &Table, tau: f64, h_um: f64) -> Complex64 {
    let place = (tau + 1.0) * (table.width - 1) as f64;
    let index = (place as i64).min(table.width as i64 - 2);
    let part = place - index as f64;
    let x = (h_um - expansion.origin_um) / expansion.reach_um;
    let terms = expansion.curves.iter().take(expansion.terms as usize).enumerate();
    let sum: Complex64 = terms
        .map(|(n, curve)| {
            let texel = |i: i64| table.load(i, n as i64 / 4, 0)[n % 4];
            let coefficient = texel(index) * (1.0 - part) + texel(index + 1) * part;
            Complex64::i().powu(curve.turns) * curve.height(x) * coefficient
        })
        .sum();
    sum * Complex64::cis(expansion.centre_z() * (h_um - expansion.origin_um))
}

/// Greatest error over the surface's heights and z, off and on the nodes.
fn true_error(expansion: &Expansion, table: &Table, height: &HeightField) -> f64 {
    let mut heights: Vec<f64> = height.heights_um().to_vec();
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    let step = heights.len().div_ceil(400);
    let ends = [heights[0], heights[heights.len() - 1]];
    let heights: Vec<f64> = heights.into_iter().step_by(step).chain(ends).collect();
    let mut most = 0.0_f64;
    for i in 0..=997 {
        let tau = -f64::from(i) / 997.0;
        for h in &heights {
            let want = Complex64::cis(tau * expansion.z_max * (h - expansion.origin_um));
            most = most.max((phase_function(expansion, table, tau, *h) - want).norm());
        }
    }
    most
}

#[test]
fn the_stated_bound_holds_and_is_not_loose() {
    let tall = BLAZED.replace("0.36", "1.5");
    let lamellar = "grating = { kind = \"lamellar\", period_um = 2, height_um = 0.15, pixels = 60, duty = 0.4 }";
    for (name, surface) in
        [("fingers", FINGERS), ("blazed", BLAZED), ("tall", &tall), ("lamellar", lamellar)]
    {
        let height = height(surface);
        for basis in BASES {
            for error in [1e-1, 1e-2, 1e-3, 1e-4] {
                let expansion = Expansion::new(basis, 1, &height, 380.0).with_error(error);
                let table = coefficients_table(&expansion, expansion.nodes());
                let (bound, found) = (expansion.bound(), true_error(&expansion, &table, &height));
                println!(
                    "{name} {} {error:e}: {} terms, {} nodes, bound {bound:.2e}, true {found:.2e}",
                    basis.as_str(),
                    expansion.terms,
                    table.width
                );
                assert!(bound <= error && found <= bound, "{name} {basis:?}: {found:e}, {bound:e}");
                // two heights are met exactly, up to the interpolation
                if name != "lamellar" {
                    assert!(bound < 4.0 * found, "{name} {basis:?}: {found:e}, {bound:e}");
                }
            }
        }
    }
}

#[test]
fn fewer_terms_than_a_power_series() {
    let height = height(BLAZED);
    let terms = |basis| Expansion::new(basis, 1, &height, 380.0).with_error(1e-2).terms;
    assert_eq!([Basis::Taylor, Basis::Chebyshev, Basis::Optimal].map(terms), [19, 11, 6]);
}

/// Faint light at the blue end may err more, so that all other errs less; the bound stays one for all.
#[test]
fn an_optimum_for_the_light_that_is_seen_errs_less_there() {
    let height = height(BLAZED);
    let seen_nm = Spectrum::new(&"D65".into()).unwrap().faint_below_nm(&Wavelengths {
        min_nm: 380.0,
        max_nm: 780.0,
        step_nm: 5.0,
    });
    // a twentieth of X + Y + Z lies below
    assert!((425.0..435.0).contains(&seen_nm), "{seen_nm}");
    let greatest = |expansion: &Expansion, beyond: bool| {
        let seen_tau = 380.0 / seen_nm;
        let taus = (0..=400).map(|i| f64::from(i) / 400.0);
        let table = coefficients_table(expansion, expansion.nodes());
        taus.filter(|tau| (*tau > seen_tau) == beyond)
            .flat_map(|tau| height.heights_um().iter().map(move |h| (-tau, *h)))
            .map(|(tau, h)| {
                let want = Complex64::cis(tau * expansion.z_max * (h - expansion.origin_um));
                (phase_function(expansion, &table, tau, h) - want).norm()
            })
            .fold(0.0, f64::max)
    };
    let alike = Expansion::new(Basis::Optimal, 5, &height, 380.0);
    let best = Expansion::over((0.0, 380.0), seen_nm, Basis::Optimal, 5, &height);
    let found = [&best, &alike].map(|one| [false, true].map(|beyond| greatest(one, beyond)));
    assert!(found[0][0] < 0.8 * found[1][0], "{found:?}");
    assert!(greatest(&best, true) > greatest(&alike, true));
    assert!(greatest(&best, true) <= best.bound());
}

#[test]
fn a_swapped_row_of_coefficients_shows() {
    let height = height(FINGERS);
    for basis in BASES {
        let expansion = Expansion::new(basis, 1, &height, 380.0).with_error(1e-3);
        let mut table = coefficients_table(&expansion, expansion.nodes());
        assert!(true_error(&expansion, &table, &height) < 1e-3);
        table.texels.chunks_mut(4).for_each(|texel| texel.swap(0, 1));
        assert!(true_error(&expansion, &table, &height) > 0.1);
    }
}

/// The tables of terms are the transforms of the functions that the bound is of.
#[test]
fn terms_times_coefficients_are_the_transform_of_the_phase_function() {
    let heights_um: Vec<f64> = (0..35).map(|i| f64::from(i * i % 13) * 0.02).collect();
    let height = HeightField::new(7, 5, 0.06, 0.05, heights_um).unwrap();
    for basis in BASES {
        let expansion = Expansion::new(basis, 26, &height, 400.0);
        let terms = Terms::new(&height, &expansion, Bins { r_max: 3, s_max: 2 }, None);
        for tau in [-1.0, -0.37, 0.0] {
            let z = tau * expansion.z_max;
            for (r, s) in [(0, 0), (1, 0), (0, -2), (-3, 2)] {
                let sum: Complex64 =
                    (0..26).map(|n| terms.at(n, r, s) * expansion.coefficient(n, tau)).sum();
                let exact = diffraction_shaders::field::coefficient_brute(&height, r, s, z);
                let want = exact * Complex64::cis(-z * expansion.origin_um);
                assert!((sum - want).norm() < 1e-9, "{basis:?} {r},{s} τ={tau}: {sum} {want}");
            }
        }
    }
}

fn difference(height: &HeightField, variant: &Variant, spoil: bool) -> ColourDifference {
    let wi = direction(20.0, 0.0);
    let mut directions: Vec<Directions> =
        view_directions(32).into_iter().map(|wr| Directions { wi, wr }).collect();
    directions.extend(on_orders(height, &variant.optics, 0.0, wi, 300, 1));
    // the same sum over bins and wavelengths with a power series that has converged
    let converged = plan(BLAZED, "basis = \"taylor\"").1.variants[0].terms;
    let whole = Variant { basis: Basis::Taylor, terms: converged, ..variant.clone() };
    let placement = Placement { height, rotate_deg: 0.0, variant: &whole };
    let want = TwinRunner::new(placement, false).unwrap().tristimulus(&directions).unwrap();
    let form = Form::new(variant, height).unwrap();
    let mut tables: Vec<Table> = specialise::tables(&form, height, 0.0).unwrap();
    tables = tables.into_iter().map(Table::rounded).collect();
    if spoil {
        let table = tables.iter_mut().find(|t| t.name == "coefficients").unwrap();
        table.texels.chunks_mut(4).for_each(|texel| texel.swap(1, 2));
    }
    let twin = Twin::new(&form, &tables, 0.0);
    let got: Vec<[f64; 3]> = directions.iter().map(|&d| twin.tristimulus(d)).collect();
    colour_difference(&variant.name, &want, &got, None).unwrap()
}

const MODES: &str = "mode = [\"full\", \"pq\", \"adaptive\"]\nwavelengths = [{ step_nm = 10 }]\n";

#[test]
fn colours_with_few_terms() {
    let scan = data::find("elaphe_crop_100px.png")
        .map(|file| format!("file = {file:?}\npixel_um = 0.0586\nheight_um = 0.375"));
    for surface in [Some(FINGERS.to_owned()), scan].into_iter().flatten() {
        for (basis, terms, limit) in
            [("optimal", 5, 0.5), ("optimal", 6, 0.1), ("chebyshev", 11, 0.1)]
        {
            let keys = format!(
                r#"{MODES}coherence = ["single", "ensemble"]
basis = "{basis}"
terms = {terms}
table = ["f32", "f16"]
packing = ["paired", "single"]"#
            );
            let (height, plan) = plan(&surface, &keys);
            let isolated = |v: &&Variant| Form::new(v, &height).is_ok();
            for variant in plan.variants.iter().filter(isolated) {
                let found = difference(&height, variant, false);
                println!(
                    "{}: p95 {:.4}, max {:.3}",
                    variant.name, found.de2000.p95, found.de2000.max
                );
                assert!(found.de2000.p95 < limit, "{}: {found:?}", variant.name);
            }
        }
    }
}

/// Two coefficients exchanged give other colours: the test above can fail.
#[test]
fn exchanged_coefficients_change_the_colours() {
    let (height, plan) = plan(
        FINGERS,
        r#"mode = "full"
basis = ["optimal", "chebyshev"]
terms = 6
accept_error = true
wavelengths = { step_nm = 20 }"#,
    );
    for variant in &plan.variants {
        assert!(difference(&height, variant, true).de2000.p95 > 2.0, "{}", variant.name);
    }
}

#[test]
fn every_mode_and_form_compiles_for_every_target() {
    let keys = format!(
        r#"{MODES}basis = ["optimal", "chebyshev"]
terms = [1, 5, "auto"]
accept_error = true
coherence = ["single", "ensemble"]
table = ["f32", "f16"]
packing = ["paired", "single"]"#
    );
    let (height, plan) = plan(BLAZED, &keys);
    let count = |mode| plan.variants.iter().filter(|v| v.mode == mode).count();
    assert_eq!([Mode::Full, Mode::Pq, Mode::Adaptive].map(count), [48, 24, 48]);
    for variant in &plan.variants {
        let form = Form::new(variant, &height).unwrap();
        let shapes = specialise::shapes(&form, 0.0);
        assert_eq!(shapes.len(), 3);
        let nodes = specialise::node_count(&shapes);
        let defines = specialise::defines(variant, &form, 0.0, nodes);
        let module = specialise::shader(&Sources::builtin(), &variant.name, &form, &defines)
            .unwrap_or_else(|e| panic!("{}: {:?}", variant.name, package::lines(&e)));
        for target in package::TARGETS {
            emit(&module, target).unwrap_or_else(|e| panic!("{}: {e}", variant.name));
        }
        let bytes: usize = shapes.iter().map(Table::byte_count).sum();
        assert_eq!(bytes as u64, form.cost().table_bytes, "{}", variant.name);
    }
}

#[test]
fn what_has_no_meaning_is_told() {
    let (height, plan) =
        plan(BLAZED, "basis = [\"taylor\", \"optimal\"]\nhoist = false\nterms = \"auto\"");
    assert_eq!(plan.variants.len(), 1);
    assert!(plan.rejected[0].reason.contains("not powers"), "{:?}", plan.rejected);
    let fine = Variant {
        basis: Basis::Optimal,
        reconstruction: Reconstruction::Window,
        sampling: Sampling::Load,
        hoist: true,
        term_error: 1e-9,
        ..plan.variants[0].clone()
    };
    let message = Form::new(&fine, &height).unwrap_err().to_string();
    assert!(message.contains("term_error = 1e-9"), "{message}");
}
