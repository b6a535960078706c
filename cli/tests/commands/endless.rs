//! Inputs that never begin or never end are refused at once.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const PLAN: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 40 }
[variants]
terms = [12]
"#;

/// Exit code and stderr. A command that hangs fails.
fn said(folder: &Path, line: &str) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction"));
    command.env("XDG_CACHE_HOME", folder.join("cache")).args(line.split(' ')).current_dir(folder);
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > Duration::from_secs(30) {
            let _ = child.kill();
            panic!("{line}: hangs");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let done = child.wait_with_output().unwrap();
    (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn pipes_devices_and_endless_files_are_refused_wherever_a_file_is_read() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let put = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    put("plan.toml", PLAN);
    put("d.csv", "theta_i,phi_i,theta_r,phi_r\n20,0,20,180\n");
    pipe(&folder.join("pipe"));
    symlink("/dev/zero", folder.join("zero")).unwrap();
    fs::File::create(folder.join("huge")).unwrap().set_len(1 << 40).unwrap();
    let scan = |name: &str| {
        put(
            &format!("scan-{name}.toml"),
            &format!(
                "schema = 1\n[[surface]]\nname = \"s\"\nfile = \"{name}.npy\"\npixel_um = 0.05\n"
            ),
        );
        put(
            &format!("light-{name}.toml"),
            &PLAN.replace("[variants]", &format!("[optics]\nilluminant = \"{name}\"\n[variants]")),
        );
        symlink(folder.join(name), folder.join(format!("{name}.npy"))).unwrap();
    };
    for name in ["pipe", "zero", "huge"] {
        scan(name);
        for (line, subject) in [
            (format!("list --plan {name}"), name.to_owned()),
            (format!("eval --surface a --directions {name}"), name.to_owned()),
            (format!("generate --out out --plan scan-{name}.toml"), "surface s".to_owned()),
            (format!("inspect --surface s --plan scan-{name}.toml"), "surface s".to_owned()),
            (format!("list --plan light-{name}.toml"), "illuminant".to_owned()),
        ] {
            let (code, text) = said(folder, &line);
            assert_eq!(code, Some(2), "{line}: {text}");
            assert!(text.contains(&subject), "{line}: {text}");
        }
        // an output folder whose manifest leads there
        let out = format!("out-{name}");
        fs::create_dir(folder.join(&out)).unwrap();
        symlink(folder.join(name), folder.join(&out).join("manifest.json")).unwrap();
        for line in [format!("generate --out {out}"), format!("generate --check --out {out}")] {
            let (code, text) = said(folder, &line);
            assert_eq!(code, Some(2), "{line}: {text}");
            assert!(text.contains("neither empty nor a package"), "{line}: {text}");
        }
    }
    // the control: the same commands on files
    for line in ["list", "eval --surface a --directions d.csv", "generate --out fine"] {
        let (code, text) = said(folder, line);
        assert_eq!(code, Some(0), "{line}: {text}");
    }
    // a file of the package that became a pipe: the next run makes the package anew
    let shader = folder.join("fine/README.md");
    fs::remove_file(&shader).unwrap();
    pipe(&shader);
    let (code, text) = said(folder, "generate --check --out fine");
    assert_eq!(code, Some(1), "{text}");
}
