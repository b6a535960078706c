//! Compares a drawn picture with the same scene in f64.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::optics::colour::from_rgb;
use diffraction_shaders::optics::colour_difference::{ColourDifference, colour_difference};
use diffraction_shaders::tables::Table;
use diffraction_shaders::variant::Twin;
use diffraction_shaders::variant::mesh::{MeshParams, Vertex, in_frame, mesh as shaded};

use crate::drivers::Prepared;
use crate::drivers::gpu::Gpu;
use crate::scene::{Mesh, raster};

use super::{directions, relative_radiance};

/// The differences between a driver's picture by the entry point `mesh` and the scene in f64.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Truth {
    /// Number of pixels that both show.
    pub pixels: usize,
    /// Number of pixels on edges, where the two show different points, or only one shows the mesh. They are left out.
    pub edges: usize,
    /// Number of pixels whose point faces both light and viewer.
    pub facing: usize,
    /// 95th percentile of the difference between the directions and those of the f64 rasteriser. A driver moves corners to a grid of
    /// 1/256 pixel.
    pub direction: f64,
    /// Maximum of that difference. It means little near the pole of a sphere, where interpolated tangents cancel.
    pub direction_max: f64,
    /// The picture against the twin's colours for the directions of the rasteriser.
    pub scene: ColourDifference,
    /// The picture against the twin's colours for the directions that the driver used.
    pub shading: ColourDifference,
}

/// Draws `mesh` by the entry point `mesh` of a variant, reads the directions that the driver used, and computes both again in
/// f64: directions from the vertices, and colours by the twin for both sets of directions.
pub fn truth(
    gpu: &Gpu,
    prepared: &Prepared<'_>,
    mesh: &Mesh,
    params: &MeshParams,
    size: [u32; 2],
) -> Result<Truth> {
    let drawn = relative_radiance(gpu, prepared, mesh, params, size)?;
    let used = directions(gpu, prepared, mesh, params, size)?;
    let (mesh, params) = (received(mesh), received_params(params));
    let seen = raster::visible(&mesh, &params, size)?;
    let tables: Vec<Table> = [&prepared.terms, &prepared.spectrum, &prepared.coefficients]
        .map(|t| t.clone().rounded())
        .into();
    let subject = prepared.placement;
    let twin = Twin::new(&prepared.form, &tables, &subject.variant.optics, subject.rotate_deg);
    let colour = subject.variant.optics.colour;
    let (mut edges, mut facing, mut apart) = (0, 0, Vec::new());
    let (mut exact, mut shading, mut picture) = (Vec::new(), Vec::new(), Vec::new());
    for ((seen, used), drawn) in seen.iter().zip(&used).zip(&drawn) {
        let (Some(seen), Some((used, away))) = (seen, used) else {
            edges += usize::from(seen.is_some() != used.is_some());
            continue;
        };
        let at = &seen.at;
        if (at.place.distance(params.eye) - away).abs() > EDGE * away {
            edges += 1;
            continue;
        }
        let wi = in_frame(&mesh.orientation, params.light_direction, at);
        let wr = in_frame(&mesh.orientation, params.eye - at.place, at);
        facing += usize::from(wi.z > 0.0 && wr.z > 0.0);
        apart.push(wi.distance(used.wi).max(wr.distance(used.wr)));
        exact.push(shaded(&twin, &params, &mesh.orientation, at));
        shading.push(twin.tristimulus(*used));
        picture.push(from_rgb([drawn[0], drawn[1], drawn[2]].map(f64::from), colour));
    }
    if picture.is_empty() {
        return Err(Error::new(
            &mesh.name,
            "is not visible in any pixel, so nothing can be compared",
        ));
    }
    apart.sort_by(f64::total_cmp);
    Ok(Truth {
        pixels: picture.len(),
        edges,
        facing,
        direction: apart[(apart.len() - 1) * 95 / 100],
        direction_max: apart[apart.len() - 1],
        scene: colour_difference(&mesh.name, &exact, &picture, None)?,
        shading: colour_difference(&mesh.name, &shading, &picture, None)?,
    })
}

/// Relative difference of distances above which a pixel counts as on an edge.
const EDGE: f64 = 1e-4;

/// The mesh with its numbers rounded as a driver gets them.
fn received(mesh: &Mesh) -> Mesh {
    let vertex = |v: &Vertex| Vertex {
        position: v.position.as_vec3().as_dvec3(),
        normal: v.normal.as_vec3().as_dvec3(),
        tangent: v.tangent.as_vec4().as_dvec4(),
        uv: v.uv.as_vec2().as_dvec2(),
        orientation_angle: f64::from(v.orientation_angle as f32),
    };
    Mesh { vertices: mesh.vertices.iter().map(vertex).collect(), ..mesh.clone() }
}

fn received_params(params: &MeshParams) -> MeshParams {
    MeshParams {
        model: params.model.as_mat4().as_dmat4(),
        view: params.view.as_mat4().as_dmat4(),
        projection: params.projection.as_mat4().as_dmat4(),
        light_direction: params.light_direction.as_vec3().as_dvec3(),
        eye: params.eye.as_vec3().as_dvec3(),
    }
}
