//! A page that uses another and tells what came of it.

use std::path::Path;
use std::time::{Duration, Instant};

use diffraction_shaders::error::Result;
use serde_json::Value;

use super::chromium::Chromium;
use super::failure::failure;
use super::flags;
use super::folder::FolderServer;
use super::page_check::console;

/// How often it is seen whether the browser still runs.
const TICK: Duration = Duration::from_millis(100);

/// What came of it.
#[derive(Clone, Debug)]
pub struct Driven {
    /// What the page posted.
    pub posted: Value,
    /// Every line on the console, also the browser's own warnings about what the page does.
    pub console: Vec<String>,
}

/// Opens `page`, an address below the folder with its query, and waits until it posts JSON. The browser has WebGPU and WebGL2,
/// is one of its own, and gone afterwards.
pub fn drive_page(folder: &Path, page: &str, limit: Duration) -> Result<Driven> {
    let server = FolderServer::open(folder, 0)?;
    let logging = ["--enable-logging=stderr"];
    let flags = [flags::ANY_GL.as_slice(), &logging].concat();
    let begun = Instant::now();
    let mut chromium = Chromium::start(None, &flags, &format!("{}{page}", server.address()))?;
    loop {
        if let Some(bytes) = server.answer(TICK)? {
            let posted = serde_json::from_slice(&bytes)
                .map_err(|e| failure(format!("{page} posted no JSON")).source(e))?;
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
