//! Numbers in tables of text.

/// Four digits that count.
pub(super) fn digits(value: f64) -> String {
    let places = (3.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{value:.places$}")
}
