//! Results of `tune`: one for every candidate, measured or not.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What became of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tune {
    /// The surface's name.
    pub surface: String,
    /// The candidate's name.
    pub variant: String,
    /// What became of it.
    pub verdict: Verdict,
    /// Why, in words; empty where the verdict says all.
    pub why: String,
    /// Whether no other candidate that was timed is both faster and more exact.
    pub front: bool,
    /// Greatest 95th percentile of CIEDE2000 that was allowed, under every light.
    pub budget_de: f64,
    /// Interface of the adapter that times were measured on.
    pub backend: String,
    /// The adapter's name.
    pub adapter: String,
    /// Directions of the lights, theta and phi in degrees; times are those of the first.
    pub lights: Vec<[f64; 2]>,
    /// Pixels along a side of the map that was timed.
    pub size: usize,
    /// The profile whose limits had to be kept.
    pub fits: Option<String>,
    /// Most MiB of tables.
    pub max_table_mib: Option<f64>,
    /// Errors under each light; empty where they were not measured, or only at a first look.
    pub errors: Vec<LightError>,
    /// The 95th percentile at which measuring ended, where it was far over the budget.
    pub far_p95: Option<f64>,
    /// Time of a frame; none where it was not measured.
    pub time: Option<Time>,
    /// Texels that a lit pixel reads, on average; none where the candidate cannot be laid on the surface.
    pub fetches: Option<f64>,
    /// Bytes of all tables.
    pub table_bytes: Option<u64>,
    /// A-priori bounds, see [`Bounds`].
    pub bounds: Option<Bounds>,
    /// The candidate as a preset of a plan, TOML.
    pub preset: String,
    /// The variant's canonical configuration; null where the plan refuses it.
    pub settings: Value,
}

impl Tune {
    /// The greatest 95th percentile of CIEDE2000 under any light, of all directions or of the map.
    pub fn worst_p95(&self) -> Option<f64> {
        self.errors.iter().map(LightError::worst_p95).reduce(f64::max)
    }

    /// The greatest CIEDE2000 under any light.
    pub fn worst_max(&self) -> Option<f64> {
        self.errors.iter().map(|error| error.max).reduce(f64::max)
    }

    /// Time of a pixel, ns, and error of a candidate that has both.
    pub fn place(&self) -> Option<[f64; 2]> {
        Some([self.time?.ns_per_pixel, self.worst_p95()?])
    }
}

/// Colours of a candidate, computed by its twin on rounded tables, against the exact ones under one light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightError {
    /// Direction of the light, theta and phi in degrees.
    pub light: [f64; 2],
    /// 95th percentile of CIEDE2000 over lit directions: pixels of a map and those drawn on orders and near the mirror.
    pub p95: f64,
    /// The greatest of them.
    pub max: f64,
    /// 95th percentile over the map alone, at its own exposure; none where next to nothing of it is lit.
    pub map_p95: Option<f64>,
}

impl LightError {
    /// The greater of both 95th percentiles.
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
    /// `median_ms` over the pixels of the disc, ns.
    pub ns_per_pixel: f64,
    /// Median over rounds of the time of `texts` over this one's.
    pub ratio: f64,
    /// 95 % confidence interval of the ratio.
    pub ratio_interval: [f64; 2],
    /// The same interval of the fastest one's time within the budget over this one's, round by round: where it reaches 1,
    /// the two cannot be told apart. None where they were not drawn in turns with each other.
    pub pace: Option<[f64; 2]>,
    /// Rounds that were measured.
    pub runs: usize,
}

/// What is known of a candidate's error before anything is computed; 0 where its mode has no such error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Greatest error of the phase function after the series is cut.
    pub phase: f64,
    /// Share of a lobe's light in bins that are not read.
    pub tail: f64,
    /// Share of a lobe's light that the steps of the wavelength miss or count twice, where the light is deflected by
    /// about half of a right angle.
    pub step: f64,
}

impl Bounds {
    /// The three, in the order of the fields.
    pub fn all(&self) -> [f64; 3] {
        [self.phase, self.tail, self.step]
    }
}

/// What became of a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within the budget, and the fastest, or not told from the fastest and the best of those.
    Winner,
    /// Within the budget, but slower, or not timed.
    Within,
    /// Over the budget.
    Over,
    /// Far over the budget, at a first look or under one light.
    Far,
    /// No candidate: what ratios are against.
    Baseline,
    /// Less accurate by every bound than one that misses the budget.
    Implied,
    /// Costs no less than one of the same form within the budget.
    Costlier,
    /// Reads many times the texels of one within the budget.
    Costly,
    /// A bound says that it is far over the budget.
    Bound,
    /// Costs no less than one of the same form with smaller bounds.
    Dominated,
    /// The profile's limits do not hold its tables.
    Unfit,
    /// Its tables are larger than allowed.
    Large,
    /// The same as another, once laid on the surface.
    Same,
    /// Of the plan, but with another light or material than `[optics]`.
    Optics,
    /// The plan's rules, or the surface, refuse it.
    Refused,
    /// Something went wrong with it.
    Failed,
}

impl Verdict {
    /// In a few words.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Winner => "winner",
            Verdict::Within => "within the budget",
            Verdict::Over => "over the budget",
            Verdict::Far => "far over the budget",
            Verdict::Baseline => "baseline",
            Verdict::Implied => "less accurate by every bound than one over the budget",
            Verdict::Costlier => "costs no less than one of the same form within the budget",
            Verdict::Costly => "reads many times the texels of one within the budget",
            Verdict::Bound => "a bound is far too large",
            Verdict::Dominated => "costs no less than one of the same form with smaller bounds",
            Verdict::Unfit => "does not fit the profile",
            Verdict::Large => "tables too large",
            Verdict::Same => "the same as another",
            Verdict::Optics => "another light or material than [optics]",
            Verdict::Refused => "cannot be built",
            Verdict::Failed => "failed",
        }
    }
}
