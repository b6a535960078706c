//! The result of the readers of height files: numbers, and what the file says about them.

use crate::surface::length::{self, Unit};

/// The result of a format's reader: numbers in the file's own units.
pub(super) struct Raster {
    pub columns: usize,
    pub rows: usize,
    pub samples: Samples,
    pub stated: Stated,
    pub notes: Vec<String>,
}

/// Samples `[row][column]`, top row first, NaN where void.
pub(super) enum Samples {
    /// Shares of the full grey range, 0 to 1.
    Grey { shares: Vec<f64>, bits: u8 },
    /// Numbers in the unit of [`Stated::unit`].
    Float(Vec<f64>),
}

/// What a file says about its numbers. `None` where it says nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Stated {
    /// Pixel pitch along x and y, in the unit `lateral`.
    pub pitch: [Option<f64>; 2],
    /// The unit of `pitch`.
    pub lateral: Lateral,
    /// The file's words for the pitch, for messages: `XReal, YReal`.
    pub pitch_by: String,
    /// Unit of the numbers of a float file.
    pub unit: Option<Unit>,
    /// The file's words for the unit or the range of heights.
    pub heights_by: String,
    /// Heights that black and white of an integer file stand for, µm.
    pub range_um: Option<[f64; 2]>,
    /// The number that stands for void pixels.
    pub void_value: Option<f64>,
}

/// The unit of a file's lateral lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Lateral {
    /// µm per unit.
    Um(f64),
    /// Not stated, and most likely that of the heights beside them.
    LikeHeights,
    /// Not stated.
    #[default]
    Unknown,
}

impl Stated {
    /// Whole lengths along x and y, each in a unit, as pitches. Lengths that are not positive are left out.
    pub fn sizes(&mut self, sizes: [Option<f64>; 2], pixels: [usize; 2], unit: &Unit, by: &str) {
        let pitch = |axis: usize| {
            sizes[axis].filter(|s| s.is_finite() && *s > 0.0).map(|s| s / pixels[axis] as f64)
        };
        self.pitch = [pitch(0), pitch(1)];
        self.pitch_by = by.to_owned();
        match unit {
            Unit::Length(um) => self.lateral = Lateral::Um(*um),
            Unit::Other(_) => self.pitch = [None; 2],
        }
    }

    /// The pitch along both axes, in the file's unit. One that is missing is that of the other axis.
    pub fn both(&self) -> Option<[f64; 2]> {
        match self.pitch {
            [Some(x), Some(y)] => Some([x, y]),
            [Some(one), None] | [None, Some(one)] => Some([one; 2]),
            [None, None] => None,
        }
    }

    /// The unit of heights and what names it, for messages.
    pub fn unit_words(&self) -> String {
        match &self.unit {
            Some(Unit::Length(um)) => length::name(*um)
                .map_or_else(|| format!("{} µm", length::shown(*um)), str::to_owned),
            Some(Unit::Other(word)) if word.is_empty() => "no unit".to_owned(),
            Some(Unit::Other(word)) => word.clone(),
            None => "µm".to_owned(),
        }
    }
}
