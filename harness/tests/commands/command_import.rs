//! `cargo xtask import`: a file of an instrument becomes a field that the compiler reads, and nothing else is touched.

use crate::support::tools;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use diffraction_shaders::{Plan, input};

/// Heights of three columns and two rows, in nm, the top row first; all differ, so that no turn or mirror image is the same.
const HEIGHTS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

fn text(value: &str) -> Vec<u8> {
    [value.as_bytes(), b"\0"].concat()
}

/// An object of the Gwyddion format: its name, the size of what follows, its items.
fn object(name: &str, items: &[Vec<u8>]) -> Vec<u8> {
    let items = items.concat();
    [text(name), (items.len() as u32).to_le_bytes().to_vec(), items].concat()
}

fn item(name: &str, kind: u8, value: &[u8]) -> Vec<u8> {
    [text(name), vec![kind], value.to_vec()].concat()
}

/// A field of 30 × 20 nm.
fn field(unit: &str, heights: &[f64]) -> Vec<u8> {
    let si_unit = |name: &str, unit: &str| {
        item(name, b'o', &object("GwySIUnit", &[item("unitstr", b's', &text(unit))]))
    };
    let numbers: Vec<u8> = heights.iter().flat_map(|h| (h * 1e-9).to_le_bytes()).collect();
    let data = [(heights.len() as u32).to_le_bytes().to_vec(), numbers].concat();
    object(
        "GwyDataField",
        &[
            item("xres", b'i', &3_i32.to_le_bytes()),
            item("yres", b'i', &2_i32.to_le_bytes()),
            item("xreal", b'd', &30e-9_f64.to_le_bytes()),
            item("yreal", b'd', &20e-9_f64.to_le_bytes()),
            si_unit("si_unit_xy", "m"),
            si_unit("si_unit_z", unit),
            item("data", b'D', &data),
        ],
    )
}

/// A Gwyddion file with these channels: title, unit of values, heights.
///
/// Source: Gwyddion user guide, appendix "Gwyddion native format".
fn gwy(channels: &[(&str, &str, [f64; 6])]) -> Vec<u8> {
    let mut items = Vec::new();
    for (index, (title, unit, heights)) in channels.iter().enumerate() {
        items.push(item(&format!("/{index}/data"), b'o', &field(unit, heights)));
        items.push(item(&format!("/{index}/data/title"), b's', &text(title)));
    }
    [b"GWYP".to_vec(), object("GwyContainer", &items)].concat()
}

fn import(folder: &Path, args: &[&str]) -> (Output, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
    let done = command.arg("import").args(args).current_dir(folder).output().unwrap();
    let said = [&done.stdout[..], &done.stderr].concat();
    (done, String::from_utf8_lossy(&said).into_owned())
}

/// A folder with a file of one channel, if the library is there.
fn scene() -> Option<tempfile::TempDir> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scan.gwy"), gwy(&[("Topo", "m", HEIGHTS)])).unwrap();
    let (_, said) = import(folder.path(), &["scan.gwy", "--out", "trial"]);
    if said.contains("import --setup") {
        tools::missing(said);
        return None;
    }
    Some(folder)
}

/// Heights in nm as the compiler reads them, by the block that was printed.
fn heights_nm(folder: &Path, said: &str) -> (usize, f64, Vec<f64>) {
    let block = &said[said.find("[[surface]]").expect(said)..];
    let block = block.split("\nnote: ").next().unwrap();
    let block = block.replace("level = \"plane\"", "level = \"none\"");
    let plan = Plan::parse(&format!("schema = 1\n{block}"), &folder.join("plan.toml")).unwrap();
    let surface = input::load_surface(&plan.surfaces[0]).unwrap();
    let field = &surface.field;
    let heights = field.heights_um().iter().map(|h| h * 1e3);
    (field.columns(), field.pitch_x_um() * 1e3, heights.collect())
}

#[test]
fn what_was_written_is_what_the_compiler_reads() {
    let Some(folder) = scene() else { return };
    let (done, said) = import(folder.path(), &["scan.gwy"]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    for part in ["channel 'Topo'", "3 × 2 pixels", "0.03 × 0.02 µm", "peak to valley 0.031 µm"]
    {
        assert!(said.contains(part), "{part}: {said}");
    }
    let (columns, pitch, heights) =
        heights_nm(folder.path(), &String::from_utf8_lossy(&done.stdout));
    assert!(columns == 3 && (pitch - 10.0).abs() < 1e-6, "{columns} {pitch}");
    let off = |order: &[usize]| {
        let pairs = heights.iter().zip(order.iter().map(|&i| HEIGHTS[i]));
        // heights have no zero that counts
        let differences: Vec<f64> = pairs.map(|(found, right)| found - right).collect();
        differences.iter().map(|d| (d - differences[0]).abs()).fold(0.0, f64::max)
    };
    assert!(off(&[0, 1, 2, 3, 4, 5]) < 1e-3, "{heights:?}");
    // upside down, mirrored, transposed
    for wrong in [[3, 4, 5, 0, 1, 2], [2, 1, 0, 5, 4, 3], [0, 3, 1, 4, 2, 5]] {
        assert!(off(&wrong) > 1.0);
    }
    let header = fs::read(folder.path().join("scan.gsf")).unwrap();
    let header = String::from_utf8_lossy(&header).into_owned();
    assert!(header.starts_with("Gwyddion Simple Field 1.0\nXRes = 3\nYRes = 2\n"), "{header}");
    assert!(header.contains("\nXYUnits = m\nZUnits = m\nTitle = Topo\n"), "{header}");
}

/// Heights of a millimetre that differ by nanometres would lose them in 32 bits.
#[test]
fn a_great_height_is_taken_off() {
    let Some(folder) = scene() else { return };
    let high = HEIGHTS.map(|h| h + 1e6);
    fs::write(folder.path().join("high.gwy"), gwy(&[("Topo", "m", high)])).unwrap();
    let (done, said) = import(folder.path(), &["high.gwy"]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("dropped: ") && said.contains(" µm of all heights"), "{said}");
    let (_, _, heights) = heights_nm(folder.path(), &String::from_utf8_lossy(&done.stdout));
    assert!((heights[5] - heights[0] - 31.0).abs() < 1e-3, "{heights:?}");
}

#[test]
fn channels_are_chosen_by_name_or_for_a_reason() {
    let Some(folder) = scene() else { return };
    let write = |channels: &[(&str, &str, [f64; 6])]| {
        fs::write(folder.path().join("more.gwy"), gwy(channels)).unwrap();
    };
    let twice = HEIGHTS.map(|h| 2.0 * h);
    write(&[("Topo", "m", HEIGHTS), ("Depth", "m", twice)]);
    let (done, said) = import(folder.path(), &["more.gwy"]);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(
        said.contains("several channels of heights") && said.contains("--channel Topo or Depth"),
        "{said}"
    );
    assert!(!folder.path().join("more.gsf").exists());

    let (done, said) = import(folder.path(), &["more.gwy", "--channel", "Depth"]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("more-Depth.gsf") && said.contains("0.062 µm"), "{said}");
    assert!(said.contains("dropped: channel 'Topo' (heights)"), "{said}");

    let (done, said) = import(folder.path(), &["more.gwy", "--channel", "Phase"]);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains("more.gwy: has no channel 'Phase' (one of 'Topo', 'Depth')"), "{said}");

    write(&[("Topo backward", "m", twice), ("Topo forward", "m", HEIGHTS)]);
    let (done, said) = import(folder.path(), &["more.gwy"]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("channel 'Topo backward' (the first of several scans"), "{said}");

    // an ampere is no ångström
    write(&[("Current", "A", HEIGHTS), ("Force", "N", HEIGHTS)]);
    let (done, said) = import(folder.path(), &["more.gwy"]);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains("has no channel of heights, only 'Current'"), "{said}");
}

/// What a file does not state is not invented: the plan has to say it.
#[test]
fn a_file_without_units_becomes_a_field_without_units() {
    let Some(folder) = scene() else { return };
    let file = gwy(&[("Topo", "", HEIGHTS.map(|h| h * 1e9))]);
    fs::write(folder.path().join("bare.gwy"), file).unwrap();
    let (done, said) = import(folder.path(), &["bare.gwy"]);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("peak to valley 31; the file states no unit"), "{said}");
    assert!(said.contains("a plan would refuse it") && said.contains("# size_um = …"), "{said}");
    let stated = said.replace("# size_um = …  ", "size_um = 0.03  ");
    let stated = stated.replace("# z_unit_um = …  ", "z_unit_um = 0.001  ");
    let (columns, pitch, heights) = heights_nm(folder.path(), &stated);
    assert!(columns == 3 && (pitch - 10.0).abs() < 1e-6, "{columns} {pitch}");
    assert!((heights[5] - heights[0] - 31.0).abs() < 1e-3, "{heights:?}");
}

#[test]
fn one_bad_file_does_not_keep_the_others() {
    let Some(folder) = scene() else { return };
    let whole = gwy(&[("Topo", "m", HEIGHTS)]);
    fs::write(folder.path().join("cut.gwy"), &whole[..whole.len() / 2]).unwrap();
    fs::write(folder.path().join("note.doc"), "no heights at all").unwrap();
    let files = ["cut.gwy", "scan.gwy", "note.doc", "absent.gwy", "--out", "fields"];
    let (done, said) = import(folder.path(), &files);
    assert_eq!(done.status.code(), Some(2), "{said}");
    for part in [
        "error: cut.gwy: is in no format that SurfaceTopography reads, or damaged",
        "error: note.doc: is in no format that SurfaceTopography reads, or damaged (png, tiff",
        "error: absent.gwy: does not exist",
        "error: 3 of 4 files were not imported",
        "scan.gwy -> fields/scan.gsf",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(!said.contains("Traceback"), "{said}");
    let written: Vec<_> = fs::read_dir(folder.path().join("fields")).unwrap().collect();
    assert_eq!(written.len(), 1, "{written:?}");
}

#[test]
fn foreign_files_are_not_overwritten() {
    let Some(folder) = scene() else { return };
    let (source, output) = (folder.path().join("scan.gwy"), folder.path().join("scan.gsf"));
    fs::write(&output, "Gwyddion Simple Field 1.0\nXRes = 1\n\0Importer = diffraction import\n")
        .unwrap();
    let before = fs::read(&output).unwrap();
    let (done, said) = import(folder.path(), &["scan.gwy"]);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains("scan.gsf: exists, and import did not write it"), "{said}");
    assert_eq!(fs::read(&output).unwrap(), before);
    for options in [&["--force"][..], &[]] {
        // the second time it is ours
        let (done, said) = import(folder.path(), &[&["scan.gwy"], options].concat());
        assert_eq!(done.status.code(), Some(0), "{said}");
    }
    assert_ne!(fs::read(&output).unwrap(), before);
    // two files of one name, and a file onto itself
    fs::create_dir(folder.path().join("b")).unwrap();
    fs::copy(&source, folder.path().join("b/scan.gwy")).unwrap();
    let (done, said) = import(folder.path(), &["scan.gwy", "b/scan.gwy", "--out", "one"]);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains("would be written from scan.gwy too"), "{said}");
    let (done, said) = import(folder.path(), &["scan.gsf", "--force"]);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains("would be overwritten by its own import"), "{said}");
}

/// Needs no library: none is there.
#[test]
fn without_the_library_the_command_to_run_is_said() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scan.gwy"), "").unwrap();
    let run = |variable: &str, value: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction-harness"));
        command.args(["import", "scan.gwy"]).current_dir(folder.path()).env("PATH", folder.path());
        command.env("DIFFRACTION_TOOLS", folder.path()).env_remove("DIFFRACTION_PYTHON");
        command.env("DIFFRACTION_CALLED_AS", "diffraction").env(variable, value);
        let done = command.output().unwrap();
        assert_eq!(done.status.code(), Some(2));
        String::from_utf8_lossy(&done.stderr).into_owned()
    };
    let said = run("NOTHING", "");
    assert!(said.contains("\n  diffraction import --setup\n"), "{said}");
    assert!(said.contains("DIFFRACTION_PYTHON=PATH"), "{said}");
    let said = run("DIFFRACTION_PYTHON", "/bin/false");
    assert!(said.contains("DIFFRACTION_PYTHON=/bin/false: is no Python that has"), "{said}");
}
