//! An axis: everything needed to read, name, list and document one key of a variant.

use serde_json::Value;

use super::Variant;
use super::item::Item;
use super::words::{AUTO, names};

/// A key of `[variants]`, of a preset or of `[optics]`.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    pub(super) key: &'static str,
    /// Description of the key in one line, for the manual.
    pub(super) about: &'static str,
    /// Values other than words, for the manual.
    pub(super) values: &'static str,
    /// The words that the key accepts. Empty for keys that accept only numbers.
    pub(super) words: fn() -> Vec<&'static str>,
    /// For a key whose value may be an array: whether an array is one value. `None`: an array is a list of values.
    pub(super) is_one: Option<fn(&Item) -> bool>,
    /// Reads a value into a variant.
    pub(super) read: fn(&Item, &mut Variant) -> Option<()>,
    /// Its entries in the canonical configuration. A mode may read only some of them.
    pub(super) entries: &'static [Entry],
    /// Its part of the canonical name.
    pub(super) part: Part,
}

/// An entry of the canonical configuration.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) key: &'static str,
    pub(super) value: fn(&Variant) -> Value,
    /// Copies the entry's value from one variant to another.
    pub(super) copy: fn(&Variant, &mut Variant),
}

/// When an axis adds a part to the canonical name.
#[derive(Clone, Copy)]
pub(super) enum Part {
    /// Whenever the mode reads it.
    Always(fn(&Variant) -> String),
    /// If it differs from the documented default.
    Changed(fn(&Variant) -> String),
    /// If it differs, as a range, with the step if the mode reads it.
    Wavelengths,
    /// Never, since the key is another way to write the values of other keys.
    Alias,
}

impl Axis {
    /// Copies the axis' value from one variant to another.
    pub(super) fn copy(&self, from: &Variant, to: &mut Variant) {
        self.entries.iter().for_each(|entry| (entry.copy)(from, to));
    }

    /// Whether the key is another way to write the values of other keys.
    pub(super) fn is_alias(&self) -> bool {
        matches!(self.part, Part::Alias)
    }

    /// Whether two variants have different values.
    pub(super) fn differs(&self, a: &Variant, b: &Variant) -> bool {
        self.entries.iter().any(|entry| (entry.value)(a) != (entry.value)(b))
    }

    /// The value in a variant, whether the mode reads it or not. It is an object if the axis has several entries.
    pub(super) fn value(&self, of: &Variant) -> Value {
        match self.entries {
            [entry] if entry.key == self.key => (entry.value)(of),
            entries => entries.iter().map(|e| (e.key.to_owned(), (e.value)(of))).collect(),
        }
    }
}

/// An entry that is a field of the variant.
macro_rules! entry {
    ($key:expr, $($field:ident).+) => {
        $crate::plan::axis::entry!($key, $($field).+, |v| serde_json::json!(v.$($field).+))
    };
    ($key:expr, $($field:ident).+, $value:expr) => {
        $crate::plan::axis::Entry {
            key: $key,
            value: $value,
            copy: |from, to| to.$($field).+.clone_from(&from.$($field).+),
        }
    };
}

/// A key that is a field of the variant and accepts only words. The manual and the reader share one list of them.
macro_rules! worded {
    ($key:literal, $($field:ident).+, $words:expr, $about:literal, $part:expr) => {
        $crate::plan::axis::Axis {
            key: $key,
            about: $about,
            values: "",
            words: || $crate::plan::words::names($words),
            is_one: None,
            read: |item, into| item.word($words).map(|word| into.$($field).+ = word),
            entries: &[$crate::plan::axis::entry!($key, $($field).+)],
            part: $part,
        }
    };
}

/// A key that is a field of the variant and does not accept words.
macro_rules! valued {
    ($key:literal, $($field:ident).+, $read:path, $values:literal, $about:literal, $part:expr) => {
        $crate::plan::axis::Axis {
            key: $key,
            about: $about,
            values: $values,
            words: Vec::new,
            is_one: None,
            read: |item, into| $read(item).map(|value| into.$($field).+ = value),
            entries: &[$crate::plan::axis::entry!($key, $($field).+)],
            part: $part,
        }
    };
}

/// The only word of a key whose number the tool can choose.
pub(super) fn auto() -> Vec<&'static str> {
    names(AUTO)
}

pub(super) use {entry, valued, worded};
