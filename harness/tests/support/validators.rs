//! The validators of this machine.

use super::tools;
use std::fs;

use diffraction_harness::validate::{self, Report, TIME_LIMIT, Tool, validate};

/// The validators that are installed.
pub fn installed_tools() -> Vec<Box<dyn Tool>> {
    let mut installed = Vec::new();
    // the comparison with manifests needs a package
    for tool in validate::tools(TIME_LIMIT).into_iter().filter(|tool| tool.name() != "reflection") {
        let Err(trouble) = tool.version() else {
            installed.push(tool);
            continue;
        };
        let what = format!("{}: {trouble}; {}", tool.name(), tool.remedy());
        match tool.name() {
            // nothing that is installed as a package brings it, so it cannot be required
            "tint" => println!("NOT RUN: {what}"),
            _ => tools::missing(what),
        }
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
