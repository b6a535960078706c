//! The bins that the wavelengths of a direction can reach, for the mode `adaptive`.

use std::f64::consts::SQRT_2;

use crate::optics;
use crate::plan::{CoherenceScaling, Variant};

/// Lobes end at this many standard deviations of the window in the frequency plane; `exp(-4²)` of the peak is left.
pub const REACH_SIGMAS: f64 = 4.0;
/// Panels that the whole range of wavenumbers is cut into for each 0.4 µm of heights: the intensity of a bin is taken
/// once in a panel. Its curvature over a panel of width `p` errs by `(2π w H p)²/96` of the amplitude's square, 3e-3.
const PANELS: u32 = 32;
/// Whole lobes this many panels wide are not cut: their light is within a quarter of their width.
pub const WHOLE_PANELS: f64 = 2.5;
/// Height range that one set of panels serves, µm.
const PANEL_HEIGHT_UM: f64 = 0.4;

/// Static bounds of the loops over bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corridor {
    /// Most columns (or rows) along the segment.
    pub majors: u32,
    /// Most bins across it.
    pub minors: u32,
    /// Most panels of a lobe.
    pub panels: u32,
    /// Bins beyond the end of the segment, along x and y.
    pub margin: [u32; 2],
}

/// Geometry of one variant on one patch; lengths in µm, frequencies in cycles per µm, wavenumbers `1/λ` in 1/µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobes {
    /// Patch size.
    pub patch_um: [f64; 2],
    /// Least and greatest wavenumber.
    pub range: [f64; 2],
    /// Whether the window follows the wavelength.
    pub scales: bool,
    /// Standard deviation `σf` of the window's spectrum at 550 nm.
    pub sigma_cpum: f64,
}

impl Lobes {
    /// Lays a variant on a patch.
    pub fn new(variant: &Variant, patch_um: [f64; 2]) -> Lobes {
        let waves = &variant.wavelengths;
        let sigma_um = optics::window_sigma_um(&variant.optics, optics::REFERENCE_NM);
        Lobes {
            patch_um,
            range: [1e3 / waves.max_nm, 1e3 / waves.min_nm],
            scales: variant.optics.coherence_scaling == CoherenceScaling::Wavelength,
            sigma_cpum: 1.0 / (std::f64::consts::TAU * sigma_um),
        }
    }

    /// `σf` at a wavenumber.
    pub fn sigma_at(&self, wavenumber: f64) -> f64 {
        let ratio = if self.scales { wavenumber * optics::REFERENCE_NM * 1e-3 } else { 1.0 };
        self.sigma_cpum * ratio
    }

    /// Half the width of the corridor.
    pub fn reach_cpum(&self) -> f64 {
        REACH_SIGMAS * self.sigma_at(self.range[1])
    }

    /// `σf·L` in bins on each axis, the largest over the wavelengths: above about 0.2 neighbouring lobes interfere.
    pub fn sigma_bins(&self) -> [f64; 2] {
        self.patch_um.map(|size_um| self.sigma_at(self.range[1]) * size_um)
    }

    /// Bounds of the loops for a surface of a height range, µm; `|u|, |v| ≤ 2`.
    pub fn corridor(&self, height_um: f64) -> Corridor {
        let reach = self.reach_cpum();
        let longest = self.patch_um[0].max(self.patch_um[1]);
        let count = |cpum: f64| (cpum * longest).floor() as u32 + 2;
        let sets = (height_um / PANEL_HEIGHT_UM).ceil().clamp(1.0, 64.0) as u32;
        Corridor {
            majors: count(2.0 * (self.range[1] - self.range[0]) + 2.0 * reach),
            minors: count(2.0 * SQRT_2 * reach),
            panels: PANELS * sets,
            // the strip across a slanting segment is wider than the corridor
            margin: self.patch_um.map(|size_um| (SQRT_2 * reach * size_um).floor() as u32 + 1),
        }
    }

    /// Wavenumbers over which the lobe of a frequency is crossed by `f = uv·t`, within the range; none when the first is
    /// above the second. The same as `lobe_span` of the template.
    pub fn span(&self, place: [f64; 2], uv: [f64; 2]) -> [f64; 2] {
        let along = uv[0] * place[0] + uv[1] * place[1];
        let half = REACH_SIGMAS / SQRT_2 * self.sigma_cpum;
        let squared = |v: [f64; 2]| (v[0] * v[0] + v[1] * v[1]).max(LEAST_SQUARED);
        if self.scales {
            // a Gaussian in λ: the window's spectrum at λ is that at 550 nm, wider by 550 nm/λ
            let half_um = half * optics::REFERENCE_NM * 1e-3 / squared(place).sqrt();
            let centre_um = along / squared(place);
            let low_um = (centre_um - half_um).max(1.0 / self.range[1]);
            let high_um = (centre_um + half_um).min(1.0 / self.range[0]);
            if low_um <= high_um { [1.0 / high_um, 1.0 / low_um] } else { [1.0, 0.0] }
        } else {
            let half = half / squared(uv).sqrt();
            let centre = along / squared(uv);
            [(centre - half).max(self.range[0]), (centre + half).min(self.range[1])]
        }
    }

    /// Every bin of a direction's corridor whose lobe is crossed, with the wavenumbers of the crossing.
    pub fn bins(&self, uv: [f64; 2]) -> Vec<([i64; 2], [f64; 2])> {
        let reach = self.reach_cpum();
        let upright = uv[1].abs() > uv[0].abs();
        let turn = |v: [f64; 2]| if upright { [v[1], v[0]] } else { v };
        let [along, across] = turn(uv);
        let size_um = turn(self.patch_um);
        let slope = if along == 0.0 { 0.0 } else { across / along };
        let half_width = reach * (1.0 + slope * slope).sqrt();
        let ends = self.range.map(|t| t * along);
        let bounds = |low: f64, high: f64, size_um: f64| {
            (low * size_um).ceil() as i64..=(high * size_um).floor() as i64
        };
        let mut found = Vec::new();
        for major in bounds(ends[0].min(ends[1]) - reach, ends[0].max(ends[1]) + reach, size_um[0])
        {
            let centre = slope * major as f64 / size_um[0];
            for minor in bounds(centre - half_width, centre + half_width, size_um[1]) {
                let bin = if upright { [minor, major] } else { [major, minor] };
                let place = [bin[0] as f64 / self.patch_um[0], bin[1] as f64 / self.patch_um[1]];
                let span = self.span(place, uv);
                if span[0] <= span[1] {
                    found.push((bin, span));
                }
            }
        }
        found
    }

    /// Panels of a lobe: evaluations of its bin.
    pub fn panels(&self, span: [f64; 2], most: u32) -> u32 {
        let whole = self.range[1] - self.range[0];
        let share = if whole > 0.0 { (span[1] - span[0]) / whole } else { 0.0 };
        let panels = share * f64::from(most);
        if panels < WHOLE_PANELS { 1 } else { panels.ceil().min(f64::from(most)) as u32 }
    }
}

/// Squares of lengths are not taken smaller than this, so that nothing is divided by zero.
pub const LEAST_SQUARED: f64 = 1e-12;
