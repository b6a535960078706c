//! Results of `tune`: one for each candidate, measured or not.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The result of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tune {
    /// The surface's name.
    pub surface: String,
    /// The candidate's name.
    pub variant: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The reason in words; empty if the verdict is enough.
    pub why: String,
    /// Whether no other timed candidate is both faster and more exact.
    pub front: bool,
    /// Maximum allowed 95th percentile of CIEDE2000, under every light.
    pub budget_de: f64,
    /// Graphics interface of the adapter for the times.
    pub backend: String,
    /// The adapter's name.
    pub adapter: String,
    /// Directions towards the lights: theta and phi in degrees. Times are measured under the first.
    pub lights: Vec<[f64; 2]>,
    /// Width and height of the timed map, in pixels.
    pub size: usize,
    /// The profile whose limits the tables must fit.
    pub fits: Option<String>,
    /// Maximum MiB of tables.
    pub max_table_mib: Option<f64>,
    /// Errors under each light; empty if they were not measured, or only at a first look.
    pub errors: Vec<LightError>,
    /// The 95th percentile at which measuring stopped, if it was far over the budget.
    pub far_p95: Option<f64>,
    /// Time of a frame; `None` if it was not measured.
    pub time: Option<Time>,
    /// Texels that a lit pixel reads on average; `None` if the candidate cannot be built on the surface.
    pub fetches: Option<f64>,
    /// Size of all tables in bytes.
    pub table_bytes: Option<u64>,
    /// A-priori bounds, see [`Bounds`].
    pub bounds: Option<Bounds>,
    /// The candidate as a preset of a plan, in TOML.
    pub preset: String,
    /// The variant's canonical configuration; null if the plan refuses it.
    pub settings: Value,
}

impl Tune {
    /// The maximum 95th percentile of CIEDE2000 under all lights, over all directions or over the map.
    pub fn worst_p95(&self) -> Option<f64> {
        self.errors.iter().map(LightError::worst_p95).reduce(f64::max)
    }

    /// The maximum CIEDE2000 under all lights.
    pub fn worst_max(&self) -> Option<f64> {
        self.errors.iter().map(|error| error.max).reduce(f64::max)
    }

    /// Time of a pixel in ns, and error, if the candidate has both.
    pub fn place(&self) -> Option<[f64; 2]> {
        Some([self.time?.ns_per_pixel, self.worst_p95()?])
    }
}

/// Error of a candidate under one light: colours by its twin on rounded tables against the exact colours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightError {
    /// Direction towards the light: theta and phi in degrees.
    pub light: [f64; 2],
    /// 95th percentile of CIEDE2000 over lit directions: pixels of a map, and random directions on orders and near the mirror
    /// direction.
    pub p95: f64,
    /// Maximum of CIEDE2000 over the same directions.
    pub max: f64,
    /// 95th percentile over the map alone, at its own exposure; `None` if almost nothing of it is lit.
    pub map_p95: Option<f64>,
}

impl LightError {
    /// The larger of both 95th percentiles.
    pub fn worst_p95(&self) -> f64 {
        self.map_p95.unwrap_or(0.0).max(self.p95)
    }
}

/// Time of a candidate, drawn in turns with the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// Median time of a frame, ms.
    pub median_ms: f64,
    /// Median absolute deviation, ms.
    pub mad_ms: f64,
    /// `median_ms` divided by the pixels of the disc, in ns.
    pub ns_per_pixel: f64,
    /// Median over rounds of the time of `texts` divided by this candidate's.
    pub ratio: f64,
    /// 95 % confidence interval of the ratio.
    pub ratio_interval: [f64; 2],
    /// 95 % confidence interval of the ratio to the fastest candidate within the budget, round by round. If it contains 1, the
    /// times are a tie. `None` if the two were not drawn in turns.
    pub pace: Option<[f64; 2]>,
    /// Number of measured rounds.
    pub runs: usize,
}

/// A-priori bounds of a candidate's error. 0 if its mode has no such error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Maximum error of the phase function by the truncated series.
    pub phase: f64,
    /// Share of a lobe's light in bins outside the window.
    pub tail: f64,
    /// Share of a lobe's light that the steps of the wavelength miss or count twice, for a deflection by about 45°.
    pub step: f64,
}

impl Bounds {
    /// The three bounds, in the order of the fields.
    pub fn all(&self) -> [f64; 3] {
        [self.phase, self.tail, self.step]
    }
}

/// The verdict on a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within the budget, and the fastest; among ties with the fastest, the one with the smallest error.
    Winner,
    /// Within the budget, but slower, or not timed.
    Within,
    /// Over the budget.
    Over,
    /// Far over the budget, at a first look or under one light.
    Far,
    /// Not a candidate, but the baseline of the ratios.
    Baseline,
    /// Less accurate by every bound than a candidate that is over the budget.
    Implied,
    /// Costs at least as much as a candidate of the same form within the budget.
    Costlier,
    /// Reads many times the texels of a candidate within the budget.
    Costly,
    /// Far over the budget by an a-priori bound.
    Bound,
    /// Costs at least as much as a candidate of the same form with smaller bounds.
    Dominated,
    /// Its tables do not fit the profile's limits.
    Unfit,
    /// Its tables are larger than allowed.
    Large,
    /// On this surface, the same as another candidate.
    Same,
    /// A variant of the plan with another light or material than `[optics]`.
    Optics,
    /// Refused by the plan's rules, or on this surface.
    Refused,
    /// An error occurred.
    Failed,
}

impl Verdict {
    /// The verdict in a few words.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Winner => "winner",
            Verdict::Within => "within the budget",
            Verdict::Over => "over the budget",
            Verdict::Far => "far over the budget",
            Verdict::Baseline => "baseline",
            Verdict::Implied => "less accurate by every bound than one that is over the budget",
            Verdict::Costlier => "costs at least as much as one of the same form within the budget",
            Verdict::Costly => "reads many times as many texels as one within the budget",
            Verdict::Bound => "an a-priori error bound is far too large",
            Verdict::Dominated => {
                "costs at least as much as one of the same form with smaller bounds"
            }
            Verdict::Unfit => "does not fit the profile",
            Verdict::Large => "tables too large",
            Verdict::Same => "the same as another candidate",
            Verdict::Optics => "has another light or material than [optics]",
            Verdict::Refused => "cannot be built",
            Verdict::Failed => "failed",
        }
    }
}
