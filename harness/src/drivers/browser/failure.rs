//! How errors of the browser begin.

use diffraction_shaders::error::{Error, Stage};

/// An error about the browser.
pub(super) fn failure(cause: impl std::fmt::Display) -> Error {
    Error::new(Stage::Run, "chromium", cause)
}
