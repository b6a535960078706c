//! `cargo xtask bench`: time of every variant on every adapter.

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
use diffraction_shaders::plan::Variant;

use crate::commands::restart;

const EXAMPLE: &str = "Examples:
  cargo xtask bench --plan plan.toml --surface blazed --variant 'full-*' --backend vulkan
  cargo xtask bench --plan plan.toml --save before
  cargo xtask bench --plan plan.toml --compare-to before --out measured
  cargo xtask bench --plan plan.toml --surface blazed --variant preview --size 1920x1080 --ggx
  cargo xtask bench --plan plans/growth.toml --scaling --out growth

Times depend on what else the machine does; ratios hardly do, since baseline and variants are drawn in turns.";

/// Mesa keeps compiled shaders on disk; found there, a pipeline would seem to cost nothing.
const NO_SHADER_CACHE: (&str, &str) = ("MESA_SHADER_CACHE_DISABLE", "true");

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    plan: PlanArgs,
    /// Take this surface only; may be repeated.
    #[arg(long, value_name = "NAME")]
    surface: Vec<String>,
    /// Take the variants that match; `texts` only where it is named. May be repeated.
    #[arg(long, value_name = "GLOB", num_args = 1..)]
    variant: Vec<String>,
    /// Take the adapters of this interface; vulkan and gl where none is named.
    #[arg(long, value_enum)]
    backend: Vec<Interface>,
    /// Take the adapters whose name or driver contains this.
    #[arg(long, value_name = "SUBSTRING")]
    adapter: Option<String>,
    /// Direction of the light in degrees.
    #[arg(long, value_name = "THETA,PHI", default_value = "20,0", allow_hyphen_values = true)]
    light: Light,
    /// Pixels of the map: its side, or width and height.
    #[arg(long, value_name = "N|WxH", default_value = "256", value_parser = frame)]
    size: Frame,
    /// The variant that ratios are against; `texts` is the shader as printed.
    #[arg(long, value_name = "NAME", default_value = Variant::TEXTS)]
    baseline: String,
    /// Seconds for each variant on each adapter; the fewest rounds are always drawn.
    #[arg(long, value_name = "S", default_value_t = 5.0, value_parser = seconds)]
    seconds: f64,
    /// Also draw a shader that computes nothing but the gain: the floor of every time.
    #[arg(long)]
    empty: bool,
    /// Also draw an ordinary material: a GGX lobe and one texel of base colour.
    #[arg(long)]
    ggx: bool,
    /// Vary pixels, terms, radius, wavelengths and their range of each variant, width and heights of the surface instead, one at a
    /// time.
    #[arg(long)]
    scaling: bool,
    /// Keep the results under this name, in target/bench or in --out.
    #[arg(long, value_name = "NAME", value_parser = name, conflicts_with = "scaling")]
    save: Option<String>,
    /// Show what changed since results were kept under this name.
    #[arg(long, value_name = "NAME", value_parser = name, conflicts_with = "scaling")]
    compare_to: Option<String>,
    /// Append each result to records.jsonl in this folder as soon as it is known.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object per result instead of tables.
    #[arg(long)]
    json: bool,
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
    restart::with_drivers_and(&[NO_SHADER_CACHE])?;
    work::run(args, Duration::from_secs_f64(args.seconds), console)
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

/// A name that is a file's name and no other file's of an output folder.
fn name(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let good = !text.is_empty() && text.chars().all(plain) && !text.starts_with('.');
    if good && text != "records" {
        return Ok(text.to_owned());
    }
    Err("expected letters, digits, -, _ and ., and not \"records\"".to_owned())
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
    fn frames_have_one_side_or_two() {
        assert_eq!(frame("256"), Ok(Frame([256, 256])));
        assert_eq!(frame("1920x1080"), Ok(Frame([1920, 1080])));
        let bad = ["0", "1x", "x", "2x0", "9000", "3x4x5", "-1", ""];
        assert!(bad.iter().all(|text| frame(text).is_err()));
    }
}
