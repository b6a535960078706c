//! The one table of what comparisons may differ by.

use std::f64::consts::{FRAC_2_PI, TAU};

use diffraction_shaders::plan::{Basis, Mode, TableFormat, Variant};
use diffraction_shaders::resolve::{Axes, Resolved, window_tail};

use crate::record::{Part, Tolerance};

/// Arithmetic in 32 bits of a series about the mid-range height, over the greatest value.
pub const CENTRED: f64 = 2e-5;
/// The same of a place between texels: around the mirror direction `(u, v)` is a difference of numbers near 1, whose rounding
/// moves the place where the amplitude is steepest (2.9e-5 on a scan of 65 µm).
pub const PLACED: f64 = 6e-5;
/// The same of a table of colours: the last bit of a direction is a small part of a column, and lobes are steep (4.5e-5).
pub const BAKED: f64 = 1e-4;
/// Two drivers' arithmetic against each other, over the greatest value.
pub const ACROSS: f64 = 1e-5;
/// Rounding of tables of 32-bit floats, over the greatest value.
const F32: f64 = 2e-6;
/// The same of terms about the lowest height.
const F32_FROM_ZERO: f64 = 1e-5;
/// Rounding of tables of 16-bit floats with a scale for each term.
const F16: f64 = 2e-2;
/// The same of colours.
const BAKED_F16: f64 = 1e-3;
/// Rounding of colours to nine bits of the largest component.
const RGB9E5: f64 = 2e-3;
/// Greatest error of the phase function of a series that counts as converged.
const CONVERGED: f64 = 1e-2;

/// 95th percentile of the colours of a prefiltered table.
const PREFILTERED: f64 = 1.5;
/// Share of the window's energy beyond the bins that are read, where the window counts as whole.
const WHOLE: f64 = 1e-3;

/// What a comparison may differ by. `None` for the parts that nothing is promised about: a comparator, a series that the
/// plan cuts short, steps of the wavelength that miss what they sum.
pub fn tolerance(part: Part, variant: &Variant, resolved: &Resolved) -> Option<Tolerance> {
    let values =
        |max_abs| Some(Tolerance { max_abs: Some(max_abs), de2000_p95: None, map_p95: None });
    match part {
        Part::Arithmetic => {
            let least = match variant.mode {
                Mode::Baked => BAKED,
                _ if resolved.grid.is_some() => PLACED,
                _ => CENTRED,
            };
            let least = least.max(filter(variant, resolved));
            values(least.max(cancellation(variant, resolved)))
        }
        Part::Across => {
            let least = if resolved.grid.is_some() { PLACED } else { ACROSS };
            let least = least.max(2.0 * filter(variant, resolved));
            values(least.max(2.0 * cancellation(variant, resolved)))
        }
        Part::Packing => values(packing(variant)),
        Part::Model | Part::Total => model(variant, resolved),
    }
}

/// Whether measured differences are inside, the 95th percentiles of all directions and of the map; what is not judged is.
pub fn is_inside(tolerance: &Option<Tolerance>, max_abs: f64, [p95, map_p95]: [f64; 2]) -> bool {
    let inside = |most: Option<f64>, value: f64| most.is_none_or(|most| value <= most);
    tolerance.is_none_or(|t| {
        inside(t.max_abs, max_abs) && inside(t.de2000_p95, p95) && inside(t.map_p95, map_p95)
    })
}

/// Drivers may round the weights of a linear filter to 8 bits: an error of 1/512 of the difference of neighbouring texels on
/// each axis. Under a Gaussian window the amplitude changes by `2π⟨|x|⟩/size = 2π √(2/π) σs/size` from a texel to the next
/// at most, the intensity twice that of its peak. Software drivers, which filter floats in 32 bits, stay below 1e-4.
fn filter(variant: &Variant, resolved: &Resolved) -> f64 {
    let Some(grid) = resolved.grid.filter(|_| variant.filters()) else { return 0.0 };
    let change = |size_um: f64| TAU * FRAC_2_PI.sqrt() * grid.sigma_um / size_um;
    2.0 / 512.0 * grid.size_um.map(change).iter().sum::<f64>()
}

/// Terms about the lowest height reach `x^n/n!`, `x = z_max·H`, before they cancel; each is rounded to 24 bits.
fn cancellation(variant: &Variant, resolved: &Resolved) -> f64 {
    match variant.basis {
        Basis::Taylor | Basis::Chebyshev | Basis::Optimal => 0.0,
        Basis::TaylorZero => terms_sum(resolved) * 2.0_f64.powi(-24),
    }
}

/// Rounding of a table shows the less, the more bins there are to average over: a hundredth of its a-priori bound, which the
/// manifest states. Terms about the lowest height cancel, so that their rounding shows more (3.6e-6); that of 16 bits is
/// 1.0e-2 on domes of 0.3 µm.
fn packing(variant: &Variant) -> f64 {
    match (variant.table, variant.basis) {
        (TableFormat::F32, Basis::Taylor | Basis::Chebyshev | Basis::Optimal) => F32,
        (TableFormat::F32, Basis::TaylorZero) => F32_FROM_ZERO,
        (TableFormat::F16, _) if variant.mode == Mode::Baked => BAKED_F16,
        (TableFormat::F16, _) => F16,
        (TableFormat::Rgb9e5, _) => RGB9E5,
    }
}

fn terms_sum(resolved: &Resolved) -> f64 {
    resolved.expansion.term_sizes().iter().sum()
}

/// 95th percentiles of CIEDE2000 against the exact reference.
///
/// * `adaptive` sees every lobe; what is left is that its intensity is taken once or twice in it (0.3 on a grating, 0.03 on scans,
///   0.13 of their maps).
/// * `full` depends on how much of the window it sees and how finely it samples. A step of 5 nm, the texts', misses narrow
///   lobes far from the mirror direction (3.8 on rows of pits; 10 on a map under a low light), 2.5 nm hardly any (0.09; 0.13);
///   one bin to each side cuts 2 % of the window off a scan of 65 µm (2.8).
/// * on a prefiltered table linear interpolation and the wavelength nodes show, evenly (0.9 on a scan, 0.5 of its map).
/// * `pq` replaces the window's lobes by lines of another shape: nothing is promised about its colours.
fn model(variant: &Variant, resolved: &Resolved) -> Option<Tolerance> {
    let waves = &variant.wavelengths;
    let visible = waves.min_nm <= 380.0 && waves.max_nm >= 780.0;
    if variant.mode == Mode::Baked && visible {
        return baked(variant, resolved);
    }
    if resolved.expansion.bound() > CONVERGED || !visible {
        return None;
    }
    let whole = window_tail(variant, resolved.patch_um, resolved.window_radius) <= WHOLE;
    let (p95, map_p95) = match variant.mode {
        Mode::Adaptive if resolved.grid.is_some() => (PREFILTERED, Some(PREFILTERED)),
        Mode::Full if resolved.grid.is_some() && waves.step_nm <= 2.5 => {
            (PREFILTERED, Some(PREFILTERED))
        }
        Mode::Full if resolved.grid.is_some() => (8.0, None),
        Mode::Adaptive => (0.5, Some(0.25)),
        Mode::Full if waves.step_nm <= 2.5 && whole => (0.3, Some(0.5)),
        Mode::Full if waves.step_nm <= 5.0 => (8.0, None),
        Mode::Full | Mode::Pq | Mode::Gems | Mode::Baked => return None,
    };
    Some(Tolerance { max_abs: None, de2000_p95: Some(p95), map_p95 })
}

/// `baked`: what its sizes aim at, twice, where they were not cut by the most bytes. Maps of isolated lobes show more, since an
/// eye that is adapted to dim orders sees the flanks between texels (2.0 on fingers under a low light; 0.6 on a scan).
fn baked(variant: &Variant, resolved: &Resolved) -> Option<Tolerance> {
    let free = Variant { bake_mib: f64::INFINITY, ..variant.clone() };
    let wanted = Axes::new(&free, 2.0 * resolved.expansion.reach_um);
    (wanted == resolved.axes).then_some(Tolerance {
        max_abs: None,
        de2000_p95: Some(2.0 * variant.bake_error),
        map_p95: Some(5.0 * variant.bake_error),
    })
}
