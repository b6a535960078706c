//! The routes `glsl450` and `glsl-es300`: emitted GLSL on a GL driver, unchanged.
//!
//! Neither a window nor a graphics card is needed: the packages `libegl1 libgles2 libgl1-mesa-dri` contain Mesa's llvmpipe. The
//! library is loaded at run time, so that a build does not need them.
//!
//! * Textures and the uniform block are found by the names, or the bindings, that [`emit`](diffraction_shaders::shader::emit) reports. A name
//!   that the driver does not know is an error.
//! * Clip space is GL's own, y up. Pictures are returned row by row from the top: row 0 is next to y = +1.
//! * Every pipeline has a context of its own, which is current only inside calls, on the calling thread. Dropping the pipeline
//!   frees the context with all its textures and buffers.
//! * The display that EGL opens is kept until the process ends: other code may have opened the same one.

mod context;
mod device;
mod pipeline;

use std::fmt;

use diffraction_shaders::error::Result;
use diffraction_shaders::plan::Target;
use diffraction_shaders::runner::Placement;
use diffraction_shaders::shader::emit::{EmittedFile, emit};
use diffraction_shaders::shader::module::Module;

use super::driver::{BoundTable, Driver, DriverRunner, Prepared};
use super::stages::stages;

use device::Device;
pub use pipeline::Pipeline;

/// How to install a software driver.
const REMEDY: &str = "install a software driver: apt-get install libegl1 libgles2 libgl1-mesa-dri";

/// A variant's emitted GLSL on one driver.
pub type EglRunner<'a> = DriverRunner<'a, Egl>;

impl<'a> EglRunner<'a> {
    /// Opens the first driver of the machine and computes the tables. Nothing is compiled yet.
    pub fn new(placement: Placement<'a>, dialect: Dialect) -> Result<EglRunner<'a>> {
        let egl = Egl::open(dialect, None)?;
        Ok(DriverRunner::with(Prepared::new(placement)?, egl))
    }
}

/// A dialect of GLSL, with the kind of context that runs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Dialect {
    /// GLSL 4.50 in a core context of desktop GL 4.5 or later.
    Glsl450,
    /// GLSL ES 3.00 in a context of GLES 3.0 or later.
    GlslEs300,
}

impl Dialect {
    /// Both dialects.
    pub const ALL: [Dialect; 2] = [Dialect::Glsl450, Dialect::GlslEs300];

    /// The target whose files it runs.
    pub fn target(self) -> Target {
        match self {
            Dialect::Glsl450 => Target::Glsl450,
            Dialect::GlslEs300 => Target::GlslEs300,
        }
    }

    /// Name of the route, the same as the target's.
    pub fn route(self) -> &'static str {
        self.target().as_str()
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.route())
    }
}

/// A driver that runs one dialect.
#[derive(Clone, Debug)]
pub struct Egl {
    device: Device,
}

impl Egl {
    /// Opens the first driver of the machine that runs `dialect` and whose name contains `adapter`, if given, ignoring case. Mesa
    /// lists graphics cards before software drivers.
    ///
    /// The error states why each display was refused.
    pub fn open(dialect: Dialect, adapter: Option<&str>) -> Result<Egl> {
        Device::open(dialect, adapter).map(|device| Egl { device })
    }

    /// The dialect.
    pub fn dialect(&self) -> Dialect {
        self.device.dialect
    }

    /// Renderer and version, from the driver.
    pub fn driver(&self) -> &str {
        &self.device.driver
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
        let [(vertex, _), (fragment, _)] = stages(name, files, entry)?;
        Pipeline::new(&self.device, name, [vertex, fragment], tables)
    }
}

impl Driver for Egl {
    type Pipeline = Pipeline;

    fn route(&self) -> String {
        self.dialect().route().to_owned()
    }

    fn pipeline(
        &self,
        module: &Module,
        entry: &str,
        tables: &[BoundTable<'_>],
    ) -> Result<Pipeline> {
        let files = emit(module, self.dialect().target())?;
        self.compile(module.name(), &files, entry, tables)
    }
}
