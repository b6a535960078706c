//! Results as JSON lines: one object per result, appended as soon as it is known, read again by reports.
//!
//! Lines are only appended, so an interrupted run keeps its results. An incomplete last line is ignored when the file is read.

mod tune;

use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use diffraction_shaders::disk::{Access, FolderLock, owner, write_whole};
use diffraction_shaders::encode;
use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::input::read_file;
use diffraction_shaders::optics::colour_difference::Percentiles;
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use diffraction_shaders::variant::{Part, Tolerance};
pub use tune::{Bounds, LightError, Time, Tune, Verdict};

/// Name of the file in an output folder.
pub const FILE: &str = "records.jsonl";

/// Name under which a new run keeps the previous file.
pub const OLD: &str = "records.old.jsonl";

/// One result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Record {
    /// Colours of a variant by a route against a reference.
    Compare(Compare),
    /// Colours of a deliberately wrong shader.
    Control(Control),
    /// What a surface returns of all light.
    Energy(Energy),
    /// Something that was not measured, or not to the end: a route, an adapter, a variant.
    Gap(Gap),
    /// Time of a variant on an adapter.
    Bench(Bench),
    /// Time against a number that was varied.
    Scaling(Scaling),
    /// Period of a surface as a variant shows it.
    Testbench(Testbench),
    /// A candidate of a search for the cheapest variant.
    Tune(Tune),
}

/// Colours of a variant by a route against a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compare {
    /// The surface's name.
    pub surface: String,
    /// The variant's name.
    pub variant: String,
    /// What computed the colours.
    pub route: String,
    /// The reference: `exact`, `twin`, `twin:unpacked` or a route.
    pub reference: String,
    /// The part of the error.
    pub part: Part,
    /// The light.
    pub light: Lit,
    /// Width and height of the map, in pixels.
    pub size: usize,
    /// Factor on luminance before colour differences are computed.
    pub exposure: f64,
    /// Share of directions that are lit, 0 to 1.
    pub lit: f64,
    /// Maximum difference of a tristimulus value, relative to the reference's maximum.
    pub max_abs: f64,
    /// Root mean square difference of tristimulus values, relative to the reference's maximum.
    pub rms: f64,
    /// CIEDE2000 over lit directions.
    pub de2000: Percentiles,
    /// Colour differences over the map's pixels alone, at the exposure of its picture; `None` if almost nothing of the map is lit.
    pub map: Option<MapColours>,
    /// Mean FLIP over the map's lit pixels, at that exposure; `None` if no pixel is lit.
    pub flip: Option<f64>,
    /// The tolerance; `None` if the variant has no tolerance here.
    pub tolerance: Option<Tolerance>,
    /// Whether it is within the tolerance. True without a tolerance.
    pub pass: bool,
    /// Pictures of reference, route and amplified difference, by their paths under the folder. They are drawn once for each variant
    /// and light, and for comparisons that disagree.
    pub pictures: Option<[String; 3]>,
    /// The variant's canonical configuration.
    pub settings: Value,
}

/// The light of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Lit {
    /// A single direction: theta and phi in degrees.
    Direction([f64; 2]),
    /// The lights of a file, by its name and the beginning of its hash.
    Lights(String),
}

impl Compare {
    /// The larger of two 95th percentiles of CIEDE2000: over all directions, and over the map alone.
    pub fn worst_p95(&self) -> f64 {
        self.map.map_or(0.0, |map| map.de2000.p95).max(self.de2000.p95)
    }
}

/// Colour differences over the pixels of a map. Half of the random directions of a comparison are in the brightest lobes, so
/// these set the exposure. The map alone has its own exposure, so that dim orders count.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapColours {
    /// Factor on luminance before colour differences are computed.
    pub exposure: f64,
    /// Share of the disc's pixels that are lit, 0 to 1.
    pub lit: f64,
    /// CIEDE2000 over lit pixels.
    pub de2000: Percentiles,
}

/// What a surface returns of all light, by the exact sum over its orders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// The surface's name.
    pub surface: String,
    /// The optics.
    pub optics: Value,
    /// Radiance under a sky of radiance 1, X, Y, Z relative to a white, towards viewers at 0, 30, 60 and 75 degrees.
    pub white_sky: [[f64; 3]; 4],
}

/// A deliberately wrong shader. It is caught if its comparison fails.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// The surface's name.
    pub surface: String,
    /// The variant's name.
    pub variant: String,
    /// What computed the colours.
    pub route: String,
    /// Name of the fault.
    pub control: String,
    /// Direction towards the light: theta and phi in degrees.
    pub light: [f64; 2],
    /// Maximum difference from the twin of the right variant.
    pub max_abs: f64,
    /// 95th percentile of CIEDE2000 against the twin of the right variant.
    pub de2000_p95: f64,
    /// Maximum difference of the right shader.
    pub right_max_abs: f64,
    /// The tolerance of the right shader.
    pub tolerance: Tolerance,
    /// Whether the wrong shader exceeded the tolerance and the right one did not.
    pub caught: bool,
}

/// Something that was not measured, or not to the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// The route, or `BACKEND:ADAPTER`.
    pub route: String,
    /// The surface, if it concerns one.
    pub surface: Option<String>,
    /// The variant, if it concerns one.
    pub variant: Option<String>,
    /// The reason.
    pub reason: String,
    /// Whether something began to run and failed, unlike something that is not available here.
    pub failed: bool,
}

/// Time of a variant on an adapter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bench {
    /// The surface's name.
    pub surface: String,
    /// The variant's name.
    pub variant: String,
    /// `vulkan`, `gl`, …
    pub backend: String,
    /// The adapter's name.
    pub adapter: String,
    /// Direction towards the light: theta and phi in degrees.
    pub light: [f64; 2],
    /// Width of the map, in pixels.
    pub size: usize,
    /// Height of the map, in pixels, if it differs from the width.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<usize>,
    /// Median time of a frame, ms.
    pub median_ms: f64,
    /// Median absolute deviation, ms.
    pub mad_ms: f64,
    /// 95 % confidence interval of the median, ms.
    pub interval_ms: [f64; 2],
    /// Processor time of a frame, all threads, ms.
    pub cpu_ms: f64,
    /// Time to create the pipeline, with the first draw, ms.
    pub pipeline_ms: f64,
    /// Number of measured rounds.
    pub runs: usize,
    /// Number of rounds far from the others.
    pub outliers: usize,
    /// Number of frames in a round.
    pub frames_per_run: usize,
    /// `timestamps` or `wall`.
    pub clock: String,
    /// `median_ms` divided by the pixels of the disc, in ns.
    pub ns_per_pixel: f64,
    /// Number of look-ups of the surroundings for a lit pixel on average, counted; absent without surroundings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lookups: Option<f64>,
    /// `ns_per_pixel` divided by `lookups`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ns_per_lookup: Option<f64>,
    /// Size of all tables that the variant reads, in bytes.
    pub table_bytes: u64,
    /// The variant that the ratio is to.
    pub baseline: Option<String>,
    /// Median over interleaved rounds of the baseline's time divided by this variant's.
    pub ratio: Option<f64>,
    /// 95 % confidence interval of the ratio.
    pub ratio_interval: Option<[f64; 2]>,
    /// The variant's canonical configuration.
    pub settings: Value,
}

/// Time against a varied number. Everything else stays the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    /// The surface's name.
    pub surface: String,
    /// The varied variant.
    pub variant: String,
    /// `vulkan`, `gl`, …
    pub backend: String,
    /// The adapter's name.
    pub adapter: String,
    /// The varied number: `pixels`, `terms`, `radius`, `wavelengths`, `patch`, `height`, `range`.
    pub axis: String,
    /// Its value.
    pub value: f64,
    /// Median time of a frame, ms.
    pub median_ms: f64,
    /// Median absolute deviation, ms.
    pub mad_ms: f64,
}

/// Period of a surface as a variant shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Testbench {
    /// The surface's name.
    pub surface: String,
    /// The variant's name, or `exact`.
    pub variant: String,
    /// What computed the responses.
    pub route: String,
    /// Angle of incidence, degrees.
    pub theta_i: f64,
    /// Angle of the light about the normal, degrees.
    pub phi_i: f64,
    /// The expected period, around which is searched, nm.
    pub expected_nm: f64,
    /// Mean period over wavelengths, nm.
    pub period_nm: f64,
    /// Standard deviation over wavelengths, nm.
    pub sd_nm: f64,
    /// Number of wavelengths with a peak.
    pub points: usize,
    /// Number of wavelengths left out because the first order is evanescent.
    pub evanescent: usize,
    /// Number of wavelengths left out because there is no maximum near the first order.
    pub flat: usize,
    /// Mean and standard deviation by the same estimator on the grating's closed form, nm.
    pub closed_nm: Option<[f64; 2]>,
    /// The window of a scan: column and row of its first pixel, width and height. `None`: the whole surface.
    pub window: Option<[usize; 4]>,
    /// In a summary: the number of windows, and the standard deviation of the period between them, nm.
    pub windows: Option<(usize, f64)>,
    /// Mean response at the peaks, the weight of a window. In a summary: the mean weight.
    pub weight: f64,
    /// The picture of the response, relative to the file of records.
    pub svg: Option<String>,
}

/// Maximum size of a file of records: a million results.
const MAX_BYTES: u64 = 1 << 30;

/// A file of records, open for appending. No other run writes to its folder meanwhile.
#[derive(Debug)]
pub struct Log {
    file: File,
    path: String,
    _lock: FolderLock,
}

impl Log {
    /// Begins a run with results of some kinds, selected by `mine`. Earlier results of these kinds are removed from the file; the
    /// whole old file is kept as [`OLD`] beside it. Returns the log and the remaining results.
    ///
    /// While another run writes to the folder, calls `waiting` once with a line to show, and waits.
    pub fn begin(
        folder: &Path,
        waiting: &dyn Fn(&str),
        mine: impl Fn(&Record) -> bool,
    ) -> Result<(Log, Vec<Record>)> {
        Log::without(folder, waiting, mine, true)
    }

    /// Goes on with a run that was cut short, without the results that it has to measure again. Keeps no copy of the file. Waits
    /// like [`Log::begin`].
    pub fn go_on(
        folder: &Path,
        waiting: &dyn Fn(&str),
        again: impl Fn(&Record) -> bool,
    ) -> Result<(Log, Vec<Record>)> {
        Log::without(folder, waiting, again, false)
    }

    fn without(
        folder: &Path,
        waiting: &dyn Fn(&str),
        mine: impl Fn(&Record) -> bool,
        copy: bool,
    ) -> Result<(Log, Vec<Record>)> {
        let lock = FolderLock::take(folder, Access::Write, waiting)?;
        let path = folder.join(FILE);
        let mut records = match std::fs::symlink_metadata(&path) {
            Ok(_) => read(&path)?,
            Err(_) => Vec::new(),
        };
        if records.iter().any(&mine) {
            if copy {
                let old = read_file(&path, MAX_BYTES).map_err(|e| Error::new(path.display(), e))?;
                write_whole(&folder.join(OLD), &old)?;
            }
            records.retain(|record| !mine(record));
            let text: String = records.iter().map(line).collect::<Result<_>>()?;
            write_whole(&path, text.as_bytes())?;
        }
        Ok((Log::locked(&path, lock)?, records))
    }

    /// Opens or creates the file of a folder. An incomplete last line is removed. Waits like [`Log::begin`].
    pub fn open(folder: &Path, waiting: &dyn Fn(&str)) -> Result<Log> {
        let lock = FolderLock::take(folder, Access::Write, waiting)?;
        Log::locked(&folder.join(FILE), lock)
    }

    fn locked(path: &Path, lock: FolderLock) -> Result<Log> {
        let shown = path.display().to_string();
        let fail = |e: std::io::Error| {
            let whose = owner(path).map(|owner| format!("; it belongs to user {owner}"));
            let remedy = format!("check its permissions{}", whose.unwrap_or_default());
            Error::new(&shown, "cannot be written").source(e).remedy(remedy)
        };
        // a pipe without a reader would never open
        if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            let error = Error::new(&shown, "is not a regular file");
            return Err(error.remedy("name another folder with --out"));
        }
        let bytes = match path.exists() {
            true => read_file(path, MAX_BYTES).map_err(fail)?,
            false => Vec::new(),
        };
        let options = OpenOptions::new().read(true).append(true).create(true).clone();
        let mut file = options.open(path).map_err(fail)?;
        let whole = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        if whole < bytes.len() {
            file.set_len(whole as u64).map_err(fail)?;
            file.seek(SeekFrom::End(0)).map_err(fail)?;
        }
        Ok(Log { file, path: shown, _lock: lock })
    }

    /// Appends one line and passes it to the system at once.
    pub fn append(&mut self, record: &Record) -> Result<()> {
        let line = line(record)?;
        self.file.write_all(line.as_bytes()).map_err(|e| Error::new(&self.path, e))
    }
}

/// A record as a line of JSON, with a line break. It is an error, with the key, if a number is not finite.
pub fn line(record: &Record) -> Result<String> {
    encode::json_line("record", record).map(|text| text + "\n")
}

/// Reads a file of records. An incomplete last line is ignored; any other fault is an error with its line number.
pub fn read(path: &Path) -> Result<Vec<Record>> {
    let shown = path.display().to_string();
    let bytes = read_file(path, MAX_BYTES).map_err(|e| Error::new(&shown, e))?;
    let whole = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
    let text = String::from_utf8_lossy(&bytes[..whole]);
    let parse = |(i, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|e| {
            Error::new(format!("{shown}:{}", i + 1), format!("is not a valid record: {e}"))
                .remedy("remove the line, or measure again with an empty folder")
        })
    };
    text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).map(parse).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(reason: &str) -> Record {
        Record::Gap(Gap {
            route: "webgpu".into(),
            surface: None,
            variant: None,
            reason: reason.into(),
            failed: false,
        })
    }

    #[test]
    fn a_line_cut_short_is_dropped_and_the_rest_stays() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join(FILE);
        Log::open(folder.path(), &|_| ())
            .and_then(|mut log| log.append(&gap("one")))
            .expect("writes");
        let cut = &line(&gap("two")).expect("finite")[..20];
        let mut file = OpenOptions::new().append(true).open(&path).expect("opens");
        file.write_all(cut.as_bytes()).expect("writes");
        assert_eq!(read(&path).expect("reads"), [gap("one")]);
        Log::open(folder.path(), &|_| ())
            .and_then(|mut log| log.append(&gap("three")))
            .expect("writes");
        assert_eq!(read(&path).expect("reads"), [gap("one"), gap("three")]);
    }

    #[test]
    fn a_new_run_replaces_its_own_kind_and_keeps_the_old_file() {
        let folder = tempfile::tempdir().expect("folder");
        let (mut log, none) = Log::begin(folder.path(), &|_| (), |_| true).expect("begins");
        assert_eq!(none, []);
        log.append(&gap("mine")).and_then(|()| log.append(&gap("other"))).expect("writes");
        drop(log);
        let mine = |record: &Record| matches!(record, Record::Gap(gap) if gap.reason == "mine");
        let (_, left) = Log::begin(folder.path(), &|_| (), mine).expect("begins");
        assert_eq!(left, [gap("other")]);
        assert_eq!(read(&folder.path().join(FILE)).expect("reads"), left);
        let old = read(&folder.path().join(OLD)).expect("reads");
        assert_eq!(old, [gap("mine"), gap("other")]);
    }

    #[test]
    fn a_line_that_is_no_record_is_an_error_with_its_place() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join(FILE);
        std::fs::write(&path, line(&gap("one")).expect("finite") + "{\"kind\":\"none\"}\n")
            .expect("writes");
        let error = read(&path).expect_err("unknown kind").to_string();
        assert!(error.contains("records.jsonl:2"), "{error}");
    }
}
