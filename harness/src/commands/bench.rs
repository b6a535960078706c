//! `cargo xtask bench`: measures the frame time of every variant on every adapter.

mod adapters;
mod output;
mod tables;
mod timed;
mod work;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use diffraction_cli::Outcome;
use diffraction_cli::args::{Light, PlanArgs};
use diffraction_cli::console::Console;
use diffraction_cli::memory::MemoryArgs;
use diffraction_shaders::light::Studio;
use diffraction_shaders::plan::Variant;

use crate::commands::restart;

const EXAMPLE: &str = "Examples:
  cargo xtask bench --plan plan.toml --surface blazed --variant 'full-*' --backend vulkan
  cargo xtask bench --plan plan.toml --save before
  cargo xtask bench --plan plan.toml --compare-to before --out measured
  cargo xtask bench --plan plan.toml --surface blazed --variant preview --size 1920x1080 --ggx
  cargo xtask bench --surface cd --variant sun --baseline sun --disc-deg 0.53
  cargo xtask bench --surface cd --variant sun --baseline sun --studio softboxes --ggx --size 1920x1080
  cargo xtask bench --plan plans/growth.toml --scaling --out growth

Ratio = time of the baseline / time of the variant. Times depend on the other load of the machine. Ratios hardly do, since
baseline and variants are drawn in turns.";

/// Mesa caches compiled shaders on disk. With that cache, creating a pipeline would seem to cost nothing.
const NO_SHADER_CACHE: (&str, &str) = ("MESA_SHADER_CACHE_DISABLE", "true");

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Measure only the surface of this name; may be repeated. Default: all surfaces.
    #[arg(long, value_name = "NAME")]
    surface: Vec<String>,
    /// Measure only variants whose name matches this pattern (`*`, `?`); may be repeated. Default: all variants. The built-in
    /// `texts` must be named.
    #[arg(long, value_name = "GLOB", num_args = 1..)]
    variant: Vec<String>,
    /// Use only adapters of this graphics interface; may be repeated. Default: vulkan and gl.
    #[arg(long, value_enum)]
    backend: Vec<Interface>,
    /// Use only adapters whose name or driver contains this text. Default: all adapters.
    #[arg(long, value_name = "SUBSTRING")]
    adapter: Option<String>,
    /// Direction towards the light, in degrees: THETA from the normal, PHI about it from the tangent.
    #[arg(long, value_name = "THETA,PHI", default_value = "20,0", allow_hyphen_values = true)]
    light: Light,
    /// Size of the map in pixels: one number for a square, or width x height.
    #[arg(long, value_name = "N|WxH", default_value = "256", value_parser = frame)]
    size: Frame,
    /// The variant that the others are compared with; `texts` is the thesis's shader as printed.
    #[arg(long, value_name = "NAME", default_value = Variant::TEXTS)]
    baseline: String,
    /// Time to measure each variant on each adapter, in seconds. At least 6 rounds are drawn in any case.
    #[arg(long, value_name = "S", default_value_t = 5.0, value_parser = seconds)]
    seconds: f64,
    /// Also time each variant that has `diffraction_disc` under a disc of this diameter, in degrees.
    #[arg(long, value_name = "DEG", value_parser = diameter, conflicts_with = "scaling")]
    disc_deg: Option<f64>,
    /// Also time each variant that has `diffraction_environment` in this studio; with --ggx, also an ordinary material there.
    #[arg(long, value_name = "NAME", value_parser = studio, conflicts_with = "scaling")]
    studio: Option<Studio>,
    /// Also time a shader that computes only the gain: no variant can be faster.
    #[arg(long)]
    empty: bool,
    /// Also time an ordinary material, for scale: a GGX lobe and one texel of base colour.
    #[arg(long)]
    ggx: bool,
    /// Instead, measure how time grows: vary pixels, terms, radius, number and range of wavelengths, and width and height of the
    /// surface, one at a time.
    #[arg(long)]
    scaling: bool,
    /// Save the results under this name, in target/bench or in the folder of --out.
    #[arg(long, value_name = "NAME", value_parser = name, conflicts_with = "scaling")]
    save: Option<String>,
    /// Show the change since the results that --save saved under this name.
    #[arg(long, value_name = "NAME", value_parser = name, conflicts_with = "scaling")]
    compare_to: Option<String>,
    /// Folder for results, for a report: each is appended to DIR/records.jsonl as soon as it is known.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object per result instead of tables.
    #[arg(long)]
    json: bool,
    /// Do not compare some of the driver's colours with the twin before the first result.
    #[arg(long)]
    unchecked: bool,
}

/// A graphics interface of the operating system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Interface {
    Vulkan,
    Gl,
    Metal,
    Dx12,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    restart::with_routes(&[NO_SHADER_CACHE])?;
    work::run(args, Duration::from_secs_f64(args.seconds), console)
}

fn diameter(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.02..=180.0).contains(value));
    value.ok_or_else(|| "expected a diameter from 0.02 to 180 degrees".to_owned())
}

fn studio(text: &str) -> Result<Studio, String> {
    let found = Studio::WORDS.iter().find(|(word, _)| *word == text);
    let words = || Studio::WORDS.map(|(word, _)| word).join(", ");
    found.map(|(_, studio)| *studio).ok_or_else(|| format!("expected one of {}", words()))
}

pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.0..=86_400.0).contains(value));
    value.ok_or_else(|| "expected a number of seconds from 0 to 86400".to_owned())
}

/// Pixels along x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Frame([usize; 2]);

fn frame(text: &str) -> Result<Frame, String> {
    let side = |text: &str| text.parse::<usize>().ok().filter(|side| (1..=8192).contains(side));
    let sides = match text.split_once('x') {
        Some((width, height)) => side(width).zip(side(height)),
        None => side(text).map(|side| (side, side)),
    };
    sides.map(|(width, height)| Frame([width, height])).ok_or_else(|| {
        "expected a side from 1 to 8192, or width and height such as 1920x1080".to_owned()
    })
}

/// A name that is valid as a file's name and does not collide with another file of the output folder.
fn name(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let good = !text.is_empty() && text.chars().all(plain) && !text.starts_with('.');
    if good && text != "records" {
        return Ok(text.to_owned());
    }
    Err("expected a name of letters, digits, -, _ and . other than \"records\"".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_folder() {
        assert_eq!(name("v1.2-rc_3"), Ok("v1.2-rc_3".to_owned()));
        assert!(["", "..", "a/b", ".x", "records", "a b"].iter().all(|text| name(text).is_err()));
        assert!(["-1", "nan", "inf", "x"].iter().all(|text| seconds(text).is_err()));
    }

    #[test]
    fn studios_have_the_words_of_files_of_lights() {
        assert_eq!(studio("window"), Ok(Studio::Window));
        assert_eq!(studio("Window"), Err("expected one of softboxes, window, gradient".to_owned()));
    }

    #[test]
    fn frames_have_one_side_or_two() {
        assert_eq!(frame("256"), Ok(Frame([256, 256])));
        assert_eq!(frame("1920x1080"), Ok(Frame([1920, 1080])));
        let bad = ["0", "1x", "x", "2x0", "9000", "3x4x5", "-1", ""];
        assert!(bad.iter().all(|text| frame(text).is_err()));
    }
}
