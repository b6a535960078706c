//! `lights.toml`: what is read, and what is refused with its place and remedy.

use std::path::Path;

use diffraction_shaders::Error;
use diffraction_shaders::input::read_lights;
use diffraction_shaders::light::{LampSearch, Light, Lights, Panorama, Studio};

fn lights(text: &str) -> Lights {
    Lights::parse(text, Path::new("lights.toml"), &|_| Err(Error::new("file", "absent"))).unwrap()
}

fn errors(text: &str) -> String {
    let errors =
        Lights::parse(text, Path::new("lights.toml"), &|_| Err(Error::new("file", "absent")))
            .expect_err(text);
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_kind_is_read_with_its_defaults() {
    let read = lights(
        r#"
schema = 1
[[light]]
kind = "direction"
direction = [20, 0]
[[light]]
kind = "disc"
direction = [90, -90]
diameter_deg = 0.53
irradiance = 2.5
colour = [1, 1.0, 1]
[[light]]
kind = "polygon"
corners = [[10, 0], [30, 40], [30, 0]]
radiance = 3
[[light]]
kind = "sky"
"#,
    );
    let kinds: Vec<&str> = read.all.iter().map(Light::kind).collect();
    assert_eq!(kinds, ["direction", "disc", "polygon", "sky"]);
    assert_eq!((read.directions().count(), read.with_size().count()), (1, 3));
    let Light::Disc { cap, irradiance } = &read.all[1] else { panic!("{read:?}") };
    assert_eq!(*irradiance, 2.5);
    assert!((cap.radius_rad - 0.265_f64.to_radians()).abs() < 1e-15);
    assert!((cap.axis + glam::DVec3::Y).length() < 1e-12, "{cap:?}");
    assert!(matches!(read.all[3], Light::Sky { radiance: 1.0 }));
}

/// A sky of radiance 1 with a sun of some pixels.
fn sunny() -> Panorama {
    let (width, height) = (360, 180);
    let texel = |i: usize| {
        let (row, column) = (i / width, i % width);
        let is_sun = (58..62).contains(&row) && (200..204).contains(&column);
        if is_sun { [4000.0, 3000.0, 2000.0] } else { [1.0; 3] }
    };
    Panorama { width, height, texels: (0..width * height).map(texel).collect() }
}

/// Without a word a map is what it is; a command may have another default, and the file has the last word.
#[test]
fn lamps_leave_a_map_only_if_someone_says_so() {
    let read = |keys: &str, by_default| {
        let text = format!(
            "schema = 1\n[[light]]\nkind = \"environment\"\nfile = \"sun.exr\"\nscale = 0.5\nrotate_deg = 90\n{keys}"
        );
        let open = |_: &Path| Ok((sunny(), Vec::new()));
        Lights::parse_with(&text, Path::new("lights.toml"), &open, by_default).unwrap()
    };
    let kinds = |lights: &Lights| lights.all.iter().map(Light::kind).collect::<Vec<_>>();
    for (keys, by_default, taken) in [
        ("", LampSearch::None, false),
        ("", LampSearch::Auto, true),
        ("lamps = \"none\"", LampSearch::Auto, false),
        ("lamps = \"auto\"", LampSearch::None, true),
        ("lamp_threshold = 100", LampSearch::None, true),
        ("lamps = \"auto\"\nlamp_threshold = 100", LampSearch::None, true),
        ("lamp_threshold = 1990", LampSearch::Auto, false),
    ] {
        let found = read(keys, by_default);
        let Light::Environment(map) = &found.all[0] else { panic!("{found:?}") };
        if !taken {
            assert_eq!(kinds(&found), ["environment"], "{keys}");
            assert_eq!(*map.panorama, sunny());
            assert_eq!(found.notes.is_empty(), keys != "lamp_threshold = 1990", "{found:?}");
            continue;
        }
        assert_eq!(kinds(&found), ["environment", "disc"], "{keys}");
        assert!(map.panorama.texels.iter().flatten().all(|v| *v <= 1.0));
        let note = found.notes.concat();
        let threshold = if keys.contains("100") { "100.0000, as given" } else { "mean" };
        // the middle of the four rows, and of the four columns, turned by 90°
        for part in ["light[1]", "[60.0", ", 112.00]", threshold, "° wide", "lamps = \"none\""] {
            assert!(note.contains(part), "{part}: {note}");
        }
        let (Light::Disc { cap, irradiance }, colour) = found.all[1].white() else {
            panic!("{found:?}")
        };
        // half of the texels times their solid angles
        let part = 16.0 * 1_f64.to_radians().powi(2) * 60_f64.to_radians().sin();
        let expected = 0.5 * part * glam::DVec3::new(3999.0, 2999.0, 1999.0);
        let off = (colour * *irradiance / expected - 1.0).abs().max_element();
        assert!(off < 2e-3, "{colour} {irradiance} {expected}");
        assert!((cap.radius_rad.to_degrees() - 2.15).abs() < 0.2, "{cap:?}");
    }
}

#[test]
fn studios_are_maps_without_a_file() {
    for (word, studio) in Studio::WORDS {
        let read = lights(&format!(
            "schema = 1\n[[light]]\nkind = \"environment\"\nstudio = \"{word}\"\nrotate_deg = 30"
        ));
        let Light::Environment(found) = &read.all[0] else { panic!("{read:?}") };
        assert_eq!((found.scale, found.rotate_deg), (1.0, 30.0));
        assert_eq!(*found.panorama, studio.panorama(1024));
    }
}

#[test]
fn what_is_wrong_is_named_with_line_and_remedy() {
    let one = |body: &str| format!("schema = 1\n[[light]]\n{body}\n");
    for (text, wanted) in [
        (String::new(), "lights.toml: has no light"),
        (
            "schema = 2\n[[light]]\nkind = \"sky\"".to_owned(),
            "lights.toml:1: schema = 2: must be 1",
        ),
        ("schema = 1\nlight = 3".to_owned(), "write [[light]] with two brackets"),
        ("schema = 1\n[light]\nkind = \"sky\"".to_owned(), "write [[light]] with two brackets"),
        (one("direction = [1, 2]"), "lights.toml:2: light[1].kind is missing"),
        (one("kind = \"lamp\""), "lights.toml:3: light[1].kind = \"lamp\": unknown value"),
        (one("kind = \"environment\""), "lights.toml:2: light[1]: has neither file nor studio"),
        (
            one("kind = \"environment\"\nfile = \"x\"\nstudio = \"window\""),
            "lights.toml:5: light[1].studio = \"window\": stands beside a file",
        ),
        (one("kind = \"environment\"\nstudio = \"windows\""), "did you mean \"window\"?"),
        (one("kind = \"environment\"\nstudio = 3"), "is an integer"),
        (one("kind = \"environment\"\nstudio = \"window\"\nlamps = \"sun\""), "unknown value"),
        (
            one("kind = \"environment\"\nstudio = \"window\"\nlamp_threshold = 0"),
            "light[1].lamp_threshold = 0: must be above 0",
        ),
        (
            one(
                "kind = \"environment\"\nstudio = \"window\"\nlamps = \"none\"\nlamp_threshold = 9",
            ),
            "stands beside lamps = \"none\"",
        ),
        (one("kind = \"sky\"\nlamps = \"auto\""), "unknown key light[1].lamps"),
        (one("kind = \"environment\"\nfile = \"x\"\nscale = -1"), "light[1].scale = -1: must be"),
        (one("kind = \"environment\"\nfile = \"x\"\nrotate_deg = 400"), "must be from -360"),
        (one("kind = \"environment\"\nfile = 3"), "light[1].file"),
        (one("kind = \"sky\"\nradiance = -1"), "light[1].radiance = -1: must be from 0"),
        (one("kind = \"sky\"\nradiance = nan"), "light[1].radiance = nan: must be from 0"),
        (one("kind = \"sky\"\nradiance = 1e300"), "must be from 0 to 1e6"),
        (one("kind = \"sky\"\nirradiance = 1"), "unknown key light[1].irradiance"),
        (one("kind = \"sky\"\ncolour = [1, -1, 0]"), "must be from 0 to 1e6"),
        (one("kind = \"sky\"\ncolour = [1, 0]"), "is not three numbers"),
        (one("kind = \"sky\"\ncolour = \"red\""), "is a string"),
        (one("kind = \"direction\""), "light[1].direction is missing"),
        (one("kind = \"direction\"\ndirection = [200, 0]"), "must be from 0 to 180"),
        (one("kind = \"direction\"\ndirection = [20]"), "is not two numbers"),
        (one("kind = \"direction\"\ndirection = [20, inf]"), "must be from -360 to 360"),
        (one("kind = \"disc\"\ndirection = [20, 0]"), "light[1].diameter_deg is missing"),
        (one("kind = \"disc\"\ndirection = [20, 0]\ndiameter_deg = 0"), "must be from 0.012"),
        (one("kind = \"disc\"\ndirection = [20, 0]\ndiameter_deg = 0.011"), "a narrower light is"),
        (
            one("kind = \"disc\"\ndirection = [20, 0]\ndiameter_deg = 180"),
            "a whole hemisphere a sky",
        ),
        (one("kind = \"polygon\"\ncorners = [[1, 2], [3, 4]]"), "has 2 corners"),
        (one("kind = \"polygon\"\ncorners = [[9, 0], [9, 0], [9, 90]]"), "coincide"),
        (
            one("kind = \"polygon\"\ncorners = [[10, 0], [30, 0], [12, 20], [30, 40]]"),
            "is not convex at corner",
        ),
        (
            one("kind = \"polygon\"\ncorners = [[90, 0], [90, 120], [90, 240]]"),
            "wider than a hemisphere",
        ),
        ("schema = 1\n[[light".to_owned(), "not valid TOML"),
    ] {
        let found = errors(&text);
        assert!(found.contains(wanted), "{text}\n{found}");
        assert!(found.contains('('), "without a remedy: {found}");
    }
    let many = "[[light]]\nkind = \"sky\"\n".repeat(65);
    assert!(errors(&format!("schema = 1\n{many}")).contains("more than 64 lights"));
}

#[test]
fn what_is_no_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (path, wanted) in [
        (folder.path().to_owned(), "is a folder"),
        (folder.path().join("absent.toml"), "cannot be read"),
        (Path::new("/dev/zero").to_owned(), "is not a regular file"),
    ] {
        let found = read_lights(&path).expect_err("refused");
        assert!(found[0].to_string().contains(wanted), "{found:?}");
    }
}
