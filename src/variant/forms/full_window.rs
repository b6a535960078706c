//! `full` on the bins of the patch: the texts' sum under the coherence window.

use std::f64::consts::TAU;

use crate::defines::Defines;
use crate::error::Result;
use crate::optics::window_sigma_um;
use crate::plan::{Auto, Illuminant, Variant, Wavelengths, Window};
use crate::surface::HeightField;
use crate::tables::{Reach, Series, TableSpec};
use crate::variant::tolerance::Promise;
use crate::variant::{AUTO_TAIL, Coat, Computation, Cost, ErrorBound, Ground, lay, window_tail};

/// Numbers of the form.
#[derive(Clone, Debug, PartialEq)]
pub struct FullWindow {
    /// The terms.
    pub series: Series,
    /// Bins to each side of the nearest one.
    pub window_radius: u32,
    /// The coherence window.
    pub window: Window,
    /// What the surface is made of.
    pub coat: Coat,
    illuminant: Illuminant,
    wavelengths: Wavelengths,
    hoist: bool,
}

impl FullWindow {
    pub(in crate::variant) fn new(variant: &Variant, height: &HeightField) -> Result<FullWindow> {
        let window = Window::from(&variant.optics);
        let (patch_um, range_nm) = (lay::patch_um(height), lay::range_nm(variant));
        let coat = Coat::new(variant)?;
        let expansion = lay::expansion(variant, height, &coat.matter)?;
        let (window_radius, reach) = match variant.window_radius {
            Auto::Value(radius) => (radius, Reach::Radius(radius)),
            Auto::Auto => {
                let tail = |radius| window_tail(window, range_nm, patch_um, radius);
                let Window { coherence_um, coherence_scaling, .. } = window;
                let reach = Reach::Tail { coherence_um, coherence_scaling, max_nm: range_nm[1] };
                (lay::radius(0, AUTO_TAIL, tail), reach)
            }
        };
        // one bin more, because a 32-bit position may be rounded the other way
        let bins = lay::bins(patch_um, range_nm[0], [window_radius as usize + 1; 2]);
        let texels = (variant.packing, variant.table);
        Ok(FullWindow {
            series: Series::new(expansion, reach, bins, None, patch_um, texels),
            window_radius,
            window,
            coat,
            illuminant: variant.optics.illuminant.clone(),
            wavelengths: variant.wavelengths,
            hoist: variant.hoist,
        })
    }

    fn range_nm(&self) -> [f64; 2] {
        [self.wavelengths.min_nm, self.wavelengths.max_nm]
    }

    fn tail(&self) -> f64 {
        window_tail(self.window, self.range_nm(), self.series.size_um, self.window_radius)
    }
}

/// Maximum share of the window's energy beyond the bins that are read for which the window counts as complete.
const WHOLE: f64 = 1e-3;

impl Computation for FullWindow {
    fn define(&self, wavelengths: usize, into: &mut Defines) {
        self.series.define(into);
        super::define_window(self.window, into);
        super::define_patch(self.series.size_um, into);
        self.coat.define(wavelengths, 2, into);
        into.flag("THESIS_LOOP", !self.hoist);
        into.count("WAVELENGTH_COUNT", wavelengths, super::WAVELENGTH_COUNT);
        let radius = self.window_radius as usize;
        into.count("WINDOW_RADIUS", radius, "number of bins to each side of the nearest one");
    }

    fn coat(&self) -> &Coat {
        &self.coat
    }

    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec> {
        let light = (&self.illuminant, self.wavelengths);
        super::uniform_tables(&self.series, false, light, &self.coat, on)
    }

    fn cost(&self) -> Cost {
        let nodes = self.wavelengths.nodes_nm().len();
        Cost::uniform(&self.series, nodes, u64::from(2 * self.window_radius + 1).pow(2))
    }

    /// Errors depend on the share of the window that is summed and on the wavelength step. The texts' step of 5 nm
    /// misses narrow lobes far from the mirror direction (95th percentile 3.8 on rows of pits; 10 on a map under a low
    /// light). A step of 2.5 nm misses hardly any (0.09; 0.13 on the map). With one bin to each side, 2 % of the window
    /// is left out on a scan of 65 µm (2.8).
    fn promise(&self) -> Promise {
        let promise = Promise::of_series(&self.series, false);
        let model = match self.wavelengths.step_nm {
            step_nm if step_nm <= 2.5 && self.tail() <= WHOLE => (0.3, Some(0.5)),
            step_nm if step_nm <= 5.0 => (8.0, None),
            _ => return promise,
        };
        promise.converged(&self.series, self.range_nm(), model)
    }

    fn error_bound(&self) -> Option<ErrorBound> {
        Some(ErrorBound::new(&self.series, Some(self.window_radius), self.tail()))
    }

    fn series(&self) -> Option<&Series> {
        Some(&self.series)
    }

    fn window_radius(&self) -> Option<u32> {
        Some(self.window_radius)
    }

    /// Between narrow lobes there is almost no light, so the share relative to the light there would be large. The
    /// share relative to the lobe's maximum counts where it is smaller.
    fn missed(&self) -> f64 {
        let [x_um, y_um] = self.series.size_um;
        let widest =
            self.range_nm().map(|nm| x_um.max(y_um) / (TAU * window_sigma_um(self.window, nm)));
        let nearest = (f64::from(self.window_radius) + 0.5) / widest[0].max(widest[1]);
        self.tail().min((-nearest * nearest).exp())
    }
}
