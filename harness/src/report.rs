//! One HTML page from records and pictures. Everything is inside one file, nothing is loaded from elsewhere, and the same input
//! gives the same bytes.

mod album;
mod compared;
mod energy;
mod gap;
mod merge;
mod number;
mod page;
mod pareto;
mod periods;
mod plot;
mod rigorous;
mod routes;
mod scaling;
mod source;
mod summary;
mod sweeps;
mod table;
mod tuned;

use maud::html;

use merge::Results;

pub use source::{Folder, read};
pub use tuned::front_picture;

/// A report.
#[derive(Clone, Debug)]
pub struct Page {
    /// The HTML file.
    pub html: String,
    /// Pictures that records name but that cannot be shown, each with the reason.
    pub missing: Vec<String>,
}

/// The page of several folders of results. If there are several results of the same measurement, the last one counts.
pub fn page(folders: &[Folder]) -> Page {
    let results = Results::new(folders);
    let mut sections = vec![
        ("summary", "Summary", summary::section(&results)),
        ("maps", "Maps", compared::section(&results)),
        ("energy", "Energy", energy::section(&results)),
        ("pareto", "Error and time", pareto::section(&results)),
        ("tuned", "Tuned", tuned::section(&results)),
        ("routes", "Routes", routes::section(&results)),
        ("periods", "Periods", periods::section(&results)),
        ("sweeps", "Sweeps", sweeps::section(&results)),
        ("scaling", "Scaling", scaling::section(&results)),
    ];
    // who reads how near a shader is to the model should see how near that is to light
    if !results.units.is_empty() {
        sections.push(("rigorous", "Scalar and rigorous", rigorous::section()));
    }
    sections.push(("data", "Data", page::data(folders)));
    let links = html! { @for (id, name, _) in &sections { a href={ "#" (id) } { (name) } } };
    let body = html! {
        @for (id, name, content) in &sections {
            section id=(id) aria-labelledby={ (id) "-h" } {
                h2 id={ (id) "-h" } { (name) }
                (content)
            }
        }
    };
    let html = page::shell(&results.title(), &links, &body, &results.album.css());
    Page { html, missing: results.missing }
}
