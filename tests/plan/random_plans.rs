//! Random plans: the valid ones compile, always to the same bytes; one fault makes an error with a place, never a panic.

use crate::support::words;

use std::collections::BTreeSet;
use std::path::Path;

use crate::support::random::{Draft, plans};
use diffraction_shaders::Compiler;
use diffraction_shaders::diagnostic::Diagnostic;
use diffraction_shaders::package::Package;
use diffraction_shaders::plan::Plan;
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngSeed, TestRunner};

/// The same cases on every machine, and none kept in a file.
fn config(cases: u32) -> Config {
    Config {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(0x5eed),
        max_shrink_iters: 200,
        ..Config::default()
    }
}

/// Beside the seeds, which are the files of random plans.
const FILE: &str = "fuzz/plan.toml";

/// Plans that are read but for one fault must not all be the same few: every key and every word is in one that is accepted,
/// and every value that a variant can be distinguished by is in one that is built.
#[test]
fn random_plans_use_every_key_and_word() {
    let mut runner = TestRunner::new(config(1));
    let (mut drawn, mut built) = (BTreeSet::new(), BTreeSet::new());
    let (mut accepted, all) = (0, 2000);
    for _ in 0..all {
        let text = plans().new_tree(&mut runner).unwrap().current().text();
        let Ok(plan) = Plan::parse_all(&text, Path::new(FILE)) else { continue };
        accepted += 1;
        drawn.extend(words::used(&text));
        for variant in &plan.variants {
            let canonical: serde_json::Value = serde_json::from_str(&variant.canonical()).unwrap();
            for (key, value) in canonical.as_object().unwrap() {
                built.insert((key.clone(), value.as_str().map(str::to_owned)));
            }
        }
    }
    let known = words::all();
    // another way to write two other keys, with a test of its own
    let is_alias = |(_, key, _): &&(String, String, Option<String>)| key == "source_diameter_deg";
    let missing: Vec<_> = known.difference(&drawn).filter(|word| !is_alias(word)).collect();
    assert!(missing.is_empty(), "random plans never have {missing:?}");
    let unknown: Vec<_> = drawn.difference(&known).collect();
    assert!(unknown.is_empty(), "the vocabulary lacks {unknown:?}, which the reader accepts");
    for (_, key, word) in known.iter().filter(|word| word.0 == "variants" && !is_alias(word)) {
        // a range is three keys there; lights are an array; what reads bins is distinguished by what does not
        let is_told = !matches!(
            (key.as_str(), word.as_deref()),
            ("wavelengths", _) | ("lights", Some(_)) | (_, Some("window"))
        );
        let is_built = built.iter().any(|(k, w)| k == key && (word.is_none() || w == word));
        assert!(is_built || !is_told, "no variant of a random plan has {key} {word:?}");
    }
    assert!(2 * accepted > all, "only {accepted} of {all} plans are accepted");
}

proptest! {
    #![proptest_config(config(60))]

    /// Generating validates every module, so `Ok` says that naga accepts them all.
    #[test]
    fn a_valid_plan_compiles_to_the_same_bytes_again(draft in plans()) {
        let plan = match Plan::parse_all(&draft.text(), Path::new(FILE)) {
            Ok(plan) => plan,
            Err(errors) => return only(&CONSTRAINTS, errors),
        };
        prop_assert!(!plan.variants.is_empty());
        let package = match package(&plan) {
            Ok(made) => made,
            Err(errors) => return only(&["nothing is left to generate"], errors),
        };
        for surface in &plan.surfaces {
            for variant in &plan.variants {
                let manifest = format!("shaders/{}/{}/manifest.json", surface.name, variant.name);
                let is_gap = package.gaps().iter().any(|g| (&g.surface, &g.variant) == (&surface.name, &variant.name));
                prop_assert!(is_gap || !variant.is_for(&surface.name) || package.bytes(&manifest).is_some(), "{manifest} is missing");
            }
        }
        prop_assert!(self::package(&plan).is_ok_and(|again| again == package));
    }
}

/// What a random plan may be refused for: combinations of words that each are valid.
const CONSTRAINTS: [&str; 12] = [
    "lights with a size have no meaning",
    "the share of each polarisation",
    "hoist = false",
    "pq repeats",
    "pq has no coherence window",
    "gems maps",
    "every combination of [variants] is rejected",
    "a prefiltered table",
    "cannot filter tables of 32-bit floats",
    "cannot store negative numbers",
    "baked integrates",
    "no visible light",
];

/// Fails unless every error is one of those that are expected.
fn only<E: std::fmt::Debug>(expected: &[&str], errors: Vec<E>) -> Result<(), TestCaseError> {
    for error in errors {
        let reported = format!("{error:?}");
        prop_assert!(expected.iter().any(|part| reported.contains(part)), "{reported}");
    }
    Ok(())
}

fn package(plan: &Plan) -> Result<Package, Vec<Diagnostic>> {
    Compiler::new(plan).compile().map_err(|errors| errors.0)
}

proptest! {
    #![proptest_config(config(3000))]

    #[test]
    fn a_plan_with_one_fault_is_refused_at_its_place(
        draft in plans(), fault in any::<Index>(), at in any::<Index>(), pick in any::<Index>()
    ) {
        let fault = FAULTS[fault.index(FAULTS.len())];
        let Some((text, place)) = fault.apply(&draft, at, pick) else { return Ok(()) };
        let Err(errors) = Plan::parse_all(&text, Path::new(FILE)) else {
            return Err(TestCaseError::fail(format!("{fault:?} is accepted:\n{text}")));
        };
        let reported: Vec<String> = errors.iter().map(|error| error.to_string()).collect();
        prop_assert!(!reported.is_empty());
        for error in &errors {
            prop_assert!(error.subject().starts_with(FILE), "{error}");
            prop_assert!(error.message().len() > error.subject().len() + 5, "{error}");
            prop_assert!(!error.to_string().contains('\n'), "{error}");
        }
        let place = match place {
            Some(line) => format!("{FILE}:{}: ", line + 1),
            None => format!("{FILE}:"),
        };
        prop_assert!(reported.iter().any(|t| t.starts_with(&place)), "{fault:?} at {place}{reported:?}\n{text}");
    }

    /// Whatever a cut, a doubled or a foreign piece makes of a plan: a plan or errors, never a panic.
    #[test]
    fn a_mangled_plan_never_panics(
        draft in plans(), from in any::<Index>(), to in any::<Index>(), piece in pieces(), twice in any::<bool>()
    ) {
        let text = draft.text();
        let (from, to) = (from.index(text.len()), to.index(text.len()));
        let (from, to) = (from.min(to), from.max(to));
        let middle = if twice { text[from..to].repeat(2) } else { piece };
        let mangled = format!("{}{middle}{}", &text[..from], &text[to..]);
        if let Err(errors) = Plan::parse_all(&mangled, Path::new(FILE)) {
            prop_assert!(!errors.is_empty());
        }
    }
}

/// Foreign text, short or long, of any alphabet.
fn pieces() -> impl Strategy<Value = String> {
    let long = "\\PC{1,3}".prop_map(|piece| piece.repeat(30));
    prop_oneof!["\\PC{0,12}", long]
}

/// One thing that is wrong.
#[derive(Clone, Copy, Debug)]
enum Fault {
    OutOfRange,
    WrongType,
    UnknownWord,
    UnknownKey,
    MisspeltKey,
    DuplicateKey,
    DuplicateName,
    MissingKey,
    Truncated,
    SwappedBrackets,
}

const FAULTS: [Fault; 10] = [
    Fault::OutOfRange,
    Fault::WrongType,
    Fault::UnknownWord,
    Fault::UnknownKey,
    Fault::MisspeltKey,
    Fault::DuplicateKey,
    Fault::DuplicateName,
    Fault::MissingKey,
    Fault::Truncated,
    Fault::SwappedBrackets,
];

/// Numbers that a key refuses, by the last part of its name.
const BAD_NUMBERS: [(&str, &[&str]); 36] = [
    ("schema", &["0", "2", "-1", "1.0"]),
    ("period_um", &["0", "-1.0", "nan", "inf"]),
    ("height_um", &["0.0", "-0.1", "-inf", "nan"]),
    ("pixels", &["0", "1", "-5", "16385", "9223372036854775807", "2.5"]),
    ("duty", &["0", "1", "1.5", "-0.5", "nan"]),
    ("apex", &["0.0", "1.0", "2", "-nan"]),
    ("clip_percent", &["-1", "50", "nan"]),
    ("coherence_um", &["0", "0.09", "10001", "inf"]),
    ("refractive_index", &["1", "0.5", "5.01", "[]"]),
    ("cover_index", &["0.99", "0", "-1.5", "4.1", "nan", "{ nk = 1 }", "{}", "[]"]),
    ("films", &["1", "[1]", "[{ index = 1.4 }]", "[{ index = 0.9, thickness_nm = 9 }]"]),
    ("thickness_nm", &["0", "-1", "10001", "nan", "inf"]),
    ("terms", &["0", "201", "[0]", "[1, 2, -3]", "1.5", "[]"]),
    ("window_radius", &["-1", "65", "[0, 65]", "1e2"]),
    ("term_error", &["0", "0.6", "-1e-3", "nan"]),
    ("periods", &["0", "[0, 1]", "[1, 10001]", "[1, 2, 3]", "[]"]),
    ("bake_error", &["0", "0.04", "11", "nan"]),
    ("bake_mib", &["0.1", "513", "-inf"]),
    ("spread_levels", &["-1", "17", "1.5", "[0, 17]"]),
    ("spread_step", &["1", "4.1", "nan"]),
    ("cells", &["7", "1025", "2.5", "[]"]),
    ("lights", &["0", "[1, 2]", "[]"]),
    ("nodes", &["1", "65", "2.5", "[0]"]),
    ("environment_error", &["0.4", "21", "nan"]),
    ("pattern", &["1", "\"yes\"", "[]"]),
    (
        "period_ratio",
        &["1", "[]", "[1]", "[1, 2, 3]", "[0.05, 1]", "[2, 1]", "[1, nan]", "[1, 11]"],
    ),
    ("depth_ratio", &["0.5", "[0, 1]", "[-1, 1]", "[1, inf]", "[\"a\", 1]"]),
    ("rotate_deg", &["nan", "inf", "-inf"]),
    ("size_um", &["0", "-1.0", "nan"]),
    ("pixel_um", &["0.0", "inf"]),
    // with it, a coarse pixel_um is accepted
    ("resample_um", &["0", "-0.1", "0.3", "nan"]),
    ("size_y_um", &["0", "-1.0", "inf"]),
    ("z_unit_um", &["0", "-1e-3", "nan"]),
    ("pitch_um", &["0", "-0.5", "inf"]),
    ("length_um", &["0.0", "-0.5", "nan"]),
    ("regularity", &["-0.1", "1.01", "nan"]),
];

/// Keys that a section cannot do without.
const REQUIRED: [&str; 10] =
    ["schema", "name", "kind", "period_um", "pixels", "duty", "apex", "file", "pitch_um", "seed"];

impl Fault {
    /// The broken text, and the line that an error must name where that is known; `None` if the plan has no place for
    /// such a fault.
    fn apply(self, draft: &Draft, at: Index, pick: Index) -> Option<(String, Option<usize>)> {
        let mut lines = draft.lines.clone();
        let pairs: Vec<usize> = (0..lines.len()).filter(|&i| key(&lines[i]).is_some()).collect();
        let keyed = |wanted: &dyn Fn(&str) -> bool| -> Option<usize> {
            let found: Vec<usize> =
                pairs.iter().copied().filter(|&i| key(&lines[i]).is_some_and(wanted)).collect();
            (!found.is_empty()).then(|| found[at.index(found.len())])
        };
        let place = match self {
            Fault::OutOfRange => {
                let i = keyed(&|key| BAD_NUMBERS.iter().any(|(known, _)| *known == key))?;
                let (_, bad) =
                    BAD_NUMBERS.iter().find(|(known, _)| Some(*known) == key(&lines[i]))?;
                set(&mut lines[i], bad[pick.index(bad.len())]);
                Some(i)
            }
            Fault::WrongType => {
                let i = keyed(&|_| true)?;
                set(&mut lines[i], ["1979-05-27", "07:32:00"][pick.index(2)]);
                Some(i)
            }
            Fault::UnknownWord => {
                let i = pairs.iter().copied().filter(|&i| {
                    // an illuminant or a file may have any name
                    let is_file = lines[i].contains("nk = ");
                    let is_free = matches!(key(&lines[i]), Some("illuminant" | "file"));
                    lines[i].contains('"') && !is_free && !is_file
                });
                let found: Vec<usize> = i.collect();
                let i = found[at.index(found.len())];
                lines[i] = lines[i].replacen('"', "\"No ", 1);
                Some(i)
            }
            Fault::UnknownKey => {
                let i = keyed(&|_| true)?;
                lines.insert(
                    i + 1,
                    format!("qq = {}", ["1", "\"a\"", "[1, 2]", "{}"][pick.index(4)]),
                );
                Some(i + 1)
            }
            Fault::MisspeltKey => {
                let i = keyed(&|_| true)?;
                lines[i] = lines[i].replacen(" =", "z =", 1);
                // of a grating whose kind is unknown nothing else is
                (key(&lines[i]) != Some("kindz")).then_some(i)
            }
            Fault::DuplicateKey => {
                let i = keyed(&|_| true)?;
                lines.insert(i, lines[i].clone());
                Some(i + 1)
            }
            Fault::DuplicateName => {
                let end = (2..lines.len()).find(|&i| lines[i].starts_with('['))?;
                let surface: Vec<String> = lines[1..end].to_vec();
                lines.splice(end..end, surface);
                Some(end + 1)
            }
            Fault::MissingKey => {
                let i = keyed(&|key| REQUIRED.contains(&key))?;
                lines.remove(i);
                None
            }
            Fault::Truncated => {
                let i = keyed(&|_| true)?;
                lines.truncate(i + 1);
                let end = lines[i].find('=')? + 1;
                lines[i].truncate(end);
                None
            }
            Fault::SwappedBrackets => {
                let i: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].contains('[')).collect();
                let i = i[at.index(i.len())];
                lines[i] = lines[i]
                    .chars()
                    .map(|c| match c {
                        '[' => ']',
                        ']' => '[',
                        c => c,
                    })
                    .collect();
                None
            }
        };
        Some((Draft { lines }.text(), place))
    }
}

/// The last part of a line's key.
fn key(line: &str) -> Option<&str> {
    let (key, _) = line.split_once(" = ")?;
    key.rsplit('.').next()
}

/// Replaces the value of a line.
fn set(line: &mut String, value: &str) {
    if let Some((key, _)) = line.split_once(" = ") {
        *line = format!("{key} = {value}");
    }
}
