//! Rules about entry points and resources.

use naga::{
    AddressSpace, Handle, ImageClass, ResourceBinding, ScalarKind, Span, Type, TypeInner,
    VectorSize,
};

use crate::diagnostic::Diagnostic;
use crate::shader::limits::Limits;
use crate::tables::SAMPLER;

use super::{super::Stage, Linted};

/// Every entry point of the contract exists, and all are vertex or fragment shaders.
pub fn entry_points(subject: &Linted) -> Vec<Diagnostic> {
    let locator = subject.locator;
    let mut found = Vec::new();
    for (name, stage) in &subject.contract.entry_points {
        let present = subject.ir.entry_points.iter().find(|entry| entry.name == *name);
        let stage_name = match stage {
            Stage::Vertex => "vertex",
            Stage::Fragment => "fragment",
        };
        match present {
            None => {
                let message = format!("there is no {stage_name} entry point `{name}`");
                found.push(locator.diagnostic(message, Span::new(0, 1)));
            }
            Some(entry) if Stage::from_naga(entry.stage) != Some(*stage) => {
                let message = format!("entry point `{name}` is not a {stage_name} shader");
                found.push(locator.diagnostic(message, locator.word(name)));
            }
            Some(_) => {}
        }
    }
    for entry in subject.ir.entry_points.iter().filter(|e| Stage::from_naga(e.stage).is_none()) {
        let name = &entry.name;
        let message = format!("entry point `{name}` is neither a vertex nor a fragment shader");
        found.push(locator.diagnostic(message, locator.word(name)));
    }
    found
}

/// Binding of the sampler in runners and manifests.
const SAMPLER_PLACE: ResourceBinding = ResourceBinding { group: 0, binding: SAMPLER };

/// Only uniform blocks, sampled textures and declared samplers may be bound.
pub fn resources(subject: &Linted) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for (handle, global) in subject.ir.global_variables.iter() {
        let name = global.name.as_deref().unwrap_or_default();
        let what = match (global.space, &subject.ir.types[global.ty].inner) {
            (AddressSpace::Storage { .. }, _) => "storage buffer",
            (_, TypeInner::Image { class: ImageClass::Storage { .. }, .. }) => "storage texture",
            (_, TypeInner::Sampler { .. }) if !subject.contract.samplers.contains(name) => {
                "sampler that is not declared"
            }
            (_, TypeInner::Sampler { comparison: true }) => "comparison sampler",
            (_, TypeInner::Sampler { .. }) if global.binding != Some(SAMPLER_PLACE) => {
                "sampler that is not at binding 5 of group 0"
            }
            _ => continue,
        };
        let span = subject.ir.global_variables.get_span(handle);
        found.push(subject.locator.diagnostic(format!("`{name}` is a {what}"), span));
    }
    found
}

/// No stage reads more textures than every API guarantees.
pub fn texture_count(subject: &Linted) -> Vec<Diagnostic> {
    let limit = Limits::common().textures_per_stage as usize;
    let is_texture = |ty: Handle<Type>| match subject.ir.types[ty].inner {
        TypeInner::Image { class, .. } => !matches!(class, ImageClass::Storage { .. }),
        _ => false,
    };
    let mut found = Vec::new();
    for (index, entry) in subject.ir.entry_points.iter().enumerate() {
        let info = subject.info.get_entry_point(index);
        let globals = subject.ir.global_variables.iter();
        let count = globals.filter(|(h, g)| is_texture(g.ty) && !info[*h].is_empty()).count();
        if count > limit {
            let name = &entry.name;
            let message =
                format!("entry point `{name}` reads {count} textures, above the limit of {limit}");
            found.push(subject.locator.diagnostic(message, subject.locator.word(name)));
        }
    }
    found
}

/// Size, number and members of the uniform blocks.
pub fn uniform_layout(subject: &Linted) -> Vec<Diagnostic> {
    let limits = Limits::common();
    let mut found = Vec::new();
    let globals = subject.ir.global_variables.iter();
    for (index, (handle, global)) in
        globals.filter(|(_, global)| global.space == AddressSpace::Uniform).enumerate()
    {
        let name = global.name.as_deref().unwrap_or_default();
        let inner = &subject.ir.types[global.ty].inner;
        let span = subject.ir.global_variables.get_span(handle);
        let size = inner.size(subject.ir.to_ctx());
        if size > limits.uniform_block {
            let limit = limits.uniform_block;
            let message =
                format!("uniform block `{name}` has {size} bytes, above the limit of {limit}");
            found.push(subject.locator.diagnostic(message, span));
        }
        if index >= limits.uniform_blocks as usize {
            let limit = limits.uniform_blocks;
            let message = format!(
                "uniform block `{name}` is number {}, above the limit of {limit} blocks",
                index + 1
            );
            found.push(subject.locator.diagnostic(message, span));
        }
        let members: Vec<(&str, Handle<Type>)> = match inner {
            TypeInner::Struct { members, .. } => {
                members.iter().map(|m| (m.name.as_deref().unwrap_or_default(), m.ty)).collect()
            }
            _ => vec![(name, global.ty)],
        };
        for (member, _) in members.into_iter().filter(|(_, ty)| !whole_rows(subject, *ty)) {
            let message =
                format!("`{member}` of uniform block `{name}` is neither vec4 nor mat4x4");
            found.push(subject.locator.diagnostic(message, subject.locator.word(member)));
        }
    }
    found
}

/// `vec4` of 32-bit numbers, `mat4x4f`, or an array of those.
fn whole_rows(subject: &Linted, ty: Handle<Type>) -> bool {
    match subject.ir.types[ty].inner {
        TypeInner::Vector { size: VectorSize::Quad, scalar } => {
            scalar.width == 4 && scalar.kind != ScalarKind::Bool
        }
        TypeInner::Matrix { columns: VectorSize::Quad, rows: VectorSize::Quad, scalar } => {
            scalar.width == 4
        }
        TypeInner::Array { base, .. } => whole_rows(subject, base),
        _ => false,
    }
}
