//! Random plans as lines of text, one key each, so that a single line can be broken on purpose.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{select, subsequence};

/// A valid plan, line by line.
#[derive(Clone, Debug)]
pub struct Draft {
    pub lines: Vec<String>,
}

impl Draft {
    pub fn text(&self) -> String {
        self.lines.iter().flat_map(|line| [line, "\n"]).collect()
    }
}

/// Plans of one or two small synthetic surfaces, a product of at most eight variants, a preset, optics, targets.
pub fn plans() -> impl Strategy<Value = Draft> {
    let surfaces = vec((gratings(), preparation()), 1..=2);
    let parts = (surfaces, section("optics", optics_values()), product(), preset(), targets());
    parts.prop_map(|(surfaces, optics, product, preset, targets)| {
        let mut lines = vec!["schema = 1".to_owned()];
        for (i, (grating, preparation)) in surfaces.into_iter().enumerate() {
            lines.push("[[surface]]".to_owned());
            lines.push(format!("name = \"surface-{i}\""));
            lines.extend(grating.into_iter().map(|line| format!("grating.{line}")));
            lines.extend(preparation);
        }
        lines.extend(optics.into_iter().chain(product).chain(preset).chain(targets));
        Draft { lines }
    })
}

/// The keys of a grating: every one-dimensional kind, and two of them crossed.
fn gratings() -> impl Strategy<Value = Vec<String>> {
    let crossed = (profiles(), profiles()).prop_map(|(x, y)| {
        let mut lines = vec!["kind = \"crossed\"".to_owned()];
        lines.extend(x.into_iter().map(|line| format!("x.{line}")));
        lines.extend(y.into_iter().map(|line| format!("y.{line}")));
        lines
    });
    prop_oneof![3 => profiles(), 1 => crossed]
}

fn profiles() -> impl Strategy<Value = Vec<String>> {
    let kinds = select(vec!["flat", "sinusoidal", "blazed", "lamellar", "triangle"]);
    // the shortest wavelength of any plan is 360 nm, so a pitch below 90 nm carries all orders
    let numbers = (2..=60u32, 0.005..0.0899f64, 0.001..0.8f64, 0.01..0.99f64);
    (kinds, numbers).prop_map(|(kind, (pixels, pitch_um, height_um, share))| {
        let period_um = pitch_um * f64::from(pixels);
        let mut lines = vec![
            format!("kind = \"{kind}\""),
            format!("period_um = {period_um}"),
            format!("pixels = {pixels}"),
        ];
        if kind != "flat" {
            lines.push(format!("height_um = {height_um}"));
        }
        match kind {
            "lamellar" => lines.push(format!("duty = {share}")),
            "triangle" => lines.push(format!("apex = {share}")),
            _ => {}
        }
        lines
    })
}

/// What a surface may say beside its grating.
fn preparation() -> impl Strategy<Value = Vec<String>> {
    let keys = vec![
        (-360.0..360.0f64).prop_map(|x| format!("rotate_deg = {x:?}")).boxed(),
        words("level", &["none", "plane", "rows"]),
        (0.0..10.0f64).prop_map(|x| format!("clip_percent = {x:?}")).boxed(),
    ];
    some_of(keys)
}

fn optics_values() -> Vec<BoxedStrategy<String>> {
    vec![
        (0.1..200.0f64).prop_map(|x| format!("coherence_um = {x:?}")).boxed(),
        words("coherence", &["single", "ensemble"]),
        words("coherence_scaling", &["fixed", "wavelength"]),
        (1.01..5.0f64).prop_map(|x| format!("refractive_index = {x:?}")).boxed(),
        any::<bool>().prop_map(|x| format!("shadowing = {x}")).boxed(),
        words("illuminant", &["D65", "D50", "A", "E", "F1"]),
        words("colour", &["srgb", "thesis"]),
    ]
}

/// `[variants]`: at most three axes of two values, the rest single.
fn product() -> impl Strategy<Value = Vec<String>> {
    let short = axis("terms", &["1", "2", "5", "31", "\"auto\""]);
    let axes = vec![
        axis("mode", &["\"full\"", "\"pq\"", "\"adaptive\"", "\"gems\""]),
        Just("term_error = 1e-2".to_owned()).boxed(),
        words("table", &["f32", "f16"]),
        Just("reconstruction = [\"window\"]".to_owned()).boxed(),
        words("periods", &["auto"]),
        waves().prop_map(|waves| format!("wavelengths = [{{ {waves} }}]")).boxed(),
    ];
    let wide = select(vec![
        ("basis", vec!["\"taylor\"", "\"taylor-zero\""]),
        ("window_radius", vec!["0", "1", "3", "\"auto\""]),
        ("packing", vec!["\"paired\"", "\"single\""]),
        ("hoist", vec!["true", "false"]),
        ("coherence", vec!["\"single\"", "\"ensemble\""]),
        ("illuminant", vec!["\"D65\"", "\"A\""]),
        ("refractive_index", vec!["1.33", "1.56", "2"]),
    ])
    .prop_flat_map(|(key, values)| axis(key, &values));
    let lines = (some_of(axes), short, wide).prop_map(|(mut lines, short, wide)| {
        lines.insert(0, "[variants]".to_owned());
        lines.extend([short, wide]);
        lines
    });
    prop_oneof![Just(Vec::new()), lines]
}

fn preset() -> impl Strategy<Value = Vec<String>> {
    let keys = vec![
        words("mode", &["full", "pq", "adaptive", "gems"]),
        words("table", &["f32", "f16"]),
        words("basis", &["taylor", "taylor-zero"]),
        (1..60u32).prop_map(|n| format!("terms = {n}")).boxed(),
        (0..4u32).prop_map(|n| format!("window_radius = {n}")).boxed(),
        waves().prop_map(|waves| format!("wavelengths = {{ {waves} }}")).boxed(),
        words("packing", &["paired", "single"]),
        any::<bool>().prop_map(|x| format!("hoist = {x}")).boxed(),
    ];
    let with_optics = keys.into_iter().chain(optics_values()).collect();
    let lines = some_of(with_optics).prop_map(|keys| {
        ["[[preset]]".to_owned(), "name = \"my-preset\"".to_owned()]
            .into_iter()
            .chain(keys)
            .collect()
    });
    prop_oneof![Just(Vec::new()), lines]
}

fn targets() -> impl Strategy<Value = Vec<String>> {
    let words =
        vec!["\"wgsl\"", "\"glsl450\"", "\"glsl-es300\"", "\"spirv\"", "\"hlsl\"", "\"msl\""];
    subsequence(words, 1..=6).prop_map(|words| {
        let emit = format!("emit = [{}]", words.join(", "));
        vec!["[targets]".to_owned(), emit, "tables = [\"bin\"]".to_owned()]
    })
}

/// The keys of a range of wavelengths: wide, narrow or a single one.
fn waves() -> impl Strategy<Value = String> {
    let range = (360.0..600.0f64, 10.0..230.0f64, 0.05..1.0f64);
    let range = range.prop_map(|(min, width, share)| {
        format!("min_nm = {min:?}, max_nm = {:?}, step_nm = {:?}", min + width, width * share)
    });
    let single = (360..=830u32).prop_map(|nm| format!("min_nm = {nm}, max_nm = {nm}"));
    prop_oneof![4 => range, 1 => single]
}

/// A line with one or two of the values in brackets, in their order.
fn axis(key: &'static str, values: &[&'static str]) -> BoxedStrategy<String> {
    subsequence(values.to_vec(), 1..=2)
        .prop_map(move |values| format!("{key} = [{}]", values.join(", ")))
        .boxed()
}

fn words(key: &'static str, words: &[&'static str]) -> BoxedStrategy<String> {
    select(words.to_vec()).prop_map(move |word| format!("{key} = \"{word}\"")).boxed()
}

/// Any subset of the lines.
fn some_of(lines: Vec<BoxedStrategy<String>>) -> impl Strategy<Value = Vec<String>> {
    let choices: Vec<_> = lines.into_iter().map(proptest::option::of).collect();
    choices.prop_map(|lines| lines.into_iter().flatten().collect())
}

/// A section with some of its keys, or nothing.
fn section(
    name: &'static str,
    values: Vec<BoxedStrategy<String>>,
) -> impl Strategy<Value = Vec<String>> {
    some_of(values).prop_map(move |keys| {
        let heading = (!keys.is_empty()).then(|| format!("[{name}]"));
        heading.into_iter().chain(keys).collect()
    })
}
