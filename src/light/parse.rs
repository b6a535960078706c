//! `lights.toml`: parsing, with the place of every error.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::de::DeTable;

use crate::error::Error;
use crate::optics::direction;
use crate::plan::toml::{Item, Source, Table};

use glam::DVec3;

use super::{Cap, Environment, Light, Lights, MAX_CORNERS, Panorama, Polygon, PolygonFault};

/// Maximum number of lights.
const MAX_LIGHTS: usize = 64;

/// Kinds of lights with their keys.
const KINDS: [(&str, &[&str]); 5] = [
    ("direction", &["direction", "irradiance"]),
    ("disc", &["direction", "diameter_deg", "irradiance"]),
    ("polygon", &["corners", "radiance"]),
    ("sky", &["radiance"]),
    ("environment", &["file", "scale", "rotate_deg"]),
];

/// Keys of every light.
const COMMON: [&str; 2] = ["kind", "colour"];

const EXAMPLE: &str = "a file of lights needs schema = 1 and at least one [[light]], such as kind = \"disc\", direction = [20, 0], diameter_deg = 0.53, irradiance = 1";

impl Lights {
    /// Checks the text of a `lights.toml`. `path` is its name in messages. `open` reads a panorama that it names, with notes.
    /// Returns all errors, in the order of the text.
    pub fn parse(text: &str, path: &Path, open: Open<'_>) -> Result<Lights, Vec<Error>> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source::new(text, path.display());
        let (document, faults) = DeTable::parse_recoverable(text);
        if !faults.is_empty() {
            source.fail_toml(&faults);
            return Err(source.into_errors());
        }
        let lights = read(&Table::root(&source, document.get_ref()), open);
        let errors = source.into_errors();
        if errors.is_empty() { Ok(lights) } else { Err(errors) }
    }
}

/// Reads a panorama, with notes. Its path is as the file of lights has it.
pub type Open<'a> = &'a dyn Fn(&Path) -> Result<(Panorama, Vec<String>), Error>;

fn read(root: &Table, open: Open<'_>) -> Lights {
    root.only(&["schema", "light"]);
    root.schema("the version of the format; write schema = 1");
    let tables = root.tables("light");
    if tables.is_empty() && root.get("light").is_none() {
        root.source.fail_file("has no light", EXAMPLE);
    }
    if let (true, Some(item)) = (tables.len() > MAX_LIGHTS, root.get("light")) {
        item.fail(format!("has more than {MAX_LIGHTS} lights"), "combine or remove lights");
        return Lights::default();
    }
    let mut lights = Lights::default();
    for table in &tables {
        lights.all.extend(light(table, open, &mut lights.notes));
    }
    lights
}

fn light(table: &Table, open: Open<'_>, notes: &mut Vec<String>) -> Option<Light> {
    let kind = table.require("kind", "direction, disc, polygon, sky or environment")?;
    let kinds = KINDS.map(|(name, keys)| (name, (name, keys)));
    let (kind, keys) = kind.word(&kinds)?;
    table.only(&[&COMMON, keys].concat());
    let colour = colour(table);
    let white = match kind {
        "direction" => Some(Light::Direction {
            direction: towards(table)?,
            irradiance: power(table, "irradiance")?,
        }),
        "disc" => {
            let item =
                table.require("diameter_deg", "the diameter in degrees; the sun has 0.53")?;
            let what = "the diameter in degrees; a narrower light is kind = \"direction\", a whole hemisphere a sky";
            let diameter =
                item.number("from 0.012 to 179.9", what, |x| (0.012..=179.9).contains(&x));
            let irradiance = power(table, "irradiance")?;
            let axis = towards(table)?;
            Some(Light::Disc {
                cap: Cap { axis, radius_rad: (0.5 * diameter?).to_radians() },
                irradiance,
            })
        }
        "polygon" => {
            Some(Light::Polygon { polygon: polygon(table)?, radiance: power(table, "radiance")? })
        }
        "environment" => environment(table, open, notes).map(Light::Environment),
        _ => Some(Light::Sky { radiance: power(table, "radiance")? }),
    };
    Some(white?.coloured(colour?))
}

fn environment(table: &Table, open: Open<'_>, notes: &mut Vec<String>) -> Option<Environment> {
    let file = table.require("file", "the path of a panorama, .exr or .hdr")?;
    let name = file.string("a path")?;
    let what = "what the picture has at phi stands at phi + rotate_deg";
    let turned = |item: Item| item.number("from -360 to 360", what, |x| x.abs() <= 360.0);
    let rotate_deg = table.get("rotate_deg").map_or(Some(0.0), turned);
    let scale = power(table, "scale");
    let (panorama, said) = open(&PathBuf::from(name))
        .map_err(|error| file.fail(error.message(), error.advice().unwrap_or("check the path")))
        .ok()?;
    notes.extend(said);
    Some(Environment { panorama: Arc::new(panorama), scale: scale?, rotate_deg: rotate_deg? })
}

/// Linear sRGB; white without the key.
fn colour(table: &Table) -> Option<DVec3> {
    let Some(item) = table.get("colour") else { return Some(DVec3::ONE) };
    let what = "linear sRGB; white, the colour of the illuminant, is [1, 1, 1]";
    let channel = |item: &Item| item.number("from 0 to 1e6", what, |x| (0.0..=1e6).contains(&x));
    let elements = item.elements("three numbers")?;
    let channels: Vec<f64> = elements.iter().filter_map(channel).collect();
    match channels.as_slice() {
        [red, green, blue] if elements.len() == 3 => Some(DVec3::new(*red, *green, *blue)),
        _ if elements.len() == 3 => None,
        _ => {
            item.fail("is not three numbers", what);
            None
        }
    }
}

fn power(table: &Table, key: &str) -> Option<f64> {
    let what = "1 is white of Y = 1 (radiance), or what a white diffuser shows as 1/π (irradiance)";
    let Some(item) = table.get(key) else { return Some(1.0) };
    item.number("from 0 to 1e6", what, |x| (0.0..=1e6).contains(&x))
}

fn towards(table: &Table) -> Option<DVec3> {
    let what = "[theta, phi] in degrees: theta from the normal, phi from the tangent";
    angles(&table.require("direction", what)?)
}

fn angles(item: &Item) -> Option<DVec3> {
    let what = "[theta, phi] in degrees; theta is from 0 to 180";
    let elements = item.elements("two numbers")?;
    let [theta, phi] = elements.as_slice() else {
        item.fail("is not two numbers", what);
        return None;
    };
    let theta = theta.number("from 0 to 180", what, |x| (0.0..=180.0).contains(&x));
    let phi = phi.number("from -360 to 360", what, |x| x.abs() <= 360.0);
    Some(direction(theta?, phi?))
}

fn polygon(table: &Table) -> Option<Polygon> {
    let what = "3 to 8 directions, such as [[10, 0], [30, 0], [30, 40]]";
    let item = table.require("corners", what)?;
    let elements = item.elements("directions")?;
    if !(3..=MAX_CORNERS).contains(&elements.len()) {
        item.fail(format!("has {} corners", elements.len()), what);
        return None;
    }
    let corners: Vec<_> = elements.iter().filter_map(angles).collect();
    if corners.len() < elements.len() {
        return None;
    }
    let fault = match Polygon::new(&corners) {
        Ok(polygon) => return Some(polygon),
        Err(PolygonFault::Count) => what.to_owned(),
        Err(PolygonFault::Coincide(one, other)) => {
            format!("corners {one} and {other} coincide, or are opposite")
        }
        Err(PolygonFault::NotConvex(corner)) => {
            format!("is not convex at corner {corner}, or is wider than a hemisphere")
        }
    };
    item.fail(fault, "list the corners of a convex polygon in their order; divide other shapes into several lights");
    None
}
