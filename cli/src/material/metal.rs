//! Metals from colours: the nearest named one, and a table of n and k.
//!
//! n and k by O. Gulbrandsen 2014, Artist Friendly Metallic Fresnel, Journal of Computer Graphics Techniques 3(4), 64-72,
//! from the reflectance r at normal incidence and the edge tint g, here `g = 1 - (1 - r)²`. With a tint of its own for
//! each r, bright metals keep a small n: for any fixed g below 1, n grows without bound as r approaches 1. The rule was
//! chosen by the six named metals. From their colours alone it gives their reflectance up to 80° with a CIEDE2000 of 2.6,
//! the mean of the six maxima, and under a cover of 1.5 with 0.8; `g = 1` gives 5.8 and 5.7.

use std::fmt::Write;

use diffraction_shaders::error::Result;
use diffraction_shaders::optics::Index;
use diffraction_shaders::optics::colour::{ciede2000, from_rgb, to_rgb};
use diffraction_shaders::optics::spectrum::Spectrum;
use diffraction_shaders::plan::{Colour, Data, METALS, Medium};

/// Wavelengths of red, green and blue, nm: the primaries of Rec. 2020, of which each acts on one channel above all. The
/// ends of the table repeat the outer two.
const CHANNELS_NM: [f64; 3] = [630.0, 532.0, 465.0];
const ENDS_NM: [f64; 2] = [380.0, 780.0];

/// Range of the reflectance of a channel. At 1 the formulas have no value.
const REFLECTANCE: [f64; 2] = [1e-3, 0.999];

/// Steps towards the colour. Each takes away at least half of the difference.
const STEPS: usize = 30;

/// A table of n and k.
pub(super) struct Table {
    /// Wavelength in nm, n, k.
    pub(super) rows: [[f64; 3]; 5],
    /// CIEDE2000 between its colour at normal incidence under D65 and the one that it was made from.
    pub(super) difference: f64,
}

/// The named metal whose colour at normal incidence under D65 is nearest to a colour (linear sRGB), with its CIEDE2000.
pub(super) fn nearest(colour: [f64; 3]) -> Result<(&'static str, f64)> {
    let light = Spectrum::new(&"D65".into())?;
    let wanted = from_rgb(colour, Colour::Srgb);
    let (mut name, mut least) = (METALS[0], f64::INFINITY);
    for &metal in METALS {
        let index = Index::new(metal, &Medium::Named(metal))?;
        let difference = ciede2000(tristimulus(&index, &light), wanted);
        if difference < least {
            (name, least) = (metal, difference);
        }
    }
    Ok((name, least))
}

/// The table of n and k whose colour at normal incidence under D65 is a colour (linear sRGB), or as near to it as the
/// table can be.
pub(super) fn table(colour: [f64; 3]) -> Result<Table> {
    let light = Spectrum::new(&"D65".into())?;
    let [least, most] = REFLECTANCE;
    let wanted = colour.map(|c| c.clamp(least, most));
    let mut reflectances = wanted;
    let mut step = || {
        let rows = rows(reflectances);
        let index = index(&rows)?;
        let xyz = tristimulus(&index, &light);
        let found = to_rgb(xyz, Colour::Srgb);
        for c in 0..3 {
            reflectances[c] = (reflectances[c] + wanted[c] - found[c]).clamp(least, most);
        }
        let difference = ciede2000(xyz, from_rgb(colour, Colour::Srgb));
        Ok(Table { rows, difference })
    };
    for _ in 1..STEPS {
        step()?;
    }
    step()
}

/// A table as a CSV file. `of`: what it is of; it must be one line.
pub(super) fn csv(rows: &[[f64; 3]], of: &str) -> String {
    let mut text = format!(
        "# n + ik of {of}, from its base colour by Gulbrandsen 2014, JCGT 3(4), with the edge tint 1 - (1 - r)^2\n"
    );
    text += "wavelength_nm,n,k\n";
    for [nm, n, k] in rows {
        let _ = writeln!(text, "{nm},{n},{k}");
    }
    text
}

fn rows([red, green, blue]: [f64; 3]) -> [[f64; 3]; 5] {
    let [at_red, at_green, at_blue] = CHANNELS_NM;
    let [first, last] = ENDS_NM;
    let row = |nm: f64, r: f64| {
        let [n, k] = complex_index(r);
        [nm, n, k].map(|number| (number * 1e4).round() * 1e-4).map(short)
    };
    [row(first, blue), row(at_blue, blue), row(at_green, green), row(at_red, red), row(last, red)]
}

/// Four digits after the point, exactly.
fn short(number: f64) -> f64 {
    format!("{number:.4}").parse().unwrap_or(number)
}

/// n and k from the reflectance at normal incidence, above 0 and below 1 (Gulbrandsen 2014).
fn complex_index(r: f64) -> [f64; 2] {
    let tint = 1.0 - (1.0 - r) * (1.0 - r);
    let root = r.sqrt();
    let n = tint * (1.0 - r) / (1.0 + r) + (1.0 - tint) * (1.0 + root) / (1.0 - root);
    let squared = ((n + 1.0) * (n + 1.0) * r - (n - 1.0) * (n - 1.0)) / (1.0 - r);
    [n, squared.max(0.0).sqrt()]
}

fn index(rows: &[[f64; 3]]) -> Result<Index> {
    let data = Data::new("colour").with_content(csv(rows, "a colour").into_bytes());
    Index::new("a colour", &Medium::File(data))
}

/// Colour of the reflectance at normal incidence, a white mirror has `Y = 1`.
fn tristimulus(index: &Index, light: &Spectrum) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for nm in 380..=780 {
        let nm = f64::from(nm);
        let index = index.at(nm);
        let square = |n: f64| n * n + index.im * index.im;
        let reflectance = square(index.re - 1.0) / square(index.re + 1.0);
        let weights = light.per_nm(nm);
        sum = [0, 1, 2].map(|c| sum[c] + weights[c] * reflectance);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_has_the_reflectance_that_it_is_made_from() {
        for i in 1..1000 {
            let r = f64::from(i) / 1000.0;
            let [n, k] = complex_index(r);
            let found = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
            assert!((found - r).abs() < 1e-12 && n > 0.0 && n < 5.0, "{r}: {n} {k} {found}");
        }
    }

    #[test]
    fn tables_have_the_colour_that_they_are_made_from() {
        for colour in [[0.9, 0.75, 0.4], [0.5, 0.5, 0.5], [0.2, 0.3, 0.4], [0.95, 0.95, 0.95]] {
            let table = table(colour).unwrap();
            assert!(table.difference < 0.05, "{colour:?}: {}", table.difference);
        }
    }

    /// How far the tables are from the metals whose colours they are made from, as the remark at the top says.
    #[test]
    fn tables_from_the_colours_of_metals_reflect_like_them() {
        use diffraction_shaders::optics::reflectances;
        let light = Spectrum::new(&"D65".into()).unwrap();
        let colour = |index: &Index, above: f64, theta_deg: f64| {
            let sin = f64::to_radians(theta_deg).sin() / above;
            let cos = (1.0 - sin * sin).sqrt();
            let mut sum = [0.0; 3];
            for nm in 380..=780 {
                let nm = f64::from(nm);
                let [s, p] = reflectances(above, cos, &[], index.at(nm), nm);
                let weights = light.per_nm(nm);
                sum = [0, 1, 2].map(|c| sum[c] + 0.5 * (s + p) * weights[c]);
            }
            sum
        };
        for (above, limit) in [(1.0, 2.8), (1.5, 0.9)] {
            let worst: Vec<f64> = METALS
                .iter()
                .map(|&name| {
                    let metal = Index::new(name, &Medium::Named(name)).unwrap();
                    let rgb = to_rgb(tristimulus(&metal, &light), Colour::Srgb);
                    let made = index(&table(rgb).unwrap().rows).unwrap();
                    let angles = [0.0, 30.0, 45.0, 60.0, 70.0, 80.0];
                    let difference = |theta| {
                        ciede2000(colour(&metal, above, theta), colour(&made, above, theta))
                    };
                    angles.map(difference).into_iter().fold(0.0, f64::max)
                })
                .collect();
            let mean = worst.iter().sum::<f64>() / 6.0;
            assert!(mean < limit, "under {above}: {worst:?}");
        }
    }

    #[test]
    fn colours_of_textbooks_name_their_metals() {
        for (name, colour) in [
            ("gold", [1.0, 0.766, 0.336]),
            ("silver", [0.972, 0.960, 0.915]),
            ("aluminium", [0.913, 0.921, 0.925]),
            ("copper", [0.955, 0.637, 0.538]),
            ("nickel", [0.660, 0.609, 0.526]),
            ("chromium", [0.550, 0.556, 0.554]),
        ] {
            let (nearest, difference) = nearest(colour).unwrap();
            assert!(nearest == name && difference < 4.5, "{name}: {nearest} {difference}");
        }
        assert!(nearest([0.1, 0.2, 0.9]).unwrap().1 > 20.0);
    }
}
