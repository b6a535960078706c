//! `diffraction-harness report` as a user runs it: where the page goes, what is printed, exit codes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const GAP: &str = r#"{"kind":"gap","route":"webgpu","surface":null,"variant":null,"reason":"no browser","failed":false}"#;

const PERIOD: &str = concat!(
    r#"{"kind":"testbench","surface":"a","variant":"exact","route":"exact","theta_i":75,"phi_i":0,"expected_nm":2500,"#,
    r#""period_nm":2500.1,"sd_nm":0.1,"points":81,"evanescent":0,"flat":0,"closed_nm":null,"window":null,"windows":null,"#,
    r#""weight":1,"svg":"pictures/a.svg"}"#
);

fn report(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    command.arg("report").args(args).current_dir(folder).output().unwrap()
}

fn folder(lines: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("run")).unwrap();
    fs::write(folder.path().join("run/records.jsonl"), lines.join("\n") + "\n").unwrap();
    folder
}

#[test]
fn the_page_goes_into_the_first_folder_or_where_it_is_wanted() {
    let folder = folder(&[GAP]);
    let done = report(folder.path(), &["run"]);
    assert_eq!((done.status.code(), done.stdout.len()), (Some(0), 0));
    let page = fs::read_to_string(folder.path().join("run/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("no browser"));
    assert_eq!(report(folder.path(), &["run", "--html", "b.html"]).status.code(), Some(0));
    assert_eq!(fs::read_to_string(folder.path().join("b.html")).unwrap(), page);
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        2,
        "something was left beside the page"
    );
}

#[test]
fn a_missing_picture_is_told_and_stops_nothing() {
    let folder = folder(&[PERIOD]);
    let done = report(folder.path(), &["run"]);
    assert_eq!(done.status.code(), Some(0));
    let message = String::from_utf8(done.stderr).unwrap();
    assert!(message.contains("picture missing: run/pictures/a.svg"), "{message}");
    let done = report(folder.path(), &["run", "--no-pictures"]);
    assert!(!String::from_utf8(done.stderr).unwrap().contains("missing"));
}

#[test]
fn what_cannot_be_read_is_an_error_with_its_place() {
    let folder = folder(&[GAP, "{}"]);
    for (args, wanted) in [
        (&["nowhere"][..], "nowhere: has no records.jsonl"),
        (&["run"], "run/records.jsonl:2"),
        (&[], "<DIR>"),
    ] {
        let done = report(folder.path(), args);
        let message = String::from_utf8(done.stderr).unwrap();
        assert!(done.status.code() == Some(2) && message.contains(wanted), "{args:?}: {message}");
    }
    assert!(!folder.path().join("run/report.html").exists());
}
