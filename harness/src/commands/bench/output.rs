//! Output of results: lines of JSON as soon as they are known, tables at the end, named results in files.

use std::path::{Path, PathBuf};

use crate::bench::scaling::Swept;
use crate::process::watched::{History, Place, child};
use crate::results::{self, Bench, Gap, Log, Record};
use anyhow::{Context, Result, bail};
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};

use diffraction_cli::console::Console;
use diffraction_cli::files::write_whole;

use super::timed::{Point, TimedVariant};
use super::{Args, tables};

/// The results so far, and where they are written.
pub(super) struct Output<'a> {
    args: &'a Args,
    console: &'a Console,
    bar: ProgressBar,
    log: Option<Log>,
    rows: Vec<TimedVariant>,
    scalings: Vec<(Swept, Vec<Point>)>,
    before: Option<Vec<Bench>>,
    failed: bool,
    /// Adapters that are measured to the end.
    done: Vec<String>,
}

/// What a run needs that goes on after a driver crashed.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kept {
    Row(Box<TimedVariant>),
    Scaling(Swept, Vec<Point>),
    Done(String),
}

impl Kept {
    fn tell(&self) -> Result<()> {
        child::keep(serde_json::to_value(self)?);
        Ok(())
    }
}

impl<'a> Output<'a> {
    /// Opens the files to write and reads the results to compare with, before anything is measured.
    pub(super) fn open(args: &'a Args, console: &'a Console) -> Result<Output<'a>> {
        let log = match &args.out {
            Some(folder) => Some(Log::open(folder, &|text| console.note(text))?),
            None => None,
        };
        let before = match &args.compare_to {
            Some(name) => Some(read(&place(args, name), name)?),
            None => None,
        };
        let bar = ProgressBar::hidden();
        Ok(Output {
            args,
            console,
            bar,
            log,
            rows: vec![],
            scalings: vec![],
            before,
            failed: false,
            done: vec![],
        })
    }

    /// From here on, notes are printed without disturbing this bar.
    pub(super) fn beside(&mut self, bar: &ProgressBar) {
        self.bar = bar.clone();
    }

    pub(super) fn note(&self, text: &str) {
        self.bar.suspend(|| self.console.note(text));
    }

    /// Takes over what was measured before a driver crashed, and records the crashes.
    pub(super) fn go_on(&mut self, history: &History) -> Result<()> {
        for kept in &history.kept {
            match serde_json::from_value(kept.clone())? {
                Kept::Row(row) => self.rows.push(*row),
                Kept::Scaling(axis, points) => self.scalings.push((axis, points)),
                Kept::Done(route) => self.done.push(route),
            }
        }
        for crash in &history.crashes {
            let Place { route, surface, variant, .. } = crash.place.clone();
            let reason = crash.reason();
            let gap = Gap { route, surface, variant, reason, failed: true };
            match history.crashes.last() == Some(crash) {
                true => self.gap(gap)?,
                // an earlier run recorded it
                false => self.failed = true,
            }
        }
        Ok(())
    }

    /// Whether an adapter was measured to the end before a driver crashed.
    pub(super) fn is_done(&self, route: &str) -> bool {
        self.done.iter().any(|done| done == route)
    }

    /// An adapter is measured to the end.
    pub(super) fn done(&mut self, route: String) {
        // the name of a route is always valid JSON
        let _ = Kept::Done(route.clone()).tell();
        self.done.push(route);
    }

    pub(super) fn row(&mut self, row: TimedVariant) -> Result<()> {
        self.record(&Record::Bench(row.record.clone()))?;
        Kept::Row(Box::new(row.clone())).tell()?;
        self.rows.push(row);
        Ok(())
    }

    pub(super) fn scaling(&mut self, axis: Swept, points: Vec<Point>) -> Result<()> {
        for point in &points {
            self.record(&Record::Scaling(point.record.clone()))?;
        }
        Kept::Scaling(axis, points.clone()).tell()?;
        self.scalings.push((axis, points));
        Ok(())
    }

    pub(super) fn gap(&mut self, gap: Gap) -> Result<()> {
        let subject: Vec<&str> = [Some(&gap.route), gap.surface.as_ref(), gap.variant.as_ref()]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        self.note(&format!("not measured: {}: {}", subject.join(", "), gap.reason));
        self.failed |= gap.failed;
        self.record(&Record::Gap(gap))
    }

    /// Whether something began to run and failed.
    pub(super) fn failed(&self) -> bool {
        self.failed
    }

    /// Prints the tables. Saves the results if the run was complete.
    pub(super) fn finish(&self, complete: bool) -> Result<()> {
        if !self.args.json {
            let times = tables::times(&self.rows, self.before.as_deref());
            self.console.data(&(times + &tables::scalings(&self.scalings)))?;
        }
        let Some(name) = &self.args.save else { return Ok(()) };
        let path = place(self.args, name);
        if !complete || self.rows.is_empty() {
            self.note(&format!("{}: not written, since the run was interrupted", path.display()));
            return Ok(());
        }
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("{}: cannot be created", folder.display()))?;
        }
        let lines = self.rows.iter().map(|row| results::line(&Record::Bench(row.record.clone())));
        write_whole(&path, lines.collect::<Result<String, _>>()?.as_bytes())
    }

    fn record(&mut self, record: &Record) -> Result<()> {
        if let Some(log) = &mut self.log {
            log.append(record)?;
        }
        if self.args.json {
            let line = results::line(record)?;
            self.bar.suspend(|| self.console.data(&line))?;
        }
        Ok(())
    }
}

/// The file of the results saved under a name.
fn place(args: &Args, name: &str) -> PathBuf {
    let folder = args.out.as_deref().unwrap_or(Path::new("target/bench"));
    folder.join(format!("{name}.jsonl"))
}

fn read(path: &Path, name: &str) -> Result<Vec<Bench>> {
    if !path.exists() {
        bail!("--compare-to {name}: {} does not exist; make it with --save {name}", path.display());
    }
    let bench = |record: Record| match record {
        Record::Bench(bench) => Some(bench),
        _ => None,
    };
    Ok(results::read(path)?.into_iter().filter_map(bench).collect())
}
