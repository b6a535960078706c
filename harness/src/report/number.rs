//! Numbers for people.

use crate::results::Lit;

/// Three significant digits: `0.0123`, `1230`, `2.60×10⁻⁶`.
pub(super) fn figure(value: f64) -> String {
    if !value.is_finite() {
        return "not a number".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let rounded = format!("{value:.2e}");
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    match exponent {
        -3..=4 => {
            let decimals = usize::try_from(2 - exponent).unwrap_or(0);
            format!("{value:.decimals$}")
        }
        _ => format!("{mantissa}×10{}", superscript(exponent)),
    }
}

/// A setting, with the digits that it was given with.
pub(super) fn plain(value: f64) -> String {
    format!("{value}")
}

/// A power of ten on an axis.
pub(super) fn power(exponent: i32) -> String {
    match exponent {
        -2..=4 => plain(10_f64.powi(exponent)),
        _ => format!("10{}", superscript(exponent)),
    }
}

/// A multiple of a power of ten on an axis.
pub(super) fn plain_power(multiple: f64, exponent: i32) -> String {
    match exponent {
        0..=4 => plain(multiple * 10_f64.powi(exponent)),
        -4..=-1 => format!(
            "{:.*}",
            exponent.unsigned_abs() as usize + usize::from(multiple.fract() > 0.0),
            multiple * 10_f64.powi(exponent)
        ),
        _ => format!("{}×10{}", plain(multiple), superscript(exponent)),
    }
}

/// Bytes in binary units.
pub(super) fn bytes(value: u64) -> String {
    const KIB: f64 = 1024.0;
    let value = value as f64;
    match value {
        v if v < KIB => format!("{v} B"),
        v if v < KIB * KIB => format!("{} KiB", figure(v / KIB)),
        v => format!("{} MiB", figure(v / KIB / KIB)),
    }
}

/// The light of a comparison: a direction, or the name of a file of lights.
pub(super) fn lit(lit: &Lit) -> String {
    match lit {
        Lit::Direction(angles) => light(*angles),
        Lit::Lights(name) => name.clone(),
    }
}

/// A direction of light: `θ 20°, φ 0°`.
pub(super) fn light([theta, phi]: [f64; 2]) -> String {
    format!("θ {}°, φ {}°", plain(theta), plain(phi))
}

fn superscript(exponent: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => {
            digit.to_digit(10).and_then(|digit| char::from_u32('⁰' as u32 + digit)).unwrap_or(digit)
        }
    };
    exponent.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let shown = [0.0, 0.012345, 1.0, 12.345, 9.999, 99999.0, 123456.0, 2.5992e-6, 9.996e-4];
        let shown = shown.map(figure);
        let wanted =
            ["0", "0.0123", "1.00", "12.3", "10.0", "1.00×10⁵", "1.23×10⁵", "2.60×10⁻⁶", "0.00100"];
        assert_eq!(shown, wanted);
        assert_eq!([power(-4), power(-2), power(3), power(5)], ["10⁻⁴", "0.01", "1000", "10⁵"]);
        assert_eq!([bytes(12), bytes(2048), bytes(3 << 20)], ["12 B", "2.00 KiB", "3.00 MiB"]);
    }
}
