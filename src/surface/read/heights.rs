//! The heights of samples: what the plan says against what the file says.

use super::steps::{Steps, steps};
use crate::error::{Error, Result};
use crate::plan::{FileSource, Trust};
use crate::surface::length::{Unit, differs, shown};
use crate::surface::raster::{Samples, Stated};
use crate::surface::{MAX_HEIGHT_UM, check_um};

/// Checks the keys of heights as far as that does not need the file.
pub(super) fn check_keys(source: &FileSource, subject: &str) -> Result<()> {
    let check = |key: &str, value: Option<f64>, max: f64| {
        value.map_or(Ok(()), |v| check_um(subject, key, v, max))
    };
    check("height_um", source.height_um, MAX_HEIGHT_UM)?;
    // the largest unit of heights in files is the metre
    check("z_unit_um", source.z_unit_um, 1e6)
}

/// How samples become heights: `offset + sample·scale`, in µm.
pub(super) struct Conversion {
    scale: f64,
    offset: f64,
    /// Where the numbers come from, for messages.
    origin: String,
    /// Whether neither plan nor file names the unit of a float file.
    pub unit_is_assumed: bool,
}

impl Conversion {
    /// µm per unit of a float file, or of the full grey range.
    pub fn unit_um(&self) -> f64 {
        self.scale
    }

    /// How an integer file quantises its heights.
    pub fn steps(&self, samples: &Samples) -> Option<Steps> {
        steps(samples, self.scale)
    }

    /// Converts samples to µm. NaN stays NaN; infinities are errors.
    pub fn heights(&self, samples: Samples, columns: usize, subject: &str) -> Result<Vec<f64>> {
        let mut values = match samples {
            Samples::Grey { shares, .. } => shares,
            Samples::Float(values) => values,
        };
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (i, v) in values.iter_mut().enumerate() {
            if v.is_infinite() {
                let cause =
                    format!("the height at column {}, row {} is {v}", i % columns, i / columns);
                return Err(Error::new(subject, cause).remedy("write NaN for void pixels"));
            }
            *v = self.offset + *v * self.scale;
            (low, high) = (low.min(*v), high.max(*v));
        }
        // infinite bounds have no difference
        if high - low > MAX_HEIGHT_UM || (high - low).is_nan() {
            let cause = format!(
                "heights from {low} to {high} µm ({}) span more than {MAX_HEIGHT_UM} µm",
                self.origin
            );
            return Err(Error::new(subject, cause).remedy(
                "if the numbers are in nm, set `z_unit_um = 0.001`; in Å, `z_unit_um = 0.0001`; if single pixels have no height, set `void_value`",
            ));
        }
        Ok(values)
    }
}

/// Decides how samples become heights. The plan's keys, or the file's words where the plan has none; an error if they
/// contradict each other, unless the plan is trusted.
pub(super) fn conversion(
    source: &FileSource,
    samples: &Samples,
    stated: &Stated,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<Conversion> {
    match samples {
        Samples::Grey { bits, .. } => grey(source, *bits, stated, subject, notes),
        Samples::Float(_) => float(source, stated, subject, notes),
    }
}

fn grey(
    source: &FileSource,
    bits: u8,
    stated: &Stated,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<Conversion> {
    let error = |cause: String| Error::new(subject, cause);
    let top = (1u32 << bits) - 1;
    if let Some(unit) = source.z_unit_um {
        return Err(error(format!(
            "`z_unit_um = {unit}` is for float files, but this file has {bits}-bit integers"
        ))
        .remedy(format!("give `height_um`, the height of the full grey range 0…{top}")));
    }
    let made = |scale, offset, origin| Conversion { scale, offset, origin, unit_is_assumed: false };
    match (source.height_um, stated.range_um) {
        (None, None) => Err(error(format!(
            "`height_um` is missing: the file has {bits}-bit integers without a unit"
        ))
        .remedy(format!(
            "give the height in µm of the full grey range 0…{top}, not of the image's extrema"
        ))),
        (None, Some([low, high])) => Ok(made(high - low, low, format!("by {}", stated.heights_by))),
        (Some(plan), None) => Ok(made(plan, 0.0, format!("`height_um = {plan}`"))),
        (Some(plan), Some([low, high])) => {
            if differs(plan, (high - low).abs()) {
                let says = format!("{} µm ({})", shown((high - low).abs()), stated.heights_by);
                contradiction(source, ("height_um", plan), &says, subject, notes)?;
            }
            let sign = if high < low { -1.0 } else { 1.0 };
            Ok(made(sign * plan, low, format!("`height_um = {plan}`")))
        }
    }
}

fn float(
    source: &FileSource,
    stated: &Stated,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<Conversion> {
    let error = |cause: String| Error::new(subject, cause);
    if let Some(height) = source.height_um {
        let cause = format!(
            "`height_um = {height}` is for integer files, but this file has floats, which are heights in {}",
            stated.unit_words()
        );
        return Err(error(cause)
            .remedy("remove `height_um`; if the numbers are not in µm, set `z_unit_um`"));
    }
    let scale = match (source.z_unit_um, &stated.unit) {
        (None, Some(Unit::Length(um))) => *um,
        (None, None) => 1.0,
        (None, Some(Unit::Other(_))) => {
            let cause = format!(
                "the unit of the file's heights, {} ({}), is not a unit of length",
                stated.unit_words(),
                stated.heights_by
            );
            return Err(error(cause)
                .remedy("choose the channel of heights, or give `z_unit_um`, the µm per unit"));
        }
        (Some(plan), Some(Unit::Length(um))) => {
            if differs(plan, *um) {
                let says = format!("{} µm per unit ({})", shown(*um), stated.heights_by);
                contradiction(source, ("z_unit_um", plan), &says, subject, notes)?;
            }
            plan
        }
        (Some(plan), _) => plan,
    };
    let assumed = source.z_unit_um.is_none() && stated.unit.is_none();
    let origin = format!("with {scale} µm per unit");
    Ok(Conversion { scale, offset: 0.0, origin, unit_is_assumed: assumed })
}

/// An error that the plan and the file contradict each other, or a note if the plan is trusted.
fn contradiction(
    source: &FileSource,
    (key, plan): (&str, f64),
    says: &str,
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<()> {
    if source.trust == Trust::Plan {
        notes.push(format!(
            "trust = \"plan\": `{key} = {plan}` is used, although the file states {says}"
        ));
        return Ok(());
    }
    let cause = format!("`{key} = {plan}` contradicts the file, which states {says}");
    let remedy =
        format!("remove `{key}` to use the file's, or add `trust = \"plan\"` to use the plan's");
    Err(Error::new(subject, cause).remedy(remedy))
}
