//! The texture of glTF's extension `KHR_materials_anisotropy` as a pattern.

use png::ColorType;

use super::file::Pixels;
use super::{MAX_ANGLE_SPREAD_RAD, PatternMap, Texel};
use crate::error::{Error, Result};

/// What a material says beside its texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anisotropy {
    /// `anisotropyStrength`, a factor on blue, from 0 to 1. glTF's own default, 0, would make every texture isotropic.
    pub strength: f64,
    /// `anisotropyRotation`, added to all angles.
    pub rotation_rad: f64,
}

impl Default for Anisotropy {
    /// The texture as it is.
    fn default() -> Anisotropy {
        Anisotropy { strength: 1.0, rotation_rad: 0.0 }
    }
}

impl PatternMap {
    /// Decodes a PNG with red, green and blue, of 8 or 16 bits; an alpha channel is ignored. Red and green are the direction of
    /// increased roughness, `2R/n - 1` and `2G/n - 1` along tangent and bitangent, which is across the grooves; blue is the strength.
    /// All are linear numbers. Ratios and masks are 1.
    ///
    /// glTF widens a lobe by the strength; here it is how well grooves are aligned. `R = strength·|direction|` counts as the length
    /// of the mean of their unit vectors, so `σφ² = -2 ln R`, at most [`MAX_ANGLE_SPREAD_RAD`]: 0 at strength 1, 26° at 0.9, 67° at
    /// 0.5, evenly distributed at 0. A direction as long as 1, to the rounding of its channels, is 1.
    ///
    /// Where the strength is not 0, a direction within one step of zero is refused. `subject` names the file in errors.
    pub fn from_anisotropy(bytes: &[u8], of: &Anisotropy, subject: &str) -> Result<PatternMap> {
        let error = |cause: String| Error::new(subject, cause);
        if !((0.0..=1.0).contains(&of.strength) && of.rotation_rad.is_finite()) {
            let cause =
                format!("has the strength {} and the rotation {}", of.strength, of.rotation_rad);
            return Err(error(cause).remedy("give a strength from 0 to 1 and a finite angle"));
        }
        let pixels = Pixels::decode(bytes, &[ColorType::Rgb, ColorType::Rgba], subject)?;
        let top = pixels.top();
        let (step, rounding) = (2.0 / top, 2f64.sqrt() / top);
        let mut zero = Vec::new();
        let mut texels = Vec::with_capacity(pixels.width * pixels.height);
        for (i, samples) in pixels.samples.chunks_exact(pixels.channels).enumerate() {
            let [x, y] = [0, 1].map(|c| 2.0 * f64::from(samples[c]) / top - 1.0);
            let strength = of.strength * f64::from(samples[2]) / top;
            if strength > 0.0 && x.abs() <= step && y.abs() <= step {
                zero.push(i);
            }
            let length = x.hypot(y);
            let length = if length > 1.0 - rounding { 1.0 } else { length };
            let spread = (-2.0 * (strength * length).ln()).max(0.0).sqrt();
            texels.push(Texel {
                angle_rad: y.atan2(x) + of.rotation_rad,
                angle_spread_rad: spread.min(MAX_ANGLE_SPREAD_RAD),
                ..Texel::default()
            });
        }
        if let Some(first) = zero.first() {
            let (column, row) = (first % pixels.width, first / pixels.width);
            let cause = format!(
                "has {} texels without a direction (red and green in the middle of their range), the first at column {column}, row {row}",
                zero.len()
            );
            return Err(error(cause).remedy("give them a direction, or the strength 0 in blue"));
        }
        PatternMap::new(pixels.width, pixels.height, texels, subject)
    }
}
