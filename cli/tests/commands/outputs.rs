//! Several runs on one output, outputs that are files of another kind, and a cache that is damaged or absent.
#![cfg(unix)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

use diffraction_shaders::random::SplitMix64;

fn plan(height_um: f64, terms: &str) -> String {
    format!(
        r#"schema = 1
[[surface]]
name = "a"
grating = {{ kind = "blazed", period_um = 2.5, height_um = {height_um}, pixels = 100 }}
[variants]
terms = {terms}
[targets]
emit = ["wgsl"]
"#
    )
}

/// A folder with plans and a folder of caches.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("one.toml"), plan(0.3, "[12]")).unwrap();
    fs::write(folder.path().join("two.toml"), plan(0.25, "[12, 21]")).unwrap();
    folder
}

fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction"));
    command.args(args).current_dir(folder).env("XDG_CACHE_HOME", folder.join("caches"));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(folder: &Path, args: &[&str]) -> Output {
    command(folder, args).output().unwrap()
}

fn done(folder: &Path, args: &[&str]) -> String {
    let output = run(folder, args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", said(&output));
    said(&output)
}

fn refused(folder: &Path, args: &[&str], part: &str) {
    let output = run(folder, args);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {}", said(&output));
    assert!(said(&output).contains(part), "{part:?} is not in: {}", said(&output));
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file below a folder, by its path from there.
fn files(root: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let (mut files, mut folders) = (BTreeMap::new(), vec![root.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.insert(path.strip_prefix(root).unwrap().to_owned(), fs::read(path).unwrap());
            }
        }
    }
    files
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn runs_at_once_on_one_output_end_well_and_one_of_them_is_there() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let expected = ["one.toml", "two.toml"].map(|plan| {
        done(
            folder.path(),
            &["generate", "--no-cache", "--plan", plan, "--out", plan.trim_end_matches(".toml")],
        );
        files(&at(plan.trim_end_matches(".toml")))
    });
    let mut waited = 0;
    for round in 0..6 {
        // absent at first, below a folder that is absent too; then there
        let children: Vec<_> = ["one.toml", "two.toml", "one.toml", "two.toml"]
            .into_iter()
            .map(|plan| {
                let args = ["generate", "--no-cache", "--plan", plan, "--out", "deep/out"];
                command(folder.path(), &args).spawn().unwrap()
            })
            .collect();
        for child in children {
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{round}: {}", said(&output));
            waited += usize::from(said(&output).contains("is in use by another run; waiting"));
        }
        let found = files(&at("deep/out"));
        assert!(expected.contains(&found), "{round}: {:?}", found.keys());
        assert_eq!(names(&at("deep")), BTreeSet::from(["out".to_owned()]));
        if round % 2 == 0 {
            fs::remove_dir_all(at("deep")).unwrap();
        }
    }
    assert!(waited > 0, "none had to wait, so nothing was tried");
}

#[test]
fn two_parts_of_a_plan_at_once_are_both_there() {
    let folder = folder();
    for _ in 0..4 {
        done(folder.path(), &["generate", "--no-cache", "--plan", "two.toml", "--out", "out"]);
        // a part is laid over what is there when its turn comes
        let children: Vec<_> = ["*t12*", "*t21*"]
            .into_iter()
            .map(|variant| {
                let args = [
                    "generate",
                    "--no-cache",
                    "--plan",
                    "two.toml",
                    "--out",
                    "out",
                    "--variant",
                    variant,
                ];
                command(folder.path(), &args).spawn().unwrap()
            })
            .collect();
        for child in children {
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        }
        done(
            folder.path(),
            &["generate", "--no-cache", "--check", "--plan", "two.toml", "--out", "out"],
        );
    }
}

#[test]
fn commands_do_not_take_each_others_folders() {
    let folder = folder();
    done(folder.path(), &["generate", "--plan", "one.toml", "--out", "package"]);
    done(folder.path(), &["inspect", "--plan", "one.toml", "--surface", "a", "--out", "survey"]);
    let before = ["package", "survey"].map(|name| files(&folder.path().join(name)));
    let survey = ["inspect", "--plan", "one.toml", "--surface", "a", "--out", "package"];
    refused(folder.path(), &survey, "was written by another command");
    for more in [&[][..], &["--check"]] {
        let package = ["generate", "--plan", "two.toml", "--out", "survey"];
        refused(folder.path(), &[&package, more].concat(), "was written by another command");
    }
    assert!(before == ["package", "survey"].map(|name| files(&folder.path().join(name))));
    done(folder.path(), &["inspect", "--plan", "two.toml", "--surface", "a", "--out", "survey"]);
}

#[test]
fn the_working_folder_can_be_the_output() {
    let folder = folder();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    let program = env!("CARGO_BIN_EXE_diffraction");
    let script = format!(
        "for plan in one two; do '{program}' generate --no-cache --plan ../$plan.toml --out . || exit; ls; done"
    );
    let output = Command::new("sh").args(["-c", &script]).current_dir(&out).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let listed = String::from_utf8_lossy(&output.stdout).matches("manifest.json").count();
    assert_eq!(listed, 2, "the shell sees what was written");
    done(
        folder.path(),
        &["generate", "--no-cache", "--check", "--plan", "two.toml", "--out", "out"],
    );
}

/// A process number can be guessed, and a link put where the file is to be written at first.
#[test]
fn a_planted_link_is_not_followed() {
    let folder = folder();
    fs::write(folder.path().join("victim"), "mine").unwrap();
    let program = env!("CARGO_BIN_EXE_diffraction");
    let script = format!(
        "for name in map.png.tmp-$$ .map.png.tmp-$$ .diffraction-tmp-$$-0 generated.tmp-$$ generated.tmp-$$.diffraction; do \
         ln -s victim $name; done; exec '{program}' \"$@\""
    );
    for args in [
        &["render", "--plan", "one.toml", "--surface", "a", "--size", "16", "--out", "map.png"][..],
        &["generate", "--no-cache", "--plan", "one.toml"],
    ] {
        let mut sh = Command::new("sh");
        sh.args(["-c", &script, "sh"]).args(args).current_dir(folder.path());
        let output = sh.env("XDG_CACHE_HOME", folder.path().join("caches")).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert_eq!(fs::read(folder.path().join("victim")).unwrap(), b"mine");
        // once more over what is there
        done(folder.path(), args);
    }
    assert!(fs::read(folder.path().join("map.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(folder.path().join("generated/manifest.json").is_file());
}

#[test]
fn a_picture_goes_where_it_can_and_nowhere_else() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let render = |out: &str| {
        let args = ["render", "--plan", "one.toml", "--surface", "a", "--size", "16", "--out", out];
        run(folder.path(), &args)
    };
    let fails = |out: &str, part: &str| {
        let output = render(out);
        assert_eq!(output.status.code(), Some(2), "{out}: {}", said(&output));
        assert!(said(&output).contains(part), "{out}: {}", said(&output));
    };
    fs::create_dir(at("folder.png")).unwrap();
    fails("folder.png", "is a folder");
    fs::write(at("kept.png"), "mine").unwrap();
    fs::set_permissions(at("kept.png"), fs::Permissions::from_mode(0o444)).unwrap();
    fails("kept.png", "is read-only");
    symlink("absent", at("nowhere.png")).unwrap();
    fails("nowhere.png", "does not exist");
    assert!(Command::new("mkfifo").arg(at("pipe.png")).status().unwrap().success());
    fails("pipe.png", "nobody reads");
    symlink("/dev/null", at("null.png")).unwrap();
    assert_eq!(render("null.png").status.code(), Some(0));
    symlink("/dev/stdout", at("stdout.png")).unwrap();
    assert!(render("stdout.png").stdout.starts_with(b"\x89PNG"));
    fs::write(at("real"), "old").unwrap();
    symlink("real", at("link.png")).unwrap();
    assert_eq!(render("link.png").status.code(), Some(0));
    assert!(fs::symlink_metadata(at("link.png")).unwrap().is_symlink());
    assert!(fs::read(at("real")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(fs::read(at("kept.png")).unwrap(), b"mine");
    assert!(
        names(folder.path()).iter().all(|name| !name.contains("tmp")),
        "{:?}",
        names(folder.path())
    );
}

/// Damages every file of a real cache in turn. No damage gets into a package or stops a run.
#[test]
fn a_damaged_cache_gives_the_same_package() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let generate = |more: &[&str]| {
        let args = ["generate", "--plan", "two.toml", "--out", "out"];
        done(folder.path(), &[&args, more].concat())
    };
    generate(&[]);
    let expected = files(&at("out"));
    let caches = at("caches/diffraction-shaders");
    let entries: Vec<PathBuf> = files(&caches).into_keys().map(|path| caches.join(path)).collect();
    assert!(entries.len() >= 9, "tables, probes, their hashes and a stamp: {entries:?}");
    let mut random = SplitMix64::new(7);
    for round in 0..20 {
        for path in &entries {
            assert!(path.is_file(), "round {round}: {} was not made anew", path.display());
            let bytes = fs::read(path).unwrap();
            let place = (random.share() * bytes.len() as f64) as usize;
            let damaged = match (round + place) % 8 {
                0 => bytes[..place].to_vec(),
                1 => Vec::new(),
                2 => [bytes, b"more".to_vec()].concat(),
                3 => vec![0; bytes.len()],
                4 => {
                    fs::remove_file(path).unwrap();
                    continue;
                }
                5 => {
                    fs::remove_file(path).unwrap();
                    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
                    continue;
                }
                6 => {
                    let other = &entries[place % entries.len()];
                    if other.is_file() { fs::read(other).unwrap() } else { Vec::new() }
                }
                _ => {
                    let mut flipped = bytes;
                    if let Some(byte) = flipped.get_mut(place) {
                        *byte ^= 1 << (place % 8);
                    }
                    flipped
                }
            };
            fs::write(path, damaged).unwrap();
        }
        fs::remove_dir_all(at("out")).unwrap();
        generate(&[]);
        assert!(files(&at("out")) == expected, "round {round}");
        generate(&["--check"]);
    }
}

/// A folder of caches that cannot be made costs time only. Without a cache nothing is looked for there.
#[test]
fn a_cache_that_takes_nothing_is_a_note() {
    let folder = folder();
    fs::write(folder.path().join("caches"), "not a folder").unwrap();
    let generate = ["generate", "--plan", "one.toml", "--out", "out"];
    let text = done(folder.path(), &generate);
    assert!(text.contains("note: the cache takes nothing"), "{text}");
    let text = done(folder.path(), &[&generate[..], &["--no-cache"]].concat());
    assert!(!text.contains("cache"), "{text}");
    let text = done(folder.path(), &[&generate[..], &["--check"]].concat());
    assert!(text.contains("note: the cache takes nothing"), "{text}");
    assert_eq!(fs::read(folder.path().join("caches")).unwrap(), b"not a folder");
}

/// Killed or not, a run without the cache leaves nothing in any folder but the output's.
#[test]
fn without_the_cache_nothing_is_left_elsewhere() {
    let folder = folder();
    let places = ["caches", "temporary"].map(|name| folder.path().join(name));
    places.iter().for_each(|place| fs::create_dir(place).unwrap());
    let is_empty = || places.iter().all(|place| names(place).is_empty());
    for wait in 0..12 {
        let args = ["generate", "--no-cache", "--plan", "two.toml", "--out", "out"];
        let mut child = command(folder.path(), &args).env("TMPDIR", &places[1]).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(3 * wait));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(is_empty(), "{:?}", places.each_ref().map(|place| names(place)));
    }
    done(folder.path(), &["generate", "--no-cache", "--plan", "two.toml", "--out", "out"]);
    assert!(is_empty());
}

/// The package is of the one scan or of the other, with its hash, whenever the file is replaced.
#[test]
fn a_scan_that_is_replaced_during_a_run_is_used_as_it_was_read() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let scan = |phase: usize| -> String {
        let row = |y: usize| {
            let height = |x: usize| format!("{:.4}", 0.02 * (((x * (phase + 2) + y) % 7) as f64));
            (0..64).map(height).collect::<Vec<_>>().join(",") + "\n"
        };
        (0..64).map(row).collect()
    };
    let text = "schema = 1\n[[surface]]\nname = \"s\"\nfile = \"scan.csv\"\nsize_um = 5.12\n[variants]\nterms = [12]\n\
                accept_error = [true]\n[targets]\nemit = [\"wgsl\"]\n";
    fs::write(at("plan.toml"), text).unwrap();
    let expected = [0, 1].map(|phase| {
        fs::write(at("scan.csv"), scan(phase)).unwrap();
        done(folder.path(), &["generate", "--no-cache", "--plan", "plan.toml", "--out", "out"]);
        files(&at("out"))
    });
    assert!(expected[0] != expected[1]);
    let is_over = AtomicBool::new(false);
    let mut seen = BTreeSet::new();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut phase = 0;
            while !is_over.load(Ordering::Relaxed) {
                phase = 1 - phase;
                fs::write(at("new.csv"), scan(phase)).unwrap();
                fs::rename(at("new.csv"), at("scan.csv")).unwrap();
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
        });
        for round in 0..30 {
            let caches = if round % 2 == 0 { &["--no-cache"][..] } else { &[] };
            let args = [&["generate", "--plan", "plan.toml", "--out", "out"][..], caches].concat();
            done(folder.path(), &args);
            let found = files(&at("out"));
            seen.insert(
                expected.iter().position(|one| *one == found).expect("one scan throughout"),
            );
        }
        is_over.store(true, Ordering::Relaxed);
    });
    assert_eq!(seen.len(), 2, "both scans were met");
}

/// Nothing of where, when and how a run is made comes into a package.
#[test]
fn a_package_is_the_same_whatever_the_run_is_like() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    done(folder.path(), &["generate", "--plan", "two.toml", "--out", "out"]);
    let expected = files(&at("out"));
    let program = env!("CARGO_BIN_EXE_diffraction");
    for (number, (shell, more)) in [
        ("umask 077; LC_ALL=tr_TR.UTF-8 TZ=Pacific/Kiritimati", "--jobs 1"),
        ("umask 000; LC_ALL=C LANG=de_DE", "--jobs 3 --no-cache"),
        ("umask 022; TMPDIR=absent", "--jobs 2 --no-cache"),
        ("umask 0277;", "--no-cache"),
    ]
    .into_iter()
    .enumerate()
    {
        let script =
            format!("{shell} '{program}' generate --plan two.toml --out out{number} {more}");
        let mut sh = Command::new("sh");
        sh.args(["-c", &script]).current_dir(folder.path()).env("XDG_CACHE_HOME", at("caches"));
        let output = sh.output().unwrap();
        // a mask that takes the owner's own right to write lets only root go on
        if output.status.code() == Some(2) && shell.contains("0277") {
            assert!(said(&output).contains("ermission denied"), "{}", said(&output));
            continue;
        }
        assert_eq!(output.status.code(), Some(0), "{script}: {}", said(&output));
        assert!(files(&at(&format!("out{number}"))) == expected, "{script}");
    }
}
