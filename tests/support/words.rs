//! What texts of plans use of the vocabulary, so that no test has a list of keys or words of its own.

use std::collections::BTreeSet;

use diffraction_shaders::plan::{Key, vocabulary};
use toml::Value;

/// A table, a key in it, and a word if the key takes words.
pub type Use = (String, String, Option<String>);

/// Everything that a plan may have: every key, and every word of it.
pub fn all() -> BTreeSet<Use> {
    let key = |Key { table, name, words }: Key| {
        let of = move |word: Option<String>| (table.to_owned(), name.clone(), word);
        let words: Vec<_> = words.into_iter().map(Some).chain([None]).collect();
        words.into_iter().map(of)
    };
    let all: BTreeSet<Use> = vocabulary().into_iter().flat_map(key).collect();
    // a list that became empty would make every test that compares with it pass
    for (table, key, word) in [
        ("", "targets", None),
        ("surface", "level", Some("rows")),
        ("surface.grating", "kind", Some("crossed")),
        ("surface.grating", "duty", None),
        ("surface.grating", "regularity", None),
        ("surface.optics", "colour", Some("thesis")),
        ("optics", "colour", Some("thesis")),
        ("variants", "terms", Some("auto")),
        ("preset", "surfaces", None),
        ("preset", "colour", Some("srgb")),
        ("preset.wavelengths", "step_nm", None),
        ("targets", "tables", Some("exr")),
    ] {
        let one = (table.to_owned(), key.to_owned(), word.map(str::to_owned));
        assert!(all.contains(&one), "{one:?} is not in the vocabulary");
    }
    all
}

/// What the text of a plan uses; strings that are no words, such as names, are left out.
pub fn used(text: &str) -> BTreeSet<Use> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let plan: toml::Table = toml::from_str(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let mut found = BTreeSet::new();
    walk("", &plan, &vocabulary(), &mut found);
    found
}

fn walk(path: &str, table: &toml::Table, vocabulary: &[Key], found: &mut BTreeSet<Use>) {
    for (name, value) in table {
        found.insert((path.to_owned(), name.clone(), None));
        let key = vocabulary.iter().find(|key| key.table == path && key.name == *name);
        let mut values = vec![value];
        while let Some(value) = values.pop() {
            match value {
                Value::Array(items) => values.extend(items),
                Value::Table(inner) => {
                    let below = match (path, name.as_str()) {
                        // the parts of a crossed grating are gratings
                        ("surface.grating", "x" | "y") => path.to_owned(),
                        ("", name) => name.to_owned(),
                        (path, name) => format!("{path}.{name}"),
                    };
                    walk(&below, inner, vocabulary, found);
                }
                Value::String(word) if key.is_some_and(|key| !key.words.is_empty()) => {
                    found.insert((path.to_owned(), name.clone(), Some(word.clone())));
                }
                _ => {}
            }
        }
    }
}
