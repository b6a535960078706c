//! `cargo xtask serve`: the gallery, or another folder, on a local port.

use std::path::PathBuf;

use anyhow::{Result, bail};
use diffraction_cli::Outcome;
use diffraction_cli::console::Console;

use crate::drivers::browser::FolderServer;

const EXAMPLE: &str = "Examples:
  cargo xtask serve
  cargo xtask serve --dir gallery/dist --port 8080

The gallery is built by
  cargo xtask generate --plan plans/gallery.toml --out gallery/package
  cd gallery && npm ci && npm run build

Only this machine can reach it, and it gets no file from outside the folder. Ctrl-C ends it.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// The folder.
    #[arg(long, value_name = "DIR", default_value = "gallery/dist")]
    dir: PathBuf,
    /// The port; 0 takes any that is free.
    #[arg(long, value_name = "N", default_value_t = 8080)]
    port: u16,
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if !args.dir.join("index.html").is_file() {
        bail!(
            "{}: holds no index.html; cargo xtask serve --help tells how the gallery is built",
            args.dir.display()
        );
    }
    let server = FolderServer::open(&args.dir, args.port)?;
    console.data(&format!("{}\n", server.address()))?;
    loop {
        server.answer(std::time::Duration::from_secs(3600))?;
    }
}
