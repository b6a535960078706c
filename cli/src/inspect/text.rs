//! The facts of a surface as text for people.

use diffraction_shaders::field::orders::SKY_VIEWS_DEG;
use diffraction_shaders::plan::{Film, Material, Medium, SurfaceSource, SurfaceSpec};
use diffraction_shaders::surface::facts::{AxisPeriods, Facts, TRIM_PERCENT};
use diffraction_shaders::survey::{MatterFacts, Survey, TERM_ERRORS};

use crate::list::{or_dash, source, table};

/// Maximum width of a line, in columns. Longer sentences are broken.
const WIDTH: usize = 100;

/// Column in which values begin.
const INDENT: usize = 16;

pub(super) fn human(spec: &SurfaceSpec, found: &Survey, written: &[String]) -> String {
    let is_file = matches!(spec.source, SurfaceSource::File(_));
    let mut lines = vec![("surface", vec![format!("{}: {}", spec.name, source(spec))])];
    lines.extend(size(found));
    lines.extend(relief(found, is_file));
    let mut text = paragraph(lines);
    text += "\n";
    text += &periods(found);
    text += "\n";
    text += &terms(found, is_file);
    text += "\n";
    text += &paragraph(window(found).into_iter().chain(energy(found)).collect());
    text += "\n";
    text += &matter(&found.matter);
    text += "\n";
    text += &cost(found);
    text += &paragraph(vec![("written", written.to_vec())]);
    text
}

type Lines = Vec<(&'static str, Vec<String>)>;

fn size(found: &Survey) -> Lines {
    let Facts { pixels, size_um, pitch_um, shortest_nm, .. } = &found.facts;
    let pitch = if (pitch_um[0] - pitch_um[1]).abs() < 1e-9 * pitch_um[0] {
        format!("{} nm", short(pitch_um[0] * 1e3))
    } else {
        format!("{} nm along x, {} nm along y", short(pitch_um[0] * 1e3), short(pitch_um[1] * 1e3))
    };
    let is_enough = found.wanted_pitch_um * (1.0 + 1e-9) >= pitch_um[0].max(pitch_um[1]);
    let verdict = format!(
        "{}, enough for wavelengths of {} nm and longer; {} nm needs a pitch of at most {} nm{}",
        pitch,
        short(*shortest_nm),
        short(found.wanted_nm),
        short(found.wanted_pitch_um * 1e3),
        if is_enough { "" } else { ": too coarse" }
    );
    let mut lines = vec![
        (
            "size",
            vec![format!(
                "{} × {} pixels, {} × {} µm",
                pixels[0],
                pixels[1],
                short(size_um[0]),
                short(size_um[1])
            )],
        ),
        ("pitch", vec![verdict]),
    ];
    if found.rotate_deg != 0.0 {
        lines.push((
            "rotation",
            vec![format!("{}°, applied later: all numbers here are before it", found.rotate_deg)],
        ));
    }
    lines
}

fn relief(found: &Survey, is_file: bool) -> Lines {
    let facts = &found.facts;
    let nm = |um: f64| format!("{} nm", short(um * 1e3));
    let mut lines = vec![
        (
            "heights",
            vec![format!(
                "{} to {}, peak to valley {}",
                nm(facts.lowest_um),
                nm(facts.highest_um),
                nm(facts.peak_to_valley_um)
            )],
        ),
        ("roughness", vec![format!("{} rms about the mean", nm(facts.rms_um))]),
    ];
    if !is_file {
        return lines;
    }
    if let Some(step_um) = found.step_um {
        lines.push(("steps", vec![format!("{}, since the file holds integers", nm(step_um))]));
    }
    let voids = match found.void_pixels {
        0 => "none".to_owned(),
        n => format!(
            "{n} pixels, {:.2} % of the file, filled from their neighbours",
            found.void_share * 100.0
        ),
    };
    lines.push(("voids", vec![voids]));
    lines.push(("tilt", vec![tilt(facts)]));
    let edges = match facts.joins {
        [true, true] => "tiles without a seam".to_owned(),
        joins => {
            let axes: Vec<&str> =
                ["x", "y"].into_iter().zip(joins).filter(|(_, j)| !j).map(|(a, _)| a).collect();
            let seam = facts.seam[0].max(facts.seam[1]);
            format!(
                "has a seam along {} when tiled (steps across the seam are {} times those inside)",
                axes.join(" and "),
                short(seam)
            )
        }
    };
    lines.push(("edges", vec![edges]));
    lines
}

fn tilt(facts: &Facts) -> String {
    let tilt = &facts.tilt;
    let rise = tilt.rise_um[0].hypot(tilt.rise_um[1]);
    if facts.levelled_peak_to_valley_um < 1e-6 * facts.peak_to_valley_um {
        return "the whole surface is one plane".to_owned();
    }
    if rise < 1e-3 * facts.peak_to_valley_um {
        return "none".to_owned();
    }
    format!(
        "{:.3}° towards {:.0}°, {} nm over the patch; with `level = \"plane\"` the peak to valley is {} nm, with `clip_percent = {TRIM_PERCENT}` as well {} nm",
        tilt.angle_deg,
        tilt.direction_deg,
        short(rise * 1e3),
        short(facts.levelled_peak_to_valley_um * 1e3),
        short(facts.trimmed_peak_to_valley_um * 1e3)
    )
}

fn periods(found: &Survey) -> String {
    let periods = &found.periods;
    let mut text = String::from("dominant periods of the heights\n");
    let percent = |share: f64| format!("{:.1}", share * 100.0);
    let rows: Vec<Vec<String>> = periods
        .peaks
        .iter()
        .map(|peak| {
            let direction = format!("{:.1}", peak.direction_deg);
            vec![format!("{:.3}", peak.period_um), direction, percent(peak.share)]
        })
        .collect();
    if rows.is_empty() {
        text += "  no period has 1 % of the power\n";
    } else {
        text += &indented(&table::text(&["period, µm", "direction, °", "power, %"], rows));
    }
    let along = |axis: &AxisPeriods| match (axis.peaks.as_slice(), axis.mean_um, axis.deviation_um)
    {
        ([], _, _) | (_, None, _) => "no period has 1 % of the power".to_owned(),
        (peaks, Some(mean), deviation) => {
            let listed: Vec<String> = peaks
                .iter()
                .map(|peak| format!("{:.3} µm ({} %)", peak.period_um, percent(peak.share)))
                .collect();
            let deviation = deviation.unwrap_or(0.0);
            let octave = if deviation > 1e-3 * mean {
                format!(
                    "; mean {mean:.2} ± {deviation:.2} µm over an octave, {} % of the power",
                    percent(axis.share)
                )
            } else {
                String::new()
            };
            format!("{}{octave}", listed.join(", "))
        }
    };
    let how = match periods.tiled {
        [true, true] => "exact, of the tiled patch".to_owned(),
        [true, false] => "with a window along y against the seam".to_owned(),
        [false, true] => "with a window along x against the seam".to_owned(),
        [false, false] => "plane removed, with a window against the seam".to_owned(),
    };
    text + &paragraph(vec![
        ("along x", vec![along(&periods.along_x)]),
        ("along y", vec![along(&periods.along_y)]),
        ("spectrum", vec![format!("{how}; ranked by power per octave")]),
    ])
}

fn terms(found: &Survey, is_file: bool) -> String {
    let numbers = |name: String, terms: &[u32; 3]| -> Vec<String> {
        std::iter::once(name).chain(terms.iter().map(ToString::to_string)).collect()
    };
    let mut rows = Vec::new();
    for counts in &found.terms {
        let name = counts.basis.as_str();
        rows.push(numbers(name.to_owned(), &counts.terms));
        if is_file && counts.levelled != counts.terms {
            rows.push(numbers(format!("{name}, levelled"), &counts.levelled));
        }
        if is_file && counts.trimmed != counts.levelled {
            rows.push(numbers(format!("{name}, levelled and clipped"), &counts.trimmed));
        }
    }
    let errors: Vec<String> = TERM_ERRORS.iter().map(|error| format!("{error:e}")).collect();
    let head: Vec<&str> =
        std::iter::once("basis").chain(errors.iter().map(String::as_str)).collect();
    format!(
        "terms needed to keep the error of the phase function below\n{}",
        indented(&table::text(&head, rows))
    )
}

fn window(found: &Survey) -> Lines {
    let window = &found.window;
    let [x, y] = window.sigma_bins;
    let mut sentences = vec![format!(
        "{} µm, `{}`: a lobe's σf is {} of the distance between orders along x, {} along y; halfway to the next order it has fallen to {:.0} % and {:.0} %",
        short(window.coherence_um),
        serde_json::to_value(window.coherence)
            .ok()
            .and_then(|v| v.as_str().map(str::to_owned))
            .unwrap_or_default(),
        short(x),
        short(y),
        window.half_way[0] * 100.0,
        window.half_way[1] * 100.0
    )];
    sentences.extend(window.meaning.iter().cloned());
    vec![("coherence", sentences)]
}

/// What the surface returns of all light.
fn energy(found: &Survey) -> Lines {
    let Some(white_sky) = found.white_sky else { return Vec::new() };
    let views = SKY_VIEWS_DEG.map(|theta_deg| format!("{theta_deg}°")).join(", ");
    let shares = white_sky.map(|[_, y, _]| format!("{:.2} %", 100.0 * y)).join(", ");
    let sentence = format!(
        "{shares} of the light of a white sky, seen at {views} from the normal along x; a scalar theory does not keep energy exactly"
    );
    vec![("reflects", vec![sentence])]
}

/// What the surface is made of, and its reflectance.
fn matter(found: &MatterFacts) -> String {
    let is_covered = found.cover_index != Medium::Constant(1.0);
    let base = match (&found.material, found.refractive_index) {
        (Material::Medium(medium), _) => medium.name(),
        (Material::Dielectric, n) => format!("a dielectric of index {}", n.unwrap_or(f64::NAN)),
    };
    let above = match &found.cover_index {
        Medium::Constant(n) if is_covered => format!("under a cover of index {n}"),
        medium if is_covered => {
            let n = found.cover_index_at_550_nm;
            format!("under a cover of {} (index {n:.3} at 550 nm)", medium.name())
        }
        _ => "in air, without a cover".to_owned(),
    };
    let film = |film: &Film| format!("{} nm of {}", film.thickness_nm, film.index.name());
    let films = match found.films.as_slice() {
        [] => "no films".to_owned(),
        films => {
            let listed: Vec<String> = films.iter().map(film).collect();
            format!("films from the outside in: {}", listed.join(", "))
        }
    };
    let obliquity = found.obliquity.as_str();
    let face = if is_covered { " and without the cover's face" } else { "" };
    let mean = format!(
        "{} %: reflectance of the relief at normal incidence, the mean over the light{face}; results are relative to it",
        percent(found.normal_reflectance)
    );
    let lines = vec![
        ("made of", vec![format!("{base} {above}; {films}; obliquity `{obliquity}`")]),
        ("R0", vec![mean]),
    ];
    paragraph(lines) + &reflectance(found, is_covered)
}

/// Reflectance over wavelength and angle: of the relief alone, and seen from outside where there is a cover.
fn reflectance(found: &MatterFacts, is_covered: bool) -> String {
    let parts: &[(&str, &[[f64; 4]; 7])] = match is_covered {
        true => &[("relief ", &found.relief), ("seen ", &found.outside)],
        false => &[("", &found.relief)],
    };
    let mut head = vec!["wavelength, nm".to_owned()];
    for (part, _) in parts {
        let [first, others @ ..] = found.angles_deg.map(|theta| format!("{theta}°"));
        head.push(format!("{part}{first}"));
        head.extend(others);
    }
    let row = |(i, nm): (usize, &f64)| {
        let values = parts.iter().flat_map(|(_, rows)| rows[i]).map(percent);
        std::iter::once(nm.to_string()).chain(values).collect()
    };
    let rows = found.wavelengths_nm.iter().enumerate().map(row).collect();
    let mut title =
        "reflectance in the mirror direction, %, mean of s and p; angles from the normal in air\n"
            .to_owned();
    if is_covered {
        title += "relief: without the cover's face; seen: from outside, times both transmittances of the face\n";
    }
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    title + &indented(&table::text(&head, rows))
}

fn percent(reflectance: f64) -> String {
    format!("{:.2}", 100.0 * reflectance)
}

fn cost(found: &Survey) -> String {
    if found.variants.is_empty() {
        return String::new();
    }
    let rows = found.variants.iter().map(|variant| {
        vec![
            variant.name.clone(),
            or_dash(variant.terms),
            or_dash(variant.window_radius),
            variant.cost.evaluations.to_string(),
            variant.cost.fetches.to_string(),
            format!("{:.1}", variant.cost.table_bytes as f64 / 1024.0),
        ]
    });
    let head = ["variant", "terms", "radius", "evaluations", "fetches", "tables, KiB"];
    format!("cost of a lit pixel\n{}\n", indented(&table::text(&head, rows.collect())))
}

/// Values with labels. Long values are broken between words.
fn paragraph(lines: Lines) -> String {
    let mut text = String::new();
    for (label, values) in lines {
        let mut label = label;
        for value in values {
            for line in broken(&value) {
                text += format!("{label:<INDENT$}{line}").trim_end();
                text.push('\n');
                label = "";
            }
        }
    }
    text
}

fn broken(value: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in value.split(' ') {
        let last = lines.len() - 1;
        let line = &mut lines[last];
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + word.chars().count() + INDENT < WIDTH {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

fn indented(table: &str) -> String {
    table.lines().map(|line| format!("  {line}\n")).collect()
}

/// Four significant digits without trailing zeros.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = (3.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_sentences_broken() {
        for (value, text) in [
            (48.7987, "48.8"),
            (95.0, "95"),
            (0.063712, "0.06371"),
            (1332.0, "1332"),
            (0.0, "0"),
            (-0.25, "-0.25"),
            (16250.0, "16250"),
        ] {
            assert_eq!(short(value), text);
        }
        let text = paragraph(vec![("label", vec!["word ".repeat(40).trim_end().to_owned()])]);
        assert!(text.lines().count() > 1 && text.lines().all(|line| line.len() <= WIDTH));
        assert!(text.starts_with("label ") && text.lines().nth(1).unwrap().starts_with("      "));
    }
}
