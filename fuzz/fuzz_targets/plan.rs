//! Any text is a plan or a list of errors, each with a place and a cause.
#![no_main]

use std::path::Path;

use diffraction_shaders::plan::Plan;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match Plan::parse_all(text, Path::new("fuzz/plan.toml")) {
        Ok(plan) => {
            assert!(!plan.surfaces.is_empty() && !plan.variants.is_empty());
            for (i, variant) in plan.variants.iter().enumerate() {
                assert!(plan.variants[..i].iter().all(|other| other.name != variant.name));
            }
        }
        Err(errors) => {
            assert!(!errors.is_empty());
            for error in errors {
                assert!(error.subject().starts_with("fuzz/plan.toml"), "{error}");
                assert!(!error.message().is_empty());
            }
        }
    }
});
