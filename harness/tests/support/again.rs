//! Tests that need an environment which must be set before the process loads its drivers.

use std::env;
use std::ffi::OsStr;
use std::process::Command;

use diffraction_harness::drivers::icd;

/// Runs the test of that name again, in a process of its own with all Vulkan drivers of the machine; false where this process
/// has them already.
pub fn again(name: &str) -> bool {
    match icd::addition() {
        Some(drivers) => {
            with(name, icd::ADD_DRIVERS, drivers);
            true
        }
        None => false,
    }
}

/// Runs the test of that name again in a process of its own, with a variable set; fails where it fails.
pub fn with(name: &str, variable: &str, value: impl AsRef<OsStr>) {
    let mut command = Command::new(env::current_exe().unwrap());
    // else Mesa's Vulkan looks for a Wayland display and complains
    command.args([name, "--exact", "--nocapture"]).env("NODEVICE_SELECT", "1");
    let output = command.env(variable, value).output().unwrap();
    let text = [output.stdout, output.stderr].map(|t| String::from_utf8_lossy(&t).into_owned());
    println!("{}", text.concat());
    assert!(output.status.success(), "{name} with {variable}: {}", output.status);
    // a name that no test has would pass
    assert!(text[0].contains("1 passed"), "{name} is no test");
}
