//! Random plans as lines of text, one key each, so that a single line can be broken on purpose.
//!
//! Keys and words come from the vocabulary of the plan's reader: a new word is drawn at once, and a new key without words
//! stops the test until [`numbers`] has values for it.

use diffraction_shaders::plan::{Key, vocabulary};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{select, subsequence};

/// A plan of valid keys and values, line by line; words that exclude each other may meet in it.
#[derive(Clone, Debug)]
pub struct Draft {
    pub lines: Vec<String>,
}

impl Draft {
    pub fn text(&self) -> String {
        self.lines.iter().flat_map(|line| [line, "\n"]).collect()
    }
}

/// Forms whose tables grow beyond a quick test unless their numbers are kept small.
#[derive(Clone, Copy)]
struct Large {
    prefiltered: bool,
    baked: bool,
}

/// Plans of one or two small surfaces, a product of at most eight variants, a preset, optics, targets.
pub fn plans() -> impl Strategy<Value = Draft> {
    let rarely = || proptest::bool::weighted(0.3);
    let large = (rarely(), rarely());
    large.prop_flat_map(|(prefiltered, baked)| plans_with(Large { prefiltered, baked }))
}

fn plans_with(large: Large) -> impl Strategy<Value = Draft> {
    let own = prop_oneof![2 => Just(Vec::new()), 1 => some_optics("surface.optics", large)];
    let own = own.prop_map(|lines| prefixed("optics", lines));
    let surfaces = vec((sources(), preparation(), own), 1..=2);
    let parts = (surfaces, optics(large), product(large), preset(large), targets());
    parts.prop_map(|(surfaces, optics, product, preset, targets)| {
        let mut lines = vec!["schema = 1".to_owned()];
        for (i, (source, preparation, own)) in surfaces.into_iter().enumerate() {
            lines.push("[[surface]]".to_owned());
            lines.push(format!("name = \"surface-{i}\""));
            lines.extend(source.into_iter().chain(preparation).chain(own));
        }
        lines.extend(optics.into_iter().chain(product).chain(preset).chain(targets));
        Draft { lines }
    })
}

/// Where the heights come from: every kind of grating, and files that the seeds of the fuzz targets have.
fn sources() -> impl Strategy<Value = Vec<String>> {
    prop_oneof![4 => gratings().prop_map(|lines| prefixed("grating", lines)), 1 => files()]
}

fn gratings() -> impl Strategy<Value = Vec<String>> {
    let kinds = key("surface.grating", "kind").words;
    let of = |kind: String| match kind.as_str() {
        "crossed" => (profiles(), profiles())
            .prop_map(|(x, y)| {
                let kind = "kind = \"crossed\"".to_owned();
                [kind].into_iter().chain(prefixed("x", x)).chain(prefixed("y", y)).collect()
            })
            .boxed(),
        "bumps" | "fingers" | "rows" => rough(kind).boxed(),
        _ => profile(kind).boxed(),
    };
    select(kinds).prop_flat_map(of)
}

/// One of the gratings that may be a part of a crossed one.
fn profiles() -> impl Strategy<Value = Vec<String>> {
    let kinds = ["flat", "sinusoidal", "blazed", "lamellar", "triangle"].map(str::to_owned);
    select(kinds.to_vec()).prop_flat_map(profile)
}

fn profile(kind: String) -> impl Strategy<Value = Vec<String>> {
    // the shortest wavelength of any plan is 360 nm, so a pitch below 90 nm carries all orders
    let numbers = (2..=60u32, 0.005..0.0899f64, 0.001..0.8f64, 0.01..0.99f64);
    numbers.prop_map(move |(pixels, pitch_um, height_um, share)| {
        let period_um = pitch_um * f64::from(pixels);
        let mut lines = vec![
            format!("kind = \"{kind}\""),
            format!("period_um = {period_um}"),
            format!("pixels = {pixels}"),
        ];
        if kind != "flat" {
            lines.push(format!("height_um = {height_um}"));
        }
        match kind.as_str() {
            "lamellar" => lines.push(format!("duty = {share}")),
            "triangle" => lines.push(format!("apex = {share}")),
            _ => {}
        }
        lines
    })
}

fn rough(kind: String) -> impl Strategy<Value = Vec<String>> {
    let numbers = (24..=32u32, 0.02..0.0899f64, 5.0..12.0f64, 0.01..0.4f64, 0..1_000_000u64);
    numbers.prop_flat_map(move |(pixels, pixel_um, pitch, height_um, seed)| {
        let lines = [
            format!("kind = \"{kind}\""),
            format!("size_um = {}", pixel_um * f64::from(pixels)),
            format!("pixels = {pixels}"),
            format!("pitch_um = {}", pixel_um * pitch),
            format!("height_um = {height_um}"),
            format!("seed = {seed}"),
        ];
        let shape = vec![
            (0.0..=1.0f64).prop_map(|x| format!("regularity = {x:?}")).boxed(),
            (5.0..12.0f64).prop_map(move |x| format!("length_um = {}", pixel_um * x)).boxed(),
        ];
        // not every default of `length_um` fits into so small a patch
        some_of(shape).prop_map(move |shape| {
            let length = format!("length_um = {}", pixel_um * pitch);
            let is_given = shape.iter().any(|line| line.starts_with("length_um"));
            lines.clone().into_iter().chain(shape).chain((!is_given).then_some(length)).collect()
        })
    })
}

/// Files of floats and of integers; those with a scale of their own are too coarse for the shortest wavelength.
fn files() -> impl Strategy<Value = Vec<String>> {
    let scale = prop_oneof![
        (0.02..0.0899f64).prop_map(|x| vec![format!("pixel_um = {x:?}")]),
        (0.1..0.4f64).prop_map(|x| vec![format!("size_um = {x:?}")]),
        (0.1..0.4f64, 0.06..0.26f64)
            .prop_map(|(x, y)| vec![format!("size_um = {x:?}"), format!("size_y_um = {y:?}")]),
    ];
    let heights = prop_oneof![
        (0.01..0.2f64).prop_map(|x| ("npy/f4.npy", format!("z_unit_um = {x:?}"))),
        (0.01..0.5f64).prop_map(|x| ("npy/u2.npy", format!("height_um = {x:?}"))),
    ];
    let word = |name: &str| {
        let key = key("surface", name);
        line(&key, select(quoted(&key)).boxed())
    };
    let more = some_of(vec![
        word("flip"),
        word("trust"),
        word("void_value"),
        Just("channel = 1".to_owned()).boxed(),
        (0.03..0.0899f64).prop_map(|x| format!("resample_um = {x:?}")).boxed(),
    ]);
    (heights, scale, more).prop_map(|((file, heights), scale, more)| {
        let file = vec![format!("file = \"seeds/{file}\""), heights];
        file.into_iter().chain(scale).chain(more).collect()
    })
}

/// What a surface may say beside its source.
fn preparation() -> impl Strategy<Value = Vec<String>> {
    let keys = vec![
        (-360.0..360.0f64).prop_map(|x| format!("rotate_deg = {x:?}")).boxed(),
        select(quoted(&key("surface", "level"))).prop_map(|word| format!("level = {word}")).boxed(),
        (0.0..10.0f64).prop_map(|x| format!("clip_percent = {x:?}")).boxed(),
    ];
    some_of(keys)
}

/// Some of the keys of a table of optics.
fn some_optics(table: &str, large: Large) -> impl Strategy<Value = Vec<String>> {
    let known = keys(table);
    some_of(known.into_iter().map(|key| line(&key, value(&key, large))).collect())
}

fn optics(large: Large) -> impl Strategy<Value = Vec<String>> {
    some_optics("optics", large).prop_map(move |mut keys| {
        if large.prefiltered && !keys.iter().any(|line| line.starts_with("coherence_um")) {
            keys.push("coherence_um = 2.5".to_owned());
        }
        let heading = (!keys.is_empty()).then(|| "[optics]".to_owned());
        heading.into_iter().chain(keys).collect()
    })
}

/// `[variants]`: at most three axes of two values, the rest single.
fn product(large: Large) -> impl Strategy<Value = Vec<String>> {
    let wide = subsequence(keys("variants"), 0..=3);
    let lines = wide.prop_flat_map(move |wide| {
        let single = keys("variants").into_iter().filter(|key| !wide.contains(key));
        let single: Vec<_> = single.map(|key| line(&key, value(&key, large))).collect();
        // few of the others, so that most combinations can be built
        let few = subsequence(single, 0..=6).prop_flat_map(|lines| lines);
        let wide: Vec<_> = wide.into_iter().map(|key| axis(&key, value(&key, large))).collect();
        (few, wide)
    });
    let lines = lines.prop_map(move |(few, wide)| section("[variants]", large, few, wide));
    prop_oneof![1 => Just(Vec::new()), 3 => lines]
}

fn preset(large: Large) -> impl Strategy<Value = Vec<String>> {
    let is_axis = |key: &Key| !matches!(key.name.as_str(), "name" | "surfaces");
    let known = keys("preset").into_iter().filter(is_axis);
    let values: Vec<_> = known.map(|key| line(&key, value(&key, large))).collect();
    let few = subsequence(values, 0..=6).prop_flat_map(|lines| lines);
    let lines = (few, any::<bool>()).prop_map(move |(few, is_for_all)| {
        let only = (!is_for_all).then(|| "surfaces = [\"surface-0\"]".to_owned());
        let first = ["name = \"my-preset\"".to_owned()].into_iter().chain(only).collect();
        section("[[preset]]", large, first, few)
    });
    prop_oneof![Just(Vec::new()), lines]
}

/// A heading and its lines. Forms that are rarely put together by chance are, where they are allowed: the word that makes
/// one stands in every section that says nothing else, and the format that a filter needs.
fn section(heading: &str, large: Large, first: Vec<String>, rest: Vec<String>) -> Vec<String> {
    let mut lines: Vec<String> =
        [heading.to_owned()].into_iter().chain(first).chain(rest).collect();
    let filters = lines.iter().any(|line| line.contains("\"filter\""));
    let surrounds = lines.iter().any(|line| line.starts_with("environment_error"));
    let has = |key: &str| lines.iter().any(|line| line.starts_with(key));
    let has_cells = has("cells");
    let spreads = has("spread_step") || has_cells;
    for (is_needed, key, value) in [
        (large.prefiltered, "reconstruction", "\"prefiltered\""),
        (large.baked, "mode", "\"baked\""),
        // the default takes long
        (large.baked, "bake_mib", "0.25"),
        (filters, "table", "\"f16\""),
        // without a form of this kind nothing reads it
        (spreads, "spread_levels", "2"),
        (spreads, "coherence", "\"ensemble\""),
        (spreads, "coherence_scaling", "\"wavelength\""),
        (has_cells, "lights", "[\"environment\"]"),
        (surrounds, "mode", "\"orders\""),
        (has("period_ratio") || has("depth_ratio"), "pattern", "true"),
        (has("pattern") || has("period_ratio") || has("depth_ratio"), "mode", "\"orders\""),
        (surrounds, "nodes", "\"auto\""),
        (surrounds, "coherence_scaling", "\"wavelength\""),
    ] {
        let start = format!("{key} = ");
        if is_needed && !lines.iter().any(|line| line.starts_with(&start)) {
            lines.push(start + value);
        }
    }
    lines
}

fn targets() -> impl Strategy<Value = Vec<String>> {
    let list = |key: &Key| {
        let (name, words) = (key.name.clone(), quoted(key));
        let count = 1..=words.len();
        subsequence(words, count).prop_map(move |words| format!("{name} = [{}]", words.join(", ")))
    };
    let lists: Vec<_> = keys("targets").iter().map(|key| list(key).boxed()).collect();
    some_of(lists).prop_map(|lines| {
        let heading = (!lines.is_empty()).then(|| "[targets]".to_owned());
        heading.into_iter().chain(lines).collect()
    })
}

/// One value of a key of variants: any of its words, or any of its numbers.
fn value(key: &Key, large: Large) -> BoxedStrategy<String> {
    let left_out = |word: &String| match word.as_str() {
        "\"prefiltered\"" => !large.prefiltered,
        "\"baked\"" => !large.baked,
        _ => false,
    };
    let words: Vec<String> = quoted(key).into_iter().filter(|word| !left_out(word)).collect();
    if key.name == "material" {
        return prop_oneof![9 => select(words), 1 => file()].boxed();
    }
    match (numbers(&key.name, large), words.is_empty()) {
        (Some(numbers), true) => numbers,
        (Some(numbers), false) => prop_oneof![2 => numbers, 1 => select(words)].boxed(),
        (None, false) => select(words).boxed(),
        (None, true) => panic!("say what {}.{} may be", key.table, key.name),
    }
}

/// What a key may be beside its words.
fn numbers(name: &str, large: Large) -> Option<BoxedStrategy<String>> {
    let float = |range: std::ops::Range<f64>| range.prop_map(|x| format!("{x:?}")).boxed();
    Some(match name {
        "terms" => select(vec!["1", "2", "5", "31"]).prop_map(str::to_owned).boxed(),
        "window_radius" => (0..4u32).prop_map(|n| n.to_string()).boxed(),
        "periods" => (1..6u32, 1..6u32).prop_map(|(x, y)| format!("[{x}, {y}]")).boxed(),
        "wavelengths" => waves().boxed(),
        "term_error" => float(1e-4..0.1),
        "hoist" | "shadowing" | "accept_error" | "pattern" => {
            any::<bool>().prop_map(|x| x.to_string()).boxed()
        }
        "bake_error" => float(2.0..10.0),
        "bake_mib" => float(0.25..0.5),
        "spread_levels" => (0..4u32).prop_map(|n| n.to_string()).boxed(),
        "spread_step" => float(1.1..4.0),
        "cells" => (8..64u32).prop_map(|n| n.to_string()).boxed(),
        "nodes" => (2..17u32).prop_map(|n| n.to_string()).boxed(),
        "environment_error" => float(1.0..20.0),
        "period_ratio" | "depth_ratio" => (0.5..1.0, 1.0..2.0f64)
            .prop_map(|(least, greatest)| format!("[{least:?}, {greatest:?}]"))
            .boxed(),
        "coherence_um" => float(if large.prefiltered { 0.1..4.0 } else { 0.1..200.0 }),
        "refractive_index" => float(1.01..5.0),
        "cover_index" => prop_oneof![6 => float(1.0..1.9), 1 => file()].boxed(),
        "films" => films().boxed(),
        "illuminant" => {
            select(vec!["D65", "D50", "A", "E", "F1"]).prop_map(|name| format!("{name:?}")).boxed()
        }
        _ => return None,
    })
}

/// A table of n and k that nobody reads: variants with it are gaps.
fn file() -> Just<String> {
    Just("{ nk = \"n.csv\" }".to_owned())
}

/// No film, or up to two.
fn films() -> impl Strategy<Value = String> {
    let index = prop_oneof![
        (1.0..5.0f64).prop_map(|n| format!("{n:?}")),
        select(vec!["\"silver\"", "\"pmma\""]).prop_map(str::to_owned),
        file(),
    ];
    let film = (index, 1.0..900.0f64)
        .prop_map(|(index, nm)| format!("{{ index = {index}, thickness_nm = {nm:?} }}"));
    vec(film, 0..3).prop_map(|films| format!("[{}]", films.join(", ")))
}

/// A range of wavelengths: wide, narrow or a single one.
fn waves() -> impl Strategy<Value = String> {
    let range = (360.0..600.0f64, 10.0..230.0f64, 0.05..1.0f64);
    let range = range.prop_map(|(min, width, share)| {
        format!("{{ min_nm = {min:?}, max_nm = {:?}, step_nm = {:?} }}", min + width, width * share)
    });
    let single =
        (360..=830u32).prop_map(|nm| format!("{{ min_nm = {nm}, max_nm = {nm}, step_nm = 5 }}"));
    prop_oneof![4 => range, 1 => single]
}

/// The keys of a table of a plan.
fn keys(table: &str) -> Vec<Key> {
    // another way to write two other keys, which must not stand beside them
    let is_alias = |key: &Key| key.name == "source_diameter_deg";
    vocabulary().into_iter().filter(|key| key.table == table && !is_alias(key)).collect()
}

fn key(table: &str, name: &str) -> Key {
    let found = keys(table).into_iter().find(|key| key.name == name);
    found.unwrap_or_else(|| panic!("{table} has no {name}"))
}

fn quoted(key: &Key) -> Vec<String> {
    key.words.iter().map(|word| format!("{word:?}")).collect()
}

fn line(key: &Key, value: BoxedStrategy<String>) -> BoxedStrategy<String> {
    let name = key.name.clone();
    value.prop_map(move |value| format!("{name} = {value}")).boxed()
}

/// A line with one or two of the values in brackets.
fn axis(key: &Key, value: BoxedStrategy<String>) -> BoxedStrategy<String> {
    let name = key.name.clone();
    let line = move |mut values: Vec<String>| {
        values.dedup();
        format!("{name} = [{}]", values.join(", "))
    };
    vec(value, 1..=2).prop_map(line).boxed()
}

fn prefixed(name: &str, lines: Vec<String>) -> Vec<String> {
    lines.into_iter().map(|line| format!("{name}.{line}")).collect()
}

/// Any subset of the lines.
fn some_of(lines: Vec<BoxedStrategy<String>>) -> impl Strategy<Value = Vec<String>> {
    let choices: Vec<_> = lines.into_iter().map(proptest::option::of).collect();
    choices.prop_map(|lines| lines.into_iter().flatten().collect())
}
