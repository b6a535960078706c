//! What a surface is made of: its reflectance as a table and as a picture.

use serde::Serialize;

use crate::encode::viridis;
use crate::error::Result;
use crate::optics::{Matter, REFERENCE_NM};
use crate::plan::{Film, Material, Medium, Obliquity, Optics};

use super::canvas::{ADVANCE, Align, Colour, LINE};
use super::plot::{Plot, PlotRange};

/// Wavelengths of the table, nm.
const TABLE_NM: [f64; 7] = [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0];

/// Angles from the normal in air, degrees.
const ANGLES_DEG: [f64; 4] = [0.0, 30.0, 60.0, 75.0];

/// Material, films and cover of a surface with their reflectance in the mirror direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MatterFacts {
    /// The plan's `material`.
    pub material: Material,
    /// Refractive index of a dielectric; `None` for other materials.
    pub refractive_index: Option<f64>,
    /// The plan's `cover_index`; 1 for none.
    pub cover_index: Medium,
    /// Refractive index of the cover at 550 nm.
    pub cover_index_at_550_nm: f64,
    /// The plan's `films`, from the outside in.
    pub films: Vec<Film>,
    /// The plan's `obliquity`.
    pub obliquity: Obliquity,
    /// Reflectance of the relief at normal incidence, from 0 to 1, without the cover's face: the mean over the light,
    /// weighted by luminance. Results are relative to it.
    pub normal_reflectance: f64,
    /// Wavelengths of the rows of `relief` and `outside`, nm.
    pub wavelengths_nm: [f64; 7],
    /// Angles of their columns, from the normal in air, degrees.
    pub angles_deg: [f64; 4],
    /// Reflectance of the relief in the mirror direction, from 0 to 1, mean of s and p, without the cover's face.
    pub relief: [[f64; 4]; 7],
    /// The same as seen from outside: times both transmittances of the cover's face ([`Matter::seen_reflectances`]).
    pub outside: [[f64; 4]; 7],
}

impl MatterFacts {
    pub(super) fn new(optics: &Optics, matter: &Matter) -> MatterFacts {
        let Optics { material, refractive_index, cover_index, films, obliquity, .. } = optics;
        let table = |part: usize| {
            TABLE_NM.map(|nm| ANGLES_DEG.map(|theta| matter.seen_reflectances(nm, theta)[part]))
        };
        MatterFacts {
            material: material.clone(),
            refractive_index: (*material == Material::Dielectric).then_some(*refractive_index),
            cover_index: cover_index.clone(),
            cover_index_at_550_nm: matter.cover_at(REFERENCE_NM),
            films: films.clone(),
            obliquity: *obliquity,
            normal_reflectance: matter.normal_reflectance(),
            wavelengths_nm: TABLE_NM,
            angles_deg: ANGLES_DEG,
            relief: table(0),
            outside: table(1),
        }
    }
}

/// Size of the area, pixels.
const WIDTH: i64 = 720;
const HEIGHT: i64 = 400;

/// Wavelengths of the picture, nm.
const SHOWN_NM: [f64; 2] = [380.0, 780.0];

/// Smallest range of the axis of reflectance, in percent.
const LEAST_PERCENT: f64 = 4.0;

/// Length of a dash and of a gap, pixels.
const DASH: i64 = 7;

/// Widths of the curves of [`ANGLES_DEG`], pixels. The first is wider, so that it shows where the second lies on it.
const WIDTHS: [i64; 4] = [5, 3, 3, 3];

/// Reflectance in the mirror direction over the wavelength as PNG, one curve for each of 0, 30, 60 and 75 degrees from the
/// normal in air: as seen from outside, and dashed that of the relief alone where there is a cover.
pub fn reflectance_picture(matter: &Matter, name: &str) -> Result<Vec<u8>> {
    let [first, last] = SHOWN_NM;
    let at = |column: i64| first + (last - first) * column as f64 / (WIDTH - 1) as f64;
    let curves = ANGLES_DEG.map(|theta| -> Vec<[f64; 2]> {
        let percent = |nm: f64| matter.seen_reflectances(nm, theta).map(|r| 100.0 * r);
        (0..WIDTH).map(|column| percent(at(column))).collect()
    });
    let x = PlotRange { low: first, high: last, name: "wavelength in air, nm".to_owned() };
    let y = range(curves.iter().flatten().flatten().copied());
    let title = format!("reflectance of {name} in the mirror direction");
    let mut plot = Plot::new(&title, [WIDTH, HEIGHT], &x, &y, None);
    let drawn: &[(usize, bool)] =
        if matter.is_covered() { &[(0, true), (1, false)] } else { &[(1, false)] };
    for ((curve, colour), width) in curves.iter().zip(colours()).zip(WIDTHS) {
        for (part, is_dashed) in drawn {
            let values: Vec<f64> = curve.iter().map(|pair| pair[*part]).collect();
            plot.curve(&values, &y, (colour, width), is_dashed.then_some(DASH));
        }
    }
    legend(&mut plot, matter.is_covered());
    plot.canvas.png()
}

/// One colour for each angle, none too light for white paper.
fn colours() -> [Colour; ANGLES_DEG.len()] {
    [0.0, 0.3, 0.58, 0.85].map(viridis)
}

/// The axis of reflectance: from 0, unless all values are far from it.
fn range(percent: impl Iterator<Item = f64>) -> PlotRange {
    let ends = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
    let (low, high) = percent.fold((f64::INFINITY, 0.0), ends);
    let margin = 0.08 * (high - low).max(LEAST_PERCENT);
    // a tick at the very top would meet the axis's name
    let high = (high + margin).min(102.0);
    let low = (low - margin).min(high - LEAST_PERCENT);
    let low = if low < 0.4 * high { 0.0 } else { low };
    PlotRange { low, high, name: "reflectance, %".to_owned() }
}

/// Which curve is of which angle, from the right end of the line above the area.
fn legend(plot: &mut Plot, is_covered: bool) {
    const SWATCH: i64 = 24;
    let top = plot.top - LINE - 8;
    let mut right = plot.left + plot.width;
    if is_covered {
        let text = "dashed: relief alone";
        plot.canvas.label(text, right, top, Align::Right);
        right -= (text.chars().count() as i64 + 2) * ADVANCE;
    }
    for ((theta, colour), width) in ANGLES_DEG.into_iter().zip(colours()).zip(WIDTHS).rev() {
        let text = format!("{theta}°");
        plot.canvas.label(&text, right, top, Align::Right);
        right -= text.chars().count() as i64 * ADVANCE + 4;
        plot.canvas.fill(right - SWATCH, top + (LINE - width) / 2, SWATCH, width, colour);
        right -= SWATCH + 2 * ADVANCE;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_begins_at_zero_unless_all_values_are_far_from_it() {
        let ends = |values: &[f64]| {
            let PlotRange { low, high, .. } = range(values.iter().copied());
            (low, high)
        };
        assert_eq!(ends(&[4.0, 29.0]), (0.0, 31.0));
        assert_eq!(ends(&[50.0, 75.0]), (48.0, 77.0));
        // nearly constant, and at the upper end
        let (low, high) = ends(&[91.0, 91.0]);
        assert!(low < 91.0 && high > 91.0 && high - low >= LEAST_PERCENT, "{low} {high}");
        let (low, high) = ends(&[99.9, 100.0]);
        assert!(low <= 96.4 && high > 100.0 && high <= 102.0, "{low} {high}");
    }
}
