//! What is drawn by the untranslated routes, and how results are compared.

use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{
    Auto, Basis, Coherence, Grating, Mode, Optics, Packing, Reconstruction, Rough, Sampling,
    TableFormat, Variant,
};
use diffraction_shaders::runner::{Runner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;

const SIZE: usize = 48;

/// Of each kind one: modes, formats, packings, coherence; and the preset `texts`.
pub fn variants() -> Vec<Variant> {
    let named = |name, change: fn(&mut Variant)| {
        let mut variant = centred(name);
        change(&mut variant);
        variant
    };
    let texts = Variant { name: "texts".to_owned(), ..Variant::texts(&Optics::standard()) };
    vec![
        centred("full"),
        named("full-single", |v| v.packing = Packing::Single),
        named("full-f16", |v| v.table = TableFormat::F16),
        named("full-f16-single", |v| {
            (v.table, v.packing) = (TableFormat::F16, Packing::Single);
        }),
        named("full-ensemble", |v| v.optics.coherence = Coherence::Ensemble),
        named("full-not-hoisted", |v| v.hoist = false),
        named("pq", |v| (v.mode, v.window_radius) = (Mode::Pq, Auto::Value(2))),
        named("adaptive", |v| v.mode = Mode::Adaptive),
        named("adaptive-f16-ensemble", |v| {
            (v.mode, v.table) = (Mode::Adaptive, TableFormat::F16);
            v.optics.coherence = Coherence::Ensemble;
        }),
        named("gems", |v| v.mode = Mode::Gems),
        named("baked", |v| (v.mode, v.table, v.bake_mib) = (Mode::Baked, TableFormat::Rgb9e5, 2.0)),
        named("baked-filtered", |v| {
            (v.mode, v.table, v.bake_mib) = (Mode::Baked, TableFormat::Rgb9e5, 2.0);
            v.sampling = Sampling::Filter;
        }),
        texts,
    ]
}

/// 19 terms about the mid-range height, 3 × 3 bins, paired, f32.
pub fn centred(name: &str) -> Variant {
    Variant {
        name: name.to_owned(),
        basis: Basis::Taylor,
        terms: Auto::Value(19),
        packing: Packing::Paired,
        reconstruction: Reconstruction::Window,
        sampling: Sampling::Load,
        hoist: true,
        ..Variant::texts(&Optics::standard())
    }
}

/// Greatest arithmetic error of `texts`: 31 terms of a series about the lowest height cancel from `exp(z H)` down to 1, each
/// rounded to 24 bits.
pub fn texts_bound(height: &HeightField) -> f64 {
    let (low_um, high_um) = height.range_um();
    let z_max = diffraction_shaders::tables::basis::max_z(380.0);
    (z_max * (high_um - low_um)).exp() * 2.0_f64.powi(-24)
}

pub fn blazed() -> HeightField {
    let grating = Grating::Blazed { period_um: 2.5, height_um: 0.25, pixels: 60 };
    synthesise(&grating, "blazed").unwrap().field
}

/// Unlike its mirror images.
pub fn fingers(height_um: f64) -> HeightField {
    let grating = Grating::Fingers(Rough {
        size_um: 5.0,
        pixels: 64,
        pitch_um: 1.1,
        height_um,
        seed: 3,
        regularity: 0.7,
        length_um: Some(2.4),
    });
    synthesise(&grating, "fingers").unwrap().field
}

/// What is compared of a runner.
pub struct Results {
    map: Vec<[f64; 3]>,
    probe: Vec<[f64; 3]>,
}

impl Results {
    pub fn of(runner: &dyn Runner) -> Results {
        // under the light of the map, and under others
        let pair = |i: u32| Directions {
            wi: rounded(direction(f64::from(i % 70), 10.0 + f64::from(i / 70) * 60.0)),
            wr: rounded(direction(f64::from(i * 31 % 85), f64::from(i * 77 % 360))),
        };
        let pairs: Vec<Directions> = (0..420).map(pair).collect();
        Results {
            map: runner.brdf_map(rounded(direction(20.0, 10.0)), SIZE).unwrap().disc(),
            probe: runner.tristimulus(&pairs).unwrap(),
        }
    }

    /// Greatest differences over the greatest expected value, of the map and of the probe.
    pub fn errors(&self, expected: &Results) -> [f64; 2] {
        [(&self.map, &expected.map), (&self.probe, &expected.probe)].map(|(got, expected)| {
            assert_eq!(got.len(), expected.len());
            let (got, expected) = (got.as_flattened(), expected.as_flattened());
            let most = expected.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            assert!(most > 0.0);
            let differences = got.iter().zip(expected).map(|(a, b)| (a - b).abs() / most);
            // what is not a number is as wrong as can be
            differences.fold(0.0, |most, d| if d <= most { most } else { d })
        })
    }
}
