//! `cargo xtask report`: makes one HTML page from records and pictures.

use std::path::PathBuf;

use crate::report::{page, read};
use anyhow::{Result, bail};

use diffraction_cli::Outcome;
use diffraction_cli::console::Console;
use diffraction_cli::files::write_whole;

const EXAMPLE: &str = "Examples:
  cargo xtask report target/compare
  cargo xtask report target/compare target/bench --html report.html

The page is one file with everything inside, pictures too; it loads nothing from the network. If folders have several results
of the same measurement, the last one counts.";

/// Size from which a page counts as large, in bytes.
const LARGE: usize = 40 << 20;

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Folders with records.jsonl, written by compare, bench, testbench or tune with --out.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// The HTML file to write. Default: report.html in the first folder.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Leave out pictures, for a smaller page.
    #[arg(long)]
    no_pictures: bool,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let Some(first) = args.folders.first() else { bail!("name a folder with records") };
    let read = |folder: &PathBuf| read(folder, !args.no_pictures);
    let folders: Vec<_> = args.folders.iter().map(read).collect::<Result<_, _>>()?;
    let page = page(&folders);
    for missing in &page.missing {
        console.note(&format!("picture missing: {missing}"));
    }
    let path = args.html.clone().unwrap_or_else(|| first.join("report.html"));
    write_whole(&path, page.html.as_bytes())?;
    let records: usize = folders.iter().map(|folder| folder.records.len()).sum();
    let mib = page.html.len() as f64 / f64::from(1 << 20);
    console.note(&format!("{}: {records} records, {mib:.1} MiB", path.display()));
    if page.html.len() > LARGE && !args.no_pictures {
        console.note("the page is large; --no-pictures makes one with tables and plots only");
    }
    Ok(Outcome::Done)
}
