//! `eval` and `render` under a file of lights.

use std::fs;
use std::process::{Command, Output};

const PLAN: &str = r#"schema = 1
[[surface]]
name = "mirror"
grating = { kind = "flat", period_um = 1.0, pixels = 16 }
[[surface]]
name = "cd"
grating = { kind = "lamellar", period_um = 1.6, height_um = 0.12, duty = 0.5, pixels = 64 }
[optics]
source_diameter_deg = 0.53
[[preset]]
name = "lobes"
mode = "adaptive"
terms = 19
[[preset]]
name = "fixed"
mode = "adaptive"
terms = 19
coherence_um = 65
coherence_scaling = "fixed"
[[preset]]
name = "foil"
surfaces = ["cd"]
mode = "orders"
coherence = "ensemble"
pattern = true
period_ratio = [0.6, 1.6]
depth_ratio = [0.5, 1.5]
"#;

const SUN: &str = r#"schema = 1
[[light]]
kind = "disc"
direction = [20, 0]
diameter_deg = 0.53
"#;

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        place.put("plan.toml", PLAN);
        place.put("sun.toml", SUN);
        place.put("views.csv", "theta_r,phi_r\n0,0\n20,180\n50,180\n100,0\n");
        place
    }

    fn put(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(name), text).unwrap();
    }

    fn run(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_diffraction"))
            .args(line.split_whitespace())
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    /// Rows of numbers below the header.
    fn rows(&self, line: &str) -> Vec<Vec<f64>> {
        let done = self.run(line);
        assert_eq!(done.status.code(), Some(0), "{line}: {}", said(&done));
        let text = String::from_utf8(done.stdout).unwrap();
        assert!(text.starts_with("theta_r,phi_r,X,Y,Z\n"), "{text}");
        text.lines().skip(1).map(|l| l.split(',').map(|n| n.parse().unwrap()).collect()).collect()
    }

    fn refused(&self, line: &str, wanted: &str) {
        let done = self.run(line);
        assert_eq!(done.status.code(), Some(2), "{line}: {}", said(&done));
        assert!(said(&done).contains(wanted), "{line}: {}", said(&done));
    }
}

fn said(done: &Output) -> String {
    String::from_utf8_lossy(&done.stderr).into_owned()
}

/// A mirror shows the sun's radiance times its reflectance of 4 %, where the sun is mirrored, and nothing elsewhere.
#[test]
fn a_mirror_shows_the_sun() {
    let rows = Place::new().rows("eval --surface mirror --lights sun.toml --views views.csv");
    let radius = 0.265_f64.to_radians();
    let radiance = 0.04 / (std::f64::consts::PI * radius.sin().powi(2));
    assert_eq!(rows.len(), 4);
    assert!((rows[1][3] / radiance - 1.0).abs() < 0.02, "{rows:?} {radiance}");
    for row in [0, 2, 3] {
        assert_eq!(rows[row][2..], [0.0; 3], "{rows:?}");
    }
}

/// Several lights add up; a light of one direction goes through the window, for the twin as for the reference.
#[test]
fn lights_add_up() {
    let place = Place::new();
    let direction = "[[light]]\nkind = \"direction\"\ndirection = [10, 40]\nirradiance = 2\n";
    let sky = "[[light]]\nkind = \"sky\"\nradiance = 0.5\n";
    place.put("direction.toml", &format!("schema = 1\n{direction}"));
    place.put("sky.toml", &format!("schema = 1\n{sky}"));
    place.put("all.toml", &format!("{SUN}{direction}{sky}"));
    place.put("views.csv", "theta_r,phi_r\n0,0\n10,220\n10.4,220.1\n50,180\n");
    let of = |name: &str, rest: &str| {
        let line = format!("eval --surface cd --lights {name}.toml --views views.csv {rest}");
        place.rows(&line).into_iter().map(|row| row[3]).collect::<Vec<_>>()
    };
    let (sun, one, sky, all) = (of("sun", ""), of("direction", ""), of("sky", ""), of("all", ""));
    for i in 0..4 {
        assert!((sun[i] + one[i] + sky[i] - all[i]).abs() < 1e-9 * all[i], "{i}");
    }
    let twin = of("direction", "--runner twin --variant lobes");
    assert!(one[1] > 1.0 && (twin[1] / one[1] - 1.0).abs() < 0.05, "{one:?} {twin:?}");
}

#[test]
fn what_has_no_meaning_is_refused() {
    let place = Place::new();
    let eval = "eval --surface cd --lights sun.toml --views views.csv";
    place.refused(&format!("{eval} --runner twin --variant lobes"), "or --runner exact");
    place.refused(&format!("{eval} --runner twin --variant lobes"), "mode = \"orders\"");
    place.refused(&format!("{eval} --variant fixed"), "orders would carry energy");
    place.refused(&format!("{eval} --wavelength-nm 550"), "cannot be used with");
    place.refused("eval --surface cd --lights sun.toml", "--views");
    place.refused("eval --surface cd --views views.csv", "--lights");
    place.refused("eval --surface cd", "--directions");
    place.refused(
        "render --surface cd --lights sun.toml --light 20,0 --out a.png",
        "cannot be used with",
    );
    place.put("views.csv", "theta_i,phi_i\n0,0\n");
    place.refused(eval, "the header must be \"theta_r,phi_r\"");
    place.put("views.csv", "theta_r,phi_r\n0,x\n");
    place.refused(eval, "views.csv:2: phi_r = \"x\" is not a number");
}

/// The closed forms of a variant give what the exact sum gives, of discs and of polygons, in eval and in render.
#[test]
fn a_variant_with_the_functions_is_near_the_exact_sum() {
    let place = Place::new();
    let sun = "[[preset]]\nname = \"sun\"\nmode = \"orders\"\ncoherence = \"ensemble\"\n";
    place.put("plan.toml", &format!("{PLAN}{sun}"));
    let polygon = "[[light]]\nkind = \"polygon\"\ncorners = [[10, 2.5], [34, 2.5], [40, 25], [34, 47], [10, 47]]\n";
    place.put("lamps.toml", &format!("{}{polygon}", SUN.replace("0.53", "12")));
    let views: Vec<String> = (0..30).map(|i| format!("{},{}\n", 2 * i, 175 + i % 20)).collect();
    place.put("views.csv", &format!("theta_r,phi_r\n{}", views.concat()));
    let eval = "eval --surface cd --variant sun --lights lamps.toml --views views.csv";
    let (exact, twin) = (place.rows(eval), place.rows(&format!("{eval} --runner twin")));
    let largest = exact.iter().map(|row| row[3]).fold(0.0, f64::max);
    assert!(largest > 1e-3, "{exact:?}");
    for (exact, twin) in exact.iter().zip(&twin) {
        for c in 2..5 {
            assert!((exact[c] - twin[c]).abs() < 5e-3 * largest, "{exact:?} {twin:?}");
        }
    }
    let render = "render --surface cd --variant sun --runner twin --lights lamps.toml";
    let done = place.run(&format!("{render} --size 32 --out a.png"));
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let sky = "schema = 1\n[[light]]\nkind = \"sky\"\n";
    place.put("sky.toml", sky);
    let eval = eval.replace("lamps", "sky");
    let (exact, twin) = (place.rows(&eval), place.rows(&format!("{eval} --runner twin")));
    for (exact, twin) in exact.iter().zip(&twin) {
        assert!((exact[3] - twin[3]).abs() < 0.05 * exact[3], "{exact:?} {twin:?}");
    }
    // lamps of any colour; single directions have none
    let amber = format!("{}colour = [1, 0.3, 0.05]\n", SUN.replace("0.53", "12"));
    place.put("sky.toml", &format!("{amber}{polygon}colour = [0, 0.2, 1]\n"));
    let (exact, twin) = (place.rows(&eval), place.rows(&format!("{eval} --runner twin")));
    let white = place.rows(&format!("{} --runner twin", eval.replace("sky", "lamps")));
    let (mut worst, mut apart) = (0.0_f64, 0.0_f64);
    for ((exact, twin), white) in exact.iter().zip(&twin).zip(&white) {
        for c in 2..5 {
            worst = worst.max((exact[c] - twin[c]).abs());
            apart = apart.max((exact[c] - white[c]).abs());
        }
    }
    assert!(worst < 5e-3 * largest && apart > 0.1 * largest, "{worst} {apart} {largest}");
    let ahead = "[[light]]\nkind = \"direction\"\ndirection = [20, 0]\n";
    place.put("sky.toml", &format!("schema = 1\n{ahead}colour = [1, 0.5, 0.2]\n"));
    place.refused(&format!("{eval} --runner twin"), "coloured light of one direction");
    place.refused(&format!("{eval} --runner twin"), "make it a disc of the source's width");
}

#[test]
fn a_map_under_lights_is_drawn() {
    let place = Place::new();
    place.put("bulb.toml", &SUN.replace("0.53", "10"));
    let done =
        place.run("render --surface cd --lights bulb.toml --size 64 --exposure 1 --out a.png");
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let picture = image::open(place.0.path().join("a.png")).unwrap().to_rgb8();
    let lit = picture.pixels().filter(|p| p.0.iter().any(|c| *c > 40)).count();
    assert!((5..400).contains(&lit), "{lit}");
}

/// A texel of a pattern is the surface turned and scaled: `exact` of the texel is `exact` of a surface that is made so, and the variant's
/// twin is near it. Patterns that a variant does not have are refused.
#[test]
fn a_texel_of_a_pattern_is_a_surface_of_its_own() {
    let place = Place::new();
    let own = "[[surface]]\nname = \"own\"\ngrating = { kind = \"lamellar\", period_um = 2.0, height_um = 0.15, duty = 0.5, pixels = 64 }\nrotate_deg = -30\n[optics]";
    place.put("own.toml", &PLAN.replace("[optics]", own));
    place.put("bulb.toml", &SUN.replace("0.53", "20"));
    place.put("views.csv", "theta_r,phi_r\n0,0\n20,180\n35,150\n50,180\n");
    let rest = "--lights bulb.toml --views views.csv";
    let wanted = place.rows(&format!("eval --plan own.toml --surface own {rest}"));
    for runner in ["exact", "twin --variant foil"] {
        let line = format!("eval --surface cd --runner {runner} --pattern -30,1.25,1.25 {rest}");
        let found = place.rows(&line);
        let plain = place.rows(&line.replace("--pattern -30,1.25,1.25 ", ""));
        let apart = |a: &[Vec<f64>], b: &[Vec<f64>]| {
            let all = a.iter().flatten().zip(b.iter().flatten());
            all.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let largest = wanted.iter().flat_map(|row| &row[2..]).fold(0.0, |max: f64, c| max.max(*c));
        assert!(apart(&found, &wanted) < 0.01 * largest, "{runner}: {found:?} {wanted:?}");
        assert!(apart(&plain, &wanted) > 0.1 * largest, "{runner}: {plain:?}");
    }
    for (line, wanted) in [
        ("--runner twin --variant lobes --pattern 0,1,1", "pattern = true"),
        ("--runner twin --variant foil --pattern 0,1.7,1", "period_ratio is 1.7"),
        ("--runner twin --variant foil --pattern 0,1,0.4", "depth_ratio is 0.4"),
        ("--pattern 0,1", "an angle in degrees and two ratios"),
        ("--pattern 0,nan,1", "an angle in degrees and two ratios"),
        ("--pattern 0,0,1", "an angle in degrees and two ratios"),
        ("--pattern inf,1,1", "an angle in degrees and two ratios"),
    ] {
        place.refused(&format!("eval --surface cd {line} {rest}"), wanted);
    }
}
