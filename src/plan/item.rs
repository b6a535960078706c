//! Values of a TOML text with their places, and checks that turn them into numbers and words.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::fmt::Display;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::Error;

/// Maximum number of errors reported for one plan. A text with more is probably not a plan.
const MAX_ERRORS: usize = 100;

/// Maximum length of an error's cause in characters. A key in a plan may be megabytes long.
const MAX_CAUSE: usize = 500;

/// The text that is being read, and the errors found in it.
pub(crate) struct Source<'a> {
    text: &'a str,
    /// Position of the end of each line.
    ends: Vec<usize>,
    file: String,
    errors: RefCell<Vec<(usize, Error)>>,
    /// Number of errors beyond [`MAX_ERRORS`].
    omitted: Cell<usize>,
}

impl<'a> Source<'a> {
    pub(crate) fn new(text: &'a str, file: impl Display) -> Source<'a> {
        let ends = text.match_indices('\n').map(|(at, _)| at).collect();
        let (errors, omitted) = Default::default();
        Source { text, ends, file: file.to_string(), errors, omitted }
    }

    /// Records an error at a byte of the text.
    pub(crate) fn fail(&self, at: usize, cause: impl Display, remedy: Option<String>) {
        if self.is_full() {
            return self.omitted.set(self.omitted.get() + 1);
        }
        let line = self.ends.partition_point(|end| *end < at) + 1;
        let error = Error::new(format!("{}:{line}", self.file), cut(cause, MAX_CAUSE));
        let error = match remedy {
            Some(remedy) => error.remedy(remedy),
            None => error,
        };
        self.errors.borrow_mut().push((at, error));
    }

    /// Records an error of the text as a whole.
    pub(crate) fn fail_file(&self, cause: impl Display, remedy: impl Display) {
        if self.is_full() {
            return self.omitted.set(self.omitted.get() + 1);
        }
        let error = Error::new(&self.file, cause).remedy(remedy);
        self.errors.borrow_mut().push((0, error));
    }

    /// Records the faults of a text that is not TOML.
    pub(crate) fn fail_toml(&self, faults: &[toml::de::Error]) {
        for fault in faults {
            let cause = format!("not valid TOML: {}", fault.message().replace('\n', ", "));
            let remedy = "correct the TOML at this place".to_owned();
            self.fail(fault.span().map_or(0, |span| span.start), cause, Some(remedy));
        }
    }

    /// All recorded errors, in the order of the text. If there are too many, the first that were found, and the number
    /// of the others.
    pub(crate) fn into_errors(self) -> Vec<Error> {
        let mut errors = self.errors.into_inner();
        errors.sort_by_key(|(at, _)| *at);
        let omitted = match self.omitted.get() {
            0 => None,
            n => Some(
                Error::new(&self.file, format!("has {n} more errors"))
                    .remedy("fix the errors above first"),
            ),
        };
        errors.into_iter().map(|(_, error)| error).chain(omitted).collect()
    }

    /// Whether further errors are only counted.
    fn is_full(&self) -> bool {
        self.errors.borrow().len() >= MAX_ERRORS
    }
}

/// A table with its dotted path and place.
#[derive(Clone)]
pub(crate) struct Table<'s, 't> {
    pub(crate) source: &'s Source<'t>,
    pub(crate) path: String,
    table: &'s DeTable<'t>,
    at: usize,
}

impl<'s, 't> Table<'s, 't> {
    pub(crate) fn root(source: &'s Source<'t>, table: &'s DeTable<'t>) -> Table<'s, 't> {
        Table { source, path: String::new(), table, at: 0 }
    }

    /// The value of a key.
    pub(crate) fn get(&self, key: &str) -> Option<Item<'s, 't>> {
        self.items().into_iter().find(|(name, _)| *name == key).map(|(_, item)| item)
    }

    /// The value of a key. It is an error if the key is missing.
    pub(crate) fn require(&self, key: &str, what: &str) -> Option<Item<'s, 't>> {
        let item = self.get(key);
        if item.is_none() {
            self.fail(format!("{} is missing", self.path_of(key)), Some(what.to_owned()));
        }
        item
    }

    /// All keys and values.
    pub(crate) fn items(&self) -> Vec<(&'s str, Item<'s, 't>)> {
        self.table
            .iter()
            .map(|(key, value)| (&**key.get_ref(), self.item(key.get_ref(), value)))
            .collect()
    }

    /// Records an error for every unknown key, with the most similar known key.
    pub(crate) fn only(&self, known: &[&str]) {
        for (key, _) in self.table.iter().filter(|(key, _)| !known.contains(&&**key.get_ref())) {
            let cause = format!("unknown key {}", self.path_of(key.get_ref()));
            let remedy = (!self.source.is_full()).then(|| suggest(key.get_ref(), known));
            self.source.fail(key.span().start, cause, remedy);
        }
    }

    /// The tables of an array of tables, none if the key is missing.
    pub(crate) fn tables(&self, key: &str) -> Vec<Table<'s, 't>> {
        let Some(item) = self.get(key) else { return Vec::new() };
        if !item.is_array() {
            item.fail("is not an array of tables", format!("write [[{key}]] with two brackets"));
            return Vec::new();
        }
        let elements = item.elements("tables").unwrap_or_default();
        elements.iter().filter_map(|element| element.table(&format!("[[{key}]]"))).collect()
    }

    /// Checks that `schema` is 1.
    pub(crate) fn schema(&self, what: &str) {
        if let Some(item) = self.require("schema", what)
            && item.plain().and_then(|value| value.as_integer()) != Some(1)
        {
            item.fail("must be 1", what);
        }
    }

    /// The same table with another path, once its name is known.
    pub(crate) fn renamed(&self, path: String) -> Table<'s, 't> {
        Table { path, ..self.clone() }
    }

    /// Records an error of the table as a whole.
    pub(crate) fn fail(&self, cause: impl Display, remedy: Option<String>) {
        self.source.fail(self.at, cause, remedy);
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn item(&self, key: &str, value: &'s Spanned<DeValue<'t>>) -> Item<'s, 't> {
        Item {
            source: self.source,
            path: self.path_of(key),
            value: value.get_ref(),
            span: value.span(),
        }
    }
}

/// A value with its dotted path and place.
#[derive(Clone)]
pub(crate) struct Item<'s, 't> {
    pub(crate) path: String,
    source: &'s Source<'t>,
    value: &'s DeValue<'t>,
    span: Range<usize>,
}

impl<'s, 't> Item<'s, 't> {
    /// Records the error `path = value: cause (remedy)` at the place of the value.
    pub(crate) fn fail(&self, cause: impl Display, remedy: impl Display) {
        let cause = format!("{} = {}: {cause}", self.path, self.shown());
        self.source.fail(self.span.start, cause, Some(remedy.to_string()));
    }

    pub(crate) fn is_array(&self) -> bool {
        self.value.is_array()
    }

    pub(crate) fn is_table(&self) -> bool {
        self.value.is_table()
    }

    pub(crate) fn is_integer(&self) -> bool {
        self.value.is_integer()
    }

    pub(crate) fn as_str(&self) -> Option<&'s str> {
        self.value.as_str()
    }

    /// The elements of an array. An array of tables is an array, too.
    pub(crate) fn elements(&self, what: &str) -> Option<Vec<Item<'s, 't>>> {
        let Some(array) = self.value.as_array() else {
            self.wrong_type(&format!("an array of {what}"));
            return None;
        };
        let element = |(i, value): (usize, &'s Spanned<DeValue<'t>>)| Item {
            source: self.source,
            path: format!("{}[{}]", self.path, i + 1),
            value: value.get_ref(),
            span: value.span(),
        };
        Some(array.iter().enumerate().map(element).collect())
    }

    pub(crate) fn table(&self, what: &str) -> Option<Table<'s, 't>> {
        let Some(table) = self.value.as_table() else {
            self.wrong_type(&format!("a table: {what}"));
            return None;
        };
        Some(Table { source: self.source, path: self.path.clone(), table, at: self.span.start })
    }

    pub(crate) fn string(&self, what: &str) -> Option<&'s str> {
        if !self.value.is_str() {
            self.wrong_type(&format!("a string: {what}"));
        }
        self.value.as_str()
    }

    pub(crate) fn boolean(&self) -> Option<bool> {
        if !self.value.is_bool() {
            self.wrong_type("true or false");
        }
        self.value.as_bool()
    }

    /// A finite number that passes a check. Integers are accepted.
    pub(crate) fn number(
        &self,
        must: &str,
        what: &str,
        check: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        let number = match self.value {
            DeValue::Integer(n) => {
                i64::from_str_radix(n.as_str(), n.radix()).ok().map(|n| n as f64)
            }
            DeValue::Float(x) => x.as_str().parse().ok(),
            _ => {
                self.wrong_type(&format!("a number: {what}"));
                return None;
            }
        };
        let number = number.filter(|x: &f64| x.is_finite() && check(*x));
        if number.is_none() {
            self.fail(format!("must be {must}"), what);
        }
        number
    }

    /// A positive finite number.
    pub(crate) fn positive(&self, what: &str) -> Option<f64> {
        self.number("positive and finite", what, |x| x > 0.0)
    }

    /// A whole number in a range.
    pub(crate) fn whole(&self, range: Range<u64>, what: &str) -> Option<u64> {
        let DeValue::Integer(n) = self.value else {
            self.wrong_type(&format!("a whole number: {what}"));
            return None;
        };
        let number = u64::from_str_radix(n.as_str(), n.radix()).ok().filter(|n| range.contains(n));
        if number.is_none() {
            let must = match range.end {
                u64::MAX => {
                    "must be a whole number of at least".to_owned() + &format!(" {}", range.start)
                }
                end => format!("must be a whole number from {} to {}", range.start, end - 1),
            };
            self.fail(must, what);
        }
        number
    }

    /// One of the words of a list.
    pub(crate) fn word<T: Copy>(&self, words: &[(&'static str, T)]) -> Option<T> {
        let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
        let Some(text) = self.value.as_str() else {
            self.wrong_type(&format!("one of {}", quoted(&known)));
            return None;
        };
        let found = words.iter().find(|(word, _)| *word == text);
        if found.is_none() {
            self.fail("unknown value", suggest(text, &known));
        }
        found.map(|(_, meaning)| *meaning)
    }

    /// Records the error that the value is not among the known names, with the most similar one.
    pub(crate) fn unknown(&self, cause: &str, known: &BTreeSet<&str>) {
        let known: Vec<&str> = match self.source.is_full() {
            true => Vec::new(),
            false => known.iter().copied().collect(),
        };
        self.fail(cause, self.as_str().map_or_else(String::new, |text| suggest(text, &known)));
    }

    /// The value without places, for types that implement `Deserialize`.
    pub(crate) fn plain(&self) -> Option<toml::Value> {
        plain(self.value)
    }

    fn wrong_type(&self, wanted: &str) {
        self.fail(
            format!("is {}", with_article(self.value.type_str())),
            format!("expected {wanted}"),
        );
    }

    /// The value as written, shortened to one line.
    fn shown(&self) -> String {
        if self.value.is_table() {
            return "{…}".to_owned();
        }
        let text = self.source.text.get(self.span.clone()).unwrap_or("…");
        let line = text.lines().next().unwrap_or("…");
        let short: String = line.chars().take(48).collect();
        if short.len() < text.len() { format!("{short}…") } else { short }
    }
}

/// The first characters of a text.
fn cut(text: impl Display, longest: usize) -> String {
    let text = text.to_string();
    match text.char_indices().nth(longest) {
        Some((at, _)) => format!("{}…", &text[..at]),
        None => text,
    }
}

/// Maximum length of a word that is compared with the known ones. Time and memory grow with its length.
const MAX_WORD: usize = 64;

/// `did you mean …` if a known word is similar, otherwise the list of known words.
pub(crate) fn suggest(text: &str, known: &[&str]) -> String {
    let text = if text.len() > MAX_WORD { "" } else { text };
    let distance = |word: &str| strsim::damerau_levenshtein(text, word);
    let nearest = known.iter().min_by_key(|word| distance(word));
    match nearest {
        Some(word) if distance(word) <= 2.max(word.len() / 3) => {
            format!("did you mean \"{word}\"?")
        }
        Some(word) if known.len() > 12 => format!("the nearest known one is \"{word}\""),
        _ => format!("known: {}", known.join(", ")),
    }
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}

fn with_article(name: &str) -> String {
    let article = if name.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {name}")
}

fn plain(value: &DeValue<'_>) -> Option<toml::Value> {
    Some(match value {
        DeValue::String(text) => toml::Value::String(text.to_string()),
        DeValue::Integer(n) => {
            toml::Value::Integer(i64::from_str_radix(n.as_str(), n.radix()).ok()?)
        }
        DeValue::Float(x) => toml::Value::Float(x.as_str().parse().ok()?),
        DeValue::Boolean(b) => toml::Value::Boolean(*b),
        DeValue::Datetime(at) => toml::Value::Datetime(*at),
        DeValue::Array(items) => toml::Value::Array(
            items.iter().map(|item| plain(item.get_ref())).collect::<Option<_>>()?,
        ),
        DeValue::Table(table) => {
            let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
                Some((ToString::to_string(key.get_ref()), plain(value.get_ref())?))
            };
            toml::Value::Table(table.iter().map(entry).collect::<Option<_>>()?)
        }
    })
}
