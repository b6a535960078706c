//! The fast exact field against the definition, and the two readings of the sum over orders against each other.

use diffraction_shaders::field::{Domain, Field, Scratch, amplitude_brute, ensemble_brute};
use diffraction_shaders::plan::{Coherence, Grating};
use diffraction_shaders::random::SplitMix64;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use glam::DVec2;

fn rough(columns: usize, rows: usize) -> HeightField {
    let mut random = SplitMix64::new(7);
    let heights_um = (0..columns * rows).map(|_| 0.4 * random.share()).collect();
    HeightField::new(columns, rows, 0.07, 0.09, heights_um).expect("valid")
}

/// Columns and rows shifted round, to the right and down.
fn rolled(height: &HeightField, right: usize, down: usize) -> HeightField {
    let (columns, rows) = (height.columns(), height.rows());
    let from = |i: usize| {
        ((i / columns + rows - down) % rows) * columns + (i % columns + columns - right) % columns
    };
    let heights_um = (0..columns * rows).map(|i| height.heights_um()[from(i)]).collect();
    HeightField::new(columns, rows, height.pitch_x_um(), height.pitch_y_um(), heights_um)
        .expect("valid")
}

const F: [DVec2; 4] =
    [DVec2::ZERO, DVec2::new(0.83, 0.11), DVec2::new(-2.4, 3.9), DVec2::new(5.0, -0.01)];

/// From windows far wider than the patch to windows so narrow that the Gaussian is split; odd and even sizes.
#[test]
fn fast_field_is_the_definition_to_a_billionth() {
    for (columns, rows) in [(16, 11), (9, 24)] {
        let height = rough(columns, rows);
        for sigma_um in [16.25, 0.9, 0.07] {
            for coherence in [Coherence::Single, Coherence::Ensemble] {
                let domain = Domain {
                    coherence,
                    sigma_um: (sigma_um, sigma_um * 1.3),
                    z: (-33.0, -2.0),
                    reach_cpum: 5.0,
                };
                let field = Field::new(&height, &domain);
                let mut scratch = Scratch::default();
                for sigma_um in [sigma_um, sigma_um * 1.3] {
                    for (f, z) in F.into_iter().zip([-33.0, -17.3, -2.0, -8.0]) {
                        let single = amplitude_brute(&height, f, z, sigma_um);
                        let got = field.intensity(f, z, sigma_um, &mut scratch);
                        let error = match field.amplitude(f, z, sigma_um, &mut scratch) {
                            Some(amplitude) => (amplitude - single).norm(),
                            None => (got - ensemble_brute(&height, f, z, sigma_um)).abs(),
                        };
                        assert!(error < 1e-9, "{coherence:?} σs={sigma_um} f={f} z={z}: {error:e}");
                    }
                }
            }
        }
    }
}

/// The ensemble is the mean of `|P|²` over all positions of the window: the patch rolled under it by every pixel.
#[test]
fn ensemble_is_the_mean_over_window_positions() {
    let height = rough(10, 8);
    // a window of 0.3 µm on a patch of 0.7 × 0.72 µm: lobes overlap, positions matter
    let (sigma_um, z) = (0.3, -15.0);
    for f in [DVec2::new(0.4, 0.2), DVec2::new(1.1, -1.9)] {
        let at =
            |i: usize| amplitude_brute(&rolled(&height, i % 10, i / 10), f, z, sigma_um).norm_sqr();
        let single: Vec<f64> = (0..80).map(at).collect();
        let mean = single.iter().sum::<f64>() / 80.0;
        let ensemble = ensemble_brute(&height, f, z, sigma_um);
        assert!((mean - ensemble).abs() < 1e-12, "{mean} against {ensemble}");
        let spread = single.iter().map(|p| (p - mean).abs()).fold(0.0, f64::max);
        assert!(spread > 0.1 * mean, "positions that do not matter prove nothing");
    }
}

/// The window is centred on the patch: rolling a scan by half a patch shows another part of it; a grating looks the same.
#[test]
fn rolling_matters_to_a_scan_and_not_to_a_grating() {
    let differs = |height: &HeightField, sigma_um: f64| {
        let other = rolled(height, height.columns() / 2, height.rows() / 2);
        let relative = |f: DVec2| {
            let (a, b) = (
                amplitude_brute(height, f, -15.0, sigma_um),
                amplitude_brute(&other, f, -15.0, sigma_um),
            );
            (a.norm_sqr() - b.norm_sqr()).abs() / a.norm_sqr().max(b.norm_sqr())
        };
        [DVec2::new(0.4, 0.0), DVec2::new(0.8, 0.0)].map(relative).into_iter().fold(0.0, f64::max)
    };
    assert!(differs(&rough(24, 20), 0.35) > 0.05);
    let grating =
        synthesise(&Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 30 }, "blazed")
            .expect("valid")
            .field;
    assert!(differs(&grating, 16.25) < 1e-9);
}

/// Rows are read with `+y` up the picture: a surface that varies along one axis only diffracts along that axis, and a
/// tilted one to the side that it leans to.
#[test]
fn plus_y_is_up_the_picture() {
    let rows = 30;
    // rising towards the top row: h = H·y/d, so the facets lean towards -y and the light goes to v > 0
    let heights_um = (0..4 * rows).map(|i| 0.3 * (1.0 - (i / 4) as f64 / rows as f64)).collect();
    let height = HeightField::new(4, rows, 0.08, 0.08, heights_um).expect("valid");
    let z = -21.0;
    let order = |n: f64| amplitude_brute(&height, DVec2::new(0.0, n / 2.4), z, 16.25).norm_sqr();
    assert!(order(1.0) > 0.9 && order(-1.0) < 0.05, "{} {}", order(1.0), order(-1.0));
}
