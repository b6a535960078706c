//! Axes of the product and keys of presets: one reader per key, one list that fixes their order.

use super::axis::{Axis, values, values_or_auto, worded};
use super::item::{Item, Table};
use super::mode::{self, MODES};
use super::optics::{OPTICS, OpticsSetting};
use super::words::{self, unavailable};
use super::{
    Auto, Basis, Mode, Optics, Packing, Reconstruction, Sampling, TableFormat, Variant, Wavelengths,
};

/// Most combinations that the axes of a plan may span.
pub const MAX_VARIANTS: usize = 4096;

/// Most wavelength samples of a variant.
const MAX_SAMPLES: f64 = 4000.0;

/// A configuration before the constraints: it may hold words that this version does not build.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Draft {
    pub(super) mode: Word<Mode>,
    pub(super) basis: Word<Basis>,
    pub(super) terms: Auto<u32>,
    pub(super) term_error: f64,
    pub(super) reconstruction: Word<Reconstruction>,
    pub(super) window_radius: Auto<u32>,
    pub(super) periods: Option<[u32; 2]>,
    pub(super) wavelengths: Wavelengths,
    pub(super) table: Word<TableFormat>,
    pub(super) packing: Packing,
    pub(super) bake_error: f64,
    pub(super) bake_mib: f64,
    pub(super) sampling: Sampling,
    pub(super) hoist: bool,
    pub(super) optics: Optics,
}

/// A word of the plan and its meaning; `None` when it is not available in this version.
pub(super) type Word<T> = (&'static str, Option<T>);

/// One value of one axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Setting {
    Mode(Word<Mode>),
    Basis(Word<Basis>),
    Terms(Auto<u32>),
    TermError(f64),
    Reconstruction(Word<Reconstruction>),
    WindowRadius(Auto<u32>),
    Periods(Option<[u32; 2]>),
    Wavelengths(Wavelengths),
    Table(Word<TableFormat>),
    Packing(Packing),
    BakeError(f64),
    BakeMib(f64),
    Sampling(Sampling),
    Hoist(bool),
    Optics(OpticsSetting),
}

/// Keys of `[variants]` and of a preset in the order of the product: the first varies slowest.
pub(super) const AXES: [Axis; 14] = [
    worded!("mode", MODES, Setting::Mode),
    worded!("basis", words::BASES, Setting::Basis),
    values_or_auto("terms", |item| {
        auto(item, 1..201, "the number of terms, or \"auto\"").map(Setting::Terms)
    }),
    values("term_error", term_error),
    worded!("reconstruction", words::RECONSTRUCTIONS, Setting::Reconstruction),
    values_or_auto("window_radius", |item| {
        auto(item, 0..65, "bins to each side of the nearest one, or \"auto\"")
            .map(Setting::WindowRadius)
    }),
    values_or_auto("periods", |item| periods(item).map(Setting::Periods)),
    values("wavelengths", |item| wavelengths(item).map(Setting::Wavelengths)),
    worded!("table", words::TABLE_FORMATS, Setting::Table),
    worded!("packing", words::PACKINGS, |(_, packing)| Setting::Packing(packing)),
    worded!("sampling", words::SAMPLINGS, |(_, word)| Setting::Sampling(word)),
    values("hoist", |item| item.boolean().map(Setting::Hoist)),
    values("bake_error", bake_error),
    values("bake_mib", bake_mib),
];

/// Keys of a range of wavelengths.
pub(super) const WAVELENGTHS: [&str; 3] = ["min_nm", "max_nm", "step_nm"];

/// Reads `[optics]` over the documented defaults.
pub(super) fn read_optics(table: &Table) -> Optics {
    table.only(&OPTICS.map(|axis| axis.key));
    let mut draft = Draft::standard(Optics::standard());
    for (_, value) in preset_values(table, &OPTICS) {
        draft.set(value);
    }
    draft.optics
}

/// Reads `[variants]` and spans the product over a base.
pub(super) fn read_product(table: &Table, base: &Draft) -> Vec<Draft> {
    let axes = [AXES.as_slice(), OPTICS.as_slice()].concat();
    table.only(&axes.iter().map(|axis| axis.key).collect::<Vec<_>>());
    let values: Vec<Vec<Setting>> = axes
        .iter()
        .filter_map(|axis| Some(axis_values(axis.key, &table.get(axis.key)?, axis.read)))
        .collect();
    let count = values.iter().try_fold(1usize, |n, axis| n.checked_mul(axis.len()));
    if count.is_none_or(|n| n > MAX_VARIANTS) {
        let remedy =
            "take values from the axes, or name the variants you want as presets".to_owned();
        table.fail(
            format!("variants: the product has more than {MAX_VARIANTS} combinations"),
            Some(remedy),
        );
        return Vec::new();
    }
    values.iter().fold(vec![base.clone()], |drafts, axis| {
        drafts
            .iter()
            .flat_map(|draft| axis.iter().map(|value| draft.clone().with(value.clone())))
            .collect()
    })
}

/// Reads the keys of a preset, `name` apart, over a base; refuses what cannot be built.
pub(super) fn read_preset(table: &Table, base: &Draft) -> Option<Variant> {
    let axes = [AXES.as_slice(), OPTICS.as_slice()].concat();
    let mut known: Vec<_> = axes.iter().map(|axis| axis.key).collect();
    known.push("name");
    table.only(&known);
    let draft = preset_values(table, &axes)
        .into_iter()
        .fold(base.clone(), |draft, (_, value)| draft.with(value));
    match mode::normalised(draft).build(String::new()) {
        Ok(variant) => Some(variant),
        Err(refusals) => {
            for (key, reason) in refusals {
                match table.get(key) {
                    Some(item) => item.fail(reason, "see `cargo xtask list` for what is available"),
                    None => table.fail(format!("{}: {reason}", table.path), None),
                }
            }
            None
        }
    }
}

impl Draft {
    /// The documented defaults with given optics.
    pub(super) fn standard(optics: Optics) -> Draft {
        Draft {
            mode: ("full", Some(Mode::Full)),
            basis: ("taylor", Some(Basis::Taylor)),
            terms: Auto::Value(31),
            term_error: 1e-3,
            reconstruction: ("window", Some(Reconstruction::Window)),
            window_radius: Auto::Value(1),
            periods: None,
            wavelengths: Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 5.0 },
            table: ("f32", Some(TableFormat::F32)),
            packing: Packing::Paired,
            bake_error: 0.5,
            bake_mib: 32.0,
            sampling: Sampling::Load,
            hoist: true,
            optics,
        }
    }

    /// Applies the constraints; refusals name the key that they are about.
    pub(super) fn build(&self, name: String) -> Result<Variant, Vec<(&'static str, String)>> {
        let mut refusals = Vec::new();
        let mode = available(&mut refusals, "mode", self.mode);
        let basis = available(&mut refusals, "basis", self.basis);
        let reconstruction = available(&mut refusals, "reconstruction", self.reconstruction);
        let table = available(&mut refusals, "table", self.table);
        let (Some(mode), Some(basis), Some(reconstruction), Some(table), true) =
            (mode, basis, reconstruction, table, refusals.is_empty())
        else {
            return Err(refusals);
        };
        refusals.extend(mode::broken(mode, self));
        if !refusals.is_empty() {
            return Err(refusals);
        }
        Ok(Variant {
            name,
            mode,
            basis,
            terms: self.terms,
            term_error: self.term_error,
            reconstruction,
            window_radius: self.window_radius,
            periods: self.periods,
            wavelengths: self.wavelengths,
            table,
            packing: self.packing,
            bake_error: self.bake_error,
            bake_mib: self.bake_mib,
            sampling: self.sampling,
            hoist: self.hoist,
            optics: self.optics.clone(),
        })
    }

    fn with(mut self, value: Setting) -> Draft {
        self.set(value);
        self
    }

    fn set(&mut self, value: Setting) {
        match value {
            Setting::Mode(x) => self.mode = x,
            Setting::Basis(x) => self.basis = x,
            Setting::Terms(x) => self.terms = x,
            Setting::TermError(x) => self.term_error = x,
            Setting::Reconstruction(x) => self.reconstruction = x,
            Setting::WindowRadius(x) => self.window_radius = x,
            Setting::Periods(x) => self.periods = x,
            Setting::Wavelengths(x) => self.wavelengths = x,
            Setting::Table(x) => self.table = x,
            Setting::Packing(x) => self.packing = x,
            Setting::BakeError(x) => self.bake_error = x,
            Setting::BakeMib(x) => self.bake_mib = x,
            Setting::Sampling(x) => self.sampling = x,
            Setting::Hoist(x) => self.hoist = x,
            Setting::Optics(setting) => setting.apply(&mut self.optics),
        }
    }
}

fn available<T: Copy>(
    refusals: &mut Vec<(&'static str, String)>,
    key: &'static str,
    word: Word<T>,
) -> Option<T> {
    if word.1.is_none() {
        refusals.push((key, unavailable(key, word.0)));
    }
    word.1
}

fn preset_values(table: &Table, axes: &[Axis]) -> Vec<(&'static str, Setting)> {
    let value = |axis: &Axis| {
        let item = table.get(axis.key)?;
        if item.is_array() && axis.key != "periods" {
            item.fail("is an array", "expected one value; only [variants] takes several");
            return None;
        }
        Some((axis.key, (axis.read)(&item)?))
    };
    axes.iter().filter_map(value).collect()
}

/// The values of an axis: an array, or a single value in place of an array of one.
fn axis_values(key: &str, item: &Item, read: fn(&Item) -> Option<Setting>) -> Vec<Setting> {
    let whole = !item.is_array() || (key == "periods" && is_pair(item));
    let items =
        if whole { vec![item.clone()] } else { item.elements("values").unwrap_or_default() };
    if items.is_empty() {
        item.fail("has no values", "leave the key out to mean its default");
    }
    if items.len() > MAX_VARIANTS {
        item.fail(format!("has more than {MAX_VARIANTS} values"), "take values from the axis");
        return Vec::new();
    }
    let values: Vec<Setting> = items.iter().filter_map(read).collect();
    for (i, value) in values.iter().enumerate() {
        if values[..i].contains(value) && values.len() == items.len() {
            items[i].fail("is listed twice", "remove one of the two");
        }
    }
    values
}

fn is_auto(item: &Item) -> bool {
    words::AUTO.iter().any(|(word, ())| item.as_str() == Some(word))
}

fn auto(item: &Item, range: std::ops::Range<u64>, what: &str) -> Option<Auto<u32>> {
    match is_auto(item) {
        true => Some(Auto::Auto),
        false => item.whole(range, what).and_then(|n| u32::try_from(n).ok()).map(Auto::Value),
    }
}

fn term_error(item: &Item) -> Option<Setting> {
    let what = "the largest error of the phase function that terms = \"auto\" may leave";
    item.number("above 0 and at most 0.5", what, |x| x > 0.0 && x <= 0.5).map(Setting::TermError)
}

fn bake_error(item: &Item) -> Option<Setting> {
    let what = "the 95th percentile of CIEDE2000 that the sizes of a baked table aim at";
    item.number("from 0.05 to 10", what, |x| (0.05..=10.0).contains(&x)).map(Setting::BakeError)
}

fn bake_mib(item: &Item) -> Option<Setting> {
    let what = "the most that a baked table may have, in MiB";
    item.number("from 0.25 to 512", what, |x| (0.25..=512.0).contains(&x)).map(Setting::BakeMib)
}

fn is_pair(item: &Item) -> bool {
    item.elements("numbers")
        .is_some_and(|items| items.len() == 2 && items.iter().all(Item::is_integer))
}

fn periods(item: &Item) -> Option<Option<[u32; 2]>> {
    let what = "the numbers of replicas along x and y, [qx, qy], or \"auto\"";
    if is_auto(item) {
        return Some(None);
    }
    if !item.is_array() {
        item.fail("is neither a pair nor \"auto\"", what);
        return None;
    }
    let numbers = item.elements("two numbers")?;
    let [x, y] = numbers.as_slice() else {
        item.fail("has not two numbers", what);
        return None;
    };
    let read = |item: &Item| item.whole(1..10001, what).and_then(|n| u32::try_from(n).ok());
    Some(Some([read(x)?, read(y)?]))
}

fn wavelengths(item: &Item) -> Option<Wavelengths> {
    let table = item.table("{ min_nm, max_nm, step_nm }")?;
    table.only(&WAVELENGTHS);
    let limit = |key: &str, default: f64| match table.get(key) {
        Some(item) => {
            let what = "the range of the spectral tables; visible light is 380 to 780 nm";
            item.number("from 360 to 830", what, |x| (360.0..=830.0).contains(&x))
        }
        None => Some(default),
    };
    let (min_nm, max_nm) = (limit("min_nm", 380.0), limit("max_nm", 780.0));
    let step_nm = table
        .get("step_nm")
        .map_or(Some(5.0), |item| item.positive("the distance of samples in nm"));
    let (min_nm, max_nm, step_nm) = (min_nm?, max_nm?, step_nm?);
    let place = |key: &str| table.get(key).unwrap_or_else(|| item.clone());
    if min_nm > max_nm {
        place("min_nm")
            .fail(format!("min_nm {min_nm} is above max_nm {max_nm}"), "exchange the two");
        return None;
    }
    let range = max_nm - min_nm;
    if range > 0.0 && step_nm > range {
        let remedy = "for a single wavelength set max_nm to min_nm";
        place("step_nm")
            .fail(format!("a step of {step_nm} nm is wider than the range of {range} nm"), remedy);
        return None;
    }
    if (range / step_nm).ceil() + 1.0 > MAX_SAMPLES {
        let least = (range / (MAX_SAMPLES - 1.0) * 1000.0).ceil() / 1000.0;
        let remedy = format!("use a step of at least {least} nm");
        place("step_nm").fail(format!("gives more than {MAX_SAMPLES} samples"), remedy);
        return None;
    }
    Some(Wavelengths { min_nm, max_nm, step_nm })
}
