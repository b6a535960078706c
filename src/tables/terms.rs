//! The transforms of the basis functions of a surface.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use serde::Serialize;

use crate::field::transform::{Bins, GridAxis, axes, heights_upwards_um, ifft2};
use crate::surface::HeightField;
use crate::tables::basis::Expansion;

/// A grid of frequencies that does not depend on the patch. The coherence window is applied in space to the plane that
/// the patch tiles, and the product is transformed. The frequencies are so close that linear interpolation suffices.
///
/// The window is also divided by `sinc²(x/size)`, the transform of the linear interpolation, so that interpolated
/// values have no roll-off. Their only error comes from the images of the window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Grid {
    /// Samples along x and y, at the pitch of the patch.
    pub samples: [usize; 2],
    /// Extent of the samples, µm. Texels are `1/size` cycles per µm apart.
    pub size_um: [f64; 2],
    /// Standard deviation of the coherence window, µm.
    pub sigma_um: f64,
}

/// `ifft2(b_n(h))` of every term at the wanted bins, `[term][s][r]`, row-major, origin at the patch centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// The bins kept.
    pub bins: Bins,
    /// One table per term.
    pub tables: Vec<Vec<Complex64>>,
}

impl Terms {
    /// Transforms all terms. Two real functions share one complex transform, `f + i g`, and are separated by the
    /// symmetry `F(-r, -s) = F*(r, s)`. The powers of `i` are multiplied in afterwards.
    ///
    /// With a grid, they are the terms of `P(f; z)` at the grid's frequencies. Without one, they are the terms of
    /// `c_rs(z)` at the bins of the patch.
    pub fn new(
        height: &HeightField,
        expansion: &Expansion,
        bins: Bins,
        grid: Option<Grid>,
    ) -> Terms {
        let mut tables = Vec::with_capacity(expansion.terms as usize);
        // collecting cannot fail
        let _ = Terms::each::<()>(height, expansion, bins, grid, |table| {
            tables.push(table);
            Ok(())
        });
        Terms { bins, tables }
    }

    /// Like [`Terms::new`], but hands over one term after the other, so that not all of them need to be in memory. An error
    /// of `take` ends the work.
    pub fn each<E>(
        height: &HeightField,
        expansion: &Expansion,
        bins: Bins,
        grid: Option<Grid>,
        mut take: impl FnMut(Vec<Complex64>) -> Result<(), E>,
    ) -> Result<(), E> {
        if expansion.is_tabulated() {
            return curves(height, expansion, bins, grid, take);
        }
        let x: Vec<f64> = heights_upwards_um(height)
            .iter()
            .map(|h| expansion.z_max * (h - expansion.origin_um))
            .collect();
        let mut power = vec![1.0; x.len()];
        for n in (0..expansion.terms).step_by(2) {
            let next = |p: f64, x: f64, n: u32| p * x / f64::from(n + 1);
            let data: Vec<Complex64> =
                power.par_iter().zip(&x).map(|(&p, &x)| Complex64::new(p, next(p, x, n))).collect();
            power
                .par_iter_mut()
                .zip(&data)
                .zip(&x)
                .for_each(|((p, pair), &x)| *p = next(pair.im, x, n + 1));
            let both = transform(data, axes(height), bins, grid);
            let last = both.len() - 1;
            // bins run from -max to max on both axes, so the mirrored bin has the mirrored index
            let mirrored = |i: usize| both[last - i].conj();
            let even = |i: usize| times_i(0.5 * (both[i] + mirrored(i)), n);
            take((0..both.len()).into_par_iter().map(even).collect())?;
            if n + 1 < expansion.terms {
                // (Z(r) - Z*(-r))/2i is the odd one
                let odd = |i: usize| times_i(0.5 * (both[i] - mirrored(i)), n + 4);
                take((0..both.len()).into_par_iter().map(odd).collect())?;
            }
        }
        Ok(())
    }

    /// Bytes that [`Terms::each`] takes beside the heights, without what `take` keeps.
    pub(super) fn working_bytes(
        height: &HeightField,
        expansion: &Expansion,
        bins: Bins,
        grid: Option<Grid>,
    ) -> u64 {
        const COMPLEX: u64 = size_of::<Complex64>() as u64;
        let pixels = height.heights_um().len() as u64;
        // two numbers for each pixel, or three: heights and the power, or the shift
        let kept = if expansion.is_tabulated() { 24 } else { 16 } * pixels;
        let bins = bins.len() as u64;
        let signal = COMPLEX * pixels;
        let windowed = grid.map_or(0, |grid| grid.samples.iter().product::<usize>() as u64);
        // the signal, then its columns, then the bins; with a grid the signal goes before the transform
        let transformed = match grid {
            None => signal + 2 * COMPLEX * bins,
            Some(_) => (signal + COMPLEX * windowed).max(COMPLEX * (windowed + 2 * bins)),
        };
        // both terms of a pair, and what they are separated from
        kept + transformed.max(3 * COMPLEX * bins)
    }

    /// Value of a term at bin `(r, s)`.
    pub fn at(&self, term: usize, r: i64, s: i64) -> Complex64 {
        let (column, row) = (r + self.bins.r_max as i64, s + self.bins.s_max as i64);
        self.tables[term][row as usize * self.bins.width() + column as usize]
    }
}

/// The terms of a basis with functions of its own. Each needs a transform, because they are complex.
fn curves<E>(
    height: &HeightField,
    expansion: &Expansion,
    bins: Bins,
    grid: Option<Grid>,
    take: impl FnMut(Vec<Complex64>) -> Result<(), E>,
) -> Result<(), E> {
    let heights_um: Vec<f64> =
        heights_upwards_um(height).iter().map(|h| h - expansion.origin_um).collect();
    let shift: Vec<Complex64> =
        heights_um.par_iter().map(|h| Complex64::cis(expansion.centre_z() * h)).collect();
    let reach_um = if expansion.reach_um > 0.0 { expansion.reach_um } else { 1.0 };
    let table = |n: usize| {
        let Some(curve) = expansion.curves.get(n) else {
            return vec![Complex64::default(); bins.len()];
        };
        let value = |(h, shift): (&f64, &Complex64)| {
            times_i(curve.height((h / reach_um).clamp(-1.0, 1.0)) * shift, curve.turns)
        };
        let data: Vec<Complex64> = heights_um.par_iter().zip(&shift).map(value).collect();
        transform(data, axes(height), bins, grid)
    };
    (0..expansion.terms as usize).map(table).try_for_each(take)
}

/// The transform at the bins of the patch, or of the grid.
fn transform(
    mut data: Vec<Complex64>,
    patch: [GridAxis; 2],
    bins: Bins,
    grid: Option<Grid>,
) -> Vec<Complex64> {
    let Some(grid) = grid else { return ifft2(&mut data, patch, bins) };
    let lines = [0, 1].map(|axis| line(patch[axis], grid.samples[axis], grid.sigma_um));
    let [columns, rows] = &lines;
    let mut windowed = vec![Complex64::default(); columns.1.len() * rows.1.len()];
    windowed.par_chunks_mut(columns.1.len()).zip(&rows.1).for_each(|(out, (row, weight))| {
        let source = &data[row * patch[0].count..];
        for (value, (column, part)) in out.iter_mut().zip(&columns.1) {
            *value = source[*column] * (weight * part);
        }
    });
    drop(data);
    ifft2(&mut windowed, [columns.0, rows.0], bins)
}

/// One axis of a grid about the patch's centre. For every sample: the index of the patch's sample there, and the
/// window's value.
fn line(patch: GridAxis, samples: usize, sigma_um: f64) -> (GridAxis, Vec<(usize, f64)>) {
    let pitch_um = patch.period_um / patch.count as f64;
    let size_um = samples as f64 * pitch_um;
    let first = ((-0.5 * size_um - patch.start_um) / pitch_um).round();
    let axis = GridAxis {
        count: samples,
        start_um: patch.start_um + first * pitch_um,
        period_um: size_um,
    };
    let sample = |index: usize| {
        let place_um = axis.position_um(index);
        let source = (first as i64 + index as i64).rem_euclid(patch.count as i64) as usize;
        let window =
            (-0.5 * (place_um / sigma_um).powi(2)).exp() * size_um / (TAU.sqrt() * sigma_um);
        let turn = PI * place_um / size_um;
        let filter = if turn == 0.0 { 1.0 } else { turn.sin() / turn };
        (source, window / (filter * filter))
    };
    (axis, (0..samples).map(sample).collect())
}

/// `i^n · c`, exactly.
fn times_i(c: Complex64, n: u32) -> Complex64 {
    match n % 4 {
        0 => c,
        1 => Complex64::new(-c.im, c.re),
        2 => -c,
        _ => Complex64::new(c.im, -c.re),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::coefficient_brute;
    use crate::plan::Basis;

    /// With enough terms, the series equals the transform of the phase function, up to the phase of the origin.
    #[test]
    fn many_terms_give_the_transform_of_the_phase_function() {
        let heights_um: Vec<f64> = (0..35).map(|i| f64::from(i * i % 13) * 0.02).collect();
        let height = HeightField::new(7, 5, 0.06, 0.05, heights_um).expect("valid");
        for basis in [Basis::Taylor, Basis::TaylorZero] {
            let expansion = Expansion::new(basis, 1, &height, 400.0).with_error(1e-12);
            let terms = Terms::new(&height, &expansion, Bins { r_max: 5, s_max: 3 }, None);
            assert_eq!(terms.tables.len(), expansion.terms as usize);
            for z in [-29.0_f64, -8.0, 3.0] {
                let tau = z / expansion.z_max;
                for (r, s) in [(0, 0), (1, 0), (0, -2), (-5, 3), (4, 1)] {
                    let sum: Complex64 = (0..terms.tables.len())
                        .map(|n| terms.at(n, r, s) * tau.powi(n as i32))
                        .sum();
                    let want = coefficient_brute(&height, r, s, z)
                        * Complex64::cis(-z * expansion.origin_um);
                    assert!(
                        (sum - want).norm() < 1e-11,
                        "{basis:?} {r},{s} z={z}: {sum} against {want}"
                    );
                }
            }
        }
    }

    /// One missing term must be noticed, which shows that the comparison above can fail.
    #[test]
    fn a_missing_term_shows() {
        let height = HeightField::new(2, 1, 0.05, 0.05, vec![0.0, 0.4]).expect("valid");
        let expansion = Expansion::new(Basis::Taylor, 3, &height, 400.0);
        let terms = Terms::new(&height, &expansion, Bins { r_max: 0, s_max: 0 }, None);
        let tau = 20.0 / expansion.z_max;
        let sum: Complex64 = (0..3).map(|n| terms.at(n, 0, 0) * tau.powi(n as i32)).sum();
        let want =
            coefficient_brute(&height, 0, 0, 20.0) * Complex64::cis(-20.0 * expansion.origin_um);
        assert!((sum - want).norm() > 0.1);
    }
}
