//! What a variant costs per pixel, counted from its configuration.

use super::{Auto, Mode, Packing, Variant};

/// Work per pixel. It is the same for every lit pixel in the full mode, so mean and worst agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// Evaluations of the field `P`: wavelength samples.
    pub evaluations: u64,
    /// Texel fetches from the term table.
    pub term_fetches: u64,
    /// Texel fetches from the spectrum table.
    pub spectrum_fetches: u64,
}

impl Cost {
    /// All texel fetches.
    pub fn fetches(&self) -> u64 {
        self.term_fetches + self.spectrum_fetches
    }
}

impl Variant {
    /// The cost as configured; `None` while terms or radius are left to the tool.
    pub fn cost(&self) -> Option<Cost> {
        match (self.terms, self.window_radius) {
            (Auto::Value(terms), Auto::Value(radius)) => Some(self.cost_of(terms, radius)),
            _ => None,
        }
    }

    /// The cost with given numbers of terms and bins to each side.
    pub fn cost_of(&self, terms: u32, radius: u32) -> Cost {
        let Mode::Full = self.mode;
        let evaluations = self.wavelengths.count() as u64;
        let width = 2 * u64::from(radius) + 1;
        let term_fetches = evaluations * u64::from(self.packing.layers(terms)) * width * width;
        Cost { evaluations, term_fetches, spectrum_fetches: evaluations }
    }
}

impl Packing {
    /// Layers of texels that hold a number of complex terms.
    pub fn layers(self, terms: u32) -> u32 {
        match self {
            Packing::Paired => terms.div_ceil(2),
            Packing::Single => terms,
        }
    }
}
