//! The spectrum of light that has a colour in linear sRGB.
//!
//! At each wavelength three shares, nowhere negative, add up to 1. The shares times red, green and blue, times the illuminant,
//! are the spectrum: white, `[1, 1, 1]`, is the illuminant itself. Under D65 a mirror shows the colour as it was given, to 2e-4
//! (Mallett and Yuksel 2019, "Spectral primary decomposition for rendering with sRGB reflectance"). The table was solved anew by
//! `primaries/make.py`. Under another illuminant the colour is that of a filter in front of it.

use std::sync::LazyLock;

use glam::DVec3;

/// One row for each wavelength: nm, then the shares of red, green and blue.
const TABLE: &str = include_str!("primaries/srgb.csv");

static SHARES: LazyLock<Vec<(f64, DVec3)>> = LazyLock::new(|| {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(TABLE.as_bytes());
    let rows = reader.deserialize::<[f64; 4]>().filter_map(Result::ok);
    rows.map(|[nm, red, green, blue]| (nm, DVec3::new(red, green, blue))).collect()
});

/// Shares of red, green and blue light at a wavelength: linear between the rows of the table, constant beyond its ends.
pub fn primary_shares(lambda_nm: f64) -> DVec3 {
    let rows = SHARES.as_slice();
    let next = rows.partition_point(|(nm, _)| *nm <= lambda_nm);
    match (next.checked_sub(1).and_then(|at| rows.get(at)), rows.get(next)) {
        (Some((from, before)), Some((to, after))) => {
            before.lerp(*after, (lambda_nm - from) / (to - from))
        }
        (Some((_, end)), None) | (None, Some((_, end))) => *end,
        (None, None) => DVec3::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::colour::to_rgb;
    use crate::optics::spectrum::Spectrum;
    use crate::plan::{Colour, Optics};

    #[test]
    fn shares_add_up_to_one_and_are_never_negative() {
        for tenth in 3000..9000 {
            let shares = primary_shares(0.1 * f64::from(tenth));
            assert!((shares.element_sum() - 1.0).abs() < 1e-12 && shares.min_element() >= 0.0);
        }
    }

    #[test]
    fn a_mirror_shows_the_colour() {
        let spectrum = Spectrum::new(&Optics::standard().illuminant).unwrap();
        for rgb in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE, DVec3::new(0.2, 3.0, 0.01)] {
            let seen: DVec3 = (3800..7800)
                .map(|tenth| {
                    let nm = 0.1 * (f64::from(tenth) + 0.5);
                    0.1 * rgb.dot(primary_shares(nm)) * DVec3::from(spectrum.per_nm(nm))
                })
                .sum();
            let seen = DVec3::from(to_rgb(seen.to_array(), Colour::Srgb));
            assert!((seen - rgb).abs().max_element() < 5e-4 * rgb.max_element(), "{rgb} {seen}");
        }
    }
}
