//! Bad input through the real command: exit code 2, a message that names what is wrong and what to do, and the previous
//! output untouched.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

const GOOD: &str = r#"schema = 1
[[surface]]
name = "grating"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 40 }
[[preset]]
name = "small"
mode = "full"
terms = 5
accept_error = true
wavelengths = { min_nm = 400, max_nm = 700, step_nm = 100 }
[targets]
emit = ["wgsl"]
"#;

/// A folder with a good plan and its package.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        place.put("plan.toml", GOOD);
        let done = place.run(&["generate"]);
        assert_eq!(done.status.code(), Some(0), "{}", said(&done));
        place
    }

    fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.0.path().join(name), bytes).unwrap();
    }

    fn run(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_diffraction"))
            .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
            .args(args)
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    /// Every file below the output, by path.
    fn output(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = BTreeMap::new();
        let mut folders = vec![self.0.path().join("generated")];
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

    /// Runs what must fail, and returns what it said.
    fn refused(&self, args: &[&str], parts: &[&str]) {
        let before = self.output();
        let done = self.run(args);
        let text = said(&done);
        assert_eq!(done.status.code(), Some(2), "{args:?}: {text}");
        assert!(!text.contains("panicked"), "{text}");
        for part in parts {
            assert!(text.contains(part), "{args:?}: {part:?} is not in: {text}");
        }
        assert!(self.output() == before, "{args:?} touched the previous output");
        let left = fs::read_dir(self.0.path())
            .unwrap()
            .filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().contains(".tmp-"));
        assert_eq!(left.count(), 0, "{args:?} left a temporary folder");
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A surface table of a file, in place of the good plan's.
fn with_file(keys: &str) -> String {
    let start = GOOD.find("grating =").unwrap();
    let end = GOOD.find("[[preset]]").unwrap();
    format!("{}{keys}\n{}", &GOOD[..start], &GOOD[end..])
}

#[test]
fn plans() {
    let place = Place::new();
    let grating = r#"grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 40 }"#;
    let cases: &[(String, &[&str])] = &[
        (GOOD.replace("0.3", "0.0"), &["plan.toml:4", "height_um", "positive"]),
        (GOOD.replace("0.3", "-0.3"), &["plan.toml:4", "height_um = -0.3"]),
        (GOOD.replace("0.3", "nan"), &["plan.toml:4", "height_um"]),
        (GOOD.replace("0.3", "1e9"), &["height_um"]),
        (GOOD.replace("2.5", "0"), &["plan.toml:4", "period_um"]),
        (GOOD.replace("pixels = 40", "pixels = 12"), &["pitch", "µm"]),
        (GOOD.replace("min_nm = 400", "min_nm = 100"), &["plan.toml", "min_nm", "360"]),
        (GOOD.replace("min_nm = 400", "min_nm = 750"), &["min_nm", "750", "700"]),
        (GOOD.replace("step_nm = 100", "step_nm = 0"), &["step_nm"]),
        (GOOD.replace("terms = 5", "terms = 0"), &["plan.toml:8", "terms"]),
        (GOOD.replace("terms = 5", "terms = 100000"), &["plan.toml:8", "terms", "200"]),
        (GOOD.replace("terms = 5", "terms = \"many\""), &["terms"]),
        (GOOD.replace("terms = 5", "term = 5"), &["plan.toml:8", "term", "terms"]),
        (GOOD.replace("\"full\"", "7"), &["plan.toml:7", "mode"]),
        (GOOD.replace("\"small\"", "\"a/b\""), &["plan.toml:6", "a/b"]),
        (GOOD.replace("\"grating\"", "\"../up\""), &["plan.toml:3", "../up"]),
        (
            GOOD.replace(
                grating,
                &format!(
                    r#"{grating}
[[surface]]
name = "grating"
{grating}"#
                ),
            ),
            &["grating", "name"],
        ),
        (GOOD.replace("schema = 1", "schema = 2"), &["plan.toml:1", "schema"]),
        (GOOD.replace("schema = 1\n", ""), &["schema"]),
        (GOOD.replace("\"wgsl\"", "\"wgls\""), &["plan.toml", "wgls", "wgsl"]),
        (
            GOOD.replace("[targets]", "[optics]\nilluminant = \"D66\"\n[targets]"),
            &["illuminant", "D66", "D65"],
        ),
        (String::new(), &["plan.toml"]),
        ("schema = ".to_owned(), &["plan.toml:1"]),
    ];
    for (plan, parts) in cases {
        place.put("bad.toml", plan);
        let parts: Vec<String> =
            parts.iter().map(|part| part.replace("plan.toml", "bad.toml")).collect();
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        place.refused(&["generate", "--plan", "bad.toml"], &parts);
    }
    place.put("bad.toml", b"schema = 1 # \xff");
    place.refused(&["generate", "--plan", "bad.toml"], &["bad.toml", "UTF-8"]);
    place.refused(&["generate", "--plan", "absent.toml"], &["absent.toml"]);
    place.refused(&["generate", "--plan", "generated"], &["generated"]);
}

#[test]
fn surface_files() {
    let place = Place::new();
    let png = |colour: [u8; 3]| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let picture = image::RgbImage::from_fn(30, 20, |x, y| {
            image::Rgb(if (x, y) == (3, 4) { colour } else { [(x + y) as u8; 3] })
        });
        picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let grey = png([9; 3]);
    let npy = |shape: &str, data: &[f32]| {
        let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
        while (header.len() + 11) % 64 != 0 {
            header.push(' ');
        }
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16 + 1).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.push(b'\n');
        bytes.extend(data.iter().flat_map(|v| v.to_le_bytes()));
        bytes
    };
    let gsf = |side: usize, data: &[u8]| {
        let header = format!(
            r#"Gwyddion Simple Field 1.0
XRes = {side}
YRes = {side}
XReal = 1e-6
YReal = 1e-6
"#
        );
        let mut bytes = header.into_bytes();
        bytes.extend(vec![0; 4 - bytes.len() % 4]);
        bytes.extend(data);
        bytes
    };
    place.put("empty.png", b"");
    place.put("cut.png", &grey[..grey.len() / 2]);
    place.put("colour.png", png([200, 9, 9]));
    place.put("grey.png", &grey);
    place.put("cut.npy", &npy("(20, 30)", &[0.0; 600])[..900]);
    place.put("huge.npy", npy("(20000, 20000)", &[]));
    place.put("void.npy", npy("(20, 30)", &[f32::NAN; 600]));
    place.put("infinite.npy", npy("(20, 30)", &[f32::INFINITY; 600]));
    place.put("one.npy", npy("(1, 1)", &[0.1]));
    place.put("flat.npy", npy("(20, 30)", &[0.1; 600]));
    place.put("cut.gsf", gsf(20, &[0; 100]));
    place.put("huge.gsf", gsf(20000, &[]));
    place.put("cut.tiff", b"II*\0\x08\0\0\0\x05\0");
    place.put("scan.spm", b"\\*File list");
    let metres: Vec<u8> = [1e-7f32; 400].iter().flat_map(|h| h.to_le_bytes()).collect();
    place.put("good.gsf", gsf(20, &metres));
    let marked: Vec<f32> =
        (0..600u16).map(|i| if i == 7 { -9999.0 } else { f32::from(i % 9) }).collect();
    place.put("mark.npy", npy("(20, 30)", &marked));
    place.put("nm.txt", "# Width: 1 µm\n# Value units: nm\n1 2\n3 5\n");
    place.put("two.txt", "1 2\n3 5\n\n1 2\n3 5\n");
    place.put("comma.txt", "1,2\n3,5\n");
    fs::create_dir(place.0.path().join("folder.png")).unwrap();
    let cases: &[(&str, &[&str])] = &[
        ("file = \"absent.png\"\nsize_um = 1.0\nheight_um = 0.3", &["absent.png"]),
        ("file = \"folder.png\"\nsize_um = 1.0\nheight_um = 0.3", &["folder.png"]),
        ("file = \"empty.png\"\nsize_um = 1.0\nheight_um = 0.3", &["empty.png"]),
        ("file = \"cut.png\"\nsize_um = 1.0\nheight_um = 0.3", &["cut.png"]),
        ("file = \"colour.png\"\nsize_um = 1.0\nheight_um = 0.3", &["colour.png", "200"]),
        ("file = \"cut.npy\"\nsize_um = 1.0", &["cut.npy"]),
        ("file = \"huge.npy\"\nsize_um = 1.0", &["huge.npy", "20000"]),
        ("file = \"void.npy\"\nsize_um = 1.0", &["void.npy", "void"]),
        ("file = \"infinite.npy\"\nsize_um = 1.0", &["infinite.npy", "inf"]),
        ("file = \"one.npy\"\nsize_um = 0.05", &["one.npy"]),
        ("file = \"cut.gsf\"", &["cut.gsf"]),
        ("file = \"huge.gsf\"", &["huge.gsf", "20000"]),
        ("file = \"cut.tiff\"\nsize_um = 1.0", &["cut.tiff"]),
        (
            "file = \"flat.npy\"\nsize_um = 1.0\nheight_um = 0.3",
            &["flat.npy", "height_um", "z_unit_um"],
        ),
        ("file = \"grey.png\"\nsize_um = 1.0", &["grey.png", "height_um"]),
        ("file = \"grey.png\"\nheight_um = 0.3", &["size_um", "pixel_um"]),
        (
            r#"file = "grey.png"
height_um = 0.3
size_um = 1.0
pixel_um = 0.1"#,
            &["size_um", "pixel_um"],
        ),
        ("file = \"grey.png\"\nheight_um = 0.3\nsize_um = -1.0", &["size_um = -1"]),
        ("file = \"scan.spm\"\nsize_um = 1.0", &["`diffraction import ", "scan.spm`"]),
        ("file = \"good.gsf\"\nsize_um = 1.5", &["size_um = 1.5", "1 × 1 µm", "trust = \"plan\""]),
        ("file = \"nm.txt\"\nz_unit_um = 1.0", &["z_unit_um = 1", "0.001 µm", "Value units: nm"]),
        ("file = \"mark.npy\"\nsize_um = 1.0", &["1 pixels are -9999", "void_value = -9999"]),
        ("file = \"two.txt\"\nsize_um = 1.0", &["2 blocks", "channel"]),
        ("file = \"comma.txt\"\nsize_um = 1.0", &["the number 1.2 or the numbers 1 and 2"]),
        ("file = \"nm.txt\"\nflip = \"up\"", &["flip", "rows"]),
        ("file = \"nm.txt\"\nvoid_value = \"zero\"", &["void_value", "none"]),
        (
            "file = \"nm.txt\"\nresample_um = 0.2",
            &["resample_um = 0.2", "0.1 µm along x and y", "800 nm"],
        ),
        ("file = \"nm.txt\"\nsize_y_um = 1.0\npixel_um = 0.1", &["size_y_um and pixel_um"]),
        ("file = \"grey.png\"\nheight_um = 0.3\nsize_um = 1e9", &["size_um"]),
        (
            "file = \"grey.png\"\nheight_um = 0.3\nsize_um = 30.0",
            &["grey.png", "size_um", "pitch", "100.0000 nm"],
        ),
    ];
    for (keys, parts) in cases {
        place.put("bad.toml", with_file(keys));
        place.refused(&["generate", "--plan", "bad.toml"], parts);
    }
    // and the one that looks odd and is right: a single row is a profile
    place.put("row.npy", npy("(1, 30)", &[0.1; 30]));
    place.put("bad.toml", with_file("file = \"row.npy\"\nsize_um = 1.0"));
    let done = place.run(&["generate", "--plan", "bad.toml"]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert!(said(&done).contains("profile"), "{}", said(&done));
}

#[test]
fn outputs_and_directions() {
    let place = Place::new();
    fs::create_dir(place.0.path().join("foreign")).unwrap();
    place.put("foreign/thesis.txt", "mine");
    place.refused(&["generate", "--out", "foreign"], &["foreign", "manifest.json"]);
    assert_eq!(fs::read(place.0.path().join("foreign/thesis.txt")).unwrap(), b"mine");
    place.refused(&["generate", "--out", "plan.toml"], &["plan.toml"]);
    place.refused(&["generate", "--out", "plan.toml/deeper/out"], &["plan.toml"]);
    place.refused(&["generate", "--variant", "nothing-*"], &["nothing-*", "small"]);
    place.refused(&["generate", "--target", "wgls"], &["wgls", "wgsl"]);
    place.refused(&["generate", "--jobs", "0"], &["--jobs"]);
    place.refused(&["generate", "--jobs", "100000"], &["--jobs", "from 1 to 1024"]);
    place.refused(&["render", "--surface", "grating", "--out", "map.jpg"], &["map.jpg", ".png"]);
    place.refused(&["render", "--surface", "gratin", "--out", "map.png"], &["gratin", "grating"]);
    place.refused(&["render", "--surface", "grating", "--out", "absent/map.png"], &["absent"]);
    place.refused(
        &["render", "--surface", "grating", "--light", "95,0", "--out", "map.png"],
        &["--light"],
    );
    place.refused(
        &["render", "--surface", "grating", "--size", "0", "--out", "map.png"],
        &["--size"],
    );
    place.put("bad.csv", "theta_i,phi_i,theta_r,phi_r\n20,0,x,180\n");
    place.refused(
        &["eval", "--surface", "grating", "--directions", "bad.csv"],
        &["bad.csv:2", "theta_r", "x"],
    );
    place.put("bad.csv", "a,b\n1,2\n");
    place.refused(
        &["eval", "--surface", "grating", "--directions", "bad.csv"],
        &["bad.csv", "theta_i"],
    );
    place.refused(&["eval", "--surface", "grating", "--directions", "absent.csv"], &["absent.csv"]);
    place.put("good.csv", "theta_i,phi_i,theta_r,phi_r\n20,0,20,180\n");
    let twin = ["eval", "--surface", "grating", "--runner", "twin", "--directions", "good.csv"];
    place.refused(&[&twin[..], &["--wavelength-nm", "390"]].concat(), &["390", "400"]);
}

/// Foreign files inside our own output survive a rebuild and are listed.
#[test]
fn foreign_files_in_the_output_are_carried_over() {
    let place = Place::new();
    place.put("generated/notes.txt", "mine");
    assert_eq!(place.run(&["generate"]).status.code(), Some(0));
    assert_eq!(fs::read(place.0.path().join("generated/notes.txt")).unwrap(), b"mine");
    let check = place.run(&["generate", "--check"]);
    assert!(String::from_utf8_lossy(&check.stdout).contains("foreign notes.txt"));
}

/// Past a file-size limit nothing of the previous output is lost.
#[cfg(unix)]
#[test]
fn a_full_disk() {
    let place = Place::new();
    place.put("plan.toml", GOOD.replace("terms = 5", "terms = 9"));
    let before = place.output();
    let script =
        format!("ulimit -f 8; exec '{}' generate --no-cache", env!("CARGO_BIN_EXE_diffraction"));
    let done = Command::new("bash")
        .args(["-c", &script])
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .current_dir(place.0.path())
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(2), "{}", said(&done));
    assert!(place.output() == before);
    assert_eq!(place.run(&["generate"]).status.code(), Some(0), "the next run mends it");
}
