//! Removes candidates before anything is computed, by bounds, sizes and counts.

use std::f64::consts::{PI, SQRT_2, TAU};

use diffraction_shaders::optics;
use diffraction_shaders::package::manifest::extent;
use diffraction_shaders::plan::Variant;
use diffraction_shaders::shader::limits::Profile;
use diffraction_shaders::shader::specialise;
use diffraction_shaders::variant::Form;

use crate::results::{Bounds, Verdict};

use super::{Candidate, Lost};

/// The limits that a candidate must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Maximum 95th percentile of CIEDE2000.
    pub budget_de: f64,
    /// The profile whose limits the tables must fit.
    pub fits: Option<Profile>,
    /// Maximum MiB of tables.
    pub max_table_mib: Option<f64>,
}

/// Maximum bounds of a candidate for a budget of 1. A bound is for the worst place; most colours are better by a factor of
/// three to ten. So each limit is about five times the bound that was seen to give a 95th percentile of 1.
const FAR: Bounds = Bounds { phase: 0.5, tail: 0.1, step: 0.5 };
/// The limits scale with the budget, but not below this one, so that a small budget does not exclude everything.
const MIN_BUDGET: f64 = 0.1;

/// Splits candidates into those worth measuring and the others.
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

/// A-priori bounds of a variant's error. 0 if its form has no such error.
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

/// Difference between the sum of a Gaussian lobe at equal steps and its integral: the first term of Poisson's formula is
/// `2 exp(-2π² (σ/step)²)`. Along `f = (u, v)/λ` the light of a lobe has the deviation `σf λ²/(√2 |(u, v)|)`; here at 500 nm and
/// `|(u, v)| = 1`.
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
    let names = [
        "error of the phase function",
        "share of a lobe outside the window",
        "share of a lobe missed by the wavelength's steps",
    ];
    let all = candidate.bounds.all().into_iter().zip(FAR.all());
    let (at, (bound, _)) = all.enumerate().find(|(_, (bound, far))| *bound > far * scale)?;
    Some((Verdict::Bound, format!("{}: up to {bound:.2}", names[at])))
}

/// A candidate of the same kind that is at most as costly, has bounds at most as large, and is better in one of these. Among
/// equal candidates the first remains.
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

/// The record of a candidate that does not take part.
pub fn lose(candidate: &Candidate, verdict: Verdict, why: String) -> Lost {
    let (name, preset) = (candidate.variant.name.clone(), candidate.preset.clone());
    Lost { name, preset, verdict, why }
}

/// Bytes as MiB.
pub fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}
