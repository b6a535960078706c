//! The command `scene` under lights: what is refused, and pictures that are not black.

use std::fs;
use std::path::Path;

use crate::{folder_with, run, without_driver};

const PLAN: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "lamellar", period_um = 1.6, height_um = 0.12, pixels = 32, duty = 0.5 }
[[preset]]
name = "orders"
mode = "orders"
coherence = "ensemble"
source_diameter_deg = 0.53
[[preset]]
name = "star"
mode = "orders"
lights = ["direction"]
source_diameter_deg = 0.53
[[preset]]
name = "fixed"
"#;

const SUN: &str = "[[light]]\nkind = \"disc\"\ndirection = [60, 60]\ndiameter_deg = 0.53\n";
const WINDOW: &str = "[[light]]\nkind = \"polygon\"\ncorners = [[40, 70], [40, 110], [70, 110], [70, 70]]\nradiance = 0.01\n";

const STUDIO: &str = "[[light]]\nkind = \"environment\"\nstudio = \"window\"\nrotate_deg = 90\n";

fn scene(folder: &Path, lights: &str, options: &str) -> (Option<i32>, String) {
    fs::write(folder.join("lights.toml"), format!("schema = 1\n{lights}")).unwrap();
    let line = format!("scene --surface a --mesh sphere --size 64x48 {options}");
    let done = run(folder, &line.split(' ').collect::<Vec<_>>());
    if without_driver(&done) {
        return (None, String::new());
    }
    (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
}

#[test]
fn lights_that_cannot_be_shown_are_refused_with_a_remedy() {
    let folder = folder_with(PLAN);
    let sky = "[[light]]\nkind = \"sky\"\n";
    let of = |variant: &str, more: &str| {
        format!("--variant {variant} --lights lights.toml --out a.png{more}")
    };
    for (lights, options, expected) in [
        (
            SUN,
            of("fixed", ""),
            "light 1: the variant fixed has no function for a light of kind \"disc\" (use a variant with mode = \"orders\"",
        ),
        (
            WINDOW,
            of("star", ""),
            "the variant star has no function for a light of kind \"polygon\"",
        ),
        (
            sky,
            of("star", ""),
            "lights.toml: light 1: the variant star has no function for a light of kind \"sky\"",
        ),
        (
            STUDIO,
            of("star", ""),
            "lights.toml: the variant star has no function for a light of kind \"environment\"",
        ),
        (
            "[[light]]\nkind = \"direction\"\ndirection = [20, 0]\ncolour = [1, 0.5, 0]\n",
            of("orders", ""),
            "light 1: a light of kind \"direction\" has the colour [1.000, 0.500, 0.000]",
        ),
        (STUDIO, of("orders", " --no-diffraction --truth"), "cannot be used with"),
        (&SUN.repeat(5), of("orders", ""), "has 5 lights of kind \"disc\""),
        (SUN, of("orders", " --light 0,0,1"), "cannot be used with"),
        (SUN, of("orders", " --light-diameter-deg 1"), "cannot be used with"),
        (SUN, of("orders", " --filter footprint"), "orders: has no function for wider lobes"),
        (SUN, of("orders", " --filter both"), "orders: has no function for wider lobes"),
        (SUN, of("orders", " --sweep lights"), "has lights of its own"),
        ("", "--variant orders --sweep zoom".to_owned(), "its pictures need --out"),
        ("", of("orders", ""), "has no light"),
        (
            "",
            "--variant fixed --sweep flicker".to_owned(),
            "spread_levels = \"auto\", or --filter supersample",
        ),
        (
            "",
            "--variant orders --light-diameter-deg 0.001 --out a.png".to_owned(),
            "from 0.02 to 179.9",
        ),
    ] {
        let (code, said) = scene(folder.path(), lights, &options);
        assert_eq!(code, Some(2), "{options}: {said}");
        assert!(said.contains(expected), "{options}: {said}");
        assert!(!folder.path().join("a.png").exists());
    }
}

/// The window of the studio stands behind the body, blue and bright; without it the corners are black.
#[test]
fn a_studio_is_the_background_and_lights_the_body() {
    let folder = folder_with(PLAN);
    let mut seen = Vec::new();
    for more in ["", " --no-background", " --filter supersample"] {
        let options = "--variant orders --lights lights.toml --no-diffraction --out a.png";
        let (code, said) = scene(folder.path(), STUDIO, &format!("{options}{more}"));
        let Some(code) = code else { return };
        assert_eq!(code, 0, "{more}: {said}");
        let file = fs::File::open(folder.path().join("a.png")).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut texels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut texels).unwrap();
        let samples = reader.info().color_type.samples();
        let of = |x: usize, y: usize| texels[(64 * y + x) * samples..][..3].to_vec();
        // a corner above the middle of the window, and the body
        seen.push((of(18, 3), of(32, 24)));
    }
    let [(with, body), (without, same), (fine, _)] = &seen[..] else { panic!("{seen:?}") };
    assert!(with[2] > 200 && with[2] > with[0], "{seen:?}");
    assert!(*without == [0, 0, 0] && body == same && body[1] > 20, "{seen:?}");
    assert!(with.iter().zip(fine).all(|(a, b)| a.abs_diff(*b) < 12), "{seen:?}");
}

/// Whatever power a file states, the body is neither black nor white.
#[test]
fn pictures_are_exposed_for_their_lights() {
    let folder = folder_with(PLAN);
    let single = SUN.replace("disc", "direction").replace("diameter_deg = 0.53\n", "");
    let cases = [
        (SUN, "--variant orders --lights lights.toml", None),
        (WINDOW, "--variant orders --lights lights.toml", None),
        (&single, "--variant fixed --lights lights.toml", None),
        (SUN, "--variant orders", None),
        (SUN, "--variant fixed", Some("fixed has no function for discs")),
        (SUN, "--variant fixed --light-diameter-deg 0", None),
    ];
    for (lights, options, note) in cases {
        let (code, said) = scene(folder.path(), lights, &format!("{options} --out a.png"));
        let Some(code) = code else { return };
        assert_eq!(code, 0, "{options}: {said}");
        assert_eq!(said.contains("has no function for discs"), note.is_some(), "{options}: {said}");
        assert!(said.contains(note.unwrap_or("exposure")), "{options}: {said}");
        let file = fs::File::open(folder.path().join("a.png")).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut texels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut texels).unwrap();
        let samples = reader.info().color_type.samples();
        // of the half of the sphere that the light reaches
        let mut greens: Vec<u8> = texels.chunks(samples).map(|texel| texel[1]).collect();
        greens.sort_unstable();
        let bright = greens[greens.len() * 9 / 10];
        assert!((60..230).contains(&bright), "{options}: {bright}");
    }
}
