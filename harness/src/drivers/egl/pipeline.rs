//! A compiled program with its tables, ready to draw.

use std::cell::Cell;
use std::fmt;
use std::ops::Range;

use diffraction_shaders::error::Result;
use diffraction_shaders::shader::emit::{BindingKind, EmittedFile};
use diffraction_shaders::tables::{SAMPLER, Table};

use super::BoundTable;
use super::context::{Context, Current};
use super::device::Device;
use crate::drivers::driver::Rows;

/// A compiled program with its tables, in a context of its own.
pub struct Pipeline {
    context: Context,
    name: String,
    /// Size of the picture that the context draws into.
    size: Cell<Option<[u32; 2]>>,
}

impl Pipeline {
    /// Compiles a vertex and a fragment file and uploads the tables that they read.
    pub(super) fn new(
        device: &Device,
        name: &str,
        files: [&EmittedFile; 2],
        tables: &[BoundTable<'_>],
    ) -> Result<Pipeline> {
        let context = device.context()?;
        let current = context.current(name)?;
        let program = link(&current, &device.driver, files)?;
        for file in files {
            bind(&current, program, file, tables)?;
        }
        drop(current);
        Ok(Pipeline { context, name: name.to_owned(), size: Cell::new(None) })
    }
}

impl Rows for Pipeline {
    fn rows(&self, size: [u32; 2], params: &[f32; 8], band: Range<u32>) -> Result<Vec<[f32; 4]>> {
        let current = self.context.current(&self.name)?;
        let max = ("GL_MAX_RENDERBUFFER_SIZE", glow::MAX_RENDERBUFFER_SIZE);
        let width = within(&current, "a picture's width", size[0] as usize, max)?;
        let height = within(&current, "a picture's height", size[1] as usize, max)?;
        if self.size.replace(None) != Some(size) {
            match current.target([width, height]) {
                Ok(true) => current.check("picture")?,
                Ok(false) => return current.fail("the driver cannot render to 32-bit floats"),
                Err(e) => return current.fail(e),
            }
        }
        let (bottom, rows) = (size[1] - band.end, band.end - band.start);
        let upwards = current.rows([width, bottom as i32, rows as i32], bytemuck::bytes_of(params));
        current.check("drawing")?;
        self.size.set(Some(size));
        Ok(upwards.chunks_exact(size[0] as usize).rev().flatten().copied().collect())
    }
}

impl fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pipeline").field("name", &self.name).finish_non_exhaustive()
    }
}

fn link(
    current: &Current<'_>,
    driver: &str,
    [vertex, fragment]: [&EmittedFile; 2],
) -> Result<glow::Program> {
    let compile = |file: &EmittedFile, kind| {
        let text = String::from_utf8_lossy(&file.bytes);
        current.shader(kind, &text).or_else(|log| {
            let log = trimmed(&log);
            current.fail(format!("{}: does not compile on {driver}: {log}", file.name))
        })
    };
    let shaders =
        [compile(vertex, glow::VERTEX_SHADER)?, compile(fragment, glow::FRAGMENT_SHADER)?];
    let program = current.program(shaders).or_else(|log| {
        let names = format!("{} and {}", vertex.name, fragment.name);
        current.fail(format!("{names}: do not link on {driver}: {}", trimmed(&log)))
    })?;
    current.check("linking")?;
    Ok(program)
}

fn trimmed(log: &str) -> &str {
    log.trim_matches(|c: char| c == '\0' || c.is_whitespace())
}

/// Binds what a file reads, by the bindings in its text, else by the names that were reported with it.
fn bind(
    current: &Current<'_>,
    program: glow::Program,
    file: &EmittedFile,
    tables: &[BoundTable<'_>],
) -> Result<()> {
    for binding in &file.bindings {
        let name = &binding.emitted_name;
        let missing = || current.fail(format!("{}: the driver does not know {name}", file.name));
        let place = binding.emitted_binding.unwrap_or(binding.binding);
        let unsaid = binding.emitted_binding.is_none().then_some(place);
        match binding.kind {
            BindingKind::Texture => {
                if !current.texture_unit(program, name, unsaid) {
                    return missing();
                }
                let Some((_, table)) = tables.iter().find(|(at, _)| *at == binding.binding) else {
                    return current.fail(format!("{}: has no table for {name}", file.name));
                };
                upload(current, place, table)?;
            }
            BindingKind::UniformBlock => {
                let bytes = size_of::<[f32; 8]>() as i32;
                match current.block(program, name, unsaid) {
                    Some(found) if found == bytes => {}
                    Some(found) => {
                        let cause = format!("{name} has {found} bytes instead of {bytes}");
                        return current.fail(format!("{}: {cause}", file.name));
                    }
                    None => return missing(),
                }
                current.uniform_buffer(place, bytes).or_else(|e| current.fail(e))?;
            }
            // combined with its texture, whose parameters come from the table
            BindingKind::Sampler if binding.binding == SAMPLER => {}
            BindingKind::Sampler => {
                return current.fail(format!("{}: {name} is an unknown sampler", file.name));
            }
        }
    }
    current.check("binding")
}

fn upload(current: &Current<'_>, unit: u32, table: &Table) -> Result<()> {
    let what = format!("table {}", table.name);
    let side = ("GL_MAX_TEXTURE_SIZE", glow::MAX_TEXTURE_SIZE);
    let layers = ("GL_MAX_ARRAY_TEXTURE_LAYERS", glow::MAX_ARRAY_TEXTURE_LAYERS);
    let units = ("GL_MAX_TEXTURE_IMAGE_UNITS", glow::MAX_TEXTURE_IMAGE_UNITS);
    within(current, &format!("{what}: units"), unit as usize + 1, units)?;
    let size = [
        within(current, &format!("{what}: width"), table.width, side)?,
        within(current, &format!("{what}: height"), table.height, side)?,
        within(current, &format!("{what}: layers"), table.layers.max(1), layers)?,
    ];
    current.upload(unit, table, size).or_else(|e| current.fail(format!("{what}: {e}")))?;
    current.check(&what)
}

/// A number as GL's integer; an error if it is 0 or above a limit of the driver.
fn within(
    current: &Current<'_>,
    what: &str,
    value: usize,
    (name, parameter): (&str, u32),
) -> Result<i32> {
    let max = current.limit(parameter);
    match i32::try_from(value) {
        Ok(value) if (1..=max).contains(&value) => Ok(value),
        _ => current.fail(format!("{what}: {value} is not between 1 and {name} = {max}")),
    }
}
