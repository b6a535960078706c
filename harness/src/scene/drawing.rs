//! Draws a scene on a driver: a variant as the skin of a mesh, blended with the body's colour.
//!
//! The blending is the thesis's Algorithm 3.4 as intended: `(1 - w_d)·E/π·(s·ρ + (1 - R)·c·n·l) + w_d·c`, where `E` is the
//! irradiance perpendicular to a light, `ρ` the result of the package's shader, `s` its diffuser scale, `R` the Fresnel reflectance
//! and `c` the body's colour. (The thesis prints `1 - min(1, R/R0)` in place of `1 - R`. That is 0 everywhere, since no reflectance
//! is below the one at normal incidence.) Under a light with a size, the function for its kind stands for `E/π·s·ρ`, and the
//! irradiance of the surface for `E·n·l`.

mod truth;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::light::{Filtered, Light};
use diffraction_shaders::shader::template::{Argument, hand_on};
use diffraction_shaders::tables::{Table, environment_table};
use diffraction_shaders::variant::mesh::{MeshParams, OrientationMap};
use diffraction_shaders::variant::{FUNCTIONS, Form, FunctionKind};
use glam::{DMat3, DMat4, DVec3, Vec3};

use crate::drivers::gpu::{
    Colours, Gpu, MeshBuffers, MeshPass, MeshPipeline, MeshProgram, Targets, Texture,
    TextureFormat, TextureLayout,
};
use crate::drivers::{Prepared, dark, table_texture};
use crate::scene::Mesh;
use crate::scene::lights::{MAX_LIGHTS, refused};
use crate::scene::surroundings::{Surroundings, TABLE, filtered};

pub use truth::{Truth, truth, truth_under};

/// The WGSL that the harness appends to a variant's shader.
pub const SHADE: &str = include_str!("drawing/shade.wgsl");

/// Reflectance of a dielectric body.
const SCHLICK: &str = "
fn body_reflectance(cos_half: f32) -> f32 {
    let amplitude = (REFRACTIVE_INDEX - 1.0) / (REFRACTIVE_INDEX + 1.0);
    return amplitude * amplitude * fresnel_ratio(cos_half);
}
";

/// The surroundings of a fragment. The map has the frame of a file of lights: theta counts from the world's y, phi from x towards z.
const AROUND: &str = "
fn environment_radiance(direction: vec3f, spread: f32) -> vec3f {
    let world = vec3f(dot(direction, world_x), dot(direction, world_y), dot(direction, world_z));
    return MAP_FACTOR * map_radiance(world.xzy, spread);
}
";

/// What a disc of an irradiance diffracts where a variant has the function for white discs alone.
const WHITE_DISC: &str = "colour * diffraction_disc(axis, radius, wr)";

/// A single direction whose lobes have a variance, no less than that of the narrowest.
const LOBE: &str = "
fn lobe_of(wi: vec3f, wr: vec3f, variance: f32) -> vec3f {
    return diffraction_spread(wi, wr, sqrt(max(variance - LOBE_SIGMA * LOBE_SIGMA, 0.0)));
}
";

/// What a variant has in their place that cannot widen lobes.
const NO_FOOTPRINT: &str = "
fn footprint_spread(right: vec2f, down: vec2f, height: f32) -> f32 {
    return 0.0;
}
fn lobe_of(wi: vec3f, wr: vec3f, variance: f32) -> vec3f {
    return vec3f(0.0);
}
";

/// What a variant has in its place whose functions have no pattern.
const NO_PATTERN: &str = "
fn pattern_ratios(uv: vec2f) -> vec3f {
    return vec3f(1.0);
}
";

/// Bindings of the templates and of [`SHADE`].
const MESH_PARAMS: u32 = 8;
const ORIENTATION_MAP: u32 = 9;
const SHADE_BLOCK: u32 = 20;
const BODY_COLOUR: u32 = 21;
const BODY_SAMPLER: u32 = 22;
const WHITES: u32 = 23;
/// Numbers of the table of [`Surroundings`].
const WHITES_NUMBERS: usize = 4 * TABLE[0] * TABLE[1];
/// Corners of a polygon that the block has room for.
const CORNERS: usize = diffraction_shaders::light::MAX_CORNERS;
const SHADE_NUMBERS: usize = 8 + 4 * MAX_LIGHTS * (2 + 3 + CORNERS);
const PARAMS_NUMBERS: usize = 56;

const PICTURE: Targets = Targets { pictures: 1, multisampled: true };

/// What a pixel takes of the lobes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobes {
    /// Their value at the pixel's middle.
    Points,
    /// Lobes widened by the footprint of the pixel.
    Footprint,
    /// Nothing: a lobe of GGX stands in their place, for comparison.
    Ggx,
}

/// Lights and blending of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Lights in the world: at least one, and at most [`MAX_LIGHTS`] of each kind.
    pub lights: Vec<Light>,
    /// Weight `w_d` of the unlit texture, 0 to 1.
    pub texture_weight: f64,
    /// Radiance of the unlit texture where it is white.
    pub unlit: f64,
    /// Whether the relief diffracts. Without, the body's colour is drawn alone, under lights of any kind and colour.
    pub diffracts: bool,
}

impl Look {
    /// Lights alone.
    pub fn lit_by(lights: Vec<Light>) -> Look {
        Look { lights, texture_weight: 0.0, unlit: 1.0, diffracts: true }
    }
}

/// A linear picture, `[row][column]` from the top, sRGB primaries: radiance, where 1 is that of a white diffuser that faces a light of
/// irradiance π. Alpha is coverage.
#[derive(Clone, Debug, PartialEq)]
pub struct Hdr {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The texels.
    pub pixels: Vec<[f32; 4]>,
}

/// A variant on a mesh, compiled for one adapter.
pub struct Drawing<'a> {
    gpu: &'a Gpu,
    mesh: Mesh,
    buffers: MeshBuffers,
    pipeline: MeshPipeline,
    /// Its diffuser scale.
    scale: f64,
    variant: String,
    form: Form,
    /// Whether it has surroundings.
    is_around: bool,
}

impl<'a> Drawing<'a> {
    /// Compiles the shader. [`Lobes::Footprint`] needs the function of wider lobes. `around`: the skies and
    /// maps of all pictures, see [`filtered`].
    pub fn new(
        gpu: &'a Gpu,
        prepared: &Prepared<'_>,
        mesh: Mesh,
        lobes: Lobes,
        around: Option<&Filtered>,
    ) -> Result<Drawing<'a>> {
        let (variant, form) = (prepared.placement.variant, prepared.form.clone());
        let buffers = gpu.mesh(&mesh.vertices, &mesh.triangles)?;
        if lobes == Lobes::Footprint {
            check_widened(&variant.name, &form)?;
        }
        let scale = form.diffuser_scale(&variant.optics).ok_or_else(|| {
            let cause = "has no radiance scale, so it cannot be blended with a body";
            Error::new(&variant.name, cause)
        })?;
        let pipeline = pass(gpu, prepared, around, &mesh, lobes)?;
        let (variant, is_around) = (variant.name.clone(), around.is_some());
        Ok(Drawing { gpu, mesh, buffers, pipeline, scale, variant, form, is_around })
    }

    /// The drawn mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Draws a picture with four samples per pixel.
    pub fn draw(&self, params: &MeshParams, look: &Look, size: [u32; 2]) -> Result<Hdr> {
        match look.diffracts {
            true => check(&self.mesh.name, &self.variant, &self.form, &look.lights)?,
            false => check_counts(&self.mesh.name, &look.lights)?,
        }
        if look.diffracts && !self.is_around && look.lights.iter().any(Light::is_all_round) {
            let cause = "was prepared without the skies and maps of its lights";
            return Err(Error::new(&self.mesh.name, cause));
        }
        let (block, shade) = (params_bytes(params), shade_numbers(look, self.scale));
        let whites = whites(&look.lights);
        let blocks: [&[u8]; 3] =
            [&block, bytemuck::cast_slice(&shade), bytemuck::cast_slice(&whites)];
        let pass: MeshPass<'_> = (&self.pipeline, &blocks);
        let pictures = self.gpu.draw_mesh(&self.mesh.name, &self.buffers, pass, PICTURE, size)?;
        let [width, height] = size;
        Ok(Hdr { width, height, pixels: pictures.into_iter().flatten().collect() })
    }
}

/// Returns an error if the lobes of a form cannot be widened by the footprint of pixels.
pub fn check_widened(variant: &str, form: &Form) -> Result<()> {
    if form.functions().iter().any(|function| function.kind() == FunctionKind::Spread) {
        return Ok(());
    }
    let cause =
        "has no function for wider lobes, so they cannot be widened by the footprint of pixels";
    Err(Error::new(variant, cause).remedy(
        "use mode = \"baked\" with coherence = \"ensemble\", coherence_scaling = \"wavelength\" and spread_levels = \"auto\", or --filter supersample",
    ))
}

/// Returns an error if lights cannot be drawn on a variant. `subject` names the picture.
fn check(subject: &str, variant: &str, form: &Form, lights: &[Light]) -> Result<()> {
    let refused = lights.iter().find_map(|light| refused(subject, variant, form, light));
    refused.map_or_else(|| check_counts(subject, lights), Err)
}

/// Returns an error if a picture has no light, or too many. `subject` names the lights.
pub fn check_counts(subject: &str, lights: &[Light]) -> Result<()> {
    if lights.is_empty() {
        return Err(Error::new(subject, "has no light"));
    }
    for light in lights {
        let kind = light.kind();
        let count = lights.iter().filter(|other| other.kind() == kind).count();
        if count > MAX_LIGHTS {
            let cause = format!("has {count} lights of kind {kind:?}");
            let remedy = format!("a picture has at most {MAX_LIGHTS} of each kind");
            return Err(Error::new(subject, cause).remedy(remedy));
        }
    }
    Ok(())
}

/// The table of a white body under skies and maps; zeros without them.
fn whites(lights: &[Light]) -> Vec<f32> {
    Surroundings::new(lights).map_or_else(|| vec![0.0; WHITES_NUMBERS], |found| found.numbers())
}

/// The uniform block `Shade`. `scale`: diffuser scale.
fn shade_numbers(look: &Look, scale: f64) -> [f32; SHADE_NUMBERS] {
    let mut numbers = [0.0; SHADE_NUMBERS];
    let flag = |is_set: bool| f32::from(u8::from(is_set));
    let surrounded = look.lights.iter().any(Light::is_all_round);
    let (weight, unlit) = (look.texture_weight as f32, look.unlit as f32);
    numbers[..4].copy_from_slice(&[weight, scale as f32, unlit, flag(look.diffracts)]);
    let (counts, directions) = (4, 8);
    let discs = directions + 4 * MAX_LIGHTS;
    let powers = discs + 4 * MAX_LIGHTS;
    let corners = powers + 4 * 3 * MAX_LIGHTS;
    let mut next = [0; 3];
    let mut set = |at: usize, vector: DVec3, number: f64| {
        let vector = vector.as_vec3().extend(number as f32);
        numbers[at..at + 4].copy_from_slice(&vector.to_array());
    };
    for (light, colour) in look.lights.iter().map(Light::white) {
        let (kind, power, count) = match light {
            Light::Direction { direction, irradiance } => {
                set(directions + 4 * next[0], *direction, 0.0);
                (0, *irradiance, 0)
            }
            Light::Disc { cap, irradiance } => {
                set(discs + 4 * next[1], cap.axis, cap.radius_rad);
                (1, *irradiance, 0)
            }
            Light::Polygon { polygon, radiance } => {
                for (k, corner) in polygon.corners().iter().enumerate() {
                    set(corners + 4 * (CORNERS * next[2] + k), *corner, 0.0);
                }
                (2, *radiance, polygon.corners().len())
            }
            // these are in the table of a white body
            Light::Sky { .. } | Light::Environment(_) | Light::Coloured { .. } => continue,
        };
        set(powers + 4 * (MAX_LIGHTS * kind + next[kind]), power * colour, count as f64);
        next[kind] += 1;
    }
    set(counts, DVec3::from(next.map(|count| count as f64)), f64::from(flag(surrounded)));
    numbers
}

/// Draws by the package's own entry point `mesh`, with one sample per pixel: linear RGB of ρ; alpha is 0 outside the mesh.
pub fn relative_radiance(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
) -> Result<Vec<[f32; 4]>> {
    let module = prepared.module(prepared.spectrum.width)?;
    let around = around_table(prepared, None);
    let tables = textures(prepared, around.as_ref(), &mesh.orientation);
    let stage = Stage { wgsl: module.text(), entry: "mesh", pictures: 1, textures: tables };
    let pictures = single(gpu, prepared, mesh, params, size, stage, None)?;
    Ok(pictures.into_iter().flatten().collect())
}

/// Draws what the lights contribute, with one sample per pixel: linear RGB of the diffracted radiance, with alpha 0 outside the mesh,
/// and the radiance of a white body, which is that under all lights.
pub fn lit_parts(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    lights: &[Light],
    size: [u32; 2],
) -> Result<Vec<([f32; 4], Vec3)>> {
    let variant = prepared.placement.variant;
    check(&mesh.name, &variant.name, &prepared.form, lights)?;
    let scale = prepared.form.diffuser_scale(&variant.optics).unwrap_or_default();
    let shade = shade_numbers(&Look::lit_by(lights.to_vec()), scale);
    let around = around_table(prepared, filtered(lights).as_ref());
    let textures = textures(prepared, around.as_ref(), &mesh.orientation);
    let wgsl = &text(prepared, around.as_ref(), Lobes::Points)?;
    let stage = Stage { wgsl, entry: "scene_parts", pictures: 2, textures };
    let whites = whites(lights);
    let blocks = [bytemuck::cast_slice(&shade), bytemuck::cast_slice(&whites)];
    let pictures = single(gpu, prepared, mesh, params, size, stage, Some(blocks))?;
    let white = |texel: &[f32; 4]| vector(texel).as_vec3();
    Ok(pictures[0].iter().zip(&pictures[1]).map(|(g, w)| (*g, white(w))).collect())
}

/// What the entry point `mesh` uses in a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Used {
    /// The directions.
    pub directions: Directions,
    /// Distance of the point from the viewer.
    pub away: f64,
    /// Spread of the lobes; 0 without the function of wider lobes.
    pub spread: f64,
}

/// What the entry point `mesh` uses in each pixel; `None` outside the mesh.
pub fn directions(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
) -> Result<Vec<Option<Used>>> {
    let used = |wi: &[f32; 4], wr: &[f32; 4]| {
        let directions = Directions { wi: vector(wi), wr: vector(wr) };
        let (away, spread) = (f64::from(wi[3]), f64::from(wr[3]) - 1.0);
        (wr[3] > 0.0).then_some(Used { directions, away, spread })
    };
    let pictures = frames(gpu, prepared, mesh, params, size, "scene_directions")?;
    Ok(pictures[0].iter().zip(&pictures[1]).map(|(wi, wr)| used(wi, wr)).collect())
}

/// The matrix from the world to the frame that each pixel uses; meaningless outside the mesh.
fn axes(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
) -> Result<Vec<DMat3>> {
    let frame = |x: &[f32; 4], y: &[f32; 4]| {
        let (side, x, y) = (f64::from(x[3]), vector(x), vector(y));
        DMat3::from_cols(x, y, side * x.cross(y))
    };
    let pictures = frames(gpu, prepared, mesh, params, size, "scene_axes")?;
    Ok(pictures[0].iter().zip(&pictures[1]).map(|(x, y)| frame(x, y)).collect())
}

fn vector(texel: &[f32; 4]) -> DVec3 {
    Vec3::new(texel[0], texel[1], texel[2]).as_dvec3()
}

/// Draws an entry point with two pictures that needs no table.
fn frames(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
    entry: &str,
) -> Result<Vec<Vec<[f32; 4]>>> {
    let textures = vec![orientation_texture(&mesh.orientation)];
    let around = around_table(prepared, None);
    let stage = Stage {
        wgsl: &text(prepared, around.as_ref(), Lobes::Points)?,
        entry,
        pictures: 2,
        textures,
    };
    single(gpu, prepared, mesh, params, size, stage, None)
}

/// A fragment entry point: its text, its number of pictures, and what it reads.
struct Stage<'a> {
    wgsl: &'a str,
    entry: &'a str,
    pictures: usize,
    textures: Vec<Texture<'a>>,
}

/// A pass with one sample to a pixel that reads the package's own parameters, `textures` and, if given, the blocks `Shade` and
/// `Whites`.
fn single(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
    Stage { wgsl, entry, pictures, textures }: Stage<'_>,
    shade: Option<[&[u8]; 2]>,
) -> Result<Vec<Vec<[f32; 4]>>> {
    let targets = Targets { pictures, multisampled: false };
    let mut uniforms = vec![(MESH_PARAMS, 4 * PARAMS_NUMBERS)];
    let block = params_bytes(params);
    let mut blocks: Vec<&[u8]> = vec![&block];
    if let Some(shade) = shade {
        uniforms.extend([(SHADE_BLOCK, 4 * SHADE_NUMBERS), (WHITES, 4 * WHITES_NUMBERS)]);
        blocks.extend(shade);
    }
    let program = MeshProgram {
        name: &prepared.placement.variant.name,
        wgsl,
        vertex_entry: "mesh_vert",
        fragment_entry: entry,
        textures,
        colours: None,
        uniforms,
    };
    let pipeline = gpu.mesh_program(&program, targets)?;
    let buffers = gpu.mesh(&mesh.vertices, &mesh.triangles)?;
    gpu.draw_mesh(&mesh.name, &buffers, (&pipeline, &blocks), targets, size)
}

/// The shader of a variant with the harness's shading appended, and the functions that the variant does not have.
fn text(prepared: &Prepared<'_>, around: Option<&(Table, f64)>, lobes: Lobes) -> Result<String> {
    let module = prepared.module(prepared.spectrum.width)?;
    let known = prepared.form.functions();
    let is_absent = |kind| !known.iter().any(|function| function.kind() == kind);
    let absent: String = FUNCTIONS
        .iter()
        // pictures are not traced by paths
        .filter(|function| is_absent(function.kind()) && function.kind() != FunctionKind::Path)
        .map(|f| {
            let result = match f.kind() {
                // lamps of a colour are refused, so that the colour is a number
                FunctionKind::DiscColoured if !is_absent(FunctionKind::Disc) => WHITE_DISC,
                _ => "vec3f(0.0)",
            };
            format!("fn {}{} {{ return {result}; }}\n", f.name(), f.signature())
        })
        .collect();
    let footprint = if is_absent(FunctionKind::Spread) { NO_FOOTPRINT } else { LOBE };
    let matter = prepared.form.matter();
    // a number above 1 stands for Schlick's reflectance
    let share = matter.body_share().unwrap_or(2.0);
    let reflectance = match matter.is_plain() {
        true => SCHLICK,
        false => "fn body_reflectance(cos_half: f32) -> f32 { return 0.0; }",
    };
    let body = format!(
        "const BODY_SHARE: f32 = {share:?};\nconst WIDENS: bool = {};\nconst IS_GGX: bool = {};\n{reflectance}\n",
        lobes == Lobes::Footprint,
        lobes == Lobes::Ggx,
    );
    let around = around.map_or_else(String::new, |(_, factor)| {
        format!("const MAP_FACTOR: f32 = {:?};\n{AROUND}", *factor as f32)
    });
    let own = module.text().replace("fn environment_radiance(", "fn map_radiance(");
    let shading = format!("{SHADE}{around}{body}{absent}{footprint}");
    if !prepared.form.has_pattern() {
        return Ok(format!("{own}\n{shading}{NO_PATTERN}"));
    }
    let given: Vec<&str> = known.iter().map(|function| function.name()).collect();
    let argument = Argument { name: "pattern", of_type: "vec4f" };
    Ok(format!("{own}\n{}", hand_on(&shading, argument, &given)))
}

/// The pass that draws the body and what it diffracts.
fn pass(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    around: Option<&Filtered>,
    mesh: &Mesh,
    lobes: Lobes,
) -> Result<MeshPipeline> {
    let around = around_table(prepared, around);
    let colours = Colours { map: &mesh.colour, binding: BODY_COLOUR, sampler: BODY_SAMPLER };
    let program = MeshProgram {
        name: &mesh.name,
        wgsl: &text(prepared, around.as_ref(), lobes)?,
        vertex_entry: "mesh_vert",
        fragment_entry: "scene_skin",
        textures: textures(prepared, around.as_ref(), &mesh.orientation),
        colours: Some(colours),
        uniforms: [
            (MESH_PARAMS, 4 * PARAMS_NUMBERS),
            (SHADE_BLOCK, 4 * SHADE_NUMBERS),
            (WHITES, 4 * WHITES_NUMBERS),
        ]
        .to_vec(),
    };
    gpu.mesh_program(&program, PICTURE)
}

/// The surroundings as a shader reads them, with the factor by which they were divided. `None` if the variant has no function for
/// them.
fn around_table(prepared: &Prepared<'_>, around: Option<&Filtered>) -> Option<(Table, f64)> {
    (prepared.streaks.width > 0).then(|| around.map_or_else(dark, environment_table))
}

/// The tables of a variant, its surroundings, and the orientation map.
fn textures(
    prepared: &Prepared<'_>,
    around: Option<&(Table, f64)>,
    map: &OrientationMap,
) -> Vec<Texture<'static>> {
    let spectrum = Some(&prepared.spectrum).filter(|table| table.width > 0);
    let tables = prepared.tables().chain(spectrum).chain(around.map(|(table, _)| table));
    let tables = tables.map(|table| table_texture(table, table.binding));
    tables.chain([orientation_texture(map)]).collect()
}

fn orientation_texture(map: &OrientationMap) -> Texture<'static> {
    let ratios = |i| map.ratios.get(i).copied().unwrap_or([1.0; 3]);
    let texel = |(i, angle): (usize, &f32)| {
        let [period, depth, share] = ratios(i);
        [*angle, period, depth, share]
    };
    let texels: Vec<[f32; 4]> = map.angles.iter().enumerate().map(texel).collect();
    Texture {
        binding: ORIENTATION_MAP,
        layout: TextureLayout::D2,
        format: TextureFormat::Rgba32Float,
        width: map.width as u32,
        height: map.height as u32,
        layers: 1,
        sampler: None,
        bytes: bytemuck::cast_slice(&texels).to_vec().into(),
    }
}

/// The uniform block `MeshParams`.
fn params_bytes(params: &MeshParams) -> Vec<u8> {
    let matrix = |m: &DMat4| m.as_mat4().to_cols_array();
    let mut numbers = Vec::with_capacity(PARAMS_NUMBERS);
    for m in [&params.model, &params.view, &params.projection] {
        numbers.extend(matrix(m));
    }
    for v in [params.light_direction, params.eye] {
        numbers.extend(v.extend(0.0).as_vec4().to_array());
    }
    bytemuck::cast_slice(&numbers).to_vec()
}
