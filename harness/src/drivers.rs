//! Runs the shaders of variants on drivers of this machine and in a browser.

mod check;
mod colour_map;
mod driver;
pub mod icd;
mod limits;
mod shader;
mod stages;

pub mod browser;
pub mod egl;
pub mod gpu;
pub mod passthrough;
pub mod routes;

pub use browser::BrowserRunner;
pub use check::check;
pub use colour_map::ColourMap;
pub use driver::{BoundTable, Driver, DriverRunner, Prepared, Rows, dark, params, patterned};
pub use egl::EglRunner;
pub use passthrough::PassthroughRunner;
pub use shader::{ShaderRunner, texture as table_texture};
