//! The commands that need drivers, browsers or other programs of the machine.

use std::process::ExitCode;

fn main() -> ExitCode {
    diffraction_harness::commands::main()
}
