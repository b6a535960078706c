//! The inputs of a table.
//!
//! A [`TableSpec`] and the heights of a surface determine everything about a table: its shape, its texels, their
//! meaning, and its name, which is the hash of the `TableSpec`. Texels are computed only from these, so no input can be
//! missing from the name.

use std::f64::consts::TAU;

use glam::DVec3;
use serde::Serialize;

use crate::error::Result;
use crate::hash::{TOOL_VERSION, of_value};
use crate::optics::spectrum::Spectrum;
use crate::plan::{Coherence, CoherenceScaling, Illuminant, TableFormat, Wavelengths, Window};
use crate::surface::HeightField;
use crate::tables::terms::Terms;

use super::cells::{cells_shape, cells_table};
use super::lobes::lobes_table;
use super::orders::{
    EfficiencyAxes, efficiencies_shape, efficiencies_table, moments_shape, moments_table,
};
use super::paths::{
    OrderPaths, colour_paths_shape, colour_paths_table, order_paths_shape, order_paths_table,
};
use super::streaks::{streaks_shape, streaks_table};
use super::{
    Aim, BakedAxes, COEFFICIENTS, LaidExpansion, LobeGeometry, MatterSpec, Series, Settings, Table,
    TermLayers, TermScale, WideAxes, WideLevel, bake, coefficients_shape, coefficients_table,
    colour_format, grating_table, levels_table, rotation_table, spectrum_shape, spectrum_table,
    spreads_table, strongest_period_um, terms_shape,
};

/// A table, described by its inputs. Fields called `surface` are the identity of the heights. They are empty if the
/// table needs no name.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TableSpec {
    /// Terms of the phase function.
    Terms(TermsSpec),
    /// Coefficients of terms, for a basis whose coefficients are not powers.
    Coefficients(CoefficientsSpec),
    /// Colours over `(u, v, w)`.
    Colours(ColoursSpec),
    /// Colours of wider lobes.
    Wide(WideSpec),
    /// Sizes of the tables of wider lobes, and the rotation.
    Spreads(SpreadsSpec),
    /// A spectrum at uniform wavelengths.
    Nodes(NodesSpec),
    /// A spectrum at wavelengths that depend on `|(u, v)|`.
    Levels(LevelsSpec),
    /// Colours of lobes.
    Lobes(LobesSpec),
    /// A grating's period.
    Grating(GratingSpec),
    /// Only the rotation.
    Rotation(RotationSpec),
    /// Efficiencies of orders.
    Efficiencies(EfficienciesSpec),
    /// Moments of a spectrum.
    Moments(MomentsSpec),
    /// Cells of wavelengths for orders under surroundings.
    Streaks(StreaksSpec),
    /// Probabilities of orders and wavelengths.
    OrderPaths(OrderPathsSpec),
    /// Probabilities of `(u, v)`.
    ColourPaths(ColourPathsSpec),
    /// Cells of `(u, v)`.
    Cells(CellsSpec),
}

/// See [`terms_table`](super::terms_table).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermsSpec {
    /// Identity of the heights.
    pub surface: String,
    /// The terms.
    pub series: Series,
    /// Whether shaders read between texels through the linear filter. The table is the same either way, so this is not
    /// part of the identity.
    #[serde(skip)]
    pub filtered: bool,
}

impl TermsSpec {
    /// Hands over the layers, each with its number, one after the other.
    fn layers(
        &self,
        height: &HeightField,
        mut take: impl FnMut(Table, usize) -> Result<()>,
    ) -> Result<()> {
        let series = &self.series;
        let mut layers =
            TermLayers::new(series.bins, series.packing, series.format, series.scale());
        Terms::each(height, series.expansion(), series.bins, series.grid, |term| {
            layers.add(term).map_or(Ok(()), |(layer, index)| take(layer, index))
        })?;
        layers.finish().map_or(Ok(()), |(layer, index)| take(layer, index))
    }
}

/// See [`coefficients_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoefficientsSpec {
    /// Identity of the heights.
    pub surface: String,
    expansion: LaidExpansion,
    /// Columns.
    columns: usize,
    /// Whether shaders take the nearest column. Otherwise they interpolate.
    nearest: bool,
}

impl CoefficientsSpec {
    /// The table of coefficients of a series. `None` if the coefficients are powers.
    pub fn new(surface: &str, series: &Series) -> Option<CoefficientsSpec> {
        series.expansion().is_tabulated().then(|| CoefficientsSpec {
            surface: surface.to_owned(),
            expansion: series.laid().clone(),
            columns: series.coefficient_count(),
            nearest: series.is_prefiltered(),
        })
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    pub(super) fn z_max(&self) -> f64 {
        self.expansion.get().z_max
    }

    pub(super) fn nearest(&self) -> bool {
        self.nearest
    }
}

/// See [`bake`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColoursSpec {
    /// Identity of the heights.
    pub surface: String,
    /// Range of wavelengths, nm.
    pub range_nm: [f64; 2],
    /// The coherence window.
    pub window: Window,
    /// The light.
    #[serde(serialize_with = "Illuminant::serialize_identity")]
    pub illuminant: Illuminant,
    /// Targets for the size.
    pub aim: Aim,
    /// Sizes.
    pub axes: BakedAxes,
    /// What reflectance is in the colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matter: Option<MatterSpec>,
    /// Number format.
    pub format: TableFormat,
    /// As in [`TermsSpec::filtered`].
    #[serde(skip)]
    pub filtered: bool,
}

impl ColoursSpec {
    fn light<'a>(&'a self, range: &'a Wavelengths) -> bake::Light<'a> {
        let matter = self.matter.as_ref().map(MatterSpec::matter);
        bake::Light { window: self.window, range, matter, pooled: false }
    }
}

/// See [`WideAxes`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WideSpec {
    /// Identity of the heights.
    pub surface: String,
    /// Range of wavelengths, nm.
    pub range_nm: [f64; 2],
    /// The light.
    #[serde(serialize_with = "Illuminant::serialize_identity")]
    pub illuminant: Illuminant,
    /// Targets for the size.
    pub aim: Aim,
    /// The levels with their windows, sizes and places.
    pub wide: WideAxes,
    /// What reflectance is in the colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matter: Option<MatterSpec>,
    /// Number format.
    pub format: TableFormat,
    /// As in [`TermsSpec::filtered`].
    #[serde(skip)]
    pub filtered: bool,
}

impl WideSpec {
    fn light<'a>(&'a self, level: &WideLevel, range: &'a Wavelengths) -> bake::Light<'a> {
        let matter = self.matter.as_ref().map(MatterSpec::matter);
        bake::Light { window: level.window, range, matter, pooled: true }
    }

    fn shape(&self) -> Table {
        let ([width, height], layers) = (self.wide.size(), self.wide.layers());
        Table {
            name: "wide",
            binding: COEFFICIENTS,
            format: colour_format(self.format),
            width: width as usize,
            height: height as usize,
            layers: layers as usize,
            filtered: self.filtered,
            texels: Vec::new(),
        }
    }

    /// The texture. Texels of no level are 0.
    fn compute(&self, height: &HeightField, done: &(dyn Fn(usize) + Sync)) -> Result<Table> {
        let shape = self.shape();
        let range = range(self.range_nm);
        let channels = shape.format.channels();
        let mut texels = vec![0.0; shape.texel_count() * channels];
        for level in &self.wide.levels {
            let light = self.light(level, &range);
            let colours = bake::bake(height, light, &self.illuminant, level.axes, done)?;
            let table = bake::table(&bake::sharpen(colours), self.format);
            let [left, top] = level.place.map(|place| place as usize);
            let lines = table.texels.chunks_exact(table.width * channels);
            for (index, line) in lines.enumerate() {
                let (layer, row) = (index / table.height, index % table.height);
                let levels = level.axes.levels as usize;
                // pages stand below one another
                let row = top + layer / levels * table.height + row;
                let start = ((layer % levels * shape.height + row) * shape.width + left) * channels;
                texels[start..start + line.len()].copy_from_slice(line);
            }
        }
        Ok(Table { texels, ..shape })
    }
}

/// The spectrum table of tables with wider lobes. Row 0: for each level [`WideLevel::texel`], then the reflectance at
/// normal incidence. Row 1: the rotation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpreadsSpec {
    /// Rotation of the surface, degrees.
    pub rotate_deg: f64,
    /// The tables.
    pub wide: Box<WideSpec>,
    /// Refractive index of a dielectric in air.
    pub refractive_index: Option<f64>,
    /// Reflectance at normal incidence, which follows from these.
    #[serde(skip)]
    pub normal: f64,
}

/// The inputs of the row of settings of a spectrum table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingsSpec {
    /// Rotation of the surface, degrees.
    pub rotate_deg: f64,
    /// The terms, if they are 16-bit floats: the row contains their scales.
    pub scaled: Option<Box<TermsSpec>>,
    /// Rows about the matter of the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matter: Option<MatterSpec>,
}

impl SettingsSpec {
    /// The settings for a table of terms.
    pub fn new(rotate_deg: f64, terms: &TermsSpec, matter: Option<MatterSpec>) -> SettingsSpec {
        let scaled = terms.series.format == TableFormat::F16;
        SettingsSpec { rotate_deg, scaled: scaled.then(|| Box::new(terms.clone())), matter }
    }

    /// The settings without terms.
    pub fn without_terms(rotate_deg: f64, matter: Option<MatterSpec>) -> SettingsSpec {
        SettingsSpec { rotate_deg, scaled: None, matter }
    }

    fn settings(&self) -> Settings {
        let scale = self.scaled.as_ref().map_or(TermScale::NONE, |terms| terms.series.scale());
        Settings { rotate_deg: self.rotate_deg, scale, matter: self.matter.clone() }
    }

    /// Rows below all others.
    fn rows(&self) -> usize {
        self.matter.as_ref().map_or(0, MatterSpec::rows)
    }
}

/// See [`spectrum_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NodesSpec {
    /// The light.
    #[serde(serialize_with = "Illuminant::serialize_identity")]
    pub illuminant: Illuminant,
    /// The nodes.
    pub wavelengths: Wavelengths,
    /// Row 1.
    pub settings: SettingsSpec,
}

/// See [`levels_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelsSpec {
    /// Identity of the heights. Their range determines the numbers of nodes.
    pub surface: String,
    /// Coherence length, µm. It determines the numbers of nodes, too.
    pub coherence_um: f64,
    /// The light.
    #[serde(serialize_with = "Illuminant::serialize_identity")]
    pub illuminant: Illuminant,
    /// Range of wavelengths, nm.
    pub range_nm: [f64; 2],
    /// Number of nodes at every level.
    pub counts: Vec<u32>,
    /// Least number of columns, for the rows about the matter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<usize>,
    /// Row 1.
    pub settings: SettingsSpec,
}

/// See [`lobe_table`](super::lobe_table).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LobesSpec {
    /// Identity of the heights. Their range determines the sizes.
    pub surface: String,
    /// The light.
    #[serde(serialize_with = "Illuminant::serialize_identity")]
    pub illuminant: Illuminant,
    /// Range of wavelengths, nm.
    pub range_nm: [f64; 2],
    /// How the width of lobes depends on the wavelength. The colours of lobes do not depend on the coherence length itself.
    pub coherence_scaling: CoherenceScaling,
    /// Number of nodes of broad lobes; 1 for a single wavelength.
    pub nodes: u32,
    /// Number of columns and rows of narrow lobes.
    pub narrow: [u32; 2],
    /// Row 1.
    pub settings: SettingsSpec,
}

impl LobesSpec {
    /// The geometry of lobes for a coherence length of 1 µm and a patch of 1 µm. Colours depend only on ratios.
    pub(super) fn geometry(&self) -> LobeGeometry {
        let window = Window {
            coherence_um: 1.0,
            coherence: Coherence::Single,
            coherence_scaling: self.coherence_scaling,
        };
        LobeGeometry::new(window, &self.range(), [1.0; 2])
    }

    fn range(&self) -> Wavelengths {
        range(self.range_nm)
    }
}

/// See [`grating_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GratingSpec {
    /// Identity of the heights and their rotation.
    pub surface: String,
    /// Rotation of the surface, degrees.
    pub rotate_deg: f64,
}

/// See [`rotation_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RotationSpec {
    /// Rotation of the surface, degrees.
    pub rotate_deg: f64,
}

/// See [`efficiencies_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EfficienciesSpec {
    /// Identity of the heights.
    pub surface: String,
    /// Sizes.
    pub axes: EfficiencyAxes,
}

/// See [`moments_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MomentsSpec {
    /// The light.
    #[serde(serialize_with = "Illuminant::serialize_identity")]
    pub illuminant: Illuminant,
    /// Range of wavelengths, nm.
    pub range_nm: [f64; 2],
}

/// See [`streaks_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StreaksSpec {
    /// The light.
    #[serde(serialize_with = "Illuminant::serialize_identity")]
    pub illuminant: Illuminant,
    /// Range of wavelengths, nm.
    pub range_nm: [f64; 2],
    /// Number of cells.
    pub cells: u32,
}

/// See [`order_paths_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderPathsSpec {
    /// Identity of the heights.
    pub surface: String,
    /// The light.
    #[serde(serialize_with = "Illuminant::serialize_identity")]
    pub illuminant: Illuminant,
    /// What else probabilities depend on.
    pub of: OrderPaths,
}

/// See [`colour_paths_table`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColourPathsSpec {
    /// A table of colours that is coarser than that of the shader.
    pub colours: ColoursSpec,
}

/// The directions in which a compiled cubature asks for the surroundings, and the weights of their light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellsSpec {
    /// A table of colours with lobes that are wide enough for its sizes.
    pub colours: ColoursSpec,
    /// Number of cells.
    pub count: u32,
    /// Standard deviation of these lobes, in direction cosines.
    #[serde(skip)]
    pub lobe_sigma: f64,
    /// Index of the dielectric, whose reflectance is not in the colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refractive_index: Option<f64>,
    /// Reflectance at normal incidence.
    #[serde(skip)]
    pub normal: f64,
}

impl CellsSpec {
    /// Bakes the colours under red, green and blue light, and divides them.
    fn compute(&self, height: &HeightField, done: &(dyn Fn(usize) + Sync)) -> Result<Table> {
        let spec = &self.colours;
        let range = range(spec.range_nm);
        let light = bake::Light { pooled: true, ..spec.light(&range) };
        let white = Spectrum::new(&spec.illuminant)?;
        let colours = [DVec3::X, DVec3::Y, DVec3::Z].map(|primary| {
            let spectrum = white.clone().tinted(primary);
            bake::bake_under(height, light, &spectrum, spec.axes, done)
        });
        let unit = self.normal / (TAU * self.lobe_sigma * self.lobe_sigma);
        Ok(cells_table(&colours, self.count, unit))
    }
}

impl TableSpec {
    /// The name: the name of the binding, and a hash of this value and the tool's version.
    pub fn id(&self) -> String {
        let value = serde_json::json!([TOOL_VERSION, self]);
        format!("{}-{}", self.shape().name, &of_value(&value)[..12])
    }

    /// The table without its texels.
    pub fn shape(&self) -> Table {
        match self {
            TableSpec::Terms(TermsSpec { series, filtered, .. }) => {
                let terms = series.terms() as usize;
                let shape = terms_shape(series.bins, terms, series.packing, series.format);
                Table { filtered: *filtered, ..shape }
            }
            TableSpec::Coefficients(spec) => {
                coefficients_shape(spec.expansion.get().terms, spec.columns)
            }
            TableSpec::Colours(spec) => {
                Table { filtered: spec.filtered, ..bake::shape(&spec.axes, spec.format) }
            }
            TableSpec::Wide(spec) => spec.shape(),
            TableSpec::Spreads(spec) => spectrum_shape(spec.wide.wide.levels.len() + 1, 2),
            TableSpec::Nodes(spec) => {
                spectrum_shape(spec.wavelengths.nodes_nm().len(), 2 + spec.settings.rows())
            }
            TableSpec::Levels(spec) => {
                let widest = spec.counts.iter().copied().max().unwrap_or(1) as usize;
                let columns = widest.max(spec.columns.unwrap_or(1));
                spectrum_shape(columns, spec.counts.len() + 1 + spec.settings.rows())
            }
            TableSpec::Lobes(LobesSpec { narrow: [columns, rows], settings, .. }) => {
                spectrum_shape(*columns as usize, 2 + 2 * *rows as usize + settings.rows())
            }
            TableSpec::Grating(_) | TableSpec::Rotation(_) => spectrum_shape(1, 2),
            TableSpec::Efficiencies(spec) => efficiencies_shape(&spec.axes),
            TableSpec::Moments(spec) => moments_shape(spec.range_nm),
            TableSpec::Streaks(spec) => streaks_shape(spec.cells),
            TableSpec::OrderPaths(spec) => order_paths_shape(&spec.of),
            TableSpec::ColourPaths(_) => colour_paths_shape(),
            TableSpec::Cells(spec) => cells_shape(spec.count, spec.colours.axes.levels),
        }
    }

    /// Whether the table takes so long to compute that it is cached.
    pub fn is_expensive(&self) -> bool {
        matches!(
            self,
            TableSpec::Terms(_) | TableSpec::Colours(_) | TableSpec::Wide(_) | TableSpec::Cells(_)
        )
    }

    /// Number of columns that [`TableSpec::compute_with`] reports in all.
    pub fn columns(&self) -> usize {
        match self {
            TableSpec::Colours(spec) => spec.axes.columns as usize,
            TableSpec::Wide(spec) => {
                spec.wide.levels.iter().map(|level| level.axes.columns as usize).sum()
            }
            TableSpec::Cells(spec) => 3 * spec.colours.axes.columns as usize,
            _ => 0,
        }
    }

    /// The table with its texels, unrounded. `height` must be the heights that its name refers to.
    pub fn compute(&self, height: &HeightField) -> Result<Table> {
        self.compute_with(height, &|_| ())
    }

    /// The bytes of the rounded table, as in its `.bin`, with progress as in [`TableSpec::compute_with`]. Of a table of terms, only
    /// a few terms and the bytes are in memory at a time.
    pub fn bytes_with(
        &self,
        height: &HeightField,
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<u8>> {
        let TableSpec::Terms(spec) = self else {
            return Ok(self.compute_with(height, done)?.bytes());
        };
        let mut bytes = Vec::with_capacity(self.shape().byte_count());
        spec.layers(height, |layer, index| {
            layer.check_from(index)?;
            bytes.extend(layer.bytes());
            Ok(())
        })?;
        Ok(bytes)
    }

    /// Bytes that [`TableSpec::bytes_with`] takes at most, beside the heights: an estimate. `threads`: how many work on it.
    pub fn working_bytes(&self, height: &HeightField, threads: usize) -> u64 {
        let shape = self.shape();
        let table = shape.byte_count() as u64;
        let texels = self.texel_bytes();
        match self {
            TableSpec::Terms(TermsSpec { series, .. }) => {
                let layer = texels / shape.layers.max(1) as u64;
                let terms =
                    Terms::working_bytes(height, series.expansion(), series.bins, series.grid);
                table + layer + terms
            }
            TableSpec::Colours(spec) => {
                let range = range(spec.range_nm);
                let sizes = [texels, table];
                bake::working_bytes(height, spec.light(&range), spec.axes, sizes, threads)
            }
            TableSpec::ColourPaths(ColourPathsSpec { colours }) => {
                TableSpec::Colours(colours.clone()).working_bytes(height, threads)
            }
            TableSpec::Cells(spec) => {
                let range = range(spec.colours.range_nm);
                let axes = spec.colours.axes;
                let sizes = [texels, table];
                let light = spec.colours.light(&range);
                // the colours under two lights are kept
                let kept =
                    24 * u64::from(axes.columns) * u64::from(axes.rows) * u64::from(axes.levels);
                kept + bake::working_bytes(height, light, axes, sizes, threads)
            }
            TableSpec::Wide(spec) => {
                let range = range(spec.range_nm);
                let of = |level: &WideLevel| {
                    let light = spec.light(level, &range);
                    let sizes = [texels, table];
                    bake::working_bytes(height, light, level.axes, sizes, threads)
                };
                texels + spec.wide.levels.iter().map(of).max().unwrap_or(table)
            }
            _ => texels + table,
        }
    }

    /// Bytes of the table as [`Table::texels`] has it.
    pub fn texel_bytes(&self) -> u64 {
        let shape = self.shape();
        (size_of::<f64>() * shape.format.channels() * shape.texel_count()) as u64
    }

    /// [`TableSpec::compute`] with progress: `done` is called with the columns of a table of colours
    /// that were finished since the last call, from any thread.
    pub fn compute_with(
        &self,
        height: &HeightField,
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<Table> {
        let table = match self {
            TableSpec::Terms(spec) => {
                let shape = self.shape();
                let mut texels = Vec::with_capacity(shape.texel_count() * shape.format.channels());
                spec.layers(height, |layer, _| {
                    texels.extend(layer.texels);
                    Ok(())
                })?;
                Table { texels, ..shape }
            }
            TableSpec::Coefficients(spec) => coefficients_table(spec.expansion.get(), spec.columns),
            TableSpec::Colours(spec) => {
                let range = range(spec.range_nm);
                let light = spec.light(&range);
                let colours = bake::bake(height, light, &spec.illuminant, spec.axes, done)?;
                let table = bake::table(&bake::sharpen(colours), spec.format);
                Table { filtered: spec.filtered, ..table }
            }
            TableSpec::Wide(spec) => spec.compute(height, done)?,
            TableSpec::Spreads(spec) => {
                let levels = spec.wide.wide.levels.iter().map(WideLevel::texel);
                let texels = levels.chain([[spec.normal, 0.0, 0.0, 0.0]]).collect();
                spreads_table(texels, spec.rotate_deg)
            }
            TableSpec::Nodes(spec) => {
                let samples = Spectrum::new(&spec.illuminant)?.samples(&spec.wavelengths);
                spectrum_table(&samples, spec.settings.settings())
            }
            TableSpec::Levels(spec) => {
                let spectrum = Spectrum::new(&spec.illuminant)?;
                let levels = spectrum.warped_samples(&range(spec.range_nm), &spec.counts);
                levels_table(&levels, spec.columns.unwrap_or(1), spec.settings.settings())
            }
            TableSpec::Lobes(spec) => lobes(spec)?,
            TableSpec::Grating(spec) => {
                // a surface without a period does not have this table
                let period_um = strongest_period_um(height).unwrap_or_default();
                grating_table(period_um, spec.rotate_deg)
            }
            TableSpec::Rotation(spec) => rotation_table(spec.rotate_deg),
            TableSpec::Efficiencies(spec) => efficiencies_table(height, &spec.axes),
            TableSpec::Moments(spec) => {
                moments_table(&Spectrum::new(&spec.illuminant)?, spec.range_nm)
            }
            TableSpec::Streaks(spec) => {
                streaks_table(&Spectrum::new(&spec.illuminant)?, spec.range_nm, spec.cells)
            }
            TableSpec::OrderPaths(spec) => {
                order_paths_table(height, &Spectrum::new(&spec.illuminant)?, &spec.of)
            }
            TableSpec::ColourPaths(ColourPathsSpec { colours: spec }) => {
                let range = range(spec.range_nm);
                let light = spec.light(&range);
                let colours = bake::bake(height, light, &spec.illuminant, spec.axes, done)?;
                colour_paths_table(&colours)
            }
            TableSpec::Cells(spec) => spec.compute(height, done)?,
        };
        table.check()?;
        Ok(table)
    }
}

fn lobes(spec: &LobesSpec) -> Result<Table> {
    let settings = spec.settings.settings();
    let spectrum = Spectrum::new(&spec.illuminant)?;
    let samples = spectrum.wavenumber_samples(&spec.range());
    if spec.nodes == 1 {
        return Ok(spectrum_table(&samples, settings));
    }
    Ok(lobes_table(&samples, &spec.geometry(), spec.nodes, spec.narrow, settings))
}

/// A range of wavelengths, with any step.
fn range([min_nm, max_nm]: [f64; 2]) -> Wavelengths {
    Wavelengths { min_nm, max_nm, step_nm: (max_nm - min_nm).max(1.0) }
}
