//- Twin: src/variant/twin/mesh.rs. The limits 1e-8 and 1e-36 have no names, since a constant stands in every file.

// A mesh in a scene. Vertices carry their tangent frame, turned by the orientation field. Fragments take the directions
// to the light and to the viewer into this frame. Points that face away and points without a frame are black. A vector
// made of unit vectors counts as zero where its square is at most 1e-8, any other vector where it is at most 1e-36.

struct MeshParams {
    // matrix from the mesh to the world; it may scale unevenly and mirror
    model: mat4x4f,
    // matrix from the world to the camera
    view: mat4x4f,
    // matrix from the camera to clip space
    projection: mat4x4f,
    // xyz: direction to the light in the world, any length; w: unused
    light_direction: vec4f,
    // xyz: position of the viewer in the world; w: unused
    eye: vec4f,
}
@group(0) @binding(8) var<uniform> mesh_params: MeshParams;
#ifdef PATTERN
// The pattern. x: its angle in radians, from the tangent towards the bitangent, added to the vertex's angle; y: its period
// relative to that of the surface; z: its depth; w: share of the texel that is covered by the relief. The map repeats.
#else
// x: angle of the orientation field in radians, from the tangent towards the bitangent, added to the vertex's angle.
// The map repeats. It is one texel of 0 where only the vertices have angles.
#endif
@group(0) @binding(9) var orientation_map: texture_2d<f32>;

struct MeshVertex {
    @builtin(position) position: vec4f,
    // position in the world
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    // xyz: tangent, turned by the vertex's angle; w: handedness
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
}

// Inputs: position, normal and tangent in the mesh (MikkTSpace: the bitangent is w times normal times tangent), texture
// coordinates, and the orientation field's angle in radians.
@vertex
fn mesh_vert(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
    @location(4) orientation_angle: f32,
) -> MeshVertex {
    let place = mesh_params.model * vec4f(position, 1.0);
    let upright = unit(world_normal(normal), 1e-36);
    let along = unit((mesh_params.model * vec4f(tangent.xyz, 0.0)).xyz, 1e-36);
    let flat_tangent = unit(along - dot(along, upright) * upright, 1e-8);
    let handedness = select(1.0, -1.0, tangent.w * model_volume() < 0.0);
    let across = handedness * cross(upright, flat_tangent);
    let turned = cos(orientation_angle) * flat_tangent + sin(orientation_angle) * across;
    let clip = mesh_params.projection * (mesh_params.view * place);
    return MeshVertex(clip, place.xyz, upright, vec4f(turned, handedness), uv);
}

// Linear RGB of the visible point under the light, alpha 1.
@fragment
fn mesh(
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
) -> @location(0) vec4f {
    let wi = in_frame(mesh_params.light_direction.xyz, normal, tangent, uv);
    let wr = in_frame(mesh_params.eye.xyz - place, normal, tangent, uv);
#ifdef SPREAD
    let path = wi.xy + wr.xy;
    let spread = footprint_spread(dpdx(path), dpdy(path), min(wi.z, wr.z));
#endif
    if (!(wi.z > 0.0 && wr.z > 0.0)) {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
#ifdef PATTERN
    // the frame has the angle of the map
    let ratios = pattern_ratios(uv);
    let pattern = vec4f(1.0, 0.0, ratios.xy);
#endif
#ifdef SPREAD
    var colour = diffraction_spread(wi, wr, spread);
#else
    var colour = diffraction(wi, wr);
#endif
#ifdef PATTERN
    colour *= ratios.z;
#endif
    return vec4f(colour, 1.0);
}

#ifdef SPREAD
// Spread of lobes by the footprint of a pixel, from the steps of (u, v), which is (wi + wr).xy, to the next pixels of the row
// and of the column: 1.5 times the longest step in any direction. Lobes may be hundreds of times as bright as white, and with
// a spread of a pixel or less their edges still flicker while the camera moves. `height` is the lower of wi.z and wr.z: no
// lobe reaches the horizon, where it would take light from directions that are not seen.
fn footprint_spread(right: vec2f, down: vec2f, height: f32) -> f32 {
    let sum = dot(right, right) + dot(down, down);
    let area = right.x * down.y - right.y * down.x;
    let longest = sqrt(0.5 * (sum + sqrt(max(0.0, sum * sum - 4.0 * area * area))));
    return min(1.5 * longest, 0.5 * max(height, 0.0));
}

#endif

// Direction in the world as a unit vector in the frame of a fragment. Zero if there is no frame.
fn in_frame(direction: vec3f, normal: vec3f, tangent: vec4f, uv: vec2f) -> vec3f {
    let upright = unit(normal, 1e-8);
    let straight = unit(tangent.xyz - dot(tangent.xyz, upright) * upright, 1e-8);
    let across = select(1.0, -1.0, tangent.w < 0.0) * cross(upright, straight);
    if (dot(across, across) < 0.5) {
        return vec3f(0.0);
    }
    let turn = orientation(uv);
    let along = turn.x * straight + turn.y * across;
    let beside = turn.x * across - turn.y * straight;
    let ray = unit(direction, 1e-36);
    return unit(vec3f(dot(ray, along), dot(ray, beside), dot(ray, upright)), 1e-8);
}

// Cosine and sine of the map's angle, bilinear. Directions are interpolated and not angles, since an angle jumps by a
// whole turn.
fn orientation(uv: vec2f) -> vec2f {
    let size = vec2f(textureDimensions(orientation_map, 0));
    let place = (uv - floor(uv)) * size - 0.5;
    let corner = floor(place);
    let share = place - corner;
    let right = corner + vec2f(1.0, 0.0);
    let under = vec2f(0.0, 1.0);
    let first = texel_turn(corner, size);
    let second = texel_turn(right, size);
    let third = texel_turn(corner + under, size);
    let fourth = texel_turn(right + under, size);
#ifdef PATTERN
    // gratings that differ by some 8° are parted by an edge: the direction between them is that of neither
    let mean = 0.25 * (first + second + third + fourth);
    if (dot(mean, mean) < 0.98) {
        return texel_turn(floor(place + 0.5), size);
    }
#endif
    let turn = mix(mix(first, second, share.x), mix(third, fourth, share.x), share.y);
    let squared = dot(turn, turn);
    let direction = turn * inverseSqrt(max(squared, 1e-8));
    return select(vec2f(1.0, 0.0), direction, squared > 1e-8);
}

#ifdef PATTERN
// Period, depth and covered share of the map, bilinear. Periods and depths of texels that differ by more than 2 % are not mixed.
fn pattern_ratios(uv: vec2f) -> vec3f {
    let size = vec2f(textureDimensions(orientation_map, 0));
    let place = (uv - floor(uv)) * size - 0.5;
    let corner = floor(place);
    let share = place - corner;
    let right = corner + vec2f(1.0, 0.0);
    let under = vec2f(0.0, 1.0);
    let first = texel_ratios(corner, size);
    let second = texel_ratios(right, size);
    let third = texel_ratios(corner + under, size);
    let fourth = texel_ratios(right + under, size);
    let ratios = mix(mix(first, second, share.x), mix(third, fourth, share.x), share.y);
    let most = max(max(first.xy, second.xy), max(third.xy, fourth.xy));
    let least = min(min(first.xy, second.xy), min(third.xy, fourth.xy));
    let nearest = texel_ratios(floor(place + 0.5), size);
    return vec3f(select(ratios.xy, nearest.xy, most > 1.02 * least), ratios.z);
}

// Period, depth and covered share of one texel of the map, which repeats.
fn texel_ratios(texel: vec2f, size: vec2f) -> vec3f {
    let repeated = texel - size * floor((texel + 0.5) / size);
    return textureLoad(orientation_map, vec2i(clamp(repeated, vec2f(0.0), size - 1.0)), 0).yzw;
}

#endif
// Cosine and sine of the angle of one texel of the map, which repeats.
fn texel_turn(texel: vec2f, size: vec2f) -> vec2f {
    let repeated = texel - size * floor((texel + 0.5) / size);
    let angle = textureLoad(orientation_map, vec2i(clamp(repeated, vec2f(0.0), size - 1.0)), 0).x;
    return vec2f(cos(angle), sin(angle));
}

// Normal in the world, not normalised. The cofactors of the model matrix stand for its inverse transpose.
fn world_normal(normal: vec3f) -> vec3f {
    let x = mesh_params.model[0].xyz;
    let y = mesh_params.model[1].xyz;
    let z = mesh_params.model[2].xyz;
    let cofactors = normal.x * cross(y, z) + normal.y * cross(z, x) + normal.z * cross(x, y);
    return sign(model_volume()) * cofactors;
}

// Determinant of the model matrix, negative where the matrix mirrors.
fn model_volume() -> f32 {
    let top = cross(mesh_params.model[1].xyz, mesh_params.model[2].xyz);
    return dot(mesh_params.model[0].xyz, top);
}

// The normalised vector. Zero if its square is not above `least` or is not a number.
fn unit(vector: vec3f, least: f32) -> vec3f {
    let squared = dot(vector, vector);
    if (!(squared > least)) {
        return vec3f(0.0);
    }
    return vector * inverseSqrt(squared);
}
