//! Bodies under lights with a size: the driver's picture against the same scene in f64, and lights that are refused.

use std::f64::consts::{FRAC_1_PI, PI};

use diffraction_harness::drivers::gpu::Gpu;
use diffraction_harness::drivers::{ColourMap, Prepared};
use diffraction_harness::scene::drawing::{Drawing, Lobes, Look, Truth, truth_under};
use diffraction_harness::scene::lights::facing;
use diffraction_harness::scene::{Mesh, Orbit, sphere};
use diffraction_shaders::light::{Cap, Light, Polygon};
use diffraction_shaders::plan::{
    Coherence, CoherenceScaling, Grating, LightFunction, Mode, Optics, Variant,
};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::variant::mesh::OrientationMap;
use glam::DVec3;

use crate::scene::{gpu, hard_sphere};

const SIZE: [u32; 2] = [160, 120];

/// 95th percentiles: differences of directions; colours against the scene in f64, and for the driver's own directions; a white body
/// relative to its maximum.
const DIRECTION: f64 = 2e-4;
const COLOUR: f64 = 0.15;
const SHADING: f64 = 0.05;
const BODY: f64 = 1e-3;

pub fn crossed() -> HeightField {
    let wave = |period_um| Box::new(Grating::Sinusoidal { period_um, height_um: 0.15, pixels: 32 });
    synthesise(&Grating::Crossed { x: wave(2.0), y: wave(1.5) }, "crossed").unwrap().field
}

pub fn orders() -> Variant {
    let mut variant = Variant::texts(&Optics::standard());
    variant.name = "orders".into();
    variant.mode = Mode::Orders;
    variant.optics.coherence = Coherence::Ensemble;
    variant.optics.coherence_scaling = CoherenceScaling::Wavelength;
    variant
}

fn disc(direction: DVec3, diameter_deg: f64) -> Light {
    let cap = Cap { axis: direction.normalize(), radius_rad: (0.5 * diameter_deg).to_radians() };
    Light::Disc { cap, irradiance: 1.0 }
}

/// A polygon with corners on a circle about a direction.
fn window(direction: DVec3, radius: f64, corners: usize) -> Light {
    let axis = direction.normalize();
    let (right, up) = axis.any_orthonormal_pair();
    let corner = |i: usize| {
        let (sin, cos) = (2.0 * PI * i as f64 / corners as f64).sin_cos();
        (axis + radius * (cos * right + sin * up)).normalize()
    };
    let polygon = Polygon::new(&(0..corners).map(corner).collect::<Vec<_>>()).unwrap();
    Light::Polygon { polygon, radiance: 2.0 }
}

fn judged(gpu: &Gpu, prepared: &Prepared<'_>, lights: [&[Light]; 2]) -> Truth {
    let mesh = hard_sphere();
    let orbit = Orbit { azimuth_deg: 20.0, elevation_deg: 15.0, ..Orbit::around(&mesh, 4.0 / 3.0) };
    let params = orbit.params(&mesh, SIZE, DVec3::new(-0.4, 0.3, 0.85)).unwrap();
    truth_under(gpu, prepared, &mesh, &params, lights, SIZE).unwrap()
}

fn agrees(found: &Truth) -> bool {
    found.direction < DIRECTION
        && found.scene.de2000.p95 < COLOUR
        && found.shading.de2000.p95 < SHADING
        && found.body.unwrap() < BODY
}

/// Every kind of light, from in front, and across the horizon of many pixels; on a surface that is turned.
#[test]
fn pictures_under_lights_are_the_scene_in_f64_and_wrong_ones_are_caught() {
    let Some(gpu) = gpu() else { return };
    let (height, variant) = (crossed(), orders());
    let mut prepared =
        Prepared::new(Placement { height: &height, rotate_deg: 20.0, variant: &variant }).unwrap();
    let front = DVec3::new(-0.4, 0.3, 0.85);
    let side = DVec3::new(0.9, 0.2, -0.3);
    let [amber, blue] = [[1.0, 0.3, 0.05], [0.0, 0.2, 1.0]].map(DVec3::from);
    let cases: [(&str, Vec<Light>, Vec<Light>); 6] = [
        ("sun", vec![disc(front, 0.53)], vec![disc(front, 0.8)]),
        ("bulb", vec![disc(side, 20.0)], vec![disc(side, 30.0)]),
        ("triangle", vec![window(front, 0.2, 3)], vec![window(front, 0.3, 3)]),
        // in three parts, the last of them a triangle
        ("seven corners", vec![window(side, 0.6, 7)], vec![window(side, 0.9, 7)]),
        (
            "colours",
            vec![disc(front, 5.0).coloured(amber), window(side, 0.6, 7).coloured(blue)],
            vec![disc(front, 5.0).coloured(blue), window(side, 0.6, 7).coloured(amber)],
        ),
        (
            "all",
            vec![
                window(side, 0.4, 4),
                disc(front, 2.0),
                Light::Direction { direction: DVec3::Y, irradiance: 1.0 },
                disc(-front, 5.0),
                window(DVec3::NEG_Y, 0.3, 8),
            ],
            // the second disc is where the first one is
            vec![
                window(side, 0.4, 4),
                disc(front, 2.0),
                Light::Direction { direction: DVec3::Y, irradiance: 1.0 },
                disc(front, 5.0),
                window(DVec3::NEG_Y, 0.3, 8),
            ],
        ),
    ];
    for (name, lights, wrong) in &cases {
        let found = judged(&gpu, &prepared, [lights, lights]);
        println!("{name}: {found:?}");
        assert!(agrees(&found), "{name}: {found:?}");
        assert!(found.scene.lit * found.pixels as f64 > 60.0, "{name}: {found:?}");
        let found = judged(&gpu, &prepared, [lights, wrong]);
        println!("{name}, wrong: {:?}", found.scene.de2000);
        assert!(found.scene.de2000.p95 > 5.0 * COLOUR, "{name}: {found:?}");
    }
    let right = prepared.sources.0["mesh"].clone();
    let (from, to) = ("cross(upright, straight)", "cross(straight, upright)");
    assert!(right.contains(from));
    prepared.sources.0.insert("mesh".into(), right.replace(from, to));
    for (name, lights, _) in &cases {
        let found = judged(&gpu, &prepared, [lights, lights]);
        println!("{name}, flipped: {:?}", found.scene.de2000);
        assert!(found.direction > 100.0 * DIRECTION, "{name}: {found:?}");
        assert!(found.scene.de2000.p95 > 5.0 * COLOUR, "{name}: {found:?}");
    }
}

/// A white body that faces a light of irradiance 1 shows 1/π, less what the surface reflects, whatever the kind of light.
#[test]
fn units_are_those_of_the_file() {
    let Some(gpu) = gpu() else { return };
    let (height, variant) = (crossed(), orders());
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let mesh = Mesh { colour: ColourMap::plain([255; 3]), ..sphere(96) };
    let prepared = Prepared::new(placement).unwrap();
    let drawing = Drawing::new(&gpu, &prepared, mesh.clone(), Lobes::Points, None).unwrap();
    let softbox = window(DVec3::Z, 0.5, 4);
    let facing = facing(&softbox);
    let lights = [
        (Light::Direction { direction: DVec3::Z, irradiance: 1.0 }, FRAC_1_PI),
        (disc(DVec3::Z, 0.53), FRAC_1_PI),
        (disc(DVec3::Z, 30.0), FRAC_1_PI),
        (softbox, facing),
    ];
    // far from the mirror image of the light
    let orbit = Orbit { azimuth_deg: 75.0, ..Orbit::around(&mesh, 1.0) };
    let params = orbit.params(&mesh, [90, 90], DVec3::Z).unwrap();
    for (light, white) in lights {
        let black = Look { texture_weight: 1.0, unlit: 0.0, ..Look::lit_by(vec![light.clone()]) };
        let unlit = drawing.draw(&params, &black, [90, 90]).unwrap();
        assert!(unlit.pixels.iter().all(|p| p[..3] == [0.0; 3]), "{light:?}");
        let lit = drawing.draw(&params, &Look::lit_by(vec![light.clone()]), [90, 90]).unwrap();
        // the darkest channel is that of the body: orders are coloured
        let least = |p: &[f32; 4]| f64::from(p[0].min(p[1]).min(p[2]));
        let mut shown: Vec<f64> = lit.pixels.iter().filter(|p| p[3] == 1.0).map(least).collect();
        shown.sort_by(f64::total_cmp);
        // the part that nearly faces the light, without what glitters
        let bright = shown[shown.len() * 97 / 100];
        println!("{}: {bright:.3} of {white:.3}", light.kind());
        assert!(bright > 0.75 * white && bright < white, "{light:?}: {bright} of {white}");
    }
}

#[test]
fn what_a_picture_cannot_show_is_refused() {
    let Some(gpu) = gpu() else { return };
    let height = crossed();
    let refused = |variant: &Variant, lights: Vec<Light>| {
        let placement = Placement { height: &height, rotate_deg: 0.0, variant };
        let mesh = sphere(12);
        let prepared = Prepared::new(placement).unwrap();
        let drawing = Drawing::new(&gpu, &prepared, mesh.clone(), Lobes::Points, None).unwrap();
        let params = Orbit::around(&mesh, 1.0).params(&mesh, [8, 8], DVec3::Z).unwrap();
        drawing.draw(&params, &Look::lit_by(lights), [8, 8]).unwrap_err().to_string()
    };
    let all = orders();
    let few = Variant { lights: vec![LightFunction::Direction], ..orders() };
    let sun = disc(DVec3::Z, 0.53);
    for (found, expected) in [
        (refused(&all, vec![]), "has no light"),
        (refused(&all, vec![sun.clone(); 5]), "has 5 lights of kind \"disc\""),
        (refused(&few, vec![Light::Sky { radiance: 1.0 }]), "a light of kind \"sky\""),
        (refused(&all, vec![Light::Sky { radiance: 1.0 }]), "prepared without the skies"),
        (refused(&few, vec![sun]), "no function for a light of kind \"disc\""),
        (refused(&few, vec![window(DVec3::Z, 0.1, 3)]), "of kind \"polygon\""),
    ] {
        assert!(found.contains(expected), "{found}");
    }
}

/// A map with an angle, a period, a depth and a mask of its own in each quarter: what the driver draws is the scene in f64. A map that is
/// not read, or whose periods are forgotten, is caught.
#[test]
fn patterns_of_a_map_are_drawn_where_they_are() {
    let Some(gpu) = gpu() else { return };
    let height = crossed();
    let variant =
        Variant { pattern: true, period_ratio: [0.7, 1.4], depth_ratio: [0.5, 1.5], ..orders() };
    let mut prepared =
        Prepared::new(Placement { height: &height, rotate_deg: 20.0, variant: &variant }).unwrap();
    let map = OrientationMap {
        width: 2,
        height: 2,
        angles: vec![0.3, 1.5, -0.8, 2.9],
        ratios: vec![[0.7, 1.5, 1.0], [1.4, 0.5, 0.6], [1.0, 1.0, 1.0], [1.2, 1.2, 0.3]],
    };
    let mesh = Mesh { orientation: map, ..hard_sphere() };
    let orbit = Orbit { azimuth_deg: 20.0, elevation_deg: 15.0, ..Orbit::around(&mesh, 4.0 / 3.0) };
    let front = DVec3::new(-0.4, 0.3, 0.85);
    let params = orbit.params(&mesh, SIZE, front).unwrap();
    let lights = [disc(front, 8.0), window(front, 0.3, 4)];
    let judge = |prepared: &Prepared<'_>| {
        truth_under(&gpu, prepared, &mesh, &params, [&lights, &lights], SIZE).unwrap()
    };
    let found = judge(&prepared);
    println!("{found:?}");
    assert!(agrees(&found), "{found:?}");
    let right = prepared.sources.clone();
    for (name, from, to) in [
        ("mesh", "0).yzw", "0).zyw"),
        ("mesh", "most > 1.02 * least", "most > 9.0 * least"),
        ("arrivals", "(pattern.z * vec2f", "(1.0 * vec2f"),
        ("efficiencies", "PHASE_MIN_UM * pattern.w", "PHASE_MIN_UM * 1.0"),
    ] {
        let template = prepared.sources.0.get_mut(name).unwrap();
        assert!(template.contains(from), "{from}");
        *template = template.replace(from, to);
        let found = judge(&prepared);
        println!("{to}: {:?}", found.scene.de2000);
        assert!(!agrees(&found), "{to}: {found:?}");
        prepared.sources = right.clone();
    }
}
