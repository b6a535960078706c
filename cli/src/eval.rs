//! `cargo xtask eval`: prints the colours for given directions.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::{self, read_file};
use diffraction_shaders::optics::{Matter, direction};
use glam::DVec3;

use crate::Outcome;
use crate::args::{Runner, RunnerArgs, SurfaceArgs, wavelength_nm};
use crate::console::{Console, Errors};
use crate::memory::MemoryArgs;
use crate::progress;
use crate::runners::{Drivers, Job};

const EXAMPLE: &str = "Examples:
  cargo xtask eval --plan plan.toml --surface blazed --directions directions.csv
  cargo xtask eval --surface blazed --variant ensemble --runner twin --wavelength-nm 550 --directions directions.csv
  cargo xtask eval --surface blazed --lights lights.toml --views views.csv
  cargo xtask eval --surface blazed --variant foil --runner twin --pattern 30,1.2,1 --lights lights.toml --views views.csv

FILE.csv holds angles in degrees. Theta is the angle from the surface normal, phi the angle about it, counted from the
tangent. theta_i, phi_i point towards the light, theta_r, phi_r towards the viewer:
  theta_i,phi_i,theta_r,phi_r
  20,0,20,180

The output is CSV: the same columns, then X,Y,Z, the CIE tristimulus values relative to the peak of a mirror. With
--wavelength-nm it has rho and p2 instead: p2 is the response |P|², rho is p2 times the gain.

With --lights the light comes from a file, and --views has the columns theta_r,phi_r alone. The output is the same columns,
then X,Y,Z of the radiance, reflectance included; a white of radiance 1 has Y = 1. lights.toml has one [[light]] for each:
  schema = 1
  [[light]]
  kind = \"disc\"             # the sun; also direction, polygon (corners, radiance), sky (radiance), environment (file, studio)
  direction = [20, 0]       # theta, phi
  diameter_deg = 0.53
  irradiance = 1.0          # a white diffuser that faces the light shows 1/π";

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
    /// Evaluate this wavelength alone, in nm (360 to 830), and print rho and p2 instead of X, Y, Z.
    #[arg(long, value_name = "L", value_parser = wavelength_nm, conflicts_with = "lights")]
    wavelength_nm: Option<f64>,
    /// CSV file of directions in degrees, with the header `theta_i,phi_i,theta_r,phi_r`.
    #[arg(
        long,
        value_name = "FILE.csv",
        required_unless_present = "lights",
        conflicts_with = "lights"
    )]
    directions: Option<PathBuf>,
    /// TOML file of lights: single directions, discs, polygons, skies, maps of the surroundings. Print the radiance towards the viewers of --views.
    #[arg(long, value_name = "FILE.toml", requires = "views")]
    lights: Option<PathBuf>,
    /// CSV file of viewing directions in degrees, with the header `theta_r,phi_r`.
    #[arg(long, value_name = "FILE.csv", requires = "lights")]
    views: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, console: &Console, drivers: Drivers) -> Result<Outcome> {
    match (&args.lights, &args.views, &args.directions) {
        (Some(lights), Some(views), _) => under_lights(args, lights, views, console, drivers),
        (_, _, Some(directions)) => under_directions(args, directions, console, drivers),
        _ => bail!("--directions is missing; or give --lights and --views"),
    }
}

fn under_directions(
    args: &Args,
    path: &Path,
    console: &Console,
    drivers: Drivers,
) -> Result<Outcome> {
    let job = Job::new(&args.surface, &args.runner, &args.memory, console)?;
    let angles = rows(path, "--directions", ["theta_i", "phi_i", "theta_r", "phi_r"])?;
    let directions: Vec<Directions> = angles.iter().map(|a| Directions::from_degrees(*a)).collect();
    let runner = job.runner(&args.runner, drivers)?;
    let (header, columns): (&str, Vec<Vec<f64>>) = match args.wavelength_nm {
        Some(lambda_nm) => {
            let range = &job.variant.wavelengths;
            if args.runner.runner != Runner::Exact
                && !(range.min_nm..=range.max_nm).contains(&lambda_nm)
            {
                bail!(
                    "--wavelength-nm {lambda_nm}: variant {} covers {} to {} nm",
                    job.variant.name,
                    range.min_nm,
                    range.max_nm
                );
            }
            if args.runner.runner == Runner::Exact {
                job.surface
                    .field
                    .check_pitch(&diffraction_shaders::surface::subject(&job.spec), lambda_nm)?;
            }
            let matter = Matter::new(&job.variant.optics)?;
            let rows = runner.response(&directions, lambda_nm)?;
            let rho =
                |(d, p2): (&Directions, f64)| vec![matter.gain(d.wi, d.wr, lambda_nm) * p2, p2];
            ("rho,p2", directions.iter().zip(rows).map(rho).collect())
        }
        None => {
            let bar = progress::bar(directions.len(), "evaluating");
            let colours = runner.tristimulus_with(&directions, &|done| bar.inc(done as u64))?;
            bar.finish_and_clear();
            ("X,Y,Z", colours.into_iter().map(Vec::from).collect())
        }
    };
    print(&format!("theta_i,phi_i,theta_r,phi_r,{header}"), &angles, &columns, console)
}

fn under_lights(
    args: &Args,
    lights: &Path,
    views: &Path,
    console: &Console,
    drivers: Drivers,
) -> Result<Outcome> {
    let lights = input::read_lights(lights).map_err(Errors)?;
    lights.notes.iter().for_each(|note| console.note(note));
    let job = Job::under(&lights, &args.surface, &args.runner, &args.memory, console)?;
    let angles = rows(views, "--views", ["theta_r", "phi_r"])?;
    let views: Vec<DVec3> = angles.iter().map(|[theta, phi]| direction(*theta, *phi)).collect();
    let runner = job.runner(&args.runner, drivers)?;
    let bar = progress::bar(views.len() * lights.all.len(), "evaluating");
    let colours = job.radiance(&*runner, &args.runner, &lights, &views, &|n| bar.inc(n as u64))?;
    bar.finish_and_clear();
    let columns: Vec<Vec<f64>> = colours.into_iter().map(Vec::from).collect();
    print("theta_r,phi_r,X,Y,Z", &angles, &columns, console)
}

/// Writes the angles with their results as CSV.
fn print<const N: usize>(
    header: &str,
    angles: &[[f64; N]],
    columns: &[Vec<f64>],
    console: &Console,
) -> Result<Outcome> {
    let mut text = format!("{header}\n");
    for (angles, values) in angles.iter().zip(columns) {
        let fields: Vec<String> = angles.iter().chain(values).map(|v| format!("{v:?}")).collect();
        writeln!(text, "{}", fields.join(","))?;
    }
    console.data(&text)?;
    Ok(Outcome::Done)
}

/// Maximum size of a file of directions, in bytes: a million rows.
const MAX_DIRECTIONS_BYTES: u64 = 64 << 20;

/// Reads rows of angles in degrees. `header`: the names of the columns; those that begin with `theta` are at most 180.
fn rows<const N: usize>(path: &Path, option: &str, header: [&str; N]) -> Result<Vec<[f64; N]>> {
    let place = path.display();
    let bytes = read_file(path, MAX_DIRECTIONS_BYTES).map_err(|error| {
        if error.kind() == std::io::ErrorKind::InvalidInput {
            anyhow!("{option} {place}: {error}; give the path of a CSV file")
        } else {
            anyhow!("{option} {place}: cannot be read: {error}")
        }
    })?;
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(bytes.as_slice());
    let found = reader.headers().with_context(|| format!("{option} {place}: cannot be read"))?;
    if found.len() < N || found.iter().zip(header).any(|(got, want)| got != want) {
        let got: Vec<&str> = found.iter().collect();
        bail!(
            "{option} {place}: the header must be {:?}, but is {:?}",
            header.join(","),
            got.join(",")
        );
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.with_context(|| format!("{option} {place}"))?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut row = [0.0; N];
        for ((value, name), field) in row.iter_mut().zip(header).zip(&record) {
            *value = match field.parse::<f64>() {
                Ok(number) if number.is_finite() => number,
                _ => bail!("{option} {place}:{line}: {name} = {field:?} is not a number"),
            };
            if name.starts_with("theta") && !(0.0..=180.0).contains(value) {
                bail!("{option} {place}:{line}: {name} = {value} is not between 0 and 180 degrees");
            }
        }
        rows.push(row);
    }
    if rows.is_empty() {
        bail!("{option} {place}: has no rows below the header");
    }
    Ok(rows)
}
