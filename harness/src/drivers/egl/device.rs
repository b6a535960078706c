//! Finds a display that runs a dialect.

use std::panic::{AssertUnwindSafe, catch_unwind};

use diffraction_shaders::error::{Error, Result};
use khronos_egl as egl;

use super::context::{Context, Current, Instance, displays, instance};
use super::{Dialect, REMEDY};

/// A display that runs one dialect.
#[derive(Clone, Debug)]
pub(super) struct Device {
    pub(super) dialect: Dialect,
    pub(super) driver: String,
    display: egl::Display,
    config: egl::Config,
}

impl Device {
    pub(super) fn open(dialect: Dialect, adapter: Option<&str>) -> Result<Device> {
        let egl = instance()?;
        let wanted = |driver: &str| {
            adapter.is_none_or(|part| driver.to_lowercase().contains(&part.to_lowercase()))
        };
        let mut refused = Vec::new();
        // the bindings panic if a driver violates EGL; such a driver is skipped
        for display in catch_unwind(|| displays(egl)).unwrap_or_default() {
            let opened = catch_unwind(AssertUnwindSafe(|| Device::on(egl, display, dialect)));
            match opened {
                Ok(Ok(device)) if wanted(&device.driver) => return Ok(device),
                Ok(Ok(device)) => refused.push(format!("{} has a different name", device.driver)),
                Ok(Err(reason)) => refused.push(reason),
                Err(_) => refused.push("a display violates the rules of EGL".to_owned()),
            }
        }
        refused.dedup();
        let cause = match (refused.as_slice(), adapter) {
            ([], _) => "EGL has no display".to_owned(),
            (reasons, None) => format!("no display runs it: {}", reasons.join("; ")),
            (reasons, Some(name)) => {
                format!("no display with {name} in its name runs it: {}", reasons.join("; "))
            }
        };
        Err(Error::new(dialect, cause).remedy(REMEDY))
    }

    /// A context of the dialect's kind.
    pub(super) fn context(&self) -> Result<Context> {
        Context::new(self.dialect, self.display, self.config)
    }

    /// Opens a display; the error states why it cannot be used.
    fn on(egl: &Instance, display: egl::Display, dialect: Dialect) -> Result<Device, String> {
        egl.initialize(display)
            .map_err(|e| format!("a display cannot be opened: EGL says {e:?}"))?;
        let renderable = match dialect {
            Dialect::Glsl450 => egl::OPENGL_BIT,
            Dialect::GlslEs300 => egl::OPENGL_ES3_BIT,
        };
        let attributes = [egl::SURFACE_TYPE, 0, egl::RENDERABLE_TYPE, renderable, egl::NONE];
        let config = egl.choose_first_config(display, &attributes).ok().flatten();
        let config =
            config.ok_or_else(|| format!("a display has no configuration for {dialect}"))?;
        let mut device = Device { dialect, driver: String::new(), display, config };
        let context = device.context().map_err(|e| e.message())?;
        let current = context.current(dialect.route()).map_err(|e| e.message())?;
        device.driver = current.driver();
        match lack(&current, dialect) {
            None => Ok(device),
            Some(lack) => Err(format!("{} {lack}", device.driver)),
        }
    }
}

/// What a driver lacks, in words that continue its name.
fn lack(current: &Current<'_>, dialect: Dialect) -> Option<String> {
    let (major, minor) = match dialect {
        Dialect::Glsl450 => (4, 5),
        Dialect::GlslEs300 => (3, 0),
    };
    if current.version() < (major, minor) {
        return Some(format!("is older than {major}.{minor}"));
    }
    // desktop GL renders to 32-bit floats since 3.0
    let extension = "GL_EXT_color_buffer_float";
    (dialect == Dialect::GlslEs300 && !current.has(extension))
        .then(|| format!("cannot render to 32-bit floats: it lacks {extension}"))
}
