//! The validators of this machine.

use super::tools;
use std::fs;

use diffraction_harness::validate::{self, Report, Tool, validate};

/// The external validators that are installed.
pub fn installed_tools() -> Vec<Box<dyn Tool>> {
    let mut installed = Vec::new();
    // the comparison with manifests needs a package
    for tool in validate::tools().into_iter().filter(|tool| tool.name() != "reflection") {
        if tool.version().is_some() {
            installed.push(tool);
            continue;
        }
        let remedy = match tool.package() {
            Some(package) => format!("apt-get install {package}"),
            None => "its binary has to be on the PATH".to_owned(),
        };
        let what = format!("{} is not installed; {remedy}", tool.name());
        match tool.package() {
            Some(_) => tools::missing(what),
            // no package brings those without one, so they cannot be required
            None => println!("NOT RUN: {what}"),
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
