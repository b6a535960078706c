//! Packages on disk: what is ours and what is not, and outputs that stay whole whatever happens.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use diffraction_shaders::hash::sha256;
use diffraction_shaders::package::{
    self, Cancel, Content, Equality, JSON_TOLERANCE, Package, Report, Stamp,
};
use diffraction_shaders::plan::TableFormat;

pub fn package(files: &[(&str, &str)]) -> Package {
    let mut package = Package::new();
    for (path, text) in files {
        let compare = if path.ends_with(".json") {
            Equality::Json { tolerance: JSON_TOLERANCE }
        } else {
            Equality::Bytes
        };
        package.insert(path, *text, compare).unwrap();
    }
    package.seal(BTreeMap::from([("schema_version".to_owned(), 1.into())])).unwrap();
    package
}

pub fn text(path: PathBuf) -> String {
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Everything beside the output that should not be there.
pub fn leftovers(out: &Path) -> Vec<String> {
    let name = |entry: fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
    let entries = fs::read_dir(out.parent().unwrap()).unwrap().map(|entry| name(entry.unwrap()));
    entries.filter(|name| name.starts_with("out.")).collect()
}

#[test]
fn what_is_written_checks_clean_and_stale_files_go() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("deep/out");
    let first = package(&[("a/x.wgsl", "one"), ("a/y.json", "{\"v\":1.0}"), ("b.bin", "b")]);
    assert_eq!(package::check(&first, &out).unwrap().missing.len(), 4);
    assert!(!out.parent().unwrap().exists(), "a check writes nothing");
    let report = package::write(&first, &out).unwrap();
    assert_eq!((report.files, report.carried.len(), report.left_behind), (4, 0, vec![]));
    assert_eq!(package::check(&first, &out).unwrap(), Report::default());

    let second =
        package(&[("a/x.wgsl", "two"), ("a/y.json", "{\"v\":1.0000000000001}"), ("c/z.wgsl", "z")]);
    let report = package::check(&second, &out).unwrap();
    assert_eq!(report.changed, ["a/x.wgsl", "manifest.json"]);
    assert_eq!(
        (report.missing, report.orphan),
        (vec!["c/z.wgsl".to_owned()], vec!["b.bin".to_owned()])
    );
    assert_eq!(package::write(&second, &out).unwrap().removed, ["b.bin"]);
    assert_eq!(package::check(&second, &out).unwrap(), Report::default());
    assert!(!out.join("b.bin").exists() && leftovers(&out).is_empty());
}

#[test]
fn an_output_that_is_not_ours_is_refused_and_untouched() {
    let base = tempfile::tempdir().unwrap();
    let fresh = package(&[("x", "x")]);
    for (name, content) in
        [("notes.txt", "mine"), ("manifest.json", "{}"), ("manifest.json", "no json")]
    {
        let out = base.path().join("out");
        fs::create_dir(&out).unwrap();
        fs::write(out.join(name), content).unwrap();
        let error = package::write(&fresh, &out).unwrap_err().to_string();
        assert!(error.contains("neither empty nor a package"), "{error}");
        assert!(package::check(&fresh, &out).is_err());
        assert_eq!(text(out.join(name)), content);
        assert_eq!(fs::read_dir(&out).unwrap().count(), 1);
        fs::remove_dir_all(&out).unwrap();
    }
    let file = base.path().join("file");
    fs::write(&file, "mine").unwrap();
    assert!(package::write(&fresh, &file).unwrap_err().to_string().contains("is not a folder"));
    assert!(package::write(&fresh, &file.join("out")).is_err());
    assert!(package::write(&fresh, Path::new("/")).is_err());
    assert_eq!(text(file), "mine");
    fs::create_dir(base.path().join("out")).unwrap();
    package::write(&fresh, &base.path().join("out")).expect("an empty folder may be used");
}

#[test]
fn foreign_files_are_carried_over_and_reported() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    package::write(&package(&[("a/x", "1"), ("gone/x", "1")]), &out).unwrap();
    fs::write(out.join("README"), "mine").unwrap();
    fs::create_dir_all(out.join("gone/deep")).unwrap();
    fs::write(out.join("gone/deep/mine"), "mine").unwrap();
    let next = package(&[("a/x", "2")]);
    assert_eq!(package::check(&next, &out).unwrap().foreign, ["README", "gone/deep/mine"]);
    assert!(!Report { foreign: vec!["README".into()], ..Report::default() }.is_stale());
    let report = package::write(&next, &out).unwrap();
    assert_eq!(report.carried, [Path::new("README"), Path::new("gone/deep/mine")]);
    assert_eq!(
        (text(out.join("README")), text(out.join("gone/deep/mine"))),
        ("mine".into(), "mine".into())
    );
    assert!(!out.join("gone/x").exists());

    for in_the_way in ["README", "README/x", "gone/deep"] {
        let error = package::write(&package(&[(in_the_way, "3")]), &out).unwrap_err().to_string();
        assert!(error.contains("in the way of a generated file"), "{in_the_way}: {error}");
        assert_eq!(package::check(&next, &out).unwrap().changed, Vec::<String>::new());
        assert!(leftovers(&out).is_empty());
    }
}

#[test]
fn an_edited_file_is_found() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    let fresh = package(&[("a/x.wgsl", "one"), ("y.json", "{\"v\":1.5}")]);
    package::write(&fresh, &out).unwrap();
    fs::write(out.join("a/x.wgsl"), "edited").unwrap();
    fs::write(out.join("y.json"), "{ \"v\" : 1.6 }").unwrap();
    assert_eq!(package::check(&fresh, &out).unwrap().changed, ["a/x.wgsl", "y.json"]);
    fs::remove_file(out.join("a/x.wgsl")).unwrap();
    assert_eq!(package::check(&fresh, &out).unwrap().missing, ["a/x.wgsl"]);
}

#[test]
fn a_partial_rebuild_keeps_the_rest() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    let whole = package(&[("a/x", "1"), ("b/x", "1"), ("c/x.json", "[1.0]")]);
    package::write(&whole, &out).unwrap();
    let mut part = Package::new();
    part.insert("a/x", "2", Equality::Bytes).unwrap();
    assert_eq!(part.overlay(&out, |path| !path.starts_with("b/")).unwrap(), ["c/x.json"]);
    part.seal(BTreeMap::from([("other".to_owned(), 1.into())])).unwrap();
    package::write(&part, &out).unwrap();
    assert_eq!((text(out.join("a/x")), text(out.join("c/x.json"))), ("2".into(), "[1.0]".into()));
    assert!(!out.join("b/x").exists());
    let rebuilt = package(&[("a/x", "2"), ("c/x.json", "[1.0]")]);
    assert_eq!(
        package::check(&rebuilt, &out).unwrap().changed,
        ["manifest.json"],
        "only the index keys differ"
    );
    assert!(Package::new().overlay(&base.path().join("absent"), |_| true).unwrap().is_empty());
}

#[test]
fn paths_that_leave_the_folder_or_clash_are_refused() {
    let mut package = Package::new();
    package.insert("a/x", "x", Equality::Bytes).unwrap();
    for path in ["", "/x", "../x", "a//x", "a/./x", "a\\x", "c:x", "a/x", "a", "a/x/y"] {
        assert!(package.insert(path, "x", Equality::Bytes).is_err(), "{path:?}");
    }
    assert!(package.seal(BTreeMap::from([("files".to_owned(), 1.into())])).is_err());
}

#[test]
fn a_cancelled_write_leaves_the_previous_output() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    package::write(&package(&[("x", "1")]), &out).unwrap();
    let cancel = Cancel::new();
    cancel.cancel();
    let error = package::write_unless(&package(&[("x", "2")]), &out, &cancel).unwrap_err();
    assert!(error.to_string().contains("interrupted"));
    assert_eq!(text(out.join("x")), "1");
    assert!(leftovers(&out).is_empty());
}

#[cfg(unix)]
#[test]
fn a_link_to_the_output_stays_a_link() {
    let base = tempfile::tempdir().unwrap();
    fs::create_dir(base.path().join("real")).unwrap();
    std::os::unix::fs::symlink("real", base.path().join("out")).unwrap();
    package::write(&package(&[("x", "1")]), &base.path().join("out")).unwrap();
    assert_eq!(text(base.path().join("real/x")), "1");
    assert!(fs::symlink_metadata(base.path().join("out")).unwrap().is_symlink());
}

/// Run by the tests below in a process of its own: writes one of two packages, or both in turn for ever.
#[test]
fn child() {
    let Ok(out) = std::env::var("PACKAGE_TEST_OUT") else { return };
    let files = |letter: &str| -> Vec<(String, String)> {
        (0..40).map(|i| (format!("part-{}/file-{i}", i % 7), letter.repeat(20_000))).collect()
    };
    let write = |letter: &str| {
        let files = files(letter);
        let files: Vec<(&str, &str)> =
            files.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
        package::write(&package(&files), Path::new(&out)).map(|_| ())
    };
    if std::env::var_os("PACKAGE_TEST_FOREVER").is_some() {
        loop {
            write("a").unwrap();
            write("b").unwrap();
        }
    }
    write("b").unwrap_or_else(|e| panic!("cannot write: {e}"));
}

#[cfg(unix)]
fn child_command(out: &Path, shell: &str) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("{shell} exec \"$0\" --exact package::child --nocapture")]);
    command.arg(std::env::current_exe().unwrap()).env("PACKAGE_TEST_OUT", out);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_previous_output() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    let before = package(&[("x", "1")]);
    package::write(&before, &out).unwrap();
    // 8 blocks of 512 bytes; the signal is ignored, so the write itself fails.
    let done = child_command(&out, "trap '' XFSZ; ulimit -f 8;").output().unwrap();
    let message = String::from_utf8_lossy(&done.stdout) + String::from_utf8_lossy(&done.stderr);
    assert!(
        !done.status.success()
            && message.contains(
                "cannot write: generated file manifest.json: cannot be written: File too large"
            ),
        "{message}"
    );
    assert_eq!(package::check(&before, &out).unwrap(), Report::default());
    assert!(leftovers(&out).is_empty());
}

#[cfg(unix)]
#[test]
fn a_killed_writer_leaves_one_whole_output() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    for round in 0..6 {
        let mut child = child_command(&out, "").env("PACKAGE_TEST_FOREVER", "1").spawn().unwrap();
        while !out.join("manifest.json").exists() {
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(Duration::from_millis(15 + 13 * round));
        child.kill().unwrap();
        child.wait().unwrap();
        let first = text(out.join("part-0/file-0"));
        let letter = &first[..1];
        for i in 0..40 {
            assert_eq!(
                text(out.join(format!("part-{}/file-{i}", i % 7))),
                letter.repeat(20_000),
                "round {round}"
            );
        }
    }
    package::write(&package(&[("x", "1")]), &out).unwrap();
    assert!(leftovers(&out).is_empty(), "the next run removes what the killed ones left");
}

#[test]
fn stored_files_are_written_and_checked_like_those_in_memory() {
    let base = tempfile::tempdir().unwrap();
    let (out, stored) = (base.path().join("out"), base.path().join("stored"));
    let bytes: Vec<u8> = (0..50_000_u32).flat_map(|i| (i as f32).to_le_bytes()).collect();
    fs::write(&stored, &bytes).unwrap();
    let compare = Equality::Table { format: TableFormat::F32, tolerance: 1e-6, layer: 0 };
    let mut fresh = Package::new();
    let content = Content::Stored { file: stored.clone(), sha256: sha256(&bytes) };
    fresh.insert_content("table.bin", content, compare).unwrap();
    fresh.seal(BTreeMap::new()).unwrap();
    assert_eq!(fresh.bytes("table.bin"), None);
    package::write(&fresh, &out).unwrap();
    assert_eq!(fs::read(out.join("table.bin")).unwrap(), bytes);
    assert!(!package::check(&fresh, &out).unwrap().is_stale());
    for (value, is_stale) in [(49_000.001_f32, false), (7.0, true)] {
        let mut edited = bytes.clone();
        edited[4 * 49_000..][..4].copy_from_slice(&value.to_le_bytes());
        fs::write(out.join("table.bin"), &edited).unwrap();
        assert_eq!(package::check(&fresh, &out).unwrap().is_stale(), is_stale, "{value}");
    }
    assert_eq!(fs::read(&stored).unwrap(), bytes, "an edit of the output reaches nothing else");
    fs::write(out.join("table.bin"), &bytes[4..]).unwrap();
    assert!(package::check(&fresh, &out).unwrap().is_stale());
    // one that changes before it is copied is not what was hashed
    fs::write(&stored, &bytes[4..]).unwrap();
    let error = package::write(&fresh, &out).unwrap_err().to_string();
    assert!(error.contains("changed while it was used"), "{error}");
    assert!(fs::read(out.join("table.bin")).unwrap() == bytes[4..], "the output stays");
    assert!(leftovers(&out).is_empty());
}

#[test]
fn a_stamp_holds_until_any_file_is_edited_or_gone() {
    let base = tempfile::tempdir().unwrap();
    let out = base.path().join("out");
    let fresh = package(&[("a/x", "1"), ("y", "2")]);
    let stamp = Stamp::new(&fresh, "inputs".into(), vec!["note".into()]).unwrap();
    let file = base.path().join("stamps/one.json");
    stamp.write(&file).unwrap();
    assert_eq!(Stamp::read(&file).as_ref(), Some(&stamp));
    assert!(!stamp.holds(&out), "nothing is written yet");
    let write = || package::write(&fresh, &out).unwrap();
    write();
    assert!(stamp.holds(&out));
    fs::write(out.join("mine"), "mine").unwrap();
    assert!(stamp.holds(&out), "files that are not ours do not count");
    for path in ["a/x", "y", "manifest.json"] {
        fs::write(out.join(path), "edited").unwrap();
        assert!(!stamp.holds(&out), "{path} edited");
        fs::remove_file(out.join(path)).unwrap();
        assert!(!stamp.holds(&out), "{path} gone");
        if path == "manifest.json" {
            fs::remove_dir_all(&out).unwrap();
        }
        write();
        assert!(stamp.holds(&out));
    }
    fs::create_dir(base.path().join("out.tmp-4711")).unwrap();
    assert!(stamp.holds(&out), "a folder of somebody else");
    fs::create_dir(base.path().join("out.tmp-4711.diffraction")).unwrap();
    assert!(!stamp.holds(&out), "there is something to tidy up");
}
