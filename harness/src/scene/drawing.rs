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
use diffraction_shaders::optics::{REFERENCE_NM, window_sigma_um};
use diffraction_shaders::plan::Coherence;
use diffraction_shaders::runner::Placement;
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
const SHADE_NUMBERS: usize = 12 + 4 * MAX_LIGHTS * (2 + 3 + CORNERS);
const PARAMS_NUMBERS: usize = 56;

/// Number of levels of widened lobes. In the last, lobes are 32 times as wide.
const LEVELS: u32 = 6;

const PICTURE: Targets = Targets { pictures: 1, multisampled: true };

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
    /// The variant with the body's colour, and for widened lobes variants of shorter coherence, each with its diffuser scale.
    levels: Vec<(MeshPipeline, f64)>,
    /// `(λ σf)²` of the variant at 550 nm.
    lobe: f64,
    variant: String,
    form: Form,
    /// Whether it has surroundings.
    is_around: bool,
}

impl<'a> Drawing<'a> {
    /// Computes the tables and compiles the passes. `widen`: lobes are widened by the footprint of pixels. Only an ensemble allows
    /// that: half the coherence length doubles the width of a lobe. `around`: the skies and maps of all pictures, see
    /// [`filtered`].
    pub fn new(
        gpu: &'a Gpu,
        placement: Placement<'a>,
        mesh: Mesh,
        widen: bool,
        around: Option<&Filtered>,
    ) -> Result<Drawing<'a>> {
        let variant = placement.variant;
        let ensemble = variant.optics.coherence == Coherence::Ensemble;
        if widen && !ensemble {
            let cause = "adds amplitudes, so its lobes cannot be widened to the size of a pixel";
            return Err(Error::new(&variant.name, cause).remedy(
                "choose a variant with coherence = \"ensemble\", or --filter supersample",
            ));
        }
        let buffers = gpu.mesh(&mesh.vertices, &mesh.triangles)?;
        let mut levels = Vec::new();
        let form = Form::new(variant, placement.height)?;
        for level in 0..if widen { LEVELS } else { 1 } {
            let mut wider = variant.clone();
            wider.optics.coherence_um /= f64::from(1 << level);
            let prepared = Prepared::new(Placement { variant: &wider, ..placement })?;
            let scale = prepared.form.diffuser_scale(&wider.optics).ok_or_else(|| {
                let cause = "has no radiance scale, so it cannot be blended with a body";
                Error::new(&variant.name, cause)
            })?;
            levels.push((pass(gpu, &prepared, around, &mesh, level > 0)?, scale));
        }
        let sigma = 1.0 / (std::f64::consts::TAU * window_sigma_um(&variant.optics, REFERENCE_NM));
        let lobe = (sigma * REFERENCE_NM * 1e-3).powi(2);
        let (variant, is_around) = (variant.name.clone(), around.is_some());
        Ok(Drawing { gpu, mesh, buffers, levels, lobe, variant, form, is_around })
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
        let has_size = |light: &&Light| !matches!(light.white().0, Light::Direction { .. });
        if self.levels.len() > 1
            && look.diffracts
            && let Some(light) = look.lights.iter().find(has_size)
        {
            return Err(Error::new(&self.mesh.name, widened(light)));
        }
        let block = params_bytes(params);
        let shades: Vec<[f32; SHADE_NUMBERS]> =
            (0..self.levels.len()).map(|level| self.shade(look, level)).collect();
        let whites = whites(&look.lights);
        let bytes: Vec<[&[u8]; 3]> = shades
            .iter()
            .map(|shade| [&block[..], bytemuck::cast_slice(shade), bytemuck::cast_slice(&whites)])
            .collect();
        let passes: Vec<MeshPass<'_>> =
            self.levels.iter().zip(&bytes).map(|((p, _), bytes)| (p, &bytes[..])).collect();
        let pictures =
            self.gpu.draw_mesh(&self.mesh.name, &self.buffers, &passes, PICTURE, size)?;
        let [width, height] = size;
        Ok(Hdr { width, height, pixels: pictures.into_iter().flatten().collect() })
    }

    fn shade(&self, look: &Look, level: usize) -> [f32; SHADE_NUMBERS] {
        let last = if self.levels.len() > 1 { self.levels.len() as f32 - 1.0 } else { -1.0 };
        let scale = self.levels[level].1;
        shade_numbers(look, scale, [level as f32, last, self.lobe as f32])
    }
}

/// Why lobes are not widened under a light with a size.
pub fn widened(light: &Light) -> String {
    format!(
        "lobes are widened by a shorter coherence length, which stands for the size of a light, but a light of kind {:?} has its own",
        light.kind()
    )
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

/// The uniform block `Shade`. `scale`: diffuser scale; `[level, last, lobe]`: level of the pass, last level, and `(λ σf)²`.
fn shade_numbers(look: &Look, scale: f64, [level, last, lobe]: [f32; 3]) -> [f32; SHADE_NUMBERS] {
    let mut numbers = [0.0; SHADE_NUMBERS];
    let flag = |is_set: bool| f32::from(u8::from(is_set));
    let surrounded = look.lights.iter().any(Light::is_all_round);
    let blend = [look.texture_weight as f32, scale as f32, look.unlit as f32, level];
    let widening = [last, lobe, flag(surrounded), flag(look.diffracts)];
    numbers[..4].copy_from_slice(&blend);
    numbers[4..8].copy_from_slice(&widening);
    let (counts, directions) = (8, 12);
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
    set(counts, DVec3::from(next.map(|count| count as f64)), 0.0);
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
    let shade = shade_numbers(&Look::lit_by(lights.to_vec()), scale, [0.0, -1.0, 0.0]);
    let around = around_table(prepared, filtered(lights).as_ref());
    let textures = textures(prepared, around.as_ref(), &mesh.orientation);
    let wgsl = &text(prepared, around.as_ref())?;
    let stage = Stage { wgsl, entry: "scene_parts", pictures: 2, textures };
    let whites = whites(lights);
    let blocks = [bytemuck::cast_slice(&shade), bytemuck::cast_slice(&whites)];
    let pictures = single(gpu, prepared, mesh, params, size, stage, Some(blocks))?;
    let white = |texel: &[f32; 4]| vector(texel).as_vec3();
    Ok(pictures[0].iter().zip(&pictures[1]).map(|(g, w)| (*g, white(w))).collect())
}

/// The directions that the entry point `mesh` uses in each pixel, and the distance from the viewer; `None` outside the mesh.
pub fn directions(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
) -> Result<Vec<Option<(Directions, f64)>>> {
    let used = |wi: &[f32; 4], wr: &[f32; 4]| {
        let directions = Directions { wi: vector(wi), wr: vector(wr) };
        (wr[3] > 0.0).then(|| (directions, f64::from(wi[3])))
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
    let stage = Stage { wgsl: &text(prepared, around.as_ref())?, entry, pictures: 2, textures };
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
        add: false,
    };
    let pipeline = gpu.mesh_program(&program, targets)?;
    let buffers = gpu.mesh(&mesh.vertices, &mesh.triangles)?;
    let passes: [MeshPass<'_>; 1] = [(&pipeline, &blocks)];
    gpu.draw_mesh(&mesh.name, &buffers, &passes, targets, size)
}

/// The shader of a variant with the harness's shading appended, and the functions that the variant does not have.
fn text(prepared: &Prepared<'_>, around: Option<&(Table, f64)>) -> Result<String> {
    let module = prepared.module(prepared.spectrum.width)?;
    let known = prepared.form.functions();
    let is_absent = |kind| !known.iter().any(|function| function.kind() == kind);
    let absent: String = FUNCTIONS
        .iter()
        // pictures are not traced by paths
        .filter(|function| is_absent(function.kind()) && function.kind() != FunctionKind::Path)
        .map(|f| format!("fn {}{} {{ return vec3f(0.0); }}\n", f.name(), f.signature()))
        .collect();
    let matter = prepared.form.matter();
    // a number above 1 stands for Schlick's reflectance
    let share = matter.body_share().unwrap_or(2.0);
    let reflectance = match matter.is_plain() {
        true => SCHLICK,
        false => "fn body_reflectance(cos_half: f32) -> f32 { return 0.0; }",
    };
    let body = format!("const BODY_SHARE: f32 = {share:?};\n{reflectance}\n");
    let around = around.map_or_else(String::new, |(_, factor)| {
        format!("const MAP_FACTOR: f32 = {:?};\n{AROUND}", *factor as f32)
    });
    let own = module.text().replace("fn environment_radiance(", "fn map_radiance(");
    Ok(format!("{own}\n{SHADE}{around}{body}{absent}"))
}

/// The pass of a level. The first one draws the body, too; the others add to it.
fn pass(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    around: Option<&Filtered>,
    mesh: &Mesh,
    add: bool,
) -> Result<MeshPipeline> {
    let around = around_table(prepared, around);
    let colours = Colours { map: &mesh.colour, binding: BODY_COLOUR, sampler: BODY_SAMPLER };
    let program = MeshProgram {
        name: &mesh.name,
        wgsl: &text(prepared, around.as_ref())?,
        vertex_entry: "mesh_vert",
        fragment_entry: if add { "scene_level" } else { "scene_skin" },
        textures: textures(prepared, around.as_ref(), &mesh.orientation),
        colours: (!add).then_some(colours),
        uniforms: [
            (MESH_PARAMS, 4 * PARAMS_NUMBERS),
            (SHADE_BLOCK, 4 * SHADE_NUMBERS),
            (WHITES, 4 * WHITES_NUMBERS),
        ]
        .to_vec(),
        add,
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
    let texels: Vec<[f32; 2]> = map.angles.iter().map(|angle| [*angle, 0.0]).collect();
    Texture {
        binding: ORIENTATION_MAP,
        layout: TextureLayout::D2,
        format: TextureFormat::Rg32Float,
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
