//! Numbers in names.

/// A number in a file name, with `p` as decimal point.
pub(super) fn number(x: f64) -> String {
    format!("{x}").replace('.', "p")
}

/// The same in scientific notation.
pub(super) fn exponent(x: f64) -> String {
    format!("{x:e}").replace('.', "p")
}
