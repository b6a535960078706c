//! Tools that a test needs: drivers, a browser, validators, node.
//!
//! One rule: with `DIFFRACTION_REQUIRE_TOOLS=1`, which `cargo xtask test` sets, a missing tool fails the test. Without it the
//! test prints `NOT RUN` with the reason and passes, so that `cargo test` works on a bare machine.

use std::fmt::Display;
use std::io::Write;

/// Whether every tool has to be there.
pub fn are_required() -> bool {
    std::env::var_os("DIFFRACTION_REQUIRE_TOOLS").is_some_and(|value| value == "1")
}

/// Says that a tool is missing; fails if tools are required.
#[track_caller]
pub fn missing(what: impl Display) {
    assert!(!are_required(), "{what}");
    // not by a macro: the test runner would hide the line of a test that passes
    let _ = writeln!(std::io::stderr(), "NOT RUN: {what}");
}

/// The tool, or `None` after [`missing`].
#[track_caller]
pub fn found<T>(tool: Result<T, impl Display>) -> Option<T> {
    tool.map_err(missing).ok()
}
