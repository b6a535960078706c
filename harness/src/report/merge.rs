//! Merges the records of all folders. If there are several results of the same measurement, the last one counts, at the place
//! of the first.

use std::collections::BTreeMap;

use serde_json::Value;

use super::album::{Album, Picture};
use super::source::Folder;
use crate::results::{
    Bench, Compare, Control, Energy, Gap, Lit, Part, Record, Scaling, Testbench, Tune,
};

/// The results of a page.
#[derive(Debug, Default)]
pub(super) struct Results<'a> {
    /// Names of the folders.
    pub(super) folders: Vec<&'a str>,
    /// Comparisons, grouped by map.
    pub(super) units: Vec<Unit<'a>>,
    /// Deliberately wrong shaders.
    pub(super) controls: Vec<&'a Control>,
    /// What surfaces return of all light.
    pub(super) energies: Vec<&'a Energy>,
    /// Measurements that were not done.
    pub(super) gaps: Vec<&'a Gap>,
    /// Times.
    pub(super) benches: Vec<&'a Bench>,
    /// Times against a varied number.
    pub(super) scalings: Vec<&'a Scaling>,
    /// Periods, with the picture of the response.
    pub(super) periods: Vec<(&'a Testbench, Option<Picture>)>,
    /// Candidates of searches, with the name of the folder.
    pub(super) tunes: Vec<(&'a str, &'a Tune)>,
    /// The pictures.
    pub(super) album: Album,
    /// Pictures that cannot be shown, with the reason.
    pub(super) missing: Vec<String>,
    /// Number of records that later ones replaced.
    pub(super) replaced: usize,
}

/// A variant on a surface under a light: all comparisons of one map.
#[derive(Debug)]
pub(super) struct Unit<'a> {
    /// Anchor of its pictures in the page.
    pub(super) anchor: String,
    /// The surface's name.
    pub(super) surface: &'a str,
    /// The variant's name.
    pub(super) variant: &'a str,
    /// The light.
    pub(super) light: Lit,
    /// Width and height, in pixels.
    pub(super) size: usize,
    /// The variant's canonical configuration.
    pub(super) settings: &'a Value,
    /// The comparisons, with the pictures of reference, map and difference if they were drawn.
    pub(super) compared: Vec<(&'a Compare, Option<[Picture; 3]>)>,
}

impl<'a> Unit<'a> {
    /// Comparisons of one part of the error.
    pub(super) fn of(&self, part: Part) -> impl Iterator<Item = &'a Compare> {
        self.compared.iter().map(|(compare, _)| *compare).filter(move |c| c.part == part)
    }

    /// The comparison with the exact reference that represents the map: one with pictures, else the twin's, else any.
    pub(super) fn total(&self) -> Option<&(&'a Compare, Option<[Picture; 3]>)> {
        let totals = || self.compared.iter().filter(|(c, _)| c.part == Part::Total);
        let drawn = totals().find(|(_, strip)| strip.is_some());
        drawn.or_else(|| totals().find(|(c, _)| c.route == "twin")).or_else(|| totals().next())
    }

    /// The worst comparison of a part: of drivers by maximum difference, of approximations by colour.
    pub(super) fn worst(&self, part: Part) -> Option<&'a Compare> {
        let badness = |c: &Compare| match part {
            Part::Arithmetic | Part::Across => c.max_abs,
            _ => c.worst_p95(),
        };
        self.of(part).max_by(|a, b| badness(a).total_cmp(&badness(b)))
    }

    /// Whether everything is within its tolerance.
    pub(super) fn passes(&self) -> bool {
        self.compared.iter().all(|(c, _)| c.pass)
    }

    /// A setting by its key.
    pub(super) fn setting(&self, key: &str) -> Option<&'a str> {
        self.settings.get(key).and_then(Value::as_str)
    }
}

impl<'a> Results<'a> {
    /// Merges folders.
    pub(super) fn new(folders: &'a [Folder]) -> Results<'a> {
        let mut results = Results {
            folders: folders.iter().map(|f| f.name.as_str()).collect(),
            ..Results::default()
        };
        let mut places: BTreeMap<String, usize> = BTreeMap::new();
        let mut last: Vec<(&Folder, &Record)> = Vec::new();
        for (folder, record) in folders.iter().flat_map(|f| f.records.iter().map(move |r| (f, r))) {
            let key = key(&folder.name, record);
            match places.get(&key) {
                Some(at) => {
                    last[*at] = (folder, record);
                    results.replaced += 1;
                }
                None => {
                    places.insert(key, last.len());
                    last.push((folder, record));
                }
            }
        }
        for (folder, record) in last {
            results.take(folder, record);
        }
        results
    }

    fn take(&mut self, folder: &'a Folder, record: &'a Record) {
        match record {
            Record::Compare(compare) => {
                let strip = compare
                    .pictures
                    .as_ref()
                    .map(|places| [0, 1, 2].map(|i: usize| self.picture(folder, &places[i])));
                self.unit(compare).compared.push((compare, strip));
            }
            Record::Control(control) => self.controls.push(control),
            Record::Energy(energy) => self.energies.push(energy),
            Record::Gap(gap) => self.gaps.push(gap),
            Record::Bench(bench) => self.benches.push(bench),
            Record::Scaling(scaling) => self.scalings.push(scaling),
            Record::Tune(tune) => self.tunes.push((&folder.name, tune)),
            Record::Testbench(bench) => {
                let picture = bench.svg.as_ref().map(|place| self.picture(folder, place));
                self.periods.push((bench, picture));
            }
        }
    }

    fn picture(&mut self, folder: &Folder, place: &str) -> Picture {
        if let Some(Err(why)) = folder.pictures.get(place) {
            let reason = format!("{}/{place}: {why}", folder.name);
            if !self.missing.contains(&reason) {
                self.missing.push(reason);
            }
        }
        self.album.add(folder, place)
    }

    fn unit(&mut self, c: &'a Compare) -> &mut Unit<'a> {
        let is_it = |unit: &Unit<'_>| {
            (unit.surface, unit.variant, unit.size) == (&*c.surface, &*c.variant, c.size)
                && unit.light == c.light
        };
        let at = self.units.iter().position(is_it).unwrap_or_else(|| {
            self.units.push(Unit {
                anchor: format!("unit-{}", self.units.len() + 1),
                surface: &c.surface,
                variant: &c.variant,
                light: c.light.clone(),
                size: c.size,
                settings: &c.settings,
                compared: Vec::new(),
            });
            self.units.len() - 1
        });
        &mut self.units[at]
    }

    /// Every comparison.
    pub(super) fn compared(&self) -> impl Iterator<Item = &'a Compare> {
        self.units.iter().flat_map(|unit| unit.compared.iter().map(|(compare, _)| *compare))
    }

    /// The page's title.
    pub(super) fn title(&self) -> String {
        format!("Diffraction shaders: {}", self.folders.join(", "))
    }
}

/// Each value once, in the order in which they come.
pub(super) fn unique<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut seen = Vec::new();
    for value in values {
        if !seen.contains(&value) {
            seen.push(value);
        }
    }
    seen
}

/// What a record measures: all its choices, without its results.
fn key(folder: &str, record: &Record) -> String {
    match record {
        Record::Compare(c) => {
            // without the reference: the worst partner of a route may change from run to run
            format!("{:?}", (&c.surface, &c.variant, &c.route, c.part, &c.light, c.size))
        }
        Record::Control(c) => {
            format!("{:?}", ("control", &c.surface, &c.variant, &c.route, &c.control, c.light))
        }
        Record::Energy(e) => format!("{:?}", ("energy", &e.surface, e.optics.to_string())),
        Record::Gap(g) => format!("{:?}", ("gap", &g.route, &g.surface, &g.variant, &g.reason)),
        Record::Bench(b) => {
            let place = (&b.surface, &b.variant, &b.backend, &b.adapter);
            format!("{:?}", ("bench", place, b.light, b.size, b.height))
        }
        Record::Scaling(s) => {
            let place = (&s.surface, &s.variant, &s.backend, &s.adapter);
            format!("{:?}", ("scaling", place, &s.axis, s.value))
        }
        // candidates of one search must not be mixed with those of another
        Record::Tune(t) => {
            let asked = (t.budget_de, &t.fits, t.max_table_mib);
            let place = (&t.surface, &t.variant, &t.backend, &t.adapter);
            format!("{:?}", ("tune", folder, place, asked))
        }
        Record::Testbench(t) => {
            let light = (t.theta_i, t.phi_i);
            let windows = (t.window, t.windows.is_some());
            format!("{:?}", ("testbench", &t.surface, &t.variant, &t.route, light, windows))
        }
    }
}
