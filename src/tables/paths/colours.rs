//! Probabilities of `(u, v)` in proportion to the colours of a table.

use std::f64::consts::PI;

use crate::tables::bake::Colours;
use crate::tables::{PATHS, Table, TexelFormat};

use super::FLOOR;

/// Number of times that the plane of `(u, v)` is halved.
pub const PATH_LEVELS: u32 = 12;

/// Columns of the table: as many as rows.
pub const fn path_columns() -> usize {
    1 << (PATH_LEVELS / 2)
}

/// The table of paths of colours, 2-D: a binary tree over the disc `|(u, v)| ≤ 2`, whose places are a share of a turn and
/// `|(u, v)|²/4`, so that equal areas are equal. Node 1 is the disc; the halves of node `n` are `2n` and `2n + 1`. Node `n` is in
/// column `n mod 64` and row `n/64`. Channels: 0 where the angle is divided and 1 where the radius is, the place of the division,
/// the probability of the half below it, 0. Leaves are of even probability.
///
/// Each division is where the leaves could follow the colours best: where the sum of `sqrt(A ∫ f² dA)` over both halves is least,
/// which is the deviation of an estimate with the best constant on each.
pub fn colour_paths_table(colours: &Colours) -> Table {
    let shape = colour_paths_shape();
    let mut texels = vec![0.0; 4 * shape.texel_count()];
    let grid = Grid::new(colours);
    grid.divide(1, grid.whole(), &mut texels);
    Table { texels, ..shape }
}

/// The table without its texels.
pub fn colour_paths_shape() -> Table {
    Table {
        name: "paths",
        binding: PATHS,
        format: TexelFormat::Rgba32Float,
        width: path_columns(),
        height: path_columns(),
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    }
}

/// Cells between the columns and rows of a table of colours.
struct Grid {
    /// Shares of a turn, from the direction opposite to the first column; then `|(u, v)|²/4`.
    edges: [Vec<f64>; 2],
    /// `∫ f dA` and `∫ f² dA` of all cells before a corner, `[row][column]`.
    sums: Vec<[f64; 2]>,
}

/// First and last edge along both axes.
type Part = [[usize; 2]; 2];

impl Grid {
    fn new(colours: &Colours) -> Grid {
        let axes = &colours.axes;
        let (columns, rows) = (axes.columns as usize, axes.rows as usize);
        let turn = |column: usize| {
            let [x, y] = axes.direction(column as u32);
            // whole turns, from the opposite of the first column on
            let turn = y.atan2(x) / (2.0 * PI) + 0.5;
            if column == columns / 2 { 0.0 } else { turn }
        };
        let first = columns / 2;
        let mut turns: Vec<f64> = (0..columns).map(|i| turn((first + i) % columns)).collect();
        turns.push(1.0);
        let mut radii: Vec<f64> =
            (0..rows).map(|row| (0.5 * axes.radius(row as u32)).min(1.0).powi(2)).collect();
        if let Some(last) = radii.last_mut() {
            *last = 1.0;
        }
        let levels = axes.levels as usize;
        let light = |row: usize, column: usize| -> f64 {
            let column = (first + column) % columns;
            let of = |level: usize| {
                let xyz = colours.xyz[(level * rows + row) * columns + column];
                xyz.iter().map(|part| f64::from(*part)).sum::<f64>()
            };
            (0..levels).map(of).sum::<f64>().max(0.0) / levels as f64
        };
        let corners: Vec<f64> = (0..rows)
            .flat_map(|row| (0..=columns).map(move |column| (row, column)))
            .map(|(row, column)| light(row, column))
            .collect();
        let at = |row: usize, column: usize| row * (columns + 1) + column;
        let cell = |row: usize, column: usize| {
            let mean = 0.25
                * (corners[at(row, column)]
                    + corners[at(row, column + 1)]
                    + corners[at(row + 1, column)]
                    + corners[at(row + 1, column + 1)]);
            (mean, (turns[column + 1] - turns[column]) * (radii[row + 1] - radii[row]))
        };
        let cells = || (0..rows - 1).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let whole: f64 =
            cells().map(|(row, column)| cell(row, column)).map(|(mean, area)| mean * area).sum();
        // the mean over the disc, whose area is 1 here
        let floor = (FLOOR / (1.0 - FLOOR) * whole).max(f64::MIN_POSITIVE);
        let mut sums = vec![[0.0; 2]; rows * (columns + 1)];
        for (row, column) in cells() {
            let (mean, area) = cell(row, column);
            let f = mean + floor;
            let before = [at(row, column + 1), at(row + 1, column), at(row, column)];
            let [above, left, both] = before.map(|at| sums[at]);
            sums[at(row + 1, column + 1)] = std::array::from_fn(|i| {
                above[i] + left[i] - both[i] + area * f * if i == 0 { 1.0 } else { f }
            });
        }
        Grid { edges: [turns, radii], sums }
    }

    fn whole(&self) -> Part {
        [0, 1].map(|axis| [0, self.edges[axis].len() - 1])
    }

    /// Deviation of an estimate with a constant probability on a part: `sqrt(A ∫ f² dA)`.
    fn deviation(&self, part: Part) -> f64 {
        let [columns, rows] = part;
        let at = |row: usize, column: usize| self.sums[row * self.edges[0].len() + column][1];
        let squares = at(rows[1], columns[1]) - at(rows[0], columns[1]) - at(rows[1], columns[0])
            + at(rows[0], columns[0]);
        let side = |axis: usize| self.edges[axis][part[axis][1]] - self.edges[axis][part[axis][0]];
        (side(0) * side(1) * squares.max(0.0)).sqrt()
    }

    /// Writes a node and those below it. The result is the sum of the deviations of its leaves.
    fn divide(&self, node: usize, part: Part, texels: &mut [f64]) -> f64 {
        if node >= 1 << PATH_LEVELS {
            return self.deviation(part);
        }
        let halves = |axis: usize, edge: usize| {
            let (mut below, mut above) = (part, part);
            (below[axis][1], above[axis][0]) = (edge, edge);
            [below, above]
        };
        let candidates = [0, 1].into_iter().flat_map(|axis| {
            let [first, last] = part[axis];
            (first + 1..last).map(move |edge| (axis, edge))
        });
        let cost = |(axis, edge): &(usize, usize)| {
            halves(*axis, *edge).map(|half| self.deviation(half)).iter().sum::<f64>()
        };
        let best = candidates
            .map(|candidate| (cost(&candidate), candidate))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, (axis, edge))) = best else {
            return self.keep(node, part, texels);
        };
        let [below, above] = halves(axis, edge);
        let below = self.divide(2 * node, below, texels);
        let above = self.divide(2 * node + 1, above, texels);
        let share = below / (below + above).max(f64::MIN_POSITIVE);
        texels[4 * node..4 * node + 4].copy_from_slice(&[
            axis as f64,
            self.edges[axis][edge],
            share,
            0.0,
        ]);
        below + above
    }

    /// A cell of the grid is not divided: all of it is above its lower edge of the angle, and so on below.
    fn keep(&self, node: usize, part: Part, texels: &mut [f64]) -> f64 {
        let place = self.edges[0][part[0][0]];
        let mut each = node..node + 1;
        while each.start < 1 << PATH_LEVELS {
            for node in each.clone() {
                texels[4 * node..4 * node + 4].copy_from_slice(&[0.0, place, 0.0, 0.0]);
            }
            each = 2 * each.start..2 * each.end;
        }
        self.deviation(part)
    }
}
