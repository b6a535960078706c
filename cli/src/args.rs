//! Options that several commands share.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Result;
use diffraction_shaders::input;
use diffraction_shaders::plan::Plan;
use diffraction_shaders::variant::Pattern;

use crate::console::{Console, Errors};

/// The option for the plan.
#[derive(Clone, Debug, clap::Args)]
pub struct PlanArgs {
    /// The plan: a TOML file with surfaces, variants and targets.
    #[arg(long, value_name = "FILE", default_value = "plan.toml")]
    pub plan: PathBuf,
}

impl PlanArgs {
    /// Reads the plan and prints its notes. The error lists every fault of the plan.
    pub fn read(&self, console: &Console) -> Result<Plan> {
        let plan = input::read_plan(&self.plan).map_err(Errors)?;
        plan.notes.iter().for_each(|note| console.note(note));
        Ok(plan)
    }
}

/// The options for one surface of a plan.
#[derive(Clone, Debug, clap::Args)]
pub struct SurfaceArgs {
    /// The plan with the surface.
    #[command(flatten)]
    pub plan: PlanArgs,
    /// Name of the surface, as in the plan.
    #[arg(long, value_name = "NAME")]
    pub surface: String,
}

/// The options for the variant and for what computes its colours.
#[derive(Clone, Debug, clap::Args)]
pub struct RunnerArgs {
    /// Name of the variant, as in the plan. Needed only if the plan has several; the runner `exact` ignores it.
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// What computes the colours: the exact reference, the variant's twin, or its shader on a driver.
    #[arg(long, value_enum, default_value_t = Runner::Exact)]
    pub runner: Runner,
    /// With --runner twin: use the tables before they are rounded to their number format.
    #[arg(long)]
    pub unpacked: bool,
    /// Use the first adapter whose name contains this text, such as llvmpipe (also lavapipe) or swiftshader. Default: graphics cards
    /// before software drivers.
    #[arg(long, value_name = "SUBSTRING")]
    pub adapter: Option<String>,
    /// Do not compare some of the driver's colours with the twin before the first result.
    #[arg(long)]
    pub unchecked: bool,
    /// Evaluate a texel of a pattern: the relief turned by an angle in degrees, with its period and its depth multiplied. Runners other
    /// than exact need a variant with pattern = true, and ratios within its period_ratio and depth_ratio.
    #[arg(long, value_name = "ANGLE_DEG,PERIOD,DEPTH", value_parser = pattern, allow_hyphen_values = true)]
    pub pattern: Option<Pattern>,
}

fn pattern(text: &str) -> Result<Pattern, String> {
    let numbers: Vec<f64> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    let is_ratio = |ratio: f64| (0.1..=10.0).contains(&ratio);
    match numbers[..] {
        [angle_deg, period_ratio, depth_ratio]
            if text.split(',').count() == 3
                && angle_deg.is_finite()
                && is_ratio(period_ratio)
                && is_ratio(depth_ratio) =>
        {
            Ok(Pattern { angle_deg, period_ratio, depth_ratio })
        }
        _ => Err("expected an angle in degrees and two ratios from 0.1 to 10, such as 30,1.2,1"
            .to_owned()),
    }
}

/// What computes the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Runner {
    /// The exact reference in 64 bits, 380–780 nm; needs no variant.
    Exact,
    /// The variant's algorithm in 64 bits, without a driver.
    Twin,
    /// The variant's shader on Vulkan, translated by wgpu.
    Vulkan,
    /// The variant's shader on OpenGL, translated by wgpu.
    Gl,
    /// The emitted SPIR-V on Vulkan, unchanged.
    Spirv,
    /// The emitted HLSL on Vulkan, compiled by glslangValidator.
    Hlsl,
    /// The emitted GLSL 4.50 on desktop OpenGL.
    #[value(name = "glsl450")]
    Glsl450,
    /// The emitted GLSL ES 3.00 on OpenGL ES.
    #[value(name = "glsl-es300")]
    GlslEs300,
    /// The emitted WGSL in the WebGPU of a headless Chromium.
    #[value(name = "webgpu")]
    WebGpu,
    /// The emitted GLSL ES 3.00 in the WebGL2 of a headless Chromium.
    #[value(name = "webgl2")]
    WebGl2,
}

impl Runner {
    /// Whether it runs on a driver. Only the harness has drivers.
    pub fn is_driver(self) -> bool {
        !matches!(self, Runner::Exact | Runner::Twin)
    }
}

/// Direction towards the light, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Angle from the surface normal, at least 0 and below 90.
    pub theta_deg: f64,
    /// Angle about the normal, counted from the tangent.
    pub phi_deg: f64,
}

impl FromStr for Light {
    type Err = String;

    fn from_str(text: &str) -> Result<Light, String> {
        let numbers: Option<Vec<f64>> =
            text.split(',').map(|part| part.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([theta, phi]) if (0.0..90.0).contains(theta) && phi.is_finite() => {
                Ok(Light { theta_deg: *theta, phi_deg: *phi })
            }
            _ => {
                Err("expected THETA,PHI in degrees, such as 20,0; THETA is at least 0 and below 90"
                    .to_owned())
            }
        }
    }
}

/// Exposure of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// 0.5 divided by the 95th percentile of Y.
    Auto,
    /// The given factor.
    Value(f64),
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Exposure, String> {
        match text.parse::<f64>() {
            _ if text == "auto" => Ok(Exposure::Auto),
            Ok(value) if value.is_finite() && value > 0.0 => Ok(Exposure::Value(value)),
            _ => Err("expected \"auto\" or a positive number".to_owned()),
        }
    }
}

/// Reads a wavelength in nm. The spectral tables reach from 360 to 830 nm.
pub fn wavelength_nm(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (360.0..=830.0).contains(value));
    value.ok_or_else(|| "expected a wavelength from 360 to 830 nm".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_exposures_and_wavelengths_are_read_or_refused() {
        assert_eq!("20,0".parse(), Ok(Light { theta_deg: 20.0, phi_deg: 0.0 }));
        assert_eq!("0, -90".parse(), Ok(Light { theta_deg: 0.0, phi_deg: -90.0 }));
        for text in ["", "20", "90,0", "-1,0", "nan,0", "20,inf", "1,2,3"] {
            assert!(text.parse::<Light>().is_err(), "{text}");
        }
        assert_eq!("auto".parse(), Ok(Exposure::Auto));
        assert_eq!("2.5".parse(), Ok(Exposure::Value(2.5)));
        assert!(
            ["0", "-1", "nan", "inf", "x"].iter().all(|text| text.parse::<Exposure>().is_err())
        );
        assert_eq!(wavelength_nm("550"), Ok(550.0));
        assert!(["359", "831", "nan", ""].iter().all(|text| wavelength_nm(text).is_err()));
    }
}
