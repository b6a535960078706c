//! Results as JSON lines: one object per result, appended as soon as it is known, read back by reports.
//!
//! A file of them is never rewritten: what a run that was cut short had measured stays, and a last line without its end is
//! ignored when it is read.

mod tune;

use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::optics::colour_difference::Percentiles;
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use diffraction_shaders::variant::{Part, Tolerance};
pub use tune::{Bounds, LightError, Time, Tune, Verdict};

/// Name of the file under an output folder.
pub const FILE: &str = "records.jsonl";

/// Name of the file that a new run's predecessor is kept under.
pub const OLD: &str = "records.old.jsonl";

/// One result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Record {
    /// Colours of a variant by a route against a reference.
    Compare(Compare),
    /// The same of a deliberately wrong shader.
    Control(Control),
    /// A route or an adapter that could not be taken, or that ended early.
    Gap(Gap),
    /// Time of a variant on an adapter.
    Bench(Bench),
    /// Time against a number that was varied.
    Scaling(Scaling),
    /// Period of a surface as a variant sees it.
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
    /// What they are compared with: `exact`, `twin`, `twin:unpacked` or a route.
    pub reference: String,
    /// Which error this is.
    pub part: Part,
    /// Direction of the light, theta and phi in degrees.
    pub light: [f64; 2],
    /// Pixels along a side of the map.
    pub size: usize,
    /// Factor on luminance before colour differences.
    pub exposure: f64,
    /// Share of directions that are lit.
    pub lit: f64,
    /// Greatest difference of a tristimulus value over the reference's greatest.
    pub max_abs: f64,
    /// Root mean square of the same.
    pub rms: f64,
    /// CIEDE2000 over lit directions.
    pub de2000: Percentiles,
    /// The same of the map's pixels alone, at the exposure of its picture; none where next to
    /// nothing of the map is lit.
    pub map: Option<MapColours>,
    /// Mean FLIP over the map's lit pixels at that exposure; none where no pixel of the map is lit.
    pub flip: Option<f64>,
    /// What was allowed; none: nothing is promised.
    pub tolerance: Option<Tolerance>,
    /// Within the tolerance, or nothing to exceed.
    pub pass: bool,
    /// Reference, route and their amplified difference as pictures, by their places under the folder; drawn once for each
    /// variant and light, and where something disagrees.
    pub pictures: Option<[String; 3]>,
    /// The variant's canonical configuration.
    pub settings: Value,
}

impl Compare {
    /// The greater of the 95th percentiles of CIEDE2000 over all directions and over the map alone.
    pub fn worst_p95(&self) -> f64 {
        self.map.map_or(0.0, |map| map.de2000.p95).max(self.de2000.p95)
    }
}

/// Colour differences over the pixels of a map. Half of the drawn directions of a comparison lie in the brightest lobes, by
/// which they set its exposure; a map on its own is exposed for all that it shows, so that dim orders count.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapColours {
    /// Factor on luminance before colour differences.
    pub exposure: f64,
    /// Share of pixels of the disc that are lit.
    pub lit: f64,
    /// CIEDE2000 over lit pixels.
    pub de2000: Percentiles,
}

/// A deliberately wrong shader; caught when the comparison that it should fail fails.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// The surface's name.
    pub surface: String,
    /// The variant's name.
    pub variant: String,
    /// What computed the colours.
    pub route: String,
    /// What was made wrong.
    pub control: String,
    /// Direction of the light, theta and phi in degrees.
    pub light: [f64; 2],
    /// Greatest difference from the twin of the right variant.
    pub max_abs: f64,
    /// 95th percentile of CIEDE2000 against the same.
    pub de2000_p95: f64,
    /// Greatest difference of the right shader.
    pub right_max_abs: f64,
    /// What the right shader was allowed.
    pub tolerance: Tolerance,
    /// Whether the wrong shader exceeded the tolerance and the right one did not.
    pub caught: bool,
}

/// A route or an adapter that was not taken, or not to its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// The route, or `BACKEND:ADAPTER`.
    pub route: String,
    /// The surface, where it concerns one.
    pub surface: Option<String>,
    /// The variant, where it concerns one.
    pub variant: Option<String>,
    /// Why.
    pub reason: String,
    /// Whether something failed that began to run, as opposed to something that cannot be had here.
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
    /// Direction of the light, theta and phi in degrees.
    pub light: [f64; 2],
    /// Pixels of the map along x.
    pub size: usize,
    /// Pixels along y, where they are not as many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<usize>,
    /// Median time of a frame, ms.
    pub median_ms: f64,
    /// Median absolute deviation, ms.
    pub mad_ms: f64,
    /// 95 % confidence interval of the median, ms.
    pub interval_ms: [f64; 2],
    /// Time of the processor for a frame, all threads, ms.
    pub cpu_ms: f64,
    /// Creation of the pipeline, first draw included, ms.
    pub pipeline_ms: f64,
    /// Rounds that were measured.
    pub runs: usize,
    /// Rounds far from the others.
    pub outliers: usize,
    /// Frames of one round.
    pub frames_per_run: usize,
    /// `timestamps` or `wall`.
    pub clock: String,
    /// `median_ms` over the pixels of the disc, ns.
    pub ns_per_pixel: f64,
    /// Bytes of all tables that the variant reads.
    pub table_bytes: u64,
    /// The variant that the ratio is against.
    pub baseline: Option<String>,
    /// Median over interleaved rounds of the baseline's time over this one's.
    pub ratio: Option<f64>,
    /// 95 % confidence interval of the ratio.
    pub ratio_interval: Option<[f64; 2]>,
    /// The variant's canonical configuration.
    pub settings: Value,
}

/// Time against a number that was varied, everything else as it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    /// The surface's name.
    pub surface: String,
    /// The variant that was varied.
    pub variant: String,
    /// `vulkan`, `gl`, …
    pub backend: String,
    /// The adapter's name.
    pub adapter: String,
    /// What was varied: `pixels`, `terms`, `radius`, `wavelengths`, `patch`, `height`, `range`.
    pub axis: String,
    /// Its value.
    pub value: f64,
    /// Median time of a frame, ms.
    pub median_ms: f64,
    /// Median absolute deviation, ms.
    pub mad_ms: f64,
}

/// Period of a surface as a variant sees it.
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
    /// Direction of the light about the normal, degrees.
    pub phi_i: f64,
    /// The period around which was searched, nm.
    pub expected_nm: f64,
    /// Mean period over wavelengths, nm.
    pub period_nm: f64,
    /// Standard deviation over wavelengths, nm.
    pub sd_nm: f64,
    /// Wavelengths with a peak.
    pub points: usize,
    /// Wavelengths left out because the first order is evanescent.
    pub evanescent: usize,
    /// Wavelengths left out because there is no maximum near the first order.
    pub flat: usize,
    /// Mean and standard deviation of the same estimator on the grating's closed form, nm.
    pub closed_nm: Option<[f64; 2]>,
    /// The window of a scan, column and row of its first pixel and its width and height; none: the whole surface.
    pub window: Option<[usize; 4]>,
    /// In a summary: how many windows, and the standard deviation of the period between them, nm.
    pub windows: Option<(usize, f64)>,
    /// Mean response at the peaks, by which windows are weighted; their mean in a summary.
    pub weight: f64,
    /// The picture of the response, relative to the file of records.
    pub svg: Option<String>,
}

/// A file of records that is open for appending.
#[derive(Debug)]
pub struct Log {
    file: File,
    path: String,
}

impl Log {
    /// Begins a run of results of some kinds: earlier ones of these kinds leave the file, which is kept as a whole under
    /// [`OLD`] beside it; others stay. Gives the log and what stayed.
    pub fn begin(folder: &Path, mine: impl Fn(&Record) -> bool) -> Result<(Log, Vec<Record>)> {
        let path = folder.join(FILE);
        let fail = |e: std::io::Error| Error::new(path.display(), e);
        std::fs::create_dir_all(folder).map_err(fail)?;
        let mut records = if path.exists() { read(&path)? } else { Vec::new() };
        if records.iter().any(&mine) {
            std::fs::copy(&path, folder.join(OLD)).map_err(fail)?;
            records.retain(|record| !mine(record));
            let partial = folder.join(format!("{FILE}.tmp-{}", std::process::id()));
            let text: String = records.iter().map(line).collect();
            std::fs::write(&partial, text).map_err(fail)?;
            std::fs::rename(&partial, &path).map_err(fail)?;
        }
        Ok((Log::open(&path)?, records))
    }

    /// Opens or creates the file; a last line that was cut short is taken off.
    pub fn open(path: &Path) -> Result<Log> {
        let shown = path.display().to_string();
        let fail = |e: std::io::Error| Error::new(&shown, e);
        let options = OpenOptions::new().read(true).append(true).create(true).clone();
        let mut file = options.open(path).map_err(fail)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(fail)?;
        let whole = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        if whole < bytes.len() {
            file.set_len(whole as u64).map_err(fail)?;
            file.seek(SeekFrom::End(0)).map_err(fail)?;
        }
        Ok(Log { file, path: shown })
    }

    /// Appends one line and hands it to the system at once.
    pub fn append(&mut self, record: &Record) -> Result<()> {
        let line = line(record);
        self.file.write_all(line.as_bytes()).map_err(|e| Error::new(&self.path, e))
    }
}

/// A record as a line of JSON, with its end.
pub fn line(record: &Record) -> String {
    // numbers, strings and options only: nothing that JSON cannot hold
    serde_json::to_string(record).map(|text| text + "\n").unwrap_or_default()
}

/// Reads a file of records; an unfinished last line is ignored, any other fault is an error with its line.
pub fn read(path: &Path) -> Result<Vec<Record>> {
    let shown = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|e| Error::new(&shown, e))?;
    let whole = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
    let text = String::from_utf8_lossy(&bytes[..whole]);
    let parse = |(i, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|e| {
            Error::new(format!("{shown}:{}", i + 1), e)
                .remedy("remove the line, or measure again into an empty folder")
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
        Log::open(&path).and_then(|mut log| log.append(&gap("one"))).expect("writes");
        let cut = &line(&gap("two"))[..20];
        let mut file = OpenOptions::new().append(true).open(&path).expect("opens");
        file.write_all(cut.as_bytes()).expect("writes");
        assert_eq!(read(&path).expect("reads"), [gap("one")]);
        Log::open(&path).and_then(|mut log| log.append(&gap("three"))).expect("writes");
        assert_eq!(read(&path).expect("reads"), [gap("one"), gap("three")]);
    }

    #[test]
    fn a_new_run_replaces_its_own_kind_and_keeps_the_old_file() {
        let folder = tempfile::tempdir().expect("folder");
        let (mut log, none) = Log::begin(folder.path(), |_| true).expect("begins");
        assert_eq!(none, []);
        log.append(&gap("mine")).and_then(|()| log.append(&gap("other"))).expect("writes");
        let mine = |record: &Record| matches!(record, Record::Gap(gap) if gap.reason == "mine");
        let (_, left) = Log::begin(folder.path(), mine).expect("begins");
        assert_eq!(left, [gap("other")]);
        assert_eq!(read(&folder.path().join(FILE)).expect("reads"), left);
        let old = read(&folder.path().join(OLD)).expect("reads");
        assert_eq!(old, [gap("mine"), gap("other")]);
    }

    #[test]
    fn a_line_that_is_no_record_is_an_error_with_its_place() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join(FILE);
        std::fs::write(&path, line(&gap("one")) + "{\"kind\":\"none\"}\n").expect("writes");
        let error = read(&path).expect_err("unknown kind").to_string();
        assert!(error.contains("records.jsonl:2"), "{error}");
    }
}
