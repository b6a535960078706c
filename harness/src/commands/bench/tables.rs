//! Results as tables for people.

use crate::bench::scaling::Swept;
use crate::bench::stats::exponent;
use crate::commands::digits::digits;
use crate::results::Bench;

use diffraction_cli::list::table;

use super::timed::{Point, TimedVariant};

/// On software drivers, an empty frame is about this many times as fast as the shader as printed.
const EMPTY_RATIO: f64 = 1500.0;

/// A table for each adapter and surface, fastest first. `before` holds saved results to compare with.
pub(super) fn times(rows: &[TimedVariant], before: Option<&[Bench]>) -> String {
    let mut text = String::new();
    let mut rest: Vec<&TimedVariant> = rows.iter().collect();
    while let Some(first) = rest.first().map(|row| row.record.clone()) {
        let (mut here, others): (Vec<&TimedVariant>, Vec<&TimedVariant>) =
            rest.into_iter().partition(|row| same_place(&row.record, &first));
        rest = others;
        here.sort_by(|a, b| a.record.median_ms.total_cmp(&b.record.median_ms));
        let baseline = first.baseline.as_deref().map(|name| format!(", ratio = {name} / this"));
        text += &format!(
            "{} on {} {}, {} × {} pixels, light {},{}{}\n",
            first.surface,
            first.backend,
            first.adapter,
            first.size,
            first.height.unwrap_or(first.size),
            first.light[0],
            first.light[1],
            baseline.unwrap_or_default()
        );
        let mut head = vec![
            "variant",
            "ms",
            "± MAD",
            "ratio",
            "95 %",
            "CPU ms",
            "CPU ratio",
            "ns/pixel",
            "look-ups",
            "ns/look-up",
            "fetches",
            "KiB",
            "pipeline ms",
            "rounds·frames",
            "outliers",
            "clock",
        ];
        head.extend(before.map(|_| "since"));
        let cpu = here.iter().find(|row| first.baseline.as_ref() == Some(&row.record.variant));
        let cpu_ms = cpu.map(|row| row.record.cpu_ms);
        let cells = here.iter().map(|row| cells(row, cpu_ms, before));
        text += &table::text(&head, cells.collect());
        let near_empty =
            |row: &&TimedVariant| row.record.ratio.is_some_and(|ratio| ratio > EMPTY_RATIO);
        if here.iter().any(near_empty) {
            text +=
                "a ratio above 1500 is about as fast as an empty frame; --empty measures that\n";
        }
        text.push('\n');
    }
    if !text.is_empty() {
        text += "CPU: processor time of all threads of this process; for software drivers it does not depend on the machine's load\n";
        text += "ns/pixel: per pixel of the disc; look-ups of the surroundings and fetches from tables: per lit pixel, counted, not measured\n\n";
    }
    text
}

/// The cells of a row. `cpu_ms` is the processor time of the baseline.
fn cells(row: &TimedVariant, cpu_ms: Option<f64>, before: Option<&[Bench]>) -> Vec<String> {
    let bench = &row.record;
    let none = || "-".to_owned();
    let mut cells = vec![
        bench.variant.clone(),
        digits(bench.median_ms),
        digits(bench.mad_ms),
        bench.ratio.map_or_else(none, digits),
        bench
            .ratio_interval
            .map_or_else(none, |[low, high]| format!("{} … {}", digits(low), digits(high))),
        digits(bench.cpu_ms),
        cpu_ms.map_or_else(none, |baseline| digits(baseline / bench.cpu_ms.max(1e-6))),
        digits(bench.ns_per_pixel),
        bench.lookups.map_or_else(none, |lookups| format!("{lookups:.0}")),
        bench.ns_per_lookup.map_or_else(none, digits),
        format!("{:.0}", row.fetches),
        format!("{:.1}", bench.table_bytes as f64 / 1024.0),
        digits(bench.pipeline_ms),
        format!("{}·{}", bench.runs, bench.frames_per_run),
        bench.outliers.to_string(),
        bench.clock.clone(),
    ];
    cells.extend(before.map(|before| since(bench, before)));
    cells
}

/// How the time changed. If both runs have a ratio to the same baseline, the ratios are compared: the machine's load
/// cancels.
fn since(bench: &Bench, before: &[Bench]) -> String {
    let same = |old: &&Bench| {
        same_place(old, bench) && old.variant == bench.variant && old.settings == bench.settings
    };
    let Some(old) = before.iter().find(same) else { return "new".to_owned() };
    let is_baseline = bench.baseline.as_deref() == Some(&*bench.variant);
    let ratios = old.ratio.zip(old.ratio_interval).zip(bench.ratio.zip(bench.ratio_interval));
    let (factor, apart) = match ratios {
        Some(((before, [b_low, b_high]), (now, [low, high])))
            if old.baseline == bench.baseline && !is_baseline =>
        {
            (before / now, b_high < low || high < b_low)
        }
        _ => {
            let ([b_low, b_high], [low, high]) = (old.interval_ms, bench.interval_ms);
            (bench.median_ms / old.median_ms, b_high < low || high < b_low)
        }
    };
    let word = match apart {
        false => "unchanged",
        true if factor > 1.0 => "slower",
        true => "faster",
    };
    format!("×{factor:.3} {word}")
}

fn same_place(a: &Bench, b: &Bench) -> bool {
    let place = |r: &Bench| {
        (
            r.surface.clone(),
            r.backend.clone(),
            r.adapter.clone(),
            r.size,
            r.height,
            r.light.map(f64::to_bits),
        )
    };
    place(a) == place(b)
}

/// A table for each axis. With the exponents by which both times grow with the work.
pub(super) fn scalings(scalings: &[(Swept, Vec<Point>)]) -> String {
    let mut text = String::new();
    for (axis, points) in scalings {
        let Some(first) = points.first().map(|point| &point.record) else { continue };
        text += &format!(
            "{} of {} on {} {}, against {}\n",
            first.variant,
            first.surface,
            first.backend,
            first.adapter,
            axis.name()
        );
        let cells = points.iter().map(|point| {
            vec![
                point.record.value.to_string(),
                digits(point.record.median_ms),
                digits(point.record.mad_ms),
                digits(point.cpu_ms),
            ]
        });
        text += &table::text(&[axis.name(), "ms", "± MAD", "CPU ms"], cells.collect());
        let power = |time: fn(&Point) -> f64| {
            exponent(&points.iter().map(|point| [point.work, time(point)]).collect::<Vec<_>>())
        };
        if let Some((wall, cpu)) = power(|p| p.record.median_ms).zip(power(|p| p.cpu_ms)) {
            let work = axis.work();
            text += &format!("time grows like {work}^{wall:.2}, CPU time like {work}^{cpu:.2}\n");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bench(variant: &str, median_ms: f64, ratio: f64) -> Bench {
        Bench {
            surface: "blazed".into(),
            variant: variant.into(),
            backend: "vulkan".into(),
            adapter: "x".into(),
            light: [20.0, 0.0],
            size: 256,
            height: None,
            median_ms,
            mad_ms: 0.1,
            interval_ms: [0.9 * median_ms, 1.1 * median_ms],
            cpu_ms: 2.0 * median_ms,
            pipeline_ms: 30.0,
            runs: 6,
            outliers: 0,
            frames_per_run: 1,
            clock: "wall".into(),
            ns_per_pixel: 1.0,
            lookups: None,
            ns_per_lookup: None,
            table_bytes: 2048,
            baseline: Some("texts".into()),
            ratio: Some(ratio),
            ratio_interval: Some([0.95 * ratio, 1.05 * ratio]),
            settings: serde_json::Value::Null,
        }
    }

    #[test]
    fn the_fastest_comes_first_and_changes_are_those_of_ratios() {
        let rows = [("texts", 1000.0, 1.0), ("fast", 100.0, 10.0), ("new", 200.0, 5.0)]
            .map(|(name, ms, ratio)| TimedVariant { record: bench(name, ms, ratio), fetches: 9.0 });
        // twice as slow a machine, and `fast` was half as fast on it besides
        let before = [bench("texts", 2000.0, 1.0), bench("fast", 400.0, 5.0)];
        let text = times(&rows, Some(&before));
        let lines: Vec<&str> = text.lines().collect();
        assert!(
            lines[0].starts_with(
                "blazed on vulkan x, 256 × 256 pixels, light 20,0, ratio = texts / this"
            )
        );
        assert!(lines[2].starts_with("fast") && lines[2].ends_with("×0.500 faster"), "{text}");
        assert!(lines[3].starts_with("new") && lines[3].ends_with("wall   new"), "{text}");
        assert!(lines[4].starts_with("texts") && lines[4].ends_with("×0.500 faster"), "{text}");
        assert!(!text.contains("empty frame"));
        let fast = [TimedVariant { record: bench("baked", 0.5, 2000.0), fetches: 1.0 }];
        assert!(times(&fast, None).contains("empty frame"));
        assert!(!times(&rows, None).contains("since") && times(&[], None).is_empty());
    }

    #[test]
    fn four_digits_count() {
        let shown = [0.0, 0.12345, 1.23456, 12.3456, 1234.56, 123456.0].map(digits);
        assert_eq!(shown, ["0.0000", "0.1235", "1.235", "12.35", "1235", "123456"]);
    }
}
