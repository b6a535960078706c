//! Opens an HTML file in a browser: checks whether it fits a width, collects its console, takes a picture.

use std::fmt::Write;
use std::fs;
use std::path::{Path, absolute};
use std::time::Duration;

use diffraction_cli::interrupt::TemporaryFolder;
use diffraction_shaders::error::{Error, Result};
use serde::Deserialize;

use super::chromium::Chromium;
use super::flags;

/// Maximum time to load a page.
const LIMIT: Duration = Duration::from_secs(120);

/// Prefix of the console line that reports the sizes.
const MARK: &str = "page-check:";

/// A page with the file in a frame. A frame's width is exact, a headless window has a minimum width. Markers are replaced.
const FRAME: &str = r#"<!doctype html>
<meta charset="utf-8">
<style>body { margin: 0 } iframe { border: 0; display: block }</style>
<iframe width="WIDTH" height="HEIGHT" src="ADDRESS"></iframe>
<script>
  const frame = document.querySelector("iframe");
  frame.onload = () => {
    const root = frame.contentDocument.documentElement;
    const sizes = { scroll_width: root.scrollWidth, scroll_height: root.scrollHeight };
    sizes.width = frame.contentWindow.innerWidth;
    console.log("MARK" + JSON.stringify(sizes));
  };
</script>
"#;

/// The result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PageCheck {
    /// Width of the view, CSS pixels.
    pub width: u32,
    /// Width of the content. If it is above `width`, the page scrolls sideways.
    pub scroll_width: u32,
    /// Height of the content.
    pub scroll_height: u32,
    /// Every line on the console: uncaught errors and the page's own lines, which the browser does not distinguish.
    pub console: Vec<String>,
}

/// Opens a local file in a view of `[width, height]` CSS pixels. Saves a picture as PNG, if a path is given.
///
/// Scripts run as from disk. A browser is started for the page and ended afterwards.
pub fn check_page(
    html: &Path,
    [width, height]: [u32; 2],
    screenshot: Option<&Path>,
) -> Result<PageCheck> {
    let about =
        |e: std::io::Error| Error::new(html.display(), "cannot be opened in a browser").source(e);
    fs::metadata(html).map_err(about)?;
    let folder = TemporaryFolder::new().map_err(about)?;
    let page = folder.path().join("frame.html");
    let text = FRAME
        .replace("WIDTH", &width.to_string())
        .replace("HEIGHT", &height.to_string())
        .replace("MARK", MARK)
        .replace("ADDRESS", &address(&absolute(html).map_err(about)?));
    fs::write(&page, text).map_err(about)?;
    let picture = screenshot.map_or_else(|| folder.path().join("picture.png"), Path::to_owned);
    let picture = absolute(&picture).map_err(about)?;
    let settings = [
        "--allow-file-access-from-files".to_owned(),
        "--enable-logging=stderr".to_owned(),
        "--hide-scrollbars".to_owned(),
        // the picture is taken after this time of the page's clock, in ms
        "--virtual-time-budget=5000".to_owned(),
        format!("--window-size={width},{height}"),
        format!("--screenshot={}", picture.display()),
    ];
    let settings = settings.iter().map(String::as_str);
    let flags: Vec<&str> = flags::ANY_GL.into_iter().chain(settings).collect();
    let log = Chromium::start(None, &flags, &address(&page))?.finish(LIMIT)?;
    let unseen = |what| Error::new(html.display(), what);
    if !picture.is_file() {
        return Err(unseen("the browser took no picture of it"));
    }
    read(&log).ok_or_else(|| unseen("the browser did not load it"))
}

/// Finds the sizes and the console lines in the browser's log.
fn read(log: &str) -> Option<PageCheck> {
    #[derive(Deserialize)]
    struct Sizes {
        width: u32,
        scroll_width: u32,
        scroll_height: u32,
    }
    let (sizes, console): (Vec<String>, Vec<String>) =
        console(log).into_iter().partition(|said| said.starts_with(MARK));
    let sizes = sizes.last()?.strip_prefix(MARK).map(serde_json::from_str::<Sizes>);
    let sizes = sizes.and_then(|sizes| sizes.ok());
    let Sizes { width, scroll_width, scroll_height } = sizes?;
    Some(PageCheck { width, scroll_width, scroll_height, console })
}

/// The console lines in the browser's log.
pub(super) fn console(log: &str) -> Vec<String> {
    let lines = log.lines().filter(|line| line.contains(":CONSOLE"));
    let said = |line: &str| -> Option<String> {
        let (_, said) = line.split_once("] ")?;
        let said = said.rsplit_once(", source: ").map_or(said, |(said, _)| said);
        Some(said.trim_matches('"').to_owned())
    };
    lines.filter_map(said).collect()
}

/// The address of a file.
fn address(path: &Path) -> String {
    let mut address = "file://".to_owned();
    for byte in path.to_string_lossy().bytes() {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => address.push(char::from(byte)),
            _ if byte.is_ascii_alphanumeric() => address.push(char::from(byte)),
            _ => {
                // writing to a string does not fail
                let _ = write!(address, "%{byte:02X}");
            }
        }
    }
    address
}
