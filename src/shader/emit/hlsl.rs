//! HLSL, shader model 5.1, with all entry points in one file.

use naga::{TypeInner, back::hlsl};

use crate::error::Result;
use crate::plan::Target;
use crate::shader::module::Module;

use super::{EmittedFile, bindings, entry_points, failure, head, resolved};

mod sampler;

/// Binding `B` is register `bB`, `tB` or `sB`. Numbers are unique over all kinds, so that compilers from HLSL to
/// Vulkan, where all kinds share one set of numbers, need no shifts. A group other than 0 is a register space.
pub fn emit(module: &Module) -> Result<Vec<EmittedFile>> {
    let (ir, info) = resolved(module, Target::Hlsl, None)?;
    let fail = |cause: String| failure(module, Target::Hlsl, cause);
    let (text, entries) = write(&ir, &info, places(&ir)).map_err(fail)?;
    let text = sampler::plain(&text, &ir, true).map_err(fail)?;
    Ok(vec![EmittedFile {
        name: "diffraction.hlsl".to_owned(),
        target: Target::Hlsl,
        bytes: with_head(module, &text).into_bytes(),
        entry_points: entry_points(module, entries).map_err(fail)?,
        bindings: bindings(&ir).into_iter().map(|(_, binding)| binding).collect(),
        functions: Vec::new(),
    }])
}

/// The text, and for every entry point its name or the reason why it is missing.
pub fn write(
    ir: &naga::Module,
    info: &naga::valid::ModuleInfo,
    binding_map: hlsl::BindingMap,
) -> Result<(String, Vec<Result<String, String>>), String> {
    let options = hlsl::Options {
        shader_model: hlsl::ShaderModel::V5_1,
        binding_map,
        // a binding without a register must be an error; naga must not choose one
        fake_missing_bindings: false,
        sampler_buffer_binding_map: sampler::index_buffers(ir),
        special_constants_binding: None,
        zero_initialize_workgroup_memory: false,
        restrict_indexing: false,
        force_loop_bounding: false,
        ray_query_initialization_tracking: false,
        mesh_shader_primitive_indices_clamp: false,
        ..hlsl::Options::default()
    };
    let pipeline = hlsl::PipelineOptions { entry_point: None };
    let mut text = String::new();
    let reflection = hlsl::Writer::new(&mut text, &options, &pipeline)
        .write(ir, info, None)
        .map_err(|error| error.to_string())?;
    let names = reflection.entry_point_names.into_iter();
    Ok((text, names.map(|name| name.map_err(|error| error.to_string())).collect()))
}

/// The text with the comment that describes it above.
pub fn with_head(module: &Module, text: &str) -> String {
    format!("{}\n\n{}\n", head::bare(module), text.trim())
}

/// The text of functions without registers.
pub fn write_unbound(ir: &naga::Module, info: &naga::valid::ModuleInfo) -> Result<String, String> {
    let samplers = ir
        .global_variables
        .iter()
        .filter(|(_, global)| matches!(ir.types[global.ty].inner, TypeInner::Sampler { .. }));
    let places =
        samplers.filter_map(|(_, global)| Some((global.binding?, hlsl::BindTarget::default())));
    let (text, _) = write(ir, info, places.collect())?;
    sampler::plain(&text, ir, false)
}

fn places(ir: &naga::Module) -> hlsl::BindingMap {
    let globals = ir.global_variables.iter();
    let places = globals.filter_map(|(_, global)| {
        let place = global.binding?;
        let target = hlsl::BindTarget {
            space: u8::try_from(place.group).ok()?,
            register: place.binding,
            ..hlsl::BindTarget::default()
        };
        Some((place, target))
    });
    places.collect()
}
