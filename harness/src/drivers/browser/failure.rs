//! Errors about the browser.

use diffraction_shaders::error::Error;

/// An error about the browser.
pub(super) fn failure(cause: impl std::fmt::Display) -> Error {
    Error::new("chromium", cause)
}
