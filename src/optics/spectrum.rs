//! Illuminant times observer: the colour weight of each wavelength.
//!
//! The tables come from the crate `colorimetry`: CIE 1931 2° observer and the CIE illuminants at 1 nm, 380–780 nm.
//! Wavelengths outside that range are accepted with weight 0 (they would add less than 1e-4 of Y).

mod warp;

use colorimetry::illuminant::CieIlluminant;
use colorimetry::observer::Observer;
use colorimetry::traits::Light;
use glam::DVec3;

use crate::error::{Error, Result};
use crate::plan::{Illuminant, Wavelengths};

use super::primaries::primary_shares;

/// Number of nodes of [`Spectrum::wavenumber_samples`]. Over 380–780 nm they are 0.4 nm apart at the blue end and 1.6
/// nm at the red end; the tables of illuminants have nodes every 5 nm, the observer's every nm.
pub const WAVENUMBER_NODES: usize = 512;

/// First wavelength of the colour tables, nm.
pub const TABLE_MIN_NM: f64 = Wavelengths::VISIBLE_NM[0];
/// Last wavelength of the colour tables, nm.
pub const TABLE_MAX_NM: f64 = Wavelengths::VISIBLE_NM[1];

/// Colour weights of one wavelength: `S(λ)·(x̄, ȳ, z̄)(λ) / ∫ S ȳ dλ`, per nm.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    per_nm: Vec<[f64; 3]>,
}

/// One node of a wavelength integral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Wavelength, nm.
    pub lambda_nm: f64,
    /// X, Y, Z that a response of 1 at this node contributes (quadrature weight included).
    pub xyz: [f64; 3],
}

impl Spectrum {
    /// The weights of an illuminant: a CIE name (`D65`, `D50`, `E`, `A`, `F1` …) or the content of a CSV file with two
    /// columns, wavelength in nm (ascending, at least 380–780) and power in any unit. It does not open a file.
    pub fn new(illuminant: &Illuminant) -> Result<Spectrum> {
        let power = match named(illuminant.name()) {
            Some(power) => power,
            None => from_csv(illuminant)?,
        };
        let observer: Vec<[f64; 3]> = (380..=780)
            .filter_map(|nm| Observer::Cie1931.xyz_at_wavelength(nm).ok())
            .map(|xyz| xyz.to_array())
            .collect();
        let weigh = |i: usize| observer[i].map(|c| c * power[i]);
        let last = power.len() - 1;
        let luminance: f64 =
            (0..=last).map(|i| weigh(i)[1] * if i == 0 || i == last { 0.5 } else { 1.0 }).sum();
        if !(luminance.is_finite() && luminance > 0.0) {
            let cause = "has no power in visible light";
            return Err(Error::new(illuminant_subject(illuminant), cause)
                .remedy("give positive powers between 380 and 780 nm"));
        }
        Ok(Spectrum { per_nm: (0..=last).map(|i| weigh(i).map(|c| c / luminance)).collect() })
    }

    /// The weights of light of a colour, linear sRGB; still relative to white.
    #[must_use]
    pub fn tinted(mut self, colour: DVec3) -> Spectrum {
        for (weights, nm) in self.per_nm.iter_mut().zip(TABLE_MIN_NM as u32..) {
            let part = colour.dot(primary_shares(f64::from(nm)));
            *weights = weights.map(|weight| part * weight);
        }
        self
    }

    /// Weights per nm at a wavelength in nm: linear between whole nm, zero outside 380–780 nm.
    pub fn per_nm(&self, lambda_nm: f64) -> [f64; 3] {
        let place = lambda_nm - TABLE_MIN_NM;
        let last = self.per_nm.len() - 1;
        if !(place >= 0.0 && place <= last as f64) {
            return [0.0; 3];
        }
        let index = (place as usize).min(last - 1);
        let t = place - index as f64;
        std::array::from_fn(|c| self.per_nm[index][c] * (1.0 - t) + self.per_nm[index + 1][c] * t)
    }

    /// The wavelength in nm below which only a small part of the light of a range lies (X, Y and Z added).
    pub fn faint_below_nm(&self, range: &Wavelengths) -> f64 {
        const PART: f64 = 0.05;
        let fine = Wavelengths { step_nm: 1.0, ..*range };
        let light: Vec<(f64, f64)> =
            self.samples(&fine).iter().map(|s| (s.lambda_nm, s.xyz.iter().sum())).collect();
        let all: f64 = light.iter().map(|(_, one)| one).sum();
        let mut below = 0.0;
        let bright = light.iter().find(|(_, one)| {
            below += one;
            below > PART * all
        });
        bright.map_or(range.min_nm, |(lambda_nm, _)| *lambda_nm)
    }

    /// Trapezoid nodes of a wavelength range: `min`, `min + step`, …, and `max`; the last interval is shorter where the
    /// step does not divide the range. A range of one wavelength is one node of 1 nm.
    pub fn samples(&self, range: &Wavelengths) -> Vec<Sample> {
        let nodes_nm = range.nodes_nm();
        let last = nodes_nm.len() - 1;
        let width = |i: usize| match i {
            _ if last == 0 => 1.0,
            0 => 0.5 * (nodes_nm[1] - nodes_nm[0]),
            i if i == last => 0.5 * (nodes_nm[last] - nodes_nm[last - 1]),
            i => 0.5 * (nodes_nm[i + 1] - nodes_nm[i - 1]),
        };
        let sample = |(i, &lambda_nm): (usize, &f64)| Sample {
            lambda_nm,
            xyz: self.per_nm(lambda_nm).map(|c| c * width(i)),
        };
        nodes_nm.iter().enumerate().map(sample).collect()
    }

    /// Nodes at equal steps of the wavenumber 1/λ, from the longest wavelength to the shortest; weights per 1/µm, so
    /// they include the factor `λ²` of `dλ = λ² d(1/λ)`. Weights are linear between nodes. A range of one wavelength is
    /// one node of 1 nm, as in [`Spectrum::samples`].
    pub fn wavenumber_samples(&self, range: &Wavelengths) -> Vec<Sample> {
        if range.max_nm <= range.min_nm {
            return self.samples(range);
        }
        let (low, high) = (1e3 / range.max_nm, 1e3 / range.min_nm);
        let node = |i: usize| {
            let share = i as f64 / (WAVENUMBER_NODES - 1) as f64;
            let lambda_um = match i {
                0 => range.max_nm * 1e-3,
                i if i == WAVENUMBER_NODES - 1 => range.min_nm * 1e-3,
                _ => 1.0 / (low + (high - low) * share),
            };
            let lambda_nm = lambda_um * 1e3;
            let xyz = self.per_nm(lambda_nm).map(|c| c * 1e3 * lambda_um * lambda_um);
            Sample { lambda_nm, xyz }
        };
        (0..WAVENUMBER_NODES).map(node).collect()
    }

    /// Nodes that are closer where there is more light, from the longest wavelength to the shortest. For each count N,
    /// the range is divided into N equal parts of a variable whose density over 1/λ is a power of the weights, and each
    /// part has its node at the middle. A node's weights are those of its whole part, so a constant response has the
    /// right colour for every count.
    pub fn warped_samples(&self, range: &Wavelengths, counts: &[u32]) -> Vec<Vec<Sample>> {
        warp::samples(self, range, counts)
    }

    /// Tristimulus values of a response of 1 at every wavelength: the illuminant's white, `Y = 1`.
    pub fn white(&self) -> [f64; 3] {
        let fine = Wavelengths { min_nm: TABLE_MIN_NM, max_nm: TABLE_MAX_NM, step_nm: 1.0 };
        sum(&self.samples(&fine))
    }
}

/// Sum of the nodes' weights: the tristimulus values of a response of 1 at every wavelength on these nodes.
pub fn sum(samples: &[Sample]) -> [f64; 3] {
    samples.iter().fold([0.0; 3], |a, s| std::array::from_fn(|c| a[c] + s.xyz[c]))
}

fn named(name: &str) -> Option<Vec<f64>> {
    use CieIlluminant as C;
    let light = match name.to_ascii_uppercase().as_str() {
        "D65" => C::D65,
        "D50" => C::D50,
        "E" => C::E,
        "A" => C::A,
        "F1" => C::F1,
        "F2" => C::F2,
        "F3" => C::F3,
        "F4" => C::F4,
        "F5" => C::F5,
        "F6" => C::F6,
        "F7" => C::F7,
        "F8" => C::F8,
        "F9" => C::F9,
        "F10" => C::F10,
        "F11" => C::F11,
        "F12" => C::F12,
        _ => return None,
    };
    Some(light.spectrum().as_array().to_vec())
}

/// Whether this version knows a CIE illuminant of that name. Any other name is the path of a file.
pub fn is_named(name: &str) -> bool {
    named(name).is_some()
}

/// Remedy for an illuminant that cannot be used.
pub const ILLUMINANT_REMEDY: &str = "name a CIE illuminant (D65, D50, E, A, F1 to F12) or a CSV file with two columns, wavelength in nm and power";

/// Subject of errors about an illuminant.
pub fn illuminant_subject(illuminant: &Illuminant) -> String {
    format!("optics.illuminant = {:?}", illuminant.name())
}

fn from_csv(illuminant: &Illuminant) -> Result<Vec<f64>> {
    let fail = |cause: String| Error::new(illuminant_subject(illuminant), cause);
    let remedy = ILLUMINANT_REMEDY;
    let Some(content) = illuminant.content() else {
        return Err(fail("is not a known illuminant, and no file was read".into()).remedy(remedy));
    };
    let text = std::str::from_utf8(content)
        .map_err(|e| fail("is not UTF-8 text".into()).source(e).remedy(remedy))?;
    let mut rows: Vec<(f64, f64)> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let mut fields =
            line.split([',', ';', '\t', ' ']).filter(|f| !f.is_empty()).map(str::parse::<f64>);
        match (fields.next(), fields.next()) {
            (Some(Ok(nm)), Some(Ok(power)))
                if nm.is_finite() && power.is_finite() && power >= 0.0 =>
            {
                if rows.last().is_some_and(|&(before, _)| before >= nm) {
                    return Err(fail(format!(
                        "line {}: the wavelength {nm} nm is not above the one before",
                        index + 1
                    ))
                    .remedy("sort the lines by ascending wavelength, each once"));
                }
                rows.push((nm, power));
            }
            _ if rows.is_empty() && index == 0 => {} // a header
            _ => {
                return Err(fail(format!(
                    "line {}: {line:?} is not a wavelength and a power of at least 0",
                    index + 1
                ))
                .remedy(remedy));
            }
        }
    }
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return Err(fail("has no numbers".into()).remedy(remedy));
    };
    if first.0 > TABLE_MIN_NM || last.0 < TABLE_MAX_NM {
        let cause = format!("covers {} to {} nm, but must cover 380 to 780 nm", first.0, last.0);
        return Err(fail(cause).remedy("extend the table, with zeros where there is no power"));
    }
    let at = |nm: f64| {
        let next = rows.partition_point(|&(x, _)| x < nm).clamp(1, rows.len() - 1);
        let ((x0, y0), (x1, y1)) = (rows[next - 1], rows[next]);
        y0 + (y1 - y0) * (nm - x0) / (x1 - x0)
    };
    if rows.len() < 2 {
        return Err(fail("has a single wavelength".into()).remedy(remedy));
    }
    Ok((380..=780).map(|nm| at(f64::from(nm))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::colour::to_rgb;
    use crate::plan::Colour;

    fn grid(step_nm: f64) -> Vec<Sample> {
        let range = Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm };
        Spectrum::new(&"D65".into()).expect("D65").samples(&range)
    }

    /// A response of 1 at every wavelength is the D65 white. The error of a coarse grid shows, since the normalisation
    /// is fixed.
    #[test]
    fn mirror_is_white_and_coarse_grids_err_as_stated() {
        let white = Spectrum::new(&"D65".into()).expect("D65").white();
        for (c, want) in [(0, 0.9505), (1, 1.0), (2, 1.0888)] {
            assert!((white[c] - want).abs() < 3e-4, "{white:?}");
        }
        for (step, want, within) in [(5.0, 1.00002, 5e-6), (25.0, 1.009, 5e-4), (50.0, 1.025, 5e-4)]
        {
            let y = sum(&grid(step))[1];
            assert!((y - want).abs() < within, "step {step}: {y}");
        }
    }

    /// The texts apply D65 twice and use a CIE-RGB matrix, so their white is far from (1, 1, 1).
    #[test]
    fn white_is_neutral_in_srgb_and_not_in_the_texts_matrix() {
        let white = Spectrum::new(&"D65".into()).expect("D65").white();
        assert!(to_rgb(white, Colour::Srgb).iter().all(|c| (c - 1.0).abs() < 1e-3));
        let thesis = to_rgb(white, Colour::Thesis);
        assert!(
            (thesis[0] - thesis[1]).abs() > 0.01 && thesis.iter().all(|c| *c < 0.3),
            "{thesis:?}"
        );
    }

    #[test]
    fn a_step_that_does_not_divide_the_range_keeps_both_ends() {
        let nodes = Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 7.0 }.nodes_nm();
        assert_eq!((nodes[0], nodes[nodes.len() - 1]), (380.0, 780.0));
        let total: f64 = grid(7.0).iter().map(|s| s.xyz[1]).sum();
        assert!((total - 1.0).abs() < 1e-3, "{total}");
        assert_eq!(Wavelengths { min_nm: 550.0, max_nm: 550.0, step_nm: 5.0 }.nodes_nm(), [550.0]);
    }

    #[test]
    fn unknown_illuminants_say_what_is_known() {
        let text = Spectrum::new(&"D66".into()).expect_err("unknown").to_string();
        assert!(text.contains("D66") && text.contains("D65"), "{text}");
    }
}
