//! `lights.toml`: what is read, and what is refused with its place and remedy.

use std::path::Path;

use diffraction_shaders::Error;
use diffraction_shaders::input::read_lights;
use diffraction_shaders::light::{Light, Lights};

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
        (one("kind = \"environment\""), "light[1].file is missing"),
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
