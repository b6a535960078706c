//! From samples to records.

use diffraction_shaders::plan::Variant;
use serde_json::Value;

use super::rounds::{Samples, Timing, ratios};
use super::stats::{interval, median, summary};
use crate::results::{Bench, Scaling};

/// Where and under which light something was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The surface's name.
    pub surface: String,
    /// `vulkan`, `gl`, …
    pub backend: String,
    /// The adapter's name.
    pub adapter: String,
    /// Direction towards the light: theta and phi in degrees.
    pub light: [f64; 2],
}

/// A variant with its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// The variant's name.
    pub variant: String,
    /// Its canonical configuration; null for a yardstick.
    pub settings: Value,
    /// Pixels of the frame along x and y.
    pub frame: [usize; 2],
    /// Time to create the pipeline and upload its tables, with the first draw of a few pixels, ms.
    pub pipeline_ms: f64,
    /// Size of all tables in bytes.
    pub table_bytes: u64,
    /// Texels that a lit pixel reads on average; counted, not measured.
    pub fetches: f64,
    /// Number of look-ups of the surroundings for a lit pixel on average; counted, not measured. `None` without surroundings.
    pub lookups: Option<f64>,
    /// The times.
    pub samples: Samples,
}

/// The canonical configuration of a variant as JSON.
pub fn settings(variant: &Variant) -> Value {
    serde_json::from_str(&variant.canonical()).unwrap_or_default()
}

/// A record; `None` if no round was measured. The ratio is against `baseline`, which may be the variant itself.
pub fn bench(
    place: &Place,
    timing: Timing,
    timed: &Timed,
    baseline: Option<&Timed>,
) -> Option<Bench> {
    let time = summary(&timed.samples.time_ms)?;
    let against = baseline.map(|baseline| ratios(&baseline.samples, &timed.samples));
    let ratio = against.as_deref().and_then(median);
    let ns_per_pixel = time.median * 1e6 / disc_pixels(timed.frame) as f64;
    Some(Bench {
        surface: place.surface.clone(),
        variant: timed.variant.clone(),
        backend: place.backend.clone(),
        adapter: place.adapter.clone(),
        light: place.light,
        size: timed.frame[0],
        height: (timed.frame[1] != timed.frame[0]).then_some(timed.frame[1]),
        median_ms: time.median,
        mad_ms: time.mad,
        interval_ms: time.interval,
        cpu_ms: median(&timed.samples.cpu_ms)?,
        pipeline_ms: timed.pipeline_ms,
        runs: timed.samples.time_ms.len(),
        outliers: time.outliers,
        frames_per_run: timed.samples.frames,
        clock: timing.name().to_owned(),
        ns_per_pixel,
        lookups: timed.lookups,
        ns_per_lookup: timed.lookups.map(|lookups| ns_per_pixel / lookups),
        table_bytes: timed.table_bytes,
        baseline: ratio.and(baseline).map(|baseline| baseline.variant.clone()),
        ratio,
        ratio_interval: against.as_deref().and_then(interval),
        settings: timed.settings.clone(),
    })
}

/// A record of a varied number; `None` if no round was measured.
pub fn scaling(place: &Place, axis: &str, value: f64, timed: &Timed) -> Option<Scaling> {
    let time = summary(&timed.samples.time_ms)?;
    Some(Scaling {
        surface: place.surface.clone(),
        variant: timed.variant.clone(),
        backend: place.backend.clone(),
        adapter: place.adapter.clone(),
        axis: axis.to_owned(),
        value,
        median_ms: time.median,
        mad_ms: time.mad,
    })
}

/// Number of pixels of a map inside the disc, about 0.785 of all. Only these have something to compute. In a frame that is
/// not square the disc is an ellipse.
pub fn disc_pixels([width, height]: [usize; 2]) -> usize {
    let place = |index: usize, side: usize| ((2 * index + 1) as f64 / side as f64 - 1.0).powi(2);
    let inside = |row: usize| {
        let y = place(row, height);
        (0..width).filter(|column| place(*column, width) + y < 1.0).count()
    };
    (0..height).map(inside).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timed(variant: &str, time_ms: &[f64]) -> Timed {
        let samples = Samples {
            frames: 1,
            rounds: (0..time_ms.len()).collect(),
            time_ms: time_ms.to_vec(),
            cpu_ms: time_ms.to_vec(),
            disagreement: None,
        };
        Timed {
            variant: variant.into(),
            settings: Value::Null,
            frame: [2, 2],
            pipeline_ms: 1.0,
            table_bytes: 8,
            fetches: 3.0,
            lookups: Some(50.0),
            samples,
        }
    }

    #[test]
    fn ratios_are_medians_of_rounds_and_not_of_times() {
        let place = Place {
            surface: "s".into(),
            backend: "gl".into(),
            adapter: "a".into(),
            light: [20.0, 0.0],
        };
        // the machine is three times slower from the third round on, and one round was hit in the middle
        let slow = timed("slow", &[10.0, 10.0, 30.0, 30.0, 30.0, 90.0, 30.0]);
        let fast = timed("fast", &[5.0, 5.0, 15.0, 15.0, 15.0, 15.0, 15.0]);
        let record = bench(&place, Timing::Wall, &fast, Some(&slow)).expect("measured");
        assert_eq!((record.ratio, record.median_ms, record.mad_ms), (Some(2.0), 15.0, 0.0));
        assert_eq!(record.ratio_interval, Some([2.0, 6.0]));
        assert_eq!(record.baseline.as_deref(), Some("slow"));
        // all four pixels of a 2 × 2 map are inside
        assert_eq!((record.ns_per_pixel, record.runs), (15.0e6 / 4.0, 7));
        assert_eq!((record.lookups, record.ns_per_lookup), (Some(50.0), Some(15.0e6 / 200.0)));
        let alone = bench(&place, Timing::Stamps, &fast, None).expect("measured");
        assert_eq!((alone.ratio, alone.baseline, alone.clock.as_str()), (None, None, "timestamps"));
        assert_eq!(bench(&place, Timing::Wall, &timed("none", &[]), Some(&slow)), None);
        let point = scaling(&place, "terms", 4.0, &fast).expect("measured");
        assert_eq!((point.value, point.median_ms), (4.0, 15.0));
    }
}
