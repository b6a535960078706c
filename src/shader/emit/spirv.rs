//! SPIR-V 1.0, one module per entry point.

use naga::back::spv;

use crate::error::Result;
use crate::plan::Target;
use crate::shader::module::{Module, Stage};

use super::{EmittedFile, EntryPoint, UNCHECKED, bindings, failure, file_name, singles};

/// Descriptor sets and bindings are as in the templates. Names are kept as debug names.
pub fn emit(module: &Module) -> Result<Vec<EmittedFile>> {
    let globals = module.ir().global_variables.iter();
    let places = globals.filter_map(|(_, global)| {
        let place = global.binding?;
        let info = spv::BindingInfo {
            descriptor_set: place.group,
            binding: place.binding,
            binding_array_size: None,
        };
        Some((place, info))
    });
    let options = spv::Options {
        lang_version: (1, 0),
        // set explicitly, because the default differs between debug and release builds
        flags: spv::WriterFlags::DEBUG | spv::WriterFlags::LABEL_VARYINGS,
        fake_missing_bindings: false,
        binding_map: places.collect(),
        capabilities: None,
        bounds_check_policies: UNCHECKED,
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        ray_query_initialization_tracking: false,
        trace_ray_argument_validation: false,
        use_storage_input_output_16: false,
        // off, because it would contain the path of a file
        debug_info: None,
        task_dispatch_limits: None,
        mesh_shader_primitive_indices_clamp: false,
        // division by zero stays defined as in WGSL; for constant divisors compilers remove the check
        emit_int_div_checks: true,
    };
    let mut files = Vec::new();
    for single in singles(module, Target::Spirv)? {
        let pipeline = spv::PipelineOptions {
            shader_stage: single.stage.to_naga(),
            entry_point: single.name.clone(),
        };
        let words = spv::write_vec(&single.ir, &single.info, &options, Some(&pipeline))
            .map_err(|error| failure(module, Target::Spirv, error))?;
        let suffix = match single.stage {
            Stage::Vertex => "vert.spv",
            Stage::Fragment => "frag.spv",
        };
        files.push(EmittedFile {
            name: file_name(&single.name, suffix),
            target: Target::Spirv,
            bytes: words.into_iter().flat_map(u32::to_le_bytes).collect(),
            bindings: bindings(&single.ir).into_iter().map(|(_, binding)| binding).collect(),
            entry_points: vec![EntryPoint {
                stage: single.stage,
                source_name: single.name.clone(),
                emitted_name: single.name,
            }],
            functions: Vec::new(),
        });
    }
    Ok(files)
}
