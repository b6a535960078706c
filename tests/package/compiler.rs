//! The face of the library: one call gives a complete package, and what it is asked for besides.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use diffraction_shaders::package::{Cancel, Content, check, write};
use diffraction_shaders::{Compiler, Plan, Target};

const PLAN: &str = r#"
schema = 1
[[surface]]
name = "cd"
grating = { kind = "lamellar", period_um = 1.6, height_um = 0.02, duty = 0.5, pixels = 32 }
[variants]
mode = ["full", "gems"]
terms = 3
wavelengths = { step_nm = 50 }
[targets]
emit = ["wgsl", "hlsl"]
"#;

fn plan(text: &str) -> Plan {
    Plan::parse(text, Path::new("plan.toml")).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn one_call_gives_a_complete_package() {
    let plan = plan(PLAN);
    let package = Compiler::new(&plan).compile().unwrap();
    for path in ["README.md", "manifest.json", "shaders/cd/gems/diffraction.wgsl"] {
        assert!(package.bytes(path).is_some(), "{path}");
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    write(&package, &out).unwrap();
    assert!(!check(&package, &out).unwrap().is_stale());
}

/// One variant in one language, laid over the rest, is the same package.
#[test]
fn a_part_and_the_rest_are_the_whole() {
    let plan = plan(PLAN);
    let whole = Compiler::new(&plan).compile().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    write(&whole, &out).unwrap();
    let part = Compiler::new(&plan)
        .variants(&plan.variants[..1])
        .targets(&[Target::Wgsl])
        .rest_from(&out)
        .compile()
        .unwrap();
    let kept = part.files().values().filter(|f| matches!(f.content, Content::Kept(_))).count();
    assert!(kept > 5 && kept < part.files().len(), "{kept} of {}", part.files().len());
    assert!(part.files().keys().eq(whole.files().keys()));
    for (path, file) in whole.files() {
        assert_eq!(
            part.files()[path].content.read().unwrap(),
            file.content.read().unwrap(),
            "{path}"
        );
    }
    let alone = Compiler::new(&plan).variants(&plan.variants[..1]).compile().unwrap();
    assert!(alone.files().len() < whole.files().len());
}

#[test]
fn progress_counts_the_variants_and_cancelling_stops() {
    let plan = plan(PLAN);
    let steps = AtomicUsize::new(0);
    let count = |_: diffraction_shaders::package::compile::Step<'_>| {
        steps.fetch_add(1, Ordering::Relaxed);
    };
    Compiler::new(&plan).progress(&count).compile().unwrap();
    assert_eq!(steps.load(Ordering::Relaxed), 2);
    let cancel = Cancel::new();
    cancel.cancel();
    let error = Compiler::new(&plan).progress(&count).cancel(&cancel).compile().unwrap_err();
    assert_eq!(error.to_string(), "compilation: was cancelled");
    assert_eq!(steps.load(Ordering::Relaxed), 2, "nothing was finished");
}

/// Every error of every surface comes at once.
#[test]
fn all_errors_come_together() {
    let missing = r#"
[[surface]]
name = "one"
file = "gone-1.png"
size_um = 10
height_um = 0.1
[[surface]]
name = "two"
file = "gone-2.png"
size_um = 10
height_um = 0.1
"#;
    let plan = plan(&PLAN.replace("[variants]", &format!("{missing}[variants]")));
    let text = Compiler::new(&plan).compile().unwrap_err().to_string();
    assert!(text.contains("gone-1.png") && text.contains("gone-2.png"), "{text}");
    assert_eq!(text.lines().count(), 2, "{text}");
}
