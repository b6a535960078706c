//! The table of streaks: cells of wavelengths for orders under surroundings.

use glam::DVec3;

use crate::optics::primary_shares;
use crate::optics::spectrum::Spectrum;

use super::{STREAKS, Table, TexelFormat};

/// Distance of the samples from which cells are summed, nm.
const STEP_NM: f64 = 0.25;

/// Part of the standard deviation of a cell's wavelengths that the surroundings are blurred over. The light between two
/// wavelengths is shared by both, so that less blur suffices.
const BLUR: f64 = 0.85;

/// Frequency in cycles per µm above which an order has twice as many cells: its streak is longer.
pub const LONG_CPUM: f64 = 1.0;

/// The table of streaks, 2-D. Columns: first `cells` cells and the upper edge of the last, then the same with twice as many for
/// orders above [`LONG_CPUM`]. Cells go from short wavelengths to long ones, with equal shares of `∫ sqrt(X + Y + Z) dλ`.
/// Rows: red, green, blue light. Channels: X, Y, Z of that light, shared between the wavelengths of neighbouring cells by
/// linear interpolation; then in row 0 the mean wavelength of the cell in µm, in row 1 its lower edge in µm, in row 2 the
/// standard deviation to blur over, in µm of wavelength.
pub fn streaks_table(spectrum: &Spectrum, range_nm: [f64; 2], cells: u32) -> Table {
    let sets = [cells, 2 * cells].map(|cells| rows(spectrum, range_nm, cells));
    let texels = (0..3).flat_map(|row| sets.iter().flat_map(move |set| set[row].clone()));
    Table { texels: texels.flatten().collect(), ..streaks_shape(cells) }
}

/// The rows of one number of cells.
fn rows(spectrum: &Spectrum, range_nm: [f64; 2], cells: u32) -> [Vec<[f64; 4]>; 3] {
    let count = ((range_nm[1] - range_nm[0]) / STEP_NM).ceil().max(1.0) as usize;
    let step_nm = (range_nm[1] - range_nm[0]) / count as f64;
    let samples: Vec<(f64, DVec3)> = (0..count)
        .map(|i| {
            let nm = range_nm[0] + (i as f64 + 0.5) * step_nm;
            (nm, DVec3::from(spectrum.per_nm(nm)) * step_nm)
        })
        .collect();
    let pace = |xyz: DVec3| xyz.element_sum().max(0.0).sqrt() + f64::MIN_POSITIVE;
    let whole: f64 = samples.iter().map(|(_, xyz)| pace(*xyz)).sum();
    // the cell of each sample, whole samples, so that edges lie between them
    let (mut place, mut edges) = (0.0, vec![range_nm[0]]);
    let mut cell_of = Vec::with_capacity(count);
    for (nm, xyz) in &samples {
        let middle = (place + 0.5 * pace(*xyz)) / whole * f64::from(cells);
        let cell = (middle as usize).min(cells as usize - 1);
        while edges.len() <= cell {
            edges.push(nm - 0.5 * step_nm);
        }
        cell_of.push(cell);
        place += pace(*xyz);
    }
    edges.resize(cells as usize, range_nm[1]);
    edges.push(range_nm[1]);
    let moments = |cell: usize| {
        let own = samples.iter().zip(&cell_of).filter(|(_, of)| **of == cell);
        let own: Vec<(f64, f64)> = own.map(|((nm, xyz), _)| (*nm, xyz.element_sum())).collect();
        let total: f64 = own.iter().map(|(_, light)| light).sum();
        let middle = 0.5 * (edges[cell] + edges[cell + 1]);
        if total <= 0.0 {
            return (middle, 0.0);
        }
        let mean = own.iter().map(|(nm, light)| nm * light).sum::<f64>() / total;
        let squares = own.iter().map(|(nm, light)| (nm - mean).powi(2) * light).sum::<f64>();
        (mean, (squares / total).sqrt())
    };
    let means: Vec<(f64, f64)> = (0..cells as usize).map(moments).collect();
    let mut light = vec![[DVec3::ZERO; 3]; cells as usize];
    for (nm, xyz) in &samples {
        let shares = primary_shares(*nm).to_array();
        let after = means.partition_point(|(mean, _)| mean <= nm);
        let (low, high) = (after.saturating_sub(1), after.min(means.len() - 1));
        let span = means[high].0 - means[low].0;
        let part = if span > 0.0 { (nm - means[low].0) / span } else { 0.0 };
        for (row, share) in shares.into_iter().enumerate() {
            light[low][row] += (1.0 - part) * share * *xyz;
            light[high][row] += part * share * *xyz;
        }
    }
    let texel = |row: usize, cell: usize| {
        let last = cell == cells as usize;
        let xyz = if last { DVec3::ZERO } else { light[cell][row] };
        let (mean, deviation) = if last { (edges[cell], 0.0) } else { means[cell] };
        let fourth = [mean, edges[cell], BLUR * deviation][row] * 1e-3;
        xyz.extend(fourth).to_array()
    };
    [0, 1, 2].map(|row| (0..=cells as usize).map(|cell| texel(row, cell)).collect())
}

/// The table of streaks without its texels.
pub(super) fn streaks_shape(cells: u32) -> Table {
    Table {
        name: "streaks",
        binding: STREAKS,
        format: TexelFormat::Rgba32Float,
        width: 3 * cells as usize + 2,
        height: 3,
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Optics;

    #[test]
    fn cells_have_all_light() {
        let spectrum = Spectrum::new(&Optics::standard().illuminant).unwrap();
        for cells in [2, 3, 8, 64] {
            let table = streaks_table(&spectrum, [380.0, 780.0], cells);
            for (first, cells) in [(0, cells), (cells + 1, 2 * cells)] {
                let texel = |cell: u32, row: usize, channel: usize| {
                    table.texels[4 * (row * table.width + (first + cell) as usize) + channel]
                };
                for (channel, white) in spectrum.white().into_iter().enumerate() {
                    let sum: f64 = (0..cells)
                        .flat_map(|cell| [0, 1, 2].map(|row| texel(cell, row, channel)))
                        .sum();
                    assert!((sum - white).abs() < 1e-4 * white, "{cells} {channel}: {sum} {white}");
                }
                for cell in 0..cells {
                    let [mean, low, high] =
                        [texel(cell, 0, 3), texel(cell, 1, 3), texel(cell + 1, 1, 3)];
                    assert!(low < mean && mean < high, "{cells} {cell}: {low} {mean} {high}");
                }
                assert_eq!((texel(0, 1, 3), texel(cells, 1, 3)), (0.38, 0.78));
            }
        }
    }
}
