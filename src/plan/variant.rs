//! A variant, and the registry of its axes: the only place that has each key, its values, and its part of the name and
//! the configuration. The axes of light and material are beside [`Optics`].

use super::axis::{Axis, Part, auto, entry, valued, worded};
use super::item::Item;
use super::mode::MODES;
use super::number::{exponent, number};
use super::optics::OPTICS;
use super::words::{self, LIGHT_FUNCTIONS};
use super::{
    Auto, Basis, LightFunction, Mode, Optics, Packing, Reconstruction, Sampling, TableFormat,
    Wavelengths,
};

/// One configuration of the shader, before it meets a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Canonical name, or the name of the preset.
    pub name: String,
    /// Surfaces that the variant is for; `None` for all.
    pub surfaces: Option<Vec<String>>,
    /// Keys of the optics that its preset or an axis states. A surface's own optics do not override them.
    pub stated: Vec<&'static str>,
    /// The method by which it computes colours.
    pub mode: Mode,
    /// Expansion of the phase function.
    pub basis: Basis,
    /// Number of terms `T` (highest power `T - 1`).
    pub terms: Auto<u32>,
    /// Error that `terms = "auto"` must keep.
    pub term_error: f64,
    /// Whether it is built even if its stated error is above the limit, so that sweeps show what goes wrong. Read by modes
    /// with terms.
    pub accept_error: bool,
    /// How the amplitude is computed from the table. Read by `full` and `adaptive`.
    pub reconstruction: Reconstruction,
    /// Bins to each side of the nearest one.
    pub window_radius: Auto<u32>,
    /// Replicas of the patch along x and y; `None` to choose them from the coherence length. Read by `pq` only.
    pub periods: Option<[u32; 2]>,
    /// Wavelength samples.
    pub wavelengths: Wavelengths,
    /// Number format of the term table.
    pub table: TableFormat,
    /// How complex terms are stored in texels.
    pub packing: Packing,
    /// How shaders interpolate between texels. Read by variants that do so, see [`Variant::reads_between`].
    pub sampling: Sampling,
    /// Whether loop-invariant work is moved out of the loops.
    pub hoist: bool,
    /// Error that the size of a table of colours is chosen for, as the 95th percentile of CIEDE2000. Read by `baked` only.
    pub bake_error: f64,
    /// Maximum size of the table of colours, MiB. It takes precedence over the error. Read by `baked` only.
    pub bake_mib: f64,
    /// Number of tables with wider lobes beside that of `diffraction`. Read by `baked` only.
    pub spread_levels: Auto<u32>,
    /// Factor from the width of a table's lobes to that of the next. Read by variants with such tables.
    pub spread_step: f64,
    /// Number of directions that surroundings are asked for. Read by `baked` with tables of wider lobes and
    /// [`LightFunction::Environment`].
    pub cells: u32,
    /// Kinds of light that the shader has functions for, sorted; always with [`LightFunction::Direction`]. Read by `orders`, and
    /// by `baked` for paths and with tables of wider lobes. Words that a mode has no function for have no effect.
    pub lights: Vec<LightFunction>,
    /// Wavelengths per order under surroundings. Read by variants with [`LightFunction::Environment`].
    pub nodes: Auto<u32>,
    /// Error that `nodes = "auto"` must keep, as the 95th percentile of CIEDE2000.
    pub environment_error: f64,
    /// Whether functions have an argument for the angle, period and depth of a texel. Read by `orders`.
    pub pattern: bool,
    /// Least and greatest period of a texel, relative to that of the surface. Read by variants with [`Variant::pattern`].
    pub period_ratio: [f64; 2],
    /// The same for the depth.
    pub depth_ratio: [f64; 2],
    /// Light and material.
    pub optics: Optics,
}

impl Variant {
    /// Name of the built-in preset.
    pub const TEXTS: &str = "texts";

    /// The documented defaults with the given optics, without a name.
    pub(super) fn standard(optics: &Optics) -> Variant {
        Variant {
            name: String::new(),
            surfaces: None,
            stated: Vec::new(),
            mode: Mode::Full,
            basis: Basis::Taylor,
            terms: Auto::Value(31),
            term_error: 1e-3,
            accept_error: false,
            reconstruction: Reconstruction::Window,
            window_radius: Auto::Value(1),
            periods: None,
            wavelengths: Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 5.0 },
            table: TableFormat::F32,
            packing: Packing::Paired,
            sampling: Sampling::Load,
            hoist: true,
            bake_error: 0.5,
            bake_mib: 32.0,
            spread_levels: Auto::Value(0),
            spread_step: 2.0,
            cells: 128,
            lights: LIGHT_FUNCTIONS
                .iter()
                .map(|(_, function)| *function)
                .filter(|function| *function != LightFunction::Path)
                .collect(),
            nodes: Auto::Value(8),
            environment_error: 2.5,
            pattern: false,
            period_ratio: [0.5, 2.0],
            depth_ratio: [1.0, 1.0],
            optics: optics.clone(),
        }
    }

    /// The shader as the texts print it, the baseline of every speed claim: 31 `taylor-zero` terms, 3 × 3 bins, 380–780
    /// nm in steps of 5 nm, one complex term per texel, nothing hoisted. It is a baseline, so it is built on deep reliefs, too,
    /// where its error is above the limit.
    pub fn texts(optics: &Optics) -> Variant {
        Variant {
            name: Variant::TEXTS.to_owned(),
            basis: Basis::TaylorZero,
            packing: Packing::Single,
            hoist: false,
            accept_error: true,
            ..Variant::standard(optics)
        }
    }
}

/// Every key of a variant in the order of the product: the first varies slowest, the keys of the optics fastest.
pub(super) fn axes() -> impl Iterator<Item = &'static Axis> {
    AXES.iter().chain(&OPTICS)
}

/// Keys of `[variants]` and of presets, other than those of the optics.
pub(super) static AXES: [Axis; 24] = [
    worded!("mode", mode, MODES, "method, see above", Part::Always(|v| v.mode.as_str().to_owned())),
    worded!(
        "basis",
        basis,
        words::BASES,
        "expansion of the phase function over the heights",
        Part::Always(|v| v.basis.as_str().to_owned())
    ),
    Axis {
        words: auto,
        ..valued!(
            "terms",
            terms,
            terms,
            "1 to 200",
            "number of terms of the basis",
            Part::Always(|v| format!("t{}", v.terms))
        )
    },
    valued!(
        "term_error",
        term_error,
        term_error,
        "above 0, at most 0.5",
        "maximum error of the phase function for `terms = \"auto\"`",
        Part::Changed(|v| format!("e{}", exponent(v.term_error)))
    ),
    valued!(
        "accept_error",
        accept_error,
        Item::boolean,
        "`true`, `false`",
        "`true`: build it even if its stated error is above the limit; for sweeps",
        Part::Changed(|_| "accepted".to_owned())
    ),
    worded!(
        "reconstruction",
        reconstruction,
        words::RECONSTRUCTIONS,
        "`window`: sum over bins; `prefiltered`: table that contains the coherence window",
        Part::Changed(|v| v.reconstruction.as_str().to_owned())
    ),
    Axis {
        words: auto,
        ..valued!(
            "window_radius",
            window_radius,
            window_radius,
            "0 to 64",
            "bins to each side of the nearest one",
            Part::Changed(|v| format!("r{}", v.window_radius))
        )
    },
    Axis {
        words: auto,
        is_one: Some(is_pair),
        entries: &[entry!("periods", periods, |v| match v.periods {
            Some(periods) => serde_json::json!(periods),
            None => serde_json::json!("auto"),
        })],
        ..valued!(
            "periods",
            periods,
            periods,
            "`[x, y]`, 1 to 10000 each",
            "replicas of the patch along x and y",
            Part::Changed(|v| {
                v.periods.map_or_else(|| "qauto".to_owned(), |[x, y]| format!("q{x}x{y}"))
            })
        )
    },
    Axis {
        entries: &[
            entry!(MIN_NM, wavelengths.min_nm),
            entry!(MAX_NM, wavelengths.max_nm),
            entry!(STEP_NM, wavelengths.step_nm),
        ],
        ..valued!(
            "wavelengths",
            wavelengths,
            wavelengths,
            "`{ min_nm, max_nm, step_nm }`, 360 to 830 nm",
            "range of the light; `step_nm` for modes that step through it",
            Part::Wavelengths
        )
    },
    worded!(
        "table",
        table,
        words::TABLE_FORMATS,
        "number format of the large table",
        Part::Changed(|v| v.table.as_str().to_owned())
    ),
    worded!(
        "packing",
        packing,
        words::PACKINGS,
        "two complex terms in a texel (`paired`), or one (`single`)",
        Part::Changed(|v| v.packing.as_str().to_owned())
    ),
    worded!(
        "sampling",
        sampling,
        words::SAMPLINGS,
        "interpolation between texels: by loads, or by a linear filter",
        Part::Changed(|v| v.sampling.as_str().to_owned())
    ),
    valued!(
        "hoist",
        hoist,
        Item::boolean,
        "`true`, `false`",
        "`true`: loop-invariant work is moved out of the loops",
        Part::Changed(|_| "nohoist".to_owned())
    ),
    valued!(
        "bake_error",
        bake_error,
        bake_error,
        "0.05 to 10",
        "error that the size of a baked table is chosen for: 95th percentile of CIEDE2000",
        Part::Changed(|v| format!("e{}", number(v.bake_error)))
    ),
    valued!(
        "bake_mib",
        bake_mib,
        bake_mib,
        "0.25 to 512",
        "maximum size of a baked table, MiB",
        Part::Changed(|v| format!("m{}", number(v.bake_mib)))
    ),
    Axis {
        words: auto,
        ..valued!(
            "spread_levels",
            spread_levels,
            spread_levels,
            "0 to 16",
            "number of baked tables with wider lobes; `auto`: until a lobe is 20° wide",
            Part::Changed(|v| format!("w{}", v.spread_levels))
        )
    },
    valued!(
        "spread_step",
        spread_step,
        spread_step,
        "1.1 to 4",
        "factor from the width of lobes in a baked table to the next",
        Part::Changed(|v| format!("x{}", number(v.spread_step)))
    ),
    valued!(
        "cells",
        cells,
        cells,
        "8 to 1024",
        "directions that a baked variant with `spread_levels` asks the surroundings for",
        Part::Changed(|v| format!("c{}", v.cells))
    ),
    Axis {
        words: || words::names(LIGHT_FUNCTIONS),
        is_one: Some(is_of_words),
        ..valued!(
            "lights",
            lights,
            lights,
            "an array of these words",
            "kinds of light that the shader has functions for, `disc` and `polygon` in white and in colours; `direction` is always one of them; `path`: random directions for path tracers; `baked` has `direction`, `path`, and with `spread_levels` `disc` and `environment`",
            Part::Changed(|v| {
                let words: Vec<&str> = v.lights.iter().map(|light| light.as_str()).collect();
                words.join("-")
            })
        )
    },
    Axis {
        words: auto,
        ..valued!(
            "nodes",
            nodes,
            nodes,
            "2 to 64",
            "wavelengths per order under surroundings",
            Part::Changed(|v| format!("n{}", v.nodes))
        )
    },
    valued!(
        "environment_error",
        environment_error,
        environment_error,
        "0.5 to 20",
        "error under surroundings for `nodes = \"auto\"`: 95th percentile of CIEDE2000",
        Part::Changed(|v| format!("s{}", number(v.environment_error)))
    ),
    valued!(
        "pattern",
        pattern,
        Item::boolean,
        "`true`, `false`",
        "`true`: functions have an argument for the angle, period and depth of a texel",
        Part::Changed(|_| "pattern".to_owned())
    ),
    Axis {
        is_one: Some(is_range),
        ..valued!(
            "period_ratio",
            period_ratio,
            ratios,
            "`[least, greatest]`, 0.1 to 10 each",
            "periods of texels relative to that of the surface, for `pattern`",
            Part::Changed(|v| ratio_part("pr", v.period_ratio))
        )
    },
    Axis {
        is_one: Some(is_range),
        ..valued!(
            "depth_ratio",
            depth_ratio,
            ratios,
            "`[least, greatest]`, 0.1 to 10 each",
            "depths of texels relative to that of the surface, for `pattern`",
            Part::Changed(|v| ratio_part("dr", v.depth_ratio))
        )
    },
];

fn ratio_part(name: &str, [least, greatest]: [f64; 2]) -> String {
    format!("{name}{}x{}", number(least), number(greatest))
}

/// Keys of `wavelengths`.
pub(super) const WAVELENGTHS: [&str; 3] = [MIN_NM, MAX_NM, STEP_NM];
const MIN_NM: &str = "min_nm";
const MAX_NM: &str = "max_nm";
pub(super) const STEP_NM: &str = "step_nm";

/// Maximum number of wavelength samples of a variant.
const MAX_SAMPLES: f64 = 4000.0;

fn is_pair(item: &Item) -> bool {
    item.elements("numbers")
        .is_some_and(|items| items.len() == 2 && items.iter().all(Item::is_integer))
}

fn is_range(item: &Item) -> bool {
    let is_number = |item: &Item| !item.is_array();
    item.elements("numbers").is_some_and(|items| items.len() == 2 && items.iter().all(is_number))
}

/// Two numbers, the lesser first.
fn ratios(item: &Item) -> Option<[f64; 2]> {
    let items = item.elements("two numbers")?;
    let what = "the least and the greatest ratio that texels may have";
    let [least, greatest] = &items[..] else {
        item.fail("must have two numbers", what);
        return None;
    };
    let ratio = |item: &Item| item.number("from 0.1 to 10", what, |x| (0.1..=10.0).contains(&x));
    let (least, greatest) = (ratio(least)?, ratio(greatest)?);
    if least > greatest {
        item.fail(format!("begins with {least}, which is above {greatest}"), what);
        return None;
    }
    Some([least, greatest])
}

fn is_of_words(item: &Item) -> bool {
    let elements = item.elements("words");
    elements.is_some_and(|items| items.iter().any(|item| item.as_str().is_some()))
}

/// Words in any order. A single word counts as an array of one.
fn lights(item: &Item) -> Option<Vec<LightFunction>> {
    let items = if item.is_array() { item.elements("words")? } else { vec![item.clone()] };
    if items.is_empty() {
        item.fail("has no words", "list at least one kind of light, or remove the key");
        return None;
    }
    let mut found = vec![LightFunction::Direction];
    for item in items {
        found.push(item.word(LIGHT_FUNCTIONS)?);
    }
    found.sort_unstable();
    found.dedup();
    Some(found)
}

fn is_auto(item: &Item) -> bool {
    auto().iter().any(|word| item.as_str() == Some(word))
}

fn number_or_auto(item: &Item, range: std::ops::Range<u64>, what: &str) -> Option<Auto<u32>> {
    match is_auto(item) {
        true => Some(Auto::Auto),
        false => item.whole(range, what).and_then(|n| u32::try_from(n).ok()).map(Auto::Value),
    }
}

fn terms(item: &Item) -> Option<Auto<u32>> {
    number_or_auto(item, 1..201, "the number of terms, or \"auto\"")
}

fn window_radius(item: &Item) -> Option<Auto<u32>> {
    number_or_auto(item, 0..65, "the number of bins to each side of the nearest one, or \"auto\"")
}

fn spread_levels(item: &Item) -> Option<Auto<u32>> {
    number_or_auto(item, 0..17, "the number of tables with wider lobes, or \"auto\"")
}

fn spread_step(item: &Item) -> Option<f64> {
    let what =
        "the factor from the width of lobes in a table to that in the next; 1.4142136 for lamps";
    item.number("from 1.1 to 4", what, |x| (1.1..=4.0).contains(&x))
}

fn cells(item: &Item) -> Option<u32> {
    let what = "the number of directions that surroundings are asked for";
    item.whole(8..1025, what).and_then(|n| u32::try_from(n).ok())
}

fn nodes(item: &Item) -> Option<Auto<u32>> {
    number_or_auto(item, 2..65, "the number of wavelengths per order, or \"auto\"")
}

fn environment_error(item: &Item) -> Option<f64> {
    let what =
        "the error under surroundings for nodes = \"auto\", as the 95th percentile of CIEDE2000";
    item.number("from 0.5 to 20", what, |x| (0.5..=20.0).contains(&x))
}

fn term_error(item: &Item) -> Option<f64> {
    let what = "the maximum error of the phase function for terms = \"auto\"";
    item.number("above 0 and at most 0.5", what, |x| x > 0.0 && x <= 0.5)
}

fn bake_error(item: &Item) -> Option<f64> {
    let what = "the error that the size of a baked table is chosen for, as the 95th percentile of CIEDE2000";
    item.number("from 0.05 to 10", what, |x| (0.05..=10.0).contains(&x))
}

fn bake_mib(item: &Item) -> Option<f64> {
    let what = "the maximum size of a baked table in MiB";
    item.number("from 0.25 to 512", what, |x| (0.25..=512.0).contains(&x))
}

fn periods(item: &Item) -> Option<Option<[u32; 2]>> {
    let what = "give the numbers of replicas along x and y as [qx, qy], or \"auto\"";
    if is_auto(item) {
        return Some(None);
    }
    if !item.is_array() {
        item.fail("is neither a pair of numbers nor \"auto\"", what);
        return None;
    }
    let numbers = item.elements("two numbers")?;
    let [x, y] = numbers.as_slice() else {
        item.fail(format!("has {} numbers, not two", numbers.len()), what);
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
            let what = "the spectral tables have this range; visible light is 380 to 780 nm";
            item.number("from 360 to 830", what, |x| (360.0..=830.0).contains(&x))
        }
        None => Some(default),
    };
    let (min_nm, max_nm) = (limit(MIN_NM, 380.0), limit(MAX_NM, 780.0));
    let step_nm = table
        .get(STEP_NM)
        .map_or(Some(5.0), |item| item.positive("the distance between samples in nm"));
    let (min_nm, max_nm, step_nm) = (min_nm?, max_nm?, step_nm?);
    let place = |key: &str| table.get(key).unwrap_or_else(|| item.clone());
    if min_nm > max_nm {
        place(MIN_NM).fail(
            format!("min_nm {min_nm} is above max_nm {max_nm}"),
            "exchange min_nm and max_nm",
        );
        return None;
    }
    let range = max_nm - min_nm;
    if range > 0.0 && step_nm > range {
        let remedy = "use a smaller step, or set max_nm to min_nm for a single wavelength";
        place(STEP_NM)
            .fail(format!("a step of {step_nm} nm is wider than the range of {range} nm"), remedy);
        return None;
    }
    if (range / step_nm).ceil() + 1.0 > MAX_SAMPLES {
        let min_step_nm = (range / (MAX_SAMPLES - 1.0) * 1000.0).ceil() / 1000.0;
        let remedy = format!("use a step of at least {min_step_nm} nm");
        place(STEP_NM).fail(format!("gives more than {MAX_SAMPLES} samples"), remedy);
        return None;
    }
    Some(Wavelengths { min_nm, max_nm, step_nm })
}
