//! Baked tables: their texels against the exact reference, their sizes, and what the twin makes of them.

use std::path::Path;

use diffraction_shaders::field::comparison_directions::standard;
use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::optics::colour_difference::{auto_exposure, colour_difference};
use diffraction_shaders::optics::{Matter, direction};
use diffraction_shaders::plan::{Plan, Variant, Wavelengths};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::BakedAxes;
use diffraction_shaders::tables::bake::{Colours, Light, bake, sharpen};
use diffraction_shaders::variant::Form;
use glam::DVec3;

const BLAZED: &str = "{ kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 60 }";
const DOMES: &str =
    "{ kind = \"bumps\", size_um = 18.0, pixels = 200, pitch_um = 2.0, height_um = 0.2, seed = 4 }";
/// Sizes at which a test takes little time.
const FEW: BakedAxes = BakedAxes {
    columns: 48,
    pages: 1,
    rows: 40,
    levels: 4,
    stretch: 8.0,
    pace: 11.0,
    least_w_squared: 0.0,
    even_w: false,
    dimmed: 0,
};
const VISIBLE: Wavelengths = Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 5.0 };

fn read(grating: &str, keys: &str) -> (HeightField, Variant) {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "a"
grating = {grating}
[variants]
mode = "baked"
{keys}
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap();
    (load(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone())
}

fn axes_of(form: &Form) -> BakedAxes {
    let Form::Baked(baked) = form else { panic!("{form:?} is not baked") };
    baked.axes
}

fn baked(height: &HeightField, variant: &Variant, axes: BakedAxes) -> Colours {
    let optics = &variant.optics;
    let light = Light { window: optics.into(), range: &VISIBLE, matter: None, pooled: false };
    bake(height, light, &optics.illuminant, axes, &|_| ()).unwrap()
}

/// Directions with a given `(u, v, w)`, the light and the viewer as high as each other.
fn directions([x, y]: [f64; 2], w: f64) -> Option<Directions> {
    let middle = DVec3::new(-x, -y, -w) * 0.5;
    let rest = 1.0 - middle.length_squared();
    let turned = DVec3::new(-y, x, 0.0).try_normalize().unwrap_or(DVec3::Y);
    (rest >= 0.0 && w < -0.02).then(|| {
        let apart = turned * rest.sqrt();
        Directions { wi: middle + apart, wr: middle - apart }
    })
}

/// Greatest difference of a table's texels from the exact colours, over the greatest colour.
fn worst(height: &HeightField, variant: &Variant, colours: &Colours) -> f64 {
    let axes = colours.axes;
    let mut cases = Vec::new();
    for level in 1..axes.levels {
        for row in (0..axes.rows - 1).step_by(3) {
            for column in (0..axes.columns).step_by(5) {
                let (radius, across) = (axes.radius(row), axes.direction(column));
                let w = axes.w(level, radius);
                let at = ((level * axes.rows + row) * axes.columns + column) as usize;
                if let Some(d) = directions(across.map(|c| c * radius), w) {
                    cases.push((d, colours.xyz[at]));
                }
            }
        }
    }
    assert!(cases.len() > 100);
    let all: Vec<Directions> = cases.iter().map(|(d, _)| *d).collect();
    let visible = Reference::VISIBLE_NM;
    let reference =
        Reference::new(height, 0.0, &variant.optics, visible, all.iter().copied()).unwrap();
    let exact = reference.tristimulus_all(&all);
    let matter = Matter::new(&variant.optics).unwrap();
    let (mut worst, mut greatest) = (0.0_f64, 0.0_f64);
    for ((d, found), exact) in cases.iter().zip(exact) {
        let gain = matter.gain(d.wi, d.wr, 550.0);
        for (found, exact) in found.iter().zip(exact.map(|c| c / gain)) {
            worst = worst.max((f64::from(*found) - exact).abs());
            greatest = greatest.max(exact);
        }
    }
    worst / greatest
}

/// Tables of wider lobes pool bins, where the others do not.
#[test]
fn pooled_bins_give_the_exact_colours() {
    let keys = "coherence = \"ensemble\"\ncoherence_scaling = \"wavelength\"\ncoherence_um = 1";
    let (height, variant) = read(DOMES, keys);
    let bake_with = |pooled| {
        let optics = &variant.optics;
        let light = Light { window: optics.into(), range: &VISIBLE, matter: None, pooled };
        bake(&height, light, &optics.illuminant, FEW, &|_| ()).unwrap()
    };
    let (pooled, plain) = (bake_with(true), bake_with(false));
    assert!(pooled != plain, "no bins were pooled");
    let found = worst(&height, &variant, &pooled);
    assert!(found < 1.5e-3, "{found:.1e}");
    let greatest = plain.xyz.iter().flatten().fold(0.0_f32, |most, c| most.max(*c));
    let apart = pooled.xyz.iter().flatten().zip(plain.xyz.iter().flatten());
    let most = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / greatest;
    println!("pooled: {found:.1e} of exact, {most:.1e} of plain");
    assert!(most < 3e-4, "{most:.1e}");
}

#[test]
fn texels_are_the_exact_colours() {
    for (grating, keys) in [
        (BLAZED, ""),
        (BLAZED, "coherence = \"ensemble\""),
        (BLAZED, "coherence_scaling = \"wavelength\"\ncoherence_um = 30"),
        (DOMES, "coherence_um = 20"),
        (DOMES, "coherence = \"ensemble\"\ncoherence_um = 30\nilluminant = \"A\""),
        (DOMES, "coherence_scaling = \"wavelength\"\ncoherence_um = 40"),
        (DOMES, "coherence_scaling = \"wavelength\"\ncoherence_um = 6"),
    ] {
        let (height, variant) = read(grating, keys);
        let colours = baked(&height, &variant, FEW);
        let found = worst(&height, &variant, &colours);
        assert!(found < 1.5e-3, "{grating} {keys}: {found:.1e}");
        // another coherence length is another table
        let (_, other) = read(grating, "coherence_um = 10");
        let other = worst(&height, &other, &colours);
        assert!(other > 3e-3, "{grating} {keys}: {other:.1e}");
    }
}

#[test]
fn tables_do_not_depend_on_the_number_of_threads() {
    let (height, variant) = read(DOMES, "");
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| sharpen(baked(&height, &variant, FEW)))
    };
    assert!(with(1) == with(3));
}

#[test]
fn sizes_follow_the_surface_the_light_and_the_error() {
    let axes = |grating: &str, keys: &str| {
        let (height, variant) = read(grating, keys);
        axes_of(&Form::new(&variant, &height).unwrap())
    };
    let plain = axes(BLAZED, "table = \"rgb9e5\"");
    assert!(plain.columns.is_multiple_of(8) && plain.pages > 1 && plain.page_columns() < 2048);
    assert!(plain.radius(plain.rows - 1) >= 2.0 && plain.radius(plain.rows - 2) < 2.0);
    let flatter = BLAZED.replace("0.3", "0.1");
    assert!(axes(&flatter, "table = \"rgb9e5\"").levels < plain.levels);
    assert!(axes(BLAZED, "table = \"rgb9e5\"\ncoherence_um = 20").columns * 3 < plain.columns);
    let coarse = axes(BLAZED, "table = \"rgb9e5\"\nbake_error = 2");
    assert!(coarse.texels() * 5 < plain.texels() && coarse.texels() * 9 > plain.texels());
    for (table, bytes) in [("f32", 16), ("f16", 8), ("rgb9e5", 4)] {
        for mib in [0.5, 3.0, 32.0] {
            let keys = format!("table = \"{table}\"\nbake_mib = {mib}\nbake_error = 0.1");
            let (height, variant) = read(BLAZED, &keys);
            let form = Form::new(&variant, &height).unwrap();
            let found = axes_of(&form).texels() * bytes;
            let most = (mib * f64::from(1 << 20)) as u64;
            assert!(found <= most && found * 5 > most * 4, "{keys}: {found}");
            assert_eq!(form.cost().table_bytes, found);
        }
    }
}

#[test]
fn maps_are_as_good_as_was_asked() {
    for (grating, keys) in [(BLAZED, ""), (DOMES, "coherence_um = 30")] {
        let p95 = |error: f64| {
            let keys = format!("table = \"rgb9e5\"\nbake_error = {error}\n{keys}");
            let (height, variant) = read(grating, &keys);
            let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
            let twin = TwinRunner::new(placement, true).unwrap();
            let light = rounded(direction(20.0, 10.0));
            let all = standard(&height, &variant.optics, 0.0, light, 24);
            let visible = Reference::VISIBLE_NM;
            let reference =
                Reference::new(&height, 0.0, &variant.optics, visible, all.iter().copied())
                    .unwrap();
            let exact = reference.tristimulus_all(&all);
            let found = twin.tristimulus(&all).unwrap();
            colour_difference("baked", &exact, &found, auto_exposure(&exact)).unwrap().de2000.p95
        };
        let (fine, coarse) = (p95(1.0), p95(8.0));
        assert!(fine < 1.5, "{grating}: {fine}");
        assert!(coarse > 1.5 * fine, "{grating}: {coarse} and {fine}");
    }
}

#[test]
fn what_it_has_not_is_told() {
    let (height, variant) = read(BLAZED, "bake_mib = 1");
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let up = Directions { wi: DVec3::Z, wr: DVec3::Z };
    let message = TwinRunner::new(placement, true).unwrap().response(&[up], 550.0).unwrap_err();
    assert!(message.to_string().contains("has no wavelength axis"), "{message}");
}
