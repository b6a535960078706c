//! What a TIFF states: calibrations of ImageJ and OME in its description, and resolutions that are not for printers.
//!
//! Sources: ImageJ writes lines `key=value` (`unit`, `c0`, `c1`, `vunit`) and pixels per unit as resolution; OME-TIFF
//! (Open Microscopy Environment, schema 2016-06) writes XML with `Pixels PhysicalSizeX`, in µm by default.

use roxmltree::Document;

use crate::surface::length::{Unit, unit};
use crate::surface::raster::{Lateral, Stated};

/// A pitch above this, in µm, is that of a printer or a screen (2540 dots per inch), not of a scan.
const PRINTED_UM: f64 = 10.0;

/// The tags that may state a scale.
pub(super) struct Tags {
    pub description: String,
    /// Pixels per unit along x and y.
    pub resolution: [Option<f64>; 2],
    /// `ResolutionUnit`: 1 none, 2 inch, 3 centimetre.
    pub resolution_unit: u32,
    /// Largest number of an integer sample.
    pub top: f64,
}

/// What the tags state.
pub(super) fn stated(tags: &Tags) -> Stated {
    if tags.description.starts_with("ImageJ=") {
        return imagej(tags);
    }
    ome(&tags.description).unwrap_or_else(|| resolution(tags))
}

fn per_pixel(resolution: Option<f64>) -> Option<f64> {
    resolution.filter(|r| r.is_finite() && *r > 0.0).map(|r| 1.0 / r)
}

fn imagej(tags: &Tags) -> Stated {
    let value = |key: &str| {
        let lines = tags.description.lines();
        lines
            .filter_map(|line| line.split_once('='))
            .find(|(k, _)| k.trim() == key)
            .map(|(_, v)| v.trim())
    };
    let mut stated = Stated::default();
    // without a unit, or in pixels, ImageJ's resolution means nothing
    if let Some(Unit::Length(um)) = value("unit").map(unit) {
        stated.pitch = tags.resolution.map(per_pixel);
        stated.lateral = Lateral::Um(um);
        stated.pitch_by = "ImageJ's unit and XResolution".to_owned();
    }
    let number = |key: &str| value(key)?.parse::<f64>().ok().filter(|v| v.is_finite());
    if let Some(words) = value("vunit") {
        stated.heights_by = "ImageJ's vunit".to_owned();
        let straight = value("cf").is_none_or(|function| function == "0");
        match (unit(words), number("c0"), number("c1")) {
            // numbers of floats are calibrated already
            (Unit::Length(um), Some(c0), Some(c1)) if straight && c1 != 0.0 => {
                stated.range_um = Some([c0 * um, (c0 + c1 * tags.top) * um]);
                stated.unit = Some(Unit::Length(um));
            }
            (found, ..) => stated.unit = Some(found),
        }
    }
    stated
}

fn ome(description: &str) -> Option<Stated> {
    let text = description.trim_start_matches('\u{feff}').trim_matches(['\0', ' ', '\n', '\r']);
    if !text.starts_with('<') {
        return None;
    }
    let document = Document::parse(text).ok()?;
    let pixels = document.descendants().find(|node| node.tag_name().name() == "Pixels")?;
    let axis = |axis: char| {
        let size = pixels.attribute(format!("PhysicalSize{axis}").as_str())?.parse::<f64>().ok()?;
        let words = pixels.attribute(format!("PhysicalSize{axis}Unit").as_str()).unwrap_or("µm");
        match unit(words) {
            Unit::Length(um) if size.is_finite() && size > 0.0 => Some(size * um),
            _ => None,
        }
    };
    Some(Stated {
        pitch: [axis('X'), axis('Y')],
        lateral: Lateral::Um(1.0),
        pitch_by: "PhysicalSizeX of the OME description".to_owned(),
        ..Stated::default()
    })
}

/// The plain tags, if their pixels are those of a scan.
fn resolution(tags: &Tags) -> Stated {
    let um = match tags.resolution_unit {
        2 => 25_400.0,
        3 => 10_000.0,
        _ => return Stated::default(),
    };
    let pitch = tags.resolution.map(|r| per_pixel(r).map(|pitch| pitch * um));
    if pitch.iter().flatten().any(|pitch| *pitch > PRINTED_UM) {
        return Stated::default();
    }
    Stated {
        pitch,
        lateral: Lateral::Um(1.0),
        pitch_by: "XResolution, YResolution".to_owned(),
        ..Stated::default()
    }
}
