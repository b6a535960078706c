//! Flags that several commands share.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Result;
use diffraction_shaders::input;
use diffraction_shaders::plan::Plan;

use crate::console::{Console, Errors};

/// The plan.
#[derive(Clone, Debug, clap::Args)]
pub struct PlanArgs {
    /// The plan to read.
    #[arg(long, value_name = "FILE", default_value = "plan.toml")]
    pub plan: PathBuf,
}

impl PlanArgs {
    /// Reads the plan and tells its notes; the error holds every fault.
    pub fn read(&self, console: &Console) -> Result<Plan> {
        let plan = input::read_plan(&self.plan).map_err(Errors)?;
        plan.notes.iter().for_each(|note| console.note(note));
        Ok(plan)
    }
}

/// One surface of a plan.
#[derive(Clone, Debug, clap::Args)]
pub struct SurfaceArgs {
    /// The plan that holds it.
    #[command(flatten)]
    pub plan: PlanArgs,
    /// The surface to take from the plan.
    #[arg(long, value_name = "NAME")]
    pub surface: String,
}

/// Which variant, and what runs it.
#[derive(Clone, Debug, clap::Args)]
pub struct RunnerArgs {
    /// The variant; not needed where the plan has only one, and ignored by `exact`.
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// What computes the colours.
    #[arg(long, value_enum, default_value_t = Runner::Exact)]
    pub runner: Runner,
    /// Let the twin read the tables before they are rounded.
    #[arg(long)]
    pub unpacked: bool,
    /// Take the adapter whose name contains this, such as llvmpipe (lavapipe) or swiftshader; else graphics cards come first.
    #[arg(long, value_name = "SUBSTRING")]
    pub adapter: Option<String>,
}

/// What computes the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Runner {
    /// The exact f64 reference, 380–780 nm.
    Exact,
    /// The f64 copy of the variant's algorithm.
    Twin,
    /// The shader on Vulkan.
    Vulkan,
    /// The shader on OpenGL.
    Gl,
    /// The emitted SPIR-V on Vulkan, as it is.
    Spirv,
    /// The emitted HLSL on Vulkan, compiled by glslangValidator.
    Hlsl,
    /// The emitted GLSL 4.50 text on a desktop GL context.
    #[value(name = "glsl450")]
    Glsl450,
    /// The emitted GLSL ES 3.00 text on a GL ES context.
    #[value(name = "glsl-es300")]
    GlslEs300,
    /// The emitted WGSL in a headless Chromium's WebGPU.
    #[value(name = "webgpu")]
    WebGpu,
    /// The emitted GLSL ES 3.00 text in a headless Chromium's WebGL2.
    #[value(name = "webgl2")]
    WebGl2,
}

impl Runner {
    /// Whether it needs a driver, and so the harness.
    pub fn is_driver(self) -> bool {
        !matches!(self, Runner::Exact | Runner::Twin)
    }
}

/// Direction of the light, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// From the normal, 0 to below 90.
    pub theta_deg: f64,
    /// From the tangent.
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
                Err("expected THETA,PHI in degrees, THETA from 0 to below 90, such as 20,0"
                    .to_owned())
            }
        }
    }
}

/// Exposure of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Half of the inverse 95th percentile of Y.
    Auto,
    /// As given.
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

/// A wavelength in nm within the range of the spectral tables.
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
