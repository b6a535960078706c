//! A run that dies, or that cannot write, leaves the previous output whole, and the next run cleans up after it.
//!
//! A binary of its own: it kills processes at moments that other tests beside it would move.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use diffraction_shaders::random::SplitMix64;

/// A plan whose generation takes a while: each of the variants has large tables of its own.
fn plan(height_um: f64, axes: &str) -> String {
    format!(
        r#"schema = 1
[[surface]]
name = "fingers"
grating = {{ kind = "fingers", size_um = 12.5, pixels = 200, pitch_um = 1.1, height_um = {height_um}, seed = 1 }}
[[surface]]
name = "rows"
grating = {{ kind = "rows", size_um = 12.5, pixels = 200, pitch_um = 1.5, height_um = {height_um}, seed = 1 }}
[variants]
{axes}
[targets]
emit = ["wgsl", "spirv"]
"#
    )
}

type Files = BTreeMap<PathBuf, Vec<u8>>;

/// A folder with two plans and the package of the first.
struct Place {
    base: tempfile::TempDir,
    old: Files,
    new: Files,
    /// How long it takes to replace one by the other.
    duration: Duration,
}

impl Place {
    fn new() -> Place {
        let base = tempfile::tempdir().unwrap();
        let put = |name: &str, text: String| fs::write(base.path().join(name), text).unwrap();
        put("old.toml", plan(0.3, "terms = [12, 19]"));
        put("new.toml", plan(0.25, "terms = [12, 21]\nhoist = [true, false]"));
        let empty = (Files::new(), Files::new(), Duration::ZERO);
        let mut place = Place { base, old: empty.0, new: empty.1, duration: empty.2 };
        place.done(&["--plan", "old.toml"]);
        place.old = place.output();
        let start = Instant::now();
        place.done(&["--plan", "new.toml"]);
        place.duration = start.elapsed();
        place.new = place.output();
        assert!(place.old != place.new);
        place.done(&["--plan", "old.toml"]);
        assert!(place.output() == place.old, "the same plan gives the same bytes");
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.base.path().join(name)
    }

    fn generate(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction"));
        command.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
        command.args(["generate", "--no-cache"]).args(args).current_dir(self.base.path());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn done(&self, args: &[&str]) {
        let output = self.generate(args).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", said(&output));
    }

    /// A run that must fail and leave the output as it was.
    fn refused(&self, mut command: Command, part: &str) {
        let before = (self.output(), self.temporary());
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(part), "{part:?} is not in: {}", said(&output));
        assert!(!said(&output).contains("panicked"), "{}", said(&output));
        assert!((self.output(), self.temporary()) == before, "{part}: something is left");
    }

    fn output(&self) -> Files {
        files(&self.path("generated"))
    }

    /// What processes left beside the output.
    fn temporary(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.base.path()).unwrap().map(|entry| entry.unwrap().path());
        entries.filter(|path| path.to_string_lossy().contains("generated.")).collect()
    }

    fn spawn_new(&self) -> Child {
        self.generate(&["--plan", "new.toml"]).spawn().unwrap()
    }

    /// Kills a run, and checks what it left: the old package or the new one, whole, and accepted by `--check`. Then goes
    /// back to the old one.
    fn kill(&self, mut child: Child) -> Killed {
        child.kill().unwrap();
        let status = child.wait().unwrap();
        let output = self.output();
        let plan = match (output == self.old, output == self.new) {
            (true, _) => "old.toml",
            (_, true) => "new.toml",
            _ => panic!("neither the old package nor the new one: {:?}", output.keys()),
        };
        let killed = Killed {
            at_work: status.signal() == Some(9),
            in_writing: !self.temporary().is_empty(),
            exchanged: plan == "new.toml",
        };
        assert!(killed.at_work || status.code() == Some(0), "{status}");
        self.done(&["--plan", plan, "--check"]);
        self.done(&["--plan", "old.toml"]);
        assert!(self.temporary().is_empty(), "the next run cleans up");
        assert!(self.output() == self.old);
        killed
    }
}

/// What a run was doing when it was killed.
#[derive(Debug)]
struct Killed {
    /// It had not ended by itself.
    at_work: bool,
    /// Its temporary folder was there.
    in_writing: bool,
    /// The new package was in place.
    exchanged: bool,
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file below a folder.
fn files(root: &Path) -> Files {
    let mut files = Files::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.insert(path.clone(), fs::read(path).unwrap());
            }
        }
    }
    files
}

#[test]
fn a_run_killed_at_any_moment_leaves_a_whole_package() {
    let place = Place::new();
    assert!(place.duration >= Duration::from_millis(150), "{:?} is too short", place.duration);
    let mut random = SplitMix64::new(0x5eed);
    let mut seen = Vec::new();
    for tenth in 0..10 {
        let child = place.spawn_new();
        sleep(place.duration.mul_f64((f64::from(tenth) + random.share()) / 10.0));
        seen.push(place.kill(child));
    }
    println!("{:?} per run; over the whole run: {seen:?}", place.duration);
    assert!(seen.iter().filter(|killed| killed.at_work).count() >= 3, "{seen:?}");
    assert!(seen.iter().any(|killed| !killed.exchanged), "{seen:?}");
    // and while it writes, exchanges and removes, which is but a part of the run
    seen.clear();
    for fifth in 0..5 {
        let child = place.spawn_new();
        let temporary = place.path(&format!("generated.tmp-{}", child.id()));
        let start = Instant::now();
        while !temporary.exists() && start.elapsed() < 100 * place.duration {
            sleep(Duration::from_micros(200));
        }
        sleep(place.duration.mul_f64(0.05 * f64::from(fifth) * random.share()));
        seen.push(place.kill(child));
    }
    println!("while it writes: {seen:?}");
    assert!(seen.iter().any(|killed| killed.in_writing), "{seen:?}");
}

/// Two runs of two plans at once, both killed: one package, whole. A foreign folder in the output has it written in place,
/// where a killed run may leave a package that is not complete; `--check` says so, and the next run completes it.
#[test]
fn two_runs_at_once_killed_at_any_moment_leave_a_whole_package() {
    let rounds = std::env::var("DIFFRACTION_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(8);
    let place = Place::new();
    let mut random = SplitMix64::new(0x2bad);
    for is_in_place in [false, true] {
        let foreign = place.path("generated/mine/file");
        if is_in_place {
            fs::create_dir(place.path("generated/mine")).unwrap();
            fs::write(&foreign, "mine").unwrap();
        }
        let held = || {
            let mut output = place.output();
            // what a killed run was building, which no package lists
            output.retain(|path, _| !path.to_string_lossy().contains("/.diffraction-new"));
            assert_eq!(output.remove(&foreign).is_some(), is_in_place);
            let found = [("old.toml", &place.old), ("new.toml", &place.new)];
            found.into_iter().find(|(_, files)| **files == output).map(|(plan, _)| plan)
        };
        let (mut old, mut new, mut between) = (0, 0, 0);
        for _ in 0..rounds {
            let plans = ["new.toml", "old.toml"];
            let mut children = plans.map(|plan| place.generate(&["--plan", plan]).spawn().unwrap());
            sleep(place.duration.mul_f64(2.0 * random.share()));
            for child in &mut children {
                child.kill().unwrap();
                child.wait().unwrap();
            }
            let clean = plans.map(|plan| {
                let output = place.generate(&["--plan", plan, "--check"]).output().unwrap();
                assert!(matches!(output.status.code(), Some(0 | 1)), "{}", said(&output));
                output.status.success()
            });
            match held() {
                Some("old.toml") => old += 1,
                Some(_) => new += 1,
                None => between += 1,
            }
            let expected = plans.map(|plan| held() == Some(plan));
            assert_eq!(
                clean, expected,
                "what is called clean is a package, and the other way round"
            );
            assert!(held().is_some() || is_in_place, "an exchange leaves a whole package");
            place.done(&["--plan", "old.toml"]);
            assert_eq!(held(), Some("old.toml"));
            assert!(place.temporary().is_empty(), "the next run cleans up");
        }
        println!(
            "in place: {is_in_place}; of {rounds}: {old} old, {new} new, {between} to complete"
        );
    }
}

#[test]
fn where_nothing_can_be_written_the_previous_output_stays() {
    let place = Place::new();
    let out = |out: &str| place.generate(&["--plan", "new.toml", "--out", out]);
    place.refused(out("old.toml/generated"), "old.toml");
    place.refused(out("old.toml"), "is not a folder");
    if cfg!(target_os = "linux") {
        place.refused(out("/proc/generated"), "/proc/generated");
    }
    // a name so long that none fits for the temporary folder beside it: the package is built inside
    let long = "g".repeat(253);
    fs::rename(place.path("generated"), place.path(&long)).unwrap();
    let done = out(&long).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    fs::rename(place.path(&long), place.path("generated")).unwrap();
    assert!(place.output() == place.new);
}

#[test]
fn on_a_full_disk_the_previous_output_stays() {
    let place = Place::new();
    for kib in [0, 1, 16, 128] {
        let mut command = Command::new("bash");
        let program = env!("CARGO_BIN_EXE_diffraction");
        let script =
            format!("ulimit -f {kib}; exec '{program}' generate --no-cache --plan new.toml");
        command.args(["-c", &script]).current_dir(place.base.path());
        command.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
        place.refused(command, "cannot be written");
    }
    place.done(&["--plan", "new.toml"]);
    assert!(place.output() == place.new, "the next run mends it");
}
