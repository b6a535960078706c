//! `baked`: a table of colours over `(u, v, w)`. The integral over wavelengths is in the table.

use std::f64::consts::PI;

use crate::defines::Defines;
use crate::error::{Error, Result};
use crate::optics::{REFERENCE_NM, window_sigma_um};
use crate::plan::{Auto, Illuminant, LightFunction, TableFormat, Variant, Window};
use crate::surface::HeightField;
use crate::tables::paths::{PATH_LEVELS, colour_paths_shape, path_columns};
use crate::tables::{
    Aim, BEND, BakedAxes, CellsSpec, ColourPathsSpec, ColoursSpec, PACKED, RotationSpec,
    SpreadsSpec, TableSpec, WideAxes, WideSpec, cells_shape, colour_format, lobe_sigma,
};
use crate::variant::judge::Light;
use crate::variant::tolerance::{Promise, is_visible};
use crate::variant::{
    Coat, Computation, Cost, DIRECTIONAL, ENVIRONMENT, Function, Ground, PATH, SOFT_DISC, SPREAD,
    StatedError, define_surroundings, lay,
};

/// Range of the heights from which on layers for the phase are enough for the reflectance of a metal in air, µm.
const FLATTEST_UM: f64 = 0.15;

/// Error at which the axes of the colours are chosen that probabilities of paths follow: a fraction of the time of the table
/// itself.
const PATH_ERROR: f64 = 4.0;

/// Numbers of the form.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// Axes of the table.
    pub axes: BakedAxes,
    /// Number format of the table.
    pub format: TableFormat,
    aim: Aim,
    /// Whether the sizes reach the target error, that is, the maximum size did not reduce them.
    is_uncut: bool,
    window: Window,
    range_nm: [f64; 2],
    /// What the surface is made of.
    pub coat: Coat,
    illuminant: Illuminant,
    filters: bool,
    has_paths: bool,
    /// Axes of the colours that probabilities of paths follow.
    path_axes: BakedAxes,
    /// Radiance relative to a white diffuser per unit of the result, divided by π.
    pub radiance_scale: f64,
    refractive_index: f64,
    /// Tables of wider lobes.
    pub wide: Option<Wide>,
    /// Cells that surroundings light.
    pub cells: Option<Cells>,
}

/// The cells of `(u, v)` that surroundings light one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// Number of them.
    pub count: u32,
    /// Axes of the colours that they are made of.
    pub axes: BakedAxes,
    window: Window,
}

/// Longest coherence length of the colours that cells are made of, µm. Its lobes are narrower than most cells.
const CELLS_UM: f64 = 25.0;
/// How their axes are chosen. A cell has many of their texels.
const CELLS_AIM: Aim = Aim { error: 1.0, mib: 1024.0 };

impl Cells {
    /// Bytes of their table.
    fn byte_count(&self) -> u64 {
        cells_shape(self.count, self.axes.levels).byte_count() as u64
    }
}

/// The tables of wider lobes.
#[derive(Clone, Debug, PartialEq)]
pub struct Wide {
    /// Their sizes.
    pub axes: WideAxes,
    /// Whether the sizes reach the target error.
    is_uncut: bool,
    /// Factor from the width of lobes in a table to that in the next.
    pub step: f64,
    /// Whether the shader has a function for discs.
    pub has_disc: bool,
    /// Standard deviation of the narrowest lobes, in direction cosines.
    pub lobe_sigma: f64,
}

impl Wide {
    /// Factor from the variance of lobes in a table to that in the next.
    pub fn ratio(&self) -> f64 {
        self.step * self.step
    }

    /// Variance of the widest lobes relative to that of the narrowest.
    pub fn widest(&self) -> f64 {
        self.axes.levels.iter().fold(1.0, |variance, _| variance * self.ratio())
    }
}

/// Lobes that a disc is made of, on two rings.
pub const DISC_LOBES: usize = 13;
/// Lobes on the inner ring.
pub const DISC_INNER: usize = 4;
/// Radii of the rings relative to that of the disc.
pub const DISC_RINGS: [f64; 2] = [0.3, 0.75];
/// Share of the light in the inner ring.
pub const DISC_INNER_SHARE: f64 = 0.26;
/// Variance of such a lobe relative to that of the disc. With the rings it is where the sum comes closest to a disc: the root mean
/// square of the difference is 0.16 of that of the disc, against 0.46 for a single lobe, and 0.5 % of the light is further out
/// than 1.25 radii, against 5 %.
pub const DISC_SHARE: f64 = 0.15;
/// Variance of the rings relative to that of the disc, which is a quarter of its squared radius.
pub const DISC_RING_VARIANCE: f64 = 2.0
    * (DISC_INNER_SHARE * DISC_RINGS[0] * DISC_RINGS[0]
        + (1.0 - DISC_INNER_SHARE) * DISC_RINGS[1] * DISC_RINGS[1]);

/// Coherence length of a lobe that is as wide as a disc of 20°, µm: where `spread_levels = "auto"` ends.
const WIDE_UM: f64 = 2.835;
/// The shortest coherence length of a table, µm, as wide as a disc of 81°. Wider lobes would reach around the hemisphere,
/// where a width in direction cosines means nothing.
const WIDEST_UM: f64 = 0.7;

/// Number of tables of wider lobes. It is an error if lobes become too wide.
fn level_count(variant: &Variant) -> Result<u32> {
    let (step, narrowest_um) = (variant.spread_step, variant.optics.coherence_um);
    let count = match variant.spread_levels {
        Auto::Value(count) => count,
        Auto::Auto => {
            let mut count = 1;
            let mut coherence_um = narrowest_um / step;
            while coherence_um > WIDE_UM {
                coherence_um /= step;
                count += 1;
            }
            count
        }
    };
    let widest_um = (0..count).fold(narrowest_um, |um, _| um / step);
    if count > 0 && widest_um < WIDEST_UM {
        let cause = format!(
            "{count} tables, each with lobes {step} times as wide as the last, end with a coherence length of {widest_um:.2} µm, below {WIDEST_UM} µm"
        );
        return Err(Error::new(&variant.name, cause)
            .remedy("use fewer spread_levels, or a smaller spread_step"));
    }
    Ok(count)
}

impl Baked {
    pub(in crate::variant) fn new(variant: &Variant, height: &HeightField) -> Result<Baked> {
        Light::new(variant)?;
        let window = Window::from(&variant.optics);
        let aim = Aim { error: variant.bake_error, mib: variant.bake_mib };
        let coat = Coat::new(variant)?;
        let range_um = lay::height_range_um(height);
        let least = coat.matter.least_w_squared();
        let layered_um = match &coat.rows {
            None => range_um,
            Some(_) => {
                // interference in films changes with w as fast as in a relief of their depth; equal steps of w need twice as
                // many layers, and so does a reflectance even on a flat relief
                let deep_um = range_um + coat.matter.detail_um(0.0);
                if least == 0.0 { 2.0 * deep_um.max(FLATTEST_UM) } else { deep_um }
            }
        };
        let with_matter = |axes: BakedAxes| match &coat.rows {
            None => axes,
            Some(_) => axes.with_matter(least, coat.matter.brightest(lay::range_nm(variant))),
        };
        let sized = |aim| with_matter(BakedAxes::new(window, variant.table, aim, layered_um));
        let axes = sized(aim);
        let sigma_um = window_sigma_um(window, REFERENCE_NM);
        let count = level_count(variant)?;
        let widened = |aim| {
            let (steps, format) = ((window, variant.spread_step), variant.table);
            WideAxes::new(steps, count, (format, aim), layered_um, with_matter)
        };
        let has_sky = count > 0 && variant.has_function(LightFunction::Environment);
        let cells = has_sky.then(|| {
            let window = Window { coherence_um: window.coherence_um.min(CELLS_UM), ..window };
            let axes = BakedAxes::new(window, TableFormat::F32, CELLS_AIM, layered_um);
            let axes = with_matter(axes);
            Cells { count: variant.cells, axes, window }
        });
        let unlimited = Aim { mib: f64::INFINITY, ..aim };
        let wide = match count {
            0 => None,
            _ => Some(Wide {
                axes: widened(aim),
                is_uncut: widened(aim) == widened(unlimited),
                step: variant.spread_step,
                has_disc: variant.has_function(LightFunction::Disc),
                lobe_sigma: lobe_sigma(window),
            }),
        };
        Ok(Baked {
            wide,
            cells,
            axes,
            has_paths: variant.has_function(LightFunction::Path),
            path_axes: sized(Aim { error: aim.error.max(PATH_ERROR), ..aim }),
            radiance_scale: coat.matter.diffuser_scale(sigma_um) / PI,
            format: variant.table,
            aim,
            is_uncut: axes == sized(unlimited),
            window,
            range_nm: lay::range_nm(variant),
            coat,
            illuminant: variant.optics.illuminant.clone(),
            filters: variant.filters(),
            refractive_index: variant.optics.refractive_index,
        })
    }
}

impl Baked {
    /// The error that the function of wider lobes promises: that of a table, and between two of them that of their mixture
    /// (12 on fingers with step 2, 5 with step √2; 2.0 and 0.6 on a scan). `None` if the maximum size reduced the tables.
    pub fn spread_error(&self) -> Option<StatedError> {
        let wide = self.wide.as_ref()?;
        let kept = self.is_uncut && wide.is_uncut && is_visible(self.range_nm);
        kept.then(|| StatedError {
            under: "a direction, with any spread up to the widest table".to_owned(),
            de2000_p95: 2.0 * self.aim.error + wide.mixing_error(),
        })
    }

    /// The error that the function of surroundings promises.
    pub fn sky_error(&self) -> Option<f64> {
        let cells = self.cells.filter(|_| is_visible(self.range_nm))?;
        Some(CELLS_128 * (128.0 / f64::from(cells.count)).powf(CELLS_FALL))
    }

    /// The errors that the function of discs promises, for every radius that the tables reach. Empty as above.
    pub fn disc_errors(&self) -> Vec<StatedError> {
        let Some(wide) = &self.wide else {
            return Vec::new();
        };
        let kept = self.is_uncut && wide.is_uncut && is_visible(self.range_nm);
        let reached = |radius_deg: f64| {
            let lobe = 2.0 * wide.lobe_sigma;
            let widest = lobe * (wide.widest() / DISC_SHARE).sqrt();
            kept && (lobe..=widest).contains(&radius_deg.to_radians().sin())
        };
        let stated = DISC_ERRORS.into_iter().filter(|(radius_deg, _)| reached(*radius_deg));
        let error = |(radius_deg, de2000_p95): (f64, f64)| StatedError {
            under: format!(
                "a disc of {radius_deg}° in radius, on a relief without a period, with many orders in the disc"
            ),
            de2000_p95,
        };
        stated.map(error).collect()
    }
}

/// The error under surroundings of 128 cells, and the power of their number with which it falls: at most 6.6, 6.6 and 4.9 with 64,
/// 128 and 256 cells under a window with bars; 4.8, 3.7 and 2.9 under softboxes, less under skies without narrow lamps.
const CELLS_128: f64 = 7.5;
/// See [`CELLS_128`].
const CELLS_FALL: f64 = 0.5;

/// Error of a mixture of two tables per logarithm of the step between them: at most 17 on fingers, where it is largest.
const MIXING: f64 = 20.0;
/// Radius of a disc, degrees, and the 95th percentile of CIEDE2000 against the exact colours. The sum of lobes is less sharp than a
/// disc, which shows where few orders are strong: at most 2.7, 6.8 and 12.2 on a scan of 65 µm, 6.9, 13.2 and 20.6 on synthetic reliefs,
/// whose lattices are nearly regular.
const DISC_ERRORS: [(f64, f64); 3] = [(3.0, 8.0), (8.0, 14.0), (20.0, 25.0)];

impl Wide {
    /// Error of a lobe between two tables.
    fn mixing_error(&self) -> f64 {
        MIXING * self.step.ln()
    }

    fn define(&self, into: &mut Defines) {
        let narrowest = "standard deviation of the narrowest lobes, in direction cosines";
        into.number("LOBE_SIGMA", self.lobe_sigma, narrowest);
        let ratio = "factor from the variance of lobes on a level to that on the next";
        into.number("LEVEL_RATIO", self.ratio(), ratio);
        let widest = "variance of the widest lobes, relative to that of the narrowest";
        into.number("WIDEST_VARIANCE", self.widest(), widest);
        if self.has_disc {
            into.count("DISC_LOBES", DISC_LOBES, "number of lobes that a disc is made of");
            into.count("DISC_INNER", DISC_INNER, "number of them on the inner ring");
            let ring = "radius of the inner ring, relative to that of the disc";
            into.number("DISC_INNER_RING", DISC_RINGS[0], ring);
            into.number(
                "DISC_OUTER_RING",
                DISC_RINGS[1],
                "radius of the outer ring, relative to that of the disc",
            );
            let light = "share of the light in the inner ring";
            into.number("DISC_INNER_SHARE", DISC_INNER_SHARE, light);
            let share = "variance of a lobe, relative to that of the disc";
            into.number("DISC_SHARE", DISC_SHARE, share);
            let rings = "variance of the rings, relative to that of the disc";
            into.number("DISC_RING_VARIANCE", DISC_RING_VARIANCE, rings);
        }
        let levels = "number of levels with wider lobes";
        into.count("SPREAD_LEVELS", self.axes.levels.len(), levels);
        let packed = "factor of the second of two numbers in one";
        into.number("PACKED", f64::from(PACKED), packed);
        let pace = "number of rows per unit of asinh on these levels";
        into.number("WIDE_PACE", self.axes.levels.first().map_or(1.0, |l| l.axes.pace), pace);
        let [columns, rows] = self.axes.size();
        into.count("WIDE_COLUMNS", columns as usize, "number of columns of all these levels");
        into.count("WIDE_ROWS", rows as usize, "number of rows of all these levels");
        into.count("WIDE_LAYERS", self.axes.layers() as usize, "number of layers of these levels");
    }
}

impl Computation for Baked {
    fn define(&self, _: usize, into: &mut Defines) {
        let BakedAxes { columns, levels, pages, rows, pace, stretch, .. } = self.axes;
        let BakedAxes { least_w_squared, even_w, .. } = self.axes;
        into.flag("EVEN_LEVELS", even_w);
        let path = self.has_paths;
        into.flag("PATH", path);
        into.count("PATH_LEVELS", PATH_LEVELS as usize, "number of divisions of a path");
        let columns_of_paths = "number of columns of the table of paths";
        into.count("PATH_COLUMNS", path_columns(), columns_of_paths);
        let radiance = "radiance relative to a white diffuser per unit of the result, divided by π";
        into.number("RADIANCE_SCALE", self.radiance_scale, radiance);
        let least = "least square of w, under a cover";
        into.number("LEAST_W_SQUARED", least_w_squared, least);
        into.number("BEND", BEND, "slope at 0 of the parabola that replaces the arc tangent");
        into.number(
            "COLOUR_UNIT",
            1.0 / self.axes.colour_scale(),
            "unit of the numbers in the table of colours",
        );
        into.count(
            "COLUMN_COUNT",
            columns as usize,
            "number of columns of a full turn, on all pages",
        );
        into.count("LEVEL_COUNT", levels as usize, "number of levels of w², the layers of a page");
        let page_columns = self.axes.page_columns() as usize;
        into.count(
            "PAGE_COLUMNS",
            page_columns,
            "number of columns of a page, without the repeated one",
        );
        into.count("PAGE_COUNT", pages as usize, "number of pages that the angle is divided into");
        into.count("ROW_COUNT", rows as usize, "number of rows");
        into.number("ROW_PACE", pace, "number of rows per unit of asinh(STRETCH |(u, v)|)");
        into.number("STRETCH", stretch, "factor of |(u, v)| in the argument of asinh");
        into.flag("SPREAD", self.wide.is_some());
        into.flag("SIZED", self.wide.is_some() || self.has_paths);
        into.flag("ENVIRONMENT", self.cells.is_some());
        if let Some(Cells { count, axes, .. }) = &self.cells {
            into.count("CELL_COUNT", *count as usize, "number of cells of (u, v)");
            into.count("CELL_LAYERS", axes.levels as usize, "number of layers of w of a cell");
            define_surroundings(into);
        }
        if let Some(wide) = &self.wide {
            into.flag("DISC", wide.has_disc);
            wide.define(into);
        }
    }

    fn coat(&self) -> &Coat {
        &self.coat
    }

    fn tables(&self, on: Ground<'_>) -> Vec<TableSpec> {
        let colours = ColoursSpec {
            surface: on.surface.to_owned(),
            range_nm: self.range_nm,
            window: self.window,
            illuminant: self.illuminant.clone(),
            aim: self.aim,
            axes: self.axes,
            matter: self.coat.rows.clone(),
            format: self.format,
            filtered: self.filters,
        };
        let normal = self.coat.matter.normal_reflectance();
        let refractive_index = self.coat.rows.is_none().then_some(self.refractive_index);
        let cells = self.cells.map(|Cells { count, axes, window }| {
            let (aim, format) = (CELLS_AIM, TableFormat::F32);
            let colours = ColoursSpec { window, axes, aim, format, ..colours.clone() };
            let lobe_sigma = lobe_sigma(window);
            TableSpec::Cells(CellsSpec { colours, count, lobe_sigma, refractive_index, normal })
        });
        let coarse = ColoursSpec { axes: self.path_axes, ..colours.clone() };
        let paths = TableSpec::ColourPaths(ColourPathsSpec { colours: coarse });
        let paths = self.has_paths.then_some(paths);
        let Some(Wide { axes: wide, .. }) = &self.wide else {
            let rotation = TableSpec::Rotation(RotationSpec { rotate_deg: on.rotate_deg });
            let rotation = (on.rotate_deg != 0.0).then_some(rotation);
            return [TableSpec::Colours(colours)]
                .into_iter()
                .chain(rotation)
                .chain(paths)
                .collect();
        };
        let wide = WideSpec {
            surface: on.surface.to_owned(),
            range_nm: self.range_nm,
            illuminant: self.illuminant.clone(),
            aim: self.aim,
            wide: wide.clone(),
            matter: self.coat.rows.clone(),
            format: self.format,
            filtered: self.filters,
        };
        let spreads = SpreadsSpec {
            rotate_deg: on.rotate_deg,
            wide: Box::new(wide.clone()),
            refractive_index,
            normal,
        };
        let all = [TableSpec::Colours(colours), TableSpec::Spreads(spreads), TableSpec::Wide(wide)];
        all.into_iter().chain(cells).chain(paths).collect()
    }

    fn functions(&self) -> Vec<&'static dyn Function> {
        let mut all: Vec<&'static dyn Function> = match &self.wide {
            Some(Wide { has_disc: true, .. }) => vec![&DIRECTIONAL, &SPREAD, &SOFT_DISC],
            Some(_) => vec![&DIRECTIONAL, &SPREAD],
            None => vec![&DIRECTIONAL],
        };
        if self.cells.is_some() {
            all.push(&ENVIRONMENT);
        }
        if self.has_paths {
            all.push(&PATH);
        }
        all
    }

    fn cost(&self) -> Cost {
        // two neighbouring levels, filtered or not
        let fetches: u64 = if self.filters { 2 } else { 8 };
        let wide = self.wide.as_ref().map_or(0, |wide| wide.axes.texels());
        let texels = self.axes.texels() + wide;
        Cost {
            fetches,
            fetches_mean: fetches as f64,
            table_bytes: texels * colour_format(self.format).texel_bytes() as u64
                + if self.has_paths { colour_paths_shape().byte_count() as u64 } else { 0 }
                + self.cells.map_or(0, |cells| cells.byte_count()),
            ..Cost::default()
        }
    }

    /// Twice the target error, if the maximum size did not reduce the sizes. Maps of isolated lobes show larger errors,
    /// since their exposure is adapted to dim orders, so that errors on flanks between texels are visible (2.0 on
    /// fingers under a low light; 0.6 on a scan).
    fn promise(&self) -> Promise {
        let kept = self.is_uncut && is_visible(self.range_nm);
        let model = kept.then_some((2.0 * self.aim.error, Some(5.0 * self.aim.error)));
        Promise::of_colours(self.format).with_model(model)
    }

    fn filters(&self) -> bool {
        self.filters
    }

    fn no_wavelength_axis(&self) -> Option<&'static str> {
        Some("has no wavelength axis: its table holds colours")
    }
}
