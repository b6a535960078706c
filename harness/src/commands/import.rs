//! `cargo xtask import`: files of instruments as Gwyddion Simple Field, by the Python library SurfaceTopography.

mod facts;
mod python;

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Result, anyhow, bail};
use diffraction_cli::Outcome;
use diffraction_cli::console::Console;
use diffraction_cli::files::write_whole;
use diffraction_cli::interrupt::TemporaryFolder;
use diffraction_shaders::disk::{Access, FolderLock};
use diffraction_shaders::error::Error;
use diffraction_shaders::{Plan, input};

use super::setup::IMPORT;
use crate::process::accepted;

use facts::{Answer, Facts, block};

const EXAMPLE: &str = "Examples:
  cargo xtask import --setup
  cargo xtask import scans/beetle.spm --channel ZSensor
  cargo xtask import scans/*.x3p --out fields

Reads what SurfaceTopography reads: Gwyddion, Bruker and Veeco, Nanosurf, Asylum and JPK, Zygo, Keyence, Sensofar, Digital Surf,
Alicona, WSxM, X3P (ISO 25178-72), SDF (ISO 25178-71), and others; see docs/import.md. Writes FILE's name with .gsf beside it, or with
the channel's name if --channel is given. Lengths become metres, voids NaN; the first row is the top of the picture.

Prints what was read and dropped, and the [[surface]] to paste into a plan.

Exit code 2: a file was not imported; the others were.";

const SCRIPT: &str = include_str!("../../python/import.py");
/// Maximum time for one file.
const TIME_LIMIT: Duration = Duration::from_secs(600);
/// The line in the header of a file that this command wrote.
const OURS: &str = "\nImporter = diffraction import\n";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Files of instruments.
    #[arg(value_name = "FILE", required_unless_present = "setup")]
    files: Vec<PathBuf>,
    /// The channel to read; otherwise the one that holds heights.
    #[arg(long, value_name = "NAME")]
    channel: Option<String>,
    /// Folder for the results; otherwise beside each file.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite files that this command did not write.
    #[arg(long)]
    force: bool,
    /// Install the library first (150 MB to download, from Python's package index), into the user's cache folder.
    #[arg(long)]
    setup: bool,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if args.setup {
        IMPORT.install(console)?;
    }
    if args.files.is_empty() {
        return Ok(Outcome::Done);
    }
    let python = python::find()?;
    let waiting = |text: &str| console.note(text);
    let take = |folder: &PathBuf| FolderLock::take(folder, Access::Write, &waiting);
    let _lock = args.out.as_ref().map(take).transpose()?;
    let mut taken = BTreeMap::new();
    let (mut blocks, mut failed) = (Vec::new(), 0);
    for file in &args.files {
        let done = place(args, file).and_then(|output| {
            if let Some(other) = taken.insert(output.clone(), file) {
                let cause = format!("would be written from {} too", other.display());
                bail!(Error::new(output.display(), cause).remedy("import them into two folders"));
            }
            Ok((import(args, &python, file, &output)?, output))
        });
        match done {
            Ok((facts, output)) => {
                console.data(&facts.text(file, &output))?;
                let block = block(&facts, &output);
                note_refusal(&block, console);
                blocks.push(block);
            }
            Err(error) => {
                console.error(&error);
                failed += 1;
            }
        }
    }
    if !blocks.is_empty() {
        console.data(&format!("\n{}", blocks.join("\n")))?;
    }
    if failed > 0 {
        bail!("{failed} of {} files were not imported", args.files.len());
    }
    Ok(Outcome::Done)
}

/// The file that a file becomes.
fn place(args: &Args, file: &Path) -> Result<PathBuf> {
    if !file.is_file() {
        let cause = if file.exists() { "is not a regular file" } else { "does not exist" };
        bail!(Error::new(file.display(), cause).remedy("give the path of a file"));
    }
    let mut name = stem(file);
    if let Some(channel) = &args.channel {
        let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' };
        name = format!("{name}-{}", channel.chars().map(plain).collect::<String>());
    }
    let folder = args.out.as_deref().or(file.parent()).unwrap_or(Path::new(""));
    let output = folder.join(format!("{name}.gsf"));
    let same = fs::canonicalize(&output).ok().zip(fs::canonicalize(file).ok());
    if same.is_some_and(|(output, file)| output == file) {
        bail!(
            Error::new(file.display(), "would be overwritten by its own import")
                .remedy("a plan reads GSF as it is; or name another folder: --out DIR")
        );
    }
    if !args.force && output.exists() && !is_ours(&output) {
        bail!(
            Error::new(output.display(), "exists, and import did not write it")
                .remedy("name another folder: --out DIR; or overwrite it: --force")
        );
    }
    Ok(output)
}

fn import(args: &Args, python: &Path, file: &Path, output: &Path) -> Result<Facts> {
    let place = TemporaryFolder::new()?;
    let field = place.path().join("field.gsf");
    let mut command = python::command(python, SCRIPT);
    // a relative name might look like an option
    command.arg(fs::canonicalize(file)?).arg(&field);
    command.arg(file.file_name().unwrap_or_default()).args(&args.channel);
    let said = accepted(&mut command, TIME_LIMIT).map_err(|fault| {
        let lines = fault.to_string();
        let last = lines.lines().last().unwrap_or_default();
        anyhow!(Error::new(file.display(), format!("{}: {last}", python.display())))
    })?;
    // libraries print, too
    let answer = said.lines().last().unwrap_or_default();
    match serde_json::from_str(answer) {
        Ok(Answer::Read(facts)) => {
            if let Some(folder) = output.parent().filter(|folder| !folder.as_os_str().is_empty()) {
                fs::create_dir_all(folder)?;
            }
            write_whole(output, &fs::read(&field)?)?;
            Ok(facts)
        }
        Ok(Answer::Refused { error, remedy }) => {
            let error = Error::new(file.display(), error);
            bail!(remedy.into_iter().fold(error, Error::remedy))
        }
        Err(error) => {
            bail!(Error::new(file.display(), "the script's answer is unclear").source(error))
        }
    }
}

/// Says why a plan would refuse the result: too coarse, too many voids.
fn note_refusal(block: &str, console: &Console) {
    let plan = Plan::parse(&format!("schema = 1\n{block}"), Path::new("plan.toml"));
    let refused = plan
        .and_then(|plan| plan.surfaces.iter().try_for_each(|s| input::load_surface(s).map(|_| ())));
    if let Err(error) = refused {
        console.note(&format!("the file is written, but a plan would refuse it: {error}"));
    }
}

/// Whether this command wrote a file.
fn is_ours(path: &Path) -> bool {
    if !path.is_file() {
        return false;
    }
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(1 << 16).read_to_end(&mut head));
    let header = head.split(|byte| *byte == 0).next().unwrap_or_default();
    read.is_ok() && String::from_utf8_lossy(header).contains(OURS)
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
