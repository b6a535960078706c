//! The amplitude of one bin in f64; see `templates/bins.wgsl`.

use glam::DVec2;
use rustfft::num_complex::Complex64;

use crate::plan::Packing;
use crate::tables::Series;

use super::Twin;

/// The sum over terms of coefficient times table at one bin: `c_rs(z)`, divided by the scale of the first term.
pub fn bin_amplitude(twin: &Twin<'_>, series: &Series, bin: DVec2, argument: f64) -> Complex64 {
    let column = bin.x as i64 + series.bins.r_max as i64;
    let row = bin.y as i64 + series.bins.s_max as i64;
    let paired = series.packing == Packing::Paired;
    let load = |layer: usize| {
        let [re, im, next_re, next_im] = twin.terms.load(column, row, layer);
        (Complex64::new(re, im), Complex64::new(next_re, next_im))
    };
    let layers = series.layers() as usize;
    let table = twin.coefficients;
    let mut sum = Complex64::default();
    if table.width == 0 {
        // Horner's rule
        for (first, second) in (0..layers).rev().map(load) {
            if paired {
                sum = sum * argument + second;
            }
            sum = sum * argument + first;
        }
        return sum;
    }
    let index = (argument as i64).min(table.width as i64 - 2);
    let part = argument - index as f64;
    for row in 0..table.height {
        let (before, after) =
            (table.load(index, row as i64, 0), table.load(index + 1, row as i64, 0));
        let four: [f64; 4] = std::array::from_fn(|c| before[c] + part * (after[c] - before[c]));
        // layers beyond the last read as zero
        if paired {
            let ((a, b), (c, d)) = (load(2 * row), load(2 * row + 1));
            sum += a * four[0] + b * four[1] + c * four[2] + d * four[3];
        } else {
            sum += (0..4).map(|c| load(4 * row + c).0 * four[c]).sum::<Complex64>();
        }
    }
    sum
}
