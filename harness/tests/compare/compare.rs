//! Comparisons over routes: what a right, a wrong and a broken route become in the records.

use crate::support::tools;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use diffraction_harness::compare::{
    AROUND_CONTROLS, CONTROLS, Job, LAMP_CONTROLS, MATTER_CONTROLS, SPREAD_CONTROLS, Shine, Sink,
    Unit, run, steps,
};
use diffraction_harness::drivers::Prepared;
use diffraction_harness::drivers::routes::{self, Route};
use diffraction_harness::results::{Compare, Control, Energy, Gap, Lit, Part, Record};
use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::light::{Cap, Environment, Light, Lights, Polygon, Studio};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::Plan;
use diffraction_shaders::runner::{Progress, Runner, TwinRunner};
use glam::DVec3;

const PLAN: &str = r#"schema = 1
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 60 }
[[surface]]
name = "flat"
grating = { kind = "flat", period_um = 4.0, pixels = 50 }
[variants]
mode = ["full", "adaptive"]
terms = [19]
[[preset]]
name = "half"
table = "f16"
terms = 19
[[preset]]
name = "comparator"
mode = "gems"
"#;

/// What a made-up route gives.
#[derive(Clone, Copy, PartialEq)]
enum Behaviour {
    /// The twin's colours, whatever was made wrong in the shader.
    Blind,
    /// The twin's colours, all a thousandth of the greatest off.
    Off,
    /// No number.
    Nan,
    /// An error.
    Broken,
}

struct Made {
    behaviour: Behaviour,
    asked: Rc<Cell<usize>>,
}

impl Route for Made {
    fn name(&self) -> String {
        "made".to_owned()
    }

    fn runner<'a>(&self, prepared: Prepared<'a>) -> Box<dyn Runner + 'a> {
        self.asked.set(self.asked.get() + 1);
        let twin = TwinRunner::new(prepared.placement, true).unwrap();
        Box::new(MadeRunner { behaviour: self.behaviour, twin })
    }
}

struct MadeRunner<'a> {
    behaviour: Behaviour,
    twin: TwinRunner<'a>,
}

impl Runner for MadeRunner<'_> {
    fn route(&self) -> String {
        "made".to_owned()
    }

    fn tristimulus_with(
        &self,
        directions: &[Directions],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        if self.behaviour == Behaviour::Broken {
            return Err(Error::new("made", "the device was lost"));
        }
        let mut colours = self.twin.tristimulus_with(directions, progress)?;
        let most = colours.iter().flatten().fold(0.0, |a: f64, b| a.max(*b));
        for value in colours.iter_mut().flatten() {
            match self.behaviour {
                Behaviour::Off => *value += 1e-3 * most,
                Behaviour::Nan => *value = f64::NAN,
                _ => {}
            }
        }
        Ok(colours)
    }

    fn under(
        &self,
        light: &Light,
        views: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let mut colours = self.twin.under(light, views, progress)?;
        if self.behaviour == Behaviour::Off {
            let most = colours.iter().flatten().fold(0.0, |a: f64, b| a.max(*b));
            colours.iter_mut().flatten().for_each(|value| *value += 1e-3 * most);
        }
        Ok(colours)
    }

    fn response(&self, directions: &[Directions], lambda_nm: f64) -> Result<Vec<f64>> {
        self.twin.response(directions, lambda_nm)
    }
}

/// Keeps everything; knows what an earlier run has.
#[derive(Default)]
struct Kept {
    records: Vec<Record>,
    pictures: BTreeMap<String, Vec<u8>>,
    steps: usize,
    known: bool,
}

impl Sink for Kept {
    fn record(&mut self, record: Record) -> Result<()> {
        self.records.push(record);
        Ok(())
    }

    fn picture(&mut self, place: &str, png: Vec<u8>) -> Result<()> {
        self.pictures.insert(place.to_owned(), png);
        Ok(())
    }

    fn begin(&mut self, _: &str) {}

    fn step(&mut self) {
        self.steps += 1;
    }

    fn has(&self, _: &Unit<'_>, _: &[String]) -> bool {
        self.known
    }

    fn has_control(&self, _: &str, _: &str) -> bool {
        self.known
    }
}

impl Kept {
    fn compares(&self) -> Vec<&Compare> {
        let one = self.records.iter().filter_map(|record| match record {
            Record::Compare(c) => Some(c),
            _ => None,
        });
        one.collect()
    }

    fn controls(&self) -> Vec<&Control> {
        let one = self.records.iter().filter_map(|record| match record {
            Record::Control(c) => Some(c),
            _ => None,
        });
        one.collect()
    }

    fn energies(&self) -> Vec<&Energy> {
        let one = self.records.iter().filter_map(|record| match record {
            Record::Energy(energy) => Some(energy),
            _ => None,
        });
        one.collect()
    }

    fn gaps(&self) -> Vec<&Gap> {
        let one = self.records.iter().filter_map(|record| match record {
            Record::Gap(gap) => Some(gap),
            _ => None,
        });
        one.collect()
    }
}

fn compared(routes: &[Box<dyn Route>], known: bool) -> Kept {
    compared_of(PLAN, routes, known)
}

fn compared_of(plan: &str, routes: &[Box<dyn Route>], known: bool) -> Kept {
    let plan = Plan::parse(plan, Path::new("plan.toml")).unwrap();
    let request = Job {
        surfaces: &plan.surfaces,
        variants: &plan.variants,
        routes,
        lights: &[Shine::Direction([20.0, 0.0]), Shine::Direction([0.0, 0.0])],
        size: 24,
        exposure: None,
        subset: 2,
        memory: u64::MAX,
    };
    let mut kept = Kept { known, ..Kept::default() };
    run(&request, &mut kept).unwrap();
    assert_eq!(kept.steps, steps(&request), "the bar does not end");
    kept
}

fn made(behaviour: Behaviour) -> (Kept, usize) {
    let asked = Rc::new(Cell::new(0));
    let kept = compared(&[Box::new(Made { behaviour, asked: asked.clone() })], false);
    (kept, asked.get())
}

/// The same heights twice, once under optics of their own: exact colours and variants follow, and what is not for a surface
/// is not missed there.
#[test]
fn surfaces_have_their_own_optics_and_presets() {
    const GRATING: &str =
        "grating = { kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 60 }";
    const REST: &str = r#"[variants]
mode = ["full", "pq"]
terms = [19]
[[preset]]
name = "foil"
surfaces = ["card"]
mode = "adaptive"
terms = 19
"#;
    let of = |own: &str, optics: &str| {
        let plan = format!(
            r#"schema = 1
[[surface]]
name = "a"
{GRATING}
[[surface]]
name = "card"
{GRATING}
{own}
{optics}
{REST}"#
        );
        compared_of(&plan, &[], false)
    };
    let on = |kept: &Kept, surface: &str| -> Vec<Compare> {
        kept.compares().into_iter().filter(|c| c.surface == surface).cloned().collect()
    };
    let optics = "refractive_index = 1.8\ncoherence = \"ensemble\"";
    let own = of("optics = { refractive_index = 1.8, coherence = \"ensemble\" }", "");
    let plain = of("", "");
    assert_eq!(on(&own, "a"), on(&plain, "a"));
    assert!(on(&own, "card") != on(&plain, "card"));
    // pq has no ensemble, and a plan with such optics not even the variant
    let same = of("", &format!("[optics]\n{optics}"));
    let unnamed = |compares: Vec<Compare>| -> Vec<Compare> {
        let unnamed = |mut c: Compare| {
            c.variant = c.variant.replace("-ensemble-n1p8", "");
            c.pictures = None;
            c
        };
        compares.into_iter().map(unnamed).collect()
    };
    let card = unnamed(on(&own, "card"));
    assert_eq!(card, unnamed(on(&same, "card")));
    let variants = |compares: &[Compare]| -> BTreeSet<String> {
        compares.iter().map(|c| c.variant.clone()).collect()
    };
    assert_eq!(variants(&card), ["foil", "full-taylor-t19"].map(str::to_owned).into());
    assert!(card.iter().all(|c| c.pass), "{card:#?}");
    assert!(!variants(&on(&own, "a")).contains("foil"));
    let gaps: Vec<&str> = own.gaps().iter().map(|gap| gap.reason.as_str()).collect();
    assert!(gaps.len() == 1 && gaps[0].contains("pq repeats the patch"), "{gaps:?}");
    assert_eq!(own.gaps()[0].surface.as_deref(), Some("card"));
}

/// A route that does not run the shader that it is given passes every comparison, and no control.
#[test]
fn controls_find_a_route_that_is_blind() {
    let (kept, _) = made(Behaviour::Blind);
    assert!(kept.compares().iter().all(|c| c.pass), "{:?}", kept.compares());
    assert_eq!(kept.controls().len(), CONTROLS.len());
    assert!(kept.controls().iter().all(|control| !control.caught));
}

#[test]
fn a_route_that_is_off_is_outside_and_drawn() {
    let (kept, _) = made(Behaviour::Off);
    let arithmetic: Vec<_> =
        kept.compares().into_iter().filter(|c| c.part == Part::Arithmetic).collect();
    assert!(!arithmetic.is_empty());
    for c in arithmetic {
        assert!(!c.pass && c.max_abs > 5e-4, "{c:?}");
        let places = c.pictures.as_ref().unwrap();
        assert!(places.iter().all(|place| kept.pictures.contains_key(place)), "{places:?}");
    }
    // the right shader is wrong there too, so that nothing counts as caught
    assert!(kept.controls().iter().all(|control| !control.caught));
}

#[test]
fn a_route_that_gives_no_numbers_or_breaks_ends_and_the_rest_goes_on() {
    for behaviour in [Behaviour::Nan, Behaviour::Broken] {
        let (kept, asked) = made(behaviour);
        let failed = kept.gaps().into_iter().filter(|gap| gap.failed).count();
        assert!(failed >= 3, "{failed}");
        if behaviour == Behaviour::Broken {
            assert_eq!(asked, 3, "a lost device is asked again and again");
        }
        // model and packing of what can be resolved: 4 variants on blazed, 3 on the flat one, 2 lights
        let twins = kept.compares().into_iter().filter(|c| c.part == Part::Packing).count();
        assert_eq!(twins, 14);
    }
}

/// What is unavailable is reported with its reason; errors are split; pictures are there once.
#[test]
fn without_a_route_the_twin_is_compared() {
    let kept = compared(&[], false);
    let gap = kept.gaps()[0];
    assert!(!gap.failed && gap.reason.contains("period"), "{gap:?}");
    assert_eq!(gap.variant.as_deref(), Some("comparator"));
    for part in [Part::Model, Part::Packing, Part::Total] {
        assert_eq!(kept.compares().iter().filter(|c| c.part == part).count(), 14, "{part:?}");
    }
    let find = |part, variant: &str| {
        let all = kept.compares();
        all.into_iter()
            .find(|c| c.part == part && c.variant == variant && c.surface == "blazed")
            .unwrap()
            .clone()
    };
    let half = find(Part::Packing, "half");
    assert!(half.max_abs > 1e-4 && half.pass, "{half:?}");
    assert!(find(Part::Packing, "full-taylor-t19").max_abs < 2e-6);
    assert!(find(Part::Total, "comparator").de2000.p95 > 10.0);
    // one exact map for each surface and light, three pictures for each unit of which one is that
    assert_eq!(kept.pictures.len(), 4 + 2 * 14);
}

#[test]
fn what_is_known_is_not_measured_again() {
    assert!(compared(&[], true).compares().is_empty());
    let asked = Rc::new(Cell::new(0));
    let route = Made { behaviour: Behaviour::Blind, asked: asked.clone() };
    let kept = compared(&[Box::new(route)], true);
    assert!(kept.controls().is_empty() && asked.get() == 0);
}

/// Surfaces and lights that each tolerance was made for, which it may exceed four times at most.
#[test]
fn no_tolerance_is_too_loose() {
    const WORST: &str = r#"schema = 1
[[surface]]
name = "rows"
grating = { kind = "rows", size_um = 12.0, pixels = 200, pitch_um = 1.5, height_um = 0.25, seed = 1 }
[[surface]]
name = "bumps"
grating = { kind = "bumps", size_um = 10.0, pixels = 150, pitch_um = 1.3, height_um = 0.3, seed = 2 }
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }
[[preset]]
name = "fine"
terms = 19
wavelengths = { step_nm = 2.5 }
[[preset]]
name = "half"
terms = 23
table = "f16"
[[preset]]
name = "adaptive"
mode = "adaptive"
terms = 23
[[preset]]
name = "printed"
basis = "taylor-zero"
terms = 31
[[preset]]
name = "prefiltered"
mode = "adaptive"
basis = "optimal"
terms = 6
reconstruction = "prefiltered"
table = "f16"
coherence_um = 16
"#;
    let plan = Plan::parse(WORST, Path::new("plan.toml")).unwrap();
    let find = |name: &str| plan.variants.iter().find(|v| v.name == name).unwrap().clone();
    // what, surface, variant, light, pixels
    let cases = [
        ("full by 2.5 nm", Part::Total, "rows", "fine", [20.0, 0.0], 256),
        ("full by 5 nm", Part::Total, "rows", "half", [20.0, 0.0], 256),
        ("adaptive", Part::Total, "blazed", "adaptive", [0.0, 0.0], 32),
        ("adaptive, map", Part::Total, "bumps", "adaptive", [0.0, 0.0], 64),
        ("prefiltered", Part::Total, "bumps", "prefiltered", [60.0, 0.0], 48),
        ("prefiltered, map", Part::Total, "bumps", "prefiltered", [60.0, 0.0], 48),
        ("packing f16", Part::Packing, "bumps", "half", [0.0, 0.0], 48),
        ("packing from zero", Part::Packing, "blazed", "printed", [20.0, 0.0], 48),
        ("packing f32", Part::Packing, "rows", "fine", [20.0, 0.0], 256),
    ];
    for (what, part, surface, variant, light, size) in cases {
        let request = Job {
            surfaces: &[plan.surface(surface).unwrap().clone()],
            variants: &[find(variant)],
            routes: &[],
            lights: &[Shine::Direction(light)],
            size,
            exposure: None,
            subset: 0,
            memory: u64::MAX,
        };
        let mut kept = Kept::default();
        run(&request, &mut kept).unwrap();
        let all = kept.compares();
        let c = all.iter().find(|c| c.part == part).unwrap();
        let (t, map) = (c.tolerance.unwrap(), c.map.map_or(0.0, |map| map.de2000.p95));
        let (allowed, measured) = match (part, what.ends_with("map")) {
            (_, true) => (t.map_p95.unwrap(), map),
            (Part::Packing, _) => (t.max_abs.unwrap(), c.max_abs),
            _ => (t.de2000_p95.unwrap(), c.de2000.p95),
        };
        println!("{what}: {measured:.2e} of {allowed:.2e}");
        assert!(c.pass, "{what}: {c:?}");
        assert!(allowed <= 4.0 * measured, "{what}: {allowed} for {measured}");
    }
}

/// Every route of the machine, small.
#[test]
fn real_routes_pass_and_catch_every_control() {
    let wanted: Vec<String> =
        ["vulkan:llvmpipe", "gl", "spirv:llvmpipe", "hlsl:llvmpipe", "glsl450", "glsl-es300"]
            .map(str::to_owned)
            .to_vec();
    let mut open = Vec::new();
    for found in routes::open(&wanted).unwrap() {
        let route = found.route.map_err(|error| format!("{}: {error}", found.name));
        open.extend(tools::found(route));
    }
    let kept = compared(&open, false);
    for c in kept.compares() {
        assert!(c.pass, "{c:?}");
    }
    assert_eq!(kept.controls().len(), open.len() * CONTROLS.len(), "{:?}", kept.gaps());
    for control in kept.controls() {
        assert!(control.caught, "{control:?}");
    }
}

#[test]
fn an_unknown_route_is_refused() {
    let error = routes::open(&["directx".to_owned()]).err().unwrap().to_string();
    assert!(error.contains("directx") && error.contains("glsl-es300"), "{error}");
}

/// Under lights with a size: a right route passes and catches every fault, a route that is off fails, variants without the
/// functions are gaps, and what the surface returns of all light is recorded.
#[test]
fn lights_with_a_size_are_compared_and_their_controls_are_caught() {
    const PLAN: &str = r#"schema = 1
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 60 }
[optics]
source_diameter_deg = 0.53
coherence = "ensemble"
[variants]
mode = ["orders", "adaptive"]
terms = [19]
"#;
    let corners = [[30.0, 80.0], [30.0, 100.0], [60.0, 100.0], [60.0, 80.0]];
    let corners = corners.map(|[theta, phi]| direction(theta, phi));
    let sun = Cap { axis: direction(20.0, 10.0), radius_rad: 0.265_f64.to_radians() };
    let lights = Lights {
        notes: Vec::new(),
        all: vec![
            Light::Disc { cap: sun, irradiance: 1.0 },
            Light::Polygon { polygon: Polygon::new(&corners).unwrap(), radiance: 10.0 },
            Light::Direction { direction: direction(50.0, 200.0), irradiance: 1.0 },
        ],
    };
    let plan = Plan::parse(PLAN, Path::new("plan.toml")).unwrap();
    let around = Lights {
        notes: Vec::new(),
        all: vec![Light::Environment(Environment {
            panorama: Arc::new(Studio::Softboxes.panorama(512)),
            scale: 1.0,
            rotate_deg: 0.0,
        })],
    };
    let compared_under = |plan: &Plan, routes: &[Box<dyn Route>], lights: &Lights| {
        let request = Job {
            surfaces: &plan.surfaces,
            variants: &plan.variants,
            routes,
            lights: &[Shine::Lights("lamps.toml 1234", lights)],
            size: 24,
            exposure: None,
            subset: 2,
            memory: u64::MAX,
        };
        let mut kept = Kept::default();
        run(&request, &mut kept).unwrap();
        kept
    };
    let compared = |plan: &Plan, routes: &[Box<dyn Route>]| compared_under(plan, routes, &lights);
    let mut open = Vec::new();
    for found in routes::open(&["vulkan:llvmpipe".to_owned()]).unwrap() {
        open.extend(tools::found(found.route));
    }
    if open.is_empty() {
        return;
    }
    let right = compared(&plan, &open);
    let compares = right.compares();
    assert!(compares.len() >= 4 && compares.iter().all(|c| c.pass), "{compares:#?}");
    assert!(compares.iter().all(|c| c.light == Lit::Lights("lamps.toml 1234".to_owned())));
    assert!(compares.iter().all(|c| c.variant.starts_with("orders")));
    let total = compares.iter().find(|c| c.part == Part::Total && c.route == "twin").unwrap();
    assert!(total.lit > 0.2 && total.de2000.p95 < 0.5, "{total:?}");
    let controls: Vec<&Control> = right.controls();
    let under_lamps = LAMP_CONTROLS.len() + SPREAD_CONTROLS.len();
    assert_eq!(controls.len(), CONTROLS.len() + under_lamps);
    assert!(controls.iter().all(|control| control.caught), "{controls:#?}");
    let gaps: Vec<&Gap> = right.gaps();
    assert!(gaps.iter().any(|gap| gap.reason.contains("no function for a light")), "{gaps:#?}");
    let sky: Vec<&Energy> = right.energies();
    assert!(sky.len() == 1 && (0.02..0.2).contains(&sky[0].white_sky[0][1]), "{sky:?}");

    // surroundings, which bring controls of their own
    let right = compared_under(&plan, &open, &around);
    let compares = right.compares();
    assert!(compares.len() >= 4 && compares.iter().all(|c| c.pass), "{compares:#?}");
    let total = compares.iter().find(|c| c.part == Part::Total && c.route == "twin").unwrap();
    assert!(total.lit > 0.2 && total.de2000.p95 > 0.1 && total.de2000.p95 < 6.0, "{total:?}");
    let controls: Vec<&Control> = right.controls();
    assert_eq!(controls.len(), CONTROLS.len() + under_lamps + AROUND_CONTROLS.len());
    assert!(controls.iter().all(|control| control.caught), "{controls:#?}");

    // a metal under a cover, which brings controls of its own
    let own = "pixels = 60 }\noptics = { material = \"gold\", cover_index = \"polycarbonate\" }\n";
    let covered =
        Plan::parse(&PLAN.replace("pixels = 60 }\n", own), Path::new("plan.toml")).unwrap();
    let right = compared(&covered, &open);
    let compares = right.compares();
    assert!(compares.len() >= 4 && compares.iter().all(|c| c.pass), "{compares:#?}");
    let controls: Vec<&Control> = right.controls();
    let all = CONTROLS.len() + under_lamps + MATTER_CONTROLS.len();
    assert_eq!(controls.len(), all);
    assert!(controls.iter().all(|control| control.caught), "{controls:#?}");
    let sky: Vec<&Energy> = right.energies();
    assert!(sky.len() == 1 && (0.2..1.0).contains(&sky[0].white_sky[0][1]), "{sky:?}");

    let made = Made { behaviour: Behaviour::Off, asked: Rc::default() };
    let off = compared(&plan, &[Box::new(made)]);
    let by_made = |c: &&&Compare| c.route == "made" && c.part == Part::Arithmetic;
    assert!(off.compares().iter().find(by_made).is_some_and(|c| !c.pass));
}
