//! Progress of long work: a bar with the remaining time on a terminal, nothing on a pipe.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar of `total` steps on stderr.
pub fn bar(total: usize, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(total as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {percent:>3} % · {eta} left")
    {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(what.to_owned());
    bar
}
