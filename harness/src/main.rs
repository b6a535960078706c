//! The program `diffraction-harness`: commands that need drivers, browsers or other programs.

use std::process::ExitCode;

fn main() -> ExitCode {
    diffraction_harness::commands::main()
}
