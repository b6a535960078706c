//! Metals, covers and films in every form against the exact reference, from the normal to 75°.

use std::f64::consts::TAU;
use std::path::Path;

use diffraction_shaders::field::comparison_directions::{on_orders, under_lights};
use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::light::{Cap, Light, Lights};
use diffraction_shaders::optics::colour_difference::colour_difference;
use diffraction_shaders::optics::{Matter, direction};
use diffraction_shaders::plan::{Plan, Variant};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::variant::{Form, Part};
use glam::DVec3;

const CD: &str =
    "{ kind = \"lamellar\", period_um = 1.6, height_um = 0.12, pixels = 50, duty = 0.7 }";
const WAVES: &str = "{ kind = \"sinusoidal\", period_um = 1.3, height_um = 0.2, pixels = 64 }";

/// What the surfaces are made of.
const MATTER: [(&str, &str, &str); 4] = [
    ("cd", CD, "material = \"aluminium\"\ncover_index = \"polycarbonate\""),
    ("gold in air", WAVES, "material = \"gold\""),
    (
        "nickel under a film and lacquer",
        WAVES,
        "material = \"nickel\"\ncover_index = 1.2\nfilms = [{ index = 2.2, thickness_nm = 250 }]\nobliquity = \"te\"",
    ),
    (
        "copper under PMMA, unpolarised",
        WAVES,
        "material = \"copper\"\ncover_index = \"pmma\"\nobliquity = \"unpolarised\"",
    ),
];

/// The preset that `unpolarised` has not.
const BAKED: &str =
    "[[preset]]\nname = \"baked\"\nmode = \"baked\"\nbake_error = 1.0\nbake_mib = 128\n";

/// One preset of each form with an error of its own.
const FORMS: &str = r#"
[[preset]]
name = "full"
basis = "optimal"
terms = "auto"
window_radius = "auto"
wavelengths = { min_nm = 380, max_nm = 780, step_nm = 2.5 }
[[preset]]
name = "taylor"
mode = "adaptive"
terms = 29
[[preset]]
name = "optimal"
mode = "adaptive"
basis = "optimal"
terms = "auto"
[[preset]]
name = "prefiltered"
mode = "adaptive"
reconstruction = "prefiltered"
basis = "optimal"
terms = "auto"
[[preset]]
name = "baked"
mode = "baked"
bake_error = 1.0
bake_mib = 128
[[preset]]
name = "orders"
mode = "orders"
lights = ["direction"]
"#;

fn plan(grating: &str, matter: &str, presets: &str) -> Plan {
    let text = format!(
        "schema = 1\n[[surface]]\nname = \"a\"\ngrating = {grating}\n[optics]\ncoherence_um = 40\n{matter}\n{presets}"
    );
    let baked = |presets: &str| presets.replace(BAKED, "");
    let text = if matter.contains("unpolarised") { baked(&text) } else { text };
    Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{e}"))
}

fn colours(height: &HeightField, variant: &Variant, all: &[Directions]) -> Vec<[f64; 3]> {
    let placement = Placement { height, rotate_deg: 0.0, variant };
    TwinRunner::new(placement, true).unwrap().tristimulus(all).unwrap()
}

/// Every form keeps the error that it promises, or that it has in air at the same optical depth, and the same form without
/// the matter is far off.
#[test]
fn every_form_keeps_its_error_with_other_matter() {
    for (name, grating, keys) in MATTER {
        let plan = plan(grating, keys, FORMS);
        let bare = self::plan(grating, "", FORMS);
        let height = load(&plan.surfaces[0]).unwrap().field;
        // the same optical depth in air, which decides how dim and how many the orders are
        let index = Matter::new(&plan.optics).unwrap().cover_index();
        let deep = height.heights_um().iter().map(|h| index * h).collect();
        let (pitch_x_um, pitch_y_um) = (height.pitch_x_um(), height.pitch_y_um());
        let deep = HeightField::new(height.columns(), height.rows(), pitch_x_um, pitch_y_um, deep)
            .unwrap();
        let mut all = Vec::new();
        for theta in [0.0, 30.0, 60.0, 75.0] {
            let wi = rounded(direction(theta, 10.0));
            let found = on_orders(&height, &plan.optics, 0.0, wi, 800, 7);
            all.extend(found.into_iter().filter(|d| d.wr.z > 75.0_f64.to_radians().cos()));
        }
        let visible = Reference::VISIBLE_NM;
        let exact = Reference::new(&height, 0.0, &plan.optics, visible, all.iter().copied());
        let exact = exact.unwrap().tristimulus_all(&all);
        let plain = Reference::new(&deep, 0.0, &bare.optics, visible, all.iter().copied());
        let plain = plain.unwrap().tristimulus_all(&all);
        for variant in &plan.variants {
            let form = Form::new(variant, &height).unwrap_or_else(|e| panic!("{name}: {e}"));
            let got = colours(&height, variant, &all);
            let found = colour_difference(name, &exact, &got, None).unwrap();
            let allowed = form.promise().tolerance(Part::Model).unwrap().de2000_p95.unwrap();
            println!(
                "{name:32} {:12} p95 {:.3} of {allowed} max {:.2} abs {:.1e} lit {:.2}",
                variant.name, found.de2000.p95, found.de2000.max, found.max_abs, found.lit
            );
            let other = bare.variants.iter().find(|v| v.name == variant.name).unwrap();
            // what the form promises, or what it has in air at the same optical depth
            let usual = colours(&deep, other, &all);
            let usual = colour_difference(name, &plain, &usual, None).unwrap();
            println!("{:45} in air, as deep {:.3} abs {:.1e}", "", usual.de2000.p95, usual.max_abs);
            // a metal is bright at all angles, so that its dim orders, and errors in them, are seen at a higher exposure
            let as_in_air =
                found.max_abs <= 1.5 * usual.max_abs && found.de2000.p95 <= 2.0 * usual.de2000.p95;
            let keeps = found.de2000.p95 <= allowed || as_in_air;
            assert!(keeps, "{name} {}: {}", variant.name, found.de2000.p95);
            let got = colours(&height, other, &all);
            let without = colour_difference(name, &exact, &got, None).unwrap().de2000.p95;
            let far = f64::max(5.0, 2.0 * allowed);
            assert!(without > far, "{name} {}: {without} without", variant.name);
        }
    }
}

/// The closed forms of lights with a size, too.
#[test]
fn lights_with_a_size_keep_their_error_with_other_matter() {
    let preset = "[[preset]]\nname = \"sun\"\nmode = \"orders\"\ncoherence = \"ensemble\"\nsource_diameter_deg = 0.53\n";
    for (name, grating, keys) in MATTER {
        let plan = plan(grating, keys, preset);
        let bare = self::plan(grating, "", preset);
        let height = load(&plan.surfaces[0]).unwrap().field;
        for (theta, radius_deg, allowed) in
            [(20.0, 0.265, 0.3), (50.0, 5.0, 0.7), (30.0, 20.0, 2.5)]
        {
            let cap = Cap { axis: direction(theta, 30.0), radius_rad: f64::to_radians(radius_deg) };
            let light = Light::Disc { cap, irradiance: 1.0 };
            let lights = Lights { all: vec![light.clone()], notes: Vec::new() };
            let optics = &plan.variants[0].optics;
            let views = under_lights(&height, optics, 0.0, &lights, 1);
            let step = views.len() / 150;
            let views: Vec<_> = views.into_iter().step_by(step).take(150).map(rounded).collect();
            let by = |plan: &Plan| {
                let variant = &plan.variants[0];
                let placement = Placement { height: &height, rotate_deg: 0.0, variant };
                TwinRunner::new(placement, true).unwrap().under(&light, &views, &|_| ()).unwrap()
            };
            let variant = &plan.variants[0];
            let exact = Exact(Placement { height: &height, rotate_deg: 0.0, variant });
            let exact = exact.under(&light, &views, &|_| ()).unwrap();
            let found = colour_difference(name, &exact, &by(&plan), None).unwrap();
            println!(
                "{name:32} radius {radius_deg:5} p95 {:.3} max {:.2} lit {:.2}",
                found.de2000.p95, found.de2000.max, found.lit
            );
            assert!(found.lit > 0.2, "{name} {radius_deg}: {}", found.lit);
            assert!(found.de2000.p95 <= allowed, "{name} {radius_deg}: {}", found.de2000.p95);
            let without = colour_difference(name, &exact, &by(&bare), None).unwrap().de2000.p95;
            assert!(without > 5.0, "{name} {radius_deg}: {without} without");
        }
    }
}

/// At the peaks of orders, `pq` has the closed form with the phase inside the cover.
#[test]
fn pq_has_the_phase_inside_the_cover() {
    let preset = "[[preset]]\nname = \"pq\"\nmode = \"pq\"\nbasis = \"optimal\"\nterms = \"auto\"\nperiods = [200, 200]\nwindow_radius = 8\n";
    let plan = plan(WAVES, "material = \"gold\"\ncover_index = \"polycarbonate\"", preset);
    let height = load(&plan.surfaces[0]).unwrap().field;
    let variant = &plan.variants[0];
    let matter = Matter::new(&variant.optics).unwrap();
    let placement = Placement { height: &height, rotate_deg: 0.0, variant };
    let twin = TwinRunner::new(placement, true).unwrap();
    for (theta, order, lambda_nm) in
        [(20.0, 1, 480.0), (55.0, -1, 520.0), (70.0, -2, 450.0), (0.0, -1, 650.0)]
    {
        let wi = direction(theta, 0.0);
        let x = -wi.x - f64::from(order) * lambda_nm * 1e-3 / 1.3;
        let wr = DVec3::new(x, 0.0, (1.0 - x * x).sqrt());
        let got = twin.response(&[Directions { wi, wr }], lambda_nm).unwrap()[0];
        let efficiency = |w: f64| {
            let phase = TAU / (lambda_nm * 1e-3) * w * 0.1;
            libm::jn(order, phase).powi(2)
        };
        let want = efficiency(matter.depth(wi, wr, lambda_nm));
        assert!((got - want).abs() < 4e-3, "{theta} {order}: {got} {want}");
        let in_air = efficiency(-(wi.z + wr.z));
        assert!((got - in_air).abs() > 0.015, "{theta} {order}: {got} in air {in_air}");
    }
}
