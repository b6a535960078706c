//! Metal Shading Language 2.0, with all entry points in one file.

use naga::{AddressSpace, TypeInner, back::msl};

use crate::error::Result;
use crate::plan::Target;
use crate::shader::module::{Module, Stage};

use super::{EmittedFile, UNCHECKED, bindings, entry_points, failure, hlsl, resolved};

/// Binding `b` of group 0 is slot `buffer(b)`, `texture(b)` or `sampler(b)` of every entry point that reads it.
pub fn emit(module: &Module) -> Result<Vec<EmittedFile>> {
    let (ir, info) = resolved(module, Target::Msl, None)?;
    let fail = |cause: String| failure(module, Target::Msl, cause);
    let resources = msl::EntryPointResources { resources: slots(&ir), ..Default::default() };
    let names = module.entry_points().map(|(name, _): (&str, Stage)| name.to_owned());
    let options = msl::Options {
        lang_version: (2, 0),
        per_entry_point_map: names.map(|name| (name, resources.clone())).collect(),
        inline_samplers: Vec::new(),
        spirv_cross_compatibility: false,
        // an entry point whose binding has no slot must be an error; naga must not choose one
        fake_missing_bindings: false,
        bounds_check_policies: UNCHECKED,
        zero_initialize_workgroup_memory: false,
        force_loop_bounding: false,
        task_dispatch_limits: None,
        mesh_shader_primitive_indices_clamp: false,
        emit_int_div_checks: true,
        ray_query_initialization_tracking: false,
    };
    let (text, reflection) =
        msl::write_string(&ir, &info, &options, &msl::PipelineOptions::default())
            .map_err(|error| fail(error.to_string()))?;
    let entries = reflection.entry_point_names.into_iter();
    let entries = entries.map(|name| name.map_err(|error| error.to_string()));
    Ok(vec![EmittedFile {
        name: "diffraction.metal".to_owned(),
        target: Target::Msl,
        bytes: hlsl::with_head(module, &text).into_bytes(),
        entry_points: entry_points(module, entries).map_err(fail)?,
        bindings: bindings(&ir).into_iter().map(|(_, binding)| binding).collect(),
        functions: Vec::new(),
    }])
}

/// The slots of bindings. Metal does not have groups, so only group 0 has slots.
fn slots(ir: &naga::Module) -> msl::BindingMap {
    let globals = ir.global_variables.iter();
    let slots = globals.filter_map(|(_, global)| {
        let place = global.binding.filter(|place| place.group == 0)?;
        let slot = u8::try_from(place.binding).ok()?;
        let target = match (global.space, &ir.types[global.ty].inner) {
            (AddressSpace::Uniform, _) => {
                msl::BindTarget { buffer: Some(slot), ..Default::default() }
            }
            (_, TypeInner::Sampler { .. }) => msl::BindTarget {
                sampler: Some(msl::BindSamplerTarget::Resource(slot)),
                ..Default::default()
            },
            _ => msl::BindTarget { texture: Some(slot), ..Default::default() },
        };
        Some((place, target))
    });
    slots.collect()
}
