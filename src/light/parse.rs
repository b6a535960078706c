//! `lights.toml`: parsing, with the place of every error.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::de::DeTable;

use crate::error::Error;
use crate::optics::direction;
use crate::plan::toml::{Item, Source, Table};

use glam::DVec3;

use super::{
    Cap, Environment, LampSearch, Light, Lights, MAX_CORNERS, MAX_LAMP_DEG, Panorama, Polygon,
    PolygonFault, Studio, TakenOut,
};

/// Maximum number of lights.
const MAX_LIGHTS: usize = 64;

/// Kinds of lights with their keys.
const KINDS: [(&str, &[&str]); 5] = [
    ("direction", &["direction", "irradiance"]),
    ("disc", &["direction", "diameter_deg", "irradiance"]),
    ("polygon", &["corners", "radiance"]),
    ("sky", &["radiance"]),
    ("environment", &["file", "studio", "scale", "rotate_deg", "lamps", "lamp_threshold"]),
];

/// Keys of every light.
const COMMON: [&str; 2] = ["kind", "colour"];

const EXAMPLE: &str = "a file of lights needs schema = 1 and at least one [[light]], such as kind = \"disc\", direction = [20, 0], diameter_deg = 0.53, irradiance = 1";

impl Lights {
    /// Checks the text of a `lights.toml`. `path` is its name in messages. `open` reads a panorama that it names, with notes.
    /// Returns all errors, in the order of the text.
    pub fn parse(text: &str, path: &Path, open: Open<'_>) -> Result<Lights, Vec<Error>> {
        Lights::parse_with(text, path, open, LampSearch::None)
    }

    /// The same. `lamps`: what happens to lamps in a map of which the text does not say it.
    pub fn parse_with(
        text: &str,
        path: &Path,
        open: Open<'_>,
        lamps: LampSearch,
    ) -> Result<Lights, Vec<Error>> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source::new(text, path.display());
        let (document, faults) = DeTable::parse_recoverable(text);
        if !faults.is_empty() {
            source.fail_toml(&faults);
            return Err(source.into_errors());
        }
        let lights = read(&Table::root(&source, document.get_ref()), open, lamps);
        let errors = source.into_errors();
        if errors.is_empty() { Ok(lights) } else { Err(errors) }
    }
}

/// Reads a panorama, with notes. Its path is as the file of lights has it.
pub type Open<'a> = &'a dyn Fn(&Path) -> Result<(Panorama, Vec<String>), Error>;

fn read(root: &Table, open: Open<'_>, lamps: LampSearch) -> Lights {
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
        let mut said = Vec::new();
        let found = light(table, open, &mut said).into_iter();
        lights.all.extend(found.flat_map(|light| divided(table, light, lamps, &mut said)));
        lights.notes.extend(said);
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
    let what = "what the picture has at phi stands at phi + rotate_deg";
    let turned = |item: Item| item.number("from -360 to 360", what, |x| x.abs() <= 360.0);
    let rotate_deg = table.get("rotate_deg").map_or(Some(0.0), turned);
    let scale = power(table, "scale");
    let either = "write file = \"studio.exr\" (.exr or .hdr), or studio = \"softboxes\", \"window\" or \"gradient\"";
    let panorama = match (table.get("file"), table.get("studio")) {
        (Some(file), None) => {
            let name = file.string("a path")?;
            let refused = |error: Error| {
                file.fail(error.message(), error.advice().unwrap_or("check the path"));
            };
            let (panorama, said) = open(&PathBuf::from(name)).map_err(refused).ok()?;
            notes.extend(said);
            panorama
        }
        (None, Some(studio)) => studio.word(&Studio::WORDS)?.panorama(Studio::WIDTH),
        (None, None) => {
            let cause = format!("{}: has neither file nor studio", table.path);
            table.fail(cause, Some(either.to_owned()));
            return None;
        }
        (Some(_), Some(studio)) => {
            studio.fail("stands beside a file", format!("keep one of them: {either}"));
            return None;
        }
    };
    Some(Environment { panorama: Arc::new(panorama), scale: scale?, rotate_deg: rotate_deg? })
}

/// A light as it is, or a map without its lamps, and these. `by_default`: what happens to lamps unless the table says it.
fn divided(
    table: &Table,
    light: Light,
    by_default: LampSearch,
    notes: &mut Vec<String>,
) -> Vec<Light> {
    let (white, colour) = light.white();
    let Light::Environment(environment) = white else { return vec![light] };
    let Some(search) = search(table, by_default) else { return Vec::new() };
    let Some(taken) = environment.without_lamps(search) else { return vec![light] };
    notes.extend(said(&table.path, search, &taken));
    let all = taken.lamps.iter().map(|lamp| lamp.light().coloured(colour));
    [Light::Environment(taken.rest.clone()).coloured(colour)].into_iter().chain(all).collect()
}

/// How lamps of a map are sought. `None` if a key is wrong.
fn search(table: &Table, by_default: LampSearch) -> Option<LampSearch> {
    let what = "radiance above which a small spot is a lamp, in the units of the light: the map's times scale";
    let words = [("none", LampSearch::None), ("auto", LampSearch::Auto)];
    let word = table.get("lamps").map(|item| item.word(&words));
    let threshold = table.get("lamp_threshold");
    let number = threshold
        .clone()
        .map(|item| item.number("above 0 and at most 1e12", what, |x| x > 0.0 && x <= 1e12));
    match (word, number) {
        (Some(None), _) | (_, Some(None)) => None,
        (Some(Some(LampSearch::None)), Some(_)) => {
            let cause = "stands beside lamps = \"none\"";
            threshold?.fail(cause, "remove one of them");
            None
        }
        (_, Some(Some(radiance))) => Some(LampSearch::Above(radiance)),
        (Some(word), None) => word,
        (None, None) => Some(by_default),
    }
}

/// What a user should know about the lamps of a map. `None` if there is nothing to say.
fn said(subject: &str, search: LampSearch, taken: &TakenOut) -> Option<String> {
    let found = match search {
        LampSearch::Above(_) => "as given",
        _ => "16 times the map's mean",
    };
    let threshold = format!("radiance {:.4}, {found}", taken.threshold);
    if taken.lamps.is_empty() {
        // a map without lamps is as it was; who asked for them should know
        let asked = matches!(search, LampSearch::Above(_));
        return asked.then(|| {
            format!("{subject}: no lamp of at most {MAX_LAMP_DEG}° in radius above {threshold}")
        });
    }
    let each = taken.lamps.iter().map(|lamp| {
        let axis = lamp.cap.axis;
        let theta = axis.truncate().length().atan2(axis.z).to_degrees();
        let phi = axis.y.atan2(axis.x).to_degrees();
        let wide = 2.0 * lamp.cap.radius_rad.to_degrees();
        let (white, colour) = (lamp.light(), lamp.irradiance);
        let irradiance = match white.white().0 {
            Light::Disc { irradiance, .. } => *irradiance,
            _ => colour.max_element(),
        };
        format!("{wide:.2}° wide at [{theta:.2}, {phi:.2}] of irradiance {irradiance:.4}")
    });
    let each: Vec<String> = each.collect();
    let more = match taken.others {
        0 => String::new(),
        n => format!("; {n} weaker ones stay in the map"),
    };
    let count = match each.len() {
        1 => "1 lamp is".to_owned(),
        n => format!("{n} lamps are"),
    };
    Some(format!(
        "{subject}: {count} taken out of the map above {threshold}, to be discs: {}{more} (lamps = \"none\" keeps them in)",
        each.join("; ")
    ))
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
