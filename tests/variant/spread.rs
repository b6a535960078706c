//! Wider lobes of `baked`: the width as an argument, against the exact colours of a wider window.

use std::path::Path;

use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::load_surface;
use diffraction_shaders::optics::colour_difference::{auto_exposure, colour_difference};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Plan, Variant};
use diffraction_shaders::random::SplitMix64;
use diffraction_shaders::shader::specialise;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::{Table, TableSpec, lobe_sigma};
use diffraction_shaders::variant::{
    Arguments, Form, Function, FunctionKind, Ground, SPREAD, Twin, widened,
};
use glam::{DVec2, DVec3};

const FINGERS: &str = "grating = { kind = \"fingers\", size_um = 16, pixels = 320, pitch_um = 1.1, height_um = 0.25, seed = 7 }";

fn subject(surface: &str, keys: &str) -> (HeightField, Variant) {
    let text = format!(
        "schema = 1\n[[surface]]\nname = \"a\"\n{surface}\n[optics]\ncoherence = \"ensemble\"\ncoherence_scaling = \"wavelength\"\n[[preset]]\nname = \"soft\"\nmode = \"baked\"\ntable = \"f16\"\n{keys}\n"
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap();
    (load_surface(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone())
}

/// A variant with its rounded tables.
struct Shader {
    height: HeightField,
    variant: Variant,
    form: Form,
    tables: Vec<Table>,
}

impl Shader {
    fn new(surface: &str, keys: &str) -> Shader {
        let (height, variant) = subject(surface, keys);
        let form = Form::new(&variant, &height).unwrap();
        let tables = specialise::tables(&form, &height, 0.0).unwrap();
        let tables = tables.into_iter().map(Table::rounded).collect();
        Shader { height, variant, form, tables }
    }

    fn call(&self, arguments: Arguments) -> [f64; 3] {
        Twin::new(&self.form, &self.tables, 0.0).evaluate(arguments).unwrap()
    }

    fn spread(&self, all: &[Directions], spread: f64) -> Vec<[f64; 3]> {
        let call = |d: &Directions| self.call(Arguments::Spread { directions: *d, spread });
        all.iter().map(call).collect()
    }

    fn exact(&self, all: &[Directions], spread: f64) -> Vec<[f64; 3]> {
        widened(&self.height, 0.0, &self.variant.optics, spread, all).unwrap()
    }

    /// Standard deviation of the narrowest lobes.
    fn sigma(&self) -> f64 {
        lobe_sigma((&self.variant.optics).into())
    }
}

/// Viewers all around under a light, and near the mirror direction.
fn directions(count: usize, seed: u64) -> Vec<Directions> {
    let mut random = SplitMix64::new(seed);
    let wi = direction(25.0, 40.0);
    let view = |i: usize| {
        let turn = DVec2::from_angle(6.283 * random.share());
        let plane = match i % 4 {
            0 => -wi.truncate() + 0.15 * random.share() * turn,
            _ => 0.98 * random.share().sqrt() * turn,
        };
        Directions { wi, wr: plane.extend((1.0 - plane.length_squared()).sqrt()) }
    };
    (0..count).map(view).collect()
}

fn p95(exact: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    colour_difference("spread", exact, found, auto_exposure(exact)).unwrap().de2000.p95
}

#[test]
fn scratch() {
    for (size, keys) in [
        ("", "coherence_um = 40\nspread_levels = 3"),
        ("", "coherence_um = 40\nspread_levels = 6\nspread_step = 1.4142136"),
    ] {
        let _ = size;
        let shader = Shader::new(FINGERS, keys);
        let all = directions(400, 1);
        let Form::Baked(baked) = &shader.form else { panic!() };
        println!("{keys} {:?}", baked.wide.as_ref().unwrap().axes.size());
        for width in [0.0, 0.5, 1.0, 3.0f64.sqrt(), 2.5, 15.0f64.sqrt(), 63.0f64.sqrt(), 12.0] {
            let spread = width * shader.sigma();
            println!(
                "  {width:.3}: {:.2}",
                p95(&shader.exact(&all, spread), &shader.spread(&all, spread))
            );
        }
    }
}
