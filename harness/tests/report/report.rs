//! The report: everything that was recorded is on the page, nothing else is fetched or run.

use crate::support::tools;
use std::fs;
use std::path::Path;

use crate::support::report::{
    bench, compare, control, draw, gap, scaling, settings, testbench, tune, with, write,
};
use diffraction_harness::report::{Page, page, read};
use serde_json::{Value, json};

const HOSTILE: &str = "<script>alert(1)</script>\" onload='x";

fn everything() -> Vec<Value> {
    let mut records =
        vec![control("vulkan:raster", true), control("glsl450", false), gap("no browser here")];
    for (i, step) in [1.0, 5.0, 100.0].into_iter().enumerate() {
        let name = format!("step-{step}");
        let total =
            compare("blazed", &name, [0.0125, 0.345, 6.78][i], settings("step_nm", json!(step)));
        let other = [("pictures", Value::Null)];
        let part = |part: &str, route: &str, reference: &str, max_abs: f64| {
            let keys = [("part", part), ("route", route), ("reference", reference)]
                .map(|(k, v)| (k, json!(v)));
            let record = with(with(total.clone(), &other), &keys);
            with(
                record,
                &[
                    ("max_abs", json!(max_abs)),
                    ("pass", json!(max_abs < 2e-5)),
                    ("tolerance", json!({"max_abs": 2e-5, "de2000_p95": null})),
                ],
            )
        };
        records.extend([
            part("model", "twin:unpacked", "exact", 1.1e-6),
            part("packing", "twin", "twin:unpacked", 2.2e-6),
            part("arithmetic", "vulkan:raster", "twin", 3.37e-6),
            part("arithmetic", "glsl450", "twin", if i == 2 { 8.88e-5 } else { 3.1e-6 }),
            part("across", "glsl450", "vulkan:raster", 4.48e-6),
        ]);
        records.push(total);
        records.push(bench(&name, [12.4, 3.3, 1.1][i]));
    }
    records.extend([scaling(5.0, 10.0), scaling(10.0, 20.0), scaling(20.0, 40.0)]);
    records.extend([testbench("exact", 2500.161), testbench("full", 2500.173)]);
    records.push(tune("best", "winner", Some(0.33), ""));
    records.push(tune("near", "over", Some(0.99), ""));
    records.push(tune("wide", "unfit", None, "its table is larger than webgl2 guarantees"));
    records.push(json!({
        "kind": "energy", "surface": "blazed", "optics": { "refractive_index": 1.5, "illuminant": "D65" },
        "white_sky": [[0.0392, 0.0411, 0.041], [0.039, 0.0422, 0.0465], [0.0263, 0.0267, 0.0149], [0.194, 0.203, 0.193]],
    }));
    records.push(gap("not applicable: the mode gems has no wavelength axis"));
    records
}

fn report(records: &[Value]) -> Page {
    let folder = tempfile::tempdir().expect("folder");
    write(folder.path(), records);
    draw(folder.path(), records);
    let mut folder = read(folder.path(), true).expect("reads");
    folder.name = "run".into();
    page(&[folder])
}

/// The part of a page between a section's tag and the next section's.
fn section<'a>(html: &'a str, id: &str) -> &'a str {
    let from =
        html.find(&format!("<section id=\"{id}\"")).unwrap_or_else(|| panic!("no section {id}"));
    let rest = &html[from..];
    &rest[..rest.find("</section>").expect("an end")]
}

#[track_caller]
fn has(text: &str, wanted: &[&str]) {
    for wanted in wanted {
        assert!(text.contains(wanted), "no {wanted:?}");
    }
}

#[test]
fn every_section_shows_its_numbers() {
    let Page { html, missing } = report(&everything());
    assert_eq!(missing, Vec::<String>::new());
    has(
        section(&html, "summary"),
        &["2 over tolerance", "1 missed", "caught, 0.993", "no browser here", "339"],
    );
    has(
        section(&html, "maps"),
        &["step-100", "0.0125", "0.0789", "3.33", "0.0555", "0.00456", "25.0 % of directions lit"],
    );
    has(
        section(&html, "pareto"),
        &["<svg", "12.4", "117×", "112–121", "246", "1.50 MiB", "On the front"],
    );
    has(
        section(&html, "energy"),
        &["blazed", "illuminant D65, refractive_index 1.5", "0.0411", "0.203"],
    );
    has(section(&html, "routes"), &["8.88×10⁻⁵", "fails", "4.48×10⁻⁶", "3.37×10⁻⁶"]);
    has(
        section(&html, "periods"),
        &["2500.173", "+0.023", "+0.012", "2499.997 / 0.377", "1144.262", "no wavelength axis"],
    );
    has(section(&html, "sweeps"), &["wavelength step, nm", "6.78", "<svg"]);
    has(section(&html, "scaling"), &["terms of the series", "Exponents: full: 1.00"]);
    has(
        section(&html, "tuned"),
        &[
            "<svg",
            "at most 0.75",
            "Winner: best",
            "417×",
            "401–433",
            "name = &quot;best&quot;",
            "✗ ",
            "larger than webgl2 guarantees",
            "1.50 MiB",
            "★",
        ],
    );
    has(
        section(&html, "rigorous"),
        &[
            "<svg",
            "fine and deep",
            "0.955",
            "lamellar, 1.6 µm, height 0.12 µm, duty 0.35",
            "order −1",
        ],
    );
    has(section(&html, "data"), &["\"kind\":\"scaling\"", "Save records.jsonl"]);
    assert!(!html.contains("Nothing recorded"), "something is said to be missing");
}

#[test]
fn a_section_without_records_says_so() {
    let html = report(&[]).html;
    for id in
        ["summary", "maps", "energy", "pareto", "tuned", "routes", "periods", "sweeps", "scaling"]
    {
        has(section(&html, id), &["Nothing recorded"]);
    }
    assert!(!html.contains("id=\"rigorous\""), "the model's limits without a comparison");
}

#[test]
fn links_lead_somewhere_and_nowhere_outside() {
    let html = report(&everything()).html;
    let mut links = 0;
    for attribute in ["href=\"", "src=\"", "action=\"", "data=\""] {
        for (at, _) in html.match_indices(attribute) {
            let value = &html[at + attribute.len()..];
            let value = &value[..value.find('"').expect("an end")];
            let id = value
                .strip_prefix('#')
                .unwrap_or_else(|| panic!("{attribute}{value} leads outside"));
            assert!(html.contains(&format!("id=\"{id}\"")), "nothing is called {id}");
            links += 1;
        }
    }
    assert!(links > 40, "{links} links only");
    for (at, _) in html.match_indices("url(") {
        assert!(html[at..].starts_with("url(\"data:image/"), "{}", &html[at..at + 40]);
    }
    assert!(!html.contains("http://") && !html.contains("https://") && !html.contains("@import"));
    let mut ids: Vec<&str> = html
        .match_indices(" id=\"")
        .map(|(at, tag)| html[at + tag.len()..].split('"').next().expect("an id"))
        .collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "an id is given twice");
}

#[test]
fn names_are_text_wherever_they_come() {
    let place =
        [("surface", json!(HOSTILE)), ("variant", json!(HOSTILE)), ("route", json!(HOSTILE))];
    let adapter =
        [("backend", json!(HOSTILE)), ("adapter", json!(HOSTILE)), ("axis", json!(HOSTILE))];
    let mut records: Vec<Value> = everything().into_iter().map(|r| with(r, &place)).collect();
    for (i, record) in records.iter_mut().enumerate() {
        *record = with(record.clone(), &adapter);
        record["light"] = json!([20.0, i as f64]);
        record["pictures"] = Value::Null;
        record["reason"] = json!(HOSTILE);
        record["control"] = json!(HOSTILE);
        record["settings"]["mode"] = json!(HOSTILE);
        record["clock"] = json!(HOSTILE);
    }
    let html = report(&records).html;
    has(&html, &["&lt;script&gt;alert(1)", "\\u003cscript>alert(1)"]);
    assert!(!html.contains("<script>alert"), "a name became a tag");
    // in the records themselves a quote is JSON's
    let outside = html.split("<section id=\"data\"").next().expect("a beginning");
    assert!(!outside.contains("\" onload='x"), "a name ended an attribute");
    assert_eq!(html.matches("<script").count(), 2, "the page's own script and its records");
}

#[test]
fn the_same_records_give_the_same_bytes() {
    assert!(report(&everything()).html == report(&everything()).html);
}

#[test]
fn the_last_of_repeated_records_counts() {
    let old = compare("blazed", "full", 7.77, settings("terms", json!(19)));
    let new = compare("blazed", "full", 0.432, settings("terms", json!(19)));
    let html = report(&[old, new]).html;
    has(section(&html, "maps"), &["0.432"]);
    has(section(&html, "summary"), &["1 results by later ones"]);
    assert!(!section(&html, "maps").contains("7.77"));
}

#[test]
fn a_picture_is_in_the_page_once() {
    let records = everything();
    let html = report(&records).html;
    let drawn = records.iter().filter(|r| r["pictures"].is_array()).count() * 3;
    assert_eq!(html.matches("data:image/png;base64,").count(), drawn);
    let shown = html.matches("class=\"map p0\"").count();
    assert!(shown >= 2, "the first map is in its strip and in a sweep: {shown}");
}

#[test]
fn pictures_that_cannot_be_shown_are_named() {
    let folder = tempfile::tempdir().expect("folder");
    let mut record = compare("blazed", "full", 1.0, settings("terms", json!(19)));
    fs::write(folder.path().join("page.png"), "no picture").expect("writes");
    record["pictures"] = json!(["gone.png", "../records.jsonl", "page.png"]);
    write(folder.path(), &[record]);
    let found = page(&[read(folder.path(), true).expect("reads")]);
    let missing = found.missing.join("\n");
    has(
        &missing,
        &[
            "gone.png: ",
            "../records.jsonl: is outside the folder",
            "page.png: is not a PNG or SVG picture",
        ],
    );
    has(section(&found.html, "summary"), &["gone.png", "is outside"]);
    has(section(&found.html, "maps"), &["picture missing"]);
    let without = page(&[read(folder.path(), false).expect("reads")]);
    assert_eq!(without.missing, Vec::<String>::new());
    has(section(&without.html, "maps"), &["left out"]);
}

#[test]
fn folders_without_sound_records_are_errors() {
    let folder = tempfile::tempdir().expect("folder");
    let fault = |folder: &Path| read(folder, true).expect_err("a fault").to_string();
    has(&fault(folder.path()), &["has no records.jsonl", "--out"]);
    fs::write(folder.path().join("records.jsonl"), "{\"kind\":\"compare\"}\n").expect("writes");
    has(&fault(folder.path()), &["records.jsonl:1", "missing field"]);
}

#[test]
fn modes_and_lights_are_sweeps_too() {
    let under = |name: &str, mode: Value, light: f64| {
        let record = compare("blazed", name, 0.5, mode);
        with(record, &[("light", json!([light, 0.0])), ("pictures", Value::Null)])
    };
    let full = || settings("mode", json!("full"));
    let records = [
        under("full", full(), 0.0),
        under("full", full(), 10.0),
        under("full", full(), 20.0),
        under("pq", json!({"mode": "pq", "terms": 19, "periods": "auto"}), 20.0),
        under("gems", json!({"mode": "gems"}), 20.0),
        under("coarse", json!({"mode": "pq", "terms": 3}), 20.0),
    ];
    let html = report(&records).html;
    let sweeps = section(&html, "sweeps");
    has(sweeps, &["blazed: mode", "blazed: light", ">pq<", ">gems<", "θ 10°, φ 0°"]);
    assert!(!sweeps.contains("coarse"), "a variant of other terms differs in two settings");
}

/// No script fails, and nothing sticks out of a desk's window or a telephone's.
#[test]
fn a_browser_shows_it_without_errors_or_scrolling_sideways() {
    use diffraction_harness::drivers::browser::check_page;
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("report.html");
    fs::write(&file, report(&everything()).html).expect("writes");
    for width in [1280, 390] {
        let Some(found) = tools::found(check_page(&file, [width, 900], None)) else { return };
        assert_eq!(found.width, width);
        assert!(found.scroll_width <= width, "{found:?}");
        assert!(found.scroll_height > 2000, "{found:?}");
        assert!(found.console.is_empty(), "{found:?}");
    }
    // and it would be seen: a script that the page's policy forbids, and something too wide
    let html = report(&everything()).html;
    let wrong =
        html.replace("</main>", "<p style=\"width:3000px\">x</p><script>y()</script></main>");
    assert_ne!(html, wrong);
    fs::write(&file, wrong.replace("Content-Security-Policy", "no-policy")).expect("writes");
    let found = check_page(&file, [390, 900], None).expect("opens");
    assert!(found.scroll_width > 390 && !found.console.is_empty(), "{found:?}");
}
