//! The order sum of GPU Gems: where its rainbows lie, and what it does not offer.

use std::path::Path;

use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::optics::colour::to_rgb;
use diffraction_shaders::plan::{Plan, Variant};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::variant::Form;
use glam::DVec3;

fn read(grating: &str) -> (HeightField, Variant) {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "a"
grating = {grating}
[variants]
mode = "gems"
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap();
    (load(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone())
}

const CD: &str =
    "{ kind = \"lamellar\", period_um = 1.6, height_um = 0.12, pixels = 100, duty = 0.69 }";

/// Linear RGB for light along the normal and a viewer at `u` across the grooves.
fn colour(rotate_deg: f64, u: f64, v: f64) -> [f64; 3] {
    let (height, variant) = read(CD);
    let runner =
        TwinRunner::new(Placement { height: &height, rotate_deg, variant: &variant }, true)
            .unwrap();
    let wr = DVec3::new(-u, -v, (1.0 - u * u - v * v).sqrt());
    let xyz = runner.tristimulus(&[Directions { wi: DVec3::Z, wr }]).unwrap()[0];
    to_rgb(xyz, variant.optics.colour)
}

#[test]
fn orders_have_the_chapters_colours() {
    // λ = d u: the middle of the chapter's green, 0.75 µm, then of its red; order 2 lies below its range
    let [r, g, b] = colour(0.0, 0.75 / 1.6, 0.0);
    assert!((g - 1.0).abs() < 1e-3 && r.abs() < 1e-3 && b.abs() < 1e-3, "{r} {g} {b}");
    let [r, g, _] = colour(0.0, 0.875 / 1.6, 0.0);
    assert!((r - 1.0).abs() < 1e-3 && g.abs() < 1e-3, "{r} {g}");
    // along the grooves only the highlight, white; turned by 90°, the rainbow
    let along = colour(0.0, 0.0, 0.75 / 1.6);
    assert!(along.iter().all(|c| (c - 1.0).abs() < 2e-3), "{along:?}");
    let turned = colour(90.0, 0.0, 0.75 / 1.6);
    assert!((turned[1] - 1.0).abs() < 1e-3 && turned[0].abs() < 1e-3, "{turned:?}");
}

#[test]
fn what_it_has_not_is_told() {
    let (height, variant) = read(CD);
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let up = Directions { wi: DVec3::Z, wr: DVec3::Z };
    let runner = TwinRunner::new(placement, true).unwrap();
    let message = runner.response(&[up], 550.0).unwrap_err().to_string();
    assert!(message.contains("has no wavelength axis"), "{message}");
    let cost = Form::new(&variant, &height).unwrap().cost();
    assert_eq!((cost.evaluations, cost.fetches), (0, 1));

    let (height, variant) = read("{ kind = \"flat\", period_um = 2.5, pixels = 100 }");
    let message = Form::new(&variant, &height).unwrap_err().to_string();
    assert!(message.contains("a flat surface has no period"), "{message}");
}
