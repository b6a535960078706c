//! Sharpening that compensates in advance for the loss by a linear filter.

use rayon::prelude::*;

use super::Colours;

/// Weights of a texel's two neighbours and of the texel itself. With them, linear interpolation of a smooth function
/// has a mean error of fourth order in the step.
const KERNEL: [f32; 2] = [-1.0 / 12.0, 7.0 / 6.0];

/// Sharpens along columns, rows and levels. Negative results become 0.
#[must_use]
pub fn sharpen(mut colours: Colours) -> Colours {
    let axes = colours.axes;
    let (columns, rows, levels) = (axes.columns as usize, axes.rows as usize, axes.levels as usize);
    // around the turn
    colours.xyz.par_chunks_mut(columns).for_each(|line| {
        let before = line.to_vec();
        for (i, out) in line.iter_mut().enumerate() {
            let neighbours = [before[(i + columns - 1) % columns], before[(i + 1) % columns]];
            *out = sharpened(before[i], neighbours);
        }
    });
    // along the radius; the column on the other side of the mirror direction is the opposite one
    colours.xyz.par_chunks_mut(columns * rows).for_each(|level| {
        let before = level.to_vec();
        for row in 0..rows - 1 {
            for column in 0..columns {
                let at = row * columns + column;
                let opposite = columns + (column + columns / 2) % columns;
                let inner = if row == 0 { opposite } else { at - columns };
                level[at] = sharpened(before[at], [before[inner], before[at + columns]]);
            }
        }
    });
    // along w, except at the ends
    let before = colours.xyz.clone();
    let size = columns * rows;
    colours.xyz.par_chunks_mut(size).enumerate().for_each(|(level, out)| {
        if level > 0 && level + 1 < levels {
            for (i, out) in out.iter_mut().enumerate() {
                let at = level * size + i;
                *out = sharpened(before[at], [before[at - size], before[at + size]]);
            }
        }
    });
    colours
}

fn sharpened(own: [f32; 3], [a, b]: [[f32; 3]; 2]) -> [f32; 3] {
    std::array::from_fn(|c| (KERNEL[1] * own[c] + KERNEL[0] * (a[c] + b[c])).max(0.0))
}
