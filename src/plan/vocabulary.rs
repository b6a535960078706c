//! All keys and words of plans, so that tests and tools do not need lists of their own.

use std::collections::BTreeSet;

use serde_json::Value;

use super::axis::Axis;
use super::material;
use super::optics::OPTICS;
use super::variant::{AXES, WAVELENGTHS, axes};
use super::words::names;
use super::{Optics, Variant, parse, surface};

/// A key of a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    /// Dotted path of its table, without brackets. Empty at the top level.
    pub table: &'static str,
    /// The key.
    pub name: String,
    /// All words that the key accepts. Empty for keys that accept only numbers, tables, names or files.
    pub words: Vec<String>,
}

/// All keys of a plan with their words, table by table. The parser uses the same lists. The parts of a crossed grating
/// have the keys of a grating.
pub fn vocabulary() -> Vec<Key> {
    let mut keys = Vec::new();
    let mut add = |table, name: &str, words: Vec<&str>| {
        let words = words.into_iter().map(str::to_owned).collect();
        keys.push(Key { table, name: name.to_owned(), words });
    };
    for name in parse::SECTIONS {
        add("", name, Vec::new());
    }
    for name in surface::KEYS {
        add("surface", name, surface::words_of(name));
    }
    let kinds = surface::grating_words(None);
    add("surface.grating", "kind", kinds.iter().map(String::as_str).collect());
    let of_kinds = kinds.iter().flat_map(|kind| surface::grating_words(Some(kind)));
    for name in of_kinds.collect::<BTreeSet<_>>() {
        add("surface.grating", &name, Vec::new());
    }
    let of = |axis: &Axis| (axis.key, (axis.words)());
    for table in ["surface.optics", "optics"] {
        for (name, words) in OPTICS.iter().map(of) {
            add(table, name, words);
        }
    }
    for [table, films] in material::TABLES {
        add(table, material::NK, Vec::new());
        for name in material::FILM.into_iter().filter(|_| !films.is_empty()) {
            add(films, name, Vec::new());
        }
    }
    for name in parse::PRESET {
        add("preset", name, Vec::new());
    }
    for (table, waves) in [("variants", "variants.wavelengths"), ("preset", "preset.wavelengths")] {
        for (name, words) in axes().map(of) {
            add(table, name, words);
        }
        for name in WAVELENGTHS {
            add(waves, name, Vec::new());
        }
    }
    add("targets", parse::EMIT.0, names(parse::EMIT.1));
    add("targets", parse::TABLES.0, names(parse::TABLES.1));
    keys
}

/// An axis of a variant, for lists and manuals.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisDoc {
    /// The key.
    pub key: &'static str,
    /// All words that the key accepts.
    pub words: Vec<&'static str>,
    /// Values other than words. Empty if there are none.
    pub values: &'static str,
    /// The documented default; null for a key that is another way to write the values of other keys.
    pub default: Value,
    /// Description in one line.
    pub about: &'static str,
    /// Whether it is also a key of `[optics]`.
    pub is_optics: bool,
}

/// All keys of a variant, in the order of the product.
pub fn axis_docs() -> Vec<AxisDoc> {
    let standard = Variant::standard(&Optics::standard());
    let doc = |(place, axis): (usize, &Axis)| AxisDoc {
        key: axis.key,
        words: (axis.words)(),
        values: axis.values,
        default: if axis.is_alias() { Value::Null } else { axis.value(&standard) },
        about: axis.about,
        is_optics: place >= AXES.len(),
    };
    axes().enumerate().map(doc).collect()
}
