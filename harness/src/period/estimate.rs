//! The period that a surface shows along the plane of incidence.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::facts::periods;

/// A period counts for the plane of incidence if it repeats within this angle of it, degrees.
const ALONG_DEG: f64 = 5.0;

/// The dominant spatial period of the heights along a direction of the surface's own frame, degrees from `+x`, µm: that of
/// the strongest peak of their spectrum near it; along x and y, where there is none, whatever repeats along that axis.
///
/// `tiled`: whether the patch is known to join itself along x and y.
pub fn expected_um(
    height: &HeightField,
    tiled: [bool; 2],
    along_deg: f64,
    subject: &str,
) -> Result<f64> {
    let found = periods(height, tiled);
    let axes = found.along_x.peaks.iter().chain(&found.along_y.peaks);
    let apart = |deg: f64| (along_deg - deg + 90.0).rem_euclid(180.0) - 90.0;
    let along = found.peaks.iter().chain(axes).find(|p| apart(p.direction_deg).abs() < ALONG_DEG);
    along.map(|peak| peak.period_um).ok_or_else(|| {
        let cause =
            format!("shows no period along the plane of incidence, {along_deg}° from its x");
        Error::new(subject, cause).remedy("say where to search with --period-nm")
    })
}
