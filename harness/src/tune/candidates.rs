//! The candidates: the variants of the plan, and a grid over all that can be built.

use std::collections::{BTreeMap, BTreeSet};

use diffraction_shaders::error::Error;
use diffraction_shaders::plan::{Auto, Basis, Plan, Variant};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::Series;
use diffraction_shaders::tables::basis::Expansion;
use diffraction_shaders::variant::Form;
use rayon::prelude::*;

use crate::results::Verdict;

use super::grid::{GRIDS, name, product};
use super::preset::of_grid;
use super::{Candidate, Lost, preset, prune};

/// All candidates for a surface, the plan's own first, and those that cannot take part. The pitch of the surface must resolve
/// the wavelengths of visible light.
pub fn candidates(plan: &Plan, height: &HeightField) -> (Vec<Candidate>, Vec<Lost>) {
    let own = plan.variants.iter().map(|v| (preset(v, &plan.optics), Ok(v.clone())));
    let names: BTreeSet<&str> = plan.variants.iter().map(|v| v.name.as_str()).collect();
    let tried = texts(height).into_iter().map(|(name, keys)| {
        let taken = names.contains(name.as_str());
        let name = if taken { format!("{name}-tuned") } else { name };
        let text = of_grid(&name, &keys);
        let read = plan.preset(&text).map_err(|errors| (name.clone(), plain(&errors, &name)));
        (text, read)
    });
    let all: Vec<_> = own.chain(tried).collect();
    // in parallel, since the functions of a basis on a large surface are slow
    let laid: Vec<Result<Candidate, Lost>> =
        all.into_par_iter().map(|(text, read)| lay(plan, height, text, read)).collect();
    let (mut kept, mut lost) = (Vec::new(), Vec::new());
    let mut seen: BTreeMap<String, String> = BTreeMap::new();
    for laid in laid {
        let candidate = match laid {
            Ok(candidate) => candidate,
            Err(reason) => {
                lost.push(reason);
                continue;
            }
        };
        let name = candidate.variant.name.clone();
        match seen.get(&effective(&candidate)) {
            Some(first) => lost.push(Lost {
                name,
                preset: candidate.preset,
                verdict: Verdict::Same,
                why: format!("the same on this surface as {first}"),
            }),
            None => {
                seen.insert(effective(&candidate), name);
                kept.push(candidate);
            }
        }
    }
    (kept, lost)
}

/// Names and keys of the grid's presets, with numbers of terms filled in.
fn texts(height: &HeightField) -> Vec<(String, Vec<(&'static str, String)>)> {
    let bases = [Basis::Optimal, Basis::Chebyshev, Basis::Taylor];
    let laid = bases.map(|basis| (basis.as_str(), Expansion::new(basis, 1, height, MIN_NM)));
    let mut texts = Vec::new();
    for row in GRIDS.into_iter().flat_map(product) {
        let basis = row.iter().find(|(key, _)| *key == "basis");
        let expansion = basis.and_then(|(_, word)| {
            laid.iter().find(|(known, _)| *known == word.trim_matches('"')).map(|(_, laid)| laid)
        });
        let filled = row.into_iter().map(|(key, value)| match (key, expansion) {
            ("terms", Some(expansion)) => (key, terms(value, expansion)),
            _ => (key, value.to_owned()),
        });
        let keys: Vec<(&str, String)> = filled.collect();
        // two errors may need the same number of terms
        if !texts.iter().any(|(_, known)| *known == keys) {
            texts.push((name(&keys), keys));
        }
    }
    texts
}

/// The shortest wavelength of the grid, nm.
const MIN_NM: f64 = 380.0;

/// The number of terms for an error, as TOML. A word stays as it is.
fn terms(error: &str, expansion: &Expansion) -> String {
    match error.parse::<f64>() {
        Ok(error) => expansion.clone().with_error(error).terms.to_string(),
        Err(_) => error.to_owned(),
    }
}

fn lay(
    plan: &Plan,
    height: &HeightField,
    preset: String,
    read: Result<Variant, (String, String)>,
) -> Result<Candidate, Lost> {
    let lose = |name: String, preset, verdict, why| Lost { name, preset, verdict, why };
    let variant = match read {
        Ok(variant) => variant,
        Err((name, why)) => return Err(lose(name, preset, Verdict::Refused, why)),
    };
    let name = variant.name.clone();
    if differs_in_optics(&variant, plan) {
        let why =
            "[optics] defines the right colours; change it to tune for other optics".to_owned();
        return Err(lose(name, preset, Verdict::Optics, why));
    }
    match Form::new(&variant, height) {
        Ok(on) => {
            let bounds = prune::bounds(&variant, &on);
            let (kind, cost) = (kind(&variant), on.cost());
            Ok(Candidate { variant, on, preset, kind, bounds, cost })
        }
        Err(error) => {
            let why = plain(&[error], &name);
            Err(lose(name, preset, Verdict::Refused, why))
        }
    }
}

/// Whether optics that the variant's mode reads differ from the plan's. Optics that it does not read are at their defaults.
fn differs_in_optics(variant: &Variant, plan: &Plan) -> bool {
    let same = Variant { optics: plan.optics.clone(), ..variant.clone() };
    same.canonical() != variant.canonical()
}

/// Keys of the configuration with numbers, which determine counts and bounds.
const NUMBERS: [&str; 5] = ["terms", "term_error", "window_radius", "step_nm", "periods"];

fn kind(variant: &Variant) -> String {
    let mut settings: BTreeMap<String, serde_json::Value> =
        serde_json::from_str(&variant.canonical()).unwrap_or_default();
    settings.retain(|key, _| !NUMBERS.contains(&key.as_str()));
    settings.into_iter().map(|(key, value)| format!("{key}={value} ")).collect()
}

/// The configuration with the counts that `"auto"` resolves to.
fn effective(candidate: &Candidate) -> String {
    let Candidate { variant, on, .. } = candidate;
    let counted = Variant {
        terms: on.series().map(Series::terms).map_or(variant.terms, Auto::Value),
        window_radius: on.window_radius().map_or(variant.window_radius, Auto::Value),
        ..variant.clone()
    };
    counted.hash()
}

/// Errors of a preset in words without its name, so that the same error of many presets is printed once.
fn plain(errors: &[Error], name: &str) -> String {
    let one = |error: &Error| {
        let message = error.message();
        let cause = message.strip_prefix(&format!("{}: ", error.subject())).unwrap_or(&message);
        cause.replace(&format!("preset.{name}."), "")
    };
    errors.iter().map(one).collect::<Vec<_>>().join("; ")
}
