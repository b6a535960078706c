//! The routes `webgpu` and `webgl2`: emitted WGSL in a browser's WebGPU and emitted GLSL ES 3.00 in its WebGL2, unchanged.
//!
//! There, Tint compiles WGSL, which shares no code with naga, and ANGLE checks GLSL ES, more strictly than drivers do. Neither a
//! window nor a graphics card is needed: `chromium` comes with SwiftShader, and its WebGL2 uses Mesa's llvmpipe if installed.
//!
//! * One [`Browser`], a process with a profile of its own, serves any number of pipelines of both routes. Dropping it, also on
//!   an error or a panic, ends its processes and removes its profile. If this process is killed, the page loses its server and
//!   closes the browser; the next browser that is started removes the profile.
//! * Every failure is an [`Error`]: the compiler's message with its line, a lost device or context, a browser that crashed
//!   or does not answer.
//! * Pictures are returned row by row from the top: row 0 is next to y = +1.

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
    /// Computes the tables. Nothing is compiled yet.
    pub fn new(subject: Placement<'a>, web: Web) -> Result<BrowserRunner<'a>> {
        Ok(DriverRunner::with(Prepared::new(subject)?, web))
    }
}

/// A graphics interface of browsers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Api {
    /// WebGPU, which takes WGSL.
    WebGpu,
    /// WebGL2, which takes GLSL ES 3.00.
    WebGl2,
}

impl Api {
    /// Both interfaces.
    pub const ALL: [Api; 2] = [Api::WebGpu, Api::WebGl2];

    /// The target whose files it takes.
    pub fn target(self) -> Target {
        match self {
            Api::WebGpu => Target::Wgsl,
            Api::WebGl2 => Target::GlslEs300,
        }
    }

    /// Name of the route.
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

/// A running browser. Clones share one process, which ends with the last clone and the last pipeline.
#[derive(Clone)]
pub struct Browser {
    shared: Arc<Shared>,
}

struct Shared {
    link: Mutex<Link>,
    process: u32,
    /// What the page reported: for each route `driver` or `error`.
    found: Value,
    /// Routes and numbers of pipelines that are no longer needed. They are freed before the next job.
    unused: Mutex<Vec<(Api, u32)>>,
    /// Number of the next pipeline.
    next: Mutex<u32>,
}

impl Browser {
    /// Starts the installed browser.
    pub fn open() -> Result<Browser> {
        Browser::start(None)
    }

    /// Starts a Chromium by its path.
    pub fn open_program(program: &Path) -> Result<Browser> {
        Browser::start(Some(program))
    }

    /// Id of the browser's first process.
    pub fn process(&self) -> u32 {
        self.shared.process
    }

    /// The folder with the browser's profile, which is removed with it.
    pub fn profile(&self) -> PathBuf {
        lock(&self.shared.link).profile().to_owned()
    }

    /// The interface `api` on the adapter that the browser chooses; an error if the browser lacks it.
    pub fn api(&self, api: Api) -> Result<Web> {
        let found = &self.shared.found[api.route()];
        match found["driver"].as_str() {
            Some(driver) => Ok(Web { browser: self.clone(), api, driver: driver.to_owned() }),
            None => {
                let cause = found["error"]
                    .as_str()
                    .unwrap_or("the page reported neither a driver nor an error");
                Err(Error::new(api, cause).remedy(DRIVERS))
            }
        }
    }

    fn start(program: Option<&Path>) -> Result<Browser> {
        let (link, first) = Link::start(program, &flags::ANY_GL)?;
        let (link, first) = match first.head[Api::WebGl2.route()]["driver"].is_string() {
            true => (link, first),
            false => {
                // there is no GL library, or the browser does not accept it
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

    /// Does a job. An error that the page reports is about `subject`.
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

/// How to install drivers that the browser can use.
const DRIVERS: &str = "install software drivers: apt-get install chromium libegl1 libgles2";

/// Flags to start the browser with.
mod flags {
    const WEBGPU: &str = "--enable-unsafe-webgpu";
    const SOFTWARE: &str = "--enable-unsafe-swiftshader";
    /// The machine's GL through EGL. Even a software driver there is much faster than the browser's own.
    pub(super) const ANY_GL: [&str; 3] = [WEBGPU, "--use-angle=gl-egl", "--ignore-gpu-blocklist"];
    /// The software driver that comes with the browser.
    pub(super) const OWN_GL: [&str; 3] = [WEBGPU, "--use-angle=swiftshader", SOFTWARE];
}

/// One interface of a browser, with the adapter that the browser chose.
#[derive(Clone, Debug)]
pub struct Web {
    browser: Browser,
    api: Api,
    driver: String,
}

impl Web {
    /// Starts a browser for one interface. If `adapter` is given, the adapter's name must contain it, ignoring case.
    pub fn open(api: Api, adapter: Option<&str>) -> Result<Web> {
        let web = Browser::open()?.api(api)?;
        let name = web.driver.to_lowercase();
        match adapter.filter(|part| !name.contains(&part.to_lowercase())) {
            None => Ok(web),
            Some(part) => {
                let cause = format!(
                    "the browser chose the adapter {}, whose name does not contain {part}",
                    web.driver
                );
                Err(Error::new(api, cause).remedy("leave --adapter out"))
            }
        }
    }

    /// The interface.
    pub fn api(&self) -> Api {
        self.api
    }

    /// Name of the adapter, from the browser.
    pub fn driver(&self) -> &str {
        &self.driver
    }

    /// Compiles the fragment entry point `entry` of emitted files with their only vertex entry point, and uploads the tables that
    /// it reads. `name` is the variant's name, for errors.
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
}

/// The lock, also after a panic: a holder leaves nothing half done.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
