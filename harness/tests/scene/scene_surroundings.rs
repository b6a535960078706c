//! Bodies under skies and maps: where the background stands, how a body is lit, and what is refused.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use diffraction_harness::drivers::{ColourMap, Prepared};
use diffraction_harness::scene::drawing::{Drawing, Lobes, Look};
use diffraction_harness::scene::surroundings::add_behind;
use diffraction_harness::scene::{Mesh, Orbit, raster, sphere};
use diffraction_shaders::light::{Cap, Environment, Light, Panorama, Studio};
use diffraction_shaders::optics::{Matter, REFERENCE_NM};
use diffraction_shaders::plan::{LightFunction, Variant};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::variant::mesh::MeshParams;
use glam::DVec3;

use crate::scene::gpu;
use crate::scene_lights::{crossed, orders};

const SIZE: [u32; 2] = [96, 64];

fn environment(panorama: Panorama, rotate_deg: f64) -> Environment {
    Environment { panorama: Arc::new(panorama), scale: 1.5, rotate_deg }
}

/// Every pixel has its own colour: red counts rows, green columns.
fn numbered(width: usize) -> Panorama {
    let height = width / 2;
    let texel = |i: usize| [(i / width) as f32, (i % width) as f32, 1.0];
    Panorama { width, height, texels: (0..width * height).map(texel).collect() }
}

fn params(azimuth_deg: f64, elevation_deg: f64) -> MeshParams {
    let mesh = sphere(12);
    let orbit = Orbit { azimuth_deg, elevation_deg, ..Orbit::around(&mesh, 1.5) };
    orbit.params(&mesh, SIZE, DVec3::Y).unwrap()
}

/// The background of a picture without a body.
fn behind(lights: &[Light], params: &MeshParams) -> Vec<[f32; 4]> {
    let mut pixels = vec![[0.0; 4]; (SIZE[0] * SIZE[1]) as usize];
    add_behind(&mut pixels, SIZE[0], lights, params, 1);
    pixels
}

/// The camera on +z looks along -z, which is phi = -90° and theta = 90°; to its right is +x, which is phi = 0°; above is theta = 0°.
#[test]
fn the_background_stands_where_the_manual_says() {
    let (width, height) = (360, 180);
    let light =
        [Light::Environment(Environment { scale: 1.0, ..environment(numbered(width), 0.0) })];
    let place = |pixel: [f32; 4]| {
        let [row, column, one, coverage] = pixel.map(f64::from);
        assert!((one - 1.0).abs() < 1e-6 && coverage == 0.0);
        let theta = (row + 0.5) / height as f64 * 180.0;
        [theta, (column + 0.5) / width as f64 * 360.0 - 180.0]
    };
    let pixel = |pixels: &[[f32; 4]], x: u32, y: u32| place(pixels[(y * SIZE[0] + x) as usize]);
    let front = behind(&light, &params(0.0, 0.0));
    let [theta, phi] = pixel(&front, SIZE[0] / 2, SIZE[1] / 2);
    assert!((theta - 90.0).abs() < 0.5 && (phi + 90.0).abs() < 0.5, "{theta} {phi}");
    // the view is 30° high, and 1.5 times as wide
    let half = 0.5 * (15_f64.to_radians().tan() * 1.5 * 95.0 / 96.0).atan().to_degrees() * 2.0;
    let [_, right] = pixel(&front, SIZE[0] - 1, SIZE[1] / 2);
    assert!((right + 90.0 - half).abs() < 0.5, "{right} {half}");
    let [above, _] = pixel(&front, SIZE[0] / 2, 0);
    assert!((above - 90.0 + 15.0 * 63.0 / 64.0).abs() < 0.5, "{above}");
    // from azimuth 90° the camera is on +x and looks along -x, which is phi = ±180°; from above it looks down
    let [_, phi] = pixel(&behind(&light, &params(90.0, 0.0)), SIZE[0] / 2 - 8, SIZE[1] / 2);
    assert!((170.0..180.0).contains(&phi), "{phi}");
    let [theta, phi] = pixel(&behind(&light, &params(0.0, 60.0)), SIZE[0] / 2, SIZE[1] / 2);
    assert!((theta - 150.0).abs() < 0.5 && (phi + 90.0).abs() < 0.5, "{theta} {phi}");
    // what was at phi = -120° is at -90° when the map is turned by 30°
    let turned =
        [Light::Environment(Environment { scale: 1.0, ..environment(numbered(width), 30.0) })];
    let [_, phi] = pixel(&behind(&turned, &params(0.0, 0.0)), SIZE[0] / 2, SIZE[1] / 2);
    assert!((phi + 120.0).abs() < 0.5, "{phi}");
}

/// What covers a pixel keeps its share, coverage stays, lamps are seen at their place, and lamps alone are no background.
#[test]
fn only_what_a_body_leaves_free_is_filled() {
    let sky = Light::Sky { radiance: 2.0 }.coloured(DVec3::new(0.5, 1.0, 0.25));
    let mut pixels = [[0.3, 0.2, 0.1, 1.0], [0.15, 0.1, 0.05, 0.5], [0.0; 4], [0.0; 4]];
    let view = params(0.0, 0.0);
    add_behind(&mut pixels, 2, std::slice::from_ref(&sky), &view, 2);
    let expected =
        [[0.3, 0.2, 0.1, 1.0], [0.65, 1.1, 0.3, 0.5], [1.0, 2.0, 0.5, 0.0], [1.0, 2.0, 0.5, 0.0]];
    let near = |a: &[f32; 4], b: &[f32; 4]| (0..4).all(|c| (a[c] - b[c]).abs() < 1e-6);
    assert!(pixels.iter().zip(&expected).all(|(a, b)| near(a, b)), "{pixels:?}");
    // a disc of 4° at the middle of the right half
    let axis = DVec3::new(0.2, 0.0, -1.0).normalize();
    let cap = Cap { axis, radius_rad: 2_f64.to_radians() };
    let disc = Light::Disc { cap, irradiance: 1.0 };
    assert!(behind(std::slice::from_ref(&disc), &view).iter().all(|p| *p == [0.0; 4]));
    let both = behind(&[sky, disc], &view);
    let lit: Vec<usize> = (0..both.len()).filter(|i| both[*i][0] > 2.0).collect();
    let middle = lit.iter().map(|i| (i % 96) as f64 + 0.5).sum::<f64>() / lit.len() as f64;
    let expected = 48.0 * (1.0 + 0.2 / (1.5 * 15_f64.to_radians().tan()));
    assert!(lit.len() > 20 && (middle - expected).abs() < 0.5, "{middle} {expected}");
}

/// A white sphere under maps against the integral over all directions; the map turned round and mirrored must fail.
#[test]
fn a_body_is_lit_by_the_whole_map() {
    let Some(gpu) = gpu() else { return };
    let (height, variant) = (crossed(), orders());
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let mesh = Mesh { colour: ColourMap::plain([255; 3]), ..sphere(96) };
    let prepared = Prepared::new(placement).unwrap();
    let drawing = Drawing::new(&gpu, &prepared, mesh.clone(), Lobes::Points, None).unwrap();
    let orbit = Orbit { azimuth_deg: 35.0, elevation_deg: 20.0, ..Orbit::around(&mesh, 1.5) };
    let view = orbit.params(&mesh, SIZE, DVec3::Y).unwrap();
    let seen = raster::visible(&mesh, &view, SIZE).unwrap();
    let matter = Matter::new(&variant.optics).unwrap();
    for (word, studio) in Studio::WORDS {
        let map = environment(studio.panorama(256), 70.0);
        let mut mirrored = studio.panorama(256);
        mirrored.texels.chunks_exact_mut(256).for_each(<[_]>::reverse);
        let lamp = Light::Direction { direction: DVec3::new(0.6, 0.0, 0.8), irradiance: 0.5 };
        let lamp = lamp.coloured(DVec3::new(0.2, 1.0, 0.1));
        let look = |map: Environment| Look {
            diffracts: false,
            ..Look::lit_by(vec![Light::Environment(map), lamp.clone()])
        };
        let drawn = drawing.draw(&view, &look(map.clone()), SIZE).unwrap();
        let turned = Environment { rotate_deg: 250.0, ..map.clone() };
        let turned = drawing.draw(&view, &look(turned), SIZE).unwrap();
        let mirrored = drawing.draw(&view, &look(environment(mirrored, 70.0)), SIZE).unwrap();
        let whole = |i: &usize| drawn.pixels[*i][3] == 1.0 && seen[*i].is_some();
        let mut apart = [Vec::new(), Vec::new(), Vec::new()];
        let mut most = 0.0_f64;
        for i in (0..seen.len()).filter(whole).step_by(17) {
            let at = seen[i].unwrap().at;
            let normal = at.normal.normalize();
            let wr = (view.eye - at.place).normalize();
            let share = |wi: DVec3| {
                1.0 - matter.reflectances(REFERENCE_NM, (wi + wr).normalize().dot(wr))[0]
            };
            let ahead = DVec3::new(0.6, 0.0, 0.8);
            let white = share(normal) * integral(&map, normal) / PI
                + share(ahead) * 0.5 / PI * ahead.dot(normal).max(0.0) * DVec3::new(0.2, 1.0, 0.1);
            most = most.max(white.max_element());
            for (apart, picture) in apart.iter_mut().zip([&drawn, &turned, &mirrored]) {
                let [r, g, b, _] = picture.pixels[i].map(f64::from);
                apart.push((DVec3::new(r, g, b) - white).abs().max_element());
            }
        }
        let p95 = apart.map(|mut all| {
            all.sort_by(f64::total_cmp);
            all[all.len() * 95 / 100] / most
        });
        println!("{word}: {p95:?} of {most:.3}");
        assert!(p95[0] < 5e-3, "{word}: {p95:?}");
        assert!(p95[1] > 0.1 && p95[2] > 0.1, "{word}: {p95:?}");
    }
}

/// Integral of a map in the world over directions, by the cosine to a normal.
fn integral(map: &Environment, normal: DVec3) -> DVec3 {
    let (rows, mut sum) = (200, DVec3::ZERO);
    for row in 0..rows {
        let y = 2.0 * (f64::from(row) + 0.5) / f64::from(rows) - 1.0;
        for column in 0..2 * rows {
            let phi = TAU * (f64::from(column) + 0.5) / f64::from(2 * rows);
            let flat = (1.0 - y * y).sqrt();
            let wi = DVec3::new(flat * phi.cos(), y, flat * phi.sin());
            let radiance = map.panorama.at(y.acos(), phi - map.rotate_deg.to_radians());
            sum += map.scale * radiance * wi.dot(normal).max(0.0);
        }
    }
    sum * TAU / f64::from(rows * rows)
}

#[test]
fn what_a_relief_cannot_diffract_is_refused() {
    let Some(gpu) = gpu() else { return };
    let lights = vec![LightFunction::Direction, LightFunction::Disc];
    let (height, variant) = (crossed(), Variant { lights, ..orders() });
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let mesh = sphere(12);
    let prepared = Prepared::new(placement).unwrap();
    let drawing = Drawing::new(&gpu, &prepared, mesh, Lobes::Points, None).unwrap();
    let map = Light::Environment(environment(Studio::Window.panorama(32), 0.0));
    let sun = Light::Disc { cap: Cap { axis: DVec3::Y, radius_rad: 0.01 }, irradiance: 1.0 };
    let ahead = Light::Direction { direction: DVec3::Y, irradiance: 1.0 };
    let red = ahead.coloured(DVec3::new(1.0, 0.5, 0.2));
    for (light, cause, remedy) in [
        (map, "no function for a light of kind \"environment\"", "--no-diffraction"),
        (
            Light::Sky { radiance: 1.0 },
            "no function for a light of kind \"sky\"",
            "--no-diffraction",
        ),
        (red, "has the colour [1.000, 0.500, 0.200]", "make it a light of kind \"disc\""),
    ] {
        let look = Look::lit_by(vec![sun.clone(), light]);
        let found = drawing.draw(&params(0.0, 0.0), &look, [8, 8]).unwrap_err().to_string();
        assert!(found.contains(cause) && found.contains(remedy), "{found}");
        let alone = Look { diffracts: false, ..look };
        let drawn = drawing.draw(&params(0.0, 0.0), &alone, [8, 8]).unwrap();
        assert!(drawn.pixels.iter().any(|p| p[0] > 0.0));
    }
}
