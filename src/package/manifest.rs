//! The manifests of a package as data.

mod describe;
mod interface;

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use crate::plan::{Container, Target, Variant};
use crate::shader::emit::{self, BindingName, EmittedFile, EntryPoint};
use crate::shader::limits::{Extent, Limits, Profile, fits};
use crate::shader::module::Module;
use crate::shader::template::GENERATED;
use crate::tables::Table;
use crate::tables::container::ContainerEntry;
use crate::variant::{
    Cost, DIRECTIONAL, ErrorBound, Form, Function, FunctionKind, LobeBounds, StatedError,
};

pub use describe::describe;
use interface::{bindings, uniforms, vertex_inputs};

/// Version of the manifests' layout.
pub const SCHEMA_VERSION: u32 = 1;

/// `manifest.json` of a variant on a surface.
#[derive(Clone, Debug, Serialize)]
pub struct VariantManifest {
    /// The generated-by line.
    pub generated_by: &'static str,
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Name of the surface.
    pub surface: String,
    /// Name of the variant.
    pub variant: String,
    /// The canonical configuration.
    pub configuration: Value,
    /// SHA-256 of the canonical configuration.
    pub configuration_hash: String,
    /// SHA-256 of everything that the files are made from: surface, configuration, tool version.
    pub input_hash: String,
    /// The contract of the core function.
    pub core: Core,
    /// The functions of lights with a size. Empty for variants that have only the core function.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub functions: Vec<LightEntry>,
    /// Files of every target.
    pub targets: BTreeMap<Target, Vec<FileEntry>>,
    /// Resources by their names in the templates.
    pub bindings: Vec<Binding>,
    /// Layout of the uniform blocks.
    pub uniforms: Vec<UniformBlock>,
    /// Attributes that the vertex stage of a mesh reads from buffers.
    pub vertex_inputs: Vec<VertexInput>,
    /// The tables, by binding.
    pub tables: Vec<TableEntry>,
    /// Rust file with bindings, uniforms and tables, in the same folder.
    pub rust_bindings: &'static str,
    /// What the variant requires.
    pub requires: Requires,
    /// Cost of one lit pixel.
    pub cost: Cost,
    /// A-priori bounds of the model's approximations. `None` where no error is claimed, or where only a comparison
    /// shows the error.
    pub error_bound: Option<ErrorBound>,
    /// What the surface returns of all light. `None` where its orders need more memory than the tool allows.
    pub energy: Option<Energy>,
    /// Bounds of the loops over lobes, for modes that have such loops.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lobes: Option<LobeBounds>,
}

/// What a surface returns of all light, by the exact sum over its orders.
#[derive(Clone, Debug, Serialize)]
pub struct Energy {
    /// Radiance under a sky of radiance 1, X, Y, Z relative to a white, towards viewers at 0, 30, 60 and 75 degrees from
    /// the normal, in the plane of normal and tangent.
    pub white_sky: [[f64; 3]; 4],
}

/// The contract of `diffraction(wi, wr)`.
#[derive(Clone, Debug, Serialize)]
pub struct Core {
    /// WGSL signature.
    pub function: String,
    /// Frame of the directions.
    pub frame: &'static str,
    /// Meaning of the directions.
    pub directions: &'static str,
    /// Primaries and transfer function of the result.
    pub colour_space: &'static str,
    /// Meaning of the value 1.
    pub unit: &'static str,
    /// Whether the result is clamped. Always false.
    pub clamped: bool,
    /// Radiance relative to a white diffuser, per unit of the result. `None` where the unit is arbitrary.
    pub diffuser_scale: Option<f64>,
    /// Signature of the function that returns tristimulus values instead.
    pub tristimulus_function: String,
    /// The last argument of all functions. `None` without patterns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<PatternEntry>,
}

/// The argument `pattern`, and what it may be.
#[derive(Clone, Debug, Serialize)]
pub struct PatternEntry {
    /// Meaning of its four numbers.
    pub argument: &'static str,
    /// Least and greatest period ratio that the tables reach.
    pub period_ratio: [f64; 2],
    /// The same of the depth ratio.
    pub depth_ratio: [f64; 2],
}

/// The contract of a function of lights with a size. Frame and colour space are those of the core function.
#[derive(Clone, Debug, Serialize)]
pub struct LightEntry {
    /// Name.
    pub name: &'static str,
    /// WGSL signature.
    pub function: String,
    /// Signature of the function that returns tristimulus values instead.
    pub tristimulus_function: String,
    /// Signatures of functions that belong to it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further: Vec<String>,
    /// Meaning of the arguments.
    pub arguments: &'static str,
    /// Meaning of the value 1.
    pub unit: &'static str,
    /// Whether the result is clamped. Always false.
    pub clamped: bool,
    /// Functions that the engine must supply.
    pub host: Vec<&'static str>,
    /// Cost of one lit pixel: mean over viewers under a disc of 5° in radius or a rectangle of 24 × 10°, maximum under the widest
    /// light.
    pub cost: Cost,
    /// Errors that it promises.
    pub errors: Vec<StatedError>,
}

/// One file of a target.
#[derive(Clone, Debug, Serialize)]
pub struct FileEntry {
    /// File name beside the manifest.
    pub file: String,
    /// Entry points in it.
    pub entry_points: Vec<EntryPoint>,
    /// Functions that a function form offers. Empty for whole shaders.
    pub functions: Vec<emit::Function>,
    /// Names in the file of the resources that it reads.
    pub bindings: Vec<BindingName>,
}

/// A resource of the shader.
#[derive(Clone, Debug, Serialize)]
pub struct Binding {
    /// Name in the templates.
    pub name: String,
    /// Bind group.
    pub group: u32,
    /// Binding.
    pub binding: u32,
    /// `uniform`, `texture` or `sampler`.
    pub kind: &'static str,
    /// For textures: `2d` or `2d-array`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dimension: Option<&'static str>,
    /// For textures: `unfilterable-float` if read with `textureLoad` only, `float` if read through the sampler.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_type: Option<&'static str>,
    /// For samplers: `linear` interpolation between texels, at level 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter: Option<&'static str>,
    /// For samplers: `clamp-to-edge` on both axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<&'static str>,
    /// For textures that a table fills: WebGPU's name of the texel format.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<&'static str>,
    /// What fills the binding.
    pub source: String,
}

/// An attribute of the vertices of `mesh_vert`.
#[derive(Clone, Debug, Serialize)]
pub struct VertexInput {
    /// Name in the templates.
    pub name: String,
    /// Location. In HLSL it is the semantic `LOC` with this number, in Metal the attribute.
    pub location: u32,
    /// WGSL type.
    #[serde(rename = "type")]
    pub ty: &'static str,
    /// WebGPU's name of the format.
    pub format: &'static str,
    /// What it holds.
    pub meaning: &'static str,
}

/// A uniform block. Its members are `vec4` and `mat4x4` only, so its layout is compatible with std140.
#[derive(Clone, Debug, Serialize)]
pub struct UniformBlock {
    /// Name of the variable in the templates.
    pub name: String,
    /// Name of the structure.
    pub structure: String,
    /// Bytes.
    pub size: u32,
    /// Members in order.
    pub members: Vec<UniformMember>,
}

/// A member of a uniform block.
#[derive(Clone, Debug, Serialize)]
pub struct UniformMember {
    /// Name.
    pub name: String,
    /// Offset, bytes.
    pub offset: u32,
    /// WGSL type.
    #[serde(rename = "type")]
    pub ty: &'static str,
    /// What it holds.
    pub meaning: &'static str,
}

/// Where a table is stored.
#[derive(Clone, Debug, Serialize)]
pub struct TableEntry {
    /// Name of the binding.
    pub binding: &'static str,
    /// Identity of the table.
    pub id: String,
    /// Path of the description, relative to the manifest's folder.
    pub description: String,
    /// Path of the texels, relative to the manifest's folder.
    pub data: String,
}

/// The description beside a `.bin` file.
#[derive(Clone, Debug, Serialize)]
pub struct TableDescription {
    /// The generated-by line.
    pub generated_by: &'static str,
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Identity: a hash of everything that the table is made from.
    pub id: String,
    /// File of the texels.
    pub data: String,
    /// Size of that file in bytes.
    pub bytes: usize,
    /// WebGPU's name of the texel format.
    pub format: &'static str,
    /// Byte order of numbers.
    pub endianness: &'static str,
    /// `2d` or `2d-array`.
    pub dimension: &'static str,
    /// Texels along x.
    pub width: usize,
    /// Texels along y.
    pub height: usize,
    /// Array layers; 1 for a plain texture.
    pub layers: usize,
    /// Order of the texels.
    pub order: &'static str,
    /// Meaning of the channels.
    pub channels: Vec<String>,
    /// Meaning of columns, rows and layers.
    pub axes: BTreeMap<&'static str, String>,
    /// Factor that the stored numbers are to be multiplied by.
    pub scale: f64,
    /// One factor for each term, where terms have scales of their own. The shader applies them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub term_scales: Vec<f64>,
    /// Address mode outside the texture. Shaders never read there.
    pub wrap: &'static str,
    /// The same texels in the containers that the plan asks for.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub containers: BTreeMap<Container, ContainerEntry>,
}

/// What a variant requires.
#[derive(Clone, Debug, Serialize)]
pub struct Requires {
    /// Profiles whose guaranteed limits suffice.
    pub profiles: Vec<&'static str>,
    /// Reason for each profile that the variant does not fit.
    pub gaps: BTreeMap<&'static str, String>,
    /// Optional features. Always empty.
    pub features: Vec<String>,
}

/// Parts of a manifest that are known before the shader's files are emitted.
pub struct Described<'a> {
    /// Name of the surface.
    pub surface: &'a str,
    /// The variant.
    pub variant: &'a Variant,
    /// How it computes on the surface.
    pub form: &'a Form,
    /// Its tables, without texels, and their entries.
    pub tables: Vec<(&'a Table, TableEntry)>,
    /// Hash of all inputs.
    pub input_hash: String,
    /// What the surface returns of all light.
    pub energy: Option<Energy>,
}

/// Writes the manifest of a variant from its module's reflection and its emitted files.
pub fn manifest(subject: Described<'_>, module: &Module, files: &[EmittedFile]) -> VariantManifest {
    let Described { surface, variant, form, tables, input_hash, energy } = subject;
    let mut targets: BTreeMap<Target, Vec<FileEntry>> = BTreeMap::new();
    for file in files {
        let entry = FileEntry {
            file: file.name.clone(),
            entry_points: file.entry_points.clone(),
            functions: file.functions.clone(),
            bindings: file.bindings.clone(),
        };
        targets.entry(file.target).or_default().push(entry);
    }
    let extents: Vec<Extent> = tables.iter().map(|(table, _)| extent(table)).collect();
    VariantManifest {
        generated_by: GENERATED,
        schema_version: SCHEMA_VERSION,
        surface: surface.to_owned(),
        variant: variant.name.clone(),
        configuration: serde_json::from_str(&variant.canonical()).unwrap_or(Value::Null),
        configuration_hash: variant.hash(),
        input_hash,
        core: core(&DIRECTIONAL, variant, form),
        functions: light_entries(form),
        targets,
        bindings: bindings(module, &tables),
        uniforms: uniforms(module),
        vertex_inputs: vertex_inputs(module),
        rust_bindings: "bindings.rs",
        requires: requires(&extents),
        cost: DIRECTIONAL.cost(form),
        error_bound: form.error_bound(),
        energy,
        lobes: form.lobe_bounds(),
        tables: tables.into_iter().map(|(_, entry)| entry).collect(),
    }
}

fn light_entries(form: &Form) -> Vec<LightEntry> {
    let functions = form.functions();
    let lights = functions.into_iter().filter(|f| f.kind() != FunctionKind::Direction);
    let entry = |function: &dyn Function| LightEntry {
        name: function.name(),
        function: declared(form, function.name(), function.signature()),
        tristimulus_function: declared(
            form,
            function.tristimulus_name(),
            function.tristimulus_signature(),
        ),
        further: function.further(Some(form)).iter().map(|(n, s)| declared(form, n, s)).collect(),
        arguments: function.arguments(),
        unit: function.unit(form),
        clamped: false,
        host: function.host().into_iter().collect(),
        cost: function.cost(form),
        errors: function.errors(form),
    };
    lights.map(entry).collect()
}

/// The function that has no pattern.
const LIGHT_OF_A_COLOUR: &str = "diffraction_light";

/// The WGSL declaration of a function.
fn declared(form: &Form, name: &str, signature: &str) -> String {
    match signature.split_once(") ->") {
        // light of a colour is the same on all texels
        Some((arguments, result)) if form.has_pattern() && name != LIGHT_OF_A_COLOUR => {
            format!("fn {name}{arguments}, pattern: vec4f) ->{result}")
        }
        _ => format!("fn {name}{signature}"),
    }
}

fn core(function: &dyn Function, variant: &Variant, form: &Form) -> Core {
    let optics = &variant.optics;
    Core {
        function: declared(form, function.name(), function.signature()),
        frame: "tangent frame: x along the tangent, y along the bitangent, z along the normal; right-handed",
        directions: function.arguments(),
        colour_space: form.colour_space(optics.colour),
        unit: function.unit(form),
        clamped: false,
        diffuser_scale: form.diffuser_scale(optics),
        tristimulus_function: declared(
            form,
            function.tristimulus_name(),
            function.tristimulus_signature(),
        ),
        pattern: variant.pattern.then_some(PatternEntry {
            argument: "cosine and sine of the angle by which the relief is turned, from the tangent towards the bitangent; its period and its depth relative to those of the surface",
            period_ratio: variant.period_ratio,
            depth_ratio: variant.depth_ratio,
        }),
    }
}

/// The texture that holds a table.
pub fn extent(table: &Table) -> Extent {
    let (width, height) = (table.width as u32, table.height as u32);
    match table.layers as u32 {
        0 => Extent::Plane { width, height },
        layers => Extent::Layers { width, height, layers },
    }
}

fn requires(extents: &[Extent]) -> Requires {
    let fitting = fits(extents);
    let reason = |limits: Limits| {
        let misfits = extents.iter().filter(|extent| !limits.allow(**extent));
        let misfits: Vec<String> = misfits.map(Extent::to_string).collect();
        format!(
            "a table of {} exceeds the limit of {} texels per side or {} layers",
            misfits.join(", "),
            limits.texture_2d,
            limits.array_layers
        )
    };
    let missing = Profile::ALL.into_iter().filter(|p| !fitting.contains(p));
    Requires {
        profiles: fitting.iter().map(|p| p.name()).collect(),
        gaps: missing.map(|p| (p.name(), reason(p.limits()))).collect(),
        features: Vec::new(),
    }
}
