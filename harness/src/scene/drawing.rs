//! Draws a scene on a driver: a variant as the skin of a mesh, blended with the body's colour.
//!
//! The blending is the thesis's Algorithm 3.4 as intended: `(1 - w_d)·(s·ρ + (1 - R)·c·n·l) + w_d·c`, where `ρ` is the result of
//! the package's shader, `s` its diffuser scale, `R` the Fresnel reflectance and `c` the body's colour. (The thesis prints
//! `1 - min(1, R/R0)` in place of `1 - R`. That is 0 everywhere, since no reflectance is below the one at normal incidence.)

mod truth;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::optics::{REFERENCE_NM, window_sigma_um};
use diffraction_shaders::plan::Coherence;
use diffraction_shaders::runner::Placement;
use diffraction_shaders::variant::mesh::{MeshParams, OrientationMap};
use glam::DMat4;

use crate::drivers::gpu::{
    Colours, Gpu, MeshBuffers, MeshPass, MeshPipeline, MeshProgram, Targets, Texture,
    TextureFormat, TextureLayout,
};
use crate::drivers::{Prepared, table_texture};
use crate::scene::{Light, MAX_LIGHTS, Mesh};

pub use truth::{Truth, truth};

/// The WGSL that the harness appends to a variant's shader.
pub const SHADE: &str = include_str!("drawing/shade.wgsl");

/// Bindings of the templates and of [`SHADE`].
const MESH_PARAMS: u32 = 8;
const ORIENTATION_MAP: u32 = 9;
const SHADE_BLOCK: u32 = 20;
const BODY_COLOUR: u32 = 21;
const BODY_SAMPLER: u32 = 22;
const SHADE_NUMBERS: usize = 8 + 8 * MAX_LIGHTS;
const PARAMS_NUMBERS: usize = 56;

/// Number of levels of widened lobes. In the last, lobes are 32 times as wide.
const LEVELS: u32 = 6;

const PICTURE: Targets = Targets { pictures: 1, multisampled: true };

/// Lights and blending of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// One to four directional lights.
    pub lights: Vec<Light>,
    /// Weight `w_d` of the unlit texture, 0 to 1.
    pub texture_weight: f64,
}

/// A linear picture, `[row][column]` from the top: sRGB primaries, 1 is a white diffuser that faces a light. Alpha is coverage.
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
}

impl<'a> Drawing<'a> {
    /// Computes the tables and compiles the passes. `widen`: lobes are widened by the footprint of pixels. Only an ensemble allows
    /// that: half the coherence length doubles the width of a lobe.
    pub fn new(
        gpu: &'a Gpu,
        placement: Placement<'a>,
        mesh: Mesh,
        widen: bool,
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
        for level in 0..if widen { LEVELS } else { 1 } {
            let mut wider = variant.clone();
            wider.optics.coherence_um /= f64::from(1 << level);
            let prepared = Prepared::new(Placement { variant: &wider, ..placement })?;
            let scale = prepared.form.diffuser_scale(&wider.optics).ok_or_else(|| {
                let cause = "has no radiance scale, so it cannot be blended with a body";
                Error::new(&variant.name, cause)
            })?;
            levels.push((pass(gpu, &prepared, &mesh, level > 0)?, scale));
        }
        let sigma = 1.0 / (std::f64::consts::TAU * window_sigma_um(&variant.optics, REFERENCE_NM));
        let lobe = (sigma * REFERENCE_NM * 1e-3).powi(2);
        Ok(Drawing { gpu, mesh, buffers, levels, lobe })
    }

    /// The drawn mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Draws a picture with four samples per pixel.
    pub fn draw(&self, params: &MeshParams, look: &Look, size: [u32; 2]) -> Result<Hdr> {
        let fail = |cause: String| Err(Error::new(&self.mesh.name, cause));
        if look.lights.is_empty() || look.lights.len() > MAX_LIGHTS {
            return fail(format!(
                "{} lights, but a picture has 1 to {MAX_LIGHTS}",
                look.lights.len()
            ));
        }
        if let Some(light) = look.lights.iter().find(|l| l.direction.try_normalize().is_none()) {
            return fail(format!("the light {} is not a direction", light.direction));
        }
        let block = params_bytes(params);
        let shades: Vec<[f32; SHADE_NUMBERS]> =
            (0..self.levels.len()).map(|level| self.shade(look, level)).collect();
        let bytes: Vec<[&[u8]; 2]> =
            shades.iter().map(|shade| [&block[..], bytemuck::cast_slice(shade)]).collect();
        let passes: Vec<MeshPass<'_>> =
            self.levels.iter().zip(&bytes).map(|((p, _), bytes)| (p, &bytes[..])).collect();
        let pictures =
            self.gpu.draw_mesh(&self.mesh.name, &self.buffers, &passes, PICTURE, size)?;
        let [width, height] = size;
        Ok(Hdr { width, height, pixels: pictures.into_iter().flatten().collect() })
    }

    fn shade(&self, look: &Look, level: usize) -> [f32; SHADE_NUMBERS] {
        let mut numbers = [0.0; SHADE_NUMBERS];
        let last = if self.levels.len() > 1 { self.levels.len() as f32 - 1.0 } else { -1.0 };
        let head = [
            look.texture_weight as f32,
            self.levels[level].1 as f32,
            look.lights.len() as f32,
            level as f32,
            last,
            self.lobe as f32,
        ];
        numbers[..head.len()].copy_from_slice(&head);
        for (i, light) in look.lights.iter().enumerate() {
            let direction = light.direction.as_vec3().normalize();
            numbers[8 + 4 * i..][..3].copy_from_slice(&direction.to_array());
            numbers[8 + 4 * (MAX_LIGHTS + i)..][..3].copy_from_slice(&light.colour);
        }
        numbers
    }
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
    let tables = textures(prepared, &mesh.orientation);
    let pictures = single(gpu, prepared, mesh, params, size, (module.text(), "mesh", 1), tables)?;
    Ok(pictures.into_iter().flatten().collect())
}

/// The directions that the entry point `mesh` uses in each pixel, and the distance from the viewer; `None` outside the mesh.
pub fn directions(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
) -> Result<Vec<Option<(Directions, f64)>>> {
    let text = text(prepared)?;
    let map = vec![orientation_texture(&mesh.orientation)];
    let pictures = single(gpu, prepared, mesh, params, size, (&text, "scene_directions", 2), map)?;
    let vector = |c: &[f32; 4]| glam::Vec3::new(c[0], c[1], c[2]).as_dvec3();
    let used = |(wi, wr): (&[f32; 4], &[f32; 4])| {
        let directions = Directions { wi: vector(wi), wr: vector(wr) };
        (wr[3] > 0.0).then(|| (directions, f64::from(wi[3])))
    };
    Ok(pictures[0].iter().zip(&pictures[1]).map(used).collect())
}

/// A pass with one sample to a pixel that reads nothing but the package's own parameters and `textures`; `(text, entry,
/// number of pictures)`.
fn single(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
    (wgsl, fragment_entry, pictures): (&str, &str, usize),
    textures: Vec<Texture<'_>>,
) -> Result<Vec<Vec<[f32; 4]>>> {
    let targets = Targets { pictures, multisampled: false };
    let program = MeshProgram {
        name: &prepared.placement.variant.name,
        wgsl,
        vertex_entry: "mesh_vert",
        fragment_entry,
        textures,
        colours: None,
        uniforms: vec![(MESH_PARAMS, 4 * PARAMS_NUMBERS)],
        add: false,
    };
    let pipeline = gpu.mesh_program(&program, targets)?;
    let buffers = gpu.mesh(&mesh.vertices, &mesh.triangles)?;
    let block = params_bytes(params);
    let passes: [MeshPass<'_>; 1] = [(&pipeline, &[&block])];
    gpu.draw_mesh(&mesh.name, &buffers, &passes, targets, size)
}

/// The shader of a variant with the harness's shading appended.
fn text(prepared: &Prepared<'_>) -> Result<String> {
    let module = prepared.module(prepared.spectrum.width)?;
    Ok(format!("{}\n{SHADE}", module.text()))
}

/// The pass of a level. The first one draws the body, too; the others add to it.
fn pass(gpu: &Gpu, prepared: &Prepared<'_>, mesh: &Mesh, add: bool) -> Result<MeshPipeline> {
    let colours = Colours { map: &mesh.colour, binding: BODY_COLOUR, sampler: BODY_SAMPLER };
    let program = MeshProgram {
        name: &mesh.name,
        wgsl: &text(prepared)?,
        vertex_entry: "mesh_vert",
        fragment_entry: if add { "scene_level" } else { "scene_skin" },
        textures: textures(prepared, &mesh.orientation),
        colours: (!add).then_some(colours),
        uniforms: vec![(MESH_PARAMS, 4 * PARAMS_NUMBERS), (SHADE_BLOCK, 4 * SHADE_NUMBERS)],
        add,
    };
    gpu.mesh_program(&program, PICTURE)
}

/// The tables of a variant and the orientation map.
fn textures(prepared: &Prepared<'_>, map: &OrientationMap) -> Vec<Texture<'static>> {
    let tables = [&prepared.terms, &prepared.spectrum, &prepared.coefficients];
    let tables = tables.into_iter().filter(|table| table.width > 0);
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
