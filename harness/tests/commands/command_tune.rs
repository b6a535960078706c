//! `cargo xtask tune` as a user runs it, on whatever adapter there is.

use crate::{folder_with, run, without_driver};
use std::fs;
use std::path::Path;
use std::process::Output;

use diffraction_harness::results::{self, Record, Tune, Verdict};
use diffraction_shaders::plan::Plan;

/// `short` is cut so short that its colours are wrong; it costs next to nothing.
const PLAN: &str = r#"schema = 1
[[surface]]
name = "wave"
grating = { kind = "sinusoidal", period_um = 2.0, height_um = 0.25, pixels = 40 }
[[preset]]
name = "short"
mode = "adaptive"
terms = 2
accept_error = true
"#;

/// Measures as little as there can be.
fn tune(folder: &Path, args: &[&str]) -> Output {
    let fixed = ["tune", "--size", "8", "--seconds", "0", "--light", "20,0"];
    run(folder, &[&fixed[..], args].concat())
}

fn folder() -> tempfile::TempDir {
    folder_with(PLAN)
}

fn tunes(folder: &Path) -> Vec<Tune> {
    let records = results::read(&folder.join("out/records.jsonl")).unwrap();
    let tune = |r| if let Record::Tune(tune) = r { Some(tune) } else { None };
    records.into_iter().filter_map(tune).collect()
}

#[test]
fn the_winner_is_within_the_budget_and_its_preset_can_be_pasted() {
    let folder = folder();
    let args = ["--surface", "wave", "--budget-de", "1", "--out", "out", "--json"];
    let done = tune(folder.path(), &args);
    if without_driver(&done) {
        return;
    }
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let found = tunes(folder.path());
    let stdout = String::from_utf8(done.stdout).unwrap();
    let lines = |found: &[Tune]| -> String {
        found.iter().map(|t| results::line(&Record::Tune(t.clone())).expect("finite")).collect()
    };
    assert_eq!(stdout, lines(&found));
    let winners: Vec<&Tune> = found.iter().filter(|t| t.verdict == Verdict::Winner).collect();
    let [winner] = winners.as_slice() else { panic!("{} winners", winners.len()) };
    assert!(winner.worst_p95().unwrap() <= 1.0 && winner.time.unwrap().ratio > 1.0);
    // the wrong series costs less, and has not won
    let short = found.iter().find(|t| t.variant == "short").unwrap();
    assert_eq!(short.verdict, Verdict::Bound, "{}", short.why);
    assert!(found.iter().all(|t| t.verdict != Verdict::Failed));
    // pasted into the plan it is the same variant
    let pasted = format!("{PLAN}{}", winner.preset);
    let plan = Plan::parse(&pasted, Path::new("plan.toml")).unwrap();
    let variant = plan.variant(Some(&winner.variant)).unwrap();
    assert_eq!(diffraction_harness::bench::result::settings(&variant), winner.settings);
    let picture = folder.path().join("out/pictures/tune-wave-vulkan-de1.svg");
    let is_gl = winner.backend == "gl";
    assert!(is_gl || fs::read_to_string(picture).unwrap().contains(&winner.variant));
    // a second run replaces the first; what is measured is the same
    let done = tune(folder.path(), &["--surface", "wave", "--budget-de", "1", "--out", "out"]);
    let again = tunes(folder.path());
    let plain = |all: &[Tune]| -> Vec<String> {
        let mut all: Vec<String> =
            all.iter().map(|t| format!("{} {:?} {:?}", t.variant, t.errors, t.bounds)).collect();
        all.sort();
        all
    };
    assert_eq!(plain(&again), plain(&found));
    let text = String::from_utf8(done.stdout).unwrap();
    assert!(text.contains("winner: ") && text.contains("[[preset]]"), "{text}");
    assert!(
        text.contains("an a-priori error bound is far too large") && text.contains("baseline"),
        "{text}"
    );
}

#[test]
fn a_budget_that_nothing_keeps_is_a_finding_that_says_what_came_nearest() {
    let folder = folder();
    let done = tune(folder.path(), &["--surface", "wave", "--budget-de", "1e-6"]);
    if without_driver(&done) {
        return;
    }
    let text = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(1), "{text}");
    assert!(
        text.contains("no candidate is within a p95 of 0.000001") && text.contains("nearest"),
        "{text}"
    );
}

#[test]
fn bad_input_is_a_usage_error_with_what_there_is() {
    let folder = folder();
    for (args, message) in [
        (&["--surface", "wave", "--budget-de", "0"][..], "positive"),
        (&["--surface", "wave", "--budget-de", "nan"], "positive"),
        (&["--surface", "wave", "--budget-de", "-1"], "positive"),
        (&["--surface", "wvae", "--budget-de", "1"], "wave"),
        (&["--surface", "wave", "--budget-de", "1", "--fits", "webgl3"], "webgl2"),
        (&["--surface", "wave", "--budget-de", "1", "--max-table-mib", "-1"], "positive"),
        (&["--surface", "wave", "--budget-de", "1", "--adapter", "no such"], "no such"),
        (&["--surface", "wave", "--budget-de", "1", "--light", "90,0"], "THETA"),
        (&["--surface", "wave"], "--budget-de"),
    ] {
        let done = tune(folder.path(), args);
        let text = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{args:?}: {text}");
        assert!(text.contains(message) && done.stdout.is_empty(), "{args:?}: {text}");
    }
}
