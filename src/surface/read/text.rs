//! Text: matrices, profiles and points, with what their headers say.
//!
//! A matrix has one row of heights per line, top row first. Two columns whose first is evenly spaced are a profile of
//! distances and heights. Three columns that fill a grid are points. A header may state the number of pixels: then lines
//! mean nothing. What may be read in two ways is an error that names both.

mod blocks;
mod coordinates;
mod decode;
mod even;
mod header;
mod keys;
mod layout;
mod names;
mod numbers;
mod points;
mod profile;
mod surfer;
mod table;
mod zygo;

use crate::error::{Error, Result};
use crate::plan::FileSource;
use crate::surface::raster::Raster;

pub(super) use decode::is_text;

/// First words of text formats that are not read, with what they are.
const OTHERS: [(&str, &str); 6] = [
    ("Wyko ASCII", "Wyko's text format, whose rows are columns"),
    ("aBCR-", "a surface data file of ISO 25178-71"),
    ("aISO-", "a surface data file of ISO 25178-71"),
    ("ISO/TC 201", "an SPM file of ISO 28600"),
    ("<?xml", "XML"),
    ("PV 6", "an image of 3D measuring macroscopes"),
];

/// Reads a text.
pub(super) fn read(bytes: &[u8], source: &FileSource, subject: &str) -> Result<Raster> {
    let mut notes = Vec::new();
    let text = decode::text(bytes, subject, &mut notes)?;
    for (mark, what) in OTHERS {
        if text.starts_with(mark) {
            return Err(Error::new(subject, format!("is {what}, which a plan does not read"))
                .remedy(format!("convert it with `{}`", super::import(&source.path))));
        }
    }
    let known = zygo::read(&text, subject).or_else(|| surfer::read(&text, subject));
    let mut raster = match known {
        Some(raster) => raster?,
        None => {
            let blocks = blocks::split(&text, subject)?;
            let channel = source.channel.as_deref();
            let chosen = blocks::choose(blocks, channel, subject, &mut notes)?;
            table::read(chosen, channel, subject)?
        }
    };
    notes.append(&mut raster.notes);
    raster.notes = notes;
    Ok(raster)
}
