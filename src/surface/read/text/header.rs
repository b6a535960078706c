//! What the lines before the numbers say: keys with values, and names of columns.
//!
//! [`super::keys`] lists the keys.

use super::keys::Axis::{self, Both, X, Y};
use super::keys::{Key, key_of};
use super::names::{self, Column, Role};
use crate::surface::length::{Unit, quantity, unit};
use crate::surface::raster::{Lateral, Stated};

/// Lines of a header beyond this many say nothing about heights.
const MAX_LINES: usize = 4000;

/// A line that is no key with a value.
#[derive(Clone, Debug)]
pub(super) struct Remark {
    pub line: usize,
    pub text: String,
    /// Whether it begins with `#`.
    pub is_comment: bool,
}

/// The lines before the numbers of a block.
#[derive(Clone, Debug, Default)]
pub(super) struct Header {
    entries: Vec<(Key, String, String)>,
    pub remarks: Vec<Remark>,
}

/// Key and value of a line.
fn entry(line: &str) -> Option<(Key, &str, &str)> {
    let line = line.trim().trim_start_matches(['#', '%', '/', '!', '*', '\\', '"', ' ']);
    let split = line
        .split_once([':', '=', '：'])
        .or_else(|| line.split_once(char::is_whitespace).filter(|(_, v)| quantity(v).is_some()));
    let (key, value) = split?;
    Some((key_of(key)?, key.trim(), value.trim().trim_end_matches('"')))
}

impl Header {
    /// Whether a line after numbers begins another block.
    pub fn begins_block(line: &str) -> bool {
        matches!(entry(line), Some((Key::Channel | Key::Size(_) | Key::Heights, ..)))
    }

    pub fn add(&mut self, line: usize, text: &str, is_comment: bool) {
        if self.entries.len() + self.remarks.len() >= MAX_LINES {
            return;
        }
        match entry(text) {
            Some((key, name, value)) => {
                self.entries.push((key, name.to_owned(), value.to_owned()));
            }
            None if text.trim().is_empty() => {}
            None => self.remarks.push(Remark { line, text: text.to_owned(), is_comment }),
        }
    }

    /// Takes what another header says, for a block that says nothing itself.
    pub fn inherit(&mut self, other: &Header) {
        if self.entries.is_empty() {
            let other = other.entries.iter().filter(|(key, ..)| *key != Key::Channel);
            self.entries.extend(other.cloned());
        }
    }

    /// Takes what lines after the numbers say.
    pub fn append(&mut self, footer: Header) {
        self.entries.extend(footer.entries);
    }

    fn value(&self, wanted: Key) -> Option<&str> {
        self.entries.iter().find(|(key, ..)| *key == wanted).map(|(.., value)| value.as_str())
    }

    /// The channel's name.
    pub fn channel(&self) -> Option<&str> {
        self.value(Key::Channel).filter(|name| !name.is_empty())
    }

    /// What a block is called in messages: its channel, or its last remark.
    pub fn label(&self) -> Option<String> {
        let remark = || self.remarks.last().map(|r| r.text.as_str());
        self.channel().or_else(remark).map(|text| text.chars().take(40).collect())
    }

    /// Names of columns: the last remark, if it has that many names.
    pub fn columns(&self, width: usize) -> Option<Vec<Column>> {
        let named = names::columns(&self.remarks.last()?.text)?;
        (named.len() == width).then_some(named)
    }

    /// Columns and rows, if both are stated.
    pub fn pixels(&self) -> Option<(u64, u64)> {
        let count = |axis| {
            let (number, rest) = quantity(self.value(Key::Pixels(axis))?)?;
            (rest.is_empty() && (1.0..1e9).contains(&number) && number.fract() == 0.0)
                .then_some(number as u64)
        };
        Some((count(X)?, count(Y)?))
    }

    /// What is stated about a matrix of `pixels` columns and rows.
    pub fn stated(&self, pixels: [usize; 2]) -> Stated {
        let mut stated = Stated { void_value: self.number(Key::Void), ..Stated::default() };
        self.lateral(&mut stated, pixels);
        self.heights(&mut stated);
        stated
    }

    fn number(&self, key: Key) -> Option<f64> {
        quantity(self.value(key)?).map(|(number, _)| number)
    }

    fn lateral(&self, stated: &mut Stated, pixels: [usize; 2]) {
        for (kind, is_size) in [
            (Key::Size as fn(Axis) -> Key, true),
            (Key::Length as fn(Axis) -> Key, true),
            (Key::Pitch as fn(Axis) -> Key, false),
        ] {
            let both = self.pair(kind);
            let of = |axis: Axis, place: usize| {
                let found =
                    self.value(kind(axis)).and_then(|text| self.length(text, axis, kind(axis)));
                found.or(both.map(|b| b[place]))
            };
            let found = [of(X, 0), of(Y, 1)];
            // `Height: 40 nm` without a width may be the height of a step
            let Some((x, unit)) = found[0] else { continue };
            let is_count = is_size && unit.is_none() && x == pixels[0] as f64;
            if is_count || !(x.is_finite() && x > 0.0) {
                continue;
            }
            let um = |unit: Option<f64>| unit.unwrap_or(1.0);
            let per = |place: usize| if is_size { pixels[place] as f64 } else { 1.0 };
            let y = found[1].filter(|(y, other)| *y > 0.0 && other.is_some() == unit.is_some());
            stated.pitch = [Some(x * um(unit) / per(0)), y.map(|(y, unit)| y * um(unit) / per(1))];
            stated.lateral = unit.map_or(Lateral::Unknown, |_| Lateral::Um(1.0));
            stated.pitch_by = self.words(&[kind(X), kind(Y), kind(Both)]);
            return;
        }
    }

    /// Two lengths of one key: `Scan Size: 500 500 nm`, `5 µm`.
    fn pair(&self, kind: fn(Axis) -> Key) -> Option<[(f64, Option<f64>); 2]> {
        let text = self.value(kind(Both))?;
        let (first, rest) = quantity(text)?;
        let rest = rest.trim_start_matches(['x', '×', '*', ' ']);
        match quantity(rest) {
            Some((second, words)) => {
                let (_, unit) = self.length(&format!("{second} {words}"), X, kind(Both))?;
                Some([(first, unit), (second, unit)])
            }
            None => Some([self.length(text, X, kind(Both))?; 2]),
        }
    }

    /// A number and the µm of its unit, which may stand elsewhere. Nothing if the unit is none of length.
    fn length(&self, text: &str, axis: Axis, key: Key) -> Option<(f64, Option<f64>)> {
        let (number, words) = quantity(text)?;
        let elsewhere = || self.value(Key::Unit(axis)).or_else(|| self.value(Key::Unit(X)));
        let elsewhere = || elsewhere().or_else(|| self.value(Key::Unit(Both)));
        let words = if words.is_empty() { elsewhere().unwrap_or_default() } else { words };
        match (unit(words), words.is_empty(), key) {
            (Unit::Length(um), ..) => Some((number, Some(um))),
            (_, true, Key::Length(_)) => Some((number, Some(1e-3))),
            (_, true, _) => Some((number, None)),
            (Unit::Other(_), false, _) => None,
        }
    }

    fn heights(&self, stated: &mut Stated) {
        let scale = match self.value(Key::ScaleNeeded) {
            Some(word) if word.eq_ignore_ascii_case("yes") => self.number(Key::Scale),
            _ => None,
        };
        let scaled = |found: Unit| match found {
            Unit::Length(um) => Unit::Length(um * scale.unwrap_or(1.0)),
            other => other,
        };
        let of_range = |text: &str| quantity(text).map(|(_, words)| unit(words));
        let found = self
            .value(Key::Heights)
            .map(|words| scaled(unit(words)))
            .or_else(|| {
                self.number(Key::Bit2nm).filter(|n| *n > 0.0).map(|nm| Unit::Length(nm * 1e-3))
            })
            .or_else(|| self.value(Key::Amplitude).and_then(of_range));
        if found.is_some() {
            stated.unit = found;
            stated.heights_by = self.words(&[Key::Heights, Key::Bit2nm, Key::Amplitude]);
        }
    }

    /// The lines with these keys, for messages.
    fn words(&self, keys: &[Key]) -> String {
        let lines = self.entries.iter().filter(|(key, ..)| keys.contains(key));
        let shown: Vec<String> =
            lines.map(|(_, name, value)| format!("`{name}: {value}`")).take(2).collect();
        shown.join(", ")
    }
}

/// Adds the units of named columns: `lateral` and `heights` are their places.
pub(super) fn of_columns(
    stated: &mut Stated,
    columns: &[Column],
    lateral: Option<usize>,
    heights: usize,
) {
    if let (None, Some(found)) = (&stated.unit, &columns[heights].unit) {
        stated.unit = Some(found.clone());
        stated.heights_by = format!("column `{}`", columns[heights].label);
    }
    if stated.lateral == Lateral::LikeHeights
        && let Some(Column { unit: Some(Unit::Length(um)), .. }) = lateral.map(|at| &columns[at])
    {
        stated.lateral = Lateral::Um(*um);
    }
}

/// The place of the column of heights: the chosen one, the one that is called so, or the last.
pub(super) fn height_column(columns: &[Column], channel: Option<&str>) -> Option<usize> {
    match channel {
        Some(wanted) => columns.iter().position(|c| c.label.eq_ignore_ascii_case(wanted.trim())),
        None => columns.iter().position(|c| c.role() == Role::Height).or(match columns.len() {
            0 => None,
            n => Some(n - 1),
        }),
    }
}
