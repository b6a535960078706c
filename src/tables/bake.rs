//! Baking: the wavelength integral computed in advance. Colours over `(u, v, w)`, without the gain.
//!
//! `XYZ(u, v, w) = ∫ |P((u, v)/λ; 2πw/λ)|² S(λ) (x̄, ȳ, z̄)(λ) dλ / ∫ S ȳ dλ`, or with the ensemble mean of `|P|²`, on
//! the axes of [`super::BakedAxes`]. With other matter the integrand has the reflectance, too: on the relief the cosine
//! between half vector and viewer is `|(u, v, n w')|/(2n)`. As λ runs over its range, `(u, v)/λ` moves along a radius. So all rows of a column
//! share the amplitudes on one line of the frequency plane. These are the terms of the phase function, each under the
//! coherence window, at equal steps of frequency. A row uses the wavelengths that fall on these steps, and combines the
//! terms there for all `w` at once.

mod line;
mod pool;
mod sharpen;
mod table;

use rayon::prelude::*;

use crate::error::Result;
use crate::optics::Matter;
use crate::optics::spectrum::Spectrum;
use crate::plan::{Illuminant, Wavelengths, Window};
use crate::surface::HeightField;

use super::BakedAxes;

use line::{LANES, Lines, RadiusRow};

pub use sharpen::sharpen;
pub use table::{shape, table};

/// Colours of a table, `[level][row][column][X, Y, Z]`. Columns cover a full turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Colours {
    /// The axes.
    pub axes: BakedAxes,
    /// Numbers.
    pub xyz: Vec<[f32; 3]>,
}

/// What is integrated.
#[derive(Clone, Copy, Debug)]
pub struct Light<'a> {
    /// The coherence window.
    pub window: Window,
    /// The wavelengths.
    pub range: &'a Wavelengths,
    /// Material, films and cover, whose reflectance becomes part of the colours. `None`: a dielectric in air, whose
    /// reflectance is part of the gain.
    pub matter: Option<&'a Matter>,
    /// Whether intensities of bins may be pooled before they are summed, where the window is many bins wide.
    pub pooled: bool,
}

/// Computes the colours. `done` is called with the number of columns finished since the last call, from any thread. The
/// result does not depend on the number of threads.
pub fn bake(
    height: &HeightField,
    light: Light<'_>,
    illuminant: &Illuminant,
    axes: BakedAxes,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Colours> {
    Ok(bake_under(height, light, &Spectrum::new(illuminant)?, axes, done))
}

/// The same under any spectrum.
pub fn bake_under(
    height: &HeightField,
    light: Light<'_>,
    spectrum: &Spectrum,
    axes: BakedAxes,
    done: &(dyn Fn(usize) + Sync),
) -> Colours {
    let lines = Lines::new(height, light, spectrum, axes);
    let columns = axes.columns as usize;
    let cells = axes.rows as usize * axes.levels as usize;
    let blocks: Vec<Vec<[[f32; LANES]; 3]>> = (0..columns.div_ceil(LANES))
        .into_par_iter()
        .map(|block| {
            let first = block * LANES;
            let colours = lines.block(first as u32);
            done(LANES.min(columns - first));
            colours
        })
        .collect();
    let mut xyz = vec![[0.0_f32; 3]; cells * columns];
    // blocks are [row][level]
    xyz.par_chunks_mut(columns).enumerate().for_each(|(line, out)| {
        let (level, row) = (line / axes.rows as usize, line % axes.rows as usize);
        let cell = row * axes.levels as usize + level;
        for (block, out) in blocks.iter().zip(out.chunks_mut(LANES)) {
            for (lane, out) in out.iter_mut().enumerate() {
                *out = std::array::from_fn(|c| block[cell][c][lane]);
            }
        }
    });
    Colours { axes, xyz }
}

/// Bytes that baking takes at most, beside the heights: an estimate. `texels` and `table`: bytes of the table in 64 bits and in
/// its format.
pub(super) fn working_bytes(
    height: &HeightField,
    light: Light<'_>,
    axes: BakedAxes,
    [texels, table]: [u64; 2],
    threads: usize,
) -> u64 {
    let cells = u64::from(axes.columns) * u64::from(axes.rows) * u64::from(axes.levels);
    let colours = cells * size_of::<[f32; 3]>() as u64;
    let [making, lines] = line::bytes(height, light, &axes, threads);
    // what the threads computed, then the same in order; sharpening keeps a copy
    making.max(lines + 2 * colours).max(colours + texels).max(texels + table)
}

/// The rows of a table with their wavelengths.
fn rows(axes: &BakedAxes) -> impl Iterator<Item = RadiusRow> + '_ {
    (0..axes.rows).map(|index| RadiusRow { radius: axes.radius(index) })
}
