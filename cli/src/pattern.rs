//! `cargo xtask pattern`: pattern maps by formula as files.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use diffraction_shaders::encode::png;
use diffraction_shaders::input::read_stencil;
use diffraction_shaders::pattern::{Bits, Drawing, Groove, Kind, PatternMap, Ranges, Sketch};

use crate::Outcome;
use crate::console::Console;
use crate::files::write_whole;

/// Maximum number of rows and of columns. A map takes 48 bytes of memory per texel while it is drawn.
const MAX_SIDE: usize = 4096;

const EXAMPLE: &str = "Examples:
  cargo xtask pattern --kind circles --rings 12 --out disc.png --preview disc-preview.png
  cargo xtask pattern --kind logo --logo logo.png --invert --angle-deg 45 --out logo-map.png
  cargo xtask pattern --kind logo --logo logo.png --ground-angle-deg 90 --ground-period 1.2 --out latent.png
  cargo xtask pattern --kind guilloche --size 2048x2048 --out rosette.png --preview rosette-preview.png
  cargo xtask pattern --kind flakes --cell-size 16 --seed 7 --out flakes.png
  cargo xtask pattern --kind ramp --period-ratio 0.8,1.4 --out rainbow.png --size 1024x64
  cargo xtask pattern --kind cells --cell-size 32 --step-deg 20 --out cells.png
  cargo xtask pattern --kind cells --cell-size 8 --image portrait.png --out portrait-map.png

The file is an RGBA PNG of numbers (docs/patterns.md): red is the angle across the grooves from the tangent towards the
bitangent, green the period ratio, blue the depth ratio, alpha the mask, which is the share of the area that is foil. It states
its ranges as text. Load it as data, not as sRGB.

--preview is for people: left the direction as hue and the period as lightness, with a disc of all of them; right a sketch of the
first order as seen along the normal, under a white lamp in the direction --light on a profile of the period --period-um. The
dot in the disc is the lamp. The sketch shows where which wavelength goes and no more: neither the profile's efficiency nor
other orders are in it. `cargo xtask scene` draws foils.

A logo is inside where brightness times opacity is at least 0.5. Soft edges so become sharp there, and the map's own edges are one
texel wide: the mask is the share inside. With a ground there is foil everywhere, and a texel belongs to the side that has more of it.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// What to draw.
    #[arg(long, value_enum, value_name = "KIND")]
    kind: KindName,
    /// The file to write.
    #[arg(long, value_name = "FILE.png")]
    out: PathBuf,
    /// Columns and rows, 1 to 4096 each.
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    size: [usize; 2],
    /// Lowest and highest period over that of the compiled profile.
    #[arg(long, value_name = "LO,HI", default_value = "0.6,1.6", value_parser = range)]
    period_ratio: [f64; 2],
    /// Lowest and highest depth over that of the compiled profile.
    #[arg(long, value_name = "LO,HI", default_value = "1,1", value_parser = range)]
    depth_ratio: [f64; 2],
    /// Direction across the grooves, degrees from the tangent (right) towards the bitangent (up). Kinds with many directions are
    /// turned by it.
    #[arg(long, value_name = "A", default_value_t = 0.0, value_parser = number, allow_negative_numbers = true)]
    angle_deg: f64,
    /// Period ratio of circles without --rings, of a logo and of cells with --image; the mean one of flakes. 1 unless given.
    #[arg(long, value_name = "R", value_parser = positive)]
    period: Option<f64>,
    /// circles: number of rings, with ratios at a third and at two thirds of their ranges in turns.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    rings: Option<u32>,
    /// logo: the picture whose shape is filled, a PNG.
    #[arg(long, value_name = "FILE.png")]
    logo: Option<PathBuf>,
    /// logo, cells: dark counts as bright, for a black logo on white or on nothing.
    #[arg(long)]
    invert: bool,
    /// logo: angle of a grating outside. Without it and --ground-period there is no foil outside.
    #[arg(long, value_name = "A", value_parser = number, allow_negative_numbers = true)]
    ground_angle_deg: Option<f64>,
    /// logo: period ratio of a grating outside.
    #[arg(long, value_name = "R", value_parser = positive)]
    ground_period: Option<f64>,
    /// flakes, cells: side of a flake or a cell, texels. 16 unless given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    cell_size: Option<u32>,
    /// cells: by how much the angle grows from a cell to the next. 15 unless given.
    #[arg(long, value_name = "A", value_parser = number, allow_negative_numbers = true)]
    step_deg: Option<f64>,
    /// cells: a picture whose brightness is the angle, a PNG: a quarter turn from black to white.
    #[arg(long, value_name = "FILE.png")]
    image: Option<PathBuf>,
    /// flakes: seed of the random numbers. 0 unless given.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Bits of a channel.
    #[arg(long, value_name = "8|16", default_value = "16", value_parser = bits)]
    bits: Bits,
    /// A picture of the map for people.
    #[arg(long, value_name = "FILE.png")]
    preview: Option<PathBuf>,
    /// Lamp of the preview's sketch: degrees from the normal, and from the tangent.
    #[arg(long, value_name = "THETA,PHI", default_value = "30,0", value_parser = light, allow_hyphen_values = true)]
    light: [f64; 2],
    /// Period of the profile in the preview's sketch, µm.
    #[arg(long, value_name = "P", default_value_t = 1.0, value_parser = positive)]
    period_um: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum KindName {
    /// A disc with concentric grooves, as a CD has.
    Circles,
    /// The shape of a picture.
    Logo,
    /// Rosettes of crossing curves, as on banknotes.
    Guilloche,
    /// Random flakes that repeat without a seam, each with its own angle and a slightly different period.
    Flakes,
    /// The period goes through its range from left to right, and the depth through its own from below to above.
    Ramp,
    /// Square cells of one grating each, in a regular sequence or from a picture.
    Cells,
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    let value = text.split_once('x').and_then(|(w, h)| Some([side(w)?, side(h)?]));
    value.ok_or_else(|| format!("expected WxH with numbers from 1 to {MAX_SIDE}, such as 1024x512"))
}

fn two(text: &str) -> Option<[f64; 2]> {
    let (first, second) = text.split_once(',')?;
    let both = [first.trim().parse().ok()?, second.trim().parse().ok()?];
    both.iter().all(|v: &f64| v.is_finite()).then_some(both)
}

fn range(text: &str) -> Result<[f64; 2], String> {
    let value = two(text).ok_or("expected two numbers with a comma, such as 0.6,1.6")?;
    match value[0] <= value[1] {
        true => Ok(value),
        false => Err("the first number must not exceed the second".to_owned()),
    }
}

fn light(text: &str) -> Result<[f64; 2], String> {
    let value = two(text).filter(|[theta, _]| (0.0..=90.0).contains(theta));
    value.ok_or_else(|| "expected THETA,PHI in degrees, with THETA from 0 to 90".to_owned())
}

fn number(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v: &f64| v.is_finite());
    value.ok_or_else(|| "expected a number".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0);
    value.ok_or_else(|| "expected a positive number".to_owned())
}

fn bits(text: &str) -> Result<Bits, String> {
    match text {
        "8" => Ok(Bits::Eight),
        "16" => Ok(Bits::Sixteen),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

pub(crate) fn run(args: &Args, console: &Console) -> Result<Outcome> {
    check_outputs(args)?;
    check_options(args)?;
    let drawing = drawing(args, console)?;
    let map = drawing.map()?;
    let ranges = drawing.ranges;
    let preview = args.preview.as_ref().map(|path| {
        let [theta_deg, phi_deg] = args.light;
        let sketch = Sketch { theta_deg, phi_deg, period_um: args.period_um };
        map.preview(&ranges, &sketch).and_then(|picture| png(&picture)).map(|bytes| (path, bytes))
    });
    let preview = preview.transpose()?;
    write_whole(&args.out, &map.png(&ranges, args.bits)?)?;
    if let Some((path, bytes)) = preview {
        write_whole(path, &bytes)?;
    }
    console.note(&summary(args, &map));
    Ok(Outcome::Done)
}

/// What was written.
fn summary(args: &Args, map: &PatternMap) -> String {
    let found = map.ranges().map_or_else(String::new, |found| {
        let text = |[low, high]: [f64; 2]| match high - low < 5e-4 {
            true => format!("{low:.3}"),
            false => format!("{low:.3} to {high:.3}"),
        };
        let (period, depth) = (text(found.period_ratio), text(found.depth_ratio));
        format!("; period ratio {period}, depth ratio {depth}")
    });
    format!(
        "{}: {} × {} texels, {:.1} % foil{found}",
        args.out.display(),
        map.width(),
        map.height(),
        100.0 * map.foil_share()
    )
}

fn check_outputs(args: &Args) -> Result<()> {
    let outputs = [("--out", Some(&args.out)), ("--preview", args.preview.as_ref())];
    for (option, path) in outputs {
        let Some(path) = path else { continue };
        let file = path.display();
        if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            bail!("{option} {file}: the name must end in .png");
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            let folder = folder.display();
            bail!("{option} {file}: the folder {folder} does not exist; make it first");
        }
    }
    if args.preview.as_ref() == Some(&args.out) {
        bail!("--preview {}: is the file of --out; name another", args.out.display());
    }
    Ok(())
}

/// Refuses options that the kind does not read: they would be lost without a word.
fn check_options(args: &Args) -> Result<()> {
    use KindName::{Cells, Circles, Flakes, Logo};
    let given = [
        ("--rings", args.rings.is_some(), &[Circles][..]),
        ("--logo", args.logo.is_some(), &[Logo]),
        ("--invert", args.invert, &[Logo, Cells]),
        ("--ground-angle-deg", args.ground_angle_deg.is_some(), &[Logo]),
        ("--ground-period", args.ground_period.is_some(), &[Logo]),
        ("--cell-size", args.cell_size.is_some(), &[Flakes, Cells]),
        ("--step-deg", args.step_deg.is_some(), &[Cells]),
        ("--image", args.image.is_some(), &[Cells]),
        ("--seed", args.seed.is_some(), &[Flakes]),
        ("--period", args.period.is_some(), &[Circles, Logo, Flakes, Cells]),
    ];
    for (option, is_given, kinds) in given {
        if is_given && !kinds.contains(&args.kind) {
            let of: Vec<String> =
                kinds.iter().map(|kind| format!("{kind:?}").to_lowercase()).collect();
            bail!("{option} is for --kind {}; leave it out", of.join(", "));
        }
    }
    match args.kind {
        Logo if args.logo.is_none() => bail!("--kind logo needs --logo FILE.png"),
        Circles if args.rings.is_some() && args.period.is_some() => {
            bail!("--rings takes the periods of --period-ratio; leave --period out")
        }
        Cells if args.image.is_some() && args.step_deg.is_some() => {
            bail!("--image gives the angles; leave --step-deg out")
        }
        Cells if args.image.is_none() && (args.invert || args.period.is_some()) => {
            bail!("--invert and --period of cells need --image FILE.png")
        }
        _ => Ok(()),
    }
}

fn drawing(args: &Args, console: &Console) -> Result<Drawing> {
    let cell = args.cell_size.unwrap_or(16);
    let stencil = |path: &Path| read_stencil(path, args.invert);
    let kind = match args.kind {
        KindName::Circles => Kind::Circles { rings: args.rings },
        KindName::Logo => logo(args, console)?,
        KindName::Guilloche => Kind::Guilloche,
        KindName::Flakes => {
            Kind::Flakes { size: f64::from(cell), seed: args.seed.unwrap_or_default() }
        }
        KindName::Ramp => Kind::Ramp,
        KindName::Cells => Kind::Cells {
            size: cell,
            step_deg: args.step_deg.unwrap_or(15.0),
            picture: args.image.as_deref().map(stencil).transpose()?,
        },
    };
    let [width, height] = args.size;
    let ranges = Ranges { period_ratio: args.period_ratio, depth_ratio: args.depth_ratio };
    let (angle_deg, period_ratio) = (args.angle_deg, args.period.unwrap_or(1.0));
    Ok(Drawing { width, height, ranges, angle_deg, period_ratio, kind })
}

fn logo(args: &Args, console: &Console) -> Result<Kind> {
    let path = args.logo.as_deref().unwrap_or(Path::new(""));
    let logo = read_stencil(path, args.invert)?;
    let file = path.display();
    if logo.inside_share() == 0.0 {
        let other = if args.invert { "leave --invert out" } else { "try --invert" };
        bail!(
            "--logo {file}: brightness times opacity is below 0.5 everywhere, so nothing is inside; {other}"
        );
    }
    let soft = logo.soft_share();
    if soft > 0.0 {
        let percent = 100.0 * soft;
        console.note(&format!(
            "{file}: {percent:.1} % of its pixels are neither inside nor outside; the edge is where brightness times opacity is 0.5"
        ));
    }
    let is_bare = args.ground_angle_deg.is_none() && args.ground_period.is_none();
    let ground = (!is_bare).then(|| Groove {
        angle_rad: args.ground_angle_deg.unwrap_or(0.0).to_radians(),
        period_ratio: args.ground_period.unwrap_or(1.0),
        depth_ratio: args.depth_ratio[0],
    });
    Ok(Kind::Logo { logo, ground })
}
