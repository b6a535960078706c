//! Opens a page in a browser and waits until it posts a result.

use std::path::Path;
use std::time::{Duration, Instant};

use diffraction_shaders::error::Result;
use serde_json::Value;

use super::chromium::Chromium;
use super::failure::failure;
use super::flags;
use super::folder::FolderServer;
use super::page_check::console;

/// Interval between checks whether the browser still runs.
const TICK: Duration = Duration::from_millis(100);

/// The result of a page.
#[derive(Clone, Debug)]
pub struct Driven {
    /// The JSON that the page posted.
    pub posted: Value,
    /// Every line on the console, with the browser's own warnings about the page.
    pub console: Vec<String>,
}

/// Opens `page`, a path below the folder with its query, and waits until it posts JSON. A browser with WebGPU and WebGL2 is
/// started for it and ended afterwards.
pub fn drive_page(folder: &Path, page: &str, limit: Duration) -> Result<Driven> {
    let server = FolderServer::open(folder, 0)?;
    let logging = ["--enable-logging=stderr"];
    let flags = [flags::ANY_GL.as_slice(), &logging].concat();
    let begun = Instant::now();
    let mut chromium = Chromium::start(None, &flags, &format!("{}{page}", server.address()))?;
    loop {
        if let Some(bytes) = server.answer(TICK)? {
            let posted = serde_json::from_slice(&bytes).map_err(|e| {
                failure(format!("{page} posted text that is not valid JSON")).source(e)
            })?;
            return Ok(Driven { posted, console: console(&chromium.said()) });
        }
        if let Some(e) = chromium.ended() {
            return Err(e);
        }
        if begun.elapsed() > limit {
            let words = chromium.last_words();
            return Err(failure(format!("{page} posted nothing in {} s{words}", limit.as_secs())));
        }
    }
}
