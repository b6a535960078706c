//! `cargo xtask compare` from the outside: records, resuming, what it refuses.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

const PLAN: &str = r#"schema = 1
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 60 }
[variants]
mode = ["full", "adaptive"]
terms = [19]
"#;

fn folder(plan: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    folder
}

fn compare(folder: &TempDir, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.current_dir(folder.path()).arg("compare").args(arguments);
    command.args(["--size", "16", "--out", "out"]).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn records(folder: &TempDir, name: &str) -> Vec<Value> {
    let text = fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn records_are_those_of_the_interface_and_survive_an_interruption() {
    let folder = folder(PLAN);
    let first = compare(&folder, &["--route", "twin", "--json"]);
    assert_eq!(code(&first), 0, "{}", message(&first));
    let all = records(&folder, "records.jsonl");
    let printed = String::from_utf8(first.stdout).unwrap();
    assert_eq!(printed.lines().count(), all.len());
    // model, packing and total of two variants
    assert_eq!(all.len(), 6);
    for record in &all {
        for key in ["kind", "surface", "variant", "route", "reference", "light", "size", "exposure"]
            .iter()
            .chain(&["lit", "max_abs", "rms", "de2000", "flip", "pass"])
        {
            assert!(!record[key].is_null() || *key == "flip", "{key}: {record}");
        }
        for key in ["mean", "p50", "p95", "p99", "max"] {
            assert!(record["de2000"][key].is_number(), "{record}");
        }
    }
    let drawn = all.iter().filter_map(|r| r["pictures"].as_array()).flatten();
    for place in drawn {
        assert!(folder.path().join("out").join(place.as_str().unwrap()).is_file(), "{place}");
    }

    // cut in the middle of the second variant's second record
    let file = folder.path().join("out/records.jsonl");
    let text = fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    fs::write(&file, lines[..4].join("\n") + "\n" + &lines[4][..30]).unwrap();
    let resumed = compare(&folder, &["--route", "twin", "--resume"]);
    assert_eq!(code(&resumed), 0, "{}", message(&resumed));
    let after = records(&folder, "records.jsonl");
    assert_eq!(after[..4], all[..4], "what was measured is lost");
    // the second variant is whole again
    assert_eq!(after.len(), 4 + 3);
    let again = compare(&folder, &["--route", "twin", "--resume"]);
    assert_eq!(code(&again), 0, "{}", message(&again));
    assert_eq!(records(&folder, "records.jsonl").len(), 7, "measured what was known");

    let anew = compare(&folder, &["--route", "twin"]);
    assert_eq!(code(&anew), 0, "{}", message(&anew));
    assert_eq!(records(&folder, "records.jsonl").len(), 6);
    assert_eq!(records(&folder, "records.old.jsonl").len(), 7, "the last run's are gone");
    assert!(String::from_utf8_lossy(&anew.stdout).contains("6 comparisons, 0 outside"));
}

#[test]
fn what_cannot_be_compared_is_exit_2_and_says_why() {
    let folder = folder(PLAN);
    for (arguments, wanted) in [
        (vec!["--route", "direct"], "route direct"),
        (vec!["--route", "vulkan:no such adapter"], "no such adapter"),
        (vec!["--surface", "blaze"], "did you mean \"blazed\""),
        (vec!["--variant", "fool-*"], "fool-*"),
        (vec!["--size", "0"], "0 is not in"),
        (vec!["--light", "90,0"], "THETA"),
    ] {
        let output = compare(&folder, &arguments);
        assert_eq!(code(&output), 2, "{arguments:?}: {}", message(&output));
        assert!(message(&output).contains(wanted), "{arguments:?}: {}", message(&output));
    }
    assert!(!Path::new(&folder.path().join("out/records.jsonl")).exists());
}

/// The second waits for the first, with a word, and then goes on from what is there.
#[test]
fn two_runs_into_one_folder_lose_nothing() {
    let folder = folder(PLAN);
    let both = |more: &[&str]| {
        let children = ["full*", "adaptive*"].map(|variant| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
            command.current_dir(folder.path()).args(["compare", "--route", "twin", "--size", "16"]);
            command.args(["--out", "out", "--variant", variant]).args(more);
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        });
        let outputs = children.map(|child| child.wait_with_output().unwrap());
        outputs.iter().for_each(|output| assert_eq!(code(output), 0, "{}", message(output)));
        let waits =
            |output: &&Output| message(output).contains("is in use by another run; waiting");
        assert_eq!(outputs.iter().filter(waits).count(), 1, "{outputs:?}");
    };
    both(&["--resume"]);
    let all = records(&folder, "records.jsonl");
    assert_eq!(all.len(), 6, "three of each variant: {all:?}");
    // without it, the first begins anew, and the second keeps what the first has written
    both(&[]);
    let (new, old) = (records(&folder, "records.jsonl"), records(&folder, "records.old.jsonl"));
    assert_eq!((new.len(), old.len()), (6, 6));
    assert_ne!(new[0]["variant"], new[5]["variant"]);
    let alone = compare(&folder, &["--route", "twin", "--variant", "full*"]);
    assert_eq!((code(&alone), records(&folder, "records.jsonl").len()), (0, 3), "as ever");
}
