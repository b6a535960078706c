//! WGSL: the specialised text itself, with its comments.

use crate::error::Result;
use crate::plan::Target;
use crate::shader::module::Module;

use super::{EmittedFile, EntryPoint, bindings};

/// One file with all entry points.
pub fn emit(module: &Module) -> Result<Vec<EmittedFile>> {
    let entry_points = module.entry_points().map(|(name, stage)| EntryPoint {
        stage,
        source_name: name.to_owned(),
        emitted_name: name.to_owned(),
    });
    Ok(vec![EmittedFile {
        name: "diffraction.wgsl".to_owned(),
        target: Target::Wgsl,
        bytes: module.text().as_bytes().to_vec(),
        entry_points: entry_points.collect(),
        bindings: bindings(module.ir()).into_iter().map(|(_, binding)| binding).collect(),
        functions: Vec::new(),
    }])
}
