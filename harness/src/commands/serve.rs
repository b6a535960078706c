//! `cargo xtask serve`: serves the gallery, or another folder, on a local port.

use std::path::PathBuf;

use anyhow::{Result, bail};
use diffraction_cli::Outcome;
use diffraction_cli::console::Console;

use crate::drivers::browser::FolderServer;

const EXAMPLE: &str = "Examples:
  cargo xtask serve
  cargo xtask serve --dir gallery/dist --port 8080

Build the gallery first:
  cargo xtask generate --plan plans/gallery.toml --out gallery/package
  cd gallery && npm ci && npm run build

Only browsers on this machine can reach the server, and it serves files of the folder only. Stop it with Ctrl-C.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// The folder to serve; it must hold an index.html.
    #[arg(long, value_name = "DIR", default_value = "gallery/dist")]
    dir: PathBuf,
    /// The port; 0: any free port.
    #[arg(long, value_name = "N", default_value_t = 8080)]
    port: u16,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if !args.dir.join("index.html").is_file() {
        bail!(
            "{}: has no index.html; cargo xtask serve --help says how to build the gallery",
            args.dir.display()
        );
    }
    let server = FolderServer::open(&args.dir, args.port)?;
    console.data(&format!("{}\n", server.address()))?;
    loop {
        server.answer(std::time::Duration::from_secs(3600))?;
    }
}
