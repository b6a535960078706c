//! Units of length as files write them: symbols, words, powers of ten.

/// The unit of a file's numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Unit {
    /// A length, with the µm in one of it.
    Length(f64),
    /// No length, as the file writes it: volts, degrees, counts, nothing.
    Other(String),
}

/// Symbols and names of one unit of length, in lower case.
type Names = &'static [&'static str];

/// µm per unit. `A` alone is missing: it may be an ampere.
const UNITS: [(f64, Names); 9] = [
    (1e6, &["m", "meter", "metre", "meters", "metres"]),
    (1e4, &["cm", "centimeter", "centimetre", "centimeters", "centimetres"]),
    (1e3, &["mm", "millimeter", "millimetre", "millimeters", "millimetres", "milli"]),
    (
        1.0,
        &[
            "µm",
            "μm",
            "um",
            "~m",
            "\\u00b5m",
            "&#181;m",
            "&#xb5;m",
            "micron",
            "microns",
            "µ",
            "μ",
            "micrometer",
            "micrometre",
            "micrometers",
            "micrometres",
            "mkm",
            "мкм",
        ],
    ),
    (1e-3, &["nm", "nanometer", "nanometre", "nanometers", "nanometres", "нм"]),
    (1e-4, &["å", "a\u{30a}", "ang", "angstrom", "angstroms", "angstroem", "ångström", "ångstrom"]),
    (1e-6, &["pm", "picometer", "picometre", "picometers", "picometres"]),
    (25_400.0, &["in", "inch", "inches", "\"", "\\\""]),
    (25.4, &["mil", "thou"]),
];

/// Reads a unit, with or without brackets, such as `nm`, `[µm]`, `(Angstrom)`, `10^-6 m`, `1e-9 m`.
pub(super) fn unit(text: &str) -> Unit {
    let bare = text.trim().trim_matches(['[', ']', '(', ')', '{', '}', '\'']).trim();
    match um(bare) {
        Some(um) => Unit::Length(um),
        None => Unit::Other(bare.chars().take(40).collect()),
    }
}

/// µm per unit of a name that is a length.
fn um(text: &str) -> Option<f64> {
    // the Å of U+212B becomes that of U+00C5
    let lower = text.to_lowercase();
    // a capital changes the meaning of these: megametres, petametres
    if ["Mm", "Pm", "M"].contains(&text) {
        return None;
    }
    named(&lower).or_else(|| {
        let (factor, rest) = power(&lower)?;
        Some(factor * named(rest.trim_start_matches(['*', '·', '×', ' ']))?)
    })
}

/// µm per unit of a name in lower case.
fn named(lower: &str) -> Option<f64> {
    UNITS.iter().find(|(_, names)| names.contains(&lower)).map(|(um, _)| *um)
}

/// A leading power of ten and what follows it: `10^-6 m`, `10-6m`, `10⁻⁶ m`, `1e-6 m`, `10**-6 m`.
fn power(text: &str) -> Option<(f64, &str)> {
    let plain = |c: char| match c {
        '⁻' | '−' => Some('-'),
        '⁰' => Some('0'),
        '¹' => Some('1'),
        '²' => Some('2'),
        '³' => Some('3'),
        '⁴'..='⁹' => char::from_u32(c as u32 - '⁴' as u32 + '4' as u32),
        '-' | '+' | '0'..='9' => Some(c),
        _ => None,
    };
    let rest = text
        .strip_prefix("10")
        .map(|rest| rest.trim_start_matches("**").trim_start_matches('^'))
        .or_else(|| text.strip_prefix("1e"))
        .or_else(|| text.strip_prefix("1.0e"))?;
    let rest = rest.trim_start_matches(['{', '(']);
    let end =
        rest.char_indices().find(|&(_, c)| plain(c).is_none()).map_or(rest.len(), |(at, _)| at);
    let exponent: i32 = rest[..end].chars().filter_map(plain).collect::<String>().parse().ok()?;
    let factor = (exponent.abs() <= 15).then(|| 10f64.powi(exponent))?;
    Some((factor, rest[end..].trim_start_matches(['}', ')']).trim_start()))
}

/// A number with what follows it, such as `4.80 µm` or `4,80 µm`.
pub(super) fn quantity(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ',' | 'e' | 'E');
    let mut end = text.find(|c: char| !is_number(c)).unwrap_or(text.len());
    // a unit may begin with an `e`, and a comma may end a phrase
    while end > 0 && !text[..end].ends_with(|c: char| c.is_ascii_digit() || c == '.') {
        end -= 1;
    }
    let digits = &text[..end];
    let number = if digits.contains('.') {
        digits.parse().ok()?
    } else {
        digits.replace(',', ".").parse().ok()?
    };
    f64::is_finite(number).then(|| (number, text[end..].trim()))
}

/// Names of units for messages: the one with this many µm.
pub(super) fn name(um: f64) -> Option<&'static str> {
    let named = [
        (1e6, "m"),
        (1e4, "cm"),
        (1e3, "mm"),
        (1.0, "µm"),
        (1e-3, "nm"),
        (1e-4, "Å"),
        (1e-6, "pm"),
    ];
    named.iter().find(|(known, _)| (known / um - 1.0).abs() < 1e-9).map(|(_, name)| *name)
}

/// A number for messages, with at most six significant digits.
pub(super) fn shown(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Whether two lengths contradict each other. Files round the sizes that they state, so one percent may lie between.
pub(super) fn differs(one: f64, other: f64) -> bool {
    (one - other).abs() > 0.01 * one.abs().max(other.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_every_spelling() {
        for (um, spellings) in [
            (1e6, vec!["m", "Metres", "[m]", "meter"]),
            (
                1.0,
                vec![
                    "µm",
                    "\u{3bc}m",
                    "um",
                    "(micron)",
                    "10^-6 m",
                    "10⁻⁶ m",
                    "1e-6 m",
                    "10-6m",
                    "\\u00B5m",
                ],
            ),
            (1e-3, vec!["nm", "Nanometers", "nanometres", "10^-9 m", "10**-9 m", "1e-9m"]),
            (1e-4, vec!["Å", "\u{212b}", "Angstrom", "ang", "A\u{30a}"]),
            (1e-6, vec!["pm", "10^{-12} m"]),
            (25_400.0, vec!["inch"]),
        ] {
            for spelling in spellings {
                let Unit::Length(found) = unit(spelling) else { panic!("{spelling}") };
                assert!((found / um - 1.0).abs() < 1e-12, "{spelling}: {found}");
            }
        }
        for other in ["V", "deg", "A", "", "Mm", "10^-6", "1e99 m", "counts", "nA"] {
            assert!(matches!(unit(other), Unit::Other(_)), "{other}");
        }
    }

    #[test]
    fn quantities_with_points_and_commas() {
        for (text, number, rest) in [
            ("4.80 µm", 4.8, "µm"),
            ("4,80 µm", 4.8, "µm"),
            ("1e-6m", 1e-6, "m"),
            (" -3 ", -3.0, ""),
            ("500 500 nm", 500.0, "500 nm"),
            ("12, x", 12.0, ", x"),
        ] {
            assert_eq!(quantity(text), Some((number, rest)), "{text}");
        }
        for text in ["", "nm", "e5", "-", "."] {
            assert_eq!(quantity(text), None, "{text}");
        }
    }
}
