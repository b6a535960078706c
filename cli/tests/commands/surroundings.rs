//! `eval` under panoramas and coloured lights: where things stand, what colour they have, and which files are refused.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};

use exr::prelude::{SpecificChannels, WritableImage};

/// A mirror of silver in air, and of a dielectric.
const PLAN: &str = r#"schema = 1
[[surface]]
name = "mirror"
grating = { kind = "flat", period_um = 1.0, pixels = 16 }
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }
[optics]
source_diameter_deg = 0.53
shadowing = false
[[preset]]
name = "lobes"
mode = "adaptive"
terms = 19
"#;

/// Reflectance of the mirror at normal incidence (n = 1.5).
const REFLECTANCE: f64 = 0.04;

struct Place(tempfile::TempDir);

impl Place {
    fn new(lights: &str) -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        place.put("plan.toml", PLAN.as_bytes());
        place.put("lights.toml", format!("schema = 1\n{lights}").as_bytes());
        place
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    fn eval(&self, rest: &str) -> Output {
        let line = format!("eval --surface mirror --lights lights.toml --views views.csv {rest}");
        Command::new(env!("CARGO_BIN_EXE_diffraction"))
            .args(line.split_whitespace())
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    /// Linear sRGB of what a mirror shows to viewers, relative to its reflectance at normal incidence.
    fn seen(&self, views: &[[f64; 2]]) -> Vec<[f64; 3]> {
        let rows: String = views.iter().map(|[t, p]| format!("{t},{p}\n")).collect();
        self.put("views.csv", format!("theta_r,phi_r\n{rows}").as_bytes());
        let done = self.eval("");
        assert_eq!(done.status.code(), Some(0), "{}", said(&done));
        let text = String::from_utf8(done.stdout).unwrap();
        let rgb = |line: &str| {
            let n: Vec<f64> = line.split(',').skip(2).map(|n| n.parse().unwrap()).collect();
            [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
                .map(|row: [f64; 3]| (0..3).map(|c| row[c] * n[c]).sum::<f64>() / REFLECTANCE)
        };
        text.lines().skip(1).map(rgb).collect()
    }
}

fn said(done: &Output) -> String {
    String::from_utf8_lossy(&done.stderr).into_owned()
}

fn exr(path: &Path, [width, height]: [usize; 2], texel: impl Fn(usize, usize) -> [f32; 3] + Sync) {
    let texel = |at: exr::math::Vec2<usize>| {
        let [r, g, b] = texel(at.1, at.0);
        (r, g, b)
    };
    let image = exr::image::Image::from_channels((width, height), SpecificChannels::rgb(texel));
    image.write().to_file(path).unwrap();
}

fn hdr(path: &Path, [width, height]: [usize; 2], texel: impl Fn(usize, usize) -> [f32; 3]) {
    let pixels: Vec<image::Rgb<f32>> =
        (0..width * height).map(|i| image::Rgb(texel(i / width, i % width))).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&pixels, width, height).unwrap();
    fs::write(path, bytes).unwrap();
}

/// A map without any symmetry: every pixel has its own colour.
fn asymmetric(row: usize, column: usize) -> [f32; 3] {
    [1.0 + row as f32 / 16.0, 0.25 + column as f32 / 32.0, 0.125 * ((3 * row + column) % 7) as f32]
}

const SIZE: [usize; 2] = [32, 16];

/// A mirror shows the map's own colour where the manual says it stands: theta is that of the row, phi that of the column.
#[test]
fn a_mirror_shows_the_map_where_it_stands() {
    for (file, turned) in [("map.exr", 0.0), ("map.hdr", 0.0), ("map.exr", 33.75)] {
        let place = Place::new(&format!(
            "[[light]]\nkind = \"environment\"\nfile = \"{file}\"\nscale = 2\nrotate_deg = {turned}"
        ));
        match file {
            "map.exr" => exr(&place.path(file), SIZE, asymmetric),
            _ => hdr(&place.path(file), SIZE, asymmetric),
        }
        // near the normal, where the reflectance is that of normal incidence to 1e-3
        let places: Vec<(usize, usize)> = (0..32).map(|column| (column % 3, column)).collect();
        let views: Vec<[f64; 2]> = places
            .iter()
            .map(|(row, column)| {
                let (theta, phi) = ((*row as f64 + 0.5) * 11.25, (*column as f64 + 0.5) * 11.25);
                // the mirror direction of phi - 180°
                [theta, phi + turned]
            })
            .collect();
        let seen = place.seen(&views);
        for ((row, column), rgb) in places.iter().zip(seen) {
            let map = asymmetric(*row, *column).map(|c| 2.0 * f64::from(c));
            let most = map.into_iter().fold(0.0, f64::max);
            for c in 0..3 {
                let error = (rgb[c] - map[c]).abs() / most;
                // RGBE has 8 bits
                let allowed = if file == "map.hdr" { 6e-3 } else { 2e-3 };
                assert!(error < allowed, "{file} {row} {column}: {rgb:?} {map:?}");
            }
        }
    }
}

/// A lamp with a colour is a white lamp behind a filter: the mirror shows its colour, and three primaries add up to white.
#[test]
fn lamps_have_colours() {
    let sky = |colour: &str| format!("[[light]]\nkind = \"sky\"\nradiance = 2\n{colour}");
    let of = |text: &str| Place::new(text).seen(&[[10.0, 30.0]])[0];
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|c| (a[c] - b[c]).abs() < 4e-3);
    let red = of(&sky("colour = [0.5, 0.1, 0]"));
    assert!(near(red, [1.0, 0.2, 0.0]), "{red:?}");
    let parts = ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"].map(|c| sky(&format!("colour = {c}\n")));
    assert!(near(of(&parts.concat()), of(&sky(""))), "{:?}", of(&parts.concat()));
    // light of one direction, too
    let directed = |colour: &str| {
        let text = "[[light]]\nkind = \"direction\"\ndirection = [10, 210]\n";
        of(&format!("{text}{colour}"))
    };
    let (white, green) = (directed(""), directed("colour = [0, 1, 0]"));
    let (white, green) = (white[1], green.map(|c| c / white[1]));
    assert!(white > 1.0 && near(green, [0.0, 1.0, 0.0]), "{white} {green:?}");
}

#[test]
fn a_map_of_one_pixel_is_a_sky() {
    let place = Place::new("[[light]]\nkind = \"environment\"\nfile = \"one.exr\"");
    exr(&place.path("one.exr"), [1, 1], |_, _| [0.5, 1.0, 0.25]);
    for rgb in place.seen(&[[0.0, 0.0], [10.0, 77.0]]) {
        let error = (0..3).map(|c| (rgb[c] - [0.5, 1.0, 0.25][c]).abs()).fold(0.0, f64::max);
        assert!(error < 2e-3, "{rgb:?}");
    }
}

/// Every wrong file says which, what is wrong and what to do, and ends with exit code 2.
#[test]
fn wrong_maps_are_refused() {
    let place = Place::new("[[light]]\nkind = \"environment\"\nfile = \"map\"");
    place.put("views.csv", b"theta_r,phi_r\n0,0\n");
    let path = place.path("map");
    let refused = |wanted: &str| {
        let done = place.eval("");
        assert_eq!(done.status.code(), Some(2), "{wanted}: {}", said(&done));
        let said = said(&done);
        assert!(said.contains(wanted) && said.contains("light[1].file"), "{wanted}: {said}");
        assert!(said.contains('('), "without a remedy: {said}");
    };
    refused("cannot be read");
    for [width, height] in [[16, 16], [4, 3], [6, 1], [8, 16], [31, 16], [2, 2]] {
        exr(&path, [width, height], |_, _| [1.0; 3]);
        refused("is no panorama");
    }
    for (value, wanted) in [
        (f32::NAN, "is NaN"),
        (f32::INFINITY, "is inf"),
        (f32::NEG_INFINITY, "is -inf"),
        (1e30, "above 1e9"),
    ] {
        let spoilt =
            |row, column| if (row, column) == (3, 5) { [1.0, value, 1.0] } else { [1.0; 3] };
        exr(&path, SIZE, spoilt);
        refused(wanted);
        refused("column 5, row 3");
    }
    exr(&path, SIZE, asymmetric);
    let whole = fs::read(&path).unwrap();
    for cut in [3, 40, whole.len() / 2, whole.len() - 7] {
        place.put("map", &whole[..cut]);
        refused(if cut < 4 { "neither" } else { "cannot be decoded" });
    }
    hdr(&path, SIZE, asymmetric);
    let whole = fs::read(&path).unwrap();
    for cut in [8, whole.len() / 2, whole.len() - 3] {
        place.put("map", &whole[..cut]);
        refused("cannot be decoded");
    }
    let head = |lines: &str, size: &str| {
        let mut bytes = Vec::new();
        write!(bytes, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{lines}\n-Y {size}\n").unwrap();
        bytes.extend([128, 128, 128, 129].repeat(8 * 4));
        bytes
    };
    place.put("map", &head("", "4 +X 8"));
    assert_eq!(place.eval("").status.code(), Some(0), "{}", said(&place.eval("")));
    for (lines, size, wanted) in [
        ("", "4000 +X 8000", "cannot be decoded"),
        ("", "40000 +X 80000", "40000 rows, above the limit"),
        ("", "0 +X 0", "is no panorama"),
        ("PRIMARIES=0.7347 0.2653 0 1 0.0001 -0.077 0.32168 0.33767\n", "4 +X 8", "primaries"),
        ("COLORCORR=1 1 2\n", "4 +X 8", "colour correction"),
        ("EXPOSURE=0\n", "4 +X 8", "the exposure 0"),
    ] {
        place.put("map", &head(lines, size));
        refused(wanted);
    }
    for (bytes, wanted) in [(&b""[..], "neither"), (b"schema = 1", "neither")] {
        place.put("map", bytes);
        refused(wanted);
    }
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    refused("is a folder");
}

/// Negative values count as 0, and an exposure is divided out; both are said.
#[test]
fn what_is_changed_is_said() {
    let place = Place::new("[[light]]\nkind = \"environment\"\nfile = \"map\"");
    exr(&place.path("map"), SIZE, |_, _| [0.5, -0.5, 0.5]);
    let rgb = place.seen(&[[5.0, 0.0]])[0];
    assert!((rgb[0] - 0.5).abs() < 2e-3 && rgb[1].abs() < 2e-3, "{rgb:?}");
    assert!(said(&place.eval("")).contains("512 negative values count as 0"));
    let mut bytes = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=4\n\n-Y 4 +X 8\n".to_vec();
    bytes.extend([128, 128, 128, 129].repeat(8 * 4));
    place.put("map", &bytes);
    let rgb = place.seen(&[[5.0, 0.0]])[0];
    assert!((rgb[1] - 0.25).abs() < 2e-3, "{rgb:?}");
    assert!(said(&place.eval("")).contains("divided by its exposure, 4"));
    // a variant without the functions says what has them
    let done = place.eval("--runner twin --variant lobes");
    assert_eq!(done.status.code(), Some(2));
    assert!(said(&done).contains("\"environment\""), "{}", said(&done));
}
