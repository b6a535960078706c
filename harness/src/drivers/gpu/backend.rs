//! Graphics interfaces and adapters, in words.

use std::{fmt, str::FromStr};

use diffraction_shaders::error::{Error, Result};

/// A graphics interface of the operating system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Backend {
    /// Vulkan.
    Vulkan,
    /// Desktop OpenGL through EGL.
    Gl,
    /// Metal, on Apple's systems only.
    Metal,
    /// Direct3D 12, on Windows only.
    Dx12,
}

impl Backend {
    /// All backends.
    pub const ALL: [Backend; 4] = [Backend::Vulkan, Backend::Gl, Backend::Metal, Backend::Dx12];

    /// The name on the command line: `vulkan`, `gl`, `metal`, `dx12`.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Vulkan => "vulkan",
            Backend::Gl => "gl",
            Backend::Metal => "metal",
            Backend::Dx12 => "dx12",
        }
    }

    pub(super) fn wgpu(self) -> wgpu::Backend {
        match self {
            Backend::Vulkan => wgpu::Backend::Vulkan,
            Backend::Gl => wgpu::Backend::Gl,
            Backend::Metal => wgpu::Backend::Metal,
            Backend::Dx12 => wgpu::Backend::Dx12,
        }
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Backend {
    type Err = Error;

    fn from_str(name: &str) -> Result<Backend> {
        Backend::ALL.into_iter().find(|backend| backend.name() == name).ok_or_else(|| {
            Error::new(name, "is not a backend")
                .remedy(format!("one of {}", Backend::ALL.map(Backend::name).join(", ")))
        })
    }
}

/// An adapter, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterInfo {
    /// The graphics interface.
    pub backend: Backend,
    /// Its name, from the driver. Lavapipe and llvmpipe have the same name, and differ in `backend` and `driver`.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
}

impl fmt::Display for AdapterInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.name, self.driver)
    }
}
