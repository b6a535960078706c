//! `cargo xtask render`: draws a BRDF map.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use diffraction_shaders::input;
use diffraction_shaders::optics::brdf_map::{BrdfMap, view_directions};
use diffraction_shaders::optics::colour_difference::auto_exposure;
use diffraction_shaders::optics::direction;
use diffraction_shaders::runner::rounded;

use crate::Outcome;
use crate::args::{Exposure, Light, Runner, RunnerArgs, SurfaceArgs};
use crate::console::{Console, Errors};
use crate::files::write_whole;
use crate::memory::MemoryArgs;
use crate::progress;
use crate::runners::{Drivers, Job};

const EXAMPLE: &str = "Examples:
  cargo xtask render --plan plan.toml --surface blazed --light 20,0 --size 512 --out blazed.png
  cargo xtask render --surface fingers --variant ensemble --runner vulkan --exposure 2 --out fingers.exr
  cargo xtask render --surface cd --lights lights.toml --size 512 --out cd.png
  cargo xtask render --surface fingers --variant ensemble --runner spirv --adapter swiftshader --out fingers.png

The map is a disc. Its pixel at (x, y), with y up, shows the viewing direction whose projection on the surface is (x, y): the
centre looks along the normal, the rim grazes the surface. Outside of the disc a PNG is transparent and an EXR is 0.

With --lights the map shows the radiance under the lights of a file; `cargo xtask eval --help` describes it.";

/// Options of the command.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Args {
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// What computes the colours.
    #[command(flatten)]
    pub runner: RunnerArgs,
    /// Direction towards the light, in degrees: THETA from the normal, PHI about it from the tangent.
    #[arg(
        long,
        value_name = "THETA,PHI",
        default_value = "20,0",
        allow_hyphen_values = true,
        conflicts_with = "lights"
    )]
    light: Light,
    /// TOML file of lights: single directions, discs, polygons, skies, maps of the surroundings. Draw the radiance under all of them.
    #[arg(long, value_name = "FILE.toml")]
    lights: Option<PathBuf>,
    /// Width and height of the map, in pixels.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: u32,
    /// Factor on the colours of a PNG before the sRGB curve: a positive number, or auto: 0.5 divided by the 95th percentile of Y.
    #[arg(long, value_name = "auto|V", default_value = "auto")]
    exposure: Exposure,
    /// The picture to write: .png (sRGB, clamped) or .exr (linear radiance factor).
    #[arg(long, value_name = "FILE.png|.exr")]
    out: PathBuf,
}

#[derive(Clone, Copy)]
enum Format {
    Png,
    Exr,
}

/// Runs the command.
pub fn run(args: &Args, console: &Console, drivers: Drivers) -> Result<Outcome> {
    let format = format(&args.out)?;
    let size = args.size as usize;
    let lights = args.lights.as_deref().map(input::read_lights).transpose().map_err(Errors)?;
    lights.iter().flat_map(|lights| &lights.notes).for_each(|note| console.note(note));
    let job = match &lights {
        Some(lights) => Job::under(lights, &args.surface, &args.runner, &args.memory, console)?,
        None => Job::new(&args.surface, &args.runner, &args.memory, console)?,
    };
    let runner = job.runner(&args.runner, drivers)?;
    let light = direction(args.light.theta_deg, args.light.phi_deg);
    // the twin gets the rounded direction that the shader gets; the exact reference gets the angle as given
    let light = if args.runner.runner == Runner::Twin { rounded(light) } else { light };
    let maps = lights.as_ref().map_or(1, |lights| lights.all.len());
    let bar = progress::bar(maps * size * size, &format!("rendering {}", runner.route()));
    let done = |done| bar.inc(done as u64);
    let frame = match &lights {
        Some(lights) => {
            let views = view_directions(size);
            let colours = job.radiance(&*runner, &args.runner, lights, &views, &done)?;
            BrdfMap::from_disc(size, &colours)
        }
        None => runner.brdf_map_with(light, size, &done)?,
    };
    bar.finish_and_clear();
    let colour = job.variant.optics.colour;
    let bytes = match format {
        Format::Png => {
            let exposure = exposure(args.exposure, &frame, console);
            console.note(&format!("exposure {exposure:.4}"));
            frame.png(colour, exposure)?
        }
        Format::Exr => frame.exr(colour)?,
    };
    write_whole(&args.out, &bytes)?;
    console.note(&format!("{}: {size} × {size} pixels by {}", args.out.display(), runner.route()));
    Ok(Outcome::Done)
}

fn exposure(wanted: Exposure, frame: &BrdfMap, console: &Console) -> f64 {
    match wanted {
        Exposure::Value(value) => value,
        Exposure::Auto => auto_exposure(&frame.disc()).unwrap_or_else(|| {
            console.note("the map is black; exposure set to 1");
            1.0
        }),
    }
}

fn format(path: &Path) -> Result<Format> {
    let folder =
        path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        bail!(
            "--out {}: the folder {} does not exist; make it first",
            path.display(),
            folder.display()
        );
    }
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    match extension.as_deref().and_then(|e| e.to_str()) {
        Some("png") => Ok(Format::Png),
        Some("exr") => Ok(Format::Exr),
        _ => Err(anyhow::anyhow!("the name must end in .png or .exr"))
            .with_context(|| format!("--out {}", path.display())),
    }
}
