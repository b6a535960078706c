//! What can be said before anything is computed: bounds, sizes, counts.

use std::f64::consts::{PI, SQRT_2, TAU};

use diffraction_shaders::optics;
use diffraction_shaders::package::manifest::extent;
use diffraction_shaders::plan::Variant;
use diffraction_shaders::shader::limits::Profile;
use diffraction_shaders::shader::specialise;
use diffraction_shaders::variant::Form;

use crate::results::{Bounds, Verdict};

use super::{Candidate, Lost};

/// What a candidate must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Greatest 95th percentile of CIEDE2000.
    pub budget_de: f64,
    /// The profile that must hold its tables.
    pub fits: Option<Profile>,
    /// Most MiB of tables.
    pub max_table_mib: Option<f64>,
}

/// Bounds above these, for a budget of 1, are not measured. A bound is of the worst place; the colours of most are better
/// by a factor of three to ten, so each limit is about five times what was seen to leave a 95th percentile of 1.
const FAR: Bounds = Bounds { phase: 0.5, tail: 0.1, step: 0.5 };
/// Bounds grow with the budget, but a small one is no reason to measure nothing at all.
const MIN_BUDGET: f64 = 0.1;

/// Splits candidates into those that are worth measuring and those that are not.
pub fn prune(
    candidates: Vec<Candidate>,
    limits: &Limits,
    rotate_deg: f64,
) -> (Vec<Candidate>, Vec<Lost>) {
    let (mut kept, mut lost): (Vec<Candidate>, Vec<Lost>) = (Vec::new(), Vec::new());
    for candidate in candidates {
        match unfit(&candidate, limits, rotate_deg).or_else(|| too_far(&candidate, limits)) {
            Some((verdict, why)) => lost.push(lose(&candidate, verdict, why)),
            None => kept.push(candidate),
        }
    }
    let beaten: Vec<Option<usize>> = (0..kept.len()).map(|i| dominator(&kept, i)).collect();
    for (i, by) in beaten.iter().enumerate() {
        if let Some(by) = by {
            let why = format!("{} costs no more and has smaller bounds", kept[*by].variant.name);
            lost.push(lose(&kept[i], Verdict::Dominated, why));
        }
    }
    let kept = kept.into_iter().zip(beaten).filter(|(_, by)| by.is_none()).map(|(c, _)| c);
    (kept.collect(), lost)
}

/// What is known of a variant's error; 0 for what its form does not have.
pub fn bounds(variant: &Variant, form: &Form) -> Bounds {
    let settings: serde_json::Value =
        serde_json::from_str(&variant.canonical()).unwrap_or_default();
    let has_step = settings.get("step_nm").is_some();
    Bounds {
        phase: form.series().map_or(0.0, |series| series.expansion().bound()),
        tail: form.missed(),
        step: if has_step { aliasing(variant) } else { 0.0 },
    }
}

/// Sum of a Gaussian lobe at equal steps against its integral: Poisson's formula has `2 exp(-2π² (σ/step)²)` as its first
/// term. Along `f = (u, v)/λ` the light of a lobe has a deviation of `σf λ²/(√2 |(u, v)|)`; here 500 nm, `|(u, v)| = 1`.
fn aliasing(variant: &Variant) -> f64 {
    const LAMBDA_NM: f64 = 500.0;
    let sigma_um = optics::window_sigma_um(&variant.optics, LAMBDA_NM);
    let sigma_nm = (LAMBDA_NM * 1e-3).powi(2) / (TAU * sigma_um * SQRT_2) * 1e3;
    let ratio = PI * sigma_nm / variant.wavelengths.step_nm;
    (2.0 * (-2.0 * ratio * ratio).exp()).min(1.0)
}

fn unfit(candidate: &Candidate, limits: &Limits, rotate_deg: f64) -> Option<(Verdict, String)> {
    if let Some(most) = limits.max_table_mib {
        let mib = mib(candidate.table_bytes());
        if mib > most {
            let why = format!("{mib:.2} MiB of tables, above {most}");
            return Some((Verdict::Large, why));
        }
    }
    let profile = limits.fits?;
    let tables = specialise::shapes(&candidate.on, rotate_deg);
    let misfit = tables.iter().find(|table| !profile.limits().allow(extent(table)))?;
    let why = format!(
        "its table {} of {} × {} texels and {} layers is larger than {} guarantees",
        misfit.name,
        misfit.width,
        misfit.height,
        misfit.layers.max(1),
        profile.name()
    );
    Some((Verdict::Unfit, why))
}

fn too_far(candidate: &Candidate, limits: &Limits) -> Option<(Verdict, String)> {
    let scale = limits.budget_de.max(MIN_BUDGET);
    let names = ["the series leaves", "the window leaves out", "the wavelength's steps miss"];
    let what = ["of the phase function", "of a lobe", "of a lobe"];
    let all = candidate.bounds.all().into_iter().zip(FAR.all());
    let (at, (bound, _)) = all.enumerate().find(|(_, (bound, far))| *bound > far * scale)?;
    Some((Verdict::Bound, format!("{} up to {bound:.2} {}", names[at], what[at])))
}

/// A candidate of the same kind that costs no more, has bounds no larger, and is better in one of them; of equals the
/// first is left.
fn dominator(all: &[Candidate], at: usize) -> Option<usize> {
    let one = &all[at];
    let beats = |(i, other): &(usize, &Candidate)| {
        let (a, b) = (other.bounds.all(), one.bounds.all());
        let no_worse = other.kind == one.kind
            && other.fetches() <= one.fetches()
            && other.table_bytes() <= one.table_bytes()
            && a.iter().zip(&b).all(|(a, b)| a <= b);
        let better = other.fetches() < one.fetches()
            || other.table_bytes() < one.table_bytes()
            || a.iter().zip(&b).any(|(a, b)| a < b);
        no_worse && (better || *i < at)
    };
    all.iter().enumerate().filter(|(i, _)| *i != at).find(beats).map(|(i, _)| i)
}

fn lose(candidate: &Candidate, verdict: Verdict, why: String) -> Lost {
    let (name, preset) = (candidate.variant.name.clone(), candidate.preset.clone());
    Lost { name, preset, verdict, why }
}

/// Bytes as MiB.
pub fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}
