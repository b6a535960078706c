//! Tangent frames of a mesh in f64: what a uneven scale, a mirror and the orientation field do to them.

use std::f64::consts::{FRAC_PI_2, TAU};

use diffraction_shaders::variant::mesh::{
    MeshParams, MeshVertex, OrientationMap, Vertex, in_frame, mesh_vert,
};
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

fn params(model: DMat4) -> MeshParams {
    let (view, projection) = (DMat4::IDENTITY, DMat4::IDENTITY);
    MeshParams { model, view, projection, light_direction: DVec3::Z, eye: DVec3::Z }
}

fn vertex(normal: DVec3, tangent: DVec3, handedness: f64, angle: f64) -> Vertex {
    Vertex {
        position: DVec3::new(0.3, -0.2, 0.1),
        normal,
        tangent: tangent.extend(handedness),
        uv: DVec2::new(0.3, 0.7),
        orientation_angle: angle,
    }
}

/// Tangent, bitangent and normal of a vertex in the world, as columns: what the frame maps to x, y and z.
fn frame(at: &MeshVertex, map: &OrientationMap) -> DMat3 {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| in_frame(map, axis, at));
    DMat3::from_cols(axes[0], axes[1], axes[2]).transpose()
}

fn slanted() -> (DVec3, DVec3) {
    let normal = DVec3::new(0.2, 0.5, 0.7).normalize();
    (normal, normal.cross(DVec3::new(0.1, -0.8, 0.3)).normalize())
}

#[test]
fn the_bitangent_is_normal_times_tangent_times_handedness() {
    let (normal, tangent) = slanted();
    for handedness in [1.0, -1.0] {
        let at = mesh_vert(&params(DMat4::IDENTITY), &vertex(normal, tangent, handedness, 0.0));
        let [t, b, n] = frame(&at, &OrientationMap::none()).to_cols_array_2d().map(DVec3::from);
        assert!(t.distance(tangent) < 1e-12 && n.distance(normal) < 1e-12);
        assert!(b.distance(handedness * normal.cross(tangent)) < 1e-12, "{handedness}");
    }
}

/// Rodrigues' rotation as a matrix, from the tangent towards the bitangent: with the handedness about the normal.
#[test]
fn the_orientation_field_turns_the_frame_about_the_normal() {
    let (normal, tangent) = slanted();
    for (handedness, of_vertex, of_map) in [(1.0, 0.7, 0.0), (-1.0, 0.0, 0.4), (-1.0, -0.9, 2.5)] {
        let at =
            mesh_vert(&params(DMat4::IDENTITY), &vertex(normal, tangent, handedness, of_vertex));
        let map =
            OrientationMap { width: 1, height: 1, angles: vec![of_map as f32], ratios: Vec::new() };
        let turn =
            DMat3::from_axis_angle(normal, handedness * (of_vertex + f64::from(of_map as f32)));
        let [t, b, n] = frame(&at, &map).to_cols_array_2d().map(DVec3::from);
        assert!(t.distance(turn * tangent) < 1e-12, "{t} {}", turn * tangent);
        assert!(b.distance(turn * (handedness * normal.cross(tangent))) < 1e-12);
        assert!(n.distance(normal) < 1e-12);
    }
}

/// The normal of a plane whose two edges the model matrix moves.
#[test]
fn an_uneven_scale_keeps_the_normal_upright() {
    let (normal, tangent) = slanted();
    let bitangent = normal.cross(tangent);
    let model = DMat4::from_rotation_y(0.4) * DMat4::from_scale(DVec3::new(0.3, 2.0, 1.1));
    let at = mesh_vert(&params(model), &vertex(normal, tangent, 1.0, 0.0));
    let (along, across) = (model.transform_vector3(tangent), model.transform_vector3(bitangent));
    let [t, b, n] = frame(&at, &OrientationMap::none()).to_cols_array_2d().map(DVec3::from);
    assert!(n.distance(along.cross(across).normalize()) < 1e-12);
    assert!(t.distance(along.normalize()) < 1e-12 && b.dot(across) > 0.0);
    // the model matrix alone would tilt it
    assert!(model.transform_vector3(normal).normalize().distance(n) > 0.1);
}

/// A mesh, and its mirror image by the model matrix or by its vertices, see mirrored scenes alike.
#[test]
fn mirrored_meshes_see_mirrored_directions() {
    let (normal, tangent) = slanted();
    let mirror = DVec3::new(-1.0, 1.0, 1.0);
    let direction = DVec3::new(0.3, 0.1, 0.9);
    let map = OrientationMap { width: 2, height: 1, angles: vec![0.3, 1.1], ratios: Vec::new() };
    let at = mesh_vert(&params(DMat4::IDENTITY), &vertex(normal, tangent, 1.0, 0.6));
    let seen = in_frame(&map, direction, &at);
    let by_model =
        mesh_vert(&params(DMat4::from_scale(mirror)), &vertex(normal, tangent, 1.0, 0.6));
    assert!(in_frame(&map, mirror * direction, &by_model).distance(seen) < 1e-12);
    let mirrored = vertex(mirror * normal, mirror * tangent, -1.0, 0.6);
    let by_vertex = mesh_vert(&params(DMat4::IDENTITY), &mirrored);
    assert!(in_frame(&map, mirror * direction, &by_vertex).distance(seen) < 1e-12);
    // and the wrong handedness does not
    let wrong = mesh_vert(
        &params(DMat4::IDENTITY),
        &Vertex { tangent: mirrored.tangent * DVec4::new(1.0, 1.0, 1.0, -1.0), ..mirrored },
    );
    assert!(in_frame(&map, mirror * direction, &wrong).distance(seen) > 0.1);
}

#[test]
fn what_has_no_frame_sees_nothing() {
    let (normal, tangent) = slanted();
    let bad = [
        vertex(DVec3::ZERO, tangent, 1.0, 0.0),
        vertex(DVec3::NAN, tangent, 1.0, 0.0),
        vertex(normal, DVec3::ZERO, 1.0, 0.0),
        vertex(normal, normal, 1.0, 0.0),
        vertex(normal, DVec3::NAN, 1.0, 0.0),
    ];
    for vertex in bad {
        let at = mesh_vert(&params(DMat4::IDENTITY), &vertex);
        assert_eq!(in_frame(&OrientationMap::none(), DVec3::Z, &at), DVec3::ZERO, "{vertex:?}");
    }
    let flat = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0));
    let at = mesh_vert(&params(flat), &vertex(normal, tangent, 1.0, 0.0));
    assert_eq!(in_frame(&OrientationMap::none(), DVec3::Z, &at), DVec3::ZERO);
    let whole = mesh_vert(&params(DMat4::IDENTITY), &vertex(normal, tangent, 1.0, 0.0));
    assert_eq!(in_frame(&OrientationMap::none(), DVec3::ZERO, &whole), DVec3::ZERO);
}

/// Angles near a whole turn and near 0 are neighbours; a mean of numbers would point backwards.
#[test]
fn map_angles_blend_over_the_turn() {
    let (normal, tangent) = slanted();
    let map = OrientationMap {
        width: 2,
        height: 1,
        angles: vec![0.1, (TAU - 0.1) as f32],
        ratios: Vec::new(),
    };
    let mut middle = vertex(normal, tangent, 1.0, 0.0);
    middle.uv = DVec2::new(0.5, 0.5);
    let at = mesh_vert(&params(DMat4::IDENTITY), &middle);
    assert!(in_frame(&map, tangent, &at).distance(DVec3::X) < 1e-6);
    // the map repeats: three widths on, a quarter in, is its first texel
    middle.uv = DVec2::new(3.25, -2.5);
    let quarter = OrientationMap {
        width: 2,
        height: 1,
        angles: vec![FRAC_PI_2 as f32, 0.0],
        ratios: Vec::new(),
    };
    let at = mesh_vert(&params(DMat4::IDENTITY), &middle);
    assert!(in_frame(&quarter, tangent, &at).distance(-DVec3::Y) < 1e-6);
}
