//! From options to pictures.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use diffraction_cli::Outcome;
use diffraction_cli::console::Console;
use diffraction_cli::files::write_whole;
use diffraction_cli::{memory, progress};
use diffraction_shaders::input;
use diffraction_shaders::light::{Cap, Light, Polygon};
use diffraction_shaders::pattern::{GivenRanges, Ranges};
use diffraction_shaders::plan::{Auto, Coherence, CoherenceScaling, Mode, Plan, Variant};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::surface;
use diffraction_shaders::variant::Form;
use diffraction_shaders::variant::mesh::OrientationMap;
use glam::DVec3;

use super::args::{Args, Sweep};
use super::flicker::measured;
use super::lights::{Lamps, has_disc};
use super::skin::{Skin, orbit};
use crate::drivers::gpu::{Backend, Gpu};
use crate::drivers::{Prepared, check};
use crate::process::watched::{Place, child::enter};
use crate::results::Part;
use crate::scene::drawing::{Drawing, Hdr, Lobes, Truth, check_widened, truth, truth_under};
use crate::scene::lights::middle;
use crate::scene::surroundings::{add_behind, filtered};
use crate::scene::tone_map::{display, exr, reduced, stacked, strip};
use crate::scene::{
    Mesh, Orbit, PRINTED_LIGHTS, PRINTED_ZOOMS, Snake, card, read, snake, sphere, torus_knot,
};
use diffraction_shaders::encode::{Picture, animation};

/// Supersampled pictures are drawn N times as wide and as high.
const SUPER: u32 = 4;
/// In pictures of four samples per pixel the background takes as many: N along each side.
const BEHIND: u32 = 2;
/// Gap between pictures of a strip, in pixels.
const GAP: u32 = 4;
/// How long a turntable shows each picture.
const FRAME_MS: u16 = 80;
/// How far the camera swings, degrees.
const TILT_DEG: f64 = 30.0;
/// Tolerances at the 95th percentile of a driver's picture against the scene in f64: of directions, and of colours
/// (CIEDE2000). A corner that moves by 1/256 pixel turns the directions on scales by 1e-5, which steep lobes show as 0.05.
const TRUTH: (f64, f64) = (1e-4, 0.15);
/// Tolerances under lights as scenes draw them: of colours for the directions that the driver used (CIEDE2000), and of a white body,
/// relative to its maximum; both at the 95th percentile.
const LIT_SHADING: f64 = 0.05;
const BODY: f64 = 1e-3;
/// The negative control of lights with a size: a factor on their width.
const WIDER: f64 = 1.5;
/// Minimum number of lit pixels for a verdict.
const MIN_LIT: usize = 64;
/// The negative control: a frame of the other handedness.
const FLIP: (&str, &str) = ("cross(upright, straight)", "cross(straight, upright)");

pub(super) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let plan: Plan = args.plan.read(console)?;
    let lamps = Lamps::read(args, console)?;
    let mut skins = Vec::new();
    for name in &args.surface {
        let spec = plan.surface(name)?.clone();
        let mut variant = plan.on(&spec).variant(args.variant.as_deref())?;
        let widens = args.filter.widens() || args.sweep == Some(Sweep::Flicker);
        if widens && can_widen(&variant) {
            variant.spread_levels = Auto::Auto;
        }
        let surface = input::load_surface(&spec)?;
        surface.notes.iter().for_each(|note| console.note(note));
        surface.field.check_pitch(&surface::subject(&spec), variant.wavelengths.min_nm)?;
        let form = Form::new(&variant, &surface.field)?;
        if widens {
            check_widened(&variant.name, &form)?;
        }
        lamps.check(&variant, &form, args)?;
        if args.no_diffraction && form.matter().body_share() == Some(0.0) {
            console.note(&format!(
                "{name}: no light passes a metal, so that the body is black without diffraction"
            ));
        }
        skins.push(Skin { spec, surface, variant, has_disc: has_disc(&form) });
    }
    if let (true, Some(skin)) = (lamps.wants_discs(), skins.iter().find(|skin| !skin.has_disc)) {
        console.note(&format!(
            "{} has no function for discs: each --light is a single direction, as wide as the coherence length makes it",
            skin.variant.name
        ));
    }
    let held = skins.iter().map(|skin| skin.surface.field.byte_count()).sum();
    for Skin { spec, surface, variant, .. } in &skins {
        let needed = memory::of(&surface.field, variant)?.to_check_and_draw();
        args.memory.check(&spec.name, &variant.name, held, needed)?;
    }
    let mut mesh = match args.mesh.as_str() {
        "snake" => snake(&Snake::standard()),
        "sphere" => sphere(128),
        "torus-knot" => torus_knot(768, 96),
        "card" => card(),
        file => read(Path::new(file))?,
    };
    mesh.notes.iter().for_each(|note| console.note(note));
    if let Some(path) = &args.pattern_map {
        mesh.orientation = pattern_map(path, &skins, console)?;
    }
    turn(&mut mesh, args.orientation);
    let mut place = Place { route: Backend::Vulkan.name().to_owned(), ..Place::default() };
    enter(place.clone());
    let gpu = Gpu::open(Backend::Vulkan, args.adapter.as_deref())?;
    place.route = format!("{}:{}", gpu.info().backend, gpu.info().name);
    place.surface = Some(args.surface.join(", "));
    place.variant = skins.first().map(|skin| skin.variant.name.clone());
    enter(place);
    if args.truth {
        return judge(args, &gpu, &lamps, &skins, &mesh);
    }
    let mut rows = Vec::new();
    for skin in &skins {
        rows.push(match args.sweep {
            Some(Sweep::Flicker) => measured(args, &gpu, &lamps, skin, &mesh)?,
            _ => sweep(args, &gpu, &lamps, skin, &mesh, console)?,
        });
    }
    if args.sweep.is_none() {
        rows = vec![rows.concat()];
    }
    let Some(out) = &args.out else { return Ok(Outcome::Done) };
    let exposure = args.exposure.unwrap_or_else(|| lamps.exposure());
    let shown = |p: &Hdr| display(p.width, p.height, &p.pixels, exposure);
    let is_exr = out.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    let bytes = match (&rows[0][..], args.sweep) {
        ([one], _) if is_exr => exr(one.width, one.height, &one.pixels)?,
        (_, Some(Sweep::Turntable | Sweep::Recede | Sweep::Tilt)) => {
            animation(&rows.iter().flatten().map(shown).collect::<Vec<Picture>>(), FRAME_MS)?
        }
        _ => {
            let line = |row: &Vec<Hdr>| strip(&row.iter().map(shown).collect::<Vec<_>>(), GAP);
            animation(&[stacked(&rows.iter().map(line).collect::<Vec<_>>(), GAP)], FRAME_MS)?
        }
    };
    write_whole(out, &bytes)?;
    console.note(&format!(
        "{}: {} pictures, exposure {exposure:.4}",
        out.display(),
        rows.iter().map(Vec::len).sum::<usize>(),
    ));
    Ok(Outcome::Done)
}

/// A pattern map for a mesh, within the ranges of all skins.
fn pattern_map(path: &Path, skins: &[Skin], console: &Console) -> Result<OrientationMap> {
    let mut map = input::read_pattern(path, &GivenRanges::default())?;
    for Skin { variant, .. } in skins {
        if !variant.pattern {
            bail!(
                "--pattern-map {}: {} has no patterns; use a variant with mode = \"orders\" and pattern = true",
                path.display(),
                variant.name
            );
        }
        let ranges =
            Ranges { period_ratio: variant.period_ratio, depth_ratio: variant.depth_ratio };
        let clamped = map.clamp(&ranges);
        if clamped > 0 {
            console.note(&format!(
                "{}: {clamped} texels have ratios outside the period_ratio or depth_ratio of {}; the nearest are used",
                path.display(),
                variant.name
            ));
        }
    }
    Ok(OrientationMap {
        width: map.width(),
        height: map.height(),
        angles: map.texels().iter().map(|texel| texel.angle_rad as f32).collect(),
        ratios: map
            .texels()
            .iter()
            .map(|texel| [texel.period_ratio, texel.depth_ratio, texel.mask].map(|x| x as f32))
            .collect(),
    })
}

/// Draws all pictures of one skin.
fn sweep(
    args: &Args,
    gpu: &Gpu,
    lamps: &Lamps,
    skin: &Skin,
    mesh: &Mesh,
    console: &Console,
) -> Result<Vec<Hdr>> {
    let lights = lamps.on(skin.has_disc, None);
    let orbit = orbit(args, mesh);
    let at = |orbit: Orbit, lights: &[Light], turned: f64| (orbit, lights.to_vec(), turned);
    let shots = match args.sweep {
        None | Some(Sweep::Flicker) => vec![at(orbit, &lights, 0.0)],
        // the printed vectors point where the light goes
        Some(Sweep::Lights) => PRINTED_LIGHTS
            .map(|l| at(orbit, &lamps.on(skin.has_disc, Some(&[-DVec3::from(l)])), 0.0))
            .to_vec(),
        Some(Sweep::Zoom) => {
            PRINTED_ZOOMS.map(|zoom| at(Orbit { zoom, ..orbit }, &lights, 0.0)).to_vec()
        }
        Some(Sweep::Orientation) => {
            [0.0, 30.0, 60.0, 90.0].map(|turned| at(orbit, &lights, turned)).to_vec()
        }
        Some(Sweep::Recede) => orbit
            .receding(mesh, args.size.0, args.frames)?
            .into_iter()
            .map(|orbit| at(orbit, &lights, 0.0))
            .collect(),
        Some(Sweep::Tilt) => (0..args.frames)
            .map(|frame| {
                let turn = std::f64::consts::TAU * f64::from(frame) / f64::from(args.frames);
                let azimuth_deg = orbit.azimuth_deg + TILT_DEG * turn.sin();
                at(Orbit { azimuth_deg, ..orbit }, &lights, 0.0)
            })
            .collect(),
        Some(Sweep::Turntable) => (0..args.frames)
            .map(|frame| {
                let turned = 360.0 * f64::from(frame) / f64::from(args.frames);
                let azimuth_deg = orbit.azimuth_deg + turned;
                at(Orbit { azimuth_deg, ..orbit }, &lights, 0.0)
            })
            .collect(),
    };
    let (prepared, variant) = (Prepared::new(skin.placement())?, &skin.variant);
    if !args.unchecked {
        check(&prepared, gpu)?;
    }
    let lobes = if args.filter.widens() { Lobes::Footprint } else { Lobes::Points };
    let around = filtered(&lights);
    let bar = progress::bar(shots.len(), &format!("drawing {}", skin.spec.name));
    let (mut pictures, mut times) = (Vec::new(), Vec::new());
    let mut drawing = None;
    let mut angle = f64::NAN;
    for (orbit, lights, turned) in shots {
        if drawing.is_none() || turned != angle {
            let mut mesh = mesh.clone();
            turn(&mut mesh, turned);
            angle = turned;
            drawing = Some(Drawing::new(gpu, &prepared, mesh, lobes, around.as_ref())?);
        }
        let Some(drawing) = &drawing else { bail!("the sweep has no picture") };
        if mesh.holds(orbit.eye()) {
            console.note("the camera is inside the mesh: it sees back faces, which are black");
        }
        let look = lamps.look(lights, args);
        let picture = |times: &mut Vec<f64>| -> Result<Hdr> {
            let factor = if args.filter.supersamples() { SUPER } else { 1 };
            let size = args.size.0.map(|side| side * factor);
            let light = middle(&look.lights[0]);
            let params = orbit.params(drawing.mesh(), size, light)?;
            let begun = Instant::now();
            let mut drawn = drawing.draw(&params, &look, size)?;
            if !args.no_background {
                let side = if factor == 1 { BEHIND } else { 1 };
                add_behind(&mut drawn.pixels, drawn.width, &look.lights, &params, side);
            }
            times.push(begun.elapsed().as_secs_f64());
            let [width, height] = args.size.0;
            Ok(match factor {
                1 => drawn,
                _ => Hdr { width, height, pixels: reduced(drawn.width, &drawn.pixels, factor) },
            })
        };
        let first = picture(&mut times)?;
        for _ in 0..args.time {
            picture(&mut times)?;
        }
        pictures.push(first);
        bar.inc(1);
    }
    bar.finish_and_clear();
    if args.time > 0 {
        times.sort_by(f64::total_cmp);
        let [width, height] = args.size.0;
        println!(
            "{} {}: {width} × {height}, median {:.3} s of {} pictures, from {:.3} to {:.3} s",
            skin.spec.name,
            variant.name,
            times[times.len() / 2],
            times.len(),
            times[0],
            times[times.len() - 1]
        );
    }
    Ok(pictures)
}

/// Compares each skin's picture with the scene in f64; again with a flipped bitangent, and where lights have a size with wider ones,
/// which must fail. Single directions of options are drawn by the package's entry point `mesh`, the first of them.
fn judge(args: &Args, gpu: &Gpu, lamps: &Lamps, skins: &[Skin], mesh: &Mesh) -> Result<Outcome> {
    let mut outcome = Outcome::Done;
    for skin in skins {
        let (height, rotate_deg) = (&skin.surface.field, skin.spec.rotate_deg);
        let variant = &skin.variant;
        let mut prepared = Prepared::new(Placement { height, rotate_deg, variant })?;
        let lights = lamps.on(skin.has_disc, None);
        let is_plain = lamps.are_plain(skin.has_disc);
        let params = orbit(args, mesh).params(mesh, args.size.0, middle(&lights[0]))?;
        let compared = |prepared: &Prepared<'_>, drawn: &[Light]| match is_plain {
            true => truth(gpu, prepared, mesh, &params, args.size.0),
            false => truth_under(gpu, prepared, mesh, &params, [&lights, drawn], args.size.0),
        };
        let allowed = prepared.form.promise().tolerance(Part::Arithmetic);
        let allowed = allowed.and_then(|t| t.max_abs).unwrap_or_default();
        let shading = |found: &Truth| match is_plain {
            true => found.shading.max_abs <= allowed,
            // a light has an edge, and a direction beside it may be on either side
            false => found.shading.de2000.p95 <= LIT_SHADING,
        };
        let agrees = |found: &Truth| {
            shading(found)
                && found.direction <= TRUTH.0
                && found.scene.de2000.p95 <= TRUTH.1
                && found.body.is_none_or(|body| body <= BODY)
        };
        let found = compared(&prepared, &lights)?;
        let lit = (found.scene.lit * found.pixels as f64).round() as usize;
        if lit < MIN_LIT {
            bail!(
                "{} on {}: {lit} lit pixels, but a verdict needs at least {MIN_LIT}: \
                 raise --size or --zoom, or move the light",
                skin.spec.name,
                mesh.name
            );
        }
        let wider = wider(&lights);
        let wider = wider.map(|drawn| compared(&prepared, &drawn)).transpose()?;
        let Some(text) = prepared.sources.0.get_mut("mesh").filter(|t| t.contains(FLIP.0)) else {
            bail!("the template `mesh` has no `{}` to flip", FLIP.0);
        };
        *text = text.replace(FLIP.0, FLIP.1);
        let flipped = compared(&prepared, &lights)?;
        let pass = agrees(&found);
        let is_caught = !agrees(&flipped) && wider.as_ref().is_none_or(|found| !agrees(found));
        if !(pass && is_caught) {
            outcome = Outcome::Findings;
        }
        let mut limits = serde_json::json!({
            "direction": TRUTH.0,
            "scene_de2000_p95": TRUTH.1,
        });
        match is_plain {
            true => limits["shading_max_abs"] = allowed.into(),
            false => {
                limits["shading_de2000_p95"] = LIT_SHADING.into();
                limits["body"] = BODY.into();
            }
        }
        let kinds: Vec<&str> = lights.iter().map(Light::kind).collect();
        let mut record = serde_json::json!({
            "kind": "scene",
            "surface": skin.spec.name,
            "variant": variant.name,
            "route": format!("{}:{}", gpu.info().backend, gpu.info().name),
            "mesh": mesh.name,
            "lights": kinds,
            "pass": pass,
            "allowed": limits,
            "lit_pixels": lit,
            "truth": found,
            "flipped_bitangent": control(&flipped, !agrees(&flipped)),
        });
        if let Some(found) = &wider {
            record["wider_lights"] = control(found, !agrees(found));
        }
        println!("{record}");
    }
    Ok(outcome)
}

/// What a negative control found.
fn control(found: &Truth, is_caught: bool) -> serde_json::Value {
    serde_json::json!({
        "caught": is_caught,
        "direction": found.direction,
        "scene_de2000_p95": found.scene.de2000.p95,
        "shading_max_abs": found.shading.max_abs,
    })
}

/// The lights [`WIDER`] times as wide: discs of the same irradiance, polygons of the same radiance. Those that would be wider than a
/// hemisphere become narrower. `None` if that changes nothing.
fn wider(lights: &[Light]) -> Option<Vec<Light>> {
    let widened = |light: &Light| match light {
        Light::Disc { cap: Cap { axis, radius_rad }, irradiance } => {
            let factor = if WIDER * radius_rad < FRAC_PI_2 { WIDER } else { WIDER.recip() };
            let cap = Cap { axis: *axis, radius_rad: factor * radius_rad };
            Light::Disc { cap, irradiance: *irradiance }
        }
        Light::Polygon { polygon, radiance } => {
            let middle = middle(light);
            // along the plane that touches the sphere in the middle
            let moved = |corner: &DVec3| {
                (middle + WIDER * (*corner / corner.dot(middle) - middle)).normalize()
            };
            let corners: Vec<DVec3> = polygon.corners().iter().map(moved).collect();
            Polygon::new(&corners).map_or_else(
                |_| light.clone(),
                |polygon| Light::Polygon { polygon, radiance: *radiance },
            )
        }
        _ => light.clone(),
    };
    let all: Vec<Light> = lights.iter().map(widened).collect();
    (all != lights).then_some(all)
}

/// Whether a variant can have the function of wider lobes, but does not.
fn can_widen(variant: &Variant) -> bool {
    variant.mode == Mode::Baked
        && variant.optics.coherence == Coherence::Ensemble
        && variant.optics.coherence_scaling == CoherenceScaling::Wavelength
        && variant.spread_levels == Auto::Value(0)
}

fn turn(mesh: &mut Mesh, by_deg: f64) {
    mesh.vertices.iter_mut().for_each(|v| v.orientation_angle += by_deg.to_radians());
}
