//! Band-limited resampling of heights to another pitch.
//!
//! Each axis is a finite sum of waves: those of the patch where it joins itself when tiled, otherwise those of the patch
//! and its mirror image, so that a seam makes no ripples. Waves beyond the new Nyquist frequency are left out, and none
//! are added.

use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

use crate::error::Result;
use crate::surface::length::shown;
use crate::surface::{HeightField, check_pixels, facts};

/// Resamples to the largest pitch of at most `pitch_um` that divides the patch, whose size stays. Returns a note about
/// what was lost, or that nothing was gained.
pub(super) fn resample(
    field: &HeightField,
    pitch_um: f64,
    subject: &str,
) -> Result<(HeightField, String)> {
    let (columns, rows) = (field.columns(), field.rows());
    // of a profile, only the axis along it
    let count = |pixels: usize, size: f64| match pixels {
        1 => 1,
        _ => (size / pitch_um * (1.0 - 1e-9)).ceil().max(1.0) as u64,
    };
    let wanted = (count(columns, field.size_x_um()), count(rows, field.size_y_um()));
    let (new_columns, new_rows) = check_pixels(subject, wanted.0, wanted.1)?;
    let joins = facts::joins(field);
    let along_x = lines(field.heights_um(), columns, new_columns, joins[0]);
    let turned = transpose(&along_x, new_columns, rows);
    let along_y = lines(&turned, rows, new_rows, joins[1]);
    let heights = transpose(&along_y, new_rows, new_columns);
    let pitch = (field.size_x_um() / new_columns as f64, field.size_y_um() / new_rows as f64);
    let lost = 1.0 - variance(&heights) / variance(field.heights_um()).max(f64::MIN_POSITIVE);
    let words = note(field, pitch, lost.max(0.0));
    Ok((HeightField::new(new_columns, new_rows, pitch.0, pitch.1, heights)?, words))
}

fn note(field: &HeightField, pitch: (f64, f64), lost: f64) -> String {
    let old = [field.pitch_x_um(), field.pitch_y_um()];
    let nm = |um: f64| shown(um * 1e3);
    let mut words = format!(
        "resampled from a pitch of {} × {} nm to {} × {} nm",
        nm(old[0]),
        nm(old[1]),
        nm(pitch.0),
        nm(pitch.1)
    );
    let is_used = [field.columns() > 1, field.rows() > 1];
    let axes = || [0, 1].into_iter().filter(|axis| is_used[*axis]);
    let new = [pitch.0, pitch.1];
    if axes().any(|axis| new[axis] > old[axis] * (1.0 + 1e-9)) {
        words += &format!(
            ": {:.2} % of the variance of the heights were waves that the new pitch cannot hold, and are lost",
            100.0 * lost
        );
    }
    if axes().any(|axis| new[axis] < old[axis] * (1.0 - 1e-9)) {
        let finest = axes().map(|axis| 2.0 * old[axis]).fold(0.0, f64::max);
        words += &format!(
            "; nothing finer than {} nm was measured, so light that finer structure would diffract is missing",
            nm(finest)
        );
    }
    words
}

fn variance(heights: &[f64]) -> f64 {
    let count = heights.len() as f64;
    let mean = heights.iter().sum::<f64>() / count;
    heights.iter().map(|h| (h - mean) * (h - mean)).sum::<f64>() / count
}

/// Resamples every line of `old` numbers to `new`; `joins`: whether lines join themselves when tiled.
fn lines(heights: &[f64], old: usize, new: usize, joins: bool) -> Vec<f64> {
    if old == new {
        return heights.to_vec();
    }
    let (from, to) = if joins { (old, new) } else { (2 * old, 2 * new) };
    let mut planner = FftPlanner::new();
    let plan =
        Plan { forward: planner.plan_fft_forward(from), inverse: planner.plan_fft_inverse(to) };
    let mut out = Vec::with_capacity(heights.len() / old * new);
    let mut wave = Vec::with_capacity(from);
    for line in heights.chunks_exact(old) {
        wave.clear();
        wave.extend(line.iter().map(|&h| Complex64::from(h)));
        if !joins {
            wave.extend(line.iter().rev().map(|&h| Complex64::from(h)));
        }
        out.extend(plan.apply(&mut wave, to).iter().take(new).map(|c| c.re));
    }
    out
}

struct Plan {
    forward: std::sync::Arc<dyn Fft<f64>>,
    inverse: std::sync::Arc<dyn Fft<f64>>,
}

impl Plan {
    /// Keeps the waves that both lengths can hold. The one at the Nyquist frequency of the shorter is halved between its
    /// two signs, or put together from them.
    fn apply(&self, wave: &mut [Complex64], to: usize) -> Vec<Complex64> {
        let from = wave.len();
        self.forward.process(wave);
        let mut spectrum = vec![Complex64::default(); to];
        let shorter = from.min(to);
        let kept = shorter.div_ceil(2);
        spectrum[..kept].copy_from_slice(&wave[..kept]);
        for k in 1..kept {
            spectrum[to - k] = wave[from - k];
        }
        if shorter.is_multiple_of(2) {
            let half = shorter / 2;
            if to > from {
                spectrum[half] = wave[half] / 2.0;
                spectrum[to - half] = wave[half] / 2.0;
            } else {
                spectrum[half] = (wave[half] + wave[from - half]) / 2.0;
            }
        }
        self.inverse.process(&mut spectrum);
        let scale = 1.0 / from as f64;
        spectrum.iter_mut().for_each(|c| *c *= scale);
        spectrum
    }
}

fn transpose(heights: &[f64], columns: usize, rows: usize) -> Vec<f64> {
    (0..columns).flat_map(|c| (0..rows).map(move |r| heights[r * columns + c])).collect()
}
