//! What the script says of a file, and how it is printed.

use std::fmt::Write;
use std::path::Path;

use serde::Deserialize;

/// The script's answer.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum Answer {
    Refused { error: String, remedy: Option<String> },
    Read(Facts),
}

/// What was read.
#[derive(Deserialize)]
pub(super) struct Facts {
    format: String,
    channel: String,
    /// Why this channel, where there was a choice.
    reason: Option<String>,
    /// `None`: the file states none, and lengths are the file's numbers.
    file_unit: Option<String>,
    others: Vec<Channel>,
    metadata: Vec<String>,
    columns: usize,
    rows: usize,
    /// Width and height, µm.
    size: [f64; 2],
    /// µm.
    peak_to_valley: f64,
    /// Taken off all heights, so that they fit 32-bit floats.
    offset: f64,
    voids: usize,
}

#[derive(Deserialize)]
struct Channel {
    name: String,
    heights: bool,
}

impl Facts {
    /// Lines for users: what was read and what was dropped.
    pub(super) fn text(&self, file: &Path, output: &Path) -> String {
        let Facts { format, channel, columns, rows, voids, file_unit, .. } = self;
        let mut text = format!("{} -> {}\n", file.display(), output.display());
        let reason = self.reason.as_ref().map_or(String::new(), |reason| format!(" ({reason})"));
        let _ = writeln!(text, "  {format}, channel '{channel}'{reason}");
        let [width, height] = self.size;
        let (um, unit) = match file_unit {
            Some(unit) => (" µm", format!("lengths were in {unit}")),
            None => ("", "the file states no unit".to_owned()),
        };
        let _ = writeln!(
            text,
            "  {columns} × {rows} pixels, {} × {}{um}, {} × {}{um} each; peak to valley {}{um}; {unit}",
            short(width),
            short(height),
            short(width / *columns as f64),
            short(height / *rows as f64),
            short(self.peak_to_valley)
        );
        if *voids > 0 {
            let share = *voids as f64 / (columns * rows) as f64 * 100.0;
            let plural = if *voids == 1 { "" } else { "s" };
            let _ = writeln!(text, "  {voids} void{plural} ({share:.2} %), written as NaN");
        }
        let mut dropped: Vec<String> = self.others.iter().map(Channel::text).collect();
        if !self.metadata.is_empty() {
            dropped.push(format!("metadata {}", self.metadata.join(", ").replace('_', " ")));
        }
        if self.offset != 0.0 {
            dropped.push(format!("{}{um} of all heights, for 32-bit floats", short(self.offset)));
        }
        if !dropped.is_empty() {
            let _ = writeln!(text, "  dropped: {}", dropped.join("; "));
        }
        text
    }
}

impl Channel {
    fn text(&self) -> String {
        let kind = if self.heights { "heights" } else { "no heights" };
        format!("channel '{}' ({kind})", self.name)
    }
}

/// A number with at most six significant digits.
fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.5e}").parse().unwrap_or(number);
    rounded.to_string()
}

/// The block of a plan for a file. Keys that the user has to fill in are remarks.
pub(super) fn block(facts: &Facts, output: &Path) -> String {
    let missing = match facts.file_unit {
        Some(_) => "",
        None => {
            "# size_um = …      # the file states no unit: its width\n# z_unit_um = …    # and the unit of its heights\n"
        }
    };
    let (name, file) = keys(output);
    format!("[[surface]]\nname = \"{name}\"\nfile = {file}\nlevel = \"plane\"\n{missing}")
}

/// Name and file as a plan writes them.
fn keys(output: &Path) -> (String, String) {
    // a JSON string is a string of TOML, too
    let file = serde_json::Value::from(output.to_string_lossy()).to_string();
    let stem = output.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
    let name: String = stem.chars().map(plain).collect();
    let words: Vec<&str> = name.split('-').filter(|word| !word.is_empty()).collect();
    (if words.is_empty() { "scan".to_owned() } else { words.join("-") }, file)
}

fn plain(c: char) -> char {
    if c.is_ascii_alphanumeric() { c } else { '-' }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_names_are_those_of_plans() {
        assert_eq!(short(64_063.999_999_999_99), "64064");
        assert_eq!(short(0.016_655_562_954), "0.0166556");
        let (name, file) = keys(Path::new("a \"b\"/Scan 1_µ.gsf"));
        assert_eq!(name, "scan-1");
        let table: toml::Table = format!("file = {file}").parse().unwrap();
        assert_eq!(table["file"].as_str(), Some("a \"b\"/Scan 1_µ.gsf"));
        assert_eq!(keys(Path::new("µ.gsf")).0, "scan");
    }
}
