//! Inputs are read once, hashed as they are read, and found where the plan says.

use std::fs;
use std::path::Path;

use diffraction_shaders::input::{SurfaceInput, read_plan, read_surfaces};
use diffraction_shaders::optics::spectrum::Spectrum;

const PLAN: &str = r#"schema = 1
[[surface]]
name = "scan"
file = "scan.txt"
pixel_um = 0.05
[variants]
mode = "full"
"#;

fn scan(path: &Path, height_um: f64) {
    let row =
        |y: u32| (0..8).map(move |x| f64::from((x + y) % 3) * height_um).map(|h| h.to_string());
    let rows: Vec<String> = (0..8).map(|y| row(y).collect::<Vec<_>>().join(" ")).collect();
    fs::write(path, rows.join("\n")).unwrap();
}

/// A scan that is replaced after it was read changes neither name nor numbers.
#[test]
fn what_is_hashed_is_what_was_read() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, file) = (folder.path().join("plan.toml"), folder.path().join("scan.txt"));
    fs::write(&plan, PLAN).unwrap();
    scan(&file, 0.1);
    let spec = read_plan(&plan).unwrap().surfaces.remove(0);
    let first = SurfaceInput::read(&spec).unwrap();
    scan(&file, 0.2);
    let second = SurfaceInput::read(&spec).unwrap();
    fs::remove_file(&file).unwrap();
    let highest = |input: &SurfaceInput| input.surface().unwrap().field.range_um().1;
    assert_eq!((highest(&first), highest(&second)), (0.2, 0.4));
    assert_ne!(first.identity(), second.identity());
}

#[test]
fn every_unreadable_surface_is_an_error_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    let more = PLAN.replace(
        "[variants]",
        r#"[[surface]]
name = "bad"
file = "bad.txt"
pixel_um = 0.05
[variants]"#,
    );
    fs::write(&plan, more).unwrap();
    fs::write(folder.path().join("bad.txt"), "1 2\nx y\n").unwrap();
    let errors = read_surfaces(&read_plan(&plan).unwrap().surfaces).unwrap_err();
    let text: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(text.len(), 2, "{text:?}");
    assert!(text[0].contains("scan.txt") && text[1].contains("bad.txt"), "{text:?}");
}

/// A name comes first; a file lies beside the plan, wherever the program runs.
#[test]
fn illuminants_are_names_or_files_beside_the_plan() {
    let folder = tempfile::tempdir().unwrap();
    let plan = folder.path().join("plan.toml");
    let with = |illuminant: &str| {
        fs::write(&plan, format!("{PLAN}[optics]\nilluminant = \"{illuminant}\"\n")).unwrap();
        read_plan(&plan)
    };
    let csv = |power: &str| format!("nm,power\n360,1\n500,{power}\n830,1\n");
    fs::write(folder.path().join("D65"), csv("9")).unwrap();
    let named = with("D65").unwrap().variants.remove(0).optics.illuminant;
    assert_eq!((named.identity(), named.content()), ("D65", None));

    fs::write(folder.path().join("lamp.csv"), csv("2")).unwrap();
    let lamp = with("lamp.csv").unwrap().variants.remove(0).optics.illuminant;
    let first = lamp.identity().to_owned();
    assert_eq!((lamp.name(), first.len()), ("lamp.csv", 64));
    fs::write(folder.path().join("lamp.csv"), csv("5")).unwrap();
    let other = with("lamp.csv").unwrap().variants.remove(0).optics.illuminant;
    assert_ne!(other.identity(), first);
    fs::remove_file(folder.path().join("lamp.csv")).unwrap();
    let white = |illuminant| Spectrum::new(illuminant).unwrap().white();
    assert_ne!(white(&lamp), white(&other));

    for (name, words) in [
        ("D66", "neither a known illuminant nor a file"),
        ("lamp.csv", "relative to the plan's folder"),
    ] {
        let message = with(name).unwrap_err()[0].to_string();
        assert!(
            message.contains(name) && message.contains(words) && message.contains("D65"),
            "{message}"
        );
    }
}
