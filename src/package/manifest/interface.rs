//! The inputs of a shader, by reflection: resources, uniform blocks, vertex attributes.

use naga::{
    AddressSpace, Binding as Place, ImageClass, ImageDimension, Scalar, TypeInner, VectorSize,
};

use crate::shader::module::Module;
use crate::tables::Table;

use super::{Binding, TableEntry, UniformBlock, UniformMember, VertexInput};

/// Name of the vertex stage whose attributes come from buffers.
const MESH_VERTEX: &str = "mesh_vert";

/// The resources of a module, with the tables that fill them.
pub(super) fn bindings(module: &Module, tables: &[(&Table, TableEntry)]) -> Vec<Binding> {
    let ir = module.ir();
    let mut all: Vec<Binding> = ir
        .global_variables
        .iter()
        .filter_map(|(_, variable)| {
            let (resource, name) = (variable.binding.as_ref()?, variable.name.clone()?);
            let table = tables.iter().find(|(table, _)| table.name == name);
            let (kind, dimension, sample_type) = match ir.types[variable.ty].inner {
                TypeInner::Image { dim, arrayed, class: ImageClass::Sampled { .. } } => {
                    let dimension = if arrayed {
                        "2d-array"
                    } else if dim == ImageDimension::D3 {
                        "3d"
                    } else {
                        "2d"
                    };
                    let filtered = table.is_some_and(|(table, _)| table.filtered);
                    let sample_type = if filtered { "float" } else { "unfilterable-float" };
                    ("texture", Some(dimension), Some(sample_type))
                }
                TypeInner::Sampler { .. } => ("sampler", None, None),
                _ => ("uniform", None, None),
            };
            let source = match table {
                Some((_, entry)) => format!("table {}", entry.id),
                None if kind == "sampler" => {
                    "samples the textures of sample type `float`; in APIs without separate samplers, these are the parameters of those textures".to_owned()
                }
                None => source(&name).to_owned(),
            };
            let format = table.map(|(table, _)| table.format.name());
            let sampler = kind == "sampler";
            Some(Binding {
                name,
                group: resource.group,
                binding: resource.binding,
                kind,
                dimension,
                sample_type,
                filter: sampler.then_some("linear"),
                address: sampler.then_some("clamp-to-edge"),
                format,
                source,
            })
        })
        .collect();
    all.sort_by_key(|b| (b.group, b.binding));
    all
}

/// What fills a resource that no table of the package fills.
fn source(name: &str) -> &'static str {
    match name {
        "params" => "see `uniforms`; used by `map` and `probe` only",
        "directions" => {
            "rgba32float; rows of arguments for each row of the picture, see the comment in the text; used by `probe` only"
        }
        "mesh_params" => "see `uniforms`; used by `mesh_vert` and `mesh` only",
        "orientation_map" => {
            "any float format; r: angle in radians from the tangent towards the bitangent, added to the angle of the vertices; the map repeats; without a map, bind one texel of 0; used by `mesh` only"
        }
        _ => "the engine",
    }
}

/// The uniform blocks of a module.
pub(super) fn uniforms(module: &Module) -> Vec<UniformBlock> {
    let ir = module.ir();
    let block = |variable: &naga::GlobalVariable| {
        let ty = &ir.types[variable.ty];
        let TypeInner::Struct { members, span } = &ty.inner else { return None };
        let name = variable.name.clone()?;
        let members = members.iter().map(|m| UniformMember {
            offset: m.offset,
            ty: type_name(&ir.types[m.ty].inner),
            meaning: meaning(&name, m.name.as_deref().unwrap_or_default()),
            name: m.name.clone().unwrap_or_default(),
        });
        let members = members.collect();
        Some(UniformBlock { name, structure: ty.name.clone()?, size: *span, members })
    };
    let uniform = ir.global_variables.iter().filter(|(_, v)| v.space == AddressSpace::Uniform);
    uniform.filter_map(|(_, v)| block(v)).collect()
}

/// The attributes of [`MESH_VERTEX`]. Empty if the shader does not have this stage.
pub(super) fn vertex_inputs(module: &Module) -> Vec<VertexInput> {
    let ir = module.ir();
    let entry = ir.entry_points.iter().find(|entry| entry.name == MESH_VERTEX);
    let arguments = entry.into_iter().flat_map(|entry| &entry.function.arguments);
    let input = |argument: &naga::FunctionArgument| {
        let Some(Place::Location { location, .. }) = argument.binding else { return None };
        let name = argument.name.clone()?;
        let inner = &ir.types[argument.ty].inner;
        let meaning = meaning(MESH_VERTEX, &name);
        Some(VertexInput { name, location, ty: type_name(inner), format: format(inner), meaning })
    };
    arguments.filter_map(input).collect()
}

/// Meaning of a member of a uniform block or of an attribute of a vertex stage.
fn meaning(of: &str, name: &str) -> &'static str {
    match (of, name) {
        ("params", "light") => "xyz: unit direction to the light, for `map`; w: unused",
        ("params", "size") => "xy: size of the picture in pixels; zw: unused",
        ("mesh_params", "model") => {
            "matrix from the mesh to the world, column by column; it may scale unevenly and mirror"
        }
        ("mesh_params", "view") => "matrix from the world to the camera, column by column",
        ("mesh_params", "projection") => {
            "matrix from the camera to the clip space of the API, column by column"
        }
        ("mesh_params", "light_direction") => {
            "xyz: direction to the light in the world, any length; w: unused"
        }
        ("mesh_params", "eye") => "xyz: position of the viewer in the world; w: unused",
        (MESH_VERTEX, "position") => "position in the mesh",
        (MESH_VERTEX, "normal") => "unit normal",
        (MESH_VERTEX, "tangent") => {
            "xyz: unit tangent; w: handedness, the bitangent is w (normal × tangent), as in MikkTSpace and glTF"
        }
        (MESH_VERTEX, "uv") => "texture coordinates; (0, 0) is the corner of the first texel",
        (MESH_VERTEX, "orientation_angle") => {
            "angle of the orientation field in radians, from the tangent towards the bitangent"
        }
        _ => "",
    }
}

/// WGSL's name of a type of an interface.
fn type_name(inner: &TypeInner) -> &'static str {
    match *inner {
        TypeInner::Scalar(Scalar::F32) => "f32",
        TypeInner::Vector { size: VectorSize::Bi, scalar: Scalar::F32 } => "vec2f",
        TypeInner::Vector { size: VectorSize::Tri, scalar: Scalar::F32 } => "vec3f",
        TypeInner::Vector { size: VectorSize::Quad, scalar: Scalar::F32 } => "vec4f",
        TypeInner::Vector { size: VectorSize::Quad, scalar: Scalar::I32 } => "vec4i",
        TypeInner::Vector { size: VectorSize::Quad, scalar: Scalar::U32 } => "vec4u",
        TypeInner::Matrix {
            columns: VectorSize::Quad,
            rows: VectorSize::Quad,
            scalar: Scalar::F32,
        } => "mat4x4f",
        _ => "",
    }
}

/// WebGPU's name of the vertex format of a type.
fn format(inner: &TypeInner) -> &'static str {
    match type_name(inner) {
        "f32" => "float32",
        "vec2f" => "float32x2",
        "vec3f" => "float32x3",
        "vec4f" => "float32x4",
        _ => "",
    }
}
