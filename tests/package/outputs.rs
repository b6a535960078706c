//! Outputs of several runs at once, among the files of others, and of runs that were killed.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use diffraction_shaders::disk::{Access, FolderLock};
use diffraction_shaders::package::{self, Cancel, Equality, GENERATED_BY, Output, Package, Report};
use serde_json::{Value, json};

use crate::package::{leftovers, package, text};

/// A package whose files all say which one it is. `a` and `b` have files that the other lacks.
fn lettered(letter: &str) -> Package {
    let mut files: Vec<(String, String)> =
        (0..12).map(|i| (format!("part-{}/file-{i}", i % 4), letter.repeat(5_000))).collect();
    files.push((format!("only-{letter}/deep/file"), letter.to_owned()));
    let files: Vec<(&str, &str)> = files.iter().map(|(p, t)| (p.as_str(), t.as_str())).collect();
    package(&files)
}

/// Whether a folder holds one of the two packages, and nothing else; which.
fn held(out: &Path) -> Option<&'static str> {
    ["a", "b"].into_iter().find(|letter| {
        package::check(&lettered(letter), out).is_ok_and(|report| report == Report::default())
    })
}

#[test]
fn writers_take_turns_and_readers_see_whole_packages() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("deep/out");
    let done = AtomicBool::new(false);
    let (out, done) = (&out, &done);
    let seen = std::thread::scope(|scope| {
        let writers: Vec<_> = ["a", "b", "a", "b"]
            .into_iter()
            .map(|letter| {
                scope.spawn(move || {
                    for _ in 0..12 {
                        let report = package::write(&lettered(letter), out).unwrap();
                        assert_eq!((report.carried, report.left_behind), (vec![], vec![]));
                    }
                })
            })
            .collect();
        let reader = scope.spawn(move || {
            let mut seen = BTreeMap::new();
            while !done.load(Ordering::Relaxed) {
                // readers read together, so that both comparisons are of the same package
                let _lock = FolderLock::take(out, Access::Read, &|_| ()).unwrap();
                if out.exists() && fs::read_dir(out).unwrap().count() > 0 {
                    *seen.entry(held(out).expect("one package, whole")).or_insert(0) += 1;
                }
            }
            seen
        });
        writers.into_iter().for_each(|writer| writer.join().unwrap());
        done.store(true, Ordering::Relaxed);
        reader.join().unwrap()
    });
    println!("{seen:?}");
    assert!(held(out).is_some() && leftovers(out).is_empty());
    // a mixture would be seen
    fs::write(out.join("part-1/file-1"), "c").unwrap();
    assert_eq!(held(out), None);
}

#[test]
fn a_refused_or_cancelled_first_write_leaves_nothing() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("a/b/out");
    let cancel = Cancel::new();
    let output = Output::open(&out, GENERATED_BY, &cancel, &|_| ()).unwrap();
    assert!(out.is_dir(), "it is made, to be locked");
    cancel.cancel();
    cancel.settle(Duration::from_secs(1));
    assert!(!base.path().join("a").exists());
    assert!(output.write(&lettered("a")).unwrap_err().to_string().contains("interrupted"));
    drop(Output::open(&out, GENERATED_BY, &Cancel::new(), &|_| ()).unwrap());
    assert!(!base.path().join("a").exists());
}

/// Folders whose names look like ours, and which are not.
#[test]
fn folders_of_others_beside_the_output_stay() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    let names = ["out.tmp-2024", "out.tmp-1", "out.old-2023", "out.tmp-mine", "other.tmp-7"];
    for name in names {
        fs::create_dir(base.path().join(name)).unwrap();
        fs::write(base.path().join(name).join("half"), "half").unwrap();
    }
    // a file of the mark's name, which is none
    let mark = base.path().join("out.tmp-1/diffraction.json");
    fs::write(
        &mark,
        r#"{"left_by":"me","inode":0,"new":["half"],"old":[],"carried":[],"moving":false}"#,
    )
    .unwrap();
    fs::create_dir(base.path().join("out.tmp-3")).unwrap();
    fs::create_dir(base.path().join("out.tmp-4.diffraction")).unwrap();
    fs::write(base.path().join("out.tmp-4.diffraction/mine"), "mine").unwrap();
    fs::write(base.path().join("out.tmp-5"), "a file, not a folder").unwrap();
    for letter in ["a", "b"] {
        let report = package::write(&lettered(letter), &out).unwrap();
        assert!(report.exchanged && report.left_behind.is_empty());
    }
    for name in names {
        assert_eq!(text(base.path().join(name).join("half")), "half", "{name}");
    }
    assert!(mark.exists() && base.path().join("out.tmp-3").is_dir());
    assert_eq!(text(base.path().join("out.tmp-4.diffraction/mine")), "mine");
    assert_eq!(text(base.path().join("out.tmp-5")), "a file, not a folder");
    fs::remove_dir_all(&out).unwrap();
    package::write(&lettered("a"), &out).unwrap();
    assert_eq!(text(base.path().join("out.old-2023/half")), "half", "not taken for the output");
}

/// What a killed run leaves goes, whichever step it was in; what is foreign in there stays.
#[test]
fn what_killed_runs_left_goes_but_for_what_is_foreign() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    package::write(&lettered("a"), &out).unwrap();
    let mark = |old: &[&str]| {
        json!({
            "left_by": "diffraction-shaders builds a package here; if no run does, the next one removes the folder",
            "inode": 0, "new": [], "old": old, "carried": [], "moving": false,
        })
        .to_string()
    };
    let make = |name: &str, files: &[&str], old: &[&str]| {
        let folder = base.path().join(name);
        for file in files {
            let path = folder.join("new").join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "left").unwrap();
        }
        fs::write(folder.join("diffraction.json"), mark(old)).unwrap();
        folder
    };
    make("out.tmp-1", &["x/y", "manifest.json"], &["x/y"]);
    let foreign = make("out.tmp-2", &["x/y", "x/mine"], &["x/y"]);
    let outside = make("out.tmp-3", &["x/y"], &["../../victim", "x/y"]);
    fs::write(base.path().join("victim"), "mine").unwrap();
    fs::create_dir(base.path().join("out.tmp-4.diffraction")).unwrap();
    fs::write(base.path().join("out.tmp-4.diffraction/diffraction.json.new"), "{").unwrap();
    let report = package::write(&lettered("b"), &out).unwrap();
    let left: Vec<&Path> = report.left_behind.iter().map(|left| left.path.as_path()).collect();
    assert_eq!(left, [foreign.as_path()]);
    assert!(report.left_behind[0].to_string().contains("x/mine"), "{}", report.left_behind[0]);
    assert_eq!(text(foreign.join("new/x/mine")), "left");
    assert!(outside.exists() && base.path().join("victim").exists());
    assert_eq!(leftovers(&out).len(), 2, "{:?}", leftovers(&out));
    assert_eq!(held(&out), Some("b"));
}

/// A folder counts as ours only by the whole mark: the command's text, the schema, the form of the list.
#[test]
fn a_manifest_of_another_program_or_command_is_no_package() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    let victim = base.path().join("victim");
    fs::write(&victim, "mine").unwrap();
    let listed = json!({ "compare": "bytes", "sha256": "0", "bytes": 4 });
    let right = json!({ "generated_by": GENERATED_BY, "schema_version": 1, "files": { "mine.txt": listed } });
    let with = |key: &str, value: Value| {
        let mut manifest = right.clone();
        manifest[key] = value;
        manifest
    };
    let without = |key: &str| {
        let mut manifest = right.clone();
        manifest.as_object_mut().unwrap().remove(key);
        manifest
    };
    let other = GENERATED_BY.replace("generate`", "inspect`");
    let refused = |manifest: &Value, part: &str| {
        fs::create_dir(&out).unwrap();
        fs::write(out.join("manifest.json"), manifest.to_string()).unwrap();
        fs::write(out.join("mine.txt"), "mine").unwrap();
        for error in [
            package::write(&lettered("a"), &out).unwrap_err(),
            package::check(&lettered("a"), &out).unwrap_err(),
        ] {
            assert!(error.to_string().contains(part), "{error}");
            assert!(error.advice().is_some(), "{error}");
        }
        assert_eq!(
            (text(out.join("mine.txt")), fs::read_dir(&out).unwrap().count()),
            ("mine".into(), 2)
        );
        assert!(leftovers(&out).is_empty());
        fs::remove_dir_all(&out).unwrap();
    };
    let none = "neither empty nor a package";
    refused(&with("generated_by", json!("webpack 5")), none);
    refused(&with("generated_by", json!(7)), none);
    refused(&with("generated_by", json!(format!("{GENERATED_BY} "))), none);
    refused(&with("generated_by", json!(other)), "was written by another command");
    refused(&without("schema_version"), none);
    refused(&with("schema_version", json!("1")), none);
    refused(&with("schema_version", json!(999)), "newer version");
    refused(&without("files"), none);
    refused(&with("files", json!(["mine.txt"])), none);
    refused(&with("files", json!({ "mine.txt": "4 bytes" })), none);
    refused(&with("files", json!({ "mine.txt": {} })), none);
    for path in ["../victim", "../../x", "/etc/passwd", "a/../../victim", "", "a//b", "c:x", "a\\b"]
    {
        refused(&with("files", json!({ path: listed })), "a path outside of this folder");
    }
    refused(&json!([]), none);
    // and a package of this command is taken as such: what it lists is replaced
    fs::create_dir(&out).unwrap();
    fs::write(out.join("manifest.json"), right.to_string()).unwrap();
    fs::write(out.join("mine.txt"), "mine").unwrap();
    assert_eq!(package::write(&lettered("a"), &out).unwrap().removed, ["mine.txt"]);
    assert_eq!((held(&out), text(victim)), (Some("a"), "mine".into()));
}

/// Folders of other commands have a mark of their own.
#[test]
fn folders_of_two_commands_are_told_apart() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    let mut survey = Package::new();
    survey.insert("facts", "facts", Equality::Bytes).unwrap();
    survey.seal_as(&GENERATED_BY.replace("generate`", "inspect`"), BTreeMap::new()).unwrap();
    package::write(&survey, &out).unwrap();
    package::write(&survey, &out).expect("its own");
    let error = package::write(&lettered("a"), &out).unwrap_err().to_string();
    assert!(error.contains("another command"), "{error}");
    assert_eq!(text(out.join("facts")), "facts");
}

/// What a folder looks like to its owner.
#[cfg(unix)]
fn look(path: &Path) -> (u32, u64, i64, u64) {
    use std::os::unix::fs::MetadataExt;
    let found = fs::symlink_metadata(path).unwrap();
    (found.mode(), found.ino(), found.mtime(), found.nlink())
}

#[cfg(unix)]
#[test]
fn foreign_folders_keep_everything_since_the_output_is_written_in_place_then() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    package::write(&lettered("a"), &out).unwrap();
    let at = |name: &str| out.join(name);
    fs::create_dir_all(at("mine/empty")).unwrap();
    fs::create_dir_all(at("only-a/deep/mine")).unwrap();
    fs::write(at("mine/file"), "mine").unwrap();
    symlink("nowhere", at("mine/link")).unwrap();
    let made = Command::new("mkfifo").arg(at("mine/pipe")).status().unwrap();
    assert!(made.success());
    fs::set_permissions(at("mine"), fs::Permissions::from_mode(0o2750)).unwrap();
    let touched =
        Command::new("touch").args(["-d", "2001-02-03"]).arg(at("mine")).status().unwrap();
    assert!(touched.success());
    let all = ["", "mine", "mine/empty", "only-a/deep/mine", "mine/file", "mine/link", "mine/pipe"];
    let before: Vec<_> = all.iter().map(|name| look(&at(name)).1).collect();
    let mine = look(&at("mine"));
    let report = package::write(&lettered("b"), &out).unwrap();
    assert!(!report.exchanged);
    assert_eq!(report.removed, ["only-a/deep/file"]);
    let after: Vec<_> = all.iter().map(|name| look(&at(name)).1).collect();
    assert_eq!((before, mine), (after, look(&at("mine"))), "all is where and what it was");
    assert!(!at("only-a/deep/file").exists() && !at(".diffraction-new").exists());
    let report = package::check(&lettered("b"), &out).unwrap();
    assert!(!report.is_stale());
    assert_eq!(report.foreign, ["mine/file", "mine/link", "mine/pipe"]);
    assert!(leftovers(&out).is_empty());
}

/// Names that no file of a package has, and a file that the package has, too.
#[cfg(unix)]
#[test]
fn foreign_files_of_any_name_stay() {
    use std::os::unix::ffi::OsStrExt;
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    package::write(&lettered("a"), &out).unwrap();
    let names: [&[u8]; 5] = [b"c:x", b"a\\b", b"new\nline", b" ", b"\xff\xfe"];
    let mut links: Vec<u64> = Vec::new();
    for (number, is_unicode) in [(4, true), (5, false)] {
        for name in &names[..number] {
            fs::write(out.join(std::ffi::OsStr::from_bytes(name)), "mine").unwrap();
        }
        let next = if is_unicode { "b" } else { "a" };
        let same = format!("part-3/file-{}", if is_unicode { 13 } else { 14 });
        let mut fresh = Package::new();
        fresh.insert(&same, "same", Equality::Bytes).unwrap();
        for (path, file) in lettered(next).files() {
            if path != "manifest.json" {
                fresh.insert_content(path, file.content.clone(), file.compare).unwrap();
            }
        }
        fresh.seal(BTreeMap::new()).unwrap();
        fs::create_dir_all(out.join("part-3")).unwrap();
        fs::write(out.join(&same), "same").unwrap();
        let report = package::write(&fresh, &out).unwrap();
        assert_eq!((report.exchanged, report.left_behind), (is_unicode, vec![]));
        assert_eq!(report.carried.len(), number);
        for name in &names[..number] {
            let path = out.join(std::ffi::OsStr::from_bytes(name));
            assert_eq!(text(path.clone()), "mine");
            links.push(look(&path).3);
        }
        assert!(leftovers(&out).is_empty(), "{:?}", leftovers(&out));
    }
    assert!(links.iter().all(|count| *count == 1), "no link is left: {links:?}");
}

/// A folder of the package that is a link now leads to files of somebody else.
#[cfg(unix)]
#[test]
fn nothing_is_written_or_removed_through_a_link() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    package::write(&lettered("a"), &out).unwrap();
    fs::rename(out.join("only-a"), base.path().join("elsewhere")).unwrap();
    std::os::unix::fs::symlink("../elsewhere", out.join("only-a")).unwrap();
    let is_safe = || {
        assert_eq!(text(base.path().join("elsewhere/deep/file")), "a");
        assert!(fs::symlink_metadata(out.join("only-a")).unwrap().is_symlink());
        assert!(leftovers(&out).is_empty());
    };
    assert!(package::write(&lettered("b"), &out).unwrap().exchanged);
    is_safe();
    let error = package::write(&lettered("a"), &out).unwrap_err().to_string();
    assert!(error.contains("is in the way of a generated file"), "{error}");
    is_safe();
    // the same in place: what the manifest lists lies behind the link
    fs::remove_file(out.join("only-a")).unwrap();
    package::write(&lettered("a"), &out).unwrap();
    fs::remove_dir_all(out.join("only-a")).unwrap();
    std::os::unix::fs::symlink("../elsewhere", out.join("only-a")).unwrap();
    fs::create_dir(out.join("mine")).unwrap();
    let error = package::write(&lettered("b"), &out).unwrap_err().to_string();
    assert!(error.contains("is in the way of generated files"), "{error}");
    is_safe();
    assert_eq!(package::check(&lettered("a"), &out).unwrap().foreign, ["only-a"]);
}

/// Run by the test below in a process of its own: writes both packages in turn for ever.
#[test]
fn child() {
    let Ok(out) = std::env::var("OUTPUTS_TEST_OUT") else { return };
    loop {
        for letter in ["a", "b"] {
            package::write(&lettered(letter), Path::new(&out)).unwrap();
        }
    }
}

/// Two writers at once, killed at any moment: in place, where a foreign folder is in the output, and by exchange.
#[cfg(unix)]
#[test]
fn killed_writers_leave_one_package_or_one_that_the_next_run_completes() {
    let mut incomplete = 0;
    for is_in_place in [true, false] {
        let base = tempfile::tempdir().unwrap();
        let out = base.path().join("out");
        package::write(&lettered("a"), &out).unwrap();
        let mine = out.join("mine/file");
        if is_in_place {
            fs::create_dir(out.join("mine")).unwrap();
            fs::write(&mine, "mine").unwrap();
        }
        let is_held = || {
            ["a", "b"].iter().any(|letter| {
                package::check(&lettered(letter), &out).is_ok_and(|report| !report.is_stale())
            })
        };
        for round in 0..12 {
            let spawn = || {
                let mut command = Command::new(std::env::current_exe().unwrap());
                command.args(["--exact", "outputs::child", "--nocapture"]);
                command.env("OUTPUTS_TEST_OUT", &out).stdout(Stdio::null()).stderr(Stdio::null());
                command.spawn().unwrap()
            };
            let mut children = [spawn(), spawn()];
            std::thread::sleep(Duration::from_millis(40 + 7 * round));
            for child in &mut children {
                assert!(child.try_wait().unwrap().is_none(), "a writer failed");
                child.kill().unwrap();
                child.wait().unwrap();
            }
            let contents: Vec<PathBuf> =
                (0..12).map(|i| out.join(format!("part-{}/file-{i}", i % 4))).collect();
            let letters: std::collections::BTreeSet<u8> =
                contents.iter().filter_map(|path| fs::read(path).ok()?.first().copied()).collect();
            if !is_held() {
                incomplete += 1;
                assert!(is_in_place, "an exchange leaves a whole package: {letters:?}");
                assert!(!out.join("manifest.json").exists(), "or it would be taken for one");
            }
            package::write(&lettered(if round % 2 == 0 { "a" } else { "b" }), &out).unwrap();
            assert!(is_held(), "round {round}");
            assert!(leftovers(&out).is_empty(), "{:?}", leftovers(&out));
            let inside = fs::read_dir(&out).unwrap().flatten();
            let left: Vec<_> = inside
                .filter(|entry| entry.file_name().to_string_lossy().starts_with(".diffraction"))
                .collect();
            assert!(left.is_empty(), "{left:?}");
            assert_eq!(is_in_place, mine.exists());
        }
    }
    println!("{incomplete} of 24 killed while files moved");
}

/// A run that was killed while files moved is completed as soon as any run opens the output.
#[test]
fn a_move_that_was_begun_is_completed() {
    let base = tempfile::tempdir().unwrap();
    let (out, other) = (base.path().join("out"), base.path().join("other"));
    package::write(&lettered("a"), &out).unwrap();
    package::write(&lettered("b"), &other).unwrap();
    let names = |letter| lettered(letter).files().keys().cloned().collect::<Vec<_>>();
    let stage = out.join(".diffraction-new");
    fs::create_dir(&stage).unwrap();
    fs::rename(&other, stage.join("new")).unwrap();
    let mark = json!({
        "left_by": "diffraction-shaders builds a package here; if no run does, the next one removes the folder",
        "inode": 0, "new": names("b"), "old": names("a"), "carried": [], "moving": true,
    });
    fs::write(stage.join("diffraction.json"), mark.to_string()).unwrap();
    // as far as the killed run came
    fs::rename(out.join("manifest.json"), stage.join("old-manifest.json")).unwrap();
    fs::rename(stage.join("new/part-1/file-1"), out.join("part-1/file-1")).unwrap();
    fs::remove_file(out.join("only-a/deep/file")).unwrap();
    for letter in ["a", "b"] {
        let report = package::check(&lettered(letter), &out).unwrap();
        assert!(report.missing.contains(&"manifest.json".to_owned()), "{report:?}");
        assert!(report.foreign.is_empty(), "{report:?}");
    }
    let error = Package::new().overlay(&out, |_| true).unwrap_err().to_string();
    assert!(error.contains("killed run"), "{error}");
    drop(Output::open(&out, GENERATED_BY, &Cancel::new(), &|_| ()).unwrap());
    assert_eq!(held(&out), Some("b"));
    assert!(!stage.exists());
}
