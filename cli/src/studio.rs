//! `cargo xtask studio`: panoramas by formula as files.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::builder::PossibleValue;
use diffraction_shaders::encode::png;
use diffraction_shaders::light::{Panorama, Studio};

use crate::Outcome;
use crate::console::Console;
use crate::files::write_whole;

const EXAMPLE: &str = "Examples:
  cargo xtask studio --kind softboxes --out softboxes.exr
  cargo xtask studio --kind window --out window.png --width 512
  cargo xtask studio --kind gradient --out gradient.png --exposure 0.3

The panorama is that of studio = \"KIND\" in a file of lights (docs/lights.md), with theta 0 in the middle above: equirectangular,
linear sRGB, twice as wide as high. The centre of the pixel in row i and column j of h × w is at theta = (i + 0.5)/h·180° from
the axis that points up, and at phi = (j + 0.5)/w·360° - 180° about it. With y up, phi from +x towards +z, engines that read
equirectangular maps as three.js does show it as `cargo xtask scene` does.

An EXR holds the radiances, 32-bit floats. A PNG is a preview: radiances are multiplied by --exposure, and what exceeds 0.6 is
bent towards 1 as in the pictures of `cargo xtask scene`.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// softboxes: three softboxes in a dark room. window: a dim room with a bright window. gradient: a sky with a soft light.
    #[arg(long, value_enum, value_name = "KIND")]
    kind: Kind,
    /// The file to write: .exr (linear radiance) or .png (preview).
    #[arg(long, value_name = "FILE.exr|.png")]
    out: PathBuf,
    /// Number of columns, an even number. There are half as many rows.
    #[arg(long, value_name = "N", default_value_t = Studio::WIDTH as u32, value_parser = width)]
    width: u32,
    /// Factor on the radiances of a PNG.
    #[arg(long, value_name = "V", default_value_t = 0.5, value_parser = exposure)]
    exposure: f64,
}

/// A studio as an option's value.
#[derive(Clone, Copy, Debug)]
struct Kind(&'static str, Studio);

impl clap::ValueEnum for Kind {
    fn value_variants<'a>() -> &'a [Kind] {
        const ALL: [Kind; 3] = {
            let [a, b, c] = Studio::WORDS;
            [Kind(a.0, a.1), Kind(b.0, b.1), Kind(c.0, c.1)]
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0))
    }
}

fn width(text: &str) -> Result<u32, String> {
    let value = text.parse().ok().filter(|n: &u32| (2..=8192).contains(n) && n.is_multiple_of(2));
    value.ok_or_else(|| "expected an even number from 2 to 8192".to_owned())
}

fn exposure(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0);
    value.ok_or_else(|| "expected a positive number".to_owned())
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let is_exr = is_exr(&args.out)?;
    let panorama = args.kind.1.panorama(args.width as usize);
    let bytes = if is_exr { panorama.exr()? } else { png(&panorama.preview(args.exposure))? };
    write_whole(&args.out, &bytes)?;
    let Panorama { width, height, .. } = panorama;
    console.note(&format!("{}: {} of {width} × {height} pixels", args.out.display(), args.kind.0));
    Ok(Outcome::Done)
}

/// Whether the file is to be an EXR, or else a PNG.
fn is_exr(path: &Path) -> Result<bool> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        let (file, folder) = (path.display(), folder.display());
        bail!("--out {file}: the folder {folder} does not exist; make it first");
    }
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    match extension.as_deref().and_then(|e| e.to_str()) {
        Some("exr") => Ok(true),
        Some("png") => Ok(false),
        _ => bail!("--out {}: the name must end in .exr or .png", path.display()),
    }
}
