//! The sum over bins against the exact field.

use crate::support::data;
use std::path::Path;

use diffraction_shaders::field::comparison_directions::on_orders;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::optics::brdf_map::view_directions;
use diffraction_shaders::optics::colour_difference::{ColourDifference, colour_difference};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Plan, Variant};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner};
use diffraction_shaders::shader::specialise;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::{LobeGeometry, Table};
use diffraction_shaders::variant::Form;
use diffraction_shaders::variant::Twin;

const BLAZED: &str = "{ kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 100 }";
const LAMELLAR: &str =
    "{ kind = \"lamellar\", period_um = 1.6, height_um = 0.12, pixels = 100, duty = 0.69 }";
const CROSSED: &str = "{ kind = \"crossed\", x = { kind = \"sinusoidal\", period_um = 2.0, height_um = 0.2, pixels = 60 }, y = { kind = \"blazed\", period_um = 1.5, height_um = 0.15, pixels = 50 } }";

fn read(surface: &str, keys: &str) -> (HeightField, Variant) {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "a"
{surface}
[variants]
mode = "adaptive"
terms = "auto"
term_error = 1e-6
{keys}
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{text}: {e}"));
    (load(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone())
}

fn grating(grating: &str, keys: &str) -> (HeightField, Variant) {
    read(&format!("grating = {grating}"), keys)
}

/// The measured crop, where the folder of scans is.
fn crop(keys: &str) -> Option<(HeightField, Variant)> {
    let file = data::find("elaphe_crop_100px.png")?;
    Some(read(&format!("file = {file:?}\npixel_um = 0.0586\nheight_um = 0.375"), keys))
}

/// The whole scan that the crop is of.
fn scan(keys: &str) -> Option<(HeightField, Variant)> {
    let file = data::find("elaphe_65um.png")?;
    Some(read(&format!("file = {file:?}\nsize_um = 65.0\nheight_um = 0.375"), keys))
}

/// A map of 64² under a light, and a thousand directions on orders and around the mirror direction.
fn directions(height: &HeightField, variant: &Variant, theta_i: f64) -> Vec<Directions> {
    let wi = direction(theta_i, 0.0);
    let mut all: Vec<Directions> =
        view_directions(64).into_iter().map(|wr| Directions { wi, wr }).collect();
    all.extend(on_orders(height, &variant.optics, 0.0, wi, 1000, 1));
    all
}

fn against_the_exact(name: &str, subject: &(HeightField, Variant)) -> ColourDifference {
    under(20.0, name, subject)
}

fn under(theta_i: f64, name: &str, (height, variant): &(HeightField, Variant)) -> ColourDifference {
    let subject = Placement { height, rotate_deg: 0.0, variant };
    let directions = directions(height, variant, theta_i);
    let exact = Exact(subject).tristimulus(&directions).unwrap();
    let twin = TwinRunner::new(subject, true).unwrap();
    let colours = twin.tristimulus(&directions).unwrap();
    let all = colour_difference(name, &exact, &colours, None).unwrap();
    let map = directions.len() - 1000;
    let drawn = colour_difference(name, &exact[map..], &colours[map..], None).unwrap();
    let cost = Form::new(variant, height).unwrap().cost();
    println!(
        "{name} {}: all p95 {:.3} max {:.3}, drawn p95 {:.3} max {:.3}, max_abs {:.1e}; evaluations {:.1} worst {}",
        variant.name,
        all.de2000.p95,
        all.de2000.max,
        drawn.de2000.p95,
        drawn.de2000.max,
        all.max_abs,
        cost.evaluations_mean,
        cost.evaluations
    );
    all
}

#[test]
fn colours_are_those_of_the_exact_field() {
    for keys in ["", "coherence = \"ensemble\"", "coherence_scaling = \"wavelength\""] {
        let mut subjects = vec![
            ("blazed", grating(BLAZED, keys)),
            ("lamellar", grating(LAMELLAR, keys)),
            ("crossed", grating(CROSSED, keys)),
        ];
        subjects.extend(crop(keys).map(|crop| ("crop", crop)));
        for (name, subject) in &subjects {
            let found = against_the_exact(name, subject);
            assert!(found.de2000.p95 <= 0.5, "{name} {keys}: {found:?}");
        }
    }
}

/// No number was chosen at one angle or on one surface.
#[test]
fn colours_hold_under_other_lights() {
    let fingers = "{ kind = \"fingers\", size_um = 6.6, pixels = 90, pitch_um = 1.1, height_um = 0.3, seed = 3 }";
    let mut subjects = vec![("lamellar", grating(LAMELLAR, "")), ("fingers", grating(fingers, ""))];
    subjects.extend(crop("").map(|crop| ("crop", crop)));
    for theta_i in [0.0, 60.0, 75.0] {
        for (name, subject) in &subjects {
            let found = under(theta_i, name, subject);
            assert!(found.de2000.p95 <= 0.5, "{name} at {theta_i}: {found:?}");
        }
    }
}

/// Weights per wavenumber without `dλ = λ² d(1/λ)`: a purple cast that the comparison must not let pass.
#[test]
fn weights_without_their_jacobian_are_found() {
    let (height, variant) = &grating(CROSSED, "");
    let directions = directions(height, variant, 20.0);
    let subject = Placement { height, rotate_deg: 0.0, variant };
    let exact = Exact(subject).tristimulus(&directions).unwrap();
    let form = Form::new(variant, height).unwrap();
    let mut tables = specialise::tables(&form, height, 0.0).unwrap();
    let colours = |tables: &[Table]| -> Vec<[f64; 3]> {
        let twin = Twin::new(&form, tables, 0.0);
        directions.iter().map(|d| twin.tristimulus(*d)).collect()
    };
    let right = colour_difference("right", &exact, &colours(&tables), None).unwrap();
    let width = tables[1].width;
    for (place, texel) in tables[1].texels.chunks_mut(4).enumerate() {
        // row 1 holds no weights
        if place / width == 1 {
            continue;
        }
        // 0.55² keeps the brightness
        let jacobian = (texel[3].max(0.1) / 0.55).powi(2);
        texel[..3].iter_mut().for_each(|weight| *weight /= jacobian);
    }
    let wrong = colour_difference("wrong", &exact, &colours(&tables), None).unwrap();
    assert!(right.de2000.p95 < 0.5 && wrong.de2000.p95 > 5.0, "{wrong:?}");
}

/// A coherence length of one patch: lobes as wide as their distance.
#[test]
fn an_ensemble_is_exact_though_lobes_overlap() {
    let keys = "coherence = \"ensemble\"\ncoherence_um = 5.8";
    for (name, subject) in
        [("crossed", grating(CROSSED, "coherence = \"ensemble\"\ncoherence_um = 2.0"))]
            .into_iter()
            .chain(crop(keys).map(|crop| ("crop", crop)))
            .chain(scan("coherence = \"ensemble\"").map(|scan| ("scan", scan)))
    {
        let found = against_the_exact(name, &subject);
        assert!(found.de2000.p95 <= 0.5, "{name}: {found:?}");
    }
}

#[test]
fn a_single_patch_with_overlapping_lobes_is_refused() {
    let (height, variant) = grating(CROSSED, "coherence_um = 2.0");
    let message = Form::new(&variant, &height).unwrap_err().to_string();
    assert!(message.contains("σf·L = 0.64") && message.contains("ensemble"), "{message}");
    let subject = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    assert!(TwinRunner::new(subject, true).is_err());
}

/// One wavelength: `|P|²` where there is light.
#[test]
fn the_response_at_one_wavelength_is_the_exact_one() {
    for subject in [grating(BLAZED, ""), grating(CROSSED, "")] {
        let (height, variant) = &subject;
        let subject = Placement { height, rotate_deg: 0.0, variant };
        let directions = directions(height, variant, 20.0);
        let exact = Exact(subject).response(&directions, 550.0).unwrap();
        let twin = TwinRunner::new(subject, false).unwrap().response(&directions, 550.0).unwrap();
        let largest = exact.iter().copied().fold(0.0, f64::max);
        for (exact, twin) in exact.iter().zip(&twin) {
            assert!((exact - twin).abs() < 2e-4 * largest, "{twin} against {exact}");
        }
    }
}

/// On a grating of one period the corridor visits the orders of the texts' loop, `N_min = d u/λmax` to
/// `N_max = d u/λmin`, at their wavelengths `d u/n`; and, cut short, those whose lobes reach into the range.
#[test]
fn a_grating_is_visited_at_the_wavelengths_of_its_orders() {
    let (height, variant) = grating(BLAZED, "");
    let period_um = height.size_x_um();
    let patch_um = [period_um, height.size_y_um()];
    let lobes = LobeGeometry::new((&variant.optics).into(), &variant.wavelengths, patch_um);
    for u in [-1.7, -0.9, -0.31, 0.4, 0.8, 1.3, 1.9] {
        let [low, high] = [0.78, 0.38].map(|lambda_um: f64| period_um * u / lambda_um);
        let (least, most) = (low.min(high).ceil() as i64, low.max(high).floor() as i64);
        let visited = lobes.bins([u, 0.0]);
        assert!(visited.iter().all(|(bin, _)| bin[1] == 0));
        for n in least..=most {
            let (_, span) = visited.iter().find(|(bin, _)| bin[0] == n).expect("every order");
            let lambda_um = period_um * u / n as f64;
            let cut = span[0] <= lobes.range[0] || span[1] >= lobes.range[1];
            let centre = 2.0 / (span[0] + span[1]);
            assert!(cut || (centre - lambda_um).abs() < 1e-12, "order {n} at {centre}");
        }
        let others = visited.iter().filter(|(bin, _)| !(least..=most).contains(&bin[0]));
        for (bin, span) in others {
            assert!(
                span[0] <= lobes.range[0] || span[1] >= lobes.range[1],
                "order {bin:?} is no order of the texts, nor cut by an end of the range: {span:?}"
            );
        }
    }
}
