//! Compares the keys that modes declare to read with the keys that their shaders and tables depend on.
#![allow(clippy::unwrap_used, reason = "a test that unwraps fails with the error")]

use std::collections::BTreeSet;

use toml::de::DeTable;

use crate::plan::axis::{Axis, Entry};
use crate::plan::constraints::{broken, normalise};
use crate::plan::item::{Source, Table};
use crate::plan::names::name_of;
use crate::plan::reads::{declares, reads};
use crate::plan::variant::axes;
use crate::plan::variants::read_each;
use crate::plan::{Grating, Mode, Optics, Target, Variant};
use crate::shader::emit::emit;
use crate::shader::specialise;
use crate::shader::template::Sources;
use crate::surface::{HeightField, synthetic};
use crate::tables::TableSpec;
use crate::variant::{Form, Ground};

/// One variant of every form, small enough to be computed many times.
const FORMS: [&str; 26] = [
    "terms = 5\ncoherence_um = 9",
    "terms = \"auto\"\nwindow_radius = \"auto\"\ncoherence_um = 9",
    "terms = 5\nwavelengths = { min_nm = 550, max_nm = 550 }",
    "terms = 5\nreconstruction = \"prefiltered\"\ntable = \"f16\"\ncoherence_um = 9",
    "mode = \"pq\"\nterms = 5",
    "mode = \"pq\"\nterms = 5\nperiods = [3, 2]",
    "mode = \"pq\"\nterms = \"auto\"",
    "mode = \"adaptive\"\nterms = \"auto\"",
    "mode = \"adaptive\"\nterms = 5",
    "mode = \"adaptive\"\nterms = 5\nreconstruction = \"prefiltered\"\ntable = \"f16\"\ncoherence_um = 9",
    "mode = \"baked\"\ntable = \"f16\"\nbake_mib = 4\ncoherence_um = 9",
    "mode = \"baked\"\nbake_mib = 2\ncoherence_um = 9\ncoherence = \"ensemble\"\ncoherence_scaling = \"wavelength\"\nspread_levels = 3",
    "mode = \"baked\"\nbake_mib = 2\ncoherence = \"ensemble\"\nsource_diameter_deg = 3\nspread_levels = \"auto\"\nspread_step = 1.5",
    "mode = \"gems\"",
    "mode = \"orders\"\nlights = \"direction\"\ncoherence = \"ensemble\"",
    "mode = \"orders\"\ncoherence = \"ensemble\"\ncoherence_scaling = \"wavelength\"",
    "mode = \"orders\"\ncoherence = \"ensemble\"\ncoherence_scaling = \"wavelength\"\nnodes = \"auto\"",
    "mode = \"orders\"\ncoherence = \"ensemble\"\ncoherence_scaling = \"wavelength\"\npattern = true\ndepth_ratio = [0.5, 1.5]",
    // metals, covers and films
    "terms = 11\ncoherence_um = 9\nmaterial = \"copper\"\ncover_index = 1.4",
    "mode = \"pq\"\nterms = \"auto\"\nbasis = \"optimal\"\ncover_index = \"polycarbonate\"",
    "mode = \"adaptive\"\nterms = 9\nreconstruction = \"prefiltered\"\ncoherence_um = 9\nfilms = [{ index = 1.4, thickness_nm = 90 }]",
    "mode = \"baked\"\nbake_mib = 4\ncoherence_um = 9\nmaterial = \"nickel\"\nobliquity = \"te\"",
    "mode = \"orders\"\ncoherence = \"ensemble\"\ncoherence_scaling = \"wavelength\"\nmaterial = \"gold\"\nobliquity = \"unpolarised\"",
    // above the limit of errors
    "terms = 2\naccept_error = true\ncoherence_um = 9",
    "mode = \"pq\"\nterms = 2\naccept_error = true",
    "mode = \"adaptive\"\nterms = 2\naccept_error = true",
];

/// Values of keys other than words. Each differs from the values in all forms above.
fn others(key: &str) -> &'static [&'static str] {
    match key {
        "terms" => &["7"],
        "term_error" => &["0.3"],
        "window_radius" => &["2"],
        "periods" => &["[4, 5]"],
        "wavelengths" => &[
            "{ min_nm = 400 }",
            "{ max_nm = 700 }",
            "{ step_nm = 7 }",
            "{ min_nm = 560, max_nm = 560 }",
            "{ min_nm = 550, max_nm = 550, step_nm = 7 }",
        ],
        "bake_error" => &["2"],
        "bake_mib" => &["0.3"],
        "spread_levels" => &["0", "2"],
        "spread_step" => &["1.7"],
        "cells" => &["32"],
        "lights" => &["[\"direction\", \"disc\"]"],
        "nodes" => &["11"],
        "environment_error" => &["0.7"],
        "pattern" => &["true"],
        "period_ratio" => &["[0.7, 1.3]"],
        "depth_ratio" => &["[0.7, 1.3]"],
        "coherence_um" => &["4"],
        "source_diameter_deg" => &["5"],
        "refractive_index" => &["1.7"],
        "cover_index" => &["1.6"],
        "films" => &["[{ index = \"silver\", thickness_nm = 20 }]"],
        "illuminant" => &["\"A\""],
        "hoist" | "shadowing" | "accept_error" => &["true", "false"],
        _ => &[],
    }
}

fn read(text: &str) -> Variant {
    let source = Source::new(text, "test");
    let (document, faults) = DeTable::parse_recoverable(text);
    assert!(faults.is_empty(), "{text}: {faults:?}");
    let mut variant = Variant::standard(&Optics::standard());
    read_each(&Table::root(&source, document.get_ref()), axes(), &mut variant);
    let errors = source.into_errors();
    assert!(errors.is_empty(), "{text}: {errors:?}");
    variant
}

/// All content of a package that a variant's numbers determine, line by line: the compiled text, the names of the
/// tables, which are hashes of inputs, and further values of the manifest.
fn fingerprint(variant: &Variant, height: &HeightField) -> Option<Vec<String>> {
    let form = Form::new(variant, height).ok()?;
    let nodes = specialise::node_count(&specialise::shapes(&form, 0.0));
    let defines = specialise::defines(variant, &form, 0.0, nodes);
    let module = specialise::shader(&Sources::builtin(), "test", &form, &defines).unwrap();
    // functions that are not called are only in the commented text
    let files = emit(&module, Target::GlslEs300).unwrap();
    let compiled = files.iter().filter(|file| file.name.ends_with(".frag"));
    let text = compiled.flat_map(|file| {
        let text = str::from_utf8(&file.bytes).unwrap();
        text.lines().filter(|line| is_used(line, text)).map(str::to_owned)
    });
    let tables = form.tables(Ground { surface: "s", rotate_deg: 0.0 });
    let ids = tables.iter().map(TableSpec::id);
    let (scale, space) =
        (form.diffuser_scale(&variant.optics), form.colour_space(variant.optics.colour));
    let bounds = (form.promise(), form.error_bound(), form.lobe_bounds());
    let more = [format!("{scale:?}"), space.to_owned(), format!("{bounds:?}")];
    Some(text.chain(ids).chain(more).collect())
}

/// Whether the text uses the constant that a line declares.
fn is_used(line: &str, text: &str) -> bool {
    let constant = line.strip_prefix("const ").and_then(|rest| rest.split(' ').nth(1));
    constant.is_none_or(|name| text.matches(name).count() > 1)
}

/// The first line that differs.
fn difference(a: &[String], b: &[String]) -> Option<String> {
    let differs = a.iter().zip(b).find(|(a, b)| a != b);
    differs.map(|(a, b)| format!("{a} | {b}")).or((a.len() != b.len()).then(|| "length".to_owned()))
}

fn height() -> HeightField {
    let grating = Grating::Blazed { period_um: 2.5, height_um: 0.1, pixels: 32 };
    synthetic::synthesise(&grating, "test").unwrap().field
}

/// Variants that differ from one in a single entry.
fn changed<'a>(variant: &'a Variant, axis: &'a Axis) -> impl Iterator<Item = (&'a Entry, Variant)> {
    let words = (axis.words)().into_iter().map(|word| format!("\"{word}\""));
    let values = words.chain(others(axis.key).iter().map(ToString::to_string));
    let values: Vec<Variant> =
        values.map(|value| read(&format!("{} = {value}", axis.key))).collect();
    assert!(!values.is_empty(), "say what {} may be", axis.key);
    axis.entries.iter().flat_map(move |entry| {
        let values: Vec<_> = values
            .iter()
            .map(|value| {
                let mut variant = variant.clone();
                (entry.copy)(value, &mut variant);
                variant
            })
            .filter(|v| (entry.value)(v) != (entry.value)(variant))
            .collect();
        values.into_iter().map(move |v| (entry, v))
    })
}

#[test]
fn modes_read_what_they_declare_and_nothing_else() {
    let height = height();
    // declared entries whose change had an effect
    let mut seen = BTreeSet::new();
    for text in FORMS {
        let mut variant = read(text);
        normalise(&mut variant);
        assert_eq!(broken(&variant), [], "{text}");
        let own = (name_of(&variant), variant.hash(), fingerprint(&variant, &height).unwrap());
        for axis in axes().filter(|axis| axis.key != "mode") {
            for (entry, other) in changed(&variant, axis) {
                let place = format!("{text}: {}", entry.key);
                let mut normal = other.clone();
                normalise(&mut normal);
                if reads(&variant, entry.key) || reads(&other, entry.key) {
                    if broken(&normal).is_empty() {
                        assert_ne!(normal.hash(), own.1, "{place}");
                        assert_ne!(name_of(&normal), own.0, "{place}");
                        if fingerprint(&normal, &height).is_none_or(|print| print != own.2) {
                            seen.insert((variant.mode, entry.key));
                        }
                    }
                    continue;
                }
                assert_eq!(other.hash(), own.1, "{place}: the hash");
                // a rejected value is kept as written, and nothing is built from it
                if !broken(&normal).is_empty() {
                    continue;
                }
                assert_eq!((name_of(&normal), &normal), (own.0.clone(), &variant), "{place}");
                // a mode that does not read the entry must not depend on its value
                let laid = if declares(variant.mode, entry.key) { &normal } else { &other };
                let print = fingerprint(laid, &height).unwrap();
                assert_eq!(difference(&print, &own.2), None, "{place}");
            }
        }
    }
    let entries = || axes().flat_map(|axis| axis.entries).filter(|entry| entry.key != "mode");
    let declared = Mode::all().flat_map(|mode| {
        entries().filter(move |e| declares(mode, e.key)).map(move |entry| (mode, entry.key))
    });
    let idle: Vec<_> = declared.filter(|one| !seen.contains(one)).collect();
    assert!(idle.is_empty(), "declared, and without an effect: {idle:?}");
}
