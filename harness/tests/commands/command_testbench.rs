//! `diffraction-harness testbench` as a user runs it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const PLAN: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.25, pixels = 40 }
[[surface]]
name = "flat"
grating = { kind = "flat", period_um = 2.5, pixels = 40 }
[[surface]]
name = "rough"
grating = { kind = "fingers", size_um = 24.2, pixels = 400, pitch_um = 1.1, height_um = 0.2, seed = 1 }
[variants]
mode = ["full", "adaptive", "gems"]
terms = [19]
[[preset]]
name = "blue"
mode = "full"
wavelengths = { min_nm = 400, max_nm = 500, step_nm = 5 }
"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
    folder
}

fn testbench(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.arg("testbench").args(args).current_dir(folder).output().unwrap()
}

fn lines(output: &Output) -> Vec<Value> {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn every_variant_is_measured_or_said_not_to_apply() {
    let done = testbench(folder().path(), &["--surface", "a", "--json"]);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let lines = lines(&done);
    let of = |kind: &str, key: &str| -> Vec<&str> {
        let of_kind = lines.iter().filter(|line| line["kind"] == kind);
        of_kind.map(|line| line[key].as_str().unwrap()).collect()
    };
    assert_eq!(of("testbench", "variant"), ["exact", "full-taylor-t19", "adaptive-taylor-t19"]);
    assert_eq!(of("testbench", "route"), ["exact", "twin", "twin"]);
    assert_eq!(of("gap", "variant"), ["gems", "blue"]);
    assert!(of("gap", "reason").iter().all(|reason| reason.starts_with("not applicable: ")));
    for line in lines.iter().filter(|line| line["kind"] == "testbench") {
        assert_eq!((&line["surface"], &line["theta_i"]), (&"a".into(), &75.0.into()));
        assert_eq!((&line["points"], &line["window"]), (&81.into(), &Value::Null));
        let number = |value: &Value| value.as_f64().unwrap();
        let [period, sd] = [&line["period_nm"], &line["sd_nm"]].map(number);
        assert!((period - number(&line["closed_nm"][0])).abs() < 0.02, "{line}");
        assert!((sd - number(&line["closed_nm"][1])).abs() < 0.02 && sd > 0.05, "{line}");
    }
}

#[test]
fn people_get_a_table_and_files_get_names() {
    let folder = folder();
    let args =
        ["--surface", "a", "--wavelengths", "500,600,50", "--svg", "a.svg", "--csv", "a.csv"];
    let one = testbench(folder.path(), &[&args[..], &["--variant", "exact"]].concat());
    assert_eq!((one.status.code(), one.stderr.len()), (Some(0), 0), "{one:?}");
    let text = String::from_utf8(one.stdout).unwrap();
    for part in ["θi 75°", "500 to 600 nm by 50", "2500.000 nm", "closed form nm", "exact  "] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("a.svg").starts_with("<svg") && read("a.svg").contains("wavelength, nm"));
    assert!(read("a.csv").starts_with("wavelength_nm,theta_r_deg,response\n500.0,-8"));
    let all = testbench(folder.path(), &args);
    assert_eq!(all.status.code(), Some(0), "{all:?}");
    assert_eq!(read("a.csv"), read("a-exact.csv"));
    assert!(read("a-full-taylor-t19.svg").contains("full-taylor-t19"));
}

#[test]
fn windows_are_told_one_by_one_and_together() {
    let args =
        ["--surface", "rough", "--variant", "full-taylor-t19", "--wavelengths", "400,700,100"];
    let windows = ["--windows", "4", "--window-um", "6", "--json"];
    let done = testbench(folder().path(), &[&args[..], &windows].concat());
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let lines = lines(&done);
    let places: Vec<&Value> = lines.iter().map(|line| &line["window"]).collect();
    assert_eq!(lines.len(), 5);
    assert_eq!(places[0], &serde_json::json!([0, 0, 99, 99]));
    assert_eq!(places[3], &serde_json::json!([301, 301, 99, 99]));
    assert_eq!((places[4], &lines[4]["windows"][0]), (&Value::Null, &4.into()));
    let periods: Vec<f64> = lines.iter().map(|line| line["period_nm"].as_f64().unwrap()).collect();
    let ends = periods[..4].iter().fold((f64::MAX, 0.0_f64), |e, p| (e.0.min(*p), e.1.max(*p)));
    assert!(ends.0 <= periods[4] && periods[4] <= ends.1, "{periods:?}");
}

#[test]
fn what_cannot_be_measured_is_exit_code_two() {
    let folder = folder();
    let fails = |args: &[&str], part: &str| {
        let done = testbench(folder.path(), args);
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{message}");
        assert!(message.contains("error: ") && message.contains(part), "{message}");
    };
    fails(&["--surface", "a", "--variant", "gems"], "gems has no wavelength axis");
    fails(&["--surface", "a", "--variant", "blue"], "--wavelengths 400,500,5");
    fails(&["--surface", "rough", "--variant", "adaptive-taylor-t19"], "overlap");
    fails(&["--surface", "b"], "surface \"b\": is not in the plan");
    fails(&["--surface", "a", "--variant", "b"], "is not in the plan");
    fails(&["--surface", "flat"], "--period-nm");
    fails(
        &["--surface", "flat", "--period-nm", "2500", "--variant", "exact"],
        "no period was found",
    );
    fails(
        &[
            "--surface",
            "a",
            "--wavelengths",
            "360,780,5",
            "--variant",
            "exact",
            "--windows",
            "4",
            "--window-um",
            "9",
        ],
        "--window-um",
    );
    fails(&["--surface", "a", "--theta-i", "90"], "at least 0 and below 90");
    fails(&["--surface", "a", "--window-um", "3"], "--windows");
}
