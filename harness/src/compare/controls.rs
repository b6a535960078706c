//! Negative controls: shaders made wrong on purpose, which a comparison must catch.
//!
//! Each is run once by every route, on a surface and variant on which its fault must show: a blazed grating, which differs
//! from its mirror image, under a light off the normal. The right shader must pass there, else the control counts as missed.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use diffraction_shaders::error::Result;
use diffraction_shaders::field::comparison_directions::{on_orders, under_lights};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::light::{Cap, Environment, Light, Lights, Polygon, Studio};
use diffraction_shaders::optics::REFERENCE_NM;
use diffraction_shaders::optics::brdf_map::view_directions;
use diffraction_shaders::optics::colour_difference::{auto_exposure, colour_difference};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{
    Auto, Basis, Coherence, CoherenceScaling, Grating, LightFunction, Material, Medium, Mode,
    Optics, Packing, Reconstruction, Sampling, TableFormat, Variant,
};
use diffraction_shaders::runner::{Placement, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::tables::Table;
use diffraction_shaders::variant::{Part, Tolerance, tolerance_under};
use glam::DVec3;

use crate::drivers::Prepared;
use crate::drivers::routes::Route;
use crate::process::watched::{Place, child::enter};
use crate::results::{self, Record};

use super::{PATIENCE, Query, Sink, Truth, failed};

/// Light of the controls: theta and phi in degrees.
const LIGHT: [f64; 2] = [20.0, 10.0];
/// Width and height of the controls' map, in pixels.
const SIZE: usize = 48;
/// Number of random directions of a control.
const DRAWN: usize = 512;
/// Name of the controls' surface in records.
pub const SURFACE: &str = "blazed-control";

/// What the right shader of a control depends on.
type Kind = (Mode, bool, bool, [bool; 2]);

/// A fault: its name, the mode of the variant, and how the shader is spoilt. `mean` is the mean colour of the right map.
pub struct Control {
    /// Name in records.
    pub name: &'static str,
    /// The mode of the spoilt variant.
    pub mode: Mode,
    /// Whether the variant reads a prefiltered table through the linear filter.
    pub filtered: bool,
    /// Whether its surface is a metal under a cover.
    pub matter: bool,
    /// Whether it is among surroundings in place of lamps.
    pub around: bool,
    /// Whether it has tables of wider lobes, and is under lamps.
    pub spread: bool,
    spoil: fn(&mut Prepared<'_>, [f64; 3]),
}

/// What most controls have in common: one direction of light on a dielectric in air.
const PLAIN: Control = Control {
    name: "",
    mode: Mode::Full,
    filtered: false,
    matter: false,
    around: false,
    spread: false,
    spoil: |_, _| (),
};

impl Control {
    /// Compares the spoilt shader by a route with the twin of the right one.
    fn record<'a>(
        &self,
        placement: Placement<'a>,
        route: &dyn Route,
        rights: &mut BTreeMap<Kind, Right<'a>>,
    ) -> Result<results::Control> {
        let under = [self.around, self.spread];
        let right = match rights.entry((self.mode, self.filtered, self.matter, under)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                place.insert(Right::new(Prepared::new(placement)?, route, under)?)
            }
        };
        let mut prepared = right.prepared.clone();
        (self.spoil)(&mut prepared, right.mean());
        let Right { truth, allowed, max_abs, .. } = right;
        let wrong = truth.ask(route.runner(prepared).as_ref(), 1.0, SIZE)?;
        let wrong = colour_difference(self.name, &truth.colours, &wrong, Some(truth.exposure))?;
        let inside = |max_abs| allowed.contains(max_abs, [0.0; 2]);
        Ok(results::Control {
            surface: SURFACE.to_owned(),
            variant: placement.variant.name.clone(),
            route: route.name(),
            control: self.name.to_owned(),
            light: LIGHT,
            max_abs: wrong.max_abs,
            de2000_p95: wrong.de2000.p95,
            right_max_abs: *max_abs,
            tolerance: *allowed,
            caught: inside(*max_abs) && !inside(wrong.max_abs),
        })
    }
}

/// Controls of surroundings.
pub const AROUND_CONTROLS: [Control; 7] = [
    Control {
        name: "surroundings not blurred",
        mode: Mode::Orders,
        around: true,
        spoil: |p, _| {
            let right = "from_surface(wi), spread)";
            replace(p, "environment", right, "from_surface(wi), 0.0)");
        },
        ..PLAIN
    },
    Control {
        name: "surroundings mirrored",
        mode: Mode::Orders,
        around: true,
        spoil: |p, _| replace(p, "surroundings", "atan2(direction.y,", "atan2(-direction.y,"),
        ..PLAIN
    },
    Control {
        name: "red and blue light exchanged",
        mode: Mode::Orders,
        around: true,
        spoil: |p, _| {
            let right = "xyz += light.x * red.xyz + light.y * green.xyz + light.z * blue.xyz;";
            let wrong = "xyz += light.z * red.xyz + light.y * green.xyz + light.x * blue.xyz;";
            replace(p, "environment", right, wrong);
        },
        ..PLAIN
    },
    Control {
        name: "cells of other streaks",
        mode: Mode::Orders,
        around: true,
        spoil: |p, _| replace(p, "environment", "pace > LONG_CPUM", "pace < LONG_CPUM"),
        ..PLAIN
    },
    Control {
        name: "surroundings of cells not blurred",
        mode: Mode::Baked,
        around: true,
        spread: true,
        spoil: |p, _| replace(p, "cells", "place.z * inverseSqrt(wi.z)", "0.0 * place.z"),
        ..PLAIN
    },
    Control {
        name: "cosine of cells forgotten",
        mode: Mode::Baked,
        around: true,
        spread: true,
        spoil: |p, _| replace(p, "cells", "gain(wi, wr) / wi.z * mix(", "gain(wi, wr) * mix("),
        ..PLAIN
    },
    Control {
        name: "red and blue light of cells exchanged",
        mode: Mode::Baked,
        around: true,
        spread: true,
        spoil: |p, _| {
            let right = "light.x * red + light.y * green + light.z * blue";
            replace(p, "cells", right, "light.z * red + light.y * green + light.x * blue");
        },
        ..PLAIN
    },
];

/// Controls of lights with a size.
pub const LAMP_CONTROLS: [Control; 8] = [
    Control {
        name: "ends of the interval swapped",
        mode: Mode::Orders,
        spoil: |p, _| {
            let right = "start_um, end_um, colour, wr)";
            replace(p, "lamps", right, "end_um, start_um, colour, wr)");
        },
        ..PLAIN
    },
    Control {
        name: "edges not in order",
        mode: Mode::Orders,
        spoil: |p, _| {
            let right = "min(min(nearest.x, nearest.y), min(nearest.z, nearest.w))";
            replace(p, "rectangle", right, "nearest.x");
        },
        ..PLAIN
    },
    Control {
        name: "winding of corners reversed",
        mode: Mode::Orders,
        spoil: |p, _| {
            let right = "select(-1.0, 1.0, dot(turning, centre) > 0.0)";
            replace(p, "rectangle", right, "-1.0 + 1e-9 * dot(turning, centre)");
        },
        ..PLAIN
    },
    Control {
        name: "irradiance not divided by π sin²",
        mode: Mode::Orders,
        spoil: |p, _| {
            let right = "(3.1415927 * sine_squared)";
            replace(p, "disc", right, "(1.0 + 1e-9 * sine_squared)");
        },
        ..PLAIN
    },
    Control {
        name: "order 0 forgotten",
        mode: Mode::Orders,
        spoil: |p, _| {
            let right = "return gain(wi, wr) / max";
            let wrong = "return select(gain(wi, wr), 0.0, all(order == vec2i(0, 0))) / max";
            replace(p, "arrivals", right, wrong);
        },
        ..PLAIN
    },
    Control {
        name: "share constant between the ends",
        mode: Mode::Orders,
        spoil: |p, _| {
            let right = "vec4f(mean - square, linear - 3.0 * cube, 2.0 * square, 4.0 * cube)";
            replace(p, "lamps", right, "vec4f(mean, 1e-9 * (linear + square + cube), 0.0, 0.0)");
        },
        ..PLAIN
    },
    Control {
        name: "red and blue of lamps exchanged",
        mode: Mode::Orders,
        spoil: |p, _| {
            // blue takes the rows of red, and red is what the others leave
            replace(
                p,
                "lamps",
                "moments_between(from_um, to_um, powers, colour)",
                "moments_between(from_um, to_um, powers, colour.zyx)",
            );
        },
        ..PLAIN
    },
    Control {
        name: "colour of a lamp multiplied in afterwards",
        mode: Mode::Orders,
        spoil: |p, _| {
            let right = "tristimulus_disc_coloured(first.xyz, viewer.w, colour, viewer.xyz)";
            let white = "to_rgb(tristimulus_disc(first.xyz, viewer.w, viewer.xyz))";
            let to_xyz =
                "mat3x3f(0.4124, 0.2126, 0.0193, 0.3576, 0.7152, 0.1192, 0.1805, 0.0722, 0.9505)";
            replace(p, "probe", right, &format!("{to_xyz} * (colour * {white})"));
        },
        ..PLAIN
    },
];

/// Controls of wider lobes.
pub const SPREAD_CONTROLS: [Control; 6] = [
    Control {
        name: "level of wider lobes off by one",
        mode: Mode::Baked,
        spread: true,
        spoil: |p, _| {
            replace(p, "baked", "wide_between(path, level)", "wide_between(path, level + 1)")
        },
        ..PLAIN
    },
    Control {
        name: "energy of wider lobes forgotten",
        mode: Mode::Baked,
        spread: true,
        spoil: |p, _| {
            let right = "wider_share(wanted / own)) / own;";
            replace(p, "baked", right, "wider_share(wanted / own));");
        },
        ..PLAIN
    },
    Control {
        name: "width of amplitudes in place of intensities",
        mode: Mode::Baked,
        spread: true,
        // the standard deviation is √2 times as large
        spoil: |p, _| {
            let right = "let narrowest = LOBE_SIGMA * LOBE_SIGMA;";
            replace(p, "baked", right, "let narrowest = 2.0 * LOBE_SIGMA * LOBE_SIGMA;");
        },
        ..PLAIN
    },
    Control {
        name: "tables of wider lobes one row off",
        mode: Mode::Baked,
        spread: true,
        spoil: |p, _| replace(p, "baked", "sizes.y + page * rows)", "sizes.y + page * rows + 1.0)"),
        ..PLAIN
    },
    Control {
        name: "rings of a disc as wide as the disc",
        mode: Mode::Baked,
        spread: true,
        spoil: |p, _| replace(p, "baked", "let away = lobe.x * size;", "let away = 1.0 * size;"),
        ..PLAIN
    },
    Control {
        name: "mirror image of a disc added twice",
        mode: Mode::Baked,
        spread: true,
        spoil: |p, _| replace(p, "baked", "lobe_at(wi.xy + wr.xy, spread) * image", "0.0 * image"),
        ..PLAIN
    },
];

/// Controls of metals under a cover.
pub const MATTER_CONTROLS: [Control; 4] = [
    Control {
        name: "reflectance of the metal forgotten",
        mode: Mode::Orders,
        matter: true,
        spoil: |p, _| {
            let right = "* reflected * efficiency";
            replace(p, "arrivals", right, "* (1.0 + 1e-9 * reflected) * efficiency");
        },
        ..PLAIN
    },
    Control {
        name: "phase of air under a cover",
        mode: Mode::Orders,
        matter: true,
        spoil: |p, _| {
            let right = "-COVER_INDEX * (inside(wi).z + inside(wr).z)";
            replace(p, "gain", right, "-(wi.z + wr.z)");
        },
        ..PLAIN
    },
    Control {
        name: "face of the cover forgotten",
        mode: Mode::Orders,
        matter: true,
        spoil: |p, _| {
            let right = "crossed(wi, light, wr, viewer) * wi.z / light.z";
            replace(
                p,
                "gain",
                right,
                "(1.0 + 1e-9 * crossed(wi, light, wr, viewer)) * wi.z / light.z",
            );
        },
        ..PLAIN
    },
    Control {
        name: "cone inside the cover forgotten",
        mode: Mode::Orders,
        matter: true,
        spoil: |p, _| {
            let right = "crossed(wi, light, wr, viewer) * wi.z / light.z";
            replace(p, "gain", right, "crossed(wi, light, wr, viewer)");
        },
        ..PLAIN
    },
];

/// All controls of single directions.
pub const CONTROLS: [Control; 10] = [
    Control {
        name: "black",
        mode: Mode::Full,
        spoil: |p, _| p.spectrum.texels.chunks_mut(4).for_each(|texel| texel[..3].fill(0.0)),
        ..PLAIN
    },
    Control {
        name: "constant",
        mode: Mode::Full,
        // of all constants, the mean colour is the hardest to catch
        spoil: |p, [x, y, z]| {
            // the tables must still be read, or the driver would not know their names
            let constant = format!("(1e-20 * tristimulus(wi, wr) + vec3f({x:?}, {y:?}, {z:?}))");
            replace(p, "probe", "tristimulus(wi, wr)", &constant);
            replace(p, "colour", "to_rgb(tristimulus(wi, wr))", &format!("to_rgb({constant})"));
        },
        ..PLAIN
    },
    Control {
        name: "mirrored u",
        mode: Mode::Full,
        spoil: |p, _| {
            let mirrored = "return path * vec3f(-1.0, 1.0, 1.0);";
            replace(p, "gain", "return path;", mirrored);
        },
        ..PLAIN
    },
    Control {
        name: "largest term dropped",
        mode: Mode::Full,
        spoil: |p, _| drop_largest(&mut p.terms),
        ..PLAIN
    },
    Control { name: "f16 unscaled", mode: Mode::Full, spoil: |p, _| forget_scale(p), ..PLAIN },
    Control {
        name: "misprinted pq product",
        mode: Mode::Pq,
        spoil: |p, _| {
            replace(p, "pq", "a.x * b.y + a.y * b.x", "a.x * b.x + a.y * b.y");
        },
        ..PLAIN
    },
    Control {
        name: "weights without jacobian",
        mode: Mode::Adaptive,
        // weights per wavenumber, λ² times too small; 550 nm keeps its own
        spoil: |p, _| {
            let (width, mut rows) = (p.spectrum.width, p.spectrum.texels.chunks_mut(4));
            // row 1 has no weights
            let first = rows.by_ref().take(width).collect::<Vec<_>>();
            for texel in first.into_iter().chain(rows.skip(width)).filter(|t| t[3] > 0.0) {
                let jacobian = (texel[3] / (REFERENCE_NM * 1e-3)).powi(2);
                texel[..3].iter_mut().for_each(|weight| *weight /= jacobian);
            }
        },
        ..PLAIN
    },
    Control {
        name: "nearest filter",
        mode: Mode::Adaptive,
        filtered: true,
        spoil: |p, _| replace(p, "prefiltered", "place / size", "floor(place + 0.5) / size"),
        ..PLAIN
    },
    Control {
        name: "baked for one w",
        mode: Mode::Baked,
        spoil: |p, _| {
            let share = "min(w * w / max(4.0 - squared, 1e-6), 1.0)";
            replace(p, "baked", share, "0.5");
        },
        ..PLAIN
    },
    Control {
        name: "baked and mirrored",
        mode: Mode::Baked,
        spoil: |p, _| replace(p, "baked", "uv.x < 0.0", "uv.x > 0.0"),
        ..PLAIN
    },
];

/// Runs all controls by a route and returns how many failed to run. A driver that fails [`PATIENCE`] times is dropped.
///
/// `with_lamps`, `with_matter`, `with_around`: whether those of lights with a size, of metals under a cover and of surroundings are
/// run, too.
pub(super) fn run(
    route: &dyn Route,
    [with_lamps, with_matter, with_around]: [bool; 3],
    sink: &mut dyn Sink,
) -> Result<u32> {
    let height = surface()?;
    let mut rights: BTreeMap<Kind, Right<'_>> = BTreeMap::new();
    let mut failures = 0;
    let lamps = if with_lamps { &LAMP_CONTROLS[..] } else { &[] };
    let spread = if with_lamps { &SPREAD_CONTROLS[..] } else { &[] };
    let matter = if with_matter { &MATTER_CONTROLS[..] } else { &[] };
    let around = if with_around { &AROUND_CONTROLS[..] } else { &[] };
    let controls = CONTROLS.iter().chain(lamps).chain(spread).chain(matter).chain(around);
    let controls: Vec<(&Control, Variant)> = controls.map(|c| (c, variant(c))).collect();
    for (control, variant) in &controls {
        if failures == PATIENCE || sink.has_control(&route.name(), control.name) {
            continue;
        }
        let placement = Placement { height: &height, rotate_deg: 0.0, variant };
        enter(Place {
            route: route.name(),
            surface: Some(SURFACE.to_owned()),
            variant: Some(control.name.to_owned()),
            light: Some(LIGHT),
        });
        match control.record(placement, route, &mut rights) {
            Ok(record) => sink.record(Record::Control(record))?,
            Err(error) => {
                failures += 1;
                let at = Some((SURFACE, control.name));
                sink.record(failed(&route.name(), at, &error.to_string()))?;
            }
        }
    }
    Ok(failures)
}

/// The right shader: its tables, its colours, its tolerance, and its measured difference.
struct Right<'a> {
    prepared: Prepared<'a>,
    truth: Truth,
    allowed: Tolerance,
    max_abs: f64,
}

impl<'a> Right<'a> {
    fn new(
        prepared: Prepared<'a>,
        route: &dyn Route,
        [around, spread]: [bool; 2],
    ) -> Result<Right<'a>> {
        let Placement { height, variant, .. } = prepared.placement;
        let map = view_directions(SIZE);
        let count = map.len();
        let (query, allowed) = if variant.mode == Mode::Orders || spread {
            let lights = match (around, spread) {
                (true, _) => studio(),
                (_, true) => discs(),
                _ => lamps(),
            };
            let views = under_lights(height, &variant.optics, 0.0, &lights, SIZE);
            let views = views.into_iter().map(rounded).collect();
            let allowed = tolerance_under(&prepared.form, &lights, Part::Arithmetic);
            (Query::Lights { lights, views }, allowed)
        } else {
            let light = rounded(direction(LIGHT[0], LIGHT[1]));
            let map = map.into_iter().map(|wr| Directions { wi: light, wr });
            let drawn = on_orders(height, &variant.optics, 0.0, light, DRAWN, 1);
            let directions = map.chain(drawn).collect();
            let allowed = prepared.form.promise().tolerance(Part::Arithmetic);
            (Query::Direction { light, directions }, allowed)
        };
        let mut truth = Truth {
            query,
            map: count,
            colours: Vec::new(),
            exposure: 1.0,
            map_exposure: None,
            picture: String::new(),
        };
        truth.colours = truth.ask(&TwinRunner::new(prepared.placement, true)?, 1.0, SIZE)?;
        truth.exposure = auto_exposure(&truth.colours).unwrap_or(1.0);
        let allowed =
            allowed.unwrap_or(Tolerance { max_abs: Some(0.0), de2000_p95: None, map_p95: None });
        let found = truth.ask(route.runner(prepared.clone()).as_ref(), 1.0, SIZE)?;
        let max_abs =
            colour_difference("right", &truth.colours, &found, Some(truth.exposure))?.max_abs;
        Ok(Right { prepared, truth, allowed, max_abs })
    }

    /// Mean colour of the map.
    fn mean(&self) -> [f64; 3] {
        let map = &self.truth.colours[..self.truth.map];
        std::array::from_fn(|c| map.iter().map(|xyz| xyz[c]).sum::<f64>() / map.len() as f64)
    }
}

/// A disc of irradiance 1.
fn disc(theta_deg: f64, phi_deg: f64, radius_deg: f64) -> Light {
    let (axis, radius_rad) = (direction(theta_deg, phi_deg), radius_deg.to_radians());
    Light::Disc { cap: Cap { axis, radius_rad }, irradiance: 1.0 }
}

/// The lights of controls of wider lobes: discs whose lobes are between two tables of wider ones.
fn discs() -> Lights {
    Lights { all: vec![disc(LIGHT[0], LIGHT[1], 8.0), disc(40.0, 200.0, 20.0)], notes: Vec::new() }
}

/// The lights of controls: the sun, a wide lamp, a softbox; the sun and the softbox once more, elsewhere and in colours.
fn lamps() -> Lights {
    let softbox = |phi_deg: f64| {
        let corners = [[30.0, 0.0], [30.0, 20.0], [60.0, 20.0], [60.0, 0.0]];
        let corners = corners.map(|[theta, phi]| direction(theta, phi_deg + phi));
        // as bright as the others, so that its faults count
        Polygon::new(&corners).ok().map(|polygon| Light::Polygon { polygon, radiance: 1e3 })
    };
    let mut all = vec![disc(LIGHT[0], LIGHT[1], 0.2665), disc(40.0, 200.0, 15.0)];
    all.extend(softbox(80.0));
    let [amber, blue] = [[1.0, 0.3, 0.05], [0.0, 0.2, 1.0]].map(DVec3::from);
    all.push(disc(LIGHT[0], LIGHT[1] + 40.0, 0.2665).coloured(amber));
    all.extend(softbox(300.0).map(|softbox| softbox.coloured(blue)));
    Lights { all, notes: Vec::new() }
}

/// The surroundings of controls: softboxes that no turn and no mirror brings back.
fn studio() -> Lights {
    let panorama = Arc::new(Studio::Softboxes.panorama(512));
    let environment = Environment { panorama, scale: 1.0, rotate_deg: 40.0 };
    Lights { all: vec![Light::Environment(environment)], notes: Vec::new() }
}

/// The surface of the controls.
fn surface() -> Result<HeightField> {
    let grating = Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 60 };
    synthesise(&grating, SURFACE).map(|surface| surface.field)
}

/// The right variant of a mode. A filtered one has a narrow window, which keeps its table small.
fn variant(&Control { mode, filtered, matter, around, spread, .. }: &Control) -> Variant {
    let coherence_um = if filtered { 10.0 } else { Optics::standard().coherence_um };
    let mut standard = Optics { coherence_um, ..Optics::standard() };
    if matter {
        standard.material = Material::Medium(Medium::Named("gold"));
        standard.cover_index = Medium::Named("polycarbonate");
    }
    let texts = Variant::texts(&match mode {
        _ if spread => Optics {
            coherence_um: 40.0,
            coherence: Coherence::Ensemble,
            coherence_scaling: CoherenceScaling::Wavelength,
            ..standard
        },
        Mode::Orders => Optics {
            coherence: Coherence::Ensemble,
            coherence_scaling: CoherenceScaling::Wavelength,
            ..standard
        },
        _ => standard,
    });
    Variant {
        name: mode.as_str().to_owned(),
        mode,
        basis: if filtered { Basis::Optimal } else { Basis::Taylor },
        terms: Auto::Value(if filtered { 6 } else { 19 }),
        reconstruction: if filtered { Reconstruction::Prefiltered } else { Reconstruction::Window },
        sampling: if filtered { Sampling::Filter } else { Sampling::Load },
        // `pq` needs neighbouring replicas
        window_radius: Auto::Value(if mode == Mode::Pq { 3 } else { 1 }),
        packing: Packing::Paired,
        table: match mode {
            Mode::Baked => TableFormat::Rgb9e5,
            _ if filtered => TableFormat::F16,
            _ => TableFormat::F32,
        },
        // small, since it is computed for every route
        bake_mib: 2.0,
        spread_levels: Auto::Value(if spread { 4 } else { 0 }),
        lights: match (spread, around) {
            (false, _) => texts.lights,
            // a function less is a table less
            (true, false) => vec![LightFunction::Direction, LightFunction::Disc],
            (true, true) => vec![LightFunction::Direction, LightFunction::Environment],
        },
        hoist: true,
        ..texts
    }
}

/// Replaces a text in a template.
fn replace(prepared: &mut Prepared<'_>, template: &str, from: &str, to: &str) {
    let text = prepared.sources.0.entry(template.to_owned()).or_default();
    // if the text is not there, the control changes nothing, and so is not caught
    *text = text.replace(from, to);
}

/// Sets the term with the largest value to zero, except the constant one.
fn drop_largest(terms: &mut Table) {
    let (channels, texels) = (terms.format.channels(), terms.width * terms.height);
    let pair = |term: usize| (term / 2 * texels * channels, 2 * (term % 2));
    let count = terms.layers * channels / 2;
    let largest = |term: usize| {
        let (first, channel) = pair(term);
        let layer = &terms.texels[first..first + texels * channels];
        layer.chunks(channels).map(|t| t[channel].hypot(t[channel + 1])).fold(0.0, f64::max)
    };
    let worst = (1..count).max_by(|a, b| largest(*a).total_cmp(&largest(*b)));
    let Some((first, channel)) = worst.map(pair) else { return };
    for texel in terms.texels[first..first + texels * channels].chunks_mut(channels) {
        texel[channel..channel + 2].fill(0.0);
    }
}

/// Rounds the terms as 16-bit floats would round the transforms of `h^n` in µm without a scale, as the thesis defines them:
/// the high powers are below the smallest number of the format.
fn forget_scale(prepared: &mut Prepared<'_>) {
    let Some(series) = prepared.form.series() else { return };
    let expansion = series.expansion();
    let factor = |term: usize| (1..=term).map(|n| expansion.z_max / n as f64).product::<f64>();
    let terms = &mut prepared.terms;
    let (channels, texels) = (terms.format.channels(), terms.width * terms.height);
    for (layer, values) in terms.texels.chunks_mut(texels * channels).enumerate() {
        for (channel, value) in values.iter_mut().enumerate() {
            let term = layer * channels / 2 + channel % channels / 2;
            let unscaled = half::f16::from_f64(*value / factor(term)).to_f64();
            *value = unscaled * factor(term);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_control_changes_what_is_prepared() {
        let height = surface().expect("valid");
        for control in CONTROLS
            .iter()
            .chain(&LAMP_CONTROLS)
            .chain(&SPREAD_CONTROLS)
            .chain(&MATTER_CONTROLS)
            .chain(&AROUND_CONTROLS)
        {
            let variant = variant(control);
            let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
            let right = Prepared::new(placement).expect("resolves");
            let mut wrong = right.clone();
            (control.spoil)(&mut wrong, [0.1; 3]);
            let same = right.sources == wrong.sources
                && right.terms == wrong.terms
                && right.spectrum == wrong.spectrum;
            assert!(!same, "{} changes nothing", control.name);
        }
    }
}
