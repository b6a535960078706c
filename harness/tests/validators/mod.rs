//! The validators of this machine.

use std::fs;

use diffraction_harness::validate::{Report, Tool, tools, validate};

/// The external validators that are installed. One that is not is a failure if `DIFFRACTION_REQUIRE_TOOLS=1`;
/// otherwise it is said that it did not run.
pub fn installed_tools() -> Vec<Box<dyn Tool>> {
    let required = std::env::var("DIFFRACTION_REQUIRE_TOOLS").is_ok_and(|value| value == "1");
    let mut installed = Vec::new();
    // the comparison with manifests needs a package
    for tool in tools().into_iter().filter(|tool| tool.name() != "reflection") {
        if tool.version().is_some() {
            installed.push(tool);
            continue;
        }
        let remedy = match tool.package() {
            Some(package) => format!("apt-get install {package}"),
            None => "its binary has to be on the PATH".to_owned(),
        };
        // no package brings those without one, so that they cannot be required
        assert!(!required || tool.package().is_none(), "{}: missing; {remedy}", tool.name());
        eprintln!("NOT RUN: {} is not installed; {remedy}", tool.name());
    }
    installed
}

/// What the installed tools say about files of that name and content.
pub fn validate_files<'a>(files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Report {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    validate(folder.path(), &installed_tools(), &[]).unwrap()
}
