//! Flags of `cargo xtask scene`.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Result, bail};
use diffraction_cli::args::PlanArgs;

const EXAMPLE: &str = "Examples:
  cargo xtask scene --plan plans/scene.toml --surface fingers --variant lamp --out snake.png
  cargo xtask scene --plan plans/scene.toml --surface rows --variant lamp --zoom 2.2 --target 1.9,0.5,0 --filter supersample --out close.png
  cargo xtask scene --plan plans/scene.toml --surface blazed --variant ensemble --mesh sphere --elevation 20 --out sphere.exr
  cargo xtask scene --plan plans/scene.toml --surface fingers --variant lamp --sweep lights --size 480x360 --out lights.png
  cargo xtask scene --plan plans/scene.toml --surface fingers --variant baked --sweep zoom --filter footprint --size 480x360 --out zoom.png
  cargo xtask scene --plan plans/scene.toml --surface rows --variant lamp --sweep turntable --size 480x360 --out turntable.png
  cargo xtask scene --plan plans/scene.toml --surface fingers --variant baked --truth --size 640x360

The picture docs/snake.png:
  cargo xtask scene --plan plans/scene.toml --surface blazed,fingers,rows --variant lamp --sweep orientation --zoom 2.5 --target 1.9,0.1,0 --light -0.35,0.4,0.85 --filter supersample --size 244x150 --out docs/snake.png

The tone map: colours are exposed, negative components become 0, and a greatest component m above 0.6 is brought to
1 - 0.4 exp(-(m - 0.6)/0.4), the others in proportion. An EXR holds the linear picture.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) plan: PlanArgs,
    /// The surface of the skin; several, with commas: pictures side by side.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', required = true)]
    pub(crate) surface: Vec<String>,
    /// The variant; not needed where the plan has only one.
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,
    /// snake, sphere, or a .gltf, .glb or .obj file.
    #[arg(long, value_name = "snake|sphere|FILE", default_value = "snake")]
    pub(crate) mesh: String,
    /// Pixels of a picture.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub(crate) size: Size,
    /// Direction to a light in the world; may be repeated, up to four times.
    #[arg(
        long,
        value_name = "X,Y,Z",
        default_value = "-0.35,0.45,0.82",
        allow_hyphen_values = true
    )]
    pub(crate) light: Vec<Vector>,
    /// Angle of the camera about the upright axis, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub(crate) azimuth: f64,
    /// Angle of the camera above the horizon, degrees; below the snake if negative.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub(crate) elevation: f64,
    /// The camera's distance is divided by it.
    #[arg(long, value_name = "Z", default_value_t = 1.0, allow_hyphen_values = true)]
    pub(crate) zoom: f64,
    /// The camera's distance at zoom 1, in the mesh's unit; else the whole mesh is seen.
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    pub(crate) distance: Option<f64>,
    /// What the camera looks at; else the middle of the mesh.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) target: Option<Vector>,
    /// Factor before the tone map.
    #[arg(long, value_name = "V", default_value_t = 0.5, allow_hyphen_values = true)]
    pub(crate) exposure: f64,
    /// Weight w_d of the unlit texture, 0 to 1.
    #[arg(long, value_name = "W", default_value_t = 0.0)]
    pub(crate) texture_weight: f64,
    /// Turns the orientation field of all vertices, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub(crate) orientation: f64,
    /// What keeps distant highlights from sparkling.
    #[arg(long, value_enum, default_value_t = Filter::None)]
    pub(crate) filter: Filter,
    /// Several pictures: side by side in a .png, a row for each surface, or animated.
    #[arg(long, value_enum)]
    pub(crate) sweep: Option<Sweep>,
    /// Pictures of a turntable.
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(2..=360))]
    pub(crate) frames: u32,
    /// Take the adapter whose name contains this; else graphics cards come first.
    #[arg(long, value_name = "SUBSTRING")]
    pub(crate) adapter: Option<String>,
    /// Compare the driver's picture and the directions it used with the same scene in f64, as JSON, and again with a flipped
    /// bitangent; exit 1 over tolerance, or where the flip is not caught.
    #[arg(long)]
    pub(crate) truth: bool,
    /// Draw each picture so many times more and tell the median time.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) time: u32,
    /// The picture: .png (tone-mapped, sRGB) or .exr (linear).
    #[arg(long, value_name = "FILE.png|.exr", required_unless_present_any = ["truth", "time"])]
    pub(crate) out: Option<PathBuf>,
}

/// What keeps distant highlights from sparkling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Filter {
    /// Nothing but the four samples at edges.
    None,
    /// Lobes are widened by the pixel's footprint; needs coherence = "ensemble".
    Footprint,
    /// Sixteen shaded points to a pixel.
    Supersample,
}

/// What changes from picture to picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Sweep {
    /// The six light directions printed in the texts; -3.3130 in the first is a misprint, read as -0.0130 (of unit length).
    Lights,
    /// Zoom 0.1, 0.2, 0.5, 1, 1.5, 2.
    Zoom,
    /// The orientation field turned by 0°, 30°, 60°, 90°.
    Orientation,
    /// Once around the body; an animated PNG.
    Turntable,
}

/// Columns and rows of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size(pub(crate) [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Size, String> {
        let sides: Option<Vec<u32>> =
            text.split('x').map(|part| part.trim().parse().ok()).collect();
        match sides.as_deref() {
            Some([w, h]) if (1..=8192).contains(w) && (1..=8192).contains(h) => Ok(Size([*w, *h])),
            _ => Err("expected WxH, each from 1 to 8192, such as 1280x720".to_owned()),
        }
    }
}

/// Three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vector(pub(crate) [f64; 3]);

impl FromStr for Vector {
    type Err = String;

    fn from_str(text: &str) -> Result<Vector, String> {
        let numbers: Option<Vec<f64>> =
            text.split(',').map(|part| part.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) if [x, y, z].iter().all(|c| c.is_finite()) => Ok(Vector([x, y, z])),
            _ => Err("expected X,Y,Z, such as 0,0.5,1".to_owned()),
        }
    }
}

impl Args {
    /// What no single flag can check.
    pub(crate) fn check(&self) -> Result<()> {
        if !(0.0..=1.0).contains(&self.texture_weight) {
            bail!("--texture-weight {}: expected a number from 0 to 1", self.texture_weight);
        }
        if !(self.exposure > 0.0 && self.exposure.is_finite()) {
            bail!("--exposure {}: expected a positive number", self.exposure);
        }
        if let Some(light) = self.light.iter().find(|l| l.0 == [0.0; 3]) {
            bail!("--light {:?}: no direction", light.0);
        }
        let Some(out) = &self.out else { return Ok(()) };
        let extension = out.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let several = self.sweep.is_some() || self.surface.len() > 1;
        match extension.as_deref() {
            Some("png") => {}
            Some("exr") if !several => {}
            Some("exr") => bail!("--out {}: several pictures make a .png", out.display()),
            _ => bail!("--out {}: its name ends neither in .png nor in .exr", out.display()),
        }
        Ok(())
    }
}
