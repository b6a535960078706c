//! Height fields: heights in µm on a regular grid with a physical pitch.
//!
//! [`prepare`] turns one surface of a plan into a [`HeightField`]: decode or synthesise, fill voids, level, resample, clip
//! outliers, extrude a profile. It returns a note for every change that a user should know about.

pub mod gsf;
pub mod facts;
pub mod level;
mod length;
mod raster;
pub mod read;
mod resample;
pub mod synthetic;
pub mod voids;

use crate::error::{Error, Result};
use crate::plan::{FileSource, SurfaceSource, SurfaceSpec};

pub use gsf::write_gsf;

/// Maximum number of pixels along one axis: three times the largest scan that atomic-force microscopes commonly deliver
/// (4096 to 5120).
pub const MAX_SIDE: usize = 16384;

/// Maximum number of pixels of a surface: 8192², which is 512 MiB of heights. Its transforms would need 1 GiB per term.
pub const MAX_PIXELS: usize = 8192 * 8192;

/// Maximum peak-to-valley height, µm. The model is for reliefs of about a wavelength. A hundred times that means a wrong unit.
pub const MAX_HEIGHT_UM: f64 = 100.0;

/// Maximum pixel pitch, µm. Pixels of a millimetre mean a wrong unit.
pub const MAX_PITCH_UM: f64 = 1000.0;

/// Minimum pixel pitch, µm: a tenth of an atom's diameter.
pub const MIN_PITCH_UM: f64 = 1e-5;

/// Number of equal rows that a profile is extruded to. Any number gives the same spectrum; four keep the transforms
/// two-dimensional.
pub const EXTRUDED: usize = 4;

/// A prepared surface, with notes about its preparation.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The heights.
    pub field: HeightField,
    /// Notes for the user: heights quantised, voids filled, outliers clipped, a profile extruded, a scale overridden.
    pub notes: Vec<String>,
}

/// Facts about a file before its heights were prepared. A synthetic surface has neither steps nor voids.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Origin {
    /// Step between neighbouring heights of an integer file, µm.
    pub step_um: Option<f64>,
    /// Number of void pixels, which were filled from their neighbours.
    pub void_pixels: usize,
    /// Number of pixels of the file.
    pub file_pixels: usize,
}

/// Decodes or synthesises a surface and prepares it: voids → level → resample → clip → extrude. Also returns facts
/// about the file.
/// `bytes`: the content of the file, if the surface has one.
///
/// Errors name the surface, its file, the key, its value and what to do. The rotation of the surface is not applied
/// here: later code rotates `(u, v)` instead, which is exact.
pub fn prepare(spec: &SurfaceSpec, bytes: Option<&[u8]>) -> Result<(Surface, Origin)> {
    let mut origin = Origin::default();
    let subject = subject(spec);
    level::check_clip(&subject, spec.clip_percent)?;
    let (field, mut notes) = match &spec.source {
        SurfaceSource::Grating(grating) => {
            let surface = synthetic::synthesise(grating, &subject)?;
            (surface.field, surface.notes)
        }
        SurfaceSource::File(file) => {
            let reading = read::parse(file, &spec.name, bytes.unwrap_or_default())?;
            origin.step_um = reading.step_um;
            origin.void_pixels = reading.heights_um.iter().filter(|h| h.is_nan()).count();
            origin.file_pixels = reading.heights_um.len();
            voids::fill(reading, &subject)?
        }
    };
    let mut field = level::level(field, spec.level, &subject)?;
    if let SurfaceSource::File(FileSource { resample_um: Some(pitch_um), .. }) = spec.source {
        let (resampled, note) = resample::resample(&field, pitch_um, &subject)?;
        field = resampled;
        notes.push(note);
    }
    let (field, clipped) = level::clip(field, spec.clip_percent, &subject)?;
    notes.extend(clipped);
    if field.columns != 1 && field.rows != 1 {
        return Ok((Surface { field, notes }, origin));
    }
    let along = if field.rows == 1 { "x" } else { "y" };
    let extruded = field.extruded().map_err(|_| {
        Error::new(&subject, "has only a single pixel")
            .remedy("use a file with at least two pixels")
    })?;
    notes.push(format!(
        "a profile of {} pixels along {along}, extruded to {} × {} pixels",
        field.columns * field.rows,
        extruded.columns,
        extruded.rows
    ));
    Ok((Surface { field: extruded, notes }, origin))
}

/// Subject of errors about a surface: its name, and its file if it has one.
pub fn subject(spec: &SurfaceSpec) -> String {
    match &spec.source {
        SurfaceSource::Grating(_) => format!("surface {}", spec.name),
        SurfaceSource::File(file) => read::subject(&spec.name, &file.path),
    }
}

/// Heights of one patch, which tiles the plane periodically.
///
/// Row-major, **row 0 at the top** (largest y); pixel (col, row) lies at `x = col·pitch_x - Lx/2`,
/// `y = (rows-1-row)·pitch_y - Ly/2`, so `+x` is to the right and `+y` is up the picture. All heights are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    columns: usize,
    rows: usize,
    pitch_x_um: f64,
    pitch_y_um: f64,
    heights_um: Vec<f64>,
}

impl HeightField {
    /// Checks shape, pitch and heights (`heights_um[row][column]`, finite).
    pub fn new(
        columns: usize,
        rows: usize,
        pitch_x_um: f64,
        pitch_y_um: f64,
        heights_um: Vec<f64>,
    ) -> Result<HeightField> {
        let subject = format!("height field of {columns} × {rows} pixels");
        if columns == 0 || rows == 0 || columns.checked_mul(rows) != Some(heights_um.len()) {
            let cause = format!("{} heights were given", heights_um.len());
            return Err(Error::new(subject, cause).remedy("give one height for each pixel"));
        }
        if !(pitch_x_um.is_finite()
            && pitch_x_um > 0.0
            && pitch_y_um.is_finite()
            && pitch_y_um > 0.0)
        {
            let cause =
                format!("pixel pitch {pitch_x_um} × {pitch_y_um} µm is not positive and finite");
            return Err(Error::new(subject, cause).remedy("give the pitch in µm"));
        }
        if let Some(at) = heights_um.iter().position(|h| !h.is_finite()) {
            let cause = format!(
                "the height at column {}, row {} is {}",
                at % columns,
                at / columns,
                heights_um[at]
            );
            return Err(Error::new(subject, cause).remedy("heights must be finite"));
        }
        Ok(HeightField { columns, rows, pitch_x_um, pitch_y_um, heights_um })
    }

    /// Pixels along x.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Pixels along y.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Pixel pitch along x, µm.
    pub fn pitch_x_um(&self) -> f64 {
        self.pitch_x_um
    }

    /// Pixel pitch along y, µm.
    pub fn pitch_y_um(&self) -> f64 {
        self.pitch_y_um
    }

    /// Patch width `Lx`, µm.
    pub fn size_x_um(&self) -> f64 {
        self.columns as f64 * self.pitch_x_um
    }

    /// Patch height `Ly`, µm.
    pub fn size_y_um(&self) -> f64 {
        self.rows as f64 * self.pitch_y_um
    }

    /// Heights, µm, `[row][column]`, row 0 at the top.
    pub fn heights_um(&self) -> &[f64] {
        &self.heights_um
    }

    /// Bytes of the heights.
    pub fn byte_count(&self) -> u64 {
        size_of_val(self.heights_um.as_slice()) as u64
    }

    /// Lowest and highest height, µm.
    pub fn range_um(&self) -> (f64, f64) {
        let fold = |f: fn(f64, f64) -> f64, start| self.heights_um.iter().copied().fold(start, f);
        (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY))
    }

    /// Extrudes a profile (one row or one column) to [`EXTRUDED`] equal rows or columns, with the same pitch on both
    /// axes. Any other field is returned unchanged. A single pixel is an error.
    pub fn extruded(&self) -> Result<HeightField> {
        let HeightField { columns, rows, pitch_x_um, pitch_y_um, .. } = *self;
        match (columns, rows) {
            (1, 1) => Err(Error::new("height field of 1 × 1 pixels", "cannot be extruded")
                .remedy("a profile needs at least two pixels")),
            (_, 1) => HeightField::new(
                columns,
                EXTRUDED,
                pitch_x_um,
                pitch_x_um,
                self.heights_um.repeat(EXTRUDED),
            ),
            (1, _) => {
                let heights = self.heights_um.iter().flat_map(|&h| [h; EXTRUDED]).collect();
                HeightField::new(EXTRUDED, rows, pitch_y_um, pitch_y_um, heights)
            }
            _ => Ok(self.clone()),
        }
    }

    /// Checks that the pitch resolves every direction: `|u|, |v| ≤ 2` requires a pitch of at most `λmin/4` on both axes.
    ///
    /// `subject` names the surface. The error states the maximum pitch and the number of pixels that it needs.
    pub fn check_pitch(&self, subject: &str, lambda_min_nm: f64) -> Result<()> {
        let limit_um = lambda_min_nm / 4000.0;
        let axes =
            [("x", self.pitch_x_um, self.size_x_um()), ("y", self.pitch_y_um, self.size_y_um())];
        let is_coarse = |pitch_um: f64| pitch_um > limit_um * (1.0 + 1e-9) || limit_um.is_nan();
        let coarse: Vec<_> = axes.into_iter().filter(|(_, pitch, _)| is_coarse(*pitch)).collect();
        if coarse.is_empty() {
            return Ok(());
        }
        let list = |of: &dyn Fn(&(&str, f64, f64)) -> String| -> String {
            coarse.iter().map(of).collect::<Vec<_>>().join(" and ")
        };
        let cause = format!(
            "pixel pitch {} is above a quarter of the shortest wavelength, {lambda_min_nm} nm",
            list(&|(axis, pitch, _)| format!("{:.4} nm along {axis}", pitch * 1000.0))
        );
        let pixels = list(&|(axis, _, size)| {
            let count = (size / limit_um * (1.0 - 1e-12)).ceil();
            format!("{count} pixels over {size:.4} µm along {axis}")
        });
        let longest = coarse.iter().map(|(_, pitch, _)| *pitch).fold(0.0, f64::max);
        let remedy = format!(
            "use a pitch of at most {:.4} nm, which is {pixels} (check `size_um`, `size_y_um` or `pixel_um` of a file, `pixels` of a grating); or `resample_um = {}` of a file, after which nothing finer than the scan is known; or wavelengths of at least {:.0} nm",
            limit_um * 1000.0,
            (limit_um * 1e6).floor() / 1e6,
            (longest * 4000.0).ceil()
        );
        Err(Error::new(subject, cause).remedy(remedy))
    }
}

/// Checks a length in µm given under `key`: positive, finite, at most `max_um`.
fn check_um(subject: &str, key: &str, value_um: f64, max_um: f64) -> Result<()> {
    let error = |cause: String| Error::new(subject, cause);
    if !(value_um.is_finite() && value_um > 0.0) {
        return Err(error(format!("`{key} = {value_um}` is not positive and finite"))
            .remedy("give a length in µm"));
    }
    if value_um > max_um {
        return Err(error(format!("`{key} = {value_um}` is above {max_um} µm"))
            .remedy("lengths are in µm; check whether this number is in nm"));
    }
    Ok(())
}

/// Checks a pixel pitch, µm, against [`MIN_PITCH_UM`] and [`MAX_PITCH_UM`]; `origin` names the key that it comes from.
fn check_pixel(subject: &str, origin: &str, pitch_um: f64) -> Result<()> {
    if (MIN_PITCH_UM..=MAX_PITCH_UM).contains(&pitch_um) {
        return Ok(());
    }
    let cause = format!(
        "{origin} gives a pixel pitch of {pitch_um} µm, outside {MIN_PITCH_UM} to {MAX_PITCH_UM} µm"
    );
    let guess = if pitch_um > MAX_PITCH_UM { "nm" } else { "m or mm" };
    Err(Error::new(subject, cause)
        .remedy(format!("lengths are in µm; check whether this number is in {guess}")))
}

/// Checks the number of pixels before memory is allocated.
fn check_pixels(subject: &str, columns: u64, rows: u64) -> Result<(usize, usize)> {
    let error = |cause: String| Error::new(subject, cause);
    if columns == 0 || rows == 0 {
        return Err(error(format!("has {columns} × {rows} pixels, so it has no heights"))
            .remedy("check that this is the right file"));
    }
    let side = columns.max(rows);
    if side > MAX_SIDE as u64 || columns * rows > MAX_PIXELS as u64 {
        let cause = format!(
            "{columns} × {rows} pixels are above the limit of {MAX_SIDE} per side and 8192² in all"
        );
        return Err(
            error(cause).remedy("crop the surface, or scale it down to a pitch of about 95 nm")
        );
    }
    Ok((columns as usize, rows as usize))
}
