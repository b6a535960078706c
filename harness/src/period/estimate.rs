//! Estimates the period of a surface along the plane of incidence.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::facts::periods;

/// Maximum angle between the direction of a period and the plane of incidence, degrees.
const ALONG_DEG: f64 = 5.0;

/// The dominant spatial period of the heights, in µm, along a direction of the surface's own frame in degrees from `+x`: the
/// strongest peak of their spectrum near it. Without such a peak, along x and y, the dominant period along that axis.
///
/// `tiled`: whether the patch is known to tile without a seam along x and y.
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
            format!("has no period along the plane of incidence, {along_deg}° from its x axis");
        Error::new(subject, cause).remedy("give the expected period with --period-nm")
    })
}
