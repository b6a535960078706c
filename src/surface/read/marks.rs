//! Numbers that stand for pixels without a height.

use crate::error::{Error, Result};
use crate::plan::{FileSource, VoidValue};
use crate::surface::length::shown;
use crate::surface::raster::{Samples, Stated};

/// Numbers that programs write where they have no height: limits of integer types, round numbers of nines, Zygo's limit.
const KNOWN: [f64; 14] = [
    -9999.0,
    9999.0,
    -99999.0,
    99999.0,
    -999999.0,
    999999.0,
    -32768.0,
    32767.0,
    -32767.0,
    65535.0,
    2147483647.0,
    -2147483648.0,
    2147483640.0,
    4294967295.0,
];

/// No height has this size in any unit: blanks of Surfer are 1.7e38, the largest single-precision number is 3.4e38.
const HUGE: f64 = 1e30;

/// A known number is suspicious if it lies this many times the span of all others away from them.
const GAP: f64 = 10.0;

/// Integers with fewer levels than this may be a drawing, whose white lies far from its black.
const MIN_LEVELS: usize = 16;

/// Makes the samples void that the plan or the file marks so. It is an error if a number looks like such a mark and
/// neither says so.
pub(super) fn apply(
    source: &FileSource,
    stated: &Stated,
    samples: &mut Samples,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<()> {
    let mark = match (source.void_value, stated.void_value) {
        (Some(VoidValue::None), _) => return Ok(()),
        (Some(VoidValue::Number(plan)), file) => {
            if let Some(file) = file.filter(|file| *file != plan) {
                notes.push(format!("void_value = {plan} is used, although the file states {file}"));
            }
            Some((plan, "void_value"))
        }
        (None, Some(file)) => Some((file, "the file's header")),
        (None, None) => None,
    };
    if let Some((mark, by)) = mark {
        let count = remove(samples, mark);
        if count > 0 || source.void_value.is_some() {
            notes.push(format!("{count} pixels are {} and void, as {by} says", shown(mark)));
        }
    }
    match suspicious(samples) {
        None => Ok(()),
        Some((value, count)) => {
            let cause = format!(
                "{count} pixels are {value}, far from all other heights, as programs mark pixels without a height"
            );
            let remedy = format!(
                "write `void_value = {value}` if they have none, or `void_value = \"none\"` if this is a height"
            );
            Err(Error::new(subject, cause).remedy(remedy))
        }
    }
}

/// Makes samples that equal a mark void and returns how many there are.
fn remove(samples: &mut Samples, mark: f64) -> usize {
    let (values, equals): (&mut Vec<f64>, Box<dyn Fn(f64) -> bool>) = match samples {
        Samples::Grey { shares, bits } => {
            let top = f64::from((1u32 << *bits) - 1);
            (shares, Box::new(move |share| (share * top).round() == mark))
        }
        // marks of single-precision files are rounded to it
        Samples::Float(values) => {
            (values, Box::new(move |v| v == mark || v == f64::from(mark as f32)))
        }
    };
    let mut count = 0;
    for value in values.iter_mut().filter(|value| equals(**value)) {
        *value = f64::NAN;
        count += 1;
    }
    count
}

/// A number that looks like a mark, and how often it occurs.
fn suspicious(samples: &Samples) -> Option<(f64, usize)> {
    let (values, top) = match samples {
        Samples::Grey { bits: 8, .. } => return None,
        Samples::Grey { shares, bits } => (shares, Some(f64::from((1u32 << bits) - 1))),
        Samples::Float(values) => (values, None),
    };
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let (low, high) =
        finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return None;
    }
    for extreme in [low, high] {
        let number = top.map_or(extreme, |top| (extreme * top).round());
        let is_known = match top {
            Some(top) => number == 0.0 || number == top,
            None => KNOWN.contains(&number) || number.abs() >= HUGE,
        };
        if !is_known {
            continue;
        }
        let rest = || finite().filter(|v| *v != extreme);
        let (inner_low, inner_high) =
            rest().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let span = inner_high - inner_low;
        let gap = (extreme - inner_low).abs().min((extreme - inner_high).abs());
        let is_far = match top {
            None => number.abs() >= HUGE || (gap > GAP * span && gap > 0.0),
            Some(_) => gap > GAP * span && levels(rest()) >= MIN_LEVELS,
        };
        if is_far && (inner_high.is_finite() || number.abs() >= HUGE) {
            return Some((number, finite().filter(|v| *v == extreme).count()));
        }
    }
    None
}

/// Number of different values, as far as it matters.
fn levels(values: impl Iterator<Item = f64>) -> usize {
    let mut known: Vec<f64> = Vec::new();
    for value in values {
        if !known.contains(&value) {
            known.push(value);
            if known.len() >= MIN_LEVELS {
                break;
            }
        }
    }
    known.len()
}
