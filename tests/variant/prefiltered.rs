//! Tables with the coherence window in them, against the exact field; their sampler in every language.

use std::path::Path;

use diffraction_shaders::field::comparison_directions::on_orders;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::optics::brdf_map::view_directions;
use diffraction_shaders::optics::colour_difference::{ColourDifference, colour_difference};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Auto, Plan, Sampling, Target, Variant};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner};
use diffraction_shaders::shader::emit::{BindingKind, EmittedFile, emit};
use diffraction_shaders::shader::specialise;
use diffraction_shaders::shader::template::Sources;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::{SAMPLER, SAMPLER_NAME, SPECTRUM, Table};
use diffraction_shaders::variant::Twin;
use diffraction_shaders::variant::{Form, GRID_ERROR, grid_error};

const FINGERS: &str = "{ kind = \"fingers\", size_um = 13.0, pixels = 160, pitch_um = 1.1, height_um = 0.3, seed = 3 }";
const BUMPS: &str =
    "{ kind = \"bumps\", size_um = 12.0, pixels = 150, pitch_um = 1.7, height_um = 0.4, seed = 7 }";

fn read(grating: &str, keys: &str) -> (HeightField, Variant) {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "a"
grating = {grating}
[variants]
mode = "adaptive"
basis = "optimal"
terms = 6
reconstruction = "prefiltered"
table = "f16"
coherence_um = 16
{keys}
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{text}: {e}"));
    (load(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone())
}

fn directions(height: &HeightField, variant: &Variant, theta_i: f64) -> Vec<Directions> {
    let wi = direction(theta_i, 10.0);
    let mut all: Vec<Directions> =
        view_directions(40).into_iter().map(|wr| Directions { wi, wr }).collect();
    all.extend(on_orders(height, &variant.optics, 0.0, wi, 600, 1));
    all
}

fn exact(placement: Placement<'_>, directions: &[Directions]) -> Vec<[f64; 3]> {
    Exact(placement).tristimulus(directions).unwrap()
}

/// Lobes overlap, so that the sum over isolated lobes would be refused; no number here knows the surface.
#[test]
fn colours_are_those_of_the_exact_field_at_every_angle() {
    for (name, grating) in [("fingers", FINGERS), ("bumps", BUMPS)] {
        let (height, variant) = read(grating, "");
        let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
        let twin = TwinRunner::new(placement, true).unwrap();
        for theta_i in [0.0, 60.0] {
            let directions = directions(&height, &variant, theta_i);
            let colours = twin.tristimulus(&directions).unwrap();
            let c =
                colour_difference(name, &exact(placement, &directions), &colours, None).unwrap();
            println!("{name} {theta_i}: {:?}", c.de2000);
            assert!(c.de2000.p95 <= 1.0, "{name} {theta_i}: {c:?}");
        }
    }
}

/// Nodes of the lowest level everywhere must be too few, or the others are for nothing.
#[test]
fn far_from_the_mirror_direction_few_nodes_do_not_do() {
    let (height, variant) = read(FINGERS, "");
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let form = Form::new(&variant, &height).unwrap();
    let right = specialise::tables(&form, &height, 0.0).unwrap();
    let mut wrong = right.clone();
    let few = wrong.iter_mut().find(|table| table.binding == SPECTRUM).unwrap();
    let row = 4 * few.width;
    let first = few.texels[..row].to_vec();
    few.texels[2 * row..].chunks_mut(row).for_each(|level| level.copy_from_slice(&first));
    let directions = directions(&height, &variant, 60.0);
    let exact = exact(placement, &directions);
    let by = |tables: &[Table]| -> ColourDifference {
        let twin = Twin::new(&form, tables, 0.0);
        let colours: Vec<_> = directions.iter().map(|d| twin.tristimulus(*d)).collect();
        colour_difference("nodes", &exact, &colours, None).unwrap()
    };
    let [right, wrong] = [&right, &wrong].map(|tables| by(tables).de2000.p95);
    assert!(right <= 1.0 && wrong > 3.0 * right, "{right} {wrong}");
}

/// The amplitude errs as the grid was chosen for: root mean square over directions where light is, of `|P|`.
#[test]
fn linear_interpolation_errs_as_stated() {
    let (height, variant) = read(FINGERS, "");
    let variant = Variant { terms: Auto::Value(14), ..variant };
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let grid = Form::new(&variant, &height).unwrap().series().unwrap().grid.unwrap();
    let stated = grid_error(&grid);
    assert!(stated <= GRID_ERROR && stated > 0.9 * GRID_ERROR, "{stated}");
    let directions = directions(&height, &variant, 20.0);
    let exact = Exact(placement).response(&directions, 550.0).unwrap();
    let found = TwinRunner::new(placement, false).unwrap().response(&directions, 550.0).unwrap();
    let difference = |(a, b): (&f64, &f64)| (a.sqrt() - b.sqrt()).powi(2);
    let squared: f64 = exact.iter().zip(&found).map(difference).sum();
    let relative = (squared / exact.iter().sum::<f64>()).sqrt();
    println!("{relative} of {stated}");
    // moduli differ by less than amplitudes; directions on orders are where interpolation is worst
    assert!(relative < 2.0 * stated && relative > 0.1 * stated, "{relative} {stated}");
}

/// The size of the table comes from the window, not from the patch; what no texture holds is refused with a way out.
#[test]
fn tables_do_not_grow_with_the_patch() {
    let (small, variant) = read(FINGERS, "");
    let large = FINGERS.replace("13.0", "26.0").replace("160", "320");
    let (large, _) = read(&large, "");
    let bins = |height| Form::new(&variant, height).unwrap().series().unwrap().bins;
    assert_eq!(bins(&small), bins(&large));
    let (height, variant) = read(FINGERS, "");
    let mut wide = variant.clone();
    wide.optics.coherence_um = 600.0;
    let message = Form::new(&wide, &height).unwrap_err().to_string();
    assert!(message.contains("coherence_um = 600") && message.contains("window"), "{message}");
    let cost = |v: &Variant| Form::new(v, &height).unwrap().cost();
    let filtered = Variant { sampling: Sampling::Filter, ..variant.clone() };
    assert_eq!(cost(&variant).term_fetches, 4 * cost(&filtered).term_fetches);
}

/// A sampler of its own where the language has them, at binding 5; part of its texture in GLSL; naga's heap nowhere.
#[test]
fn every_language_has_one_plain_sampler() {
    for (sampling, count) in [("filter", 1), ("load", 0)] {
        let (height, variant) = read(FINGERS, &format!("sampling = \"{sampling}\""));
        let form = Form::new(&variant, &height).unwrap();
        let tables = specialise::shapes(&form, 0.0);
        assert_eq!(tables.iter().filter(|table| table.filtered).count(), count);
        let nodes = specialise::node_count(&tables);
        let defines = specialise::defines(&variant, &form, 0.0, nodes);
        let module = specialise::shader(&Sources::builtin(), "test", &form, &defines).unwrap();
        for target in Target::all() {
            for file in emit(&module, target).unwrap() {
                let samplers = file.bindings.iter().filter(|b| b.kind == BindingKind::Sampler);
                let reads = !file.name.contains("vert");
                assert_eq!(samplers.count(), if reads { count } else { 0 }, "{}", file.name);
                check(&file, reads && count == 1);
            }
        }
    }
}

fn check(file: &EmittedFile, samples: bool) {
    if file.target == Target::Spirv {
        return;
    }
    let text = std::str::from_utf8(&file.bytes).unwrap();
    assert!(!text.contains("nagaSampler") && !text.contains("SamplerIndexArray"), "{text}");
    let function = file.name.contains(".fn.");
    let declared = match file.target {
        Target::Wgsl if function => "linear_clamp: sampler) -> vec3f {",
        Target::Wgsl => "@group(0) @binding(5) var linear_clamp: sampler;",
        Target::Hlsl if function => "\nSamplerState linear_clamp;\n",
        Target::Hlsl => "\nSamplerState linear_clamp : register(s5);\n",
        Target::Msl => "metal::sampler linear_clamp [[sampler(5)]]",
        _ => "textureLod(",
    };
    assert_eq!(text.contains(declared), samples, "{}: {text}", file.name);
    for binding in file.bindings.iter().filter(|b| b.kind == BindingKind::Sampler) {
        assert_eq!((binding.source_name.as_str(), binding.binding), (SAMPLER_NAME, SAMPLER));
        assert!(text.contains(&binding.emitted_name), "{}", file.name);
    }
}

/// The error states a pitch. With that pitch the table can be built; a little finer it cannot. Where no pitch would do, it
/// states none.
#[test]
fn a_scan_that_is_finer_than_needed_is_told_which_pitch_would_do() {
    let (_, mut variant) = read(FINGERS, "");
    variant.optics.coherence_um = 200.0;
    // as `resample_um` makes it: the size stays, so the number of pixels is whole
    let size_um = 2.4;
    let form = |pitch_um: f64| {
        let count = (size_um / pitch_um).ceil() as usize;
        let heights_um = (0..count * count).map(|i| 1e-3 * (i % 7) as f64).collect();
        let pitch_um = size_um / count as f64;
        let height = HeightField::new(count, count, pitch_um, pitch_um, heights_um).expect("valid");
        Form::new(&variant, &height).map(drop).map_err(|error| error.to_string())
    };
    let said = form(0.004).expect_err("too many samples");
    assert!(said.contains("samples on an axis, above the limit of 8192"), "{said}");
    let stated = said.split("resample_um = ").nth(1).expect("a pitch");
    let pitch_um: f64 = stated.split(' ').next().and_then(|n| n.parse().ok()).expect("a number");
    assert!(pitch_um > 0.004 && pitch_um <= 0.095, "{said}");
    if let Err(error) = form(pitch_um) {
        assert!(!error.contains("samples on an axis"), "{error}");
    }
    let finer = form(0.9 * pitch_um).expect_err("still too many");
    assert!(finer.contains("samples on an axis"), "{finer}");
    let (height, mut longer) = read(FINGERS, "");
    longer.optics.coherence_um = 4000.0;
    let said = Form::new(&longer, &height).map(drop).expect_err("too long").to_string();
    assert!(said.contains("samples on an axis") && !said.contains("resample_um"), "{said}");
}
