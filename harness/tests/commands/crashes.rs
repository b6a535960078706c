//! Drivers that crash: a layer of Vulkan that ends the process in the middle of a run, and a driver that ends it when it is loaded.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use diffraction_harness::drivers::gpu::{Backend, Gpu};
use diffraction_harness::process::on_path;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::tools;

const PLAN: &str = r#"schema = 1
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 60 }
[variants]
mode = ["full", "adaptive"]
terms = [19]
"#;

/// A folder with a plan; `None` if a tool is missing.
fn folder() -> Option<TempDir> {
    for backend in [Backend::Vulkan, Backend::Gl] {
        tools::found(Gpu::open(backend, None))?;
    }
    tools::found(on_path("gcc").ok_or("gcc is not installed"))?;
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
    Some(folder)
}

fn built(folder: &Path, source: &str, library: &str) {
    fs::write(folder.join("source.c"), source).unwrap();
    let mut gcc = Command::new("gcc");
    gcc.args(["-shared", "-fPIC", "-O1", "-w", "-o", library, "source.c"]).current_dir(folder);
    let done = gcc.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// The environment with a layer that crashes in submission `at`.
fn layer(folder: &Path, at: u32) -> Vec<(&'static str, String)> {
    built(folder, include_str!("crash_layer.c"), "liblayer.so");
    let manifest = serde_json::json!({
        "file_format_version": "1.0.0",
        "layer": {
            "name": "VK_LAYER_TEST_crash", "type": "GLOBAL", "library_path": "./liblayer.so",
            "api_version": "1.3.0", "implementation_version": "1", "description": "crashes",
        },
    });
    fs::write(folder.join("layer.json"), manifest.to_string()).unwrap();
    vec![
        ("VK_LAYER_PATH", folder.display().to_string()),
        ("VK_INSTANCE_LAYERS", "VK_LAYER_TEST_crash".to_owned()),
        ("CRASH_AT", at.to_string()),
    ]
}

fn run(folder: &Path, env: &[(&str, String)], line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.current_dir(folder).args(line.split(' '));
    command.envs(env.iter().map(|(key, value)| (key, value))).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn records(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join("out/records.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn of<'a>(records: &'a [Value], kind: &str, route: &str) -> Vec<&'a Value> {
    let is = |r: &&Value| {
        let route_of = r["route"].as_str().or(r["backend"].as_str()).unwrap_or_default();
        r["kind"] == kind && route_of.starts_with(route)
    };
    records.iter().filter(is).collect()
}

fn crashes(records: &[Value]) -> Vec<&Value> {
    let has = |r: &&Value| r["reason"].as_str().is_some_and(|why| why.contains("the driver ended"));
    records.iter().filter(has).collect()
}

const COMPARE: &str = "compare --route vulkan:llvmpipe,gl:llvmpipe --size 16 --out out";

#[test]
fn a_driver_that_crashes_in_a_comparison_costs_its_route() {
    let Some(folder) = folder() else { return };
    let folder = folder.path();
    // after some controls
    let done = run(folder, &layer(folder, 25), COMPARE);
    assert_eq!(done.status.code(), Some(1), "{}", said(&done));
    let all = records(folder);
    let found = crashes(&all);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0]["route"].as_str().unwrap().starts_with("vulkan:"), "{}", found[0]);
    assert!(found[0]["reason"].as_str().unwrap().contains("signal 11, SIGSEGV"), "{}", found[0]);
    assert_eq!(found[0]["failed"], true);
    assert!(!of(&all, "control", "vulkan:").is_empty(), "what was measured before stays");
    assert!(!of(&all, "compare", "gl:").is_empty(), "later routes go on");
    assert_eq!(of(&all, "control", "gl:").len(), 10);
    assert!(said(&done).contains("signal 11, SIGSEGV"), "{}", said(&done));
    // nothing is recorded twice
    let key = |r: &&Value| {
        ["kind", "surface", "variant", "route", "reference", "part", "control"]
            .map(|k| r[k].to_string())
            .join(" ")
    };
    let measured: Vec<String> =
        all.iter().filter(|r| r["kind"] != "gap").collect::<Vec<_>>().iter().map(key).collect();
    let different: BTreeSet<&String> = measured.iter().collect();
    assert_eq!(different.len(), measured.len());
    let printed = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(printed.contains("not run: vulkan:"), "{printed}");
}

/// The control: the same layer, which crashes too late.
#[test]
fn without_a_crash_both_routes_are_compared() {
    let Some(folder) = folder() else { return };
    let folder = folder.path();
    let done = run(folder, &layer(folder, 1_000_000), COMPARE);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let all = records(folder);
    assert!(crashes(&all).is_empty());
    for route in ["vulkan:", "gl:"] {
        assert!(!of(&all, "compare", route).is_empty(), "{route}");
    }
}

#[test]
fn a_driver_that_crashes_in_a_bench_leaves_the_other_adapters() {
    let Some(folder) = folder() else { return };
    let folder = folder.path();
    let line = "bench --adapter llvmpipe --size 16 --seconds 0 --out out";
    let done = run(folder, &layer(folder, 12), line);
    assert_eq!(done.status.code(), Some(1), "{}", said(&done));
    let all = records(folder);
    assert_eq!(crashes(&all).len(), 1);
    assert!(of(&all, "bench", "gl").len() >= 2, "{all:?}");
    let printed = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(printed.contains("adaptive"), "the table has what was measured: {printed}");
}

#[test]
fn a_command_with_one_route_says_what_happened() {
    let Some(folder) = folder() else { return };
    let folder = folder.path();
    fs::write(folder.join("d.csv"), "theta_i,phi_i,theta_r,phi_r\n20,0,20,180\n").unwrap();
    let variant = "full-taylor-t19";
    let line =
        format!("eval --surface blazed --variant {variant} --runner vulkan --directions d.csv");
    let done = run(folder, &layer(folder, 1), &line);
    assert_eq!(done.status.code(), Some(2), "{}", said(&done));
    assert!(
        said(&done).contains("vulkan: the driver ended the program (signal 11, SIGSEGV)"),
        "{}",
        said(&done)
    );
    let fine = run(folder, &layer(folder, 1_000_000), &line);
    assert_eq!(fine.status.code(), Some(0), "{}", said(&fine));
}

/// A driver that aborts when it is loaded takes all adapters of Vulkan out, but not those of GL.
#[test]
fn a_driver_that_cannot_be_loaded_costs_its_kind() {
    let Some(folder) = folder() else { return };
    let folder = folder.path();
    built(
        folder,
        "#include <stdlib.h>\n__attribute__((constructor)) static void loaded(void) { abort(); }\n\
         void *vk_icdGetInstanceProcAddr(void *i, const char *n) { return 0; }\n",
        "libdriver.so",
    );
    let icd = serde_json::json!({
        "file_format_version": "1.0.0",
        "ICD": {"library_path": folder.join("libdriver.so"), "api_version": "1.3.0"},
    });
    fs::write(folder.join("icd.json"), icd.to_string()).unwrap();
    let env = [("VK_DRIVER_FILES", folder.join("icd.json").display().to_string())];
    let line = "compare --route vulkan,spirv,gl:llvmpipe --size 16 --out out";
    let done = run(folder, &env, line);
    assert_eq!(done.status.code(), Some(1), "{}", said(&done));
    let all = records(folder);
    let found = crashes(&all);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0]["reason"].as_str().unwrap().contains("signal 6, SIGABRT"), "{}", found[0]);
    assert!(!of(&all, "compare", "gl:").is_empty());
}
