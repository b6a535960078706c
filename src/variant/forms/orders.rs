//! `orders`: the sum over the orders of a cell that has few of them, under single directions and under lights with a size.

use crate::defines::Defines;
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};

use crate::optics::spectrum::Spectrum;
use crate::plan::{Auto, LightFunction, Variant};
use crate::surface::HeightField;
use crate::tables::orders::{EfficiencyAxes, MOMENT_HEIGHT, moment_columns};
use crate::tables::paths::{FLOOR, OrderPaths, order_paths_shape, wavelength_cells};
use crate::tables::streaks::{LONG_CPUM, streaks_table};
use crate::tables::{
    EfficienciesSpec, MomentsSpec, OrderPathsSpec, SettingsSpec, StreaksSpec, TableSpec,
};
use crate::variant::define_surroundings;
use crate::variant::judge::Light;
use crate::variant::tolerance::{Promise, is_visible};
use crate::variant::twin::arrivals;
use crate::variant::{
    Coat, Computation, Cost, Function, Ground, LobeBounds, Pattern, functions_of, lay, nodes_for,
};

use super::LobeSum;

/// Maximum number of orders. Each is a row of a table, and a pixel examines all that may meet its light.
const MAX_ORDERS: usize = 1024;
/// Maximum number of columns of the table of efficiencies: every profile allows textures of this size.
const MAX_COLUMNS: u32 = 2048;
/// Maximum number of wavelengths of all orders under surroundings: OpenGL of llvmpipe ends the loops of a shader after
/// 65,535 steps in all.
const MAX_CELLS: usize = 1 << 15;
/// Maximum phase from the lowest to the highest point, over which the share of an order is one cubic. Through four nodes of
/// Chebyshev the cubic errs by half of this to the fourth power, divided by 192.
const PANEL_PHASE: f64 = 2.0;
/// Maximum arc of the light's direction over which the share of an order is one cubic, radians.
const PANEL_ARC: f64 = 0.75;

/// Numbers of the form.
#[derive(Clone, Debug, PartialEq)]
pub struct Orders {
    /// The sum under light from a single direction.
    pub sum: LobeSum,
    /// The orders, and sizes of their table.
    pub axes: EfficiencyAxes,
    functions: Vec<LightFunction>,
    /// Whether functions have an argument for a pattern.
    pub has_pattern: bool,
    /// Least and greatest depth of a texel, relative to that of the surface.
    depth_ratio: [f64; 2],
    /// Number of cubics per 1/µm of wavenumber that the reflectance needs; 0 where it does not depend on the wavelength.
    pub panel_pace: f64,
    /// Number of cells of wavelengths of an order under surroundings; 0 without the function for them.
    pub nodes: u32,
    /// Edges of these cells, µm.
    edges_um: Vec<f64>,
    cost: Cost,
}

impl Orders {
    pub(in crate::variant) fn new(variant: &Variant, height: &HeightField) -> Result<Orders> {
        Light::new(variant)?;
        let coat = Coat::new(variant)?;
        // the surface as it is can always be evaluated
        let most = match variant.pattern {
            true => [variant.period_ratio, variant.depth_ratio].map(|ratio| ratio[1].max(1.0)),
            false => [1.0; 2],
        };
        let [most_period, _] = most;
        let axes = EfficiencyAxes::new(height, lay::range_nm(variant), &coat.matter, most);
        let fail = |cause: String| Err(Error::new(&variant.name, cause));
        let (orders, columns) = (axes.bins.len(), axes.columns);
        if orders > MAX_ORDERS {
            let cause = format!(
                "{orders} orders of the cell of {:.3} × {:.3} µm can propagate, above {MAX_ORDERS}",
                most_period * height.size_x_um(),
                most_period * height.size_y_um()
            );
            let remedy =
                "mode = \"orders\" is for gratings and other small cells; use adaptive or baked";
            return fail(cause).map_err(|error| error.remedy(remedy));
        }
        if columns > MAX_COLUMNS {
            let cause =
                format!("the heights need {columns} columns of efficiencies, above {MAX_COLUMNS}");
            return fail(cause).map_err(|error| error.remedy("check the unit of the heights"));
        }
        let sum = LobeSum::new(variant, height, coat, most)?;
        let functions = variant.lights.clone();
        let sized = functions != [LightFunction::Direction];
        let panel_pace = if sized { sum.coat.panel_pace(variant)? } else { 0.0 };
        let nodes = match (functions.contains(&LightFunction::Environment), variant.nodes) {
            (false, _) => 0,
            (true, Auto::Value(nodes)) => nodes,
            (true, Auto::Auto) => nodes_for(variant.environment_error),
        };
        if 2 * orders * nodes as usize > MAX_CELLS {
            let cause = format!(
                "{orders} orders with up to {} wavelengths each are {} look-ups under surroundings, above {MAX_CELLS}",
                2 * nodes,
                2 * orders * nodes as usize
            );
            let remedy = "use fewer nodes, or lights without \"environment\"";
            return fail(cause).map_err(|error| error.remedy(remedy));
        }
        let edges_um = match nodes {
            0 => Vec::new(),
            _ => {
                let spectrum = Spectrum::new(&sum.illuminant)?;
                let table = streaks_table(&spectrum, sum.range_nm, nodes);
                (0..table.width as i64).map(|column| table.load(column, 1, 0)[3]).collect()
            }
        };
        let cost = Cost::default();
        let (has_pattern, depth_ratio) = match variant.pattern {
            true => (true, variant.depth_ratio),
            false => (false, [1.0; 2]),
        };
        let mut form = Orders {
            sum,
            axes,
            functions,
            has_pattern,
            depth_ratio,
            panel_pace,
            nodes,
            edges_um,
            cost,
        };
        let moments = if form.has_lamps() { MOMENT_HEIGHT * form.moment_columns() } else { 0 };
        let streaks = 3 * form.edges_um.len();
        let paths = match form.has(LightFunction::Path) {
            true => order_paths_shape(&form.paths()).texel_count(),
            false => 0,
        };
        let bytes = (orders * columns as usize + moments + streaks + paths) as u64 * 16;
        form.cost = form.sum.cost(1, 0, bytes);
        Ok(form)
    }

    /// Number of columns of the table of moments.
    pub fn moment_columns(&self) -> usize {
        moment_columns(self.sum.range_nm)
    }

    /// Shortest and longest wavelength, µm.
    pub fn wavelengths_um(&self) -> [f64; 2] {
        self.sum.range_nm.map(|nm| nm * 1e-3)
    }

    /// Columns of efficiencies over which the share of an order is one cubic.
    pub fn panel_columns(&self) -> f64 {
        EfficiencyAxes::columns_of(PANEL_PHASE)
    }

    /// Maximum arc of the light's direction over which the share of an order is one cubic, radians.
    pub fn panel_arc(&self) -> f64 {
        PANEL_ARC
    }

    /// Maximum number of panels of an order: the deepest heights at all wavelengths, or a half circle.
    pub fn panels(&self) -> usize {
        let deepest = f64::from(self.axes.columns) / self.panel_columns();
        let [low, high] = self.wavelengths_um();
        let coloured = self.panel_pace * (1.0 / low - 1.0 / high);
        (2.0 * deepest).max(2.0 / PANEL_ARC).max(coloured) as usize + 1
    }

    /// Number of look-ups of the surroundings for the orders that do not mirror, towards a viewer; at most.
    pub fn streak_lookups(&self, wr: DVec3) -> u64 {
        let [x, y] = [self.axes.bins.r_max, self.axes.bins.s_max].map(|reach| reach as i32);
        let mut count = 0;
        for row in -y..=y {
            for column in (-x..=x).filter(|column| row != 0 || *column != 0) {
                let order = DVec2::new(f64::from(column), f64::from(row));
                let frequency = arrivals::order_frequency(self, order);
                let [low, high] = arrivals::propagating(self, frequency, wr);
                let meets = |cell: &&[f64]| cell[0].max(low) < cell[1].min(high);
                let (first, cells) = self.streak_cells(frequency);
                let cells = self.edges_um.windows(2).skip(first as usize).take(cells as usize);
                count += cells.filter(meets).count() as u64;
            }
        }
        count
    }

    /// First column and number of the cells of an order in the table of streaks.
    pub fn streak_cells(&self, frequency: DVec2) -> (i64, i64) {
        let cells = i64::from(self.nodes);
        if frequency.length() > LONG_CPUM { (cells + 1, 2 * cells) } else { (0, cells) }
    }

    /// What the probabilities of paths depend on.
    pub fn paths(&self) -> OrderPaths {
        let (least, most) = self.sum.coat.matter.w_span(0.0, 2.0);
        OrderPaths {
            bins: self.axes.bins,
            range_nm: self.sum.range_nm,
            steepness: [least * self.depth_ratio[0], most * self.depth_ratio[1]],
            floor: FLOOR,
            averaged: [16, 8],
        }
    }

    /// The form of a texel: its orders and its phases. The angle is the caller's.
    #[must_use]
    pub fn patterned(&self, pattern: &Pattern) -> Orders {
        let mut form = self.clone();
        form.sum.patch_um = self.sum.patch_um.map(|um| um * pattern.period_ratio);
        form.axes.covered_um = Some(self.axes.phase_min_um() * pattern.depth_ratio);
        form
    }

    fn has(&self, light: LightFunction) -> bool {
        self.functions.contains(&light)
    }

    fn has_lamps(&self) -> bool {
        self.has(LightFunction::Disc) || self.has(LightFunction::Polygon)
    }
}

impl Computation for Orders {
    fn define(&self, wavelengths: usize, into: &mut Defines) {
        self.sum.define(wavelengths, into);
        let (disc, rectangle) = (self.has(LightFunction::Disc), self.has(LightFunction::Polygon));
        into.flag("DISC", disc);
        into.flag("RECTANGLE", rectangle);
        let environment = self.has(LightFunction::Environment);
        into.flag("LAMPS", self.has_lamps());
        into.flag("ENVIRONMENT", environment);
        let path = self.has(LightFunction::Path);
        into.flag("PATH", path);
        into.flag("OUTWARD", environment || path);
        into.flag("PATTERN", self.has_pattern);
        into.flag("SIZED", self.has_lamps() || environment || path || self.has_pattern);
        let edges = "number of cells of wavelengths in the table of paths";
        into.count("PATH_CELLS", wavelength_cells(self.sum.range_nm), edges);
        let long =
            "frequency of an order, cycles per µm, above which it has twice as many wavelengths";
        into.number("LONG_CPUM", LONG_CPUM, long);
        into.count("STREAK_CELLS", self.nodes as usize, "number of wavelengths per order");
        define_surroundings(into);
        let shortest = "shortest wavelength, µm";
        into.number("WAVELENGTH_MIN_UM", self.axes.min_um, shortest);
        let covered = "wavelength in air whose greatest phase per height is the greatest here, µm";
        into.number("PHASE_MIN_UM", self.axes.phase_min_um(), covered);
        let pace = "number of cubics per 1/µm of wavenumber that the reflectance needs";
        into.number("PANEL_PACE", self.panel_pace, pace);
        let columns = "number of columns of the table of efficiencies";
        into.count("EFFICIENCY_COLUMNS", self.axes.columns as usize, columns);
        let orders = "number of orders";
        into.count("ORDER_COUNT", self.axes.bins.len(), orders);
        let [x, y] = ["largest order along x that can propagate", "largest order along y"];
        into.count("ORDER_REACH_X", self.axes.bins.r_max, x);
        into.count("ORDER_REACH_Y", self.axes.bins.s_max, y);
        let moments = "number of columns of the table of moments";
        into.count("MOMENT_COLUMNS", self.moment_columns(), moments);
        let panels = "maximum number of cubics for an order";
        into.count("PANEL_COUNT", self.panels(), panels);
        let arc = "maximum change of the light's direction for one cubic";
        into.number("PANEL_ARC", PANEL_ARC, arc);
        let wide = "maximum number of columns of efficiencies for one cubic";
        into.number("PANEL_COLUMNS", self.panel_columns(), wide);
    }

    fn coat(&self) -> &Coat {
        &self.sum.coat
    }

    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec> {
        let surface = on.surface.to_owned();
        let efficiencies = EfficienciesSpec { surface, axes: self.axes };
        let lobes = self.sum.table(
            on.surface,
            SettingsSpec::without_terms(on.rotate_deg, self.sum.coat.rows.clone()),
        );
        let (illuminant, range_nm) = (self.sum.illuminant.clone(), self.sum.range_nm);
        let mut tables = vec![TableSpec::Efficiencies(efficiencies), lobes];
        if self.has_lamps() {
            let illuminant = illuminant.clone();
            tables.push(TableSpec::Moments(MomentsSpec { illuminant, range_nm }));
        }
        if self.nodes > 0 {
            let cells = self.nodes;
            let illuminant = illuminant.clone();
            tables.push(TableSpec::Streaks(StreaksSpec { illuminant, range_nm, cells }));
        }
        if self.has(LightFunction::Path) {
            let surface = on.surface.to_owned();
            let spec = OrderPathsSpec { surface, illuminant, of: self.paths() };
            tables.push(TableSpec::OrderPaths(spec));
        }
        tables
    }

    fn cost(&self) -> Cost {
        self.cost
    }

    /// As for the sum over lobes of a series, whose terms these efficiencies replace.
    fn promise(&self) -> Promise {
        let model = is_visible(self.sum.range_nm).then_some((0.5, Some(0.25)));
        Promise::comparator().with_model(model)
    }

    fn functions(&self) -> Vec<&'static dyn Function> {
        self.functions.iter().flat_map(|word| functions_of(*word)).collect()
    }

    fn lobe_bounds(&self) -> Option<LobeBounds> {
        Some(self.sum.bounds())
    }
}
