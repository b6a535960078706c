//! Random surfaces that look like those of beetles and snakes. The seed determines them, and they are periodic over the patch.
//!
//! They are not scans. They imitate the properties that determine colours: spacing, relief, regularity of the lattice.
//! A patch has whole numbers of features, so `pitch_um` and `length_um` are adjusted to the nearest values that fit,
//! with a note. `regularity` scales every irregularity by `1 - regularity`. Heights are scaled to exactly `0 …
//! height_um`.

use crate::error::{Error, Result};
use crate::plan::Rough;
use crate::random::SplitMix64;
use crate::surface::synthetic::grid;
use crate::surface::synthetic::waves::Waves;
use crate::surface::{HeightField, MAX_HEIGHT_UM, check_pixels, check_um};

/// Streams of the random generator, one per use.
const PLACES: u64 = 1;
const WARP: u64 = 2;
const SHEETS: u64 = 3;
const SWELL: u64 = 4;

/// Smooth domes `A (1 - r²)²`, `r < 1`, where `r` is the distance divided by 0.62 of the pitch. Where two meet, the
/// higher one counts.
///
/// They sit on a brick lattice of cells `pitch_um × length_um`, displaced by up to `0.5 (1 - regularity)` of a cell
/// along each axis; `A` is up to the same amount below 1.
pub fn bumps(rough: &Rough, subject: &str, notes: &mut Vec<String>) -> Result<HeightField> {
    let lattice = Lattice::new(rough, 1.0, subject, notes)?;
    let (nx, ny, disorder) = (lattice.columns, lattice.rows, 1.0 - rough.regularity);
    let mut random = SplitMix64::stream(rough.seed, PLACES);
    let domes: Vec<(f64, f64, f64)> = (0..nx * ny)
        .map(|i| {
            // every other row is shifted by half a cell; if the number of rows is odd, the last row is not shifted
            // relative to the first
            let brick = if (i / nx) % 2 == 1 { 0.5 } else { 0.0 };
            let (x, y) = (random.signed() * disorder * 0.5, random.signed() * disorder * 0.5);
            (0.5 + brick + x, 0.5 + y, 1.0 - 0.5 * disorder * random.share())
        })
        .collect();
    lattice.field(rough, |i, j| {
        let (x, y) = lattice.cell(i, j);
        let (cx, cy) = (x.floor() as isize, y.floor() as isize);
        let mut top = 0.0_f64;
        for (row, col) in (cy - 2..=cy + 2).flat_map(|r| (cx - 2..=cx + 2).map(move |c| (r, c))) {
            let (px, py, height) = domes[wrap(row, ny) * nx + wrap(col, nx)];
            let (dx, dy) = ((x - col as f64 - px) / 0.62, (y - row as f64 - py) / 0.62);
            let r2 = dx * dx + dy * dy;
            if r2 < 1.0 {
                top = top.max(height * (1.0 - r2) * (1.0 - r2));
            }
        }
        top
    })
}

/// *Elaphe*-like: sheets that overlap like roof tiles. The upper edge of each is cut into fingers that point up the picture.
///
/// Columns of fingers are `pitch_um` apart, sheets are `length_um` apart. The tip of a finger rests on the root of the
/// one above. With `s` across a finger (`-½ … ½`) and `t` from its tip down to its root, the finger covers `|s| <
/// w(t)`, `w = 0.22 √t + 0.28 t`: a rounded tip, and flanks that widen until they meet the neighbours' flanks in a
/// notch. Its surface falls from 1 to 0.62 along `t`, and by a fifth towards its flanks; the sheet below shows in the
/// gaps, falling from 0.5 to 0. So the notch is the deepest place, as in the scan. The positions and meanders of
/// columns, the wavy edge of every sheet, and a slow swell of the ground are irregular.
pub fn fingers(rough: &Rough, subject: &str, notes: &mut Vec<String>) -> Result<HeightField> {
    let lattice = Lattice::new(rough, 2.6, subject, notes)?;
    let (nx, ny, n, disorder) =
        (lattice.columns, lattice.rows, rough.pixels, 1.0 - rough.regularity);
    let mut random = SplitMix64::stream(rough.seed, PLACES);
    let centres: Vec<f64> = (0..nx).map(|_| 0.5 + 0.35 * disorder * random.signed()).collect();
    // position of every tip, in sheets: [sheet][column]
    let tips: Vec<f64> = (0..nx * ny).map(|_| 0.45 * disorder * random.signed()).collect();
    let meander = Waves::new(&mut SplitMix64::stream(rough.seed, WARP), n, 5, 3, 4);
    let edges = Waves::new(&mut SplitMix64::stream(rough.seed, SHEETS), n, 5, 5, 2);
    let swell = Waves::new(&mut SplitMix64::stream(rough.seed, SWELL), n, 5, 3, 3);
    lattice.field(rough, |i, j| {
        let (x, y) = lattice.cell(i, j);
        let x = x + 0.045 * nx as f64 * disorder * meander.at(i, j);
        let y = y + 0.13 * ny as f64 * disorder * edges.at(i, j);
        // the columns whose centres lie to the left and to the right
        let centre = |c: isize| c as f64 + centres[wrap(c, nx)];
        let mut left = x.floor() as isize;
        if centre(left) > x {
            left -= 1;
        }
        let (from, to) = (centre(left), centre(left + 1));
        let between = (x - from) / (to - from);
        let s = if between < 0.5 { between } else { 1.0 - between };
        // upper edge of a sheet, between the tips of the two columns
        let ease = between * between * (3.0 - 2.0 * between);
        let edge = |sheet: isize| {
            let tip = |c: isize| tips[wrap(sheet, ny) * nx + wrap(c, nx)];
            sheet as f64 + tip(left) * (1.0 - ease) + tip(left + 1) * ease
        };
        let mut sheet = y.floor() as isize - 1;
        while edge(sheet) < y {
            sheet += 1;
        }
        let t = (edge(sheet) - y) / (edge(sheet) - edge(sheet - 1));
        let width = 0.22 * t.sqrt() + 0.28 * t;
        let across = if width > 0.0 { (s / width).min(1.0) } else { 1.0 };
        let finger = (1.0 - 0.38 * t) * (1.0 - 0.2 * across * across);
        let gap = 0.5 * (1.0 - t);
        // flanks slope over a tenth of the spacing
        let covered = smooth((width + 0.05 - s) / 0.1);
        gap + (finger - gap) * covered + 0.4 * disorder * swell.at(i, j)
    })
}

/// *Xenopeltis*-like: straight ridges along y, and a row of pits in every furrow between them.
///
/// Ridges stand `pitch_um` apart; over the furrow between them, `s` from -½ to ½, the profile is `0.45 + 0.55 q (2 -
/// q)` with `q = sin² πs`. Pits follow each other every `length_um` along the furrow, Gaussian with radii 0.16 of the
/// pitch and 0.27 of the length, 0.45 deep. The positions of ridges (slightly, as in the animal) and of pits are
/// irregular, and so is the depth of pits. Every furrow starts at a random y.
pub fn rows(rough: &Rough, subject: &str, notes: &mut Vec<String>) -> Result<HeightField> {
    let lattice = Lattice::new(rough, 0.6, subject, notes)?;
    let (nx, ny, n, disorder) =
        (lattice.columns, lattice.rows, rough.pixels, 1.0 - rough.regularity);
    let mut random = SplitMix64::stream(rough.seed, PLACES);
    // every furrow starts anywhere along y
    let starts: Vec<f64> = (0..nx).map(|_| random.share()).collect();
    let pits: Vec<(f64, f64, f64)> = (0..nx * ny)
        .map(|_| {
            let (x, y) = (0.12 * disorder * random.signed(), 0.5 * disorder * random.signed());
            (x, y, 0.45 * (1.0 - 0.6 * disorder * random.share()))
        })
        .collect();
    let meander = Waves::new(&mut SplitMix64::stream(rough.seed, WARP), n, 4, 4, 2);
    lattice.field(rough, |i, j| {
        let (x, y) = lattice.cell(i, j);
        let x = x + 0.007 * nx as f64 * disorder * meander.at(i, j);
        let column = x.floor() as isize;
        // the furrow is the middle of a cell
        let s = x - column as f64 - 0.5;
        let wave = libm::cos(std::f64::consts::PI * s);
        let ridge = 1.0 - wave * wave;
        let base = 0.45 + 0.55 * ridge * (2.0 - ridge);
        let furrow = wrap(column, nx);
        let y = y - starts[furrow];
        let row = y.floor() as isize;
        let mut depth = 0.0;
        for r in row - 2..=row + 2 {
            let (px, py, deep) = pits[furrow * ny + wrap(r, ny)];
            let (dx, dy) = ((s - px) / 0.16, (y - r as f64 - 0.5 - py) / 0.27);
            depth += deep * libm::exp(-0.5 * (dx * dx + dy * dy));
        }
        base - depth.min(0.45)
    })
}

/// A patch divided into a whole number of cells, one per feature.
struct Lattice {
    columns: usize,
    rows: usize,
    pixels: usize,
    pitch_um: f64,
}

impl Lattice {
    /// Checks the keys and rounds to whole numbers of cells; `aspect` is the default of `length_um / pitch_um`.
    fn new(rough: &Rough, aspect: f64, subject: &str, notes: &mut Vec<String>) -> Result<Lattice> {
        let pitch_um = grid(subject, "size_um", rough.size_um, rough.pixels)?;
        check_pixels(subject, rough.pixels as u64, rough.pixels as u64)?;
        check_um(subject, "height_um", rough.height_um, MAX_HEIGHT_UM)?;
        if !(0.0..=1.0).contains(&rough.regularity) {
            let cause = format!("`regularity = {}` is outside 0 to 1", rough.regularity);
            return Err(Error::new(subject, cause)
                .remedy("give a number from 0 to 1; 1 is a perfect lattice"));
        }
        let mut cells = |key: &str, length_um: f64, given: bool| {
            check_um(subject, key, length_um, f64::MAX)?;
            let error = |cause: String| Error::new(subject, cause);
            let count = (rough.size_um / length_um).round();
            if count < 1.0 {
                return Err(error(format!(
                    "`{key} = {length_um}` does not fit into `size_um = {}`",
                    rough.size_um
                ))
                .remedy("make the patch larger or the features smaller"));
            }
            if count * 4.0 > rough.pixels as f64 {
                return Err(error(format!(
                    "`{key} = {length_um}` is less than four pixels of {pitch_um} µm"
                ))
                .remedy("use more pixels, a smaller patch or larger features"));
            }
            let fitted = rough.size_um / count;
            if given && (fitted - length_um).abs() > 1e-3 * length_um {
                notes.push(format!(
                    "`{key} = {length_um}` was changed to {fitted:.4}, so that {count} fit into the patch"
                ));
            }
            Ok(count as usize)
        };
        let columns = cells("pitch_um", rough.pitch_um, true)?;
        let length_um = rough.length_um.unwrap_or(aspect * rough.pitch_um);
        let rows = cells("length_um", length_um, rough.length_um.is_some())?;
        Ok(Lattice { columns, rows, pixels: rough.pixels, pitch_um })
    }

    /// Place of pixel (`i` from the left, `j` from the bottom) in cells.
    fn cell(&self, i: usize, j: usize) -> (f64, f64) {
        let n = self.pixels as f64;
        (i as f64 / n * self.columns as f64, j as f64 / n * self.rows as f64)
    }

    /// The field of a shape, evaluated at (`i` from the left, `j` from the bottom), scaled to `0 … height_um`.
    fn field(&self, rough: &Rough, shape: impl Fn(usize, usize) -> f64) -> Result<HeightField> {
        let n = self.pixels;
        let mut heights: Vec<f64> = (0..n)
            .rev()
            .flat_map(|j| (0..n).map(move |i| (i, j)))
            .map(|(i, j)| shape(i, j))
            .collect();
        let (low, high) = heights
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        for h in &mut heights {
            *h = if high > low { (*h - low) / (high - low) * rough.height_um } else { 0.0 };
        }
        HeightField::new(n, n, self.pitch_um, self.pitch_um, heights)
    }
}

/// Index on a ring of `n`.
fn wrap(index: isize, n: usize) -> usize {
    index.rem_euclid(n as isize) as usize
}

/// 0 below 0, 1 above 1, `3t² - 2t³` between.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
