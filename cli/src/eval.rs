//! `cargo xtask eval`: prints the colours for given directions.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::read_file;
use diffraction_shaders::optics::gain;

use crate::Outcome;
use crate::args::{Runner, RunnerArgs, SurfaceArgs, wavelength_nm};
use crate::console::Console;
use crate::memory::MemoryArgs;
use crate::progress;
use crate::runners::{Drivers, Job};

const EXAMPLE: &str = "Examples:
  cargo xtask eval --plan plan.toml --surface blazed --directions directions.csv
  cargo xtask eval --surface blazed --variant ensemble --runner twin --wavelength-nm 550 --directions directions.csv

FILE.csv holds angles in degrees. Theta is the angle from the surface normal, phi the angle about it, counted from the
tangent. theta_i, phi_i point towards the light, theta_r, phi_r towards the viewer:
  theta_i,phi_i,theta_r,phi_r
  20,0,20,180

The output is CSV: the same columns, then X,Y,Z, the CIE tristimulus values relative to the peak of a mirror. With
--wavelength-nm it has rho and p2 instead: p2 is the response |P|², rho is p2 times the gain.";

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
    #[arg(long, value_name = "L", value_parser = wavelength_nm)]
    wavelength_nm: Option<f64>,
    /// CSV file of directions in degrees, with the header `theta_i,phi_i,theta_r,phi_r`.
    #[arg(long, value_name = "FILE.csv")]
    directions: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, console: &Console, drivers: Drivers) -> Result<Outcome> {
    let job = Job::new(&args.surface, &args.runner, &args.memory, console)?;
    let angles = read_directions(&args.directions)?;
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
            let optics = &job.variant.optics;
            let rows = runner.response(&directions, lambda_nm)?;
            let rho = |(d, p2): (&Directions, f64)| vec![gain(d.wi, d.wr, optics) * p2, p2];
            ("rho,p2", directions.iter().zip(rows).map(rho).collect())
        }
        None => {
            let bar = progress::bar(directions.len(), "evaluating");
            let colours = runner.tristimulus_with(&directions, &|done| bar.inc(done as u64))?;
            bar.finish_and_clear();
            ("X,Y,Z", colours.into_iter().map(Vec::from).collect())
        }
    };
    let mut text = format!("theta_i,phi_i,theta_r,phi_r,{header}\n");
    for (angles, values) in angles.iter().zip(&columns) {
        let fields: Vec<String> = angles.iter().chain(values).map(|v| format!("{v:?}")).collect();
        writeln!(text, "{}", fields.join(","))?;
    }
    console.data(&text)?;
    Ok(Outcome::Done)
}

/// Maximum size of a file of directions, in bytes: a million rows.
const MAX_DIRECTIONS_BYTES: u64 = 64 << 20;

/// Reads rows of `theta_i, phi_i, theta_r, phi_r`, in degrees.
fn read_directions(path: &Path) -> Result<Vec<[f64; 4]>> {
    const HEADER: [&str; 4] = ["theta_i", "phi_i", "theta_r", "phi_r"];
    let place = path.display();
    let bytes = read_file(path, MAX_DIRECTIONS_BYTES).map_err(|error| {
        if error.kind() == std::io::ErrorKind::InvalidInput {
            anyhow!("--directions {place}: {error}; give the path of a CSV file")
        } else {
            anyhow!("--directions {place}: cannot be read: {error}")
        }
    })?;
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(bytes.as_slice());
    let header =
        reader.headers().with_context(|| format!("--directions {place}: cannot be read"))?;
    if header.len() < 4 || header.iter().zip(HEADER).any(|(got, want)| got != want) {
        let got: Vec<&str> = header.iter().collect();
        bail!(
            "--directions {place}: the header must be {:?}, but is {:?}",
            HEADER.join(","),
            got.join(",")
        );
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.with_context(|| format!("--directions {place}"))?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut row = [0.0; 4];
        for ((value, name), field) in row.iter_mut().zip(HEADER).zip(&record) {
            *value = match field.parse::<f64>() {
                Ok(number) if number.is_finite() => number,
                _ => bail!("--directions {place}:{line}: {name} = {field:?} is not a number"),
            };
        }
        for (name, theta) in [("theta_i", row[0]), ("theta_r", row[2])] {
            if !(0.0..=180.0).contains(&theta) {
                bail!(
                    "--directions {place}:{line}: {name} = {theta} is not between 0 and 180 degrees"
                );
            }
        }
        rows.push(row);
    }
    if rows.is_empty() {
        bail!("--directions {place}: has no rows below the header");
    }
    Ok(rows)
}
