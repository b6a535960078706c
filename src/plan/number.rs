//! Numbers in names.

/// A number in a file name: the decimal point is a `p`.
pub(super) fn number(x: f64) -> String {
    format!("{x}").replace('.', "p")
}

/// The same with a power of ten.
pub(super) fn exponent(x: f64) -> String {
    format!("{x:e}").replace('.', "p")
}
