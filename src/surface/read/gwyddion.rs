//! The keys that Gwyddion writes into pictures: sizes, units and the heights of black and white.
//!
//! Source: the names in Gwyddion's `hdrimage`: `Gwy::XReal`, `Gwy::YReal`, `Gwy::XYUnit`, `Gwy::ZUnit` (also with an `s`);
//! `Gwy::ZMin` and `Gwy::ZMax` are the heights of 0 and of the largest integer, `Gwy::ZScale` that of 1.0.

use crate::surface::length::{Unit, unit};
use crate::surface::raster::Stated;

/// What keys and values state about a picture of `pixels` columns and rows. Capitals in keys do not matter.
pub(super) fn stated(entries: &[(String, String)], pixels: [usize; 2]) -> Stated {
    let text = |names: &[&str]| {
        let is_named = |key: &str| {
            let key = key.to_ascii_lowercase();
            key.strip_prefix("gwy::").is_some_and(|key| names.contains(&key))
        };
        entries.iter().find(|(key, _)| is_named(key)).map(|(_, value)| value.trim())
    };
    let number = |name: &str| text(&[name])?.parse::<f64>().ok().filter(|v| v.is_finite());
    // base units are what the program works in
    let of = |names: &[&str]| text(names).map_or(Unit::Length(1e6), unit);
    let mut stated = Stated::default();
    let (lateral, z) = (of(&["xyunit", "xyunits"]), of(&["zunit", "zunits"]));
    stated.sizes([number("xreal"), number("yreal")], pixels, &lateral, "Gwy::XReal, Gwy::YReal");
    let range = [number("zmin"), number("zmax")];
    match (&z, range) {
        (Unit::Length(um), [Some(low), Some(high)]) if low != high => {
            stated.range_um = Some([low * um, high * um]);
            stated.heights_by = "Gwy::ZMin, Gwy::ZMax".to_owned();
        }
        _ => {}
    }
    let named = text(&["zunit", "zunits"]).is_some();
    if let Some(scale) = number("zscale").filter(|s| *s > 0.0).or(named.then_some(1.0)) {
        stated.heights_by = match range {
            [Some(_), Some(_)] => stated.heights_by,
            _ => "Gwy::ZScale, Gwy::ZUnit".to_owned(),
        };
        stated.unit = Some(match z {
            Unit::Length(um) => Unit::Length(um * scale),
            other => other,
        });
    }
    stated
}
