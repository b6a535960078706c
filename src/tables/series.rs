//! The terms of the phase function on a surface: their number, their bins, and how a table stores them.

use std::sync::Arc;

use serde::Serialize;

use crate::defines::Defines;
use crate::error::Result;
use crate::field::transform::Bins;
use crate::optics::Matter;
use crate::optics::spectrum::Spectrum;
use crate::plan::{Basis, CoherenceScaling, Illuminant, Packing, TableFormat, Wavelengths};
use crate::surface::HeightField;
use crate::tables::basis::Expansion;
use crate::tables::terms::Grid;

use super::scale::scale;
use super::{Settings, TermScale, terms_shape};

/// How the number of terms was chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Choice {
    /// The configured number, with equal weight for all wavelengths.
    Count(u32),
    /// The configured number, optimised for visible light.
    Seen {
        /// Number of terms.
        terms: u32,
        /// The light's spectrum.
        #[serde(serialize_with = "Illuminant::serialize_identity")]
        illuminant: Illuminant,
        /// Longest wavelength, nm.
        max_nm: f64,
    },
    /// The minimum number that keeps this error of the phase function.
    Error(f64),
}

/// A basis on a surface. The serialised fields and the surface's heights determine the expansion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LaidExpansion {
    basis: Basis,
    choice: Choice,
    /// Shortest wavelength, nm.
    min_nm: f64,
    /// Under a cover: the phases that the basis is for.
    #[serde(skip_serializing_if = "Option::is_none")]
    phases: Option<Phases>,
    #[serde(skip)]
    expansion: Arc<Expansion>,
    /// Error of the phase function as colours see it.
    #[serde(skip)]
    seen_error: f64,
    /// Whether the error is above the limit, and the plan accepts that.
    #[serde(skip)]
    is_accepted: bool,
}

/// Phases per height under a cover.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Phases {
    /// Wavelength in air whose greatest phase per height is the greatest under the cover, nm.
    min_nm: f64,
    /// Least phase per height, 1/µm.
    least_z: f64,
    /// Phase per height at the wavelength from which on the basis is best, as `min_nm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    best_nm: Option<f64>,
}

impl LaidExpansion {
    /// A basis on a surface. Time: for `optimal`, a singular value decomposition.
    pub fn new(
        basis: Basis,
        choice: Choice,
        [min_nm, max_nm]: [f64; 2],
        matter: &Matter,
        height: &HeightField,
    ) -> Result<LaidExpansion> {
        let phase_min_nm = matter.phase_min_nm([min_nm, max_nm]);
        let least_z = matter.least_z([min_nm, max_nm]);
        let over = |best_nm: f64, terms: u32| {
            Expansion::over((least_z, phase_min_nm), best_nm, basis, terms, height)
        };
        let mut seen_nm = None;
        let expansion = match &choice {
            Choice::Count(terms) => over(phase_min_nm, *terms),
            Choice::Seen { terms, illuminant, max_nm } => {
                let range = Wavelengths { min_nm, max_nm: *max_nm, step_nm: 1.0 };
                let best_nm = Spectrum::new(illuminant)?.faint_below_nm(&range);
                let best_nm = matter.phase_min_nm([best_nm, *max_nm]);
                seen_nm = Some(best_nm);
                over(best_nm, *terms)
            }
            Choice::Error(error) => over(phase_min_nm, 1).with_error(*error),
        };
        let seen_error = expansion.bound();
        let expansion = Arc::new(expansion);
        let phases = matter.is_covered().then_some(Phases {
            min_nm: phase_min_nm,
            least_z,
            best_nm: seen_nm,
        });
        let is_accepted = false;
        Ok(LaidExpansion { basis, choice, min_nm, phases, expansion, seen_error, is_accepted })
    }

    /// Sets what was found about its error: as colours see it, and whether it is above the limit but accepted.
    #[must_use]
    pub fn judged(self, seen_error: f64, is_accepted: bool) -> LaidExpansion {
        LaidExpansion { seen_error, is_accepted, ..self }
    }

    /// The expansion.
    pub fn get(&self) -> &Expansion {
        &self.expansion
    }

    /// Shortest wavelength, nm.
    pub fn min_nm(&self) -> f64 {
        self.min_nm
    }
}

/// How the bins of a table were chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reach {
    /// By the configured number of bins to each side of the nearest one.
    Radius(u32),
    /// By a number of bins to each side that follows from the window's tail.
    Tail {
        /// Coherence length, µm.
        coherence_um: f64,
        /// How it depends on the wavelength.
        coherence_scaling: CoherenceScaling,
        /// Longest wavelength, nm.
        max_nm: f64,
    },
    /// By a number of bins to each side that follows from the light of replicas between their bins.
    Replicas {
        /// Replicas along x and y, as configured.
        periods: Option<[u32; 2]>,
        /// Coherence length, µm.
        coherence_um: f64,
    },
    /// By the lobes that the wavelengths of a direction cross.
    Corridor {
        /// Coherence length, µm.
        coherence_um: f64,
        /// How it depends on the wavelength.
        coherence_scaling: CoherenceScaling,
        /// Longest wavelength, nm.
        max_nm: f64,
    },
    /// By the grid of a table that contains the window.
    Prefiltered {
        /// Coherence length, µm.
        coherence_um: f64,
    },
}

/// A series of terms and its table. The serialised fields determine every number of the table on a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    expansion: LaidExpansion,
    reach: Reach,
    /// Bins of the table.
    pub bins: Bins,
    /// The grid of a table that contains the window. `None` if its bins are those of the patch.
    pub grid: Option<Grid>,
    /// Size `(Lx, Ly)` of the patch, or of the grid, µm: bins are `1/size` apart.
    pub size_um: [f64; 2],
    /// How complex terms are stored in texels.
    pub packing: Packing,
    /// Number format.
    pub format: TableFormat,
    #[serde(skip)]
    scale: TermScale,
}

/// Number of columns of coefficients if the shader takes the nearest one. Half a step of `z` changes the phase of a
/// height of 0.2 µm by 1.6e-3. Every profile allows textures of this width.
const NEAREST_COEFFICIENTS: usize = 2048;

impl Series {
    /// The series of a basis in a table. `size_um`: size of the patch, used if there is no grid.
    pub fn new(
        expansion: LaidExpansion,
        reach: Reach,
        bins: Bins,
        grid: Option<Grid>,
        patch_um: [f64; 2],
        (packing, format): (Packing, TableFormat),
    ) -> Series {
        let scale = match format {
            TableFormat::F16 => scale(expansion.get()),
            TableFormat::F32 | TableFormat::Rgb9e5 => TermScale::NONE,
        };
        let size_um = grid.map_or(patch_um, |grid| grid.size_um);
        Series { expansion, reach, bins, grid, size_um, packing, format, scale }
    }

    /// The basis on the surface.
    pub fn expansion(&self) -> &Expansion {
        self.expansion.get()
    }

    /// The basis with the fields that determine it.
    pub(super) fn laid(&self) -> &LaidExpansion {
        &self.expansion
    }

    /// Shortest wavelength, nm.
    pub fn min_nm(&self) -> f64 {
        self.expansion.min_nm
    }

    /// The wavelength in air whose greatest phase per height is the greatest here, nm: without a cover the shortest one.
    pub fn phase_min_nm(&self) -> f64 {
        self.expansion.phases.map_or(self.min_nm(), |phases| phases.min_nm)
    }

    /// Whether the table contains the coherence window.
    pub fn is_prefiltered(&self) -> bool {
        self.grid.is_some()
    }

    /// Number of terms.
    pub fn terms(&self) -> u32 {
        self.expansion().terms
    }

    /// Layers of the table.
    pub fn layers(&self) -> u32 {
        self.terms().div_ceil(match self.packing {
            Packing::Paired => 2,
            Packing::Single => 1,
        })
    }

    /// Scales of the terms.
    pub fn scale(&self) -> TermScale {
        self.scale
    }

    /// Settings of the spectrum table beside it.
    pub fn settings(&self, rotate_deg: f64) -> Settings {
        Settings { rotate_deg, scale: self.scale, matter: None }
    }

    /// Number of columns of the table of coefficients; 0 without such a table.
    pub fn coefficient_count(&self) -> usize {
        let expansion = self.expansion();
        match self.grid {
            Some(_) if expansion.is_tabulated() => NEAREST_COEFFICIENTS,
            _ => expansion.nodes(),
        }
    }

    /// Number of rows of the table of coefficients; 0 without such a table.
    pub fn coefficient_rows(&self) -> u32 {
        if self.expansion().is_tabulated() { self.terms().div_ceil(4) } else { 0 }
    }

    /// Bytes of the table and of the table of coefficients.
    pub fn byte_count(&self) -> u64 {
        let terms = terms_shape(self.bins, self.terms() as usize, self.packing, self.format);
        let coefficients = u64::from(self.coefficient_rows()) * self.coefficient_count() as u64;
        terms.byte_count() as u64 + 4 * 4 * coefficients
    }

    /// Bound of the phase function's error, including the error of coefficients between their nodes.
    pub fn phase_bound(&self) -> f64 {
        let expansion = self.expansion();
        let nearest = match (self.grid, self.coefficient_count()) {
            // half a step at the maximum height
            (Some(_), count) if count > 0 => {
                0.5 * expansion.z_max * expansion.reach_um / (count - 1) as f64
            }
            _ => 0.0,
        };
        expansion.bound() + nearest
    }

    /// Error of the phase function as colours see it: the error, the same at all wavelengths, that would change X, Y or Z
    /// as much as the errors of all wavelengths may.
    pub fn seen_error(&self) -> f64 {
        self.expansion.seen_error
    }

    /// Whether its error is above the limit, and the plan accepts that.
    pub fn is_accepted(&self) -> bool {
        self.expansion.is_accepted
    }

    /// Sum of the maxima of all terms.
    pub fn terms_sum(&self) -> f64 {
        self.expansion().term_sizes().iter().sum()
    }

    /// Flags and constants of the templates of a series.
    pub fn define(&self, into: &mut Defines) {
        into.flag("HALF", self.format == TableFormat::F16);
        into.flag("PAIRED", self.packing == Packing::Paired);
        into.flag("PREFILTERED", self.is_prefiltered());
        into.flag("TABULATED", self.expansion().is_tabulated());
        let [r_max, s_max] = [self.bins.r_max, self.bins.s_max];
        into.count("CENTRE_COLUMN", r_max, "column of the central texel of the terms, from 0");
        into.count("CENTRE_ROW", s_max, "row of the central texel of the terms, from 0");
        let columns = self.coefficient_count();
        into.count("COEFFICIENT_COUNT", columns, "number of columns of the table of coefficients");
        let rows = self.coefficient_rows() as usize;
        into.count("COEFFICIENT_ROWS", rows, "number of rows of the table of coefficients");
        let layers = match self.packing {
            Packing::Paired => "number of layers of the terms, two terms in each",
            Packing::Single => "number of layers of the terms, one term in each",
        };
        into.count("LAYER_COUNT", self.layers() as usize, layers);
        let whole = self.layers() as usize / 4 * 4;
        into.count("WHOLE_LAYERS", whole, "number of layers in whole groups of four");
        into.number("WAVELENGTH_MIN_UM", self.min_nm() * 1e-3, "shortest wavelength, µm");
        let shortest = "wavelength in air whose greatest phase per height is the greatest here, µm";
        into.number("PHASE_MIN_UM", self.phase_min_nm() * 1e-3, shortest);
    }
}
