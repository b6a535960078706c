//! `pattern`: maps by formula as files, read back through the library, and what is refused.

use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::process::{Command, Output};

use diffraction_shaders::input::read_pattern;
use diffraction_shaders::pattern::{GivenRanges, PatternMap, Texel};
use image::{Rgba, RgbaImage};

fn pattern(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_diffraction"));
    command.arg("pattern").args(line.split_whitespace()).current_dir(folder).output().unwrap()
}

/// The map of a command line, and what was said.
fn drawn(folder: &Path, line: &str) -> (PatternMap, String) {
    let done = pattern(folder, &format!("{line} --out map.png"));
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert_eq!(done.status.code(), Some(0), "{line}: {said}");
    let map = read_pattern(&folder.join("map.png"), &GivenRanges::default()).unwrap();
    (map, said)
}

fn at(map: &PatternMap, column: usize, row: usize) -> Texel {
    map.texels()[row * map.width() + column]
}

/// The distance of two angles on the circle.
fn apart(a: f64, b: f64) -> f64 {
    let turned = (a - b).rem_euclid(TAU);
    turned.min(TAU - turned)
}

/// Half a step of 16 bits, and what it is in the logarithm of a period from 0.6 to 1.6.
const STEP: f64 = 1e-4;

#[test]
fn circles_are_radial() {
    let folder = tempfile::tempdir().unwrap();
    let (map, said) = drawn(folder.path(), "--kind circles --size 64x48");
    assert_eq!((map.width(), map.height()), (64, 48));
    assert!(said.contains("64 × 48 texels") && said.contains("% foil"), "{said}");
    for row in 0..48 {
        for column in 0..64 {
            let texel = at(&map, column, row);
            // up is the bitangent
            let (x, y) = (column as f64 + 0.5 - 32.0, 24.0 - (row as f64 + 0.5));
            let distance = x.hypot(y);
            if distance < 23.0 {
                assert!(apart(texel.angle_rad, y.atan2(x)) < STEP, "{column} {row}: {texel:?}");
                assert!(texel.mask == 1.0 && (texel.period_ratio - 1.0).abs() < STEP);
            } else if distance > 25.0 {
                assert_eq!(texel.mask, 0.0, "{column} {row}");
            }
        }
    }
    assert!((map.foil_share() - PI * 24.0 * 24.0 / (64.0 * 48.0)).abs() < 2e-3);
    let soft = map.texels().iter().filter(|texel| texel.mask > 0.0 && texel.mask < 1.0).count();
    assert!(soft > 50, "{soft} texels at the edge");

    let (rings, _) =
        drawn(folder.path(), "--kind circles --rings 4 --size 64x64 --depth-ratio 0.5,2");
    // rings of 8 texels, at thirds of 0.6 to 1.6 and of 0.5 to 2
    for (column, third) in [(34, 1.0), (43, 2.0), (50, 1.0), (60, 2.0)] {
        let texel = at(&rings, column, 32);
        assert!((texel.period_ratio - 0.6 - third / 3.0).abs() < STEP, "{column}: {texel:?}");
        assert!((texel.depth_ratio - 0.5 - third / 2.0).abs() < STEP, "{column}: {texel:?}");
    }
    let (turned, _) = drawn(folder.path(), "--kind circles --angle-deg -90 --size 64x64");
    assert!(apart(at(&turned, 60, 31).angle_rad, 1.5 * PI) < 0.05);
}

/// A white disc on nothing, and a black one on white, with soft edges.
fn logos(folder: &Path) {
    let disc = |inside: [u8; 3], outside: [u8; 4]| {
        RgbaImage::from_fn(40, 20, |x, y| {
            let from = (f64::from(x) + 0.5 - 20.0).hypot(f64::from(y) + 0.5 - 10.0);
            let share = (8.5 - from).clamp(0.0, 1.0);
            let [r, g, b] = inside;
            let mix = |a: u8, b: u8| (share * f64::from(a) + (1.0 - share) * f64::from(b)) as u8;
            let inside = [r, g, b, 255];
            Rgba(std::array::from_fn(|c| mix(inside[c], outside[c])))
        })
    };
    disc([255; 3], [255, 255, 255, 0]).save(folder.join("white.png")).unwrap();
    disc([0; 3], [255; 4]).save(folder.join("black.png")).unwrap();
}

#[test]
fn a_logo_is_filled() {
    let folder = tempfile::tempdir().unwrap();
    logos(folder.path());
    // the picture of 40 × 20 is drawn four times as large, with 10 texels above and below
    let line = "--kind logo --size 160x100 --angle-deg 30 --period 1.2";
    let (white, said) = drawn(folder.path(), &format!("{line} --logo white.png"));
    assert!(said.contains("neither inside nor outside"), "{said}");
    let inside = at(&white, 80, 50);
    assert!(apart(inside.angle_rad, PI / 6.0) < STEP && inside.mask == 1.0, "{inside:?}");
    assert!((inside.period_ratio - 1.2).abs() < STEP);
    assert_eq!(at(&white, 5, 5).mask, 0.0);
    // the edge of the disc is where the share is a half, at the radius 8
    let area = white.foil_share() * 160.0 * 100.0;
    assert!((area / (PI * 32.0 * 32.0) - 1.0).abs() < 0.02, "{area}");
    assert!(white.texels().iter().any(|texel| texel.mask > 0.0 && texel.mask < 1.0));

    let (black, _) = drawn(folder.path(), &format!("{line} --logo black.png --invert"));
    let off =
        white.texels().iter().zip(black.texels()).filter(|(a, b)| (a.mask - b.mask).abs() > 0.3);
    assert!(off.count() < 8);

    let ground = "--ground-angle-deg 90 --ground-period 0.8";
    let (latent, _) = drawn(folder.path(), &format!("{line} --logo white.png {ground}"));
    assert_eq!(latent.foil_share(), 1.0);
    let outside = at(&latent, 5, 5);
    assert!(apart(outside.angle_rad, PI / 2.0) < STEP, "{outside:?}");
    assert!((outside.period_ratio - 0.8).abs() < STEP, "{outside:?}");
    let count = latent.texels().iter().filter(|texel| texel.angle_rad < 1.0).count() as f64;
    assert!((count / (PI * 32.0 * 32.0) - 1.0).abs() < 0.02, "{count}");
}

/// Grooves follow the curves: along a step across the direction the map stays on its curve, along the direction it leaves it.
#[test]
fn a_guilloche_follows_its_curves() {
    let folder = tempfile::tempdir().unwrap();
    let (map, _) = drawn(folder.path(), "--kind guilloche --size 512x512");
    let share = map.foil_share();
    assert!(share > 0.3 && share < 0.6, "{share}");
    // one family has the period 0.6 + 1/3, the other 0.6 + 2/3; no other groove has these
    let mut followed = [[0; 2]; 2];
    for (family, period) in [0.6 + 1.0 / 3.0, 0.6 + 2.0 / 3.0].into_iter().enumerate() {
        let is_of = |x: f64, y: f64| {
            let texel = at(&map, x as usize, y as usize);
            texel.mask > 0.0 && (texel.period_ratio - period).abs() < STEP
        };
        for row in 20..492 {
            for column in 20..492 {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                if !is_of(x, y) {
                    continue;
                }
                let (sin, cos) = at(&map, column, row).angle_rad.sin_cos();
                // rows count downwards
                for (across, (dx, dy)) in [(0, (sin, cos)), (1, (cos, -sin))] {
                    followed[family][across] += usize::from(is_of(x + 6.0 * dx, y + 6.0 * dy));
                }
            }
        }
    }
    for [along, across] in followed {
        assert!(along > 3 * across && along > 5000, "{followed:?}");
    }
    // of the other hand the curves would be left
    let angles = map.texels().iter().filter(|texel| texel.mask == 1.0).map(|t| t.angle_rad);
    assert!(angles.clone().any(|a| a < 0.1) && angles.clone().any(|a| apart(a, 4.0) < 0.1));
}

#[test]
fn flakes_are_random_and_repeat() {
    let folder = tempfile::tempdir().unwrap();
    let line = "--kind flakes --size 96x64 --cell-size 8 --period 1.1";
    let (map, _) = drawn(folder.path(), &format!("{line} --seed 5"));
    assert_eq!(map.foil_share(), 1.0);
    let mut angles: Vec<u64> = map.texels().iter().map(|texel| texel.angle_rad.to_bits()).collect();
    angles.sort_unstable();
    angles.dedup();
    assert!((90..=96).contains(&angles.len()), "{} flakes of 96", angles.len());
    let found = map.ranges().unwrap().period_ratio;
    assert!(found[0] > 1.1 * 0.86 && found[1] < 1.1 * 1.17 && found[1] > 1.1 * 1.05, "{found:?}");
    // texels of the last column mostly have the flake of the first
    let same =
        |a: usize, b: usize| (0..64).filter(|&row| at(&map, a, row) == at(&map, b, row)).count();
    assert!(same(95, 0) > 40 && same(48, 0) < 5, "{} {}", same(95, 0), same(48, 0));
    assert_eq!(drawn(folder.path(), &format!("{line} --seed 5")).0, map);
    assert_ne!(drawn(folder.path(), &format!("{line} --seed 6")).0, map);
}

#[test]
fn a_ramp_goes_through_its_ranges() {
    let folder = tempfile::tempdir().unwrap();
    let line = "--kind ramp --size 100x10 --period-ratio 0.8,1.4 --depth-ratio 0,2 --angle-deg 45";
    let (map, said) = drawn(folder.path(), line);
    for row in 0..10 {
        for column in 0..100 {
            let texel = at(&map, column, row);
            let (u, up) = ((column as f64 + 0.5) / 100.0, 1.0 - (row as f64 + 0.5) / 10.0);
            assert!((texel.period_ratio - 0.8 - 0.6 * u).abs() < STEP, "{texel:?}");
            assert!((texel.depth_ratio - 2.0 * up).abs() < STEP, "{texel:?}");
            assert!(apart(texel.angle_rad, PI / 4.0) < STEP);
        }
    }
    assert!(said.contains("100.0 % foil; period ratio 0.803 to 1.397"), "{said}");
    // 8 bits are coarser
    let (coarse, _) = drawn(folder.path(), &format!("{line} --bits 8"));
    let worst = |map: &PatternMap| apart(at(map, 0, 0).angle_rad, PI / 4.0);
    assert!(worst(&coarse) < PI / 256.0 && coarse != map);
}

#[test]
fn cells_are_square() {
    let folder = tempfile::tempdir().unwrap();
    let (map, _) = drawn(folder.path(), "--kind cells --size 40x30 --cell-size 10 --step-deg 20");
    for row in 0..30 {
        for column in 0..40 {
            let texel = at(&map, column, row);
            let (x, up) = ((column / 10) as f64, 2.0 - (row / 10) as f64);
            assert!(apart(texel.angle_rad, (20.0 * (x + up)).to_radians()) < STEP, "{texel:?}");
            let fifth = (x - up).rem_euclid(4.0) + 1.0;
            assert!((texel.period_ratio - 0.6 - 0.2 * fifth).abs() < STEP, "{texel:?}");
        }
    }
    // from a picture: black, white, grey, nothing
    let greys = [[0, 255], [255, 255], [128, 255], [255, 0]];
    let picture = RgbaImage::from_fn(4, 1, |x, _| {
        let [grey, alpha] = greys[x as usize];
        Rgba([grey, grey, grey, alpha])
    });
    picture.save(folder.path().join("greys.png")).unwrap();
    let line = "--kind cells --size 40x10 --cell-size 10 --image greys.png --angle-deg 10";
    let (map, _) = drawn(folder.path(), line);
    for (column, wanted_deg) in [(5, 10.0), (15, 100.0), (25, 10.0 + 90.0 * 128.0 / 255.0)] {
        let texel = at(&map, column, 5);
        assert!(apart(texel.angle_rad, f64::to_radians(wanted_deg)) < STEP, "{texel:?}");
        assert_eq!(texel.mask, 1.0);
    }
    assert_eq!(at(&map, 35, 5).mask, 0.0);
}

/// The sketch turns with the lamp; the map does not.
#[test]
fn a_preview_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let preview = |light: &str| {
        let line = format!("--kind circles --size 128x64 --preview preview.png --light {light}");
        let (map, _) = drawn(folder.path(), &line);
        (map, image::open(folder.path().join("preview.png")).unwrap().to_rgb8())
    };
    let (map, right) = preview("30,0");
    assert_eq!(right.dimensions(), (2 * 128 + 3 * 16, 64 + 2 * 16 + 112));
    // right of the middle the first order of 500 nm is seen, above the middle nothing
    let middle = (2 * 16 + 128 + 64, 16 + 32);
    let green = |picture: &image::RgbImage, dx: i32, dy: i32| {
        let place = (middle.0 + dx, middle.1 + dy);
        picture.get_pixel(place.0 as u32, place.1 as u32).0[1]
    };
    assert!(green(&right, 20, 0) > 150 && green(&right, 0, -20) < 40);
    let (same, above) = preview("30,90");
    assert!(green(&above, 20, 0) < 40 && green(&above, 0, -20) > 150);
    assert_eq!(same, map);
    let (_, negative) = preview("30,-90");
    assert!(green(&negative, 0, -20) > 150);
    // 125 nm
    let (_, dark) = preview("7.2,0");
    assert!(green(&dark, 20, 0) < 40);
}

#[test]
fn what_is_wrong_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    RgbaImage::from_pixel(4, 4, Rgba([0, 0, 0, 255]))
        .save(folder.path().join("black.png"))
        .unwrap();
    std::fs::write(folder.path().join("text.png"), "no picture").unwrap();
    let files = || std::fs::read_dir(folder.path()).unwrap().count();
    let before = files();
    for (line, wanted) in [
        ("--out a.png", "--kind"),
        ("--kind stars --out a.png", "guilloche"),
        ("--kind ramp", "--out"),
        ("--kind ramp --out a.exr", "must end in .png"),
        ("--kind ramp --out a.png --preview b.jpg", "must end in .png"),
        ("--kind ramp --out a.png --preview a.png", "name another"),
        ("--kind ramp --out absent/a.png", "does not exist; make it first"),
        ("--kind ramp --out a.png --size 100", "expected WxH"),
        ("--kind ramp --out a.png --size 0x10", "from 1 to 4096"),
        ("--kind ramp --out a.png --size 10x4097", "from 1 to 4096"),
        ("--kind ramp --out a.png --size 10x-1", "from 1 to 4096"),
        ("--kind ramp --out a.png --period-ratio 1.6,0.6", "must not exceed the second"),
        ("--kind ramp --out a.png --period-ratio nan,1", "two numbers"),
        ("--kind ramp --out a.png --period-ratio 1", "two numbers"),
        ("--kind ramp --out a.png --period-ratio 0,1", "from 0.001 to 1000"),
        ("--kind ramp --out a.png --depth-ratio=-1,1", "from 0 to 1000"),
        ("--kind ramp --out a.png --angle-deg nan", "expected a number"),
        ("--kind ramp --out a.png --bits 12", "8 or 16"),
        ("--kind ramp --out a.png --light 100,0", "THETA from 0 to 90"),
        ("--kind ramp --out a.png --light 1", "THETA from 0 to 90"),
        ("--kind ramp --out a.png --period-um 0", "a positive number"),
        ("--kind ramp --out a.png --seed 1", "--seed is for --kind flakes"),
        ("--kind ramp --out a.png --period 1", "--period is for --kind circles, logo"),
        ("--kind flakes --out a.png --cell-size 0", "1..=4096"),
        ("--kind circles --out a.png --rings 0", "1..=4096"),
        ("--kind circles --out a.png --rings 2 --period 1", "leave --period out"),
        ("--kind circles --out a.png --period 3", "outside of 0.6 to 1.6"),
        ("--kind circles --out a.png --period inf", "a positive number"),
        ("--kind logo --out a.png", "needs --logo FILE.png"),
        ("--kind logo --out a.png --logo absent.png", "absent.png: cannot be read"),
        ("--kind logo --out a.png --logo text.png", "cannot be decoded as PNG"),
        ("--kind logo --out a.png --logo black.png", "try --invert"),
        ("--kind logo --out a.png --logo black.png --invert --ground-period 9", "outside of 0.6"),
        ("--kind cells --out a.png --invert", "need --image"),
        ("--kind cells --out a.png --image black.png --step-deg 3", "leave --step-deg out"),
        ("--kind cells --out a.png --image .", "cannot be read"),
    ] {
        let done = pattern(folder.path(), line);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(2), "{line}: {said}");
        assert!(said.contains(wanted), "{line}: {said}");
    }
    assert_eq!(files(), before);
}
