//! A package is a function of its plan: neither the order of the request nor the number of threads shows in a byte.

use std::path::Path;

use diffraction_shaders::Compiler;
use diffraction_shaders::package::{MANIFEST, Package};
use diffraction_shaders::plan::{Plan, SurfaceSpec, Target, Variant};
use diffraction_shaders::random::SplitMix64;

/// Variants that share tables and variants that differ in every axis, on surfaces of every kind of size.
const PLAN: &str = r#"schema = 1
[[surface]]
name = "blazed"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 50 }
[[surface]]
name = "crossed"
rotate_deg = 30
[surface.grating]
kind = "crossed"
x = { kind = "lamellar", period_um = 1.6, height_um = 0.12, pixels = 40, duty = 0.69 }
y = { kind = "sinusoidal", period_um = 1.0, height_um = 0.1, pixels = 30 }
[[surface]]
name = "fingers"
grating = { kind = "fingers", size_um = 4.0, pixels = 64, pitch_um = 1.1, height_um = 0.3, seed = 1 }
[variants]
mode = ["full", "pq", "adaptive"]
terms = [5, "auto"]
window_radius = [1, "auto"]
wavelengths = [{ step_nm = 5 }, { min_nm = 400, max_nm = 700, step_nm = 50 }]
coherence_um = [20, 65]
[[preset]]
name = "other"
basis = "taylor-zero"
hoist = false
illuminant = "A"
[[preset]]
name = "ensemble"
coherence = "ensemble"
table = "f16"
packing = "single"
"#;

fn package(
    plan: &Plan,
    surfaces: &[SurfaceSpec],
    variants: &[Variant],
    targets: &[Target],
) -> Package {
    let plan = Plan {
        surfaces: surfaces.to_vec(),
        variants: variants.to_vec(),
        targets: targets.to_vec(),
        ..plan.clone()
    };
    Compiler::new(&plan).compile().unwrap_or_else(|errors| panic!("{errors}"))
}

fn in_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

#[track_caller]
fn assert_same(one: &Package, other: &Package) {
    let paths = |package: &Package| package.files().keys().cloned().collect::<Vec<_>>();
    assert_eq!(paths(one), paths(other));
    for (path, file) in one.files() {
        assert!(other.files()[path] == *file, "{path} differs");
    }
}

#[test]
fn neither_order_nor_threads_show() {
    let plan = Plan::parse(PLAN, Path::new("plan.toml")).unwrap();
    let (surfaces, variants, targets) = (&plan.surfaces, &plan.variants, &plan.targets);
    assert!(surfaces.len() == 3 && variants.len() > 25, "{} variants", variants.len());
    let one = in_threads(1, || package(&plan, surfaces, variants, targets));
    let eight = in_threads(8, || package(&plan, surfaces, variants, targets));
    assert_same(&one, &eight);

    let mut shuffled = (surfaces.clone(), variants.clone(), targets.clone());
    shuffled.0.reverse();
    shuffle(&mut shuffled.1, 0x5eed);
    assert_ne!(&shuffled.1, variants);
    shuffled.2.reverse();
    let other = in_threads(8, || package(&plan, &shuffled.0, &shuffled.1, &shuffled.2));
    assert_same(&one, &other);

    // and the comparison can fail
    let fewer = in_threads(8, || package(&plan, surfaces, &variants[1..], targets));
    assert!(fewer.bytes(MANIFEST) != one.bytes(MANIFEST));
}

/// Fisher and Yates.
fn shuffle<T>(items: &mut [T], seed: u64) {
    let mut random = SplitMix64::new(seed);
    for i in (1..items.len()).rev() {
        items.swap(i, (random.share() * (i + 1) as f64) as usize);
    }
}
