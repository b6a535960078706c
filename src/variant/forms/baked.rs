//! `baked`: a table of colours over `(u, v, w)`. The integral over wavelengths is in the table.

use std::f64::consts::PI;

use crate::defines::Defines;
use crate::error::Result;
use crate::optics::{REFERENCE_NM, window_sigma_um};
use crate::plan::{Illuminant, LightFunction, TableFormat, Variant, Window};
use crate::surface::HeightField;
use crate::tables::paths::{PATH_LEVELS, colour_paths_shape, path_columns};
use crate::tables::{
    Aim, BEND, BakedAxes, ColourPathsSpec, ColoursSpec, RotationSpec, TableSpec, colour_format,
};
use crate::variant::judge::Light;
use crate::variant::tolerance::{Promise, is_visible};
use crate::variant::{Coat, Computation, Cost, Function, Ground, functions_of, lay};

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
    functions: Vec<LightFunction>,
    /// Axes of the colours that probabilities of paths follow.
    path_axes: BakedAxes,
    /// Radiance relative to a white diffuser per unit of the result, divided by π.
    pub radiance_scale: f64,
}

impl Baked {
    pub(in crate::variant) fn new(variant: &Variant, height: &HeightField) -> Result<Baked> {
        Light::new(variant)?;
        let window = Window::from(&variant.optics);
        let aim = Aim { error: variant.bake_error, mib: variant.bake_mib };
        let coat = Coat::new(variant)?;
        let range_um = lay::height_range_um(height);
        let sized = |aim| match &coat.rows {
            None => BakedAxes::new(window, variant.table, aim, range_um),
            Some(_) => {
                let least = coat.matter.least_w_squared();
                // interference in films changes with w as fast as in a relief of their depth; equal steps of w need twice as
                // many layers, and so does a reflectance even on a flat relief
                let deep_um = range_um + coat.matter.detail_um(0.0);
                let layered_um =
                    if least == 0.0 { 2.0 * deep_um.max(FLATTEST_UM) } else { deep_um };
                BakedAxes::new(window, variant.table, aim, layered_um)
                    .with_matter(least, coat.matter.brightest(lay::range_nm(variant)))
            }
        };
        let axes = sized(aim);
        let has_paths = variant.has_function(LightFunction::Path);
        let sigma_um = window_sigma_um(window, REFERENCE_NM);
        Ok(Baked {
            axes,
            functions: match has_paths {
                true => vec![LightFunction::Direction, LightFunction::Path],
                false => vec![LightFunction::Direction],
            },
            path_axes: sized(Aim { error: aim.error.max(PATH_ERROR), ..aim }),
            radiance_scale: coat.matter.diffuser_scale(sigma_um) / PI,
            format: variant.table,
            aim,
            is_uncut: axes == sized(Aim { mib: f64::INFINITY, ..aim }),
            window,
            range_nm: lay::range_nm(variant),
            coat,
            illuminant: variant.optics.illuminant.clone(),
            filters: variant.filters(),
        })
    }
}

impl Baked {
    fn has_paths(&self) -> bool {
        self.functions.contains(&LightFunction::Path)
    }
}

impl Computation for Baked {
    fn define(&self, _: usize, into: &mut Defines) {
        let BakedAxes { columns, levels, pages, rows, pace, stretch, .. } = self.axes;
        let BakedAxes { least_w_squared, even_w, .. } = self.axes;
        into.flag("EVEN_LEVELS", even_w);
        let path = self.has_paths();
        into.flag("PATH", path);
        into.flag("SIZED", path);
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
        let rotation = TableSpec::Rotation(RotationSpec { rotate_deg: on.rotate_deg });
        let rotation = (on.rotate_deg != 0.0).then_some(rotation);
        let coarse = ColoursSpec { axes: self.path_axes, ..colours.clone() };
        let paths = TableSpec::ColourPaths(ColourPathsSpec { colours: coarse });
        let paths = self.has_paths().then_some(paths);
        [TableSpec::Colours(colours)].into_iter().chain(rotation).chain(paths).collect()
    }

    fn cost(&self) -> Cost {
        // two neighbouring levels, filtered or not
        let fetches: u64 = if self.filters { 2 } else { 8 };
        Cost {
            fetches,
            fetches_mean: fetches as f64,
            table_bytes: self.axes.texels() * colour_format(self.format).texel_bytes() as u64
                + if self.has_paths() { colour_paths_shape().byte_count() as u64 } else { 0 },
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

    fn functions(&self) -> Vec<&'static dyn Function> {
        self.functions.iter().flat_map(|word| functions_of(*word)).collect()
    }

    fn no_wavelength_axis(&self) -> Option<&'static str> {
        Some("has no wavelength axis: its table holds colours")
    }
}
