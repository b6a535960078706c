//! Memory is stated before it is taken, and refused above a budget.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const PLAN: &str = r#"schema = 1
[[surface]]
name = "scan"
file = "scan.npy"
pixel_um = 0.095
[[preset]]
name = "full"
[[preset]]
name = "order-sum"
mode = "gems"
[[preset]]
name = "baked"
mode = "baked"
accept_error = true
bake_mib = 4
[targets]
emit = ["wgsl"]
"#;

/// A folder with a plan and a scan of `side`² pixels.
fn folder(side: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({side}, {side}), }}");
    let header = format!("{header:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(header.as_bytes());
    let wave = |turns: usize, i: usize| {
        (turns as f32 * i as f32 / side as f32 * std::f32::consts::TAU).sin()
    };
    for y in 0..side {
        for x in 0..side {
            bytes.extend((0.06 * wave(29, x) + 0.04 * wave(17, y) * wave(5, x)).to_le_bytes());
        }
    }
    fs::write(folder.path().join("scan.npy"), bytes).unwrap();
    fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
    folder
}

fn diffraction(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction"));
    command.env("XDG_CACHE_HOME", folder.join("cache")).args(line.split(' '));
    command.current_dir(folder).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The estimates of `list`, in bytes, by the names of variants.
fn estimates(folder: &Path) -> Vec<(String, u64)> {
    let done = diffraction(folder, "list --json");
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let list: Value = serde_json::from_slice(&done.stdout).unwrap();
    let of = |v: &Value| {
        (
            v["name"].as_str().unwrap().to_owned(),
            v["cost"][0]["peak_memory_bytes"].as_u64().unwrap(),
        )
    };
    list["variants"].as_array().unwrap().iter().map(of).collect()
}

#[test]
fn above_the_budget_is_refused_with_all_that_is_needed_to_decide() {
    let folder = folder(200);
    let (name, bytes) = estimates(folder.path()).swap_remove(0);
    let gib = bytes as f64 / f64::from(1 << 30);
    let (below, above) = (0.9 * gib, 1.1 * gib);
    let line = format!("generate --out out --variant {name} --memory-gib");
    let done = diffraction(folder.path(), &format!("{line} {below:.6}"));
    assert_eq!(done.status.code(), Some(2), "{}", said(&done));
    for part in [
        "surface scan: variant full".to_owned(),
        format!("needs about {gib:.2} GiB of memory"),
        format!("above the budget of {below:.2} GiB"),
        "resample_um".to_owned(),
        "--memory-gib".to_owned(),
    ] {
        assert!(said(&done).contains(&part), "{part}: {}", said(&done));
    }
    assert!(!folder.path().join("out").exists(), "nothing is written");
    // the control
    let done = diffraction(folder.path(), &format!("{line} {above:.6}"));
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    // the list is still printed
    let done = diffraction(folder.path(), "list --memory-gib 0.0001");
    assert_eq!(done.status.code(), Some(2), "{}", said(&done));
    assert!(String::from_utf8_lossy(&done.stdout).contains("GiB"), "{}", said(&done));
    for name in ["full", "order-sum", "baked"] {
        assert!(said(&done).contains(&format!("surface scan: variant {name}: needs")), "{name}");
    }
    for text in ["0", "-1", "nan", "much"] {
        let done = diffraction(folder.path(), &format!("list --memory-gib={text}"));
        assert_eq!(done.status.code(), Some(2), "{text}");
    }
    fs::write(folder.path().join("d.csv"), "theta_i,phi_i,theta_r,phi_r\n20,0,20,180\n").unwrap();
    for line in [
        "eval --surface scan --directions d.csv",
        "eval --surface scan --directions d.csv --variant full --runner twin",
        "render --surface scan --light 20,0 --size 8 --out map.png",
    ] {
        let done = diffraction(folder.path(), &format!("{line} --memory-gib 0.0001"));
        assert_eq!(done.status.code(), Some(2), "{line}: {}", said(&done));
        assert!(said(&done).contains("above the budget"), "{line}: {}", said(&done));
        let done = diffraction(folder.path(), line);
        assert_eq!(done.status.code(), Some(0), "{line}: {}", said(&done));
    }
}

/// The peak of `generate`, as the system counted it, against the estimate. `--jobs` changes neither much, since tables are
/// built one after the other.
#[cfg(target_os = "linux")]
#[test]
fn estimates_are_what_is_taken() {
    let folder = folder(900);
    for (name, bytes) in estimates(folder.path()) {
        for jobs in ["1", "2"] {
            let line = format!(
                "generate --out out-{name}-{jobs} --variant {name} --no-cache --jobs {jobs}"
            );
            let peak = peak(folder.path(), &line);
            let ratio = bytes as f64 / peak as f64;
            println!("{name}, {jobs} jobs: estimate {bytes}, peak {peak}: {ratio:.2}");
            assert!((0.77..1.43).contains(&ratio), "{name}, {jobs} jobs: {bytes} for {peak}");
        }
    }
}

/// The most memory that a run had, in bytes.
#[cfg(target_os = "linux")]
fn peak(folder: &Path, line: &str) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction"));
    command.env("XDG_CACHE_HOME", folder.join("cache")).args(line.split(' ')).current_dir(folder);
    command.stderr(std::process::Stdio::null());
    let mut child = command.spawn().unwrap();
    let mut peak = 0;
    loop {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|l| l.trim().trim_end_matches(" kB").parse::<u64>().ok());
        peak = kib.map_or(peak, |kib| peak.max(1024 * kib));
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{line:?}");
            return peak;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}
