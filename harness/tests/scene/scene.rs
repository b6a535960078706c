//! The headless scene on a driver: the entry `mesh` against the same scene in f64, and pictures of what is wrong with a mesh.

use crate::support::tools;
use diffraction_harness::drivers::ColourMap;
use diffraction_harness::drivers::Prepared;
use diffraction_harness::drivers::gpu::{Backend, Gpu};
use diffraction_harness::scene::drawing::{
    Drawing, Hdr, Lobes, Look, Truth, relative_radiance, truth,
};
use diffraction_harness::scene::flicker::{STEPS, flicker, light, moved, within_pixel};
use diffraction_harness::scene::tone_map::{display, exr, stacked};
use diffraction_harness::scene::{Mesh, Orbit, Snake, snake, sphere, torus_knot};
use diffraction_shaders::encode::animation;
use diffraction_shaders::light::{Cap, Light};
use diffraction_shaders::plan::{
    Auto, Basis, Coherence, CoherenceScaling, Grating, Mode, Optics, Packing, Variant,
};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::variant::mesh::{OrientationMap, Vertex};
use exr::prelude::{ReadChannels, ReadLayers};
use glam::{DMat4, DVec3, DVec4};

const SIZE: [u32; 2] = [160, 120];
const LIGHT: DVec3 = DVec3::new(-0.4, 0.3, 0.85);

/// Difference of directions, 95th percentile: drivers move corners to a grid of 1/256 pixel, and a pixel's direction is some
/// sixtieth.
const DIRECTION: f64 = 2e-4;
/// 95th percentile of colour differences against the scene in f64.
const COLOUR: f64 = 0.1;

pub fn gpu() -> Option<Gpu> {
    tools::found(Gpu::open(Backend::Vulkan, None))
}

fn height() -> HeightField {
    let blazed = Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 50 };
    synthesise(&blazed, "blazed").unwrap().field
}

fn variant(coherence: Coherence) -> Variant {
    let mut variant = Variant::texts(&Optics::standard());
    variant.name = "ensemble".into();
    variant.mode = Mode::Adaptive;
    variant.basis = Basis::Optimal;
    variant.terms = Auto::Value(6);
    variant.packing = Packing::Paired;
    variant.hoist = true;
    variant.optics.coherence = coherence;
    // a short coherence length: broad lobes light more of the sphere
    variant.optics.coherence_um = 20.0;
    variant
}

/// With the function of wider lobes. 65 µm is about the sun's width.
fn soft(coherence_um: f64) -> Variant {
    let mut variant = variant(Coherence::Ensemble);
    variant.name = "soft".into();
    variant.mode = Mode::Baked;
    variant.spread_levels = Auto::Auto;
    variant.optics.coherence_scaling = CoherenceScaling::Wavelength;
    variant.optics.coherence_um = coherence_um;
    variant
}

fn judged(gpu: &Gpu, prepared: &Prepared<'_>, mesh: &Mesh) -> Truth {
    let orbit = Orbit { azimuth_deg: 20.0, elevation_deg: 15.0, ..Orbit::around(mesh, 4.0 / 3.0) };
    let params = orbit.params(mesh, SIZE, LIGHT).unwrap();
    truth(gpu, prepared, mesh, &params, SIZE).unwrap()
}

/// A sphere with everything that a frame can have: both kinds of orientation, mirrored texture coordinates on a half, an
/// uneven and mirroring model matrix.
pub fn hard_sphere() -> Mesh {
    let mut mesh = sphere(48);
    for vertex in &mut mesh.vertices {
        vertex.orientation_angle = 0.4 * vertex.position.y;
    }
    let angles = (0..16).map(|i| 0.2 * i as f32).collect();
    mesh.orientation = OrientationMap { width: 4, height: 4, angles, ratios: Vec::new() };
    let mirror = DMat4::from_scale(DVec3::new(-1.3, 0.8, 1.0));
    mesh.model = DMat4::from_rotation_x(0.3) * mirror;
    mesh.vertices.iter_mut().for_each(|v| v.tangent.w = -1.0);
    mesh
}

#[test]
fn the_picture_is_the_scene_in_f64_and_a_flipped_bitangent_is_caught() {
    let Some(gpu) = gpu() else { return };
    let (height, variant) = (height(), variant(Coherence::Ensemble));
    let mut prepared =
        Prepared::new(Placement { height: &height, rotate_deg: 20.0, variant: &variant }).unwrap();
    let mesh = hard_sphere();
    let found = judged(&gpu, &prepared, &mesh);
    println!("{found:?}");
    assert!(found.facing > 2000 && found.edges * 20 < found.pixels, "{found:?}");
    assert!(found.direction < DIRECTION, "{found:?}");
    assert!(found.scene.de2000.p95 < COLOUR && found.scene.lit > 0.005, "{found:?}");
    assert!(found.shading.de2000.p95 < COLOUR, "{found:?}");
    let faults = [
        ("cross(upright, straight)", "cross(straight, upright)"),
        // no normal matrix
        ("sign(model_volume()) * cofactors", "(mesh_params.model * vec4f(normal, 0.0)).xyz"),
        // no orientation map
        ("let turn = orientation(uv);", "let turn = vec2f(1.0, 0.0 * orientation(uv).y);"),
        // no orientation of the vertices
        ("cos(orientation_angle) * flat_tangent + sin(orientation_angle) * across", "flat_tangent"),
        // the mirror of the model matrix is forgotten
        ("tangent.w * model_volume() < 0.0", "tangent.w < 0.0"),
    ];
    let right = prepared.sources.0["mesh"].clone();
    for (from, to) in faults {
        assert!(right.contains(from), "{from}");
        prepared.sources.0.insert("mesh".into(), right.replace(from, to));
        let found = judged(&gpu, &prepared, &mesh);
        assert!(found.direction > 100.0 * DIRECTION, "{from}: {found:?}");
        assert!(found.scene.de2000.p95 > 10.0 * COLOUR, "{from}: {found:?}");
    }
}

/// The entry `mesh` widens lobes by the footprint of pixels; by another it fails.
#[test]
fn the_footprint_is_that_of_the_scene_in_f64() {
    let Some(gpu) = gpu() else { return };
    let (height, variant) = (height(), soft(65.0));
    let mut prepared =
        Prepared::new(Placement { height: &height, rotate_deg: 20.0, variant: &variant }).unwrap();
    let mesh = hard_sphere();
    let found = judged(&gpu, &prepared, &mesh);
    println!("{found:?}");
    assert!(found.scene.de2000.p95 < COLOUR && found.scene.lit > 0.005, "{found:?}");
    assert!(found.shading.de2000.p95 < COLOUR, "{found:?}");
    let right = prepared.sources.0["mesh"].clone();
    for (from, to) in [
        ("footprint_spread(dpdx(path), dpdy(path), ", "footprint_spread(dpdx(path), dpdx(path), "),
        ("footprint_spread(dpdx(path), dpdy(path), ", "footprint_spread(vec2f(0.0), vec2f(0.0), "),
    ] {
        assert!(right.contains(from), "{from}");
        prepared.sources.0.insert("mesh".into(), right.replace(from, to));
        let found = judged(&gpu, &prepared, &mesh);
        println!("{to}: {found:?}");
        assert!(found.scene.de2000.p95 > 10.0 * COLOUR, "{to}: {found:?}");
    }
}

/// A single direction under which a white diffuser that faces it has the radiance 1.
fn star(direction: DVec3) -> Light {
    Light::Direction { direction: direction.normalize(), irradiance: std::f64::consts::PI }
}

fn picture(gpu: &Gpu, mesh: &Mesh, light: DVec3, orbit: Orbit) -> Hdr {
    let (height, variant) = (height(), variant(Coherence::Ensemble));
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let prepared = Prepared::new(placement).unwrap();
    let drawing = Drawing::new(gpu, &prepared, mesh.clone(), Lobes::Points, None).unwrap();
    let look = Look::lit_by(vec![star(light)]);
    let params = orbit.params(mesh, SIZE, light).unwrap();
    drawing.draw(&params, &look, SIZE).unwrap()
}

fn sum(picture: &Hdr) -> f64 {
    picture.pixels.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum()
}

#[test]
fn light_orientation_and_dark_sides_show() {
    let Some(gpu) = gpu() else { return };
    let mesh = snake(&Snake { rings: 240, sides: 48, ..Snake::standard() });
    let orbit = Orbit::around(&mesh, 4.0 / 3.0);
    let front = picture(&gpu, &mesh, LIGHT, orbit);
    assert!(front.pixels.iter().flatten().all(|c| c.is_finite()));
    let covered = front.pixels.iter().filter(|p| p[3] > 0.0).count();
    assert!(covered > 1000, "{covered}");
    let moved = picture(&gpu, &mesh, DVec3::new(0.5, 0.2, 0.85), orbit);
    let mut turned = mesh.clone();
    turned.vertices.iter_mut().for_each(|v| v.orientation_angle += 1.0);
    let turned = picture(&gpu, &turned, LIGHT, orbit);
    for other in [&moved, &turned] {
        let pairs = front.pixels.iter().zip(&other.pixels);
        let changed = pairs.filter(|(a, b)| (a[1] - b[1]).abs() > 0.05).count();
        println!("{changed} of {covered} pixels changed");
        assert!(changed * 100 > covered, "{changed} of {covered}");
    }
    // from behind only rims can catch light, and they do, as mirrors at grazing angles
    let behind = picture(&gpu, &mesh, -DVec3::Z, orbit);
    let lit = |hdr: &Hdr| hdr.pixels.iter().filter(|p| p[..3].iter().any(|c| *c > 1e-3)).count();
    println!("{} of {} pixels lit from behind", lit(&behind), lit(&front));
    assert!(lit(&behind) * 10 < lit(&front), "{} {}", lit(&behind), lit(&front));
}

/// Far away a pixel sees many lobes. A single point finds one of them or none, so that the picture's light depends on where
/// pixels happen to lie; widened lobes keep the light and hardly depend on that.
#[test]
fn widened_lobes_keep_the_light() {
    let Some(gpu) = gpu() else { return };
    let mut mesh = sphere(64);
    mesh.colour = ColourMap::plain([0; 3]);
    let size = [40, 30];
    let (height, variant) = (height(), soft(20.0));
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let prepared = Prepared::new(placement).unwrap();
    let look = Look::lit_by(vec![star(LIGHT)]);
    // the picture's light for a camera that moves by shares of a pixel: mean and standard deviation
    let light = |drawing: &Drawing<'_>, zoom: f64, steps: u32, factor: u32| {
        let orbit = Orbit { zoom, ..Orbit::around(&mesh, 4.0 / 3.0) };
        let slope = (0.5 * orbit.view_deg.to_radians()).tan();
        let pixel = 2.0 * slope * orbit.distance / zoom / f64::from(size[1]);
        let sums: Vec<f64> = (0..steps * steps)
            .map(|i| {
                let shift = DVec3::new(f64::from(i % steps), f64::from(i / steps), 0.0);
                let target = orbit.target + pixel / f64::from(steps * factor) * shift;
                let size = size.map(|side| side * factor);
                let params = Orbit { target, ..orbit }.params(&mesh, size, LIGHT).unwrap();
                let picture = drawing.draw(&params, &look, size).unwrap();
                sum(&picture) / f64::from(factor * factor)
            })
            .collect();
        let mean = sums.iter().sum::<f64>() / sums.len() as f64;
        let variance = sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / sums.len() as f64;
        [mean, variance.sqrt()]
    };
    let [points, widened] = [Lobes::Points, Lobes::Footprint]
        .map(|lobes| Drawing::new(&gpu, &prepared, mesh.clone(), lobes, None).unwrap());
    // the sphere is 18 pixels wide; below that footprints are wider than the widest table
    let zoom = 0.63;
    let [exact, _] = light(&points, zoom, 2, 16);
    let [mean, spread] = light(&widened, zoom, 4, 1).map(|v| v / exact);
    let [bare, sparkle] = light(&points, zoom, 4, 1).map(|v| v / exact);
    println!("widened {mean:.3} ± {spread:.3}, points {bare:.3} ± {sparkle:.3}");
    // either sparkle, or darkness where every lobe is missed
    let (error, without) = ((mean - 1.0).hypot(spread), (bare - 1.0).hypot(sparkle));
    assert!((mean - 1.0).abs() < 0.04 && error < 0.2 && without > 4.0 * error, "{error} {without}");
}

/// An EXR file holds the linear numbers, an animated PNG all its frames in order.
#[test]
fn files_hold_what_was_drawn() {
    let pixels = [[-0.25, 0.5, 6.0, 1.0], [0.125, 40.0, 1e-3, 0.5]];
    let bytes = exr(2, 1, &pixels).unwrap();
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |_, _| Vec::new(),
            |all: &mut Vec<[f32; 4]>, _, (r, g, b, a)| {
                all.push([r, g, b, a]);
            },
        )
        .all_layers()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes));
    assert_eq!(read.unwrap().layer_data[0].channel_data.pixels, pixels);
    let shown = |exposure| display(2, 1, &pixels, exposure);
    let frames = [shown(0.1), shown(0.2), shown(0.4)];
    let bytes = animation(&frames, 80).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().animation_control.map(|a| a.num_frames), Some(3));
    for frame in &frames {
        let mut texels = [0; 6];
        reader.next_frame(&mut texels).unwrap();
        let expected: Vec<u8> = frame.texels.iter().flat_map(|t| t[..3].to_vec()).collect();
        assert_eq!(texels[..], expected);
    }
    let rows = stacked(&[frames[0].clone(), frames[1].clone()], 3);
    assert_eq!((rows.width, rows.height, rows.texels.len()), (2, 5, 10));
    assert_eq!(rows.texels[8..], frames[1].texels);
}

#[test]
fn frames_that_do_not_exist_are_black_and_pictures_of_no_size_are_errors() {
    let Some(gpu) = gpu() else { return };
    let (height, variant) = (height(), variant(Coherence::Ensemble));
    let prepared =
        Prepared::new(Placement { height: &height, rotate_deg: 0.0, variant: &variant }).unwrap();
    let mesh = sphere(24);
    let orbit = Orbit::around(&mesh, 4.0 / 3.0);
    let params = orbit.params(&mesh, SIZE, LIGHT).unwrap();
    let faults: [fn(&mut Vertex); 4] = [
        |v| v.tangent = DVec4::ZERO,
        |v| v.normal = DVec3::NAN,
        |v| v.tangent = v.normal.extend(1.0),
        |v| v.normal = DVec3::ZERO,
    ];
    for fault in faults {
        let mut mesh = mesh.clone();
        mesh.vertices.iter_mut().for_each(fault);
        let pixels = relative_radiance(&gpu, &prepared, &mesh, &params, SIZE).unwrap();
        assert!(pixels.iter().filter(|p| p[3] > 0.0).count() > 1000);
        assert!(pixels.iter().all(|p| p[..3] == [0.0; 3]));
    }
    let pixels = relative_radiance(&gpu, &prepared, &mesh, &params, SIZE).unwrap();
    assert!(pixels.iter().any(|p| p[1] > 1e-6) && pixels.iter().flatten().all(|c| c.is_finite()));
    let error = orbit.params(&mesh, [0, 0], LIGHT).unwrap_err();
    assert_eq!(error.to_string(), "camera: a picture of 0 × 0 pixels is empty");
    let error = relative_radiance(&gpu, &prepared, &mesh, &params, [0, 5]).unwrap_err();
    assert!(error.to_string().contains("0 × 5 pixels"), "{error}");
}

/// From inside every normal points away.
#[test]
fn inside_of_a_mesh_all_is_black() {
    let Some(gpu) = gpu() else { return };
    let mesh = sphere(24);
    let around = Orbit::around(&mesh, 4.0 / 3.0);
    let inside = Orbit { distance: 0.5, ..around };
    assert!(mesh.holds(inside.eye()) && !mesh.holds(around.eye()));
    let picture = picture(&gpu, &mesh, LIGHT, inside);
    assert!(picture.pixels.iter().all(|p| p[..3] == [0.0; 3] && p[3] == 1.0));
}

#[test]
fn amplitudes_have_no_wider_lobe() {
    let Some(gpu) = gpu() else { return };
    let (height, variant) = (height(), variant(Coherence::Single));
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let prepared = Prepared::new(placement).unwrap();
    let drawing = Drawing::new(&gpu, &prepared, sphere(12), Lobes::Footprint, None);
    let error = drawing.err().unwrap().to_string();
    assert!(error.contains("spread_levels = \"auto\""), "{error}");
}

/// While the camera moves by thirds of a pixel, points sparkle on a torus knot under a single direction and on a sphere under the sun; widened lobes and a lobe of GGX do not. Widened lobes have the light of all points of a pixel.
#[test]
fn widened_lobes_are_calm() {
    let Some(gpu) = gpu() else { return };
    let size = [480, 270];
    let (height, variant) = (height(), soft(65.0));
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let prepared = Prepared::new(placement).unwrap();
    let cap = Cap { axis: LIGHT.normalize(), radius_rad: 0.265_f64.to_radians() };
    let sun = Light::Disc { cap, irradiance: std::f64::consts::PI };
    for (mut mesh, lamp) in [(torus_knot(256, 64), star(LIGHT)), (sphere(96), sun)] {
        mesh.colour = ColourMap::plain([0; 3]);
        let orbit = Orbit::around(&mesh, 16.0 / 9.0);
        let look = Look::lit_by(vec![lamp]);
        let [points, widened, ggx] = [Lobes::Points, Lobes::Footprint, Lobes::Ggx].map(|lobes| {
            let drawing = Drawing::new(&gpu, &prepared, mesh.clone(), lobes, None).unwrap();
            let params = |pixels: f64| {
                let orbit = moved(orbit, &mesh, size, pixels).unwrap();
                orbit.params(&mesh, size, LIGHT).unwrap()
            };
            let frames = STEPS.map(|step| drawing.draw(&params(step), &look, size).unwrap());
            let whole = (0..64).map(|i| {
                let place = [i % 8, i / 8].map(|i| (f64::from(i) + 0.5) / 8.0 - 0.5);
                light(&drawing.draw(&within_pixel(&params(0.0), size, place), &look, size).unwrap())
            });
            let whole = if lobes == Lobes::Points { whole.sum::<f64>() / 64.0 } else { 0.0 };
            let mean = frames.iter().map(light).sum::<f64>() / 3.0;
            (frames, mean, whole)
        });
        // three stops above what pictures have, so that all that is lit is bright
        let exposure = 4.0;
        let found = [&points, &widened].map(|(frames, ..)| flicker(frames, exposure));
        let bright = flicker(&ggx.0, exposure * points.2 / ggx.1);
        let kept = widened.1 / points.2;
        println!("{}: {found:?}, ggx {bright:?}, light {kept:.4}", mesh.name);
        let [bare, calm] = found;
        assert!(bare.bright > 10 && bare.flicker > 0.2, "{bare:?}");
        assert!(calm.bright > 100 && calm.flicker < 0.03, "{calm:?}");
        assert!(bright.flicker < 0.01, "{bright:?}");
        assert!((kept - 1.0).abs() < 0.03, "{kept}");
    }
}
