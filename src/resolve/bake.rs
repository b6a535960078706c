//! Axes of a table of colours over `(u, v, w)`.
//!
//! * **Columns**: the angle of `(u, v)`, in octants of [`octant`], a cheap stand-in for the arc tangent. A count that eight divides
//!   puts the axes and their bisectors on columns. A turn wider than a texture is cut into pages.
//! * **Rows**: `asinh(s·|(u, v)|)`: equal steps near the mirror direction, equal ratios away from it, since the integral over
//!   wavelengths smears what lies at `λ f` in proportion.
//! * **Layers**: `w²/(4 - |(u, v)|²)` from 0 to 1, which is all there is. The square makes them dense where directions are
//!   steep and the phase `2πwh/λ` is large.

/// Sizes of a table of colours; all zero where a mode has none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Axes {
    /// Columns of a full turn.
    pub columns: u32,
    /// Pages that the turn is cut into; each repeats the first column of the next.
    pub pages: u32,
    /// Rows, from the mirror direction to `|(u, v)| = 2`.
    pub rows: u32,
    /// Layers of a page.
    pub levels: u32,
    /// The factor `s`.
    pub stretch: f64,
    /// Rows per unit of `asinh`.
    pub pace: f64,
}

impl Axes {
    /// Columns of a page, the repeated one apart.
    pub fn page_columns(&self) -> u32 {
        self.columns / self.pages.max(1)
    }

    /// Unit vector of a column.
    pub fn direction(&self, column: u32) -> [f64; 2] {
        let place = 8.0 * f64::from(column) / f64::from(self.columns);
        let index = place.floor();
        let part = place - index;
        let odd = index as i64 % 2 == 1;
        let tangent = tangent(if odd { 1.0 - part } else { part });
        let long = 1.0 / tangent.hypot(1.0);
        let short = tangent * long;
        match index as i64 % 8 {
            0 => [long, short],
            1 => [short, long],
            2 => [-short, long],
            3 => [-long, short],
            4 => [-long, -short],
            5 => [-short, -long],
            6 => [short, -long],
            _ => [long, -short],
        }
    }

    /// `|(u, v)|` of a row.
    pub fn radius(&self, row: u32) -> f64 {
        (f64::from(row) / self.pace).sinh() / self.stretch
    }

    /// `w` of a layer of a page at a radius.
    pub fn w(&self, level: u32, radius: f64) -> f64 {
        let share = f64::from(level) / f64::from(self.levels - 1);
        -(share * (4.0 - radius * radius).max(0.0)).sqrt()
    }
}

/// Place in an octant, 0 to 1, of a tangent from 0 to 1: within 0.4 % of the arc tangent's.
pub fn octant(tangent: f64) -> f64 {
    tangent * (BEND - (BEND - 1.0) * tangent)
}

/// The tangent at a place.
fn tangent(place: f64) -> f64 {
    let rest = BEND * BEND - 4.0 * (BEND - 1.0) * place;
    (BEND - rest.sqrt()) / (2.0 * (BEND - 1.0))
}

/// Slope of [`octant`] at 0.
const BEND: f64 = 1.35;
