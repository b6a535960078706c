//! Output of results: the file of records, pictures, the terminal.

use std::fs;
use std::path::Path;

use diffraction_cli::console::Console;
use diffraction_cli::files::write_whole;
use diffraction_shaders::error::{Error, Result};
use indicatif::ProgressBar;

use crate::compare::{Sink, Unit};
use crate::results::{Log, Part, Record, line};

/// Writes results as they come.
pub(super) struct Recorder<'a> {
    /// All records, including those of earlier runs.
    pub(super) records: Vec<Record>,
    /// Progress.
    pub(super) bar: ProgressBar,
    out: &'a Path,
    log: Log,
    json: bool,
    console: &'a Console,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(
        out: &'a Path,
        log: Log,
        known: Vec<Record>,
        json: bool,
        console: &'a Console,
    ) -> Recorder<'a> {
        Recorder { records: known, bar: ProgressBar::hidden(), out, log, json, console }
    }
}

impl Sink for Recorder<'_> {
    fn record(&mut self, record: Record) -> Result<()> {
        self.log.append(&record)?;
        if self.json {
            let printed = self.console.data(&line(&record)?);
            printed.map_err(|e| Error::new("stdout", e))?;
        }
        if let Record::Gap(gap) = &record
            && gap.failed
        {
            let at = gap.variant.as_ref().map(|v| format!(" {v}")).unwrap_or_default();
            self.bar.suspend(|| self.console.note(&format!("{}{at}: {}", gap.route, gap.reason)));
        }
        self.records.push(record);
        Ok(())
    }

    fn picture(&mut self, place: &str, png: Vec<u8>) -> Result<()> {
        let path = self.out.join(place);
        let fail = |e: String| Error::new(path.display(), e);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|e| fail(e.to_string()))?;
        }
        write_whole(&path, &png).map_err(|e| fail(format!("{e:#}")))
    }

    fn begin(&mut self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    fn step(&mut self) {
        self.bar.inc(1);
    }

    fn has(&self, unit: &Unit<'_>, routes: &[String]) -> bool {
        let settings: serde_json::Value =
            serde_json::from_str(&unit.variant.canonical()).unwrap_or_default();
        let of = |route: &str, part: Part| {
            self.records.iter().any(|record| match record {
                Record::Compare(c) => {
                    c.route == route
                        && c.part == part
                        && c.surface == unit.surface
                        && c.variant == unit.variant.name
                        && c.light == unit.light.lit()
                        && c.size == unit.size
                        && c.settings == settings
                }
                _ => false,
            })
        };
        // this record is written last, so all others of the unit are there
        let last = if routes.len() > 1 { Part::Across } else { Part::Arithmetic };
        of("twin", Part::Total) && routes.iter().all(|route| of(route, last))
    }

    fn has_control(&self, route: &str, control: &str) -> bool {
        let is = |record: &Record| matches!(record, Record::Control(c) if c.route == route && c.control == control);
        self.records.iter().any(is)
    }
}
