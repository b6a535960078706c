//! Plans that are large or deep on purpose: an answer within seconds, whatever the text.

use std::path::Path;
use std::time::{Duration, Instant};

use diffraction_shaders::error::Error;
use diffraction_shaders::plan::Plan;

const HEAD: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "flat", period_um = 1, pixels = 20 }
"#;

/// Far above what each of these takes, far below what a quadratic reader would need.
const LIMIT: Duration = Duration::from_secs(15);

/// As many pieces as a plan may have bytes.
fn filled(piece: impl Fn(usize) -> String) -> String {
    let mut text = HEAD.to_owned();
    let mut i = 0;
    while text.len() + 200 < diffraction_shaders::input::MAX_PLAN_BYTES as usize {
        text += &piece(i);
        i += 1;
    }
    text
}

#[track_caller]
fn parsed(text: &str) -> Result<Plan, Vec<Error>> {
    let start = Instant::now();
    let plan = Plan::parse_all(text, Path::new("plan.toml"));
    assert!(start.elapsed() < LIMIT, "took {:?}", start.elapsed());
    if let Err(errors) = &plan {
        assert!((1..=101).contains(&errors.len()), "{} errors", errors.len());
        assert!(errors.iter().all(|error| error.to_string().len() < 2000));
    }
    plan
}

#[track_caller]
fn refused(text: &str, part: &str) {
    let Err(errors) = parsed(text) else { panic!("accepted") };
    let message: Vec<String> = errors.iter().map(Error::to_string).collect();
    assert!(
        message.iter().any(|text| text.contains(part)),
        "{part} is not in {:.2000}",
        message.join("; ")
    );
}

#[test]
fn errors_without_number_are_counted() {
    refused(&("schema = 1\n".to_owned() + &filled(|i| format!("key-{i} = 1\n"))), "plan.toml:");
    refused(&filled(|i| format!("key-{i} = 1\n")), "more errors");
    refused(&filled(|_| "%".to_owned()), "not valid TOML");
    refused(&filled(|_| "[\n".to_owned()), "not valid TOML");
    refused(&filled(|_| "\u{1}\n".to_owned()), "more errors");
}

#[test]
fn long_words() {
    refused(&format!("{HEAD}{} = 1\n", "k".repeat(4_000_000)), "unknown key");
    refused(&format!("{HEAD}level = \"{}\"\n", "w".repeat(4_000_000)), "unknown value");
    refused(&format!("{HEAD}rotate_deg = {}\n", "9".repeat(4_000_000)), "rotate_deg");
}

#[test]
fn deep_nesting() {
    for open in ["[", "{ a = ", "a."] {
        refused(&format!("{HEAD}level = {}", open.repeat(500_000)), "not valid TOML");
    }
    refused(&format!("{HEAD}{}b = 1\n", "a.".repeat(1_000_000)), "not valid TOML");
    refused(&format!("{HEAD}[{}b]\n", "a.".repeat(1_000_000)), "not valid TOML");
}

#[test]
fn many_of_everything() {
    let presets = filled(|i| format!("[[preset]]\nname = \"p{i}\"\n"));
    assert!(parsed(&presets).is_ok_and(|plan| plan.variants.len() > 100_000));
    let surfaces = filled(|i| {
        format!(
            r#"[[surface]]
name = "s{i}"
grating = {{ kind = "flat", period_um = 1, pixels = 20 }}
"#
        )
    });
    assert!(parsed(&surfaces).is_ok_and(|plan| plan.surfaces.len() > 40_000));
    let values: String = (0..300_000).map(|i| format!("{}, ", 1.0 + f64::from(i) * 1e-3)).collect();
    refused(&format!("{HEAD}[variants]\ncoherence_um = [{values}]\n"), "more than 4096 values");
}
