//! `cargo xtask bench` as a user runs it, on whatever adapters there are.

use crate::{folder_with, run, without_driver};
use std::path::Path;
use std::process::Output;

use diffraction_harness::results::{self, Bench, Record};

/// `gems` has no meaning on a flat surface: it cannot be built.
const PLAN: &str = r#"schema = 1
[[surface]]
name = "flat"
grating = { kind = "flat", period_um = 2.5, pixels = 40 }
[[preset]]
name = "quick"
terms = 2
accept_error = true
wavelengths = { min_nm = 400, max_nm = 700, step_nm = 100 }
[[preset]]
name = "slow"
terms = 8
accept_error = true
wavelengths = { min_nm = 400, max_nm = 700, step_nm = 50 }
[[preset]]
name = "gems"
mode = "gems"
"#;

/// Measures as little as there can be.
fn bench(folder: &Path, args: &[&str]) -> Output {
    against("slow", folder, args)
}

fn against(baseline: &str, folder: &Path, args: &[&str]) -> Output {
    let fixed = ["bench", "--size", "8", "--seconds", "0", "--baseline", baseline];
    run(folder, &[&fixed[..], args].concat())
}

fn folder() -> tempfile::TempDir {
    folder_with(PLAN)
}

fn benches(records: &[Record]) -> Vec<&Bench> {
    records
        .iter()
        .filter_map(|r| if let Record::Bench(bench) = r { Some(bench) } else { None })
        .collect()
}

#[test]
fn results_are_appended_and_what_cannot_be_built_is_a_gap() {
    let folder = folder();
    let args = ["--variant", "quick", "gems", "--empty", "--out", "out", "--json"];
    let done = bench(folder.path(), &args);
    if without_driver(&done) {
        return;
    }
    let text = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(1), "gems failed: {text}");
    assert!(text.contains("a flat surface has no period"), "{text}");
    let records = results::read(&folder.path().join("out/records.jsonl")).unwrap();
    let stdout = String::from_utf8(done.stdout).unwrap();
    assert_eq!(
        stdout,
        records.iter().map(|r| results::line(r).expect("finite")).collect::<String>()
    );
    let gaps = records.iter().filter(|r| match r {
        Record::Gap(gap) => gap.failed && gap.variant.as_deref() == Some("gems"),
        _ => false,
    });
    let benches = benches(&records);
    assert_eq!(gaps.count() * 3, benches.len(), "on each adapter the baseline, quick and empty");
    for group in benches.chunks(3) {
        let names: Vec<&str> = group.iter().map(|b| b.variant.as_str()).collect();
        assert_eq!(names, ["slow", "quick", "empty"]);
        assert!(group.iter().all(|b| b.median_ms > 0.0 && b.baseline.as_deref() == Some("slow")));
        assert!(group.iter().all(|b| ["timestamps", "wall"].contains(&b.clock.as_str())));
    }
    // a second run adds to the first
    bench(folder.path(), &args);
    let again = results::read(&folder.path().join("out/records.jsonl")).unwrap();
    assert_eq!((again.len(), &again[..records.len()]), (2 * records.len(), &records[..]));
}

#[test]
fn kept_results_are_compared_with() {
    let folder = folder();
    let done = bench(folder.path(), &["--variant", "quick", "--save", "before"]);
    if without_driver(&done) {
        return;
    }
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let table = String::from_utf8(done.stdout).unwrap();
    assert!(table.contains("ratio = slow / this") && !table.contains("since"), "{table}");
    let kept = results::read(&folder.path().join("target/bench/before.jsonl")).unwrap();
    assert!(benches(&kept).iter().any(|b| b.variant == "quick"));
    let done = bench(folder.path(), &["--variant", "quick", "--compare-to", "before"]);
    let table = String::from_utf8(done.stdout).unwrap();
    assert!(table.contains("since") && table.contains("×") && !table.contains("new"), "{table}");
    let done = bench(folder.path(), &["--variant", "quick", "--compare-to", "never"]);
    assert_eq!(done.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&done.stderr).contains("make it with --save never"));
}

#[test]
fn scaling_varies_what_the_mode_reads() {
    let folder = folder();
    let done = bench(folder.path(), &["--variant", "quick", "--scaling", "--out", "out"]);
    if without_driver(&done) {
        return;
    }
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let table = String::from_utf8(done.stdout).unwrap();
    assert!(table.contains("time grows like terms^"), "{table}");
    let records = results::read(&folder.path().join("out/records.jsonl")).unwrap();
    let values = |axis: &str| -> Vec<f64> {
        let of_axis = |r: &Record| match r {
            Record::Scaling(s) if s.axis == axis => Some(s.value),
            _ => None,
        };
        records.iter().filter_map(of_axis).take(4).collect()
    };
    assert_eq!(values("terms"), [4.0, 8.0, 16.0, 32.0]);
    assert_eq!(values("radius"), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(values("wavelengths"), [11.0, 21.0, 41.0, 81.0]);
    assert_eq!(values("pixels").len(), 4);
}

#[test]
fn an_unknown_baseline_or_adapter_is_a_usage_error() {
    let folder = folder();
    let done = against("slwo", folder.path(), &[]);
    let text = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{text}");
    assert!(text.contains("slow"), "the nearest name: {text}");
    let done = bench(folder.path(), &["--adapter", "no such adapter"]);
    let text = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{text}");
    assert!(text.contains("no adapter whose name contains 'no such adapter'"), "{text}");
}
