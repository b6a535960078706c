//! Emitted WGSL in a browser's WebGPU and emitted GLSL ES 3.00 in its WebGL2, exactly as emitted: the routes `webgpu` and
//! `webgl2`.
//!
//! WGSL meets Tint there, a compiler that shares nothing with naga; GLSL ES meets ANGLE's checks, which are stricter than
//! those of drivers. No window and no graphics card are needed: `chromium` brings SwiftShader, and its WebGL2 takes Mesa's
//! llvmpipe where that is installed.
//!
//! * One [`Browser`], a program with a profile of its own, serves any number of pipelines of both routes. Its end, also
//!   where an error or a panic brings it, ends its processes and removes its profile. Where this process is killed, the
//!   page finds its server gone and closes the browser; the profile goes with the next one that is started.
//! * Every failure is an [`Error`]: the compiler's message with its line, a lost device or context, a browser that crashed
//!   or does not answer.
//! * Pictures are handed out row by row from the top: row 0 is next to y = +1.

mod chromium;
mod drive;
mod folder;
mod link;
mod page_check;
mod pipeline;
mod failure;
mod user_folder;
mod server;

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::plan::Target;
use diffraction_shaders::runner::Placement;
use diffraction_shaders::shader::emit::{EmittedFile, emit};
use diffraction_shaders::shader::module::Module;
use serde_json::{Value, json};

use super::driver::{BoundTable, Driver, DriverRunner, Prepared};
use super::stages::stages;

pub use drive::{Driven, drive_page};
pub use folder::FolderServer;
use link::{Link, Message};
pub use page_check::{PageCheck, check_page};
pub use pipeline::Pipeline;

/// A variant's emitted text in a browser.
pub type BrowserRunner<'a> = DriverRunner<'a, Web>;

impl<'a> BrowserRunner<'a> {
    /// Computes the tables and compiles nothing yet.
    pub fn new(subject: Placement<'a>, web: Web) -> Result<BrowserRunner<'a>> {
        Ok(DriverRunner::with(Prepared::new(subject)?, web))
    }
}

/// An interface of browsers to drivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Api {
    /// WebGPU, which takes WGSL.
    WebGpu,
    /// WebGL2, which takes GLSL ES 3.00.
    WebGl2,
}

impl Api {
    /// Both of them.
    pub const ALL: [Api; 2] = [Api::WebGpu, Api::WebGl2];

    /// The target whose texts it takes.
    pub fn target(self) -> Target {
        match self {
            Api::WebGpu => Target::Wgsl,
            Api::WebGl2 => Target::GlslEs300,
        }
    }

    /// The route.
    pub fn route(self) -> &'static str {
        match self {
            Api::WebGpu => "webgpu",
            Api::WebGl2 => "webgl2",
        }
    }
}

impl fmt::Display for Api {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.route())
    }
}

/// A running browser. Clones are the same one; it ends with the last of them and of their pipelines.
#[derive(Clone)]
pub struct Browser {
    shared: Arc<Shared>,
}

struct Shared {
    link: Mutex<Link>,
    process: u32,
    /// What the page found: for each route `driver` or `error`.
    found: Value,
    /// Jobs to do before the next one: numbers of pipelines that are no longer needed, and the route of each.
    unused: Mutex<Vec<(Api, u32)>>,
    /// Number of the next pipeline.
    next: Mutex<u32>,
}

impl Browser {
    /// Starts the browser of the machine.
    pub fn open() -> Result<Browser> {
        Browser::start(None)
    }

    /// Starts a Chromium that lies elsewhere.
    pub fn open_program(program: &Path) -> Result<Browser> {
        Browser::start(Some(program))
    }

    /// Number of its first process.
    pub fn process(&self) -> u32 {
        self.shared.process
    }

    /// The folder with its profile, which goes with it.
    pub fn profile(&self) -> PathBuf {
        lock(&self.shared.link).profile().to_owned()
    }

    /// Its interface `api` on whatever adapter the browser takes; an error where it has none.
    pub fn api(&self, api: Api) -> Result<Web> {
        let found = &self.shared.found[api.route()];
        match found["driver"].as_str() {
            Some(driver) => Ok(Web { browser: self.clone(), api, driver: driver.to_owned() }),
            None => {
                let cause = found["error"].as_str().unwrap_or("the page does not know it");
                Err(Error::new(api, cause).remedy(DRIVERS))
            }
        }
    }

    fn start(program: Option<&Path>) -> Result<Browser> {
        let (link, first) = Link::start(program, &flags::ANY_GL)?;
        let (link, first) = match first.head[Api::WebGl2.route()]["driver"].is_string() {
            true => (link, first),
            false => {
                // no library of GL, or none that the browser likes
                drop(link);
                Link::start(program, &flags::OWN_GL)?
            }
        };
        let shared = Shared {
            process: link.id(),
            link: Mutex::new(link),
            found: first.head,
            unused: Mutex::default(),
            next: Mutex::default(),
        };
        Ok(Browser { shared: Arc::new(shared) })
    }

    /// Does a job; `subject` is named where the page reports an error.
    fn call(&self, subject: &str, head: &Value, payload: &[&[u8]]) -> Result<Message> {
        let mut link = lock(&self.shared.link);
        let unused = std::mem::take(&mut *lock(&self.shared.unused));
        for (api, id) in unused {
            link.call(&json!({ "job": "free", "api": api.route(), "id": id }), &[])?;
        }
        let message = link.call(head, payload)?;
        match message.head["error"].as_str() {
            Some(cause) => Err(Error::new(subject, cause)),
            None => Ok(message),
        }
    }
}

impl fmt::Debug for Browser {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Shared { process, found, .. } = &*self.shared;
        f.debug_struct("Browser").field("process", process).field("found", found).finish()
    }
}

/// What brings drivers that the browser can use.
const DRIVERS: &str = "apt-get install chromium libegl1 libgles2 brings software drivers";

/// Ways to start it.
mod flags {
    const WEBGPU: &str = "--enable-unsafe-webgpu";
    const SOFTWARE: &str = "--enable-unsafe-swiftshader";
    /// The machine's own GL, by its EGL: much faster than the browser's software driver where it is software, too.
    pub(super) const ANY_GL: [&str; 3] = [WEBGPU, "--use-angle=gl-egl", "--ignore-gpu-blocklist"];
    /// The software driver that comes with the browser.
    pub(super) const OWN_GL: [&str; 3] = [WEBGPU, "--use-angle=swiftshader", SOFTWARE];
}

/// One interface of a browser, with the adapter that it took.
#[derive(Clone, Debug)]
pub struct Web {
    browser: Browser,
    api: Api,
    driver: String,
}

impl Web {
    /// Starts a browser of its own for one interface, whose adapter's name contains `adapter`, in any case of letters, where
    /// given.
    pub fn open(api: Api, adapter: Option<&str>) -> Result<Web> {
        let web = Browser::open()?.api(api)?;
        let name = web.driver.to_lowercase();
        match adapter.filter(|part| !name.contains(&part.to_lowercase())) {
            None => Ok(web),
            Some(part) => {
                let cause = format!("the browser chose {}, which is not {part}", web.driver);
                Err(Error::new(api, cause).remedy("leave --adapter out"))
            }
        }
    }

    /// The interface.
    pub fn api(&self) -> Api {
        self.api
    }

    /// The adapter as the browser calls it.
    pub fn driver(&self) -> &str {
        &self.driver
    }

    /// Compiles the fragment entry point `entry` of emitted files, after their only vertex entry point, and uploads the
    /// tables that it reads; `name` is the variant's, for errors.
    pub fn compile(
        &self,
        name: &str,
        files: &[EmittedFile],
        entry: &str,
        tables: &[BoundTable<'_>],
    ) -> Result<Pipeline> {
        Pipeline::new(self, name, stages(name, files, entry)?, tables)
    }
}

impl Driver for Web {
    type Pipeline = Pipeline;

    fn route(&self) -> String {
        self.api.route().to_owned()
    }

    fn pipeline(
        &self,
        module: &Module,
        entry: &str,
        tables: &[BoundTable<'_>],
    ) -> Result<Pipeline> {
        let files = emit(module, self.api.target())?;
        self.compile(module.name(), &files, entry, tables)
    }

    fn rows(
        &self,
        pipeline: &Pipeline,
        size: [u32; 2],
        params: &[f32; 8],
        band: Range<u32>,
    ) -> Result<Vec<[f32; 4]>> {
        pipeline.rows(size, params, band)
    }
}

/// Whoever panicked while it held the lock left nothing half done.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
