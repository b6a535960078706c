//! How an integer file quantises its heights.

use std::fmt;

use crate::surface::raster::Samples;

/// How an integer file quantises its heights.
pub(super) struct Steps {
    /// µm from one height to the next.
    pub(super) size_um: f64,
    bits: u8,
    /// Grey levels per step. Above 1 if the file has more bits than the data.
    levels: u32,
}

impl fmt::Display for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nm = self.size_um * 1e3;
        // three significant digits, since a 16-bit step is a few thousandths of a nanometre
        let digits = (2.0 - nm.log10().floor()).clamp(0.0, 9.0) as usize;
        write!(f, "heights come in steps of {nm:.digits$} nm ({}-bit grey", self.bits)?;
        match self.levels {
            1 => f.write_str(")"),
            levels => write!(f, ", of which only every {levels}th level is used)"),
        }
    }
}

/// The steps of an integer file whose full grey range is `height_um`. Floats have no steps.
pub(super) fn steps(samples: &Samples, height_um: f64) -> Option<Steps> {
    let Samples::Grey { shares, bits } = samples else { return None };
    let top = f64::from((1u32 << bits) - 1);
    let mut greys = shares.iter().filter(|share| !share.is_nan()).map(|s| (s * top).round() as u32);
    let first = greys.next()?;
    let common = greys.map(|grey| grey.abs_diff(first)).fold(0, greatest_common_divisor);
    // a flat surface has only one level, so the step is unknown
    let levels = common.max(1);
    Some(Steps { size_um: height_um * f64::from(levels) / top, bits: *bits, levels })
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
