//! Tables of the sum over orders: the efficiencies of a cell's orders, and moments of the light's spectrum.

use std::f64::consts::TAU;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use serde::Serialize;

use crate::field::transform::{Bins, axes, heights_upwards_um, ifft2};
use crate::optics::spectrum::Spectrum;
use crate::optics::{Matter, primary_shares};
use crate::surface::HeightField;

use super::{COEFFICIENTS, TERMS, Table, TexelFormat};

/// Change of phase between columns of efficiencies, from the lowest to the highest point. Cubic interpolation with slopes
/// errs by at most 1/384 of its fourth power: 7e-5.
const COLUMN_PHASE: f64 = 0.4;

/// Powers of the wavelength whose moments are in the table.
const MOMENTS: usize = 4;

/// Wavelength at which `t`, the variable of the moments, is zero, nm.
pub const CENTRE_NM: f64 = 580.0;
/// Unit of `t`, nm.
pub const UNIT_NM: f64 = 200.0;

/// Sizes of a table of efficiencies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EfficiencyAxes {
    /// The orders. One row for each.
    pub bins: Bins,
    /// Number of columns: equal steps of `-w/λ` from 0 to its maximum, `2/λ` at the shortest wavelength.
    pub columns: u32,
    /// Shortest wavelength, µm.
    pub min_um: f64,
    /// Under a cover or with deeper texels: wavelength in air whose greatest phase per height is the greatest here, µm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covered_um: Option<f64>,
}

impl EfficiencyAxes {
    /// The orders of a cell that can propagate at the wavelengths of a range, and as many columns as its height range
    /// needs.
    /// `most`: the greatest period and depth of a texel, relative to those of the surface.
    pub fn new(
        height: &HeightField,
        range_nm: [f64; 2],
        matter: &Matter,
        most: [f64; 2],
    ) -> EfficiencyAxes {
        let min_um = range_nm[0] * 1e-3;
        let own_um = matter.is_covered().then(|| matter.phase_min_nm(range_nm) * 1e-3);
        let covered_um = match most[1] == 1.0 {
            true => own_um,
            false => Some(own_um.unwrap_or(min_um) / most[1]),
        };
        let [width_um, height_um] = [height.size_x_um(), height.size_y_um()].map(|um| um * most[0]);
        let (low_um, high_um) = height.range_um();
        let phase = 2.0 * TAU / covered_um.unwrap_or(min_um) * (high_um - low_um);
        EfficiencyAxes {
            bins: Bins::reachable(width_um, height_um, 2.0 / min_um, 0),
            columns: (phase / COLUMN_PHASE).ceil().clamp(1.0, f64::from(u32::MAX)) as u32,
            min_um,
            covered_um,
        }
    }

    /// The wavelength in air whose greatest phase per height is the greatest here, µm: without a cover the shortest one.
    pub fn phase_min_um(&self) -> f64 {
        self.covered_um.unwrap_or(self.min_um)
    }

    /// Number of columns over which the phase from the lowest to the highest point changes by `phase`.
    pub fn columns_of(phase: f64) -> f64 {
        phase / COLUMN_PHASE
    }

    /// `z = 2πw/λ` at the left edge of a column.
    fn z(&self, column: u32) -> f64 {
        -2.0 * TAU / self.phase_min_um() * f64::from(column) / f64::from(self.columns)
    }
}

/// The table of efficiencies `|c_rs(z)|²`, 2-D. Row `(s + s_max)·(2 r_max + 1) + r + r_max`; a column reaches from its left
/// edge to that of the next. Channels: the value and its slope, per column, at the left edge; the same at the right edge.
pub fn efficiencies_table(height: &HeightField, of: &EfficiencyAxes) -> Table {
    let heights_um = heights_upwards_um(height);
    let edge = |column: u32| -> Vec<[f64; 2]> {
        let z = of.z(column);
        let transform = |factor: &dyn Fn(f64) -> Complex64| {
            let mut samples: Vec<Complex64> =
                heights_um.iter().map(|h| factor(*h) * Complex64::cis(z * h)).collect();
            ifft2(&mut samples, axes(height), of.bins)
        };
        let amplitudes = transform(&|_| Complex64::ONE);
        let slopes = transform(&|h| Complex64::new(0.0, h));
        let step = of.z(1);
        let pair =
            |(c, d): (&Complex64, &Complex64)| [c.norm_sqr(), 2.0 * (c.conj() * d).re * step];
        amplitudes.iter().zip(&slopes).map(pair).collect()
    };
    let edges: Vec<Vec<[f64; 2]>> = (0..=of.columns).into_par_iter().map(edge).collect();
    let mut texels = Vec::with_capacity(4 * of.bins.len() * of.columns as usize);
    for row in 0..of.bins.len() {
        for pair in edges.windows(2) {
            texels.extend(pair.iter().flat_map(|edge| edge[row]));
        }
    }
    Table { texels, ..efficiencies_shape(of) }
}

/// The table of efficiencies without its texels.
pub(super) fn efficiencies_shape(of: &EfficiencyAxes) -> Table {
    Table {
        name: "efficiencies",
        binding: TERMS,
        format: TexelFormat::Rgba32Float,
        width: of.columns as usize,
        height: of.bins.len(),
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    }
}

/// Number of columns of the table of moments of a range: about one per nm.
pub fn moment_columns([min_nm, max_nm]: [f64; 2]) -> usize {
    (max_nm - min_nm).ceil().max(1.0) as usize + 1
}

/// Rows of the table of moments for one light: X, Y, Z, and their parts of a column.
const MOMENT_ROWS: usize = 4;
/// Lights of the table of moments: white, and its red and green shares. The blue share is what these leave.
const LIGHTS: usize = 3;

/// Number of rows of the table of moments.
pub const MOMENT_HEIGHT: usize = LIGHTS * MOMENT_ROWS;

/// The table of moments, 2-D. Rows: X, Y, Z. Column `i` of `n`: the wavelength `λ = min + (max - min)·i/(n - 1)`. Channels `p`
/// from 0 to 3: `∫ t^p S(λ)·(x̄, ȳ, z̄)(λ) dλ` from `min` to λ, `t = (λ - 580 nm)/200 nm`. Row 3: X, Y, Z between a column and the
/// next, 0 in the last. Four rows each for S, and for its shares of red and of green, [`primary_shares`].
pub fn moments_table(spectrum: &Spectrum, range_nm: [f64; 2]) -> Table {
    /// Parts of a column in the sum.
    const PARTS: usize = 32;
    let shape = moments_shape(range_nm);
    let count = shape.width - 1;
    let step_nm = (range_nm[1] - range_nm[0]) / (count * PARTS) as f64;
    let mut sums = [[[0.0; MOMENTS]; 3]; LIGHTS];
    let mut columns = vec![sums];
    for column in 0..count {
        for part in 0..PARTS {
            let lambda_nm = range_nm[0] + ((column * PARTS + part) as f64 + 0.5) * step_nm;
            let t = (lambda_nm - CENTRE_NM) / UNIT_NM;
            let weights = spectrum.per_nm(lambda_nm);
            let [red, green, _] = primary_shares(lambda_nm).to_array();
            for (sums, share) in sums.iter_mut().zip([1.0, red, green]) {
                for (sums, weight) in sums.iter_mut().zip(weights) {
                    let mut power = share * weight * step_nm;
                    for sum in sums {
                        *sum += power;
                        power *= t;
                    }
                }
            }
        }
        columns.push(sums);
    }
    let mut texels = Vec::with_capacity(4 * shape.width * shape.height);
    for light in 0..LIGHTS {
        for row in 0..3 {
            texels.extend(columns.iter().flat_map(|sums| sums[light][row]));
        }
        for pair in columns.windows(2) {
            texels.extend((0..3).map(|row| pair[1][light][row][0] - pair[0][light][row][0]));
            texels.push(0.0);
        }
        texels.extend([0.0; 4]);
    }
    Table { texels, ..shape }
}

/// The table of moments without its texels.
pub(super) fn moments_shape(range_nm: [f64; 2]) -> Table {
    Table {
        name: "moments",
        binding: COEFFICIENTS,
        format: TexelFormat::Rgba32Float,
        width: moment_columns(range_nm),
        height: MOMENT_HEIGHT,
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    }
}
