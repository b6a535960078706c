//! For each surface: maps of the exact reference, of each variant, and of their difference, with numbers.

use maud::{Markup, html};

use super::album::{Picture, map};
use super::gap::nothing;
use super::merge::{Results, Unit, unique};
use super::number::{self, figure};
use super::summary::PARTS;
use super::table::{Cell, Head, Row, heads, table};
use crate::results::{Compare, Part};

/// The section.
pub(super) fn section(results: &Results<'_>) -> Markup {
    if results.units.is_empty() {
        return nothing("no comparisons", "cargo xtask compare");
    }
    let surfaces = unique(results.units.iter().map(|u| u.surface));
    html! {
        p {
            "Each disc shows all viewing directions under one light: the centre looks along the normal, the rim grazes the surface. "
            "From left to right: the exact reference, the variant, and the absolute difference of linear colours × 10. ΔE₀₀ is "
            "CIEDE2000 over lit directions. max |Δ| and RMS are of tristimulus values, relative to the reference's maximum."
        }
        ul.index {
            @for (i, surface) in surfaces.iter().enumerate() { li { a href={ "#surface-" (i + 1) } { (surface) } } }
        }
        @for (i, surface) in surfaces.iter().enumerate() {
            @let units: Vec<&Unit<'_>> = results.units.iter().filter(|u| u.surface == *surface).collect();
            h3 id={ "surface-" (i + 1) } { (surface) }
            @for (j, (light, size)) in unique(units.iter().map(|u| (&u.light, u.size))).into_iter().enumerate() {
                @let alike: Vec<&Unit<'_>> =
                    units.iter().filter(|u| (&u.light, u.size) == (light, size)).copied().collect();
                p.sub { "Light " (number::lit(light)) " · " (size) " × " (size) " pixels" }
                (overview(&format!("variants-{}-{}", i + 1, j + 1), surface, &alike))
                div.strips { @for unit in alike { (strip(unit)) } }
            }
        }
    }
}

fn overview(id: &str, surface: &str, units: &[&Unit<'_>]) -> Markup {
    let rows: Vec<Row> = units
        .iter()
        .map(|unit| {
            let total = unit.worst(Part::Total);
            let colour = |f: fn(&Compare) -> f64| Cell::maybe(total.map(f));
            let p95 = |part: Part| Cell::maybe(unit.worst(part).map(|c| c.de2000.p95));
            let row = vec![
                Cell::markup(html! { a href={ "#" (unit.anchor) } { (unit.variant) } }),
                unit.setting("mode").map_or_else(Cell::none, Cell::text),
                colour(|c| c.de2000.mean),
                colour(|c| c.de2000.p95),
                colour(|c| c.de2000.max),
                Cell::maybe(total.and_then(|c| c.map.map(|map| map.de2000.p95))),
                Cell::maybe(total.and_then(|c| c.flip)),
                p95(Part::Model),
                p95(Part::Packing),
                Cell::maybe(unit.worst(Part::Arithmetic).map(|c| c.max_abs)),
                verdict(unit),
            ];
            (None, row)
        })
        .collect();
    let heads = [
        ("variant", ""),
        ("mode", "how the variant computes"),
        ("ΔE₀₀ mean", "mean CIEDE2000 against the exact reference, worst route"),
        ("p95", "95th percentile of CIEDE2000 against the exact reference, worst route"),
        ("max", "maximum CIEDE2000"),
        (
            "map p95",
            "95th percentile of CIEDE2000 over the map's pixels, at the exposure of its picture",
        ),
        ("FLIP", "mean FLIP over lit pixels"),
        ("model p95", PARTS[1].2),
        ("packing p95", PARTS[2].2),
        ("arithmetic max |Δ|", PARTS[3].2),
        ("tolerance", "whether every comparison is within its tolerance"),
    ];
    let heads = heads.map(|(name, hint)| Head(name.into(), hint));
    table(id, &format!("Variants on {surface}, the worst of their routes"), &heads, &rows)
}

/// The verdict. If a variant has no tolerance for colours, only its drivers were judged, and the verdict says so; also where
/// the plan accepts errors above the limit.
fn verdict(unit: &Unit<'_>) -> Cell {
    let promised = unit.of(Part::Total).any(|c| c.tolerance.is_some());
    match unit.passes() {
        true if unit.settings.get("accept_error") == Some(&true.into()) => {
            Cell::text("error accepted by the plan")
        }
        true if promised => Cell::verdict(true, "within", ""),
        true => Cell::text("colours not judged"),
        false => Cell::verdict(false, "", "beyond"),
    }
}

fn strip(unit: &Unit<'_>) -> Markup {
    let drawn = unit.total().and_then(|(c, strip)| strip.as_ref().map(|strip| (*c, strip)));
    let others: Vec<(&Compare, &[Picture; 3])> = unit
        .compared
        .iter()
        .filter_map(|(c, strip)| strip.as_ref().map(|strip| (*c, strip)))
        .filter(|(c, _)| drawn.is_some_and(|(first, _)| !std::ptr::eq(first, *c)))
        .collect();
    html! {
        article.strip id=(unit.anchor) {
            header {
                h4 { (unit.variant) }
                (verdict(unit).words())
                @if let Some((c, _)) = unit.total() {
                    span.dim { (figure(100.0 * c.lit)) " % of directions lit · exposure " (figure(c.exposure)) @if let Some(map) = c.map { " · map: " (figure(100.0 * map.lit)) " % lit, exposure " (figure(map.exposure)) } }
                }
            }
            div.pair {
                @match drawn {
                    Some((c, pictures)) => (maps(unit, c, pictures, "exact")),
                    None => p.nothing { "No maps were drawn." },
                }
                (numbers(unit))
            }
            @if !others.is_empty() {
                details {
                    summary { (others.len()) " more pictures of comparisons that disagreed" }
                    div.more { @for (c, pictures) in others { (maps(unit, c, pictures, &c.reference)) } }
                }
            }
        }
    }
}

fn maps(unit: &Unit<'_>, c: &Compare, pictures: &[Picture; 3], reference: &str) -> Markup {
    let of = |what: &str| {
        format!("{what}: {} on {}, light {}", unit.variant, unit.surface, number::lit(&unit.light))
    };
    html! {
        figure.maps {
            div.three {
                div { (map(&pictures[0], &of(reference))) small { (reference) } }
                div { (map(&pictures[1], &of("variant"))) small { "variant" } }
                div { (map(&pictures[2], &of("difference × 10"))) small { "difference × 10" } }
            }
            figcaption { "Colours by " (c.route) ". " a.data href={ "#" (unit.anchor) "-data" } { "Data" } }
        }
    }
}

/// One line for each part of the error: of the worst route, if there are several.
fn numbers(unit: &Unit<'_>) -> Markup {
    let rows: Vec<Row> = PARTS
        .iter()
        .filter_map(|(part, name, _)| {
            let c = unit.worst(*part)?;
            let d = c.de2000;
            let routes = unit.of(*part).count();
            let limit = |limit: Option<f64>| limit.map(figure);
            let allowed = c.tolerance.map_or(String::new(), |t| {
                let limits = [
                    limit(t.de2000_p95).map(|l| format!("p95 ≤ {l}")),
                    limit(t.map_p95).map(|l| format!("map ≤ {l}")),
                    limit(t.max_abs).map(|l| format!("max |Δ| ≤ {l}")),
                ];
                limits.into_iter().flatten().collect::<Vec<_>>().join(", ")
            });
            let by = match (part, routes) {
                (Part::Model | Part::Packing, _) => String::new(),
                (Part::Across, _) => format!("{} / {}", c.route, c.reference),
                (_, 1) => c.route.clone(),
                (_, n) => format!("{}, worst of {n}", c.route),
            };
            let row = vec![
                Cell::text(name),
                Cell::number(d.mean),
                Cell::number(d.p50),
                Cell::judged(
                    d.p95,
                    c.pass || c.tolerance.is_none_or(|t| t.de2000_p95.is_none_or(|l| d.p95 <= l)),
                ),
                Cell::number(d.p99),
                Cell::number(d.max),
                match c.map {
                    Some(map) => Cell::judged(
                        map.de2000.p95,
                        c.tolerance.is_none_or(|t| t.map_p95.is_none_or(|l| map.de2000.p95 <= l)),
                    ),
                    None => Cell::none(),
                },
                Cell::maybe(c.flip),
                Cell::judged(
                    c.max_abs,
                    c.pass || c.tolerance.is_none_or(|t| t.max_abs.is_none_or(|l| c.max_abs <= l)),
                ),
                Cell::number(c.rms),
                Cell::text(allowed),
                Cell::text(by),
            ];
            Some((None, row))
        })
        .collect();
    let names = [
        "error",
        "ΔE₀₀ mean",
        "p50",
        "p95",
        "p99",
        "max",
        "map p95",
        "FLIP",
        "max |Δ|",
        "RMS",
        "allowed",
        "by",
    ];
    let caption =
        format!("{} on {}, light {}", unit.variant, unit.surface, number::lit(&unit.light));
    table(&format!("{}-data", unit.anchor), &caption, &heads(names), &rows)
}
