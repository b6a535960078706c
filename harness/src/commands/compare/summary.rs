//! The results of a comparison as a table for people.

use std::collections::BTreeMap;

use crate::results::{Compare, Lit, Part, Record};

use diffraction_cli::Outcome;
use diffraction_cli::list::table;

/// The table, and whether everything passed.
pub(super) fn summary(records: &[Record]) -> (String, Outcome) {
    let compares: Vec<&Compare> = records
        .iter()
        .filter_map(|record| match record {
            Record::Compare(compare) => Some(compare),
            _ => None,
        })
        .collect();
    let mut text = variants(&compares);
    text += &routes(&compares);
    let controls: Vec<_> = records
        .iter()
        .filter_map(|record| match record {
            Record::Control(control) => Some(control),
            _ => None,
        })
        .collect();
    let missed: Vec<_> = controls.iter().filter(|control| !control.caught).collect();
    text += &format!(
        "\n{} negative controls, {} caught\n",
        controls.len(),
        controls.len() - missed.len()
    );
    for control in &missed {
        text += &format!(
            "  NOT CAUGHT: {} by {}: max_abs {:.2e} (right shader: {:.2e})\n",
            control.control, control.route, control.max_abs, control.right_max_abs
        );
    }
    let outside: Vec<_> = compares.iter().filter(|c| !c.pass).collect();
    text += &format!("{} comparisons, {} outside their tolerance\n", compares.len(), outside.len());
    for c in &outside {
        let allowed = c.tolerance.map_or(String::new(), |t| {
            let values = t.max_abs.map(|v| format!("max_abs {v:.1e}"));
            let colours = t.de2000_p95.map(|v| format!("ΔE00 p95 {v}"));
            let map = t.map_p95.map(|v| format!("map p95 {v}"));
            [values, colours, map].into_iter().flatten().collect::<Vec<_>>().join(", ")
        });
        text += &format!(
            "  OUTSIDE: {} {} {} against {}: max_abs {:.2e}, ΔE00 p95 {:.3}, map p95 {:.3}; allowed: {allowed}\n",
            c.surface,
            c.variant,
            c.route,
            c.reference,
            c.max_abs,
            c.de2000.p95,
            c.map.map_or(0.0, |map| map.de2000.p95)
        );
    }
    let mut failures = 0;
    for record in records {
        if let Record::Gap(gap) = record {
            failures += usize::from(gap.failed);
            if gap.failed || gap.surface.is_none() || compares.is_empty() {
                text += &format!("not run: {}: {}\n", gap.route, gap.reason);
            }
        }
    }
    // if a driver took part, there must be controls: without any, nothing is proved
    let by_driver = compares.iter().any(|c| c.part == Part::Arithmetic);
    let unproved = by_driver && controls.is_empty();
    let good = outside.is_empty() && missed.is_empty() && failures == 0 && !unproved;
    (text, if good && !compares.is_empty() { Outcome::Done } else { Outcome::Findings })
}

/// Each variant's twin against the exact reference, and whether all its routes pass.
fn variants(compares: &[&Compare]) -> String {
    let head = [
        "surface",
        "variant",
        "light",
        "ΔE00 p95",
        "max",
        "map p95",
        "FLIP",
        "max_abs",
        "lit %",
        "verdict",
    ];
    let mut rows = Vec::new();
    for c in compares.iter().filter(|c| c.part == Part::Total && c.route == "twin") {
        let same =
            |o: &&&Compare| o.surface == c.surface && o.variant == c.variant && o.light == c.light;
        let pass = compares.iter().filter(same).all(|o| o.pass);
        rows.push(vec![
            c.surface.clone(),
            c.variant.clone(),
            match &c.light {
                Lit::Direction([theta, phi]) => format!("{theta},{phi}"),
                Lit::Lights(name) => name.clone(),
            },
            format!("{:.3}", c.de2000.p95),
            format!("{:.2}", c.de2000.max),
            c.map.map_or("-".to_owned(), |map| format!("{:.3}", map.de2000.p95)),
            c.flip.map_or("-".to_owned(), |flip| format!("{flip:.4}")),
            format!("{:.1e}", c.max_abs),
            format!("{:.1}", 100.0 * c.lit),
            if pass { "ok" } else { "OUTSIDE" }.to_owned(),
        ]);
    }
    table::text(&head, rows)
}

/// The maximum difference of each route from the twin and from the other routes.
fn routes(compares: &[&Compare]) -> String {
    let mut worst: BTreeMap<&str, [(f64, usize); 2]> = BTreeMap::new();
    for c in compares {
        let column = match c.part {
            Part::Arithmetic => 0,
            Part::Across => 1,
            _ => continue,
        };
        let (max, count) = &mut worst.entry(&c.route).or_insert([(0.0, 0); 2])[column];
        *max = max.max(c.max_abs);
        *count += 1;
    }
    if worst.is_empty() {
        return String::new();
    }
    let head = ["route", "variants", "max_abs to twin", "max_abs to another route"];
    let mut rows = Vec::new();
    for (route, [(twin, count), (other, others)]) in worst {
        let across = if others > 0 { format!("{other:.1e}") } else { "-".to_owned() };
        rows.push(vec![route.to_owned(), count.to_string(), format!("{twin:.1e}"), across]);
    }
    format!("\n{}", table::text(&head, rows))
}
