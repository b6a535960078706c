//! `adaptive` on the bins of the patch: a sum over the lobes that the wavelengths of a direction cross.

use crate::defines::Defines;
use crate::error::{Error, Result};
use crate::plan::{Coherence, Illuminant, Variant, Window};
use crate::surface::HeightField;
use crate::tables::{
    BROADEST, CoefficientsSpec, Corridor, LobeGeometry, LobesSpec, MatterSpec, OUTER_NODES,
    REACH_SIGMAS, Reach, Series, SettingsSpec, TableSpec, TermsSpec,
};
use crate::variant::cost::{mean_and_worst, spectrum_bytes};
use crate::variant::tolerance::Promise;
use crate::variant::{Coat, Computation, Cost, ErrorBound, Ground, ISOLATED, LobeBounds, lay};

/// Numbers of a sum over lobes, however the intensities of its bins are computed.
#[derive(Clone, Debug, PartialEq)]
pub struct LobeSum {
    /// Size of the patch, µm.
    pub patch_um: [f64; 2],
    /// Positions and widths of lobes.
    pub geometry: LobeGeometry,
    /// Bounds of the loops.
    pub corridor: Corridor,
    /// The coherence window.
    pub window: Window,
    /// Range of wavelengths, nm.
    pub range_nm: [f64; 2],
    /// The light.
    pub illuminant: Illuminant,
    /// What the surface is made of.
    pub coat: Coat,
}

impl LobeSum {
    /// It is an error if neighbouring lobes overlap and interfere. `most`: the greatest period and depth of a texel, relative to those
    /// of the surface, for which loops are bounded.
    pub(super) fn new(
        variant: &Variant,
        height: &HeightField,
        coat: Coat,
        most: [f64; 2],
    ) -> Result<LobeSum> {
        let window = Window::from(&variant.optics);
        let patch_um = lay::patch_um(height);
        let widest_um = patch_um.map(|um| um * most[0]);
        let geometry = LobeGeometry::new(window, &variant.wavelengths, widest_um);
        check_isolated(variant, &geometry)?;
        let detail_um = coat.matter.detail_um(lay::height_range_um(height) * most[1]);
        let mut corridor = geometry.corridor(detail_um);
        if corridor.nodes > 1 {
            // the rows about the matter have the same columns
            corridor.columns = corridor.columns.max(coat.columns(variant)? as u32);
        }
        Ok(LobeSum {
            patch_um,
            corridor,
            geometry,
            window,
            range_nm: lay::range_nm(variant),
            illuminant: variant.optics.illuminant.clone(),
            coat,
        })
    }

    /// Constants of the template `adaptive`.
    pub(super) fn define(&self, wavelengths: usize, into: &mut Defines) {
        super::define_window(self.window, into);
        super::define_patch(self.patch_um, into);
        into.flag("MONOCHROMATIC", wavelengths == 1);
        into.number(
            "BROADEST",
            BROADEST,
            "width of the broadest narrow lobe, in distances between nodes",
        );
        let reach = "reach of a lobe, in standard deviations of the window's spectrum";
        into.number("REACH_SIGMAS", REACH_SIGMAS, reach);
        let outer = "number of nodes beyond each end of the range of wavenumbers";
        into.count("OUTER_NODES", OUTER_NODES as usize, outer);
        let Corridor { candidates, columns, rows, minors, node_bins, nodes, .. } = self.corridor;
        into.count(
            "CANDIDATE_COUNT",
            candidates as usize,
            "maximum number of bins that are examined",
        );
        into.count(
            "LOBE_COLUMNS",
            columns as usize,
            "number of columns of the table of narrow lobes",
        );
        into.count("LOBE_ROWS", rows as usize, "number of widths in the table of narrow lobes");
        into.count("MINOR_COUNT", minors as usize, "number of bins across the strip");
        into.count("NODE_BINS", node_bins as usize, "number of columns of bins about a node");
        // a single wavelength is one node
        let nodes = (nodes as usize).min(wavelengths);
        into.count("NODE_COUNT", nodes, "number of nodes, those beyond the range included");
        self.coat.define(wavelengths, 2 + 2 * rows as usize, into);
        into.number("WAVELENGTH_MAX_UM", self.range_nm[1] * 1e-3, "longest wavelength, µm");
    }

    /// The table of the colours of lobes.
    pub(super) fn table(&self, surface: &str, settings: SettingsSpec) -> TableSpec {
        TableSpec::Lobes(LobesSpec {
            surface: surface.to_owned(),
            illuminant: self.illuminant.clone(),
            range_nm: self.range_nm,
            coherence_scaling: self.window.coherence_scaling,
            nodes: self.corridor.nodes,
            narrow: [self.corridor.columns, self.corridor.rows],
            settings,
        })
    }

    /// Cost of evaluations that read `terms` texels of the largest table and `others` of the others. `bytes`: of all tables but
    /// that of lobes.
    pub(super) fn cost(&self, terms: u64, others: u64, bytes: u64) -> Cost {
        let evaluations = mean_and_worst(|uv| evaluations(&self.geometry, &self.corridor, uv));
        let Corridor { columns, rows, .. } = self.corridor;
        let below = self.coat.rows.as_ref().map_or(0, MatterSpec::rows) as u64;
        let bytes = bytes + spectrum_bytes(u64::from(columns), u64::from(2 * rows + 2) + below);
        // two neighbouring texels of colours
        Cost::of_evaluations(evaluations, terms, others + 2, bytes)
    }

    pub(super) fn bounds(&self) -> LobeBounds {
        let [x, y] = self.geometry.sigma_bins();
        let single = self.window.coherence == Coherence::Single;
        LobeBounds {
            candidates: self.corridor.candidates,
            overlap: x.max(y),
            overlap_limit: single.then_some(ISOLATED),
        }
    }
}

/// Numbers of the form.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobes {
    /// The sum over lobes.
    pub sum: LobeSum,
    /// The terms.
    pub series: Series,
    cost: Cost,
}

impl Lobes {
    pub(in crate::variant) fn new(variant: &Variant, height: &HeightField) -> Result<Lobes> {
        let sum = LobeSum::new(variant, height, Coat::new(variant)?, [1.0; 2])?;
        let expansion = lay::expansion(variant, height, &sum.coat.matter)?;
        let (patch_um, window, range_nm) = (sum.patch_um, sum.window, sum.range_nm);
        let Window { coherence_um, coherence_scaling, .. } = window;
        let reach = Reach::Corridor { coherence_um, coherence_scaling, max_nm: range_nm[1] };
        let bins = lay::bins(patch_um, range_nm[0], sum.corridor.margin.map(|m| m as usize));
        let texels = (variant.packing, variant.table);
        let series = Series::new(expansion, reach, bins, None, patch_um, texels);
        // two neighbouring texels of every row of coefficients
        let others = 2 * u64::from(series.coefficient_rows());
        let cost = sum.cost(u64::from(series.layers()), others, series.byte_count());
        Ok(Lobes { sum, series, cost })
    }
}

/// Returns an error if amplitudes of neighbouring bins interfere, because the form adds intensities.
fn check_isolated(variant: &Variant, geometry: &LobeGeometry) -> Result<()> {
    let [x, y] = geometry.sigma_bins();
    let widest = x.max(y);
    if variant.optics.coherence == Coherence::Ensemble || widest <= ISOLATED {
        return Ok(());
    }
    let cause =
        format!("neighbouring lobes overlap and interfere: σf·L = {widest:.2} is above {ISOLATED}");
    Err(Error::new(&variant.name, cause).remedy(
        "use reconstruction = \"prefiltered\", coherence = \"ensemble\", or mode = \"full\"",
    ))
}

/// Number of evaluations: bins that the wavelengths of a direction cross.
fn evaluations(geometry: &LobeGeometry, corridor: &Corridor, uv: [f64; 2]) -> u64 {
    let breadth = geometry.breadth(uv, corridor.nodes);
    if breadth < 1.0 {
        let row = (breadth * (f64::from(corridor.rows) - 1.0) + 0.5) as u32;
        let sides = if LobeGeometry::is_halved(row, corridor.rows) { 2 } else { 1 };
        return sides * geometry.bins(uv).len() as u64;
    }
    (0..corridor.nodes).map(|node| geometry.node_bins(uv, node, corridor.nodes)).sum()
}

impl Computation for Lobes {
    fn define(&self, wavelengths: usize, into: &mut Defines) {
        self.series.define(into);
        self.sum.define(wavelengths, into);
    }

    fn coat(&self) -> &Coat {
        &self.sum.coat
    }

    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec> {
        let terms = TermsSpec {
            surface: on.surface.to_owned(),
            series: self.series.clone(),
            filtered: false,
        };
        let lobes = self.sum.table(
            on.surface,
            SettingsSpec::new(on.rotate_deg, &terms, self.sum.coat.rows.clone()),
        );
        let coefficients = CoefficientsSpec::new(on.surface, &self.series);
        let tables = [TableSpec::Terms(terms), lobes];
        tables.into_iter().chain(coefficients.map(TableSpec::Coefficients)).collect()
    }

    fn cost(&self) -> Cost {
        self.cost
    }

    /// No lobe is missed. The remaining error comes from evaluating the intensity only once or twice in a lobe (95th
    /// percentile 0.3 on a grating, 0.03 on scans, 0.13 on their maps).
    fn promise(&self) -> Promise {
        let promise = Promise::of_series(&self.series, false);
        promise.converged(&self.series, self.sum.range_nm, (0.5, Some(0.25)))
    }

    fn error_bound(&self) -> Option<ErrorBound> {
        // share of a Gaussian beyond four standard deviations of its square root
        Some(ErrorBound::new(&self.series, None, libm::erfc(REACH_SIGMAS)))
    }

    fn lobe_bounds(&self) -> Option<LobeBounds> {
        Some(self.sum.bounds())
    }

    fn series(&self) -> Option<&Series> {
        Some(&self.series)
    }
}
