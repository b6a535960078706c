//! The frame of the page: style, script, navigation, and the records.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use sha2::{Digest, Sha256};

use super::source::Folder;
use crate::results::line;

/// How the page looks. Its colours are chosen by the reader's system or by the button in the page.
const STYLE: &str = concat!(include_str!("plot/plot.css"), include_str!("page.css"));

/// The script for sorting, saving and the choice of colours. The page can be read without it.
const SCRIPT: &str = include_str!("page.js");

/// The whole file.
pub(super) fn shell(title: &str, links: &Markup, body: &Markup, pictures: &str) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content="cargo xtask report";
                meta http-equiv="Content-Security-Policy" content=(policy(pictures));
                title { (title) }
                style { (PreEscaped(STYLE)) }
                style { (PreEscaped(pictures)) }
            }
            body {
                nav aria-label="Sections" {
                    div.links { (links) }
                    button #theme type="button" hidden { "Theme" }
                }
                main {
                    header.title {
                        p.over { "Report" }
                        h1 { (title) }
                    }
                    (body)
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    page.into_string() + "\n"
}

/// What a browser may do with the page, whatever a record contains: show the pictures inside it, and use the style and the
/// script with these hashes (Content Security Policy, level 3).
fn policy(pictures: &str) -> String {
    let hash = |text: &str| format!("'sha256-{}'", STANDARD.encode(Sha256::digest(text)));
    let (style, pictures, script) = (hash(STYLE), hash(pictures), hash(SCRIPT));
    format!("default-src 'none'; img-src data:; style-src {style} {pictures}; script-src {script}")
}

/// The records, unchanged, and a button that saves them.
pub(super) fn data(folders: &[Folder]) -> Markup {
    let count: usize = folders.iter().map(|f| f.records.len()).sum();
    // what was read from a file is finite
    let lines = folders.iter().flat_map(|f| &f.records).filter_map(|record| line(record).ok());
    let text: String = lines.collect();
    // text in a script element is not escaped, so no tag may begin there; JSON can write this character in another way
    let text = text.replace('<', "\\u003c");
    html! {
        p {
            "This page contains all its " (count) " records, one JSON object per line. Every table can be saved as CSV. "
            button #save type="button" hidden { "Save records.jsonl" }
        }
        script #records type="application/x-ndjson" { (PreEscaped(text)) }
    }
}
