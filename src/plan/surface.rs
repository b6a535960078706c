//! `[[surface]]`: names, gratings, files.

use std::path::Path;

use serde::Deserialize;

use super::item::{Item, Table, suggest};
use super::{Grating, Level, SurfaceOptics, SurfaceSource, SurfaceSpec, words};

mod file;

pub(super) const KEYS: [&str; 17] = [
    "name",
    "grating",
    "file",
    "size_um",
    "size_y_um",
    "pixel_um",
    "height_um",
    "z_unit_um",
    "void_value",
    "channel",
    "flip",
    "trust",
    "resample_um",
    "rotate_deg",
    "level",
    "clip_percent",
    OPTICS,
];

/// The words that a key of [`KEYS`] accepts.
pub(super) fn words_of(key: &str) -> Vec<&'static str> {
    match key {
        "level" => words::names(words::LEVELS),
        "flip" => words::names(words::FLIPS),
        "trust" => words::names(words::TRUSTS),
        "void_value" => words::names(words::VOIDS),
        _ => Vec::new(),
    }
}

/// The key of [`KEYS`] that is a table of optics.
pub(super) const OPTICS: &str = "optics";

/// Reads one surface. `shortest_nm` returns the shortest wavelength of the variants for the surface of that name.
pub(super) fn read(
    table: &Table,
    folder: &Path,
    shortest_nm: &dyn Fn(&str) -> f64,
) -> Option<SurfaceSpec> {
    table.only(&KEYS);
    let name = name(table)?;
    let lambda_min_nm = shortest_nm(&name);
    let table = &table.renamed(format!("surface.{name}"));
    let rotate_deg = match table.get("rotate_deg") {
        Some(item) => item.number("finite", "an angle in degrees", |_| true)?,
        None => 0.0,
    };
    let level = match table.get("level") {
        Some(item) => item.word(words::LEVELS)?,
        None => Level::None,
    };
    let clip_percent = match table.get("clip_percent") {
        Some(item) => {
            let what = "the percentage of heights clipped at each end";
            item.number("from 0 to below 50", what, |x| (0.0..50.0).contains(&x))?
        }
        None => 0.0,
    };
    let optics = match table.get(OPTICS) {
        Some(item) => SurfaceOptics::read(&item.table("{ refractive_index = … }")?),
        None => SurfaceOptics::default(),
    };
    let source = match (table.get("grating"), table.get("file")) {
        (Some(item), None) => SurfaceSource::Grating(grating_surface(table, &item, lambda_min_nm)?),
        (None, Some(item)) => {
            SurfaceSource::File(file::read(table, &item, folder, limit_um(lambda_min_nm))?)
        }
        (grating, _) => {
            let cause = if grating.is_some() {
                "has both grating and file"
            } else {
                "has neither grating nor file"
            };
            let remedy = "give exactly one of grating = { kind = … } and file = \"…\"".to_owned();
            table.fail(format!("{} {cause}", table.path), Some(remedy));
            return None;
        }
    };
    Some(SurfaceSpec { name, source, rotate_deg, level, clip_percent, optics })
}

/// Reads the key `name`: 1 to 64 lower-case letters, digits and hyphens.
pub(super) fn name(table: &Table) -> Option<String> {
    let item = table.require("name", "a name of 1 to 64 characters a-z, 0-9 and hyphens")?;
    let text = item.string("a name of 1 to 64 characters a-z, 0-9 and hyphens")?;
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if text.is_empty() || text.len() > 64 || !text.chars().all(allowed) {
        item.fail(
            "is not a valid name",
            "use 1 to 64 characters a-z, 0-9 and hyphens; the name becomes a folder",
        );
        return None;
    }
    if let Some(reason) = reserved(text) {
        item.fail(reason, "use another name; it becomes the name of a folder");
        return None;
    }
    Some(text.to_owned())
}

/// Why a name of a folder makes trouble elsewhere: Windows cannot have it, or programs take it for an option.
fn reserved(name: &str) -> Option<&'static str> {
    let device = ["com", "lpt"].iter().find_map(|port| name.strip_prefix(port));
    let is_port = device
        .is_some_and(|number| number.len() == 1 && number != "-" && number.parse::<u8>().is_ok());
    match name {
        "con" | "prn" | "aux" | "nul" => {
            Some("is a device on Windows, where no folder can have this name")
        }
        _ if is_port => Some("is a device on Windows, where no folder can have this name"),
        _ if name.starts_with('-') => {
            Some("begins with a hyphen, which programs take for an option")
        }
        _ => None,
    }
}

fn grating_surface(table: &Table, item: &Item, lambda_min_nm: f64) -> Option<Grating> {
    for key in file::KEYS {
        if let Some(item) = table.get(key) {
            item.fail(
                "is a key of surfaces with a file",
                "put the keys of a synthetic surface inside grating = { … }",
            );
            return None;
        }
    }
    let table = item.table("{ kind = … }")?;
    table.require(
        "kind",
        "flat, sinusoidal, blazed, lamellar, triangle, crossed, bumps, fingers or rows",
    )?;
    let sound = check_numbers(&table);
    if !kinds_are_words(&table) {
        return None;
    }
    let grating = match item.plain().map(Grating::deserialize) {
        Some(Ok(grating)) => grating,
        Some(Err(error)) => {
            explain(&table, &error.to_string());
            return None;
        }
        None => {
            item.fail("is not a grating", "expected { kind = … }");
            return None;
        }
    };
    if let Grating::Crossed { x, y } = &grating {
        for (key, part) in [("x", x), ("y", y)] {
            if matches!(
                **part,
                Grating::Crossed { .. }
                    | Grating::Bumps(_)
                    | Grating::Fingers(_)
                    | Grating::Rows(_)
            ) {
                let item = table.get(key)?;
                item.fail(
                    "is not a one-dimensional grating",
"use flat, sinusoidal, blazed, lamellar or triangle as parts of a crossed grating",
                );
                return None;
            }
        }
    }
    (sound && check_pitch(&table, limit_um(lambda_min_nm))).then_some(grating)
}

/// Checks that the kind of a grating, and of each of its parts, is a string.
fn kinds_are_words(table: &Table) -> bool {
    table.items().into_iter().all(|(key, item)| match key {
        "kind" => item.string("flat, sinusoidal, blazed …").is_some(),
        "x" | "y" => {
            !item.is_table() || item.table("a grating").is_none_or(|part| kinds_are_words(&part))
        }
        _ => true,
    })
}

/// Checks all numbers of a grating by the names of their keys, so that all errors are reported together.
fn check_numbers(table: &Table) -> bool {
    let mut sound = true;
    for (key, item) in table.items() {
        sound &= match key {
            "kind" => true,
            "x" | "y" => item.table("a grating").is_some_and(|part| check_numbers(&part)),
            "pixels" => {
                item.whole(2..16385, "the number of pixels along the period or side").is_some()
            }
            "seed" => item.whole(0..i64::MAX as u64, "the seed of the generator").is_some(),
            "duty" | "apex" => item
                .number("between 0 and 1, both excluded", "a share of the period", |x| {
                    x > 0.0 && x < 1.0
                })
                .is_some(),
            "regularity" => item
                .number(
                    "from 0 to 1",
                    "the regularity of the placement, 1 for a perfect lattice",
                    |x| (0.0..=1.0).contains(&x),
                )
                .is_some(),
            "height_um" => item.positive("a height in µm").is_some(),
            _ if key.ends_with("_um") => item.positive("a length in µm").is_some(),
            _ => item
                .plain()
                .is_none_or(|value| value.as_float().is_none_or(f64::is_finite) || refuse(&item)),
        };
    }
    sound
}

fn refuse(item: &Item) -> bool {
    item.fail("is not finite", "write a finite number");
    false
}

/// The maximum pitch that resolves all orders with `|u| ≤ 2`.
fn limit_um(lambda_min_nm: f64) -> f64 {
    lambda_min_nm / 4000.0
}

fn too_coarse(pitch_um: f64, limit_um: f64) -> bool {
    pitch_um > limit_um * (1.0 + 1e-9)
}

fn check_pitch(table: &Table, limit_um: f64) -> bool {
    let parts = ["x", "y"].map(|key| table.get(key).and_then(|item| item.table("a grating")));
    let parts_are_sound = parts.into_iter().flatten().all(|part| check_pitch(&part, limit_um));
    let length = table.get("period_um").or_else(|| table.get("size_um"));
    let (Some(length), Some(pixels)) = (length, table.get("pixels")) else {
        return parts_are_sound;
    };
    let (Some(size_um), Some(count)) = (length.positive("µm"), pixels.whole(2..16385, "pixels"))
    else {
        return false;
    };
    let pitch = size_um / count as f64;
    if too_coarse(pitch, limit_um) {
        let min_pixels = (size_um / limit_um * (1.0 - 1e-9)).ceil();
        let cause = format!(
            "a pitch of {pitch:.4} µm is above a quarter of the shortest wavelength, {limit_um} µm"
        );
        pixels.fail(cause, format!("use at least {min_pixels} pixels for {size_um} µm"));
        return false;
    }
    parts_are_sound
}

/// The kinds of gratings (`None`), or the keys of one kind, taken from the error message of the deserialiser.
pub(super) fn grating_words(kind: Option<&str>) -> Vec<String> {
    let pair = |key: &str, value: &str| (key.to_owned(), toml::Value::String(value.to_owned()));
    let table = [pair("kind", kind.unwrap_or("?")), pair("?", "?")].into_iter().collect();
    let message = Grating::deserialize(toml::Value::Table(table)).err().map(|e| e.to_string());
    let words = message.as_deref().map(quoted_words).unwrap_or_default();
    words.into_iter().skip(1).map(str::to_owned).collect()
}

/// The words in backticks in the first line of a message of the deserialiser.
fn quoted_words(message: &str) -> Vec<&str> {
    message.lines().next().unwrap_or(message).split('`').skip(1).step_by(2).collect()
}

/// Finds the place that a message of the deserialiser is about. The words in backticks are the wrong word, then the known ones.
fn explain(table: &Table, message: &str) {
    let line = message.lines().next().unwrap_or(message);
    match quoted_words(message).as_slice() {
        [bad, known @ ..] if line.starts_with("unknown field") => {
            let at = holder(table, bad);
            at.only(
                &at.items()
                    .iter()
                    .map(|(key, _)| *key)
                    .filter(|key| key != bad)
                    .chain(known.iter().copied())
                    .collect::<Vec<_>>(),
            );
        }
        [bad, known @ ..] if line.starts_with("unknown variant") => match kind_item(table, bad) {
            Some(item) => item.fail("unknown value", suggest(bad, known)),
            None => table.fail(format!("{}: {line}", table.path), None),
        },
        [key] if line.starts_with("missing field") => {
            table.fail(
                format!("{}.{key} is missing", table.path),
                Some(format!("add {key} to the grating")),
            );
        }
        _ => table.fail(format!("{}: {line}", table.path), None),
    }
}

/// The table, or the part of a crossed grating, that has the key.
fn holder<'s, 't>(table: &Table<'s, 't>, key: &str) -> Table<'s, 't> {
    let part = |name| {
        table
            .get(name)
            .and_then(|item| item.table("a grating"))
            .filter(|part| part.get(key).is_some())
    };
    if table.get(key).is_some() { None } else { part("x").or_else(|| part("y")) }
        .unwrap_or_else(|| table.clone())
}

fn kind_item<'s, 't>(table: &Table<'s, 't>, kind: &str) -> Option<Item<'s, 't>> {
    let own = table.get("kind").filter(|item| item.as_str() == Some(kind));
    own.or_else(|| {
        ["x", "y"].iter().find_map(|key| kind_item(&table.get(key)?.table("a grating")?, kind))
    })
}
