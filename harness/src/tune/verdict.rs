//! The front of time and error, the winner, and a record for every candidate.

use std::collections::BTreeMap;

use diffraction_shaders::plan::{Plan, Variant};
use diffraction_shaders::variant::Cost;

use crate::bench::result::settings;
use crate::results::{Bench, LightError, Time, Tune, Verdict};

use super::prune::Limits;
use super::search::State;
use super::{Candidate, Lost, preset};

/// The parameters of a search.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    /// The surface's name.
    pub surface: &'a str,
    /// The plan.
    pub plan: &'a Plan,
    /// The limits.
    pub limits: Limits,
    /// Directions towards the lights: theta and phi in degrees.
    pub lights: &'a [[f64; 2]],
    /// Graphics interface and name of the adapter.
    pub adapter: [&'a str; 2],
    /// Width and height of the timed map, in pixels.
    pub size: usize,
}

/// The results of a search.
#[derive(Clone, Debug)]
pub struct Results {
    /// The candidates of the search.
    pub candidates: Vec<Candidate>,
    /// Their states.
    pub states: Vec<State>,
    /// Candidates that did not take part.
    pub lost: Vec<Lost>,
    /// Times, or what went wrong, by the indices of candidates.
    pub times: BTreeMap<usize, Result<Time, String>>,
    /// The built-in preset `texts`.
    pub baseline: Baseline,
}

/// The results of the baseline.
#[derive(Clone, Debug)]
pub struct Baseline {
    /// Errors under each light.
    pub errors: Vec<LightError>,
    /// Its time, if it was measured.
    pub time: Option<Time>,
    /// Its cost.
    pub cost: Cost,
}

/// The time of a candidate from a measurement; `None` without a ratio.
pub fn time(bench: &Bench) -> Option<Time> {
    Some(Time {
        median_ms: bench.median_ms,
        mad_ms: bench.mad_ms,
        ns_per_pixel: bench.ns_per_pixel,
        ratio: bench.ratio?,
        ratio_interval: bench.ratio_interval?,
        pace: None,
        runs: bench.runs,
    })
}

/// A record for each candidate: the winner, the other measured ones by error, the baseline, then all that were not measured.
pub fn settle(run: &Run<'_>, results: &Results) -> Vec<Tune> {
    let Results { candidates, states, times, .. } = results;
    let mut records: Vec<Tune> = candidates
        .iter()
        .zip(states)
        .enumerate()
        .map(|(i, (candidate, state))| judged(run, candidate, state, times.get(&i)))
        .collect();
    let texts = Variant::texts(&run.plan.optics);
    let Baseline { errors, time, cost } = &results.baseline;
    records.push(Tune {
        verdict: Verdict::Baseline,
        errors: errors.clone(),
        time: *time,
        fetches: Some(cost.fetches_mean),
        table_bytes: Some(cost.table_bytes),
        settings: settings(&texts),
        ..empty(run, &texts.name, preset(&texts, &run.plan.optics))
    });
    if let Some(winner) = winner(&records) {
        records[winner].verdict = Verdict::Winner;
    }
    for on in front(&records.iter().map(Tune::place).collect::<Vec<_>>()) {
        records[on].front = true;
    }
    records.sort_by(|a, b| {
        let error = |r: &Tune| r.worst_p95().unwrap_or(f64::INFINITY);
        let rank = |r: &Tune| (r.errors.is_empty(), r.verdict);
        rank(a).cmp(&rank(b)).then(error(a).total_cmp(&error(b))).then(a.variant.cmp(&b.variant))
    });
    records.extend(results.lost.iter().map(|lost| Tune {
        verdict: lost.verdict,
        why: lost.why.clone(),
        ..empty(run, &lost.name, lost.preset.clone())
    }));
    records
}

/// The fastest timed candidate within the budget. Candidates whose pace, or else ratio, does not differ significantly from it
/// are ties. Among ties the smaller error wins, then the smaller tables, then the name.
pub fn winner(records: &[Tune]) -> Option<usize> {
    let timed: Vec<(usize, Time)> = records
        .iter()
        .enumerate()
        .filter(|(_, r)| r.verdict == Verdict::Within)
        .filter_map(|(i, r)| Some((i, r.time?)))
        .collect();
    let fastest = timed.iter().max_by(|a, b| a.1.ratio.total_cmp(&b.1.ratio))?.1;
    let ties = timed.iter().filter(|(_, time)| match time.pace {
        Some([_, most]) => most >= 1.0,
        None => time.ratio_interval[1] >= fastest.ratio_interval[0],
    });
    let error = |i: usize| records[i].worst_p95().unwrap_or(f64::INFINITY);
    let (place, _) = ties.min_by(|(a, _), (b, _)| {
        let rest = |i: usize| (records[i].table_bytes, &records[i].variant);
        error(*a).total_cmp(&error(*b)).then_with(|| rest(*a).cmp(&rest(*b)))
    })?;
    Some(*place)
}

/// The front: points for which no other is at least as good in both numbers and better in one.
pub fn front(places: &[Option<[f64; 2]>]) -> Vec<usize> {
    let beaten = |[x, y]: [f64; 2]| {
        places.iter().flatten().any(|[a, b]| *a <= x && *b <= y && (*a < x || *b < y))
    };
    let on = |(i, place): (usize, &Option<[f64; 2]>)| (!beaten((*place)?)).then_some(i);
    places.iter().enumerate().filter_map(on).collect()
}

fn judged(
    run: &Run<'_>,
    candidate: &Candidate,
    state: &State,
    time: Option<&Result<Time, String>>,
) -> Tune {
    let (mut verdict, mut why, errors) = match state {
        State::Lost(verdict, why) => (*verdict, why.clone(), Vec::new()),
        State::Far(p95, [theta, phi]) => {
            (Verdict::Far, format!("p95 {p95:.1} at light {theta},{phi}"), Vec::new())
        }
        State::Measured(errors) => {
            let within = state.worst_p95().is_some_and(|p95| p95 <= run.limits.budget_de);
            let verdict = if within { Verdict::Within } else { Verdict::Over };
            (verdict, String::new(), errors.clone())
        }
    };
    match time {
        Some(Err(error)) => (verdict, why) = (Verdict::Failed, error.clone()),
        None if verdict == Verdict::Within => {
            why = "not timed: others within the budget read fewer texels".to_owned();
        }
        _ => {}
    }
    let far_p95 = match state {
        State::Far(p95, _) => Some(*p95),
        _ => None,
    };
    Tune {
        verdict,
        why,
        errors,
        far_p95,
        time: time.and_then(|time| time.as_ref().ok().copied()),
        fetches: Some(candidate.fetches()),
        table_bytes: Some(candidate.table_bytes()),
        bounds: Some(candidate.bounds),
        settings: settings(&candidate.variant),
        ..empty(run, &candidate.variant.name, candidate.preset.clone())
    }
}

fn empty(run: &Run<'_>, name: &str, preset: String) -> Tune {
    let [backend, adapter] = run.adapter.map(str::to_owned);
    Tune {
        surface: run.surface.to_owned(),
        variant: name.to_owned(),
        verdict: Verdict::Refused,
        why: String::new(),
        front: false,
        budget_de: run.limits.budget_de,
        backend,
        adapter,
        lights: run.lights.to_vec(),
        size: run.size,
        fits: run.limits.fits.map(|profile| profile.name().to_owned()),
        max_table_mib: run.limits.max_table_mib,
        errors: Vec::new(),
        far_p95: None,
        time: None,
        fetches: None,
        table_bytes: None,
        bounds: None,
        preset,
        settings: serde_json::Value::Null,
    }
}
