//! Twin of `templates/mesh.wgsl`: a mesh's tangent frame and the directions in it.

use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::field::reference::Directions;
use crate::variant::{Arguments, Pattern};

use super::Twin;

/// A vector made of unit vectors counts as zero up to this square, since it is only a rounding error.
const MIN_SHARE: f64 = 1e-8;
/// Any other vector counts as zero up to this square.
const MIN_SQUARE: f64 = 1e-36;

/// The uniform block `MeshParams`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshParams {
    /// From the mesh to the world.
    pub model: DMat4,
    /// From the world to the camera.
    pub view: DMat4,
    /// From the camera to clip space: y up, depth 0 … 1.
    pub projection: DMat4,
    /// Direction to the light in the world, any length.
    pub light_direction: DVec3,
    /// Position of the viewer in the world.
    pub eye: DVec3,
}

/// Attributes of a vertex of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Position in the mesh.
    pub position: DVec3,
    /// Normal, of unit length.
    pub normal: DVec3,
    /// Tangent; `w`: handedness of the bitangent, ±1 (MikkTSpace).
    pub tangent: DVec4,
    /// Texture coordinates; (0, 0) is the first texel's corner.
    pub uv: DVec2,
    /// Angle of the orientation field, radians, from the tangent towards the bitangent.
    pub orientation_angle: f64,
}

/// Values that are interpolated over a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshVertex {
    /// Position in clip space.
    pub position: DVec4,
    /// Position in the world.
    pub place: DVec3,
    /// Normal in the world.
    pub normal: DVec3,
    /// Tangent in the world, turned by the vertex's angle; `w`: handedness.
    pub tangent: DVec4,
    /// Texture coordinates.
    pub uv: DVec2,
}

/// Angles in radians, `[row][column]`, and the rest of a pattern. The map repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct OrientationMap {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The angles.
    pub angles: Vec<f32>,
    /// Period and depth relative to those of the surface, and the covered share. Empty for variants without patterns.
    pub ratios: Vec<[f32; 3]>,
}

/// The vertex stage.
pub fn mesh_vert(params: &MeshParams, vertex: &Vertex) -> MeshVertex {
    let place = params.model * vertex.position.extend(1.0);
    let upright = unit(world_normal(params, vertex.normal), MIN_SQUARE);
    let along = unit((params.model * vertex.tangent.truncate().extend(0.0)).truncate(), MIN_SQUARE);
    let flat = unit(along - along.dot(upright) * upright, MIN_SHARE);
    let handedness = if vertex.tangent.w * model_volume(params) < 0.0 { -1.0 } else { 1.0 };
    let across = handedness * upright.cross(flat);
    let (sin, cos) = vertex.orientation_angle.sin_cos();
    MeshVertex {
        position: params.projection * (params.view * place),
        place: place.truncate(),
        normal: upright,
        tangent: (cos * flat + sin * across).extend(handedness),
        uv: vertex.uv,
    }
}

/// The fragment stage, as relative tristimulus values. `next`: the values in the next pixel of the row and in that of the column,
/// on the same triangle.
pub fn mesh(
    twin: &Twin<'_>,
    params: &MeshParams,
    map: &OrientationMap,
    at: &MeshVertex,
    next: &[MeshVertex; 2],
) -> [f64; 3] {
    let used = |at: &MeshVertex| Directions {
        wi: in_frame(map, params.light_direction, at),
        wr: in_frame(map, params.eye - at.place, at),
    };
    let path = |at: &MeshVertex| (used(at).wi + used(at).wr).truncate();
    let directions = used(at);
    if !(directions.wi.z > 0.0 && directions.wr.z > 0.0) {
        return [0.0; 3];
    }
    let [right, down] = [&next[0], &next[1]].map(|next| path(next) - path(at));
    let spread = footprint_spread(right, down, directions.wi.z.min(directions.wr.z));
    // the frame has the angle of the map
    let [period_ratio, depth_ratio, share] = pattern_ratios(map, at.uv).to_array();
    let pattern = Pattern { angle_deg: 0.0, period_ratio, depth_ratio };
    let single = || twin.evaluate_on(&pattern, Arguments::Direction(directions));
    let widened = twin.evaluate_on(&pattern, Arguments::Spread { directions, spread });
    let xyz = widened.or_else(single).unwrap_or([f64::NAN; 3]);
    xyz.map(|c| share * c)
}

/// Spread of lobes by the footprint of a pixel, from the steps of `(u, v)` to the next pixels, and the lower of the heights of
/// light and viewer.
pub fn footprint_spread(right: DVec2, down: DVec2, height: f64) -> f64 {
    let sum = right.length_squared() + down.length_squared();
    let area = right.perp_dot(down);
    let longest = (0.5 * (sum + (sum * sum - 4.0 * area * area).max(0.0).sqrt())).sqrt();
    (1.5 * longest).min(0.5 * height.max(0.0))
}

/// Direction in the world as a unit vector in the frame of a fragment. Zero if there is no frame.
pub fn in_frame(map: &OrientationMap, direction: DVec3, at: &MeshVertex) -> DVec3 {
    let upright = unit(at.normal, MIN_SHARE);
    let tangent = at.tangent.truncate();
    let straight = unit(tangent - tangent.dot(upright) * upright, MIN_SHARE);
    let across = if at.tangent.w < 0.0 { -1.0 } else { 1.0 } * upright.cross(straight);
    if across.length_squared() < 0.5 {
        return DVec3::ZERO;
    }
    let turn = orientation(map, at.uv);
    let along = turn.x * straight + turn.y * across;
    let beside = turn.x * across - turn.y * straight;
    let ray = unit(direction, MIN_SQUARE);
    unit(DVec3::new(ray.dot(along), ray.dot(beside), ray.dot(upright)), MIN_SHARE)
}

/// Cosine and sine of the map's angle.
fn orientation(map: &OrientationMap, uv: DVec2) -> DVec2 {
    let size = DVec2::new(map.width as f64, map.height as f64);
    let place = (uv - uv.floor()) * size - 0.5;
    let corner = place.floor();
    let share = place - corner;
    let turn = |x, y| texel_turn(map, corner + DVec2::new(x, y));
    let [first, second, third, fourth] =
        [turn(0.0, 0.0), turn(1.0, 0.0), turn(0.0, 1.0), turn(1.0, 1.0)];
    let mean = 0.25 * (first + second + third + fourth);
    if !map.ratios.is_empty() && mean.length_squared() < 0.98 {
        return texel_turn(map, (place + 0.5).floor());
    }
    let turn = first.lerp(second, share.x).lerp(third.lerp(fourth, share.x), share.y);
    let squared = turn.length_squared();
    if squared > MIN_SHARE { turn / squared.sqrt() } else { DVec2::X }
}

/// Cosine and sine of the angle of one texel of the map, which repeats.
fn texel_turn(map: &OrientationMap, texel: DVec2) -> DVec2 {
    let size = DVec2::new(map.width as f64, map.height as f64);
    let repeated = texel - size * ((texel + 0.5) / size).floor();
    let [x, y] = repeated.clamp(DVec2::ZERO, size - 1.0).to_array();
    DVec2::from_angle(f64::from(map.angles[y as usize * map.width + x as usize]))
}

/// Period, depth and covered share of the map.
pub fn pattern_ratios(map: &OrientationMap, uv: DVec2) -> DVec3 {
    let size = DVec2::new(map.width as f64, map.height as f64);
    let place = (uv - uv.floor()) * size - 0.5;
    let corner = place.floor();
    let share = place - corner;
    let at = |x, y| texel_ratios(map, corner + DVec2::new(x, y));
    let [first, second, third, fourth] = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)];
    let ratios = first.lerp(second, share.x).lerp(third.lerp(fourth, share.x), share.y);
    let most = first.max(second).max(third.max(fourth));
    let least = first.min(second).min(third.min(fourth));
    let nearest = texel_ratios(map, (place + 0.5).floor());
    let mixed = |i: usize| if most[i] > 1.02 * least[i] { nearest[i] } else { ratios[i] };
    DVec3::new(mixed(0), mixed(1), ratios.z)
}

/// Period, depth and covered share of one texel of the map, which repeats.
fn texel_ratios(map: &OrientationMap, texel: DVec2) -> DVec3 {
    let size = DVec2::new(map.width as f64, map.height as f64);
    let repeated = texel - size * ((texel + 0.5) / size).floor();
    let [x, y] = repeated.clamp(DVec2::ZERO, size - 1.0).to_array();
    let ratios = map.ratios.get(y as usize * map.width + x as usize);
    ratios.map_or(DVec3::ONE, |ratios| DVec3::from(ratios.map(f64::from)))
}

/// Normal in the world, not normalised.
fn world_normal(params: &MeshParams, normal: DVec3) -> DVec3 {
    let [x, y, z] =
        [params.model.x_axis, params.model.y_axis, params.model.z_axis].map(DVec4::truncate);
    let cofactors = normal.x * y.cross(z) + normal.y * z.cross(x) + normal.z * x.cross(y);
    let volume = model_volume(params);
    if volume == 0.0 { DVec3::ZERO } else { volume.signum() * cofactors }
}

/// Determinant of the model matrix, negative if the matrix mirrors.
fn model_volume(params: &MeshParams) -> f64 {
    let [x, y, z] =
        [params.model.x_axis, params.model.y_axis, params.model.z_axis].map(DVec4::truncate);
    x.dot(y.cross(z))
}

/// The normalised vector. Zero if its square is not above `least` or is not a number.
fn unit(vector: DVec3, least: f64) -> DVec3 {
    let squared = vector.length_squared();
    if squared > least { vector / squared.sqrt() } else { DVec3::ZERO }
}
