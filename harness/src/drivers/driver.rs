//! What all drivers share: the pictures that they draw, the tables, and the meaning of the pixels.

use std::cell::RefCell;
use std::ops::Range;

use diffraction_shaders::diagnostic::Diagnostic;
use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::light::{Filtered, Light, Sky};
use diffraction_shaders::optics::brdf_map::{BrdfMap, view_direction};
use diffraction_shaders::optics::colour::from_rgb;
use diffraction_shaders::runner::{Placement, Progress, Runner, has_wavelengths, lit_by};
use diffraction_shaders::shader::module::Module;
use diffraction_shaders::shader::specialise;
use diffraction_shaders::shader::template::Sources;
use diffraction_shaders::tables::{
    COEFFICIENTS, DIRECTIONS, ENVIRONMENT, PATHS, SPECTRUM, STREAKS, Settings, TERMS, Table,
    TermScale, TexelFormat, environment_table, single_wavelength,
};
use diffraction_shaders::variant::{Arguments, Form, Pattern};
use glam::{DVec3, DVec4};

/// Rows of a picture that are drawn at once.
const BAND_ROWS: u32 = 16;
/// Directions in a row of the probe's picture.
const PROBE_WIDTH: usize = 512;
/// Maximum number of rows of the table of directions. Every driver supports it.
const DIRECTION_ROWS: usize = 2048;

/// A table, and its binding in group 0 of the templates.
pub type BoundTable<'a> = (u32, &'a Table);

/// A compiled entry point with its tables.
pub trait Rows {
    /// Draws the rows `band`, counted from the top, of a picture of `[width, height]` pixels, `[row][column]`; `params` is the
    /// block `Params`.
    fn rows(&self, size: [u32; 2], params: &[f32; 8], band: Range<u32>) -> Result<Vec<[f32; 4]>>;
}

/// A driver that runs the shaders of variants.
pub trait Driver {
    /// A compiled entry point with its tables.
    type Pipeline: Rows;

    /// Name of the route.
    fn route(&self) -> String;

    /// Compiles the fragment entry point `entry` with the vertex entry point `vert`, and uploads its tables.
    fn pipeline(
        &self,
        module: &Module,
        entry: &str,
        tables: &[BoundTable<'_>],
    ) -> Result<Self::Pipeline>;

    /// Draws a whole picture of `[width, height]` pixels in bands, so that progress shows and an interrupt is heard.
    fn draw(
        &self,
        pipeline: &Self::Pipeline,
        [width, height]: [u32; 2],
        params: &[f32; 8],
        progress: Progress<'_>,
    ) -> Result<Vec<[f32; 4]>> {
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for top in (0..height).step_by(BAND_ROWS as usize) {
            let band = top..height.min(top + BAND_ROWS);
            pixels.extend(pipeline.rows([width, height], params, band.clone())?);
            // no picture is in progress here, so `progress` may draw, too
            progress(band.len() * width as usize);
        }
        Ok(pixels)
    }
}

/// A variant on a surface with everything that its shader needs. Negative controls spoil its fields on purpose.
#[derive(Clone, Debug)]
pub struct Prepared<'a> {
    /// The variant and its surface.
    pub placement: Placement<'a>,
    /// The templates of the shader.
    pub sources: Sources,
    /// How the variant computes.
    pub form: Form,
    /// The table of terms, colours or efficiencies; empty if the mode has none of them.
    pub terms: Table,
    /// The spectrum table.
    pub spectrum: Table,
    /// The table of coefficients or moments; empty if the mode has neither.
    pub coefficients: Table,
    /// The table of streaks; empty if the variant has no function for surroundings.
    pub streaks: Table,
    /// The table of paths; empty if the variant has no function for them.
    pub paths: Table,
    /// The texel that is evaluated; [`Pattern::NONE`] for variants without patterns.
    pub pattern: Pattern,
}

impl<'a> Prepared<'a> {
    /// Computes the tables.
    pub fn new(placement: Placement<'a>) -> Result<Prepared<'a>> {
        let Placement { height, rotate_deg, variant } = placement;
        let form = Form::new(variant, height)?;
        let mut tables = specialise::tables(&form, height, rotate_deg)?;
        let mut take = |binding: u32| {
            let place = tables.iter().position(|table| table.binding == binding);
            place.map_or(Table::ABSENT, |place| tables.swap_remove(place))
        };
        let [terms, spectrum, coefficients, streaks, paths] =
            [TERMS, SPECTRUM, COEFFICIENTS, STREAKS, PATHS].map(&mut take);
        let sources = Sources::builtin();
        Ok(Prepared {
            placement,
            sources,
            form,
            terms,
            spectrum,
            coefficients,
            streaks,
            paths,
            pattern: Pattern::NONE,
        })
    }

    /// The shader for a spectrum table of `wavelengths` wavelengths.
    pub fn module(&self, wavelengths: usize) -> Result<Module> {
        let Placement { rotate_deg, variant, .. } = self.placement;
        let defines = specialise::defines(variant, &self.form, rotate_deg, wavelengths);
        specialise::shader(&self.sources, &variant.name, &self.form, &defines).map_err(first)
    }

    /// Compiles the entry point `map` with its tables. Its uniform block is [`params`].
    pub fn map_pipeline<D: Driver>(&self, driver: &D) -> Result<D::Pipeline> {
        self.map_pipeline_in(driver, None)
    }

    /// The same with surroundings, for maps that were changed to call their function.
    pub fn map_pipeline_in<D: Driver>(
        &self,
        driver: &D,
        around: Option<&Table>,
    ) -> Result<D::Pipeline> {
        let further: Vec<&Table> = around.into_iter().collect();
        self.pipeline(driver, "map", &self.spectrum, &further)
    }

    /// Rows of arguments of each pixel of the entry point `probe`.
    fn argument_rows(&self) -> usize {
        match self.form.functions().len() {
            _ if self.form.has_pattern() => 6,
            1 => 2,
            _ => 5,
        }
    }

    /// Its tables, without the spectrum.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        let all = [&self.terms, &self.coefficients, &self.streaks, &self.paths];
        all.into_iter().filter(|table| table.width > 0)
    }

    /// Compiles an entry point with its tables. Only `probe` has `further` ones: directions, surroundings.
    fn pipeline<D: Driver>(
        &self,
        driver: &D,
        entry: &str,
        spectrum: &Table,
        further: &[&Table],
    ) -> Result<D::Pipeline> {
        let module = self.module(spectrum.width)?;
        let own = self.tables().chain((spectrum.width > 0).then_some(spectrum));
        let tables = own.chain(further.iter().copied()).map(|table| (table.binding, table));
        let tables: Vec<BoundTable<'_>> = tables.collect();
        driver.pipeline(&module, entry, &tables)
    }
}

/// A variant's shader on one driver.
pub struct DriverRunner<'a, D: Driver> {
    pub(super) prepared: Prepared<'a>,
    pub(super) driver: D,
    /// The entry point `map`, compiled when first needed.
    map: RefCell<Option<D::Pipeline>>,
}

impl<'a, D: Driver> DriverRunner<'a, D> {
    /// A runner. Nothing is compiled yet.
    pub fn with(prepared: Prepared<'a>, driver: D) -> DriverRunner<'a, D> {
        DriverRunner { prepared, driver, map: RefCell::new(None) }
    }

    /// The driver.
    pub fn driver(&self) -> &D {
        &self.driver
    }

    /// Returns an error if a colour is not finite.
    fn finite(&self, colours: &[[f64; 3]]) -> Result<()> {
        let is_finite = |xyz: &[f64; 3]| xyz.iter().all(|part| part.is_finite());
        let Some(at) = colours.iter().position(|xyz| !is_finite(xyz)) else { return Ok(()) };
        let cause = format!("colour {at} is {:?}, which is not finite", colours[at]);
        Err(Error::new(self.driver.route(), cause)
            .remedy("the driver is at fault: update it, or try another --runner")
            .finding())
    }
}

/// Evaluates the entry point `probe` with a given spectrum table, in pictures of at most half a million directions.
pub(super) fn probe<D: Driver>(
    prepared: &Prepared<'_>,
    driver: &D,
    spectrum: &Table,
    directions: &[Directions],
    progress: Progress<'_>,
) -> Result<Vec<[f64; 3]>> {
    let call = |d: &Directions| (Arguments::Direction(*d), prepared.pattern);
    let calls: Vec<Call> = directions.iter().map(call).collect();
    probe_calls(prepared, driver, spectrum, &calls, None, progress)
}

/// Arguments of a function, and the texel.
pub(super) type Call = (Arguments, Pattern);

/// The same for calls of any functions.
pub(super) fn probe_calls<D: Driver>(
    prepared: &Prepared<'_>,
    driver: &D,
    spectrum: &Table,
    calls: &[Call],
    around: Option<&Filtered>,
    progress: Progress<'_>,
) -> Result<Vec<[f64; 3]>> {
    let has = prepared.streaks.width > 0;
    let surroundings = has.then(|| around.map_or_else(dark, environment_table));
    let mut out = Vec::with_capacity(calls.len());
    let rows = prepared.argument_rows();
    for block in calls.chunks(PROBE_WIDTH * (DIRECTION_ROWS / rows)) {
        let table = directions_table(block, rows);
        let further: Vec<&Table> =
            [&table].into_iter().chain(surroundings.as_ref().map(|(table, _)| table)).collect();
        let pipeline = prepared.pipeline(driver, "probe", spectrum, &further)?;
        let size = [PROBE_WIDTH as u32, (table.height / rows) as u32];
        let picture = driver.draw(&pipeline, size, &params(DVec3::Z, size), progress)?;
        let factor = surroundings.as_ref().map_or(1.0, |(_, factor)| *factor);
        out.extend(picture.iter().zip(block).map(|(c, (call, _))| {
            let is_scaled = matches!(call, Arguments::Environment { .. });
            [c[0], c[1], c[2]].map(|c| f64::from(c) * if is_scaled { factor } else { 1.0 })
        }));
    }
    Ok(out)
}

impl<D: Driver> Runner for DriverRunner<'_, D> {
    fn route(&self) -> String {
        self.driver.route()
    }

    fn tristimulus_with(
        &self,
        directions: &[Directions],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let spectrum = &self.prepared.spectrum;
        let colours = probe(&self.prepared, &self.driver, spectrum, directions, progress)?;
        self.finite(&colours)?;
        Ok(colours)
    }

    fn under(
        &self,
        light: &Light,
        views: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Vec<[f64; 3]>> {
        let Prepared { placement, form, spectrum, .. } = &self.prepared;
        let around = if self.prepared.streaks.width > 0 { light.filtered() } else { None };
        lit_by(&placement.variant.name, form, light, views, &|calls| {
            let around = around.as_ref();
            let calls: Vec<Call> =
                calls.iter().map(|call| (*call, self.prepared.pattern)).collect();
            let colours =
                probe_calls(&self.prepared, &self.driver, spectrum, &calls, around, progress)?;
            self.finite(&colours)?;
            Ok(colours)
        })
    }

    /// With a single wavelength of weight 1 the shader returns `C·|P|²`. The gain is divided out in f64.
    fn response(&self, directions: &[Directions], lambda_nm: f64) -> Result<Vec<f64>> {
        let Placement { rotate_deg, variant, .. } = self.prepared.placement;
        has_wavelengths(&variant.name, &self.prepared.form)?;
        let scale = self.prepared.form.series().map_or(TermScale::NONE, |series| series.scale());
        let (matter, rows) = (self.prepared.form.matter(), self.prepared.form.coat().rows.clone());
        let spectrum = single_wavelength(lambda_nm, Settings { rotate_deg, scale, matter: rows });
        let rho = probe(&self.prepared, &self.driver, &spectrum, directions, &|_| ())?;
        self.finite(&rho)?;
        let gains = directions.iter().map(|Directions { wi, wr }| {
            matter.geometry(*wi, *wr) * matter.ratio(lambda_nm, matter.facing_of(*wi, *wr))
        });
        Ok(rho
            .iter()
            .zip(gains)
            .map(|(rho, gain)| if gain > 0.0 { rho[0] / gain } else { 0.0 })
            .collect())
    }

    /// Draws by the entry point `map`, whose linear RGB is converted back to tristimulus values.
    fn brdf_map_with(&self, light: DVec3, size: usize, progress: Progress<'_>) -> Result<BrdfMap> {
        let mut cached = self.map.borrow_mut();
        let pipeline = match cached.take() {
            Some(pipeline) => pipeline,
            None => self.prepared.map_pipeline(&self.driver)?,
        };
        let pixels = [size as u32; 2];
        let block = patterned(params(light, pixels), &self.prepared);
        let picture = self.driver.draw(&pipeline, pixels, &block, progress);
        *cached = Some(pipeline);
        let colour = self.prepared.placement.variant.optics.colour;
        let xyz = |(i, c): (usize, &[f32; 4])| {
            view_direction(i % size, i / size, size)
                .map(|_| from_rgb([c[0], c[1], c[2]].map(f64::from), colour))
        };
        let map = BrdfMap { size, xyz: picture?.iter().enumerate().map(xyz).collect() };
        self.finite(&map.disc())?;
        Ok(map)
    }
}

/// Surroundings of one black texel and their factor, for calls that ask for none: the shader has the texture all the same.
pub fn dark() -> (Table, f64) {
    let texels = vec![0.0; 4];
    let binding = ENVIRONMENT;
    let format = TexelFormat::Rgba16Float;
    let table =
        Table { binding, format, width: 1, height: 1, filtered: true, texels, ..Table::ABSENT };
    (table, 1.0)
}

/// The arguments of each pixel in `rows` rows, as the template `probe` reads them. Unused texels hold directions below the
/// horizon, which give black.
fn directions_table(calls: &[Call], rows: usize) -> Table {
    let lines = calls.len().div_ceil(PROBE_WIDTH);
    let mut texels = vec![0.0; rows * lines * PROBE_WIDTH * 4];
    for (i, (call, pattern)) in calls.iter().enumerate() {
        let arguments: &[(DVec3, f64)] = match *call {
            Arguments::Direction(Directions { wi, wr }) => &[(wi, 0.0), (wr, 0.0)],
            Arguments::Spread { directions: Directions { wi, wr }, spread } => {
                &[(wi, 9.0), (wr, spread)]
            }
            Arguments::Disc { axis, radius_rad, colour: None, wr } => {
                &[(axis, 1.0), (wr, radius_rad)]
            }
            Arguments::Disc { axis, radius_rad, colour: Some(of), wr } => {
                &[(axis, 4.0), (wr, radius_rad), (axis, of.x), (axis, of.y), (axis, of.z)]
            }
            Arguments::Rectangle { corners: [a, b, c, d], colour, wr } => {
                let of = colour.unwrap_or_default();
                let function = if colour.is_some() { 5.0 } else { 2.0 };
                &[(a, function), (wr, 0.0), (b, of.x), (c, of.y), (d, of.z)]
            }
            Arguments::Environment { wr, .. } => &[(wr, 3.0), (wr, 0.0)],
            Arguments::Path { sky: Sky { constant, lobes: [lobe, _] }, random, wr } => &[
                (constant, 8.0),
                (wr, lobe.sigma_rad),
                (lobe.axis, 0.0),
                (lobe.radiance, 0.0),
                (random, 0.0),
            ],
        };
        let mut set = |line: usize, texel: DVec4| {
            let row = rows * (i / PROBE_WIDTH) + line;
            let at = (row * PROBE_WIDTH + i % PROBE_WIDTH) * 4;
            texels[at..at + 4].copy_from_slice(&texel.to_array());
        };
        for (line, (vector, number)) in arguments.iter().enumerate() {
            set(line, vector.extend(*number));
        }
        if rows == 6 {
            set(5, pattern.argument());
        }
    }
    Table {
        name: "directions",
        binding: DIRECTIONS,
        format: TexelFormat::Rgba32Float,
        width: PROBE_WIDTH,
        height: rows * lines,
        layers: 0,
        filtered: false,
        texels,
    }
}

/// Binding of the uniform block `Params`. Meshes have another block.
pub(super) const PARAMS: u32 = 0;

/// The uniform block `Params`: direction to the light, then width and height in pixels.
pub fn params(light: DVec3, [width, height]: [u32; 2]) -> [f32; 8] {
    let light = light.as_vec3();
    [light.x, light.y, light.z, 0.0, width as f32, height as f32, 0.0, 0.0]
}

/// The same with the pattern of a variant that has one.
pub fn patterned(mut params: [f32; 8], prepared: &Prepared<'_>) -> [f32; 8] {
    if prepared.form.has_pattern() {
        let Pattern { angle_deg, period_ratio, depth_ratio } = prepared.pattern;
        let numbers = [angle_deg.to_radians(), period_ratio, depth_ratio].map(|n| n as f32);
        [params[3], params[6], params[7]] = numbers;
    }
    params
}

/// The first diagnostic of a shader that does not compile. `generate` shows all of them with their places.
fn first(diagnostics: Vec<Diagnostic>) -> Error {
    let message = diagnostics.first().map_or("does not compile", |d| d.message.as_str());
    Error::new("shader", message).remedy("the command generate shows every error with its place")
}
