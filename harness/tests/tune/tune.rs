//! The search for the cheapest variant: candidates, pruning, order, front and winner; no driver.

use std::path::Path;

use diffraction_harness::report::front_picture;
use diffraction_harness::results::{LightError, Time, Tune, Verdict};
use diffraction_harness::tune::candidates::candidates;
use diffraction_harness::tune::colours::Truth;
use diffraction_harness::tune::prune::{Limits, prune};
use diffraction_harness::tune::search::{Found, State, search, to_time};
use diffraction_harness::tune::verdict::{Baseline, Results, Run, front, settle, winner};
use diffraction_harness::tune::{Candidate, Lost};
use diffraction_shaders::input;
use diffraction_shaders::plan::{Auto, Mode, Plan, Variant};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::shader::limits::Profile;
use diffraction_shaders::surface;
use diffraction_shaders::variant::Form;

/// A small grating, a variant of the plan, one under another light, and one with a series cut far too short.
const PLAN: &str = r#"schema = 1
[[surface]]
name = "wave"
grating = { kind = "sinusoidal", period_um = 2.0, height_um = 0.25, pixels = 40 }
[[preset]]
name = "own"
mode = "adaptive"
terms = 21
[[preset]]
name = "wet"
mode = "adaptive"
refractive_index = 1.33
[[preset]]
name = "short"
mode = "adaptive"
terms = 3
accept_error = true
"#;

const LIMITS: Limits = Limits { budget_de: 1.0, fits: None, max_table_mib: None };

fn plan() -> Plan {
    Plan::parse(PLAN, Path::new("plan.toml")).expect("a plan")
}

fn surface(plan: &Plan) -> surface::HeightField {
    input::load_surface(&plan.surfaces[0]).expect("a surface").field
}

fn of<'a>(lost: &'a [Lost], name: &str) -> &'a Lost {
    lost.iter().find(|l| l.name == name).unwrap_or_else(|| panic!("{name} has not lost"))
}

fn name(candidate: &Candidate) -> &str {
    &candidate.variant.name
}

#[test]
fn candidates_are_presets_of_the_plan_and_keep_its_optics() {
    let plan = plan();
    let height = surface(&plan);
    let (kept, lost) = candidates(&plan, &height);
    assert_eq!(kept.iter().map(name).take(2).collect::<Vec<_>>(), ["own", "short"]);
    assert_eq!(of(&lost, "wet").verdict, Verdict::Optics);
    for candidate in &kept {
        let read = plan.preset(&candidate.preset).expect("a preset");
        assert_eq!(read.hash(), candidate.variant.hash(), "{}", candidate.preset);
        assert_eq!(read.optics, plan.optics);
    }
    // every candidate is there once, and the same in every run
    let (again, lost_again) = candidates(&plan, &height);
    assert_eq!(
        kept.iter().map(name).collect::<Vec<_>>(),
        again.iter().map(name).collect::<Vec<_>>()
    );
    assert_eq!(lost, lost_again);
    let refused: Vec<&Lost> = lost.iter().filter(|l| l.verdict == Verdict::Refused).collect();
    assert!(refused.iter().all(|l| !l.why.is_empty() && !l.why.contains(&l.name)), "{refused:?}");
    // the counts of each basis are those that its errors ask for
    let terms = |basis: &str| -> Vec<u32> {
        let of = kept.iter().filter(|c| name(c).starts_with(&format!("adaptive-{basis}-")));
        let mut all: Vec<u32> = of.map(|c| c.on.series().unwrap().expansion().terms).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    assert!(terms("optimal").len() >= 3 && terms("taylor").last() > terms("optimal").last());
}

#[test]
fn bounds_sizes_and_profiles_prune_with_their_reasons() {
    let plan = plan();
    let height = surface(&plan);
    let all = || candidates(&plan, &height).0;
    let (kept, lost) = prune(all(), &LIMITS, 0.0);
    let short = of(&lost, "short");
    assert_eq!(short.verdict, Verdict::Bound);
    assert!(short.why.contains("phase function"), "{}", short.why);
    assert!(
        lost.iter().any(|l| l.verdict == Verdict::Bound && l.why.contains("wavelength's steps"))
    );
    // an even number of terms costs what the odd one below it does
    assert!(lost.iter().any(|l| l.verdict == Verdict::Dominated));
    for (i, one) in kept.iter().enumerate() {
        for other in kept.iter().skip(i + 1).filter(|other| other.kind == one.kind) {
            let better = |a: &Candidate, b: &Candidate| {
                let bounds = a.bounds.all().into_iter().zip(b.bounds.all());
                a.fetches() <= b.fetches()
                    && a.table_bytes() <= b.table_bytes()
                    && bounds.into_iter().all(|(a, b)| a <= b)
            };
            assert!(!better(one, other) && !better(other, one), "{} {}", name(one), name(other));
        }
    }
    let (small, lost) = prune(all(), &Limits { max_table_mib: Some(0.01), ..LIMITS }, 0.0);
    assert!(small.iter().all(|c| c.table_bytes() <= 10486) && small.len() < kept.len());
    assert!(lost.iter().any(|l| l.verdict == Verdict::Large && l.why.ends_with("above 0.01")));
    // a grating's bins fit anywhere, unlike the finer grid of prefiltered ones; a wide patch has more bins than a texture
    // of WebGL2 is sure to have texels
    let fits = Limits { fits: Some(Profile::Webgl2), ..LIMITS };
    let (_, lost) = prune(all(), &fits, 0.0);
    let unfit = lost.iter().filter(|l| l.verdict == Verdict::Unfit);
    assert!(unfit.clone().count() > 0 && unfit.clone().all(|l| l.name.contains("prefiltered")));
    let wide = surface::HeightField::new(4000, 4, 0.09, 0.09, wide_heights()).expect("valid");
    let (_, lost) = prune(candidates(&plan, &wide).0, &fits, 0.0);
    assert!(
        lost.iter().any(|l| l.verdict == Verdict::Unfit && l.why.contains("webgl2")),
        "{lost:?}"
    );
}

fn wide_heights() -> Vec<f64> {
    (0..16000).map(|i| 0.1 * (f64::from(i) * 0.3).sin()).collect()
}

/// Errors that follow the bounds: the search must find what looking at every candidate finds.
#[test]
fn a_search_finds_the_cheapest_of_every_form_with_few_measurements() {
    let plan = plan();
    let height = surface(&plan);
    let (kept, _) = prune(candidates(&plan, &height).0, &LIMITS, 0.0);
    let p95 = |c: &Candidate| 20.0 * c.bounds.phase + 30.0 * c.bounds.tail + 8.0 * c.bounds.step;
    let mut asked = Vec::new();
    let mut measure = |c: &Candidate| {
        asked.push(name(c).to_owned());
        let found = match p95(c) {
            far if far > 2.0 => Found::Far(far, [20.0, 0.0]),
            p95 => Found::Errors(vec![error(p95, None)]),
        };
        Ok::<_, ()>(found)
    };
    let states = search(&kept, 1.0, &mut measure).expect("no error");
    assert!(asked.len() < kept.len(), "{} of {}", asked.len(), kept.len());
    let within = |i: &usize| states[*i].worst_p95().is_some_and(|p95| p95 <= 1.0);
    let found = (0..kept.len()).filter(within).min_by(|a, b| by_fetches(&kept[*a], &kept[*b]));
    let wanted = (0..kept.len())
        .filter(|i| p95(&kept[*i]) <= 1.0)
        .min_by(|a, b| by_fetches(&kept[*a], &kept[*b]));
    assert_eq!(found.map(|i| name(&kept[i])), wanted.map(|i| name(&kept[i])));
    assert!(found.is_some());
    for (candidate, state) in kept.iter().zip(&states) {
        match state {
            State::Measured(_) | State::Far(..) => {
                assert!(asked.iter().any(|n| n == name(candidate)))
            }
            State::Lost(verdict, why) => assert!(*verdict != Verdict::Failed && !why.is_empty()),
        }
    }
    let timed = to_time(&kept, &states, 1.0);
    assert!(timed.contains(&found.expect("found")));
    assert!(timed.windows(2).all(|w| kept[w[0]].fetches() <= kept[w[1]].fetches()));
    // what fails says nothing of others
    let mut failing = |c: &Candidate| match c.variant.mode {
        Mode::Adaptive => Ok::<_, ()>(Found::Failed("no".to_owned())),
        _ => Ok(Found::Errors(vec![error(0.1, None)])),
    };
    let states = search(&kept, 1.0, &mut failing).expect("no error");
    for (candidate, state) in kept.iter().zip(&states) {
        let failed = matches!(state, State::Lost(Verdict::Failed, _));
        assert_eq!(failed, candidate.variant.mode == Mode::Adaptive, "{}", name(candidate));
    }
}

fn by_fetches(a: &Candidate, b: &Candidate) -> std::cmp::Ordering {
    a.fetches().total_cmp(&b.fetches()).then(a.table_bytes().cmp(&b.table_bytes()))
}

/// Real colours: converged candidates are inside, the wrong one is far out, whatever it costs.
#[test]
fn a_series_cut_short_is_far_over_the_budget() {
    let plan = plan();
    let height = surface(&plan);
    let lights = [[20.0, 0.0], [60.0, 0.0]];
    let truth = Truth::new(&height, 0.0, &plan.optics, &lights, &|_| ()).expect("lit");
    let measure = |name: &str| {
        let variant = plan.variant(Some(name)).expect("in the plan");
        truth.measure(Placement { height: &height, rotate_deg: 0.0, variant: &variant }, 1.0)
    };
    let Found::Errors(errors) = measure("own") else { panic!("own is far off") };
    assert_eq!(errors.iter().map(|e| e.light).collect::<Vec<_>>(), lights);
    assert!(errors.iter().all(|e| e.worst_p95() < 0.5), "{errors:?}");
    let Found::Far(p95, light) = measure("short") else { panic!("a wrong series is within") };
    assert!(p95 > 5.0 && light == lights[0], "{p95}");
    // a budget that nothing keeps
    let own = plan.variant(Some("own")).expect("in the plan");
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &own };
    assert!(matches!(truth.measure(placement, 1e-6), Found::Far(..)));
}

fn error(p95: f64, map_p95: Option<f64>) -> LightError {
    LightError { light: [20.0, 0.0], p95, max: 2.0 * p95, map_p95 }
}

/// `pace`: how far it is from the fastest.
fn time(ns_per_pixel: f64, pace: Option<[f64; 2]>) -> Time {
    let ratio = 1e5 / ns_per_pixel;
    let ratio_interval = [0.95 * ratio, 1.05 * ratio];
    Time { median_ms: 1.0, mad_ms: 0.1, ns_per_pixel, ratio, ratio_interval, pace, runs: 6 }
}

/// A settled run of the candidates of the plan with given errors and times.
fn settled(errors_and_times: &[(LightError, Time)]) -> Vec<Tune> {
    let plan = plan();
    let height = surface(&plan);
    let (kept, lost) = candidates(&plan, &height);
    let kept: Vec<Candidate> = kept.into_iter().take(errors_and_times.len()).collect();
    let states = errors_and_times.iter().map(|(e, _)| State::Measured(vec![*e])).collect();
    let times = errors_and_times.iter().map(|(_, t)| Ok(*t)).enumerate().collect();
    let texts = Variant::texts(&plan.optics);
    let cost = Form::new(&texts, &height).expect("resolves").cost();
    let baseline = Baseline { errors: vec![error(4.0, None)], time: Some(time(1e5, None)), cost };
    let run = Run {
        surface: "wave",
        plan: &plan,
        limits: LIMITS,
        lights: &[[20.0, 0.0]],
        adapter: ["vulkan", "raster"],
        size: 64,
    };
    settle(&run, &Results { candidates: kept, states, lost, times, baseline })
}

#[test]
fn the_fastest_within_the_budget_wins_and_the_front_is_marked() {
    let records = settled(&[
        (error(0.5, None), time(300.0, Some([0.6, 0.7]))),
        (error(0.2, Some(1.5)), time(100.0, None)),
        (error(0.8, None), time(200.0, Some([1.0, 1.0]))),
        (error(0.9, None), time(400.0, Some([0.5, 0.5]))),
    ]);
    let by = |verdict: Verdict| -> Vec<&Tune> {
        records.iter().filter(|r| r.verdict == verdict).collect()
    };
    // the map of the second is over the budget, though it is the fastest and its other directions are not
    assert_eq!(by(Verdict::Winner).iter().map(|r| r.worst_p95()).collect::<Vec<_>>(), [Some(0.8)]);
    assert_eq!(by(Verdict::Over).iter().map(|r| r.worst_p95()).collect::<Vec<_>>(), [Some(1.5)]);
    assert_eq!(by(Verdict::Within).len(), 2);
    assert_eq!(records[0].verdict, Verdict::Winner);
    let mut on: Vec<f64> = records.iter().filter(|r| r.front).filter_map(Tune::worst_p95).collect();
    on.sort_by(f64::total_cmp);
    assert_eq!(on, [0.5, 0.8, 1.5], "neither the slow one nor the baseline");
    assert_eq!(by(Verdict::Baseline)[0].variant, Variant::TEXTS);
    // every candidate that lost has its record with the reason
    assert!(by(Verdict::Refused).iter().all(|r| !r.why.is_empty() && r.time.is_none()));
    let picture = front_picture(&records).expect("times");
    assert!(picture.contains("budget 1") && picture.contains(&records[0].variant), "{picture}");
    assert_eq!(picture.matches("class=\"ring\"").count(), 1);
}

#[test]
fn ties_go_to_the_smaller_error_then_the_smaller_tables_then_the_name() {
    let tie = Some([0.98, 1.01]);
    let won = |errors: [f64; 3], paces: [Option<[f64; 2]>; 3]| {
        let mut records: Vec<Tune> = settled(&[
            (error(errors[0], None), time(100.0, paces[0])),
            (error(errors[1], None), time(101.0, paces[1])),
            (error(errors[2], None), time(102.0, paces[2])),
        ]);
        records.retain(|r| r.time.is_some() && r.verdict != Verdict::Baseline);
        records.sort_by(|a, b| {
            a.time
                .unwrap_or(time(1.0, None))
                .ns_per_pixel
                .total_cmp(&b.time.unwrap_or(time(1.0, None)).ns_per_pixel)
        });
        records.iter_mut().for_each(|r| r.verdict = Verdict::Within);
        (winner(&records), records)
    };
    let one = Some([1.0, 1.0]);
    assert_eq!(won([0.5, 0.4, 0.3], [one, tie, tie]).0, Some(2));
    // distinguished: slower by more than its interval
    assert_eq!(won([0.5, 0.4, 0.3], [one, tie, Some([0.9, 0.97])]).0, Some(1));
    // without paces by the ratios
    assert_eq!(won([0.5, 0.4, 0.6], [None; 3]).0, Some(1));
    let (_, mut records) = won([0.5; 3], [one, tie, tie]);
    for (record, bytes) in records.iter_mut().zip([30, 10, 20]) {
        record.table_bytes = Some(bytes);
    }
    assert_eq!(winner(&records), Some(1));
    for (record, name) in records.iter_mut().zip(["c", "b", "a"]) {
        (record.table_bytes, record.variant) = (Some(10), name.to_owned());
    }
    assert_eq!(winner(&records), Some(2));
    records.iter_mut().for_each(|r| r.verdict = Verdict::Over);
    assert_eq!(winner(&records), None);
}

#[test]
fn a_front_keeps_equals_and_drops_what_is_beaten() {
    let places = [
        Some([1.0, 2.0]),
        None,
        Some([1.0, 2.0]),
        Some([1.0, 3.0]),
        Some([2.0, 1.0]),
        Some([3.0, 1.0]),
    ];
    assert_eq!(front(&places), [0, 2, 4]);
}

#[test]
fn a_preset_is_read_like_one_of_the_plan() {
    let plan = plan();
    let read = plan
        .preset(
            r#"[[preset]]
name = "x"
terms = "auto"
"#,
        )
        .expect("a preset");
    assert_eq!((read.terms, read.name.as_str()), (Auto::Auto, "x"));
    for (text, message) in [
        ("", "is not exactly one [[preset]]"),
        (
            r#"[[preset]]
name = "x"
term = 3
"#,
            "did you mean \"terms\"",
        ),
        (
            r#"[[preset]]
name = "x"
[[preset]]
name = "y"
terms = 4
"#,
            "is not exactly one [[preset]]",
        ),
        ("[optics]\ncoherence_um = 3\n", "unknown key optics"),
        ("[[preset", "preset:1"),
    ] {
        let errors = plan.preset(text).expect_err(text);
        assert!(errors.iter().any(|e| e.to_string().contains(message)), "{text}: {errors:?}");
    }
}
