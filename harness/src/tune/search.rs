//! Decides whose colours are computed: few of many, in an order that does not depend on the machine.
//!
//! Candidates of one form differ in counts only, so their costs and bounds can be compared. A candidate within the budget
//! excludes all that cost at least as much. A candidate over the budget excludes all that are at most as accurate by every
//! bound. The search begins a form with its most expensive candidate: if that is over the budget, the whole form is dropped.
//! Then it continues in the middle of the rest. Between forms only a large difference in texels decides, since texels of
//! different forms cost different times.

use std::collections::BTreeSet;

use crate::results::{LightError, Verdict};

use super::Candidate;

/// Candidates that read more than this many times the texels of one within the budget are not measured: the time of a texel
/// differs between forms by a factor of three.
const COSTLY: f64 = 6.0;
/// Number of texels below which the rest of a pixel takes longer than the texels.
const FEW: f64 = 10.0;

/// The result of measuring a candidate.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// Errors under each light.
    Errors(Vec<LightError>),
    /// A 95th percentile too large to continue, and the light under which it was found.
    Far(f64, [f64; 2]),
    /// An error.
    Failed(String),
}

/// The state of a candidate in a search.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// Errors under each light.
    Measured(Vec<LightError>),
    /// A 95th percentile too large to continue, and the light under which it was found.
    Far(f64, [f64; 2]),
    /// Not measured, with the reason.
    Lost(Verdict, String),
}

impl State {
    /// The maximum 95th percentile, if it was measured to the end.
    pub fn worst_p95(&self) -> Option<f64> {
        match self {
            State::Measured(errors) => errors.iter().map(LightError::worst_p95).reduce(f64::max),
            State::Far(..) | State::Lost(..) => None,
        }
    }
}

/// Measures as few candidates as needed to find the cheapest one of every form within the budget. Returns the states in the order
/// of the candidates. An error of `measure` ends the search.
pub fn search<E>(
    candidates: &[Candidate],
    budget_de: f64,
    measure: &mut dyn FnMut(&Candidate) -> Result<Found, E>,
) -> Result<Vec<State>, E> {
    let mut states: Vec<Option<State>> = vec![None; candidates.len()];
    // the minimum number of texels among candidates within the budget, and that candidate
    let mut best: Option<usize> = None;
    for form in kinds(candidates) {
        let mut first = true;
        loop {
            if let Some(best) = best {
                let limit = COSTLY * candidates[best].fetches().max(FEW);
                let costly = |i: usize| candidates[i].fetches() > limit;
                let why = format!(
                    "more than {COSTLY} times the texels of {}",
                    candidates[best].variant.name
                );
                lose(&mut states, &form, costly, Verdict::Costly, &why);
            }
            let left: Vec<usize> = form.iter().copied().filter(|i| states[*i].is_none()).collect();
            let place =
                if first { left.len().saturating_sub(1) } else { (left.len().max(1) - 1) / 2 };
            let Some(&at) = left.get(place) else { break };
            first = false;
            let name = &candidates[at].variant.name;
            let state = match measure(&candidates[at])? {
                Found::Errors(errors) => State::Measured(errors),
                Found::Far(p95, light) => State::Far(p95, light),
                Found::Failed(why) => State::Lost(Verdict::Failed, why),
            };
            let within = state.worst_p95().is_some_and(|p95| p95 <= budget_de);
            // a failure says nothing about other candidates
            let judged = !matches!(state, State::Lost(Verdict::Failed, _));
            states[at] = Some(state);
            if within {
                let needless = |i: usize| costs_no_less(&candidates[i], &candidates[at]);
                let why = format!("{name} is within the budget");
                lose(&mut states, &form, needless, Verdict::Costlier, &why);
                if best.is_none_or(|best| candidates[at].fetches() < candidates[best].fetches()) {
                    best = Some(at);
                }
            } else if judged {
                let hopeless = |i: usize| {
                    let pairs = candidates[i].bounds.all().into_iter();
                    pairs.zip(candidates[at].bounds.all()).all(|(a, b)| a >= b)
                };
                let why = format!("{name} is over the budget");
                lose(&mut states, &form, hopeless, Verdict::Implied, &why);
            }
        }
    }
    Ok(states.into_iter().map(|state| state.unwrap_or_else(unreached)).collect())
}

/// The candidates worth timing, in the order of their texels: those within the budget, and a few that are slightly over it and read fewer
/// texels, so that the front of time and error continues beyond the budget.
pub fn to_time(candidates: &[Candidate], states: &[State], budget_de: f64) -> Vec<usize> {
    let measured: Vec<(usize, f64)> =
        states.iter().enumerate().filter_map(|(i, state)| Some((i, state.worst_p95()?))).collect();
    let mut within: Vec<usize> =
        measured.iter().filter(|(_, p95)| *p95 <= budget_de).map(|(i, _)| *i).collect();
    by_cost(candidates, &mut within);
    // one of every kind, since the time of a texel differs between kinds
    let mut seen = BTreeSet::new();
    let (firsts, rest): (Vec<usize>, Vec<usize>) =
        within.iter().partition(|i| seen.insert(candidates[**i].kind.as_str()));
    let mut within = [firsts, rest].concat();
    within.truncate(MAX_WITHIN);
    by_cost(candidates, &mut within);
    let Some(&cheapest) = within.first() else { return Vec::new() };
    let cheaper = |i: usize| candidates[i].fetches() < candidates[cheapest].fetches();
    let mut near: Vec<(usize, f64)> =
        measured.into_iter().filter(|(i, p95)| *p95 > budget_de && cheaper(*i)).collect();
    near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    within.extend(near.into_iter().take(MAX_NEAR).map(|(i, _)| i));
    by_cost(candidates, &mut within);
    within
}

/// Maximum number of timed candidates within the budget.
const MAX_WITHIN: usize = 12;
/// Maximum number of timed candidates over the budget.
const MAX_NEAR: usize = 3;

/// Candidates by kind, cheapest first. The kind with the cheapest candidate is first.
fn kinds(candidates: &[Candidate]) -> Vec<Vec<usize>> {
    let mut all: Vec<usize> = (0..candidates.len()).collect();
    by_cost(candidates, &mut all);
    let mut seen = BTreeSet::new();
    let kinds = all.iter().map(|i| candidates[*i].kind.as_str()).filter(|kind| seen.insert(*kind));
    let of = |kind: &str| all.iter().copied().filter(|i| candidates[*i].kind == kind).collect();
    kinds.map(of).collect()
}

fn by_cost(candidates: &[Candidate], places: &mut [usize]) {
    let cost = |i: usize| (candidates[i].fetches(), candidates[i].table_bytes());
    places.sort_by(|a, b| {
        let ((x, xs), (y, ys)) = (cost(*a), cost(*b));
        let names = || candidates[*a].variant.name.cmp(&candidates[*b].variant.name);
        x.total_cmp(&y).then(xs.cmp(&ys)).then_with(names)
    });
}

fn costs_no_less(one: &Candidate, other: &Candidate) -> bool {
    one.fetches() >= other.fetches() && one.table_bytes() >= other.table_bytes()
}

/// Settles the unsettled candidates of a form that a rule excludes.
fn lose(
    states: &mut [Option<State>],
    form: &[usize],
    rule: impl Fn(usize) -> bool,
    verdict: Verdict,
    why: &str,
) {
    for &i in form.iter().filter(|i| rule(**i)) {
        states[i].get_or_insert_with(|| State::Lost(verdict, why.to_owned()));
    }
}

/// The state of a candidate that the search did not reach. This cannot happen: every candidate has a form, and a form ends when
/// all its candidates are settled.
fn unreached() -> State {
    State::Lost(Verdict::Failed, "was not reached".to_owned())
}
