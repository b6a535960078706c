//! A compiled program with its tables in the page.

use std::ops::Range;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::shader::emit::{BindingKind, EmittedFile};
use diffraction_shaders::tables::{SAMPLER, Table};
use serde_json::{Value, json};

use super::{Api, BoundTable, Browser, Web, lock};
use crate::drivers::driver::{PARAMS, Rows};
use crate::drivers::stages::StageFile;

/// A compiled program with its tables. The page frees it when it is dropped.
#[derive(Debug)]
pub struct Pipeline {
    browser: Browser,
    api: Api,
    id: u32,
    name: String,
}

impl Pipeline {
    /// Compiles a vertex and a fragment stage and uploads the tables that they read.
    pub(super) fn new(
        web: &Web,
        name: &str,
        stages: [StageFile<'_>; 2],
        tables: &[BoundTable<'_>],
    ) -> Result<Pipeline> {
        let bytes =
            tables.iter().map(|(_, table)| bytes(name, table)).collect::<Result<Vec<_>>>()?;
        let listed: Vec<Value> =
            tables.iter().zip(&bytes).map(|((at, table), b)| describe(*at, table, b)).collect();
        let id = {
            let mut next = lock(&web.browser.shared.next);
            *next += 1;
            *next
        };
        let mut job = json!({
            "job": "compile",
            "api": web.api.route(),
            "id": id,
            "vertex": text(stages[0]),
            "fragment": text(stages[1]),
            "tables": listed,
        });
        resources(&mut job, name, web.api, stages, tables)?;
        let payload: Vec<&[u8]> = bytes.iter().map(Vec::as_slice).collect();
        web.browser.call(name, &job, &payload)?;
        Ok(Pipeline { browser: web.browser.clone(), api: web.api, id, name: name.to_owned() })
    }
}

impl Rows for Pipeline {
    fn rows(&self, size: [u32; 2], params: &[f32; 8], band: Range<u32>) -> Result<Vec<[f32; 4]>> {
        let job = json!({
            "job": "draw",
            "api": self.api.route(),
            "id": self.id,
            "size": size,
            "params": params,
            "top": band.start,
            "bottom": band.end,
        });
        let message = self.browser.call(&self.name, &job, &[])?;
        let wanted = size[0] as usize * band.len();
        if message.payload.len() != wanted * size_of::<[f32; 4]>() {
            let cause = format!("{} bytes came back for {wanted} pixels", message.payload.len());
            return Err(Error::new(&self.name, cause));
        }
        let numbers = message.payload.as_chunks().0.iter().map(|&four| f32::from_le_bytes(four));
        let numbers: Vec<f32> = numbers.collect();
        let pixels = numbers.as_chunks::<4>().0;
        Ok(match self.api {
            Api::WebGpu => pixels.to_vec(),
            // GL returns rows from the bottom
            Api::WebGl2 => {
                pixels.chunks_exact(size[0].max(1) as usize).rev().flatten().copied().collect()
            }
        })
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        lock(&self.browser.shared.unused).push((self.api, self.id));
    }
}

fn text((file, entry): StageFile<'_>) -> Value {
    json!({ "file": file.name, "text": String::from_utf8_lossy(&file.bytes), "entry": entry })
}

fn describe(binding: u32, table: &Table, bytes: &[u8]) -> Value {
    json!({
        "binding": binding,
        "name": table.name,
        "format": table.format.name(),
        "width": table.width,
        "height": table.height,
        "layers": table.layers,
        "filtered": table.filtered,
        "bytes": bytes.len(),
    })
}

/// The texels' bytes to upload; an error if there are too few or too many for the table.
fn bytes(name: &str, table: &Table) -> Result<Vec<u8>> {
    let sides = [table.width, table.height, table.layers.max(1), table.format.channels()];
    if sides.into_iter().try_fold(1, usize::checked_mul) != Some(table.texels.len()) {
        let cause = format!(
            "table {}: has a wrong number of texels: {} numbers",
            table.name,
            table.texels.len()
        );
        return Err(Error::new(name, cause));
    }
    Ok(table.bytes())
}

/// The bindings for WebGPU and the names for WebGL2 by which the page finds the uniform block and the tables.
fn resources(
    job: &mut Value,
    name: &str,
    api: Api,
    stages: [StageFile<'_>; 2],
    tables: &[BoundTable<'_>],
) -> Result<()> {
    let (mut textures, mut blocks) = (Vec::new(), Vec::new());
    let both = stages.map(|(file, _)| file);
    for (file, binding) in both.iter().flat_map(|file| file.bindings.iter().map(move |b| (file, b)))
    {
        let emitted = &binding.emitted_name;
        let entry = json!({ "name": emitted, "file": file.name, "unit": binding.binding });
        match binding.kind {
            BindingKind::UniformBlock if binding.binding != PARAMS => {}
            BindingKind::UniformBlock => {
                job["block"] = json!(binding.binding);
                blocks.push(entry);
            }
            BindingKind::Texture => {
                // a WGSL file lists the tables of all its entry points; its compiler knows which ones this entry point reads
                if api == Api::WebGl2 && !tables.iter().any(|(at, _)| *at == binding.binding) {
                    return Err(failure(name, file, format!("has no table for {emitted}")));
                }
                textures.push(entry);
            }
            // in WebGL2 samplers are parameters of textures
            BindingKind::Sampler if binding.binding == SAMPLER => job["sampler"] = json!(SAMPLER),
            BindingKind::Sampler => {
                return Err(failure(name, file, format!("{emitted} is an unknown sampler")));
            }
        }
    }
    job["textures"] = Value::Array(textures);
    job["blocks"] = Value::Array(blocks);
    Ok(())
}

fn failure(name: &str, file: &EmittedFile, cause: String) -> Error {
    Error::new(name, format!("{}: {cause}", file.name))
}
