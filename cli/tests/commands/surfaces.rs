//! Surfaces with optics of their own, and presets of some surfaces, in the commands that a user runs.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const GRATING: &str =
    "grating = { kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 100 }";
const REST: &str = r#"[[preset]]
name = "sum"
terms = 14
[[preset]]
name = "foil"
surfaces = ["card"]
terms = 13
[[preset]]
name = "copies"
mode = "pq"
terms = 14
"#;

fn diffraction(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffraction"))
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// A plan of the surfaces `a` and `card`, the second with optics of its own.
fn folder(own: &str, optics: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
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
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    let directions = "theta_i,phi_i,theta_r,phi_r\n20,0,20,180\n20,0,50,180\n";
    fs::write(folder.path().join("directions.csv"), directions).unwrap();
    folder
}

fn stdout(folder: &tempfile::TempDir, args: &[&str]) -> String {
    let done = diffraction(folder.path(), args);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

const OWN: &str = "optics = { refractive_index = 1.8, coherence_um = 20 }";
const SAME: &str = "[optics]\nrefractive_index = 1.8\ncoherence_um = 20";

#[test]
fn commands_of_one_surface_take_its_optics() {
    let (own, same, plain) = (folder(OWN, ""), folder("", SAME), folder("", ""));
    let exact = ["eval", "--directions", "directions.csv", "--surface"];
    let twin = [
        "eval",
        "--runner",
        "twin",
        "--variant",
        "sum",
        "--directions",
        "directions.csv",
        "--surface",
    ];
    let explain = ["explain", "sum", "--surface"];
    let inspect = ["inspect", "--surface"];
    for args in [exact.as_slice(), &twin, &explain, &inspect] {
        let on = |folder, surface| stdout(folder, &[args, &[surface]].concat());
        assert_eq!(on(&own, "card"), on(&same, "card"), "{args:?}");
        assert_eq!(on(&own, "a"), on(&plain, "a"), "{args:?}");
        assert_ne!(on(&own, "card"), on(&plain, "card"), "{args:?}");
    }
}

#[test]
fn a_preset_is_not_found_on_other_surfaces() {
    let own = folder(OWN, "");
    let eval = [
        "eval",
        "--runner",
        "twin",
        "--variant",
        "foil",
        "--directions",
        "directions.csv",
        "--surface",
    ];
    stdout(&own, &[eval.as_slice(), &["card"]].concat());
    for args in [[eval.as_slice(), &["a"]].concat(), vec!["explain", "foil", "--surface", "a"]] {
        let done = diffraction(own.path(), &args);
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0), "{message}");
        assert!(message.contains("\"foil\": is not for surface \"a\""), "{message}");
    }
    // without a surface the first that it is for
    assert!(stdout(&own, &["explain", "foil"]).contains("REFRACTIVE_INDEX: f32 = 1.8"));
}

#[test]
fn the_list_has_what_surfaces_change() {
    let own = folder(OWN, "");
    let list: Value = serde_json::from_str(&stdout(&own, &["list", "--json"])).unwrap();
    assert_eq!(
        list["surfaces"][1]["optics"],
        serde_json::json!({ "refractive_index": 1.8, "coherence_um": 20.0 })
    );
    assert!(list["surfaces"][0].get("optics").is_none());
    let variant = |name: &str| {
        let all = list["variants"].as_array().unwrap();
        all.iter().find(|variant| variant["name"] == name).unwrap().clone()
    };
    let sum = variant("sum");
    assert_eq!(sum["cost"].as_array().unwrap().len(), 2);
    assert!(sum["cost"][0].get("configuration").is_none() && sum.get("surfaces").is_none());
    assert_eq!(sum["cost"][1]["configuration"]["refractive_index"], 1.8);
    assert_ne!(sum["cost"][1]["hash"], sum["hash"]);
    let foil = variant("foil");
    assert_eq!(foil["surfaces"], serde_json::json!(["card"]));
    assert_eq!(foil["cost"].as_array().unwrap().len(), 1);
    let text = stdout(&own, &["list"]);
    for part in ["blazed, 2.5 µm, coherence_um 20, refractive_index 1.8", "on card only"] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn what_cannot_be_on_a_surface_is_a_note_and_the_rest_is_listed() {
    let own = folder("optics = { coherence = \"ensemble\" }", "");
    let done = diffraction(own.path(), &["list", "--json"]);
    let message = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(0), "{message}");
    assert!(message.contains("card: left out: copies: pq repeats the patch"), "{message}");
    let list: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(list["variants"][2]["cost"].as_array().unwrap().len(), 1);
}
