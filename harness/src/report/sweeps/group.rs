//! Finds variants that differ in one setting only.

use std::collections::BTreeMap;

use serde_json::Value as Json;

use crate::report::merge::{Unit, unique};
use crate::report::number;
use crate::results::Lit;

/// Variants of a surface that differ in one setting only.
pub(super) struct Group<'a> {
    /// The surface's name.
    pub(super) surface: &'a str,
    /// The setting, or `light`.
    pub(super) key: String,
    /// A variant that the others are like in all other settings.
    pub(super) like: &'a str,
    /// The variants with their values of the setting, in the order of the values.
    pub(super) members: Vec<(Value, &'a Unit<'a>)>,
}

/// A setting of a variant.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// A number.
    Number(f64),
    /// Any other value, as text.
    Text(String),
    /// The mode, and what else distinguishes variants of one mode.
    Mode(usize, String),
    /// The light.
    Light(Lit),
}

impl Value {
    fn of(json: &Json) -> Value {
        match json {
            Json::Number(number) => Value::Number(number.as_f64().unwrap_or(f64::NAN)),
            Json::String(text) => Value::Text(text.clone()),
            other => Value::Text(other.to_string()),
        }
    }

    /// The value as text for people.
    pub(super) fn shown(&self) -> String {
        match self {
            Value::Number(number) => number::plain(*number),
            Value::Text(text) | Value::Mode(_, text) => text.clone(),
            Value::Light(light) => number::lit(light),
        }
    }

    /// The value as a number for an axis, if it is one.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Value::Number(number) => Some(*number),
            Value::Light(Lit::Direction([theta, _])) => Some(*theta),
            _ => None,
        }
    }

    /// The order of values: numbers by size, before words.
    fn rank(&self) -> (usize, f64, f64, &str) {
        match self {
            Value::Number(number) => (0, *number, 0.0, ""),
            Value::Light(Lit::Direction([theta, phi])) => (0, *theta, *phi, ""),
            Value::Light(Lit::Lights(name)) => (1, 0.0, 0.0, name),
            Value::Mode(place, text) => (1, *place as f64, 0.0, text),
            Value::Text(text) => (1, 0.0, 0.0, text),
        }
    }
}

/// All groups with at least two members, in the order of their surfaces.
pub(super) fn groups<'a>(units: &'a [Unit<'a>]) -> Vec<Group<'a>> {
    let mut groups = Vec::new();
    for surface in unique(units.iter().map(|u| u.surface)) {
        let own: Vec<&Unit<'_>> =
            units.iter().filter(|u| u.surface == surface && u.total().is_some()).collect();
        groups.extend(by_setting(surface, &own));
        groups.extend(by_mode(surface, &own));
        groups.extend(by_light(surface, &own));
    }
    groups
}

/// One group for each setting and each choice of all other settings.
fn by_setting<'a>(surface: &'a str, units: &[&'a Unit<'a>]) -> Vec<Group<'a>> {
    let mut alike: BTreeMap<(String, String), Vec<(Value, &Unit<'_>)>> = BTreeMap::new();
    for unit in units {
        let Some(settings) = unit.settings.as_object() else { continue };
        for (key, value) in settings.iter().filter(|(key, _)| *key != "mode") {
            let mut others = settings.clone();
            others.remove(key);
            let place = format!("{:?} {} {}", unit.light, unit.size, Json::Object(others));
            alike.entry((key.clone(), place)).or_default().push((Value::of(value), unit));
        }
    }
    alike.into_iter().filter_map(|((key, _), members)| group(surface, &key, members)).collect()
}

/// One group for each variant of the first mode, with the variants of other modes that agree with it in all settings that both
/// have.
fn by_mode<'a>(surface: &'a str, units: &[&'a Unit<'a>]) -> Vec<Group<'a>> {
    let modes = unique(units.iter().filter_map(|u| u.setting("mode")));
    let Some(first) = modes.first() else { return Vec::new() };
    let mut groups = Vec::new();
    for unit in units.iter().filter(|u| u.setting("mode") == Some(first)) {
        let mut members = vec![(Value::Mode(0, (*first).to_owned()), *unit)];
        for other in units.iter().filter(|u| (&u.light, u.size) == (&unit.light, unit.size)) {
            let mode = other.setting("mode").unwrap_or_default();
            let Some(place) = modes.iter().position(|m| *m == mode).filter(|place| *place > 0)
            else {
                continue;
            };
            if agree(unit.settings, other.settings) {
                members.push((Value::Mode(place, mode.to_owned()), other));
            }
        }
        groups.extend(group(surface, "mode", members));
    }
    groups
}

/// Whether two configurations agree in all settings that both have, except the mode.
fn agree(a: &Json, b: &Json) -> bool {
    let (Some(a), Some(b)) = (a.as_object(), b.as_object()) else { return false };
    a.iter()
        .filter(|(key, _)| *key != "mode")
        .all(|(key, value)| b.get(key).is_none_or(|other| other == value))
}

/// One group for each variant that was compared under several lights.
fn by_light<'a>(surface: &'a str, units: &[&'a Unit<'a>]) -> Vec<Group<'a>> {
    let mut alike: BTreeMap<(usize, &str), Vec<(Value, &Unit<'_>)>> = BTreeMap::new();
    for unit in units {
        alike
            .entry((unit.size, unit.variant))
            .or_default()
            .push((Value::Light(unit.light.clone()), unit));
    }
    alike.into_values().filter_map(|members| group(surface, "light", members)).collect()
}

/// The group with its members in order; `None` if it has only one.
fn group<'a>(
    surface: &'a str,
    key: &str,
    mut members: Vec<(Value, &'a Unit<'a>)>,
) -> Option<Group<'a>> {
    members.sort_by(|(a, _), (b, _)| {
        a.rank().partial_cmp(&b.rank()).unwrap_or(std::cmp::Ordering::Equal)
    });
    // two names for one configuration do not make a sweep
    members.dedup_by(|(a, x), (b, y)| a == b && x.settings == y.settings && key != "light");
    let like = members.first()?.1.variant;
    let distinct = unique(members.iter().map(|(value, _)| value)).len();
    (distinct > 1).then_some(Group { surface, key: key.to_owned(), like, members })
}
