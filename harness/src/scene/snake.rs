//! A snake, so that pictures need no external asset: a tube along a meander, covered with overlapping keeled scales.

use std::f64::consts::TAU;

use diffraction_shaders::variant::mesh::Vertex;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::markings::corn_snake;
use super::mesh::Mesh;

/// The shape of the snake. The pattern measures lengths in girths of the middle of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snake {
    /// Number of rings of vertices from head to tail.
    pub rings: u32,
    /// Number of vertices in a ring.
    pub sides: u32,
    /// Number of rows of scales around the body. Rows are staggered, so an odd number counts as one less.
    pub scale_rows: u32,
    /// Height of a scale's free end above the next scale, in radii of the body.
    pub relief: f64,
    /// Maximum angle of the orientation field across a scale, degrees: its microstructure fans out.
    pub fan_deg: f64,
}

impl Snake {
    /// A snake of about 250,000 vertices, about ten across a scale.
    pub fn standard() -> Snake {
        Snake { rings: 1100, sides: 216, scale_rows: 24, relief: 0.06, fan_deg: 12.0 }
    }
}

/// Length of the body, and its maximum radius.
const LENGTH: f64 = 11.0;
const RADIUS: f64 = 0.36;
/// Maximum heading of the meander, radians, and its number of bends.
const SWING: f64 = 1.75;
const BENDS: f64 = 1.55;
/// Number of cells side by side in a ribbon of triangles.
const RIBBON: u32 = 8;
/// Length of a scale over its width.
const SLENDER: f64 = 1.5;

/// The snake on the plane `z = 0` with its back towards `+z`. Tangents point to the tail. Columns of the texture run from head
/// to tail.
pub fn snake(snake: &Snake) -> Mesh {
    let Snake { rings, sides, .. } = *snake;
    let spine = spine(snake);
    let columns = sides as usize + 1;
    let places: Vec<DVec3> = (0..(rings as usize + 1) * columns)
        .into_par_iter()
        .map(|i| {
            let (ring, side) = (i / columns, i % columns);
            let around = side as f64 / f64::from(sides);
            let spot = &spine[ring];
            let (height, _) = scale(snake, spot.scales, around);
            spot.surface(around, 1.0 + snake.relief * height)
        })
        .collect();
    let vertex = |i: usize| {
        let (ring, side) = (i / columns, i % columns);
        let around = side as f64 / f64::from(sides);
        let at = |ring: usize, side: usize| places[ring * columns + side];
        // both columns at the seam have the same neighbours
        let (before, after) = (
            if side == 0 { sides as usize - 1 } else { side - 1 },
            if side == sides as usize { 1 } else { side + 1 },
        );
        let along = at((ring + 1).min(rings as usize), side) - at(ring.saturating_sub(1), side);
        let across = at(ring, after) - at(ring, before);
        let normal = along.cross(across).normalize_or_zero();
        let tangent = (along - along.dot(normal) * normal).normalize_or_zero();
        let (_, beside) = scale(snake, spine[ring].scales, around);
        Vertex {
            position: places[i],
            normal,
            tangent: tangent.extend(1.0),
            uv: DVec2::new(ring as f64 / f64::from(rings), around),
            orientation_angle: (2.0 * beside * snake.fan_deg).to_radians(),
        }
    };
    let vertices = (0..places.len()).into_par_iter().map(vertex).collect();
    let cell = |(ring, side): (u32, u32)| {
        let at = |x: u32, y: u32| (ring + x) * (sides + 1) + side + y;
        [[at(0, 0), at(1, 1), at(1, 0)], [at(0, 0), at(0, 1), at(1, 1)]]
    };
    // in ribbons, a driver with a small vertex cache computes most vertices once
    let ribbon = |first: u32| {
        let last = (first + RIBBON).min(sides);
        (0..rings).flat_map(move |ring| (first..last).map(move |side| (ring, side)))
    };
    let triangles = (0..sides).step_by(RIBBON as usize).flat_map(ribbon).flat_map(cell).collect();
    let mut mesh = Mesh::new("snake", vertices, triangles);
    mesh.colour = corn_snake(4096, 512, LENGTH / (TAU * RADIUS));
    mesh
}

/// A point on the spine.
struct Spot {
    centre: DVec3,
    forward: DVec3,
    radius: f64,
    /// Number of scales from the head to here.
    scales: f64,
}

impl Spot {
    /// A point of the skin: `around` is 0 on the belly, 0.5 on the back; `out` is in radii.
    fn surface(&self, around: f64, out: f64) -> DVec3 {
        let (sin, cos) = (TAU * (around - 0.5)).sin_cos();
        let beside = DVec3::Z.cross(self.forward);
        // the belly is flat
        let up = if cos < 0.0 { 0.6 * cos } else { cos };
        self.centre + self.radius * out * (sin * beside + up * DVec3::Z)
    }
}

/// The spine from head to tail: a meander whose heading is a sine of the length (Langbein & Leopold 1966).
fn spine(snake: &Snake) -> Vec<Spot> {
    let rings = snake.rings;
    let rows = f64::from(snake.scale_rows);
    let step = LENGTH / f64::from(rings);
    let mut centre = DVec3::ZERO;
    let mut scales = 0.0;
    let spot = |ring: u32| {
        let share = f64::from(ring) / f64::from(rings);
        let heading = SWING * (TAU * BENDS * share + 0.4).sin();
        let forward = DVec3::new(heading.cos(), heading.sin(), 0.0);
        let radius = RADIUS * girth(share);
        let spot = Spot { centre: centre + 0.6 * radius * DVec3::Z, forward, radius, scales };
        centre += step * forward;
        // scales keep their shape where the body is thick, and have a minimum size
        scales += step / (SLENDER * TAU * radius.max(0.12 * RADIUS) / rows);
        spot
    };
    (0..=rings).map(spot).collect()
}

/// Radius divided by the maximum radius: a head with a blunt snout, a neck, a body, a pointed tail.
fn girth(share: f64) -> f64 {
    let ease = |from: f64, to: f64| {
        let t = ((share - from) / (to - from)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let snout = (1.0 - (1.0 - share / 0.04).max(0.0).powi(2)).max(0.0).sqrt();
    let head = 0.62 - 0.16 * ease(0.05, 0.085);
    let body = head + 0.54 * ease(0.09, 0.35);
    let tail = ((1.0 - share) / 0.45).clamp(0.0, 1.0).powf(0.75);
    (snout * body * tail).max(1e-3)
}

/// Height of the scales above the skin at a point, 0 to 1, and the distance from the keel, -0.5 to 0.5 of a scale's width.
///
/// Scales lie in rows, staggered by half a scale. Each is a tilted plate with its free end towards the tail. The highest plate
/// at a point is the visible one.
fn scale(snake: &Snake, along: f64, around: f64) -> (f64, f64) {
    let rows = f64::from(snake.scale_rows & !1);
    let column = around * rows;
    let mut best = (0.0, 0.0);
    for neighbour in -1..=1 {
        let row = column.round() + f64::from(neighbour);
        let beside = column - row;
        let stagger = if row.rem_euclid(2.0) < 1.0 { 0.0 } else { 0.5 };
        let nearest = (along - stagger).round() + stagger;
        for number in -1..=1 {
            let behind = along - (nearest + f64::from(number));
            // pointed at the free end, 1.6 scales long and 1.5 wide
            let outline = (behind / 0.8).abs().powf(2.2) + (beside / 0.75).abs().powf(2.0);
            if outline > 1.0 {
                continue;
            }
            // less curved across than the body, so that a whole scale lights up at once
            let plate = 0.5 + 0.6 * behind + 0.25 * beside * beside;
            let keel = 0.1 * (-(beside / 0.07).powi(2)).exp() * (1.0 - (behind / 0.8).powi(2));
            let height = (plate + keel) * (1.0 - outline.powi(6));
            if height > best.0 {
                best = (height, beside.clamp(-0.5, 0.5));
            }
        }
    }
    best
}
