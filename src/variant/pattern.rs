//! A pattern: the relief of a texel, made of that of the surface by turning and scaling it.

use glam::{DVec2, DVec4};

use crate::error::{Error, Result};
use crate::plan::Variant;
use crate::surface::HeightField;

/// Angle, period and depth of a texel, relative to those of the surface. `T_{a,b}(u, v, w) = T(a u, a v, b w)` with lobes of the
/// same width, which is exact: the orders of a scaled cell are at `m/(a d)`, and their efficiencies are those at the phase of the
/// scaled depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    /// Angle by which the relief is turned, degrees, from the tangent towards the bitangent.
    pub angle_deg: f64,
    /// Period, relative to that of the surface.
    pub period_ratio: f64,
    /// Depth, relative to that of the surface.
    pub depth_ratio: f64,
}

impl Pattern {
    /// The surface as it is.
    pub const NONE: Pattern = Pattern { angle_deg: 0.0, period_ratio: 1.0, depth_ratio: 1.0 };

    /// The patterns of probes: the surface as it is, and the corners of the ranges of a variant. The ratios are exact in 32-bit
    /// floats.
    pub fn probes(variant: &Variant) -> [Pattern; 4] {
        let ([short, long], [flat, deep]) = (variant.period_ratio, variant.depth_ratio);
        let own = |[least, most]: [f64; 2]| 1.0_f64.clamp(least, most);
        let pattern = |angle_deg, period_ratio: f64, depth_ratio: f64| Pattern {
            angle_deg,
            period_ratio: f64::from(period_ratio as f32),
            depth_ratio: f64::from(depth_ratio as f32),
        };
        [
            pattern(0.0, own(variant.period_ratio), own(variant.depth_ratio)),
            pattern(35.0, short, deep),
            pattern(125.0, long, flat),
            pattern(-80.0, 0.5 * (short + long), 0.5 * (flat + deep)),
        ]
    }

    /// The argument of functions: cosine and sine of the angle, period ratio, depth ratio.
    pub fn argument(&self) -> DVec4 {
        let turn = DVec2::from_angle(self.angle_deg.to_radians());
        DVec4::new(turn.x, turn.y, self.period_ratio, self.depth_ratio)
    }

    /// The relief of the texel, without the angle.
    pub fn scaled(&self, height: &HeightField) -> Result<HeightField> {
        let heights_um = height.heights_um().iter().map(|h| h * self.depth_ratio).collect();
        let [x, y] = [height.pitch_x_um(), height.pitch_y_um()].map(|um| um * self.period_ratio);
        HeightField::new(height.columns(), height.rows(), x, y, heights_um)
    }

    /// Returns an error if a variant has no patterns, or none with these ratios.
    pub fn check(&self, variant: &Variant) -> Result<()> {
        if !variant.pattern {
            let cause = "its functions have no argument for a pattern";
            return Err(Error::new(&variant.name, cause)
                .remedy("use mode = \"orders\" with pattern = true, or --runner exact"));
        }
        let all = [
            ("period_ratio", self.period_ratio, variant.period_ratio),
            ("depth_ratio", self.depth_ratio, variant.depth_ratio),
        ];
        for (key, ratio, [least, greatest]) in all {
            if !(least..=greatest).contains(&ratio) {
                let cause =
                    format!("{key} is {ratio}, but its tables reach from {least} to {greatest}");
                return Err(Error::new(&variant.name, cause)
                    .remedy(format!("widen {key} in the plan, or change the pattern")));
            }
        }
        Ok(())
    }
}
