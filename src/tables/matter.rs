//! Rows of the spectrum table about the matter of a surface: reflectances, and the dispersion of its cover.

use std::sync::Arc;

use serde::Serialize;
use serde_json::{Value, json};

use crate::defines::Defines;
use crate::error::{Error, Result};
use crate::optics::{Facing, Matter};
use crate::plan::Optics;

use super::Table;

/// Maximum error of a reflectance by cubics over cells of the cosine, relative to the larger of the reflectance and its
/// mean at normal incidence.
const CELL_ERROR: f64 = 2e-4;
/// Maximum number of cells: two rows each are within the height that every profile allows a texture.
const MAX_CELLS: u32 = 512;
/// Maximum error of a reflectance by linear interpolation between columns, in the same measure.
const COLUMN_ERROR: f64 = 1e-3;
/// Maximum number of columns that it asks for.
const MAX_COLUMNS: usize = 1024;
/// Step of the wavelengths at which cells are tried, nm.
const TRIED_NM: f64 = 10.0;
/// Maximum error of a reflectance by one cubic over a panel of wavelengths, in the same measure.
const PANEL_ERROR: f64 = 2e-2;
/// Maximum number of panels over the range. Moments of narrower ones are small differences of 32-bit floats.
const MAX_PANELS: u32 = 8;

/// The inputs of the rows.
///
/// A column is a wavelength: equal steps from the shortest to the longest, or the one wavelength of a table with a
/// single column. Row 0: what is added to the square of `n w'` at 550 nm, `4(n² - n550²)` of the cover, and the mean reflectance at normal
/// incidence. The next rows, one for each cell of
/// the cosine between half vector and viewer on the relief, have the reflectance relative to its mean at normal
/// incidence: coefficients of a cubic over the cell. For unpolarised obliquity as many rows follow: the first have s
/// polarisation, the second p polarisation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MatterSpec {
    /// What the reflectance depends on.
    identity: Value,
    /// Range of wavelengths, nm.
    range_nm: [f64; 2],
    cells: u32,
    #[serde(skip)]
    matter: Arc<Matter>,
}

impl MatterSpec {
    /// The rows for the optics of a surface. `None` for a dielectric in air with Stam's obliquity. It is an error if the
    /// reflectance changes too fast with the angle.
    pub fn new(
        optics: &Optics,
        matter: &Arc<Matter>,
        range_nm: [f64; 2],
    ) -> Result<Option<MatterSpec>> {
        let Some(identity) = optics.matter() else { return Ok(None) };
        let identity = json!([identity, optics.illuminant.identity()]);
        let cells = cells(matter, range_nm).ok_or_else(|| too_fast("angle"))?;
        Ok(Some(MatterSpec { identity, range_nm, cells, matter: matter.clone() }))
    }

    /// The matter.
    pub(super) fn matter(&self) -> &Matter {
        &self.matter
    }

    /// Number of cells of the cosine.
    pub fn cells(&self) -> u32 {
        self.cells
    }

    /// Range of wavelengths, nm.
    pub fn range_nm(&self) -> [f64; 2] {
        self.range_nm
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        let polarisations = if self.matter.is_mixed() { 2 } else { 1 };
        1 + polarisations * self.cells as usize
    }

    /// Meaning of the rows, in words.
    pub(super) fn meaning(&self) -> String {
        let cubic = format!(
            "reflectance relative to its mean at normal incidence, a cubic over each of {} equal cells of the cosine \
             between half vector and viewer, from {} to 1",
            self.cells,
            self.matter.least_cos_half()
        );
        let polarised =
            if self.matter.is_mixed() { ", for s, then for p polarisation" } else { "" };
        format!(
            "4 (n² - n550²) of the cover, mean reflectance at normal incidence, unused, unused; then {cubic}{polarised}"
        )
    }

    /// Number of columns with which linear interpolation between wavelengths is good enough. It is an error if the
    /// reflectance changes too fast with the wavelength.
    pub fn columns(&self) -> Result<usize> {
        let [from, to] = self.range_nm;
        let good = |columns: &usize| {
            let step = (to - from) / (*columns - 1) as f64;
            self.facings().iter().all(|cos| {
                (1..*columns).all(|i| {
                    let ends = [i - 1, i].map(|i| self.ratios(from + i as f64 * step, *cos));
                    let middle = self.ratios(from + (i as f64 - 0.5) * step, *cos);
                    let straight = (0..2).map(|p| 0.5 * (ends[0][p] + ends[1][p]));
                    straight.zip(middle).all(|(a, b)| (a - b).abs() <= COLUMN_ERROR * b.max(1.0))
                })
            })
        };
        let counts = std::iter::successors(Some(33), |count| Some(2 * count - 1));
        let mut counts = counts.take_while(|count| *count <= MAX_COLUMNS);
        counts.find(good).ok_or_else(|| too_fast("wavelength"))
    }

    /// Number of panels per 1/µm of wavenumber over which a cubic through four nodes of Chebyshev is good enough. It is an
    /// error if the reflectance changes too fast with the wavelength.
    pub fn panel_pace(&self) -> Result<f64> {
        let [low, high] = self.range_nm.map(|nm| 1e3 / nm);
        let range = low - high;
        let good = |count: &u32| {
            let half = 0.5 * range / f64::from(*count);
            self.facings().iter().all(|cos| {
                (0..*count).all(|panel| {
                    let middle = high + (2.0 * f64::from(panel) + 1.0) * half;
                    let at = |x: f64| self.ratios(1e3 / (middle + half * x), *cos);
                    let nodes = [0.923_879_5, 0.382_683_4, -0.382_683_4, -0.923_879_5];
                    let values = nodes.map(at);
                    [-1.0, -0.7, 0.0, 0.7, 1.0].iter().all(|x| {
                        let right = at(*x);
                        (0..2).all(|p| {
                            let guess = lagrange(&nodes, &values.map(|v| v[p]), *x);
                            (guess - right[p]).abs() <= PANEL_ERROR * right[p].max(1.0)
                        })
                    })
                })
            })
        };
        let counts = std::iter::successors(Some(1), |count| Some(2 * count));
        let mut counts = counts.take_while(|count| *count <= MAX_PANELS);
        let count =
            counts.find(good).ok_or_else(|| too_fast("wavelength for lights with a size"))?;
        // over the whole range not a whole number, which rounding could move to either side
        Ok(if range > 0.0 { (f64::from(count) - 0.01) / range } else { 0.0 })
    }

    /// Flags and constants of the template `matter`. `wavelengths`: columns of the spectrum table; `row`: first of the
    /// rows.
    pub fn define(&self, wavelengths: usize, row: usize, into: &mut Defines) {
        let [from, to] = self.range_nm;
        let span_um = (to - from) * 1e-3;
        let steps = (wavelengths - 1) as f64;
        let pace = if wavelengths > 1 { steps / span_um } else { 0.0 };
        into.number("MATTER_PACE", pace, "number of columns of the material per µm of wavelength");
        into.number("MATTER_FROM_UM", from * 1e-3, "wavelength of the first column, µm");
        into.count("MATTER_COLUMNS", wavelengths, "number of columns of the material");
        into.count("MATTER_ROW", row, "first row of the material in the table of the spectrum");
        into.count("MATTER_CELLS", self.cells as usize, "number of cells of the cosine");
        let cosine = self.matter.least_cos_half();
        into.number("MATTER_COSINE", cosine, "least cosine between half vector and viewer");
    }

    /// Adds the rows to a table of the spectrum, whose width is the number of wavelengths.
    pub(super) fn append(&self, table: &mut Table) {
        let [from, to] = self.range_nm;
        let step = (to - from) / (table.width.max(2) - 1) as f64;
        let nm = |column: usize| match table.width {
            1 => table.texels[3] * 1e3,
            _ => from + column as f64 * step,
        };
        let columns: Vec<f64> = (0..table.width).map(nm).collect();
        let normal = self.matter.normal_reflectance();
        let mut texels: Vec<[f64; 4]> =
            columns.iter().map(|nm| [self.matter.dispersion(*nm), normal, 0.0, 0.0]).collect();
        let shares: &[f64] = match self.matter.s_share() {
            Some(share) => &[share],
            None => &[1.0, 0.0],
        };
        for s_share in shares {
            for cell in 0..self.cells {
                let cubic = |nm: &f64| self.cubic(*nm, *s_share, cell);
                texels.extend(columns.iter().map(cubic));
            }
        }
        table.height += self.rows();
        table.texels.extend(texels.concat());
    }

    /// Coefficients of the cubic of a cell.
    fn cubic(&self, lambda_nm: f64, s_share: f64, cell: u32) -> [f64; 4] {
        let ratio = |cos_half| self.matter.ratio(lambda_nm, Facing { cos_half, s_share });
        cubic(self.matter.least_cos_half(), self.cells, cell, &ratio)
    }

    fn ratios(&self, lambda_nm: f64, cos_half: f64) -> [f64; 2] {
        self.matter.ratios(lambda_nm, cos_half)
    }

    /// Cosines at which wavelengths are tried.
    fn facings(&self) -> [f64; 2] {
        [1.0, 0.5 * (1.0 + self.matter.least_cos_half())]
    }
}

/// The reflectance changes faster than a table can follow.
fn too_fast(with: &str) -> Error {
    let cause = format!(
        "the reflectance changes too fast with the {with}, by interference in films or by total reflection under a cover"
    );
    Error::new("optics.films, optics.cover_index", cause)
        .remedy("use thinner films, since a layer of many wavelengths is a cover; or a cover whose index is below that of a dielectric")
}

/// The least number of cells with which cubics are good enough. `None` if that is too many.
fn cells(matter: &Matter, [from, to]: [f64; 2]) -> Option<u32> {
    let least = matter.least_cos_half();
    let count = ((to - from) / TRIED_NM).ceil() as usize;
    let tried: Vec<f64> = (0..=count).map(|i| (from + i as f64 * TRIED_NM).min(to)).collect();
    let good = |cells: &u32| {
        tried.iter().all(|nm| {
            (0..*cells).all(|cell| {
                [0, 1].iter().all(|p| {
                    let ratio = |cos| matter.ratios(*nm, cos)[*p];
                    let [a, b, c, d] = cubic(least, *cells, cell, &ratio);
                    [0.1, 0.5, 0.9].iter().all(|t| {
                        let place = (f64::from(cell) + t) / f64::from(*cells);
                        let right = ratio(least + (1.0 - least) * place);
                        (a + t * (b + t * (c + t * d)) - right).abs() <= CELL_ERROR * right.max(1.0)
                    })
                })
            })
        })
    };
    let counts = std::iter::successors(Some(1), |count| Some(2 * count));
    counts.take_while(|count| *count <= MAX_CELLS).find(good)
}

/// The cubic through the ends of a cell and two places between them (nodes of Chebyshev and Lobatto), so that
/// neighbouring cells meet. Powers of the place in the cell, 0 to 1.
fn cubic(least: f64, cells: u32, cell: u32, value: &dyn Fn(f64) -> f64) -> [f64; 4] {
    let at = |t: f64| {
        let place = (f64::from(cell) + t) / f64::from(cells);
        value(least + (1.0 - least) * place)
    };
    let [a, b, c, d] = [0.0, 0.25, 0.75, 1.0].map(at);
    // Lagrange's polynomials of 0, 1/4, 3/4 and 1 in powers
    [
        a,
        (-19.0 * a + 24.0 * b - 8.0 * c + 3.0 * d) / 3.0,
        (32.0 * a - 56.0 * b + 40.0 * c - 16.0 * d) / 3.0,
        16.0 * (-a + 2.0 * b - 2.0 * c + d) / 3.0,
    ]
}

/// The cubic through four values, at a place.
fn lagrange(nodes: &[f64; 4], values: &[f64; 4], x: f64) -> f64 {
    let term = |i: usize| {
        let others = (0..4).filter(|j| *j != i);
        others.fold(values[i], |product, j| product * (x - nodes[j]) / (nodes[i] - nodes[j]))
    };
    (0..4).map(term).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Material, Medium};

    #[test]
    fn a_cubic_is_reproduced() {
        let value = |x: f64| 1.0 - 2.0 * x + 3.0 * x * x - 4.0 * x * x * x;
        let [a, b, c, d] = cubic(0.2, 4, 2, &value);
        for t in [0.0, 0.1, 0.6, 1.0] {
            let x = 0.2 + 0.8 * (2.0 + t) / 4.0;
            assert!((a + t * (b + t * (c + t * d)) - value(x)).abs() < 1e-13);
        }
    }

    /// Metals in air and under a cover are within the error, and gold needs more than one panel.
    #[test]
    fn cells_columns_and_panels_follow_the_material() {
        let of = |metal: &'static str, cover: f64| {
            let optics = Optics {
                material: Material::Medium(Medium::Named(metal)),
                cover_index: Medium::Constant(cover),
                ..Optics::standard()
            };
            let matter = Arc::new(Matter::new(&optics).expect("valid"));
            MatterSpec::new(&optics, &matter, [380.0, 780.0]).expect("thin").expect("not plain")
        };
        let (air, covered) = (of("aluminium", 1.0), of("aluminium", 1.58));
        assert!(air.cells > covered.cells && covered.cells == 1, "{} {}", air.cells, covered.cells);
        let pace = |metal| of(metal, 1.0).panel_pace().expect("thin");
        let (smooth, edged) = (pace("silver"), pace("gold"));
        assert!(edged > smooth && smooth > 0.0, "{smooth} {edged}");
        assert!(of("gold", 1.0).columns().expect("thin") > 33);
    }
}
