//! Records of every kind, and folders with them.

use std::fs;
use std::path::Path;

use diffraction_harness::results::{FILE, Record, line};
use serde_json::{Value, json};

/// A variant's configuration with one setting changed.
pub fn settings(key: &str, value: Value) -> Value {
    let mut settings =
        json!({"mode": "full", "step_nm": 5.0, "terms": 19, "table": "f32", "coherence_um": 65.0});
    settings[key] = value;
    settings
}

/// A comparison with the exact reference; its pictures lie under `pictures/VARIANT`.
pub fn compare(surface: &str, variant: &str, p95: f64, settings: Value) -> Value {
    let place = |what: &str| format!("pictures/{variant}-{what}.png");
    json!({
        "kind": "compare", "surface": surface, "variant": variant, "route": "vulkan:raster", "reference": "exact",
        "part": "total", "light": [20.0, 0.0], "size": 8, "exposure": 2.5, "lit": 0.25, "max_abs": 0.0123, "rms": 0.00456,
        "de2000": {"mean": 0.111, "p50": 0.0789, "p95": p95, "p99": 3.33, "max": 4.44}, "flip": 0.0555,
        "tolerance": {"max_abs": null, "de2000_p95": 2.0}, "pass": p95 <= 2.0,
        "pictures": [place("exact"), place("map"), place("difference")], "settings": settings,
    })
}

/// A record with other values of some keys.
pub fn with(mut record: Value, changes: &[(&str, Value)]) -> Value {
    for (key, value) in changes {
        record[*key] = value.clone();
    }
    record
}

/// One control, caught or not.
pub fn control(route: &str, caught: bool) -> Value {
    json!({
        "kind": "control", "surface": "blazed-control", "variant": "full", "route": route, "control": "mirrored u",
        "light": [20.0, 10.0], "max_abs": 0.993, "de2000_p95": 91.5, "right_max_abs": 2.6e-6,
        "tolerance": {"max_abs": 2e-5, "de2000_p95": null}, "caught": caught,
    })
}

/// A time.
pub fn bench(variant: &str, median_ms: f64) -> Value {
    json!({
        "kind": "bench", "surface": "blazed", "variant": variant, "backend": "vulkan", "adapter": "raster",
        "light": [20.0, 0.0], "size": 256, "median_ms": median_ms, "mad_ms": 0.1, "interval_ms": [0.9 * median_ms, 1.1 * median_ms],
        "cpu_ms": 24.0, "pipeline_ms": 31.0, "runs": 20, "outliers": 1, "frames_per_run": 3, "clock": "timestamps",
        "ns_per_pixel": 246.0, "table_bytes": 1572864, "baseline": "texts", "ratio": 117.0, "ratio_interval": [112.0, 121.0],
        "settings": settings("terms", json!(19)),
    })
}

/// A time against the number of terms.
pub fn scaling(terms: f64, median_ms: f64) -> Value {
    json!({
        "kind": "scaling", "surface": "blazed", "variant": "full", "backend": "vulkan", "adapter": "raster",
        "axis": "terms", "value": terms, "median_ms": median_ms, "mad_ms": 0.1,
    })
}

/// A period.
pub fn testbench(variant: &str, period_nm: f64) -> Value {
    json!({
        "kind": "testbench", "surface": "blazed", "variant": variant, "route": "twin", "theta_i": 75.0, "phi_i": 0.0,
        "expected_nm": 2500.0, "period_nm": period_nm, "sd_nm": 0.177, "points": 81, "evanescent": 0, "flat": 0,
        "closed_nm": [2500.15, 0.176], "window": null, "windows": null, "weight": 0.4, "svg": null,
    })
}

/// A candidate of a search; without an error it was not measured.
pub fn tune(variant: &str, verdict: &str, p95: Option<f64>, why: &str) -> Value {
    let errors =
        p95.map(|p95| json!({"light": [60.0, 0.0], "p95": p95, "max": 3.21, "map_p95": null}));
    let time = p95.map(|p95| {
        json!({
            "median_ms": 2.5, "mad_ms": 0.1, "ns_per_pixel": 49.5 / p95, "ratio": 417.0, "ratio_interval": [401.0, 433.0],
            "pace": [0.9, 1.1], "runs": 12,
        })
    });
    json!({
        "kind": "tune", "surface": "blazed", "variant": variant, "verdict": verdict, "why": why, "front": verdict == "winner",
        "budget_de": 0.75, "backend": "vulkan", "adapter": "raster", "lights": [[20.0, 0.0], [60.0, 0.0]], "size": 256,
        "fits": "webgl2", "max_table_mib": 4.0, "errors": errors.into_iter().collect::<Vec<_>>(), "far_p95": null, "time": time,
        "fetches": 24.5, "table_bytes": 1572864, "bounds": {"phase": 0.01, "tail": 0.0, "step": 0.0},
        "preset": format!("[[preset]]\nname = \"{variant}\"\n"), "settings": {"mode": "adaptive"},
    })
}

/// A variant that was not taken.
pub fn gap(reason: &str) -> Value {
    json!({"kind": "gap", "route": "webgpu", "surface": null, "variant": null, "reason": reason, "failed": false})
}

/// Writes records as a folder of results.
pub fn write(folder: &Path, records: &[Value]) {
    let record =
        |value: &Value| -> Record { serde_json::from_value(value.clone()).expect("a record") };
    let text: String = records.iter().map(|value| line(&record(value)).expect("finite")).collect();
    fs::write(folder.join(FILE), text).expect("writes");
}

/// Writes the pictures that a comparison names, each of another grey.
pub fn draw(folder: &Path, records: &[Value]) {
    fs::create_dir_all(folder.join("pictures")).expect("folder");
    let places = records.iter().filter_map(|r| r["pictures"].as_array()).flatten();
    for (i, place) in places.enumerate() {
        let grey = image::GrayImage::from_pixel(2, 2, image::Luma([i as u8]));
        grey.save(folder.join(place.as_str().expect("a place"))).expect("writes");
    }
}
