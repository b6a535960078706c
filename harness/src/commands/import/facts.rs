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
    file_unit: String,
    others: Vec<Channel>,
    metadata: Vec<String>,
    columns: usize,
    rows: usize,
    size_um: [f64; 2],
    peak_to_valley_um: f64,
    /// Taken off all heights, so that they fit 32-bit floats.
    offset_um: f64,
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
        let [width, height] = self.size_um;
        let (across, down) = (width / *columns as f64 * 1e3, height / *rows as f64 * 1e3);
        let _ = writeln!(
            text,
            "  {columns} × {rows} pixels, {} × {} µm, {} × {} nm each; peak to valley {} µm; heights were in {file_unit}",
            short(width),
            short(height),
            short(across),
            short(down),
            short(self.peak_to_valley_um)
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
        if self.offset_um != 0.0 {
            dropped.push(format!("{} µm of all heights, for 32-bit floats", short(self.offset_um)));
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

/// The block of a plan for a file.
pub(super) fn block(output: &Path, stem: &str) -> String {
    // a JSON string is a string of TOML, too
    let file = serde_json::Value::from(output.to_string_lossy()).to_string();
    let name: String = stem.to_lowercase().chars().map(plain).collect();
    let words: Vec<&str> = name.split('-').filter(|word| !word.is_empty()).collect();
    let name = if words.is_empty() { "scan".to_owned() } else { words.join("-") };
    format!("[[surface]]\nname = \"{name}\"\nfile = {file}\nlevel = \"plane\"\n")
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
        let text = block(Path::new("a \"b\"/Scan 1_µ.gsf"), "Scan 1_µ");
        assert!(text.contains("name = \"scan-1\"\n"), "{text}");
        let table: toml::Table = text.parse().unwrap();
        assert_eq!(table["surface"][0]["file"].as_str(), Some("a \"b\"/Scan 1_µ.gsf"));
        assert!(block(Path::new("x"), "µ").contains("\"scan\""));
    }
}
