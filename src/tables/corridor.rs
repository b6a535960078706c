//! The bins that the wavelengths of a direction can reach, for the mode `adaptive`.

use std::f64::consts::{PI, SQRT_2};

use serde::Serialize;

use crate::optics;
use crate::plan::{CoherenceScaling, Wavelengths, Window};

/// Lobes are cut at this many standard deviations of the window in the frequency plane, where they are `exp(-4²)` of the peak.
pub const REACH_SIGMAS: f64 = 4.0;
/// Width of the broadest narrow lobe, in distances between the nodes of broad lobes.
pub const BROADEST: f64 = 4.0;
/// Number of nodes beyond each end of the range. The lobe of a node is as wide as the distance between nodes, so only
/// `exp(-9)` is omitted.
pub const OUTER_NODES: u32 = 2;
/// Shortest interval of wavenumbers over which colour weights change by their own size, 1/µm. It is 15 nm in the middle
/// of the spectrum.
const FASTEST_CHANGE: f64 = 0.05;
/// Maximum width of a narrow lobe, 1/µm, even on flat surfaces, because colours vary within the lobe.
const MAX_WIDTH: f64 = 0.06;
/// Maximum phase `2π w H s`, `|w| = 2`, of an intensity over a narrow lobe of width `s`. An intensity that is evaluated
/// at two wavenumbers has an error of 1/48 of the phase's fourth power, relative to the amplitude's square.
const MAX_PHASE: f64 = 0.5;
/// Maximum error of a lobe's colours by linear interpolation between two columns of their table.
const COLUMN_ERROR: f64 = 1e-3;
/// Maximum error of a lobe's colours by taking the nearest row, where colours change fastest.
const ROW_ERROR: f64 = 2e-2;
/// Maximum number of columns and of rows: every profile allows textures of this size.
const MAX_TEXELS: f64 = 2048.0;
/// Maximum number of nodes, without those beyond the ends.
const MAX_NODES: u32 = 1024;

/// Static bounds of the loops over bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Corridor {
    /// Maximum number of bins that are examined: all bins of a strip along the segment, or all bins about the nodes.
    pub candidates: u32,
    /// Number of bins across the strip, or across a node.
    pub minors: u32,
    /// Number of nodes of broad lobes.
    pub nodes: u32,
    /// Number of columns (or rows) of bins about a node.
    pub node_bins: u32,
    /// Number of columns of the table of narrow lobes.
    pub columns: u32,
    /// Number of rows of each of its two parts.
    pub rows: u32,
    /// Number of bins beyond the end of the segment, along x and y.
    pub margin: [u32; 2],
}

/// Geometry of the lobes of one patch; lengths in µm, frequencies in cycles per µm, wavenumbers `1/λ` in 1/µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeGeometry {
    /// Patch size.
    pub patch_um: [f64; 2],
    /// Minimum and maximum wavenumber.
    pub range: [f64; 2],
    /// Whether the window follows the wavelength.
    pub scales: bool,
    /// Standard deviation `σf` of the window's spectrum at 550 nm.
    pub sigma_cpum: f64,
}

impl LobeGeometry {
    /// The geometry of a window and a range of wavelengths on a patch.
    pub fn new(window: Window, waves: &Wavelengths, patch_um: [f64; 2]) -> LobeGeometry {
        let sigma_um = optics::window_sigma_um(window, optics::REFERENCE_NM);
        LobeGeometry {
            patch_um,
            range: [1e3 / waves.max_nm, 1e3 / waves.min_nm],
            scales: window.coherence_scaling == CoherenceScaling::Wavelength,
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

    /// Maximum `σf·L` over the wavelengths, in bins on each axis. Above about 0.2 neighbouring lobes interfere.
    pub fn sigma_bins(&self) -> [f64; 2] {
        self.patch_um.map(|size_um| self.sigma_at(self.range[1]) * size_um)
    }

    /// Bounds of the loops for a surface with a height range in µm; `|u|, |v| ≤ 2`.
    pub fn corridor(&self, height_um: f64) -> Corridor {
        let reach = self.reach_cpum();
        let longest = self.patch_um[0].max(self.patch_um[1]);
        // an interval contains at most one bin more than its length in bins, rounded down
        let across = |cpum: f64| (cpum * longest).floor() as u32 + 1;
        let nodes = self.nodes(height_um);
        let (majors, minors) = (
            across(2.0 * (self.range[1] - self.range[0]) + 2.0 * reach) + 1,
            across(2.0 * SQRT_2 * reach),
        );
        let node_bins = across(2.0 * reach);
        // the strip across a slanted segment is wider than the corridor; nodes beyond the range exist only where lobes
        // are broad
        let outer = f64::from(OUTER_NODES) * (2.0 * self.pace(nodes)).min(reach);
        let margin = |size_um: f64| ((SQRT_2 * reach + outer) * size_um).floor() as u32 + 1;
        let [columns, rows] = if nodes == 1 { [1, 0] } else { self.resolution(nodes) };
        Corridor {
            candidates: minors * majors.max(nodes * node_bins),
            minors,
            nodes,
            node_bins,
            columns,
            rows,
            margin: self.patch_um.map(margin),
        }
    }

    /// Whether the narrow lobes in a row of the table are evaluated at two wavenumbers. The template's `lobe_halves`
    /// has the same condition.
    pub fn is_halved(row: u32, rows: u32) -> bool {
        4 * row >= rows
    }

    /// Number of columns and rows of the table of narrow lobes. The error between columns is `δ²/8` times the second
    /// derivative (linear interpolation), the error of the nearest row `s δs/2` times.
    fn resolution(&self, nodes: u32) -> [u32; 2] {
        let [low, high] = self.middles(nodes);
        let columns = (high - low) / (FASTEST_CHANGE * (8.0 * COLUMN_ERROR).sqrt());
        let width = BROADEST * self.pace(nodes) * self.sigma_at(self.range[1])
            / self.sigma_at(self.range[0]);
        let rows = (width / FASTEST_CHANGE).powi(2) / (4.0 * ROW_ERROR);
        let count = |number: f64| number.ceil().clamp(8.0, MAX_TEXELS - 3.0) as u32 + 1;
        [count(columns).max(nodes), count(rows)]
    }

    /// First and last wavenumber at which `f = uv·t` crosses the lobe of a frequency, within the range. If the first is
    /// above the second, it does not cross the lobe.
    pub fn span(&self, place: [f64; 2], uv: [f64; 2]) -> [f64; 2] {
        let along = uv[0] * place[0] + uv[1] * place[1];
        let half = REACH_SIGMAS / SQRT_2 * self.sigma_cpum;
        let squared = |v: [f64; 2]| (v[0] * v[0] + v[1] * v[1]).max(MIN_SQUARED);
        if self.scales {
            // a Gaussian in λ: the window's spectrum at λ is the spectrum at 550 nm, wider by a factor of 550 nm/λ
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

    /// Every bin of a direction's corridor whose lobe the segment crosses, with the wavenumbers of the crossing.
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

    /// Number of nodes of broad lobes for a surface with a height range in µm. It is 1 for a single wavelength.
    fn nodes(&self, height_um: f64) -> u32 {
        let range = self.range[1] - self.range[0];
        if range <= 0.0 {
            return 1;
        }
        // maximum change of an intensity's phase per wavenumber
        let turn = 4.0 * PI * height_um;
        let width = (MAX_PHASE / turn).min(MAX_WIDTH);
        // if the window depends on the wavelength, lobes are broader at the other end of the range
        let pace = width / BROADEST * self.sigma_at(self.range[0]) / self.sigma_at(self.range[1]);
        ((range / pace).ceil() as u32).min(MAX_NODES) + 1 + 2 * OUTER_NODES
    }

    /// Number of bins within reach of a node.
    pub fn node_bins(&self, uv: [f64; 2], node: u32, nodes: u32) -> u64 {
        let wavenumber = self.node(node, nodes);
        let reach = REACH_SIGMAS * self.sigma_at(wavenumber);
        let bounds = |axis: usize| {
            let (place, size_um) = (uv[axis] * wavenumber, self.patch_um[axis]);
            ((place - reach) * size_um).ceil() as i64..=((place + reach) * size_um).floor() as i64
        };
        let near = |r: i64, s: i64| {
            let x = r as f64 / self.patch_um[0] - uv[0] * wavenumber;
            let y = s as f64 / self.patch_um[1] - uv[1] * wavenumber;
            x * x + y * y < reach * reach
        };
        bounds(1).map(|s| bounds(0).filter(|r| near(*r, s)).count() as u64).sum()
    }

    /// Wavenumber of a node.
    pub fn node(&self, node: u32, nodes: u32) -> f64 {
        if nodes == 1 {
            return self.range[0];
        }
        self.range[0] + (f64::from(node) - f64::from(OUTER_NODES)) * self.pace(nodes)
    }

    /// Minimum and maximum centre of narrow lobes in the table of their colours: the range of wavenumbers, extended by
    /// the reach of the broadest narrow lobe.
    pub fn middles(&self, nodes: u32) -> [f64; 2] {
        let margin = REACH_SIGMAS / SQRT_2 * BROADEST * self.pace(nodes);
        let [low, high] = self.range;
        [low - margin, high + margin * self.sigma_at(high) / self.sigma_at(low)]
    }

    /// Distance between nodes.
    pub fn pace(&self, nodes: u32) -> f64 {
        (self.range[1] - self.range[0])
            / f64::from(nodes.max(2 + 2 * OUTER_NODES) - 1 - 2 * OUTER_NODES)
    }

    /// Width of the lobes of a direction, relative to the broadest narrow lobe. Lobes of 1 or more are broad.
    pub fn breadth(&self, uv: [f64; 2], nodes: u32) -> f64 {
        let length = (uv[0] * uv[0] + uv[1] * uv[1]).max(MIN_SQUARED).sqrt();
        self.sigma_at(self.range[0]) / (BROADEST * self.pace(nodes) * length)
    }
}

/// Minimum of squared lengths, to avoid divisions by zero.
pub const MIN_SQUARED: f64 = 1e-12;
