//! `[optics]`, `[variants]` and `[[preset]]`: from tables to variants, axis by axis.

use super::axis::Axis;
use super::item::{Item, Table};
use super::optics::OPTICS;
use super::variant::axes;
use super::{Optics, Variant, constraints};

/// Maximum number of combinations of the axes of a plan.
pub const MAX_VARIANTS: usize = 4096;

/// Reads `[optics]`, with the documented defaults for missing keys.
pub(super) fn read_optics(table: &Table) -> Optics {
    table.only(&OPTICS.map(|axis| axis.key));
    let mut variant = Variant::standard(&Optics::standard());
    stated(table);
    read_each(table, OPTICS.iter(), &mut variant);
    variant.optics
}

/// Reads `[variants]` and returns all combinations of its values. `base` gives the values of missing keys.
pub(super) fn read_product(table: &Table, base: &Variant) -> Vec<Variant> {
    table.only(&axes().map(|axis| axis.key).collect::<Vec<_>>());
    let values: Vec<(&Axis, Vec<Variant>)> =
        axes().filter_map(|axis| Some((axis, axis_values(axis, &table.get(axis.key)?)))).collect();
    let count = values.iter().try_fold(1usize, |n, (_, values)| n.checked_mul(values.len()));
    if count.is_none_or(|n| n > MAX_VARIANTS) {
        let remedy = "remove values from the axes, or write the variants that you want as presets"
            .to_owned();
        table.fail(
            format!("variants: the product has more than {MAX_VARIANTS} combinations"),
            Some(remedy),
        );
        return Vec::new();
    }
    let base = Variant { stated: stated(table), ..base.clone() };
    values.iter().fold(vec![base], |variants, (axis, values)| {
        let with = |variant: &Variant, value: &Variant| {
            let mut variant = variant.clone();
            axis.copy(value, &mut variant);
            variant
        };
        variants
            .iter()
            .flat_map(|variant| values.iter().map(move |value| with(variant, value)))
            .collect()
    })
}

/// Reads the keys of a preset, apart from `names`, which only presets have. `base` gives the values of missing keys.
/// Records an error if the combination cannot be built.
pub(super) fn read_preset(table: &Table, names: &[&str], base: &Variant) -> Option<Variant> {
    let known: Vec<_> = axes().map(|axis| axis.key).chain(names.iter().copied()).collect();
    table.only(&known);
    let mut variant = Variant { stated: stated(table), ..base.clone() };
    read_each(table, axes(), &mut variant);
    constraints::normalise(&mut variant);
    let refusals = constraints::broken(&variant);
    for (key, reason) in &refusals {
        match table.get(key) {
            Some(item) => item.fail(reason, CHANGE),
            None => table.fail(format!("{}: {reason}", table.path), Some(CHANGE.to_owned())),
        }
    }
    refusals.is_empty().then_some(variant)
}

/// Remedy of a preset that a constraint rejects.
const CHANGE: &str = "change this key, or the other key that the message names";

/// Keys of the optics that the table states. A key that is another way to write the values of other keys counts as
/// these. It is an error if the table has both.
pub(super) fn stated(table: &Table) -> Vec<&'static str> {
    let mut keys: Vec<&'static str> = Vec::new();
    for axis in &OPTICS {
        let Some(item) = table.get(axis.key) else { continue };
        if !axis.is_alias() {
            keys.push(axis.key);
            continue;
        }
        for entry in axis.entries {
            if keys.contains(&entry.key) {
                let cause = format!("{} is there, too", entry.key);
                item.fail(cause, "keep one of the two keys");
            } else {
                keys.push(entry.key);
            }
        }
    }
    keys
}

/// Reads one value for each key.
pub(super) fn read_each(
    table: &Table,
    axes: impl Iterator<Item = &'static Axis>,
    into: &mut Variant,
) {
    for axis in axes {
        let Some(item) = table.get(axis.key) else { continue };
        if item.is_array() && axis.is_one.is_none() {
            item.fail("is an array", "expected one value; only [variants] accepts several");
            continue;
        }
        // errors are recorded by `read`
        let _ = (axis.read)(&item, into);
    }
}

/// The values of an axis, each in a variant of its own. A single value counts as an array of one.
fn axis_values(axis: &Axis, item: &Item) -> Vec<Variant> {
    let whole = !item.is_array() || axis.is_one.is_some_and(|is_one| is_one(item));
    let items =
        if whole { vec![item.clone()] } else { item.elements("values").unwrap_or_default() };
    if items.is_empty() {
        item.fail("has no values", "list at least one, or remove the key to use its default");
    }
    if items.len() > MAX_VARIANTS {
        item.fail(format!("has more than {MAX_VARIANTS} values"), "remove values from the axis");
        return Vec::new();
    }
    let read = |item: &Item| {
        let mut variant = Variant::standard(&Optics::standard());
        (axis.read)(item, &mut variant).map(|()| variant)
    };
    let values: Vec<Variant> = items.iter().filter_map(read).collect();
    for (i, value) in values.iter().enumerate() {
        if values[..i].contains(value) && values.len() == items.len() {
            items[i].fail("is listed twice", "remove one of the two");
        }
    }
    values
}
