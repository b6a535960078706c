//! Zygo's text formats: `Zygo ASCII Data File` (phases as whole numbers) and `Zygo XYZ Data File` (pixels and µm).
//!
//! Source: MetroPro reference guide (Zygo OMP-0347), "ASCII data format". Fourteen header lines; the fourth holds the
//! origin and size of the phase map, the eighth scale factor, wavelength in m, obliquity and m per pixel, the eleventh the
//! resolution of phases. `#` ends header, intensities and phases. A height is `phase·S·W·O/R`.

use super::decode::lines;
use crate::error::{Error, Result};
use crate::surface::check_pixels;
use crate::surface::length::Unit;
use crate::surface::raster::{Lateral, Raster, Samples, Stated};

/// Phases from here on are void.
const VOID: f64 = 2_147_483_640.0;

/// Phase steps per wave for the values 0, 1 and 2 of `PhaseRes`.
const STEPS: [f64; 3] = [4096.0, 32768.0, 131_072.0];

/// Reads a text that begins as one of these formats.
pub(super) fn read(text: &str, subject: &str) -> Option<Result<Raster>> {
    let is_xyz = text.starts_with("Zygo XYZ Data File");
    (is_xyz || text.starts_with("Zygo ASCII Data File")).then(|| parse(text, is_xyz, subject))
}

fn parse(text: &str, is_xyz: bool, subject: &str) -> Result<Raster> {
    let broken = |cause: &str| {
        Error::new(subject, format!("the Zygo file {cause}"))
            .remedy("it is truncated or of another version; export it again")
    };
    let all: Vec<&str> = lines(text).map(|(_, line)| line.trim()).collect();
    let marks: Vec<usize> =
        all.iter().enumerate().filter(|(_, line)| **line == "#").map(|(at, _)| at).collect();
    let start = *marks.first().ok_or_else(|| broken("has no `#` after its header"))?;
    let number = |line: usize, field: usize| {
        let fields = all[..start].get(line)?.split_whitespace().nth(field)?;
        fields.parse::<f64>().ok().filter(|v| v.is_finite())
    };
    let count = |field: usize| {
        let found = number(3, field).filter(|n| *n >= 0.0 && *n < 1e9);
        found.map(|n| n as u64).ok_or_else(|| broken("has no size of its phase map in line 4"))
    };
    let (columns, rows) = check_pixels(subject, count(2)?, count(3)?)?;
    let mut ends = marks[1..].to_vec();
    ends.push(all.len());
    let mut from = start + 1;
    let mut sections = Vec::new();
    for end in ends {
        sections.push(&all[from.min(end)..end]);
        from = end + 1;
    }
    let mut stated = Stated { heights_by: "the Zygo format".to_owned(), ..Stated::default() };
    // a camera that is not calibrated has the resolution 0
    if let Some(pitch) = number(7, 6).filter(|p| *p > 0.0) {
        stated.pitch = [Some(pitch); 2];
        stated.lateral = Lateral::Um(1e6);
        stated.pitch_by = "CameraRes of the Zygo header".to_owned();
    }
    let values = if is_xyz {
        stated.unit = Some(Unit::Length(1.0));
        let origin = [number(3, 0).unwrap_or(0.0), number(3, 1).unwrap_or(0.0)];
        let places = sections.first().copied().unwrap_or_default();
        pixels(places, [columns, rows], origin)
            .ok_or_else(|| broken("has a line that is no pixel"))?
    } else {
        let resolution = number(10, 0).filter(|r| [0.0, 1.0, 2.0].contains(r));
        let steps = resolution.map(|r| STEPS[r as usize]);
        let factors = (number(7, 1), number(7, 2), number(7, 4), steps);
        let (Some(s), Some(wave), Some(obliquity), Some(steps)) = factors else {
            return Err(broken("has no scale of its phases in lines 8 and 11"));
        };
        stated.unit = Some(Unit::Length(s * wave * 1e6 * obliquity / steps));
        let words = |section: &[&str]| -> usize {
            section.iter().map(|line| line.split_whitespace().count()).sum()
        };
        let phases = sections.iter().rev().find(|section| words(section) == columns * rows);
        let phases =
            phases.ok_or_else(|| broken("has another number of phases than its header says"))?;
        let parsed: Option<Vec<f64>> = phases
            .iter()
            .flat_map(|line| line.split_whitespace())
            .map(|word| word.parse::<f64>().ok())
            .collect();
        let mut values = parsed.ok_or_else(|| broken("has a phase that is not a number"))?;
        values.iter_mut().filter(|v| **v >= VOID).for_each(|v| *v = f64::NAN);
        values
    };
    Ok(Raster { columns, rows, samples: Samples::Float(values), stated, notes: Vec::new() })
}

/// Lines `column row height`, or `column row No Data`, counted from the origin; the first row is the top one.
fn pixels(lines: &[&str], [columns, rows]: [usize; 2], origin: [f64; 2]) -> Option<Vec<f64>> {
    let mut values = vec![f64::NAN; columns * rows];
    for line in lines.iter().filter(|line| !line.is_empty()) {
        let mut words = line.split_whitespace();
        let mut place = |axis: usize, count: usize| {
            let at = words.next()?.parse::<f64>().ok()? - origin[axis];
            (at >= 0.0 && at < count as f64).then_some(at as usize)
        };
        let (column, row) = (place(0, columns)?, place(1, rows)?);
        let height = words.next()?;
        values[row * columns + column] = match height {
            "No" => f64::NAN,
            number => number.parse().ok()?,
        };
    }
    Some(values)
}
