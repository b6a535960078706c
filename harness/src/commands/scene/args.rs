//! Options of `cargo xtask scene`.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Result, bail};
use diffraction_cli::args::PlanArgs;
use diffraction_cli::memory::MemoryArgs;

const EXAMPLE: &str = "Examples:
  cargo xtask scene --plan plans/scene.toml --surface fingers --variant lamp --out snake.png
  cargo xtask scene --plan plans/scene.toml --surface rows --variant lamp --zoom 2.2 --target 1.9,0.5,0 --filter supersample --out close.png
  cargo xtask scene --plan plans/scene.toml --surface blazed --variant ensemble --mesh sphere --elevation 20 --out sphere.exr
  cargo xtask scene --plan plans/scene.toml --surface fingers --variant lamp --sweep lights --size 480x360 --out lights.png
  cargo xtask scene --plan plans/scene.toml --surface fingers --variant baked --sweep zoom --filter footprint --size 480x360 --out zoom.png
  cargo xtask scene --plan plans/scene.toml --surface rows --variant lamp --sweep turntable --size 480x360 --out turntable.png
  cargo xtask scene --plan plans/scene.toml --surface fingers --variant baked --truth --size 640x360
  cargo xtask scene --plan plans/scene.toml --surface cd,fingers --variant baked --mesh torus-knot --sweep flicker --size 1920x1080
  cargo xtask scene --plan plans/scene.toml --surface cd --variant orders --mesh sphere --filter supersample --out sun.png
  cargo xtask scene --plan plans/scene.toml --surface crossed --variant orders --mesh sphere --lights studio.toml --out studio.png
  cargo xtask scene --plan plans/scene.toml --surface crossed --variant orders --mesh sphere --lights studio.toml --truth --size 320x240
  cargo xtask scene --plan plans/scene.toml --surface crossed --variant orders --mesh sphere --lights room.toml --no-diffraction --out room.png
  cargo xtask pattern --kind flakes --out flakes.png
  cargo xtask scene --plan plans/scene.toml --surface foil --variant foil --mesh card --pattern-map flakes.png --filter supersample --out card.png

A room.toml with a panorama by formula; file = \"room.exr\" takes one of your own:
  schema = 1
  [[light]]
  kind = \"environment\"
  studio = \"window\"

A studio.toml with a rectangular softbox to the upper left and a bulb to the right:
  schema = 1
  [[light]]
  kind = \"polygon\"
  corners = [[35, 95], [35, 145], [65, 145], [65, 95]]
  radiance = 1.0
  [[light]]
  kind = \"disc\"
  direction = [70, 40]
  diameter_deg = 5.0
  irradiance = 0.3

The command for docs/snake.png:
  cargo xtask scene --plan plans/scene.toml --surface blazed,fingers,rows --variant lamp --sweep orientation --zoom 2.5 --target 1.9,0.1,0 --light -0.35,0.4,0.85 --filter supersample --size 244x150 --out docs/snake.png

World: right-handed, y up. At azimuth and elevation 0 the camera is on +z. In a file of lights, theta counts from +y and phi from
+x towards +z, so [90, 90] is at the camera, [0, 0] above.

Colours are radiances: 1 is what a white diffuser shows that faces a light of irradiance π. Each --light has the irradiance π. A light of
a file has what the file states: under a disc of irradiance 1, a white diffuser that faces it shows 1/π; a polygon has its radiance.
The body's colour is lit by the same lights. Small bright spots of a map, such as the sun, become discs; a note says which.

Under a sky or a map, the lights with a size are the background, also in an EXR, whose alpha is the coverage of the body alone: to put
the body before another picture, write --no-background.

A PNG is tone-mapped: colours are multiplied by --exposure, negative components become 0. If the largest component m exceeds
0.6, it becomes 1 - 0.4 exp(-(m - 0.6)/0.4), and the others are scaled alike. An EXR holds the linear colours.";

#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) plan: PlanArgs,
    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
    /// Name of the surface for the skin. Several, separated by commas, give pictures side by side.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', required = true)]
    pub(crate) surface: Vec<String>,
    /// Name of the variant, as in the plan. Needed only if the plan has several.
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,
    /// The body: snake, sphere, torus-knot, card, or a .gltf, .glb or .obj file. Files that it names must lie below its folder. Limits: 512 MiB in
    /// all, 4 Mi vertices, 8 Mi triangles, 65536 nodes.
    #[arg(long, value_name = "snake|sphere|torus-knot|card|FILE", default_value = "snake")]
    pub(crate) mesh: String,
    /// Pattern map: angle, period, depth and share of the foil of each texel, as `cargo xtask pattern` writes them (docs/patterns.md). Needs a
    /// variant with pattern = true. Ratios outside the variant's ranges become their nearest ends; a note says how many.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) pattern_map: Option<PathBuf>,
    /// Width and height of a picture, in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub(crate) size: Size,
    /// Direction towards a light, in the world, of any length. May be repeated, for up to 4 lights.
    #[arg(
        long,
        value_name = "X,Y,Z",
        default_value = "-0.35,0.45,0.82",
        allow_hyphen_values = true
    )]
    pub(crate) light: Vec<Vector>,
    /// Angular diameter of each --light: a disc such as the sun, where the variant has a function for discs (mode = "orders", or
    /// "baked" with spread_levels). 0: a single direction, which is what other variants always have; their coherence length stands for the size of the light.
    #[arg(long, value_name = "DEG", default_value = "0.53", value_parser = diameter)]
    pub(crate) light_diameter_deg: f64,
    /// Lights of a file in place of --light: up to 4 of each kind. Discs, polygons, skies and maps need a variant with mode = "orders";
    /// single directions of a colour need --no-diffraction. docs/lights.md describes the file; its angles here are of the world, see below.
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["light", "light_diameter_deg"])]
    pub(crate) lights: Option<PathBuf>,
    /// Leave what is behind the body black. Otherwise, under a sky or a map, all lights with a size are seen behind it.
    #[arg(long)]
    pub(crate) no_background: bool,
    /// Draw the body's colour alone, without what its relief diffracts, under lights of any kind and colour.
    #[arg(long, conflicts_with = "truth")]
    pub(crate) no_diffraction: bool,
    /// Angle of the camera about the y axis, in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub(crate) azimuth: f64,
    /// Angle of the camera above the horizon, in degrees, between -90 and 90.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub(crate) elevation: f64,
    /// Zoom: the camera's distance is divided by this.
    #[arg(long, value_name = "Z", default_value_t = 1.0, allow_hyphen_values = true)]
    pub(crate) zoom: f64,
    /// Distance of the camera from the target at zoom 1, in units of the mesh. Default: the whole mesh is visible.
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    pub(crate) distance: Option<f64>,
    /// The point that the camera looks at. Default: the centre of the mesh.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) target: Option<Vector>,
    /// Factor on the colours before the tone map. Default: 0.5; with --lights, 0.5 divided by what a white diffuser shows that faces all
    /// of the lights.
    #[arg(long, value_name = "V", allow_hyphen_values = true)]
    pub(crate) exposure: Option<f64>,
    /// Weight of the body's own colour, shown unlit over everything: 0 (none) to 1 (only that). Unlit white is as bright as a white
    /// diffuser that faces a --light, or all lights of a file.
    #[arg(long, value_name = "W", default_value_t = 0.0)]
    pub(crate) texture_weight: f64,
    /// Angle by which the microstructure is turned everywhere, in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    pub(crate) orientation: f64,
    /// Filter against sparkling of distant highlights.
    #[arg(long, value_enum, default_value_t = Filter::None)]
    pub(crate) filter: Filter,
    /// Draw several pictures that differ in one setting: side by side with a row for each surface, or animated.
    #[arg(long, value_enum)]
    pub(crate) sweep: Option<Sweep>,
    /// Number of pictures of an animation.
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(2..=360))]
    pub(crate) frames: u32,
    /// Use the first adapter whose name contains this text. Default: graphics cards before software drivers.
    #[arg(long, value_name = "SUBSTRING")]
    pub(crate) adapter: Option<String>,
    /// Do not compare some of the driver's colours with the twin before the first result.
    #[arg(long)]
    pub(crate) unchecked: bool,
    /// Instead of drawing, compare the driver's picture and directions with the same scene in 64 bits and print the result as JSON;
    /// then again with a flipped bitangent, and with lights 1.5 times as wide where they have a size; these must fail. Exit code 1: over
    /// tolerance, or a fault was not caught.
    #[arg(long)]
    pub(crate) truth: bool,
    /// Draw each picture N more times and print the median time.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) time: u32,
    /// The picture to write: .png (tone-mapped, sRGB) or .exr (linear).
    #[arg(long, value_name = "FILE.png|.exr", required_unless_present_any = ["truth", "time", "sweep"])]
    pub(crate) out: Option<PathBuf>,
}

/// Filter against sparkling of distant highlights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Filter {
    /// Four samples per pixel at edges only.
    None,
    /// Widen lobes by the pixel's footprint; needs mode = "baked" and coherence = "ensemble". Without spread_levels the variant is drawn
    /// with "auto".
    Footprint,
    /// Shade 16 points per pixel.
    Supersample,
    /// Shade 16 points per pixel, each widened by its own smaller footprint: for bodies with details below the size of a pixel.
    Both,
}

impl Filter {
    pub(crate) fn widens(self) -> bool {
        matches!(self, Filter::Footprint | Filter::Both)
    }

    pub(crate) fn supersamples(self) -> bool {
        matches!(self, Filter::Supersample | Filter::Both)
    }
}

/// The setting that changes from picture to picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Sweep {
    /// The six light directions printed in the thesis. The first has a misprint: -3.3130 is taken as -0.0130, which gives unit length.
    Lights,
    /// Zoom 0.1, 0.2, 0.5, 1, 1.5, 2.
    Zoom,
    /// The microstructure turned by 0°, 30°, 60°, 90°.
    Orientation,
    /// Once around the body, as an animated PNG.
    Turntable,
    /// The camera swings to both sides of --azimuth by 30°, once forth and back, as an animated PNG: as a card that is tilted by hand.
    Tilt,
    /// From --zoom away from the body until it is 10 pixels wide, each picture smaller by the same factor, as an animated PNG.
    Recede,
    /// Three frames, the camera a third of a pixel further each time. Prints as JSON, for the filters none and footprint and for a
    /// lobe of GGX with as much light: bright_pixels, within the black body, above 0.5 of the displayed luminance in any frame;
    /// flicker, the share of them that changes by more than 0.25; light, that of the picture relative to the mean of 64 points per
    /// pixel; seconds, the least time of a frame. --filter has no effect, --out writes the first frames side by side.
    Flicker,
}

/// A diameter: 0, or what functions for discs take.
fn diameter(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok();
    let value = value.filter(|value| *value == 0.0 || (0.02..=179.9).contains(value));
    value.ok_or_else(|| "expected 0, or a diameter in degrees from 0.02 to 179.9".to_owned())
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
    /// Checks that concern several options.
    pub(crate) fn check(&self) -> Result<()> {
        if !(0.0..=1.0).contains(&self.texture_weight) {
            bail!("--texture-weight {}: expected a number from 0 to 1", self.texture_weight);
        }
        if let Some(exposure) = self.exposure.filter(|v| !(*v > 0.0 && v.is_finite())) {
            bail!("--exposure {exposure}: expected a positive number");
        }
        if self.lights.is_some() && self.sweep == Some(Sweep::Lights) {
            bail!("--sweep lights: has lights of its own, so it cannot be used with --lights");
        }
        if self.light.iter().any(|light| light.0 == [0.0; 3]) {
            bail!("--light 0,0,0: expected a direction, which has a length above 0");
        }
        let Some(out) = &self.out else {
            if matches!(self.sweep, None | Some(Sweep::Flicker)) || self.truth || self.time > 0 {
                return Ok(());
            }
            bail!("--sweep: its pictures need --out FILE.png");
        };
        let extension = out.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let several = self.sweep.is_some() || self.surface.len() > 1;
        match extension.as_deref() {
            Some("png") => {}
            Some("exr") if !several => {}
            Some("exr") => bail!("--out {}: several pictures need a .png", out.display()),
            _ => bail!("--out {}: the name must end in .png or .exr", out.display()),
        }
        Ok(())
    }
}
