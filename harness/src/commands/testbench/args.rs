//! Options of `cargo xtask testbench`.

use std::path::PathBuf;
use std::str::FromStr;

use diffraction_cli::args::{Runner, SurfaceArgs, wavelength_nm};
use diffraction_cli::memory::MemoryArgs;
use diffraction_shaders::plan::Wavelengths;
use diffraction_shaders::surface::HeightField;

const EXAMPLE: &str = "Examples:
  cargo xtask testbench --plan plan.toml --surface blazed --svg blazed.svg
  cargo xtask testbench --surface fingers --variant preview --windows 9 --window-um 8 --json
  cargo xtask testbench --surface blazed --out target/compare
  cargo xtask report target/compare

The viewer moves in the plane of incidence. With --phi-i 0 and an unrotated surface this plane contains the surface's x axis.
The viewing angle theta_r is positive on the mirror side (phi_r = phi_i + 180°) and negative on the side of the light. The
response is |P|², without the gain. For each wavelength the angle of the strongest response gives a period by the grating
equation, first order; their mean is the result.

The efficiency of an order varies over its lobe and shifts the peak away from the grating equation. This is physics: the
column \"closed form\" shows the same shift.

Without --variant, the exact reference and all variants of the plan are measured. If there are several results, file names
get the variant's name and the window's number as a suffix.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(super) surface: SurfaceArgs,
    #[command(flatten)]
    pub(super) memory: MemoryArgs,
    /// Measure only this variant, or `exact` for the exact reference. Default: all variants and `exact`.
    #[arg(long, value_name = "NAME")]
    pub(super) variant: Option<String>,
    /// What computes the responses of variants. Default: twin.
    #[arg(long, value_enum)]
    runner: Option<Runner>,
    /// With --runner twin: use the tables before they are rounded to their number format.
    #[arg(long)]
    pub(super) unpacked: bool,
    /// Use the first adapter whose name contains this text. Default: graphics cards before software drivers.
    #[arg(long, value_name = "SUBSTRING")]
    pub(super) adapter: Option<String>,
    /// Do not compare some of the driver's colours with the twin before the first result.
    #[arg(long)]
    pub(super) unchecked: bool,
    /// Angle of incidence, in degrees from the normal.
    #[arg(long, value_name = "DEG", default_value_t = 75.0, value_parser = incidence_deg)]
    pub(super) theta_i: f64,
    /// Angle of the light about the normal, in degrees from the surface's tangent.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite)]
    pub(super) phi_i: f64,
    /// Range and step of the wavelengths, in nm.
    #[arg(long, value_name = "MIN,MAX,STEP", default_value = "380,780,5")]
    pub(super) wavelengths: Range,
    /// Expected period, in nm: the search is around it. Default: the dominant period along the plane of incidence.
    #[arg(long, value_name = "D", value_parser = positive)]
    pub(super) period_nm: Option<f64>,
    /// Measure windows of the surface instead of the whole: at least N, evenly spread.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    windows: Option<u32>,
    /// Side of a window, in µm. Default: half of the surface's shorter side.
    #[arg(long, value_name = "W", value_parser = positive, requires = "windows")]
    window_um: Option<f64>,
    /// Write every sample to a CSV file: wavelength, angle, response.
    #[arg(long, value_name = "FILE.csv")]
    pub(super) csv: Option<PathBuf>,
    /// Draw the response over wavelength and angle, with the periods beside it.
    #[arg(long, value_name = "FILE.svg")]
    pub(super) svg: Option<PathBuf>,
    /// Folder for results, for a report: records are appended to DIR/records.jsonl, pictures are drawn into DIR/pictures.
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print one JSON object per result instead of a table.
    #[arg(long)]
    pub(super) json: bool,
}

impl Args {
    /// The runner for variants.
    pub(super) fn runner(&self) -> Runner {
        self.runner.unwrap_or(Runner::Twin)
    }

    /// Name of the runner.
    pub(super) fn runner_name(&self) -> String {
        let value = clap::ValueEnum::to_possible_value(&self.runner());
        value.map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Whether only the exact reference is measured.
    pub(super) fn only_exact(&self) -> bool {
        self.variant.as_deref() == Some("exact") || self.runner == Some(Runner::Exact)
    }

    /// Minimum number of windows, and their side in µm.
    pub(super) fn windows(&self, field: &HeightField) -> Option<(usize, f64)> {
        let side_um = || 0.5 * field.size_x_um().min(field.size_y_um());
        self.windows.map(|count| (count as usize, self.window_um.unwrap_or_else(side_um)))
    }
}

/// `MIN,MAX,STEP` in nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range(pub(super) Wavelengths);

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Range, String> {
        let fail = || {
            "expected MIN,MAX,STEP in nm, such as 380,780,5: between 360 and 830, with a step of at least 0.01"
                .to_owned()
        };
        let [min, max, step] = text.split(',').map(str::trim).collect::<Vec<_>>()[..] else {
            return Err(fail());
        };
        let (min_nm, max_nm) = (wavelength_nm(min)?, wavelength_nm(max)?);
        let step_nm = step.parse::<f64>().map_err(|_| fail())?;
        if min_nm > max_nm || !(0.01..=830.0).contains(&step_nm) {
            return Err(fail());
        }
        Ok(Range(Wavelengths { min_nm, max_nm, step_nm }))
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| "expected a number".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|v| *v > 0.0).ok_or_else(|| "expected a positive number".to_owned())
}

fn incidence_deg(text: &str) -> Result<f64, String> {
    let value = finite(text).ok().filter(|value| (0.0..90.0).contains(value));
    value.ok_or_else(|| "expected an angle in degrees, at least 0 and below 90".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_angles_are_read_or_refused() {
        let waves = Wavelengths { min_nm: 400.0, max_nm: 700.0, step_nm: 2.5 };
        assert_eq!("400, 700,2.5".parse(), Ok(Range(waves)));
        assert!("550,550,1".parse::<Range>().is_ok());
        for text in ["", "400,700", "700,400,5", "400,700,0", "400,700,nan", "300,700,5", "a,b,c"] {
            assert!(text.parse::<Range>().is_err(), "{text}");
        }
        assert!(["90", "-1", "nan", ""].iter().all(|text| incidence_deg(text).is_err()));
        assert!(["0", "-2", "inf", "x"].iter().all(|text| positive(text).is_err()));
    }
}
