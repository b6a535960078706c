//! The strongest period of a surface, for the order sum `gems`, which needs a grating.

use rustfft::num_complex::Complex64;

use crate::field::transform::{Bins, axes, heights_upwards_um, ifft2};
use crate::surface::HeightField;

/// Maximum frequency of a period that visible light resolves: `2/λmin` at 360 nm, cycles per µm.
const REACH_CPUM: f64 = 5.6;

/// The period of the strongest peak of the power spectrum, as a vector from one groove to the next, µm. `None` for a
/// flat surface. Among peaks that are equal within a millionth, the lowest frequency wins, then the direction along x.
pub fn strongest_period_um(height: &HeightField) -> Option<[f64; 2]> {
    let size_um = [height.size_x_um(), height.size_y_um()];
    let bins = reachable(height);
    let (low_um, high_um) = height.range_um();
    let middle_um = 0.5 * (low_um + high_um);
    let mut data: Vec<Complex64> =
        heights_upwards_um(height).iter().map(|h| Complex64::new(h - middle_um, 0.0)).collect();
    let transform = ifft2(&mut data, axes(height), bins);
    // the spectrum of real heights is symmetric, so only half of it is searched, without bin 0
    let half = (0..transform.len()).filter_map(|i| {
        let r = (i % bins.width()) as i64 - bins.r_max as i64;
        let s = (i / bins.width()) as i64 - bins.s_max as i64;
        let f = [r as f64 / size_um[0], s as f64 / size_um[1]];
        ((r, s) > (0, 0)).then(|| (transform[i].norm_sqr(), f))
    });
    let peaks: Vec<(f64, [f64; 2])> = half.collect();
    let strongest = peaks.iter().map(|p| p.0).fold(0.0, f64::max);
    let range_um = high_um - low_um;
    if strongest <= (1e-9 * range_um).powi(2) {
        return None;
    }
    let squared = |f: [f64; 2]| f[0] * f[0] + f[1] * f[1];
    let (_, f) = peaks
        .into_iter()
        .filter(|p| p.0 >= strongest * (1.0 - 1e-6))
        .min_by(|a, b| squared(a.1).total_cmp(&squared(b.1)).then(b.1[0].total_cmp(&a.1[0])))?;
    Some(f.map(|c| c / squared(f)))
}

/// Bytes that [`strongest_period_um`] takes at most, beside the heights: an estimate.
pub fn strongest_period_bytes(height: &HeightField) -> u64 {
    const COMPLEX: usize = size_of::<Complex64>();
    let (pixels, bins) = (height.heights_um().len(), reachable(height).len());
    // the heights turned over, the signal; its columns and bins; half of them with their frequencies
    let peaks = size_of::<(f64, [f64; 2])>() * bins / 2;
    let signal = COMPLEX * pixels;
    let most = (size_of::<f64>() * pixels).max(2 * COMPLEX * bins).max(COMPLEX * bins + 2 * peaks);
    (signal + most) as u64
}

/// The bins that are searched.
fn reachable(height: &HeightField) -> Bins {
    let limit = |count: usize| (count / 2).max(1);
    let all = Bins::reachable(height.size_x_um(), height.size_y_um(), REACH_CPUM, 0);
    Bins {
        r_max: all.r_max.min(limit(height.columns())),
        s_max: all.s_max.min(limit(height.rows())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Grating;
    use crate::surface::synthetic::synthesise;

    fn period(grating: Grating) -> Option<[f64; 2]> {
        strongest_period_um(&synthesise(&grating, "grating").expect("valid").field)
    }

    #[test]
    fn gratings_have_their_own_period() {
        let wave = |period_um, height_um| Grating::Sinusoidal { period_um, height_um, pixels: 60 };
        let blazed = Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 100 };
        let close = |a: Option<[f64; 2]>, b: [f64; 2]| {
            a.is_some_and(|a| (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9)
        };
        assert!(close(period(blazed), [2.5, 0.0]));
        let crossed = |a, b| Grating::Crossed { x: Box::new(a), y: Box::new(b) };
        assert!(close(period(crossed(wave(2.0, 0.1), wave(1.5, 0.2))), [0.0, 1.5]));
        assert!(close(period(crossed(wave(1.5, 0.2), wave(1.5, 0.2))), [1.5, 0.0]));
        assert_eq!(period(Grating::Flat { period_um: 2.5, pixels: 100 }), None);
    }
}
