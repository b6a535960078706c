//! Comparing colours.
