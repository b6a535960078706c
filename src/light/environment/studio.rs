//! Studios by formula: panoramas that need no file.
//!
//! Their axis points up. All are different on every side, so that a map that is turned, mirrored or upside down is noticed.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::Panorama;
use crate::optics::direction;

/// Each pixel is the mean over this many places along each side.
const PLACES: usize = 4;

/// A panorama by formula. Radiances are from 0.02 to 12.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Studio {
    /// Three rectangular softboxes of different sizes and whites in a dark grey room with a dim floor.
    Softboxes,
    /// A dim warm room with a bright bluish window that has bars.
    Window,
    /// From a sky over the horizon to the ground, with a large soft light.
    Gradient,
}

impl Studio {
    /// The words of `lights.toml`.
    pub const WORDS: [(&'static str, Studio); 3] = [
        ("softboxes", Studio::Softboxes),
        ("window", Studio::Window),
        ("gradient", Studio::Gradient),
    ];

    /// Columns unless a user asks for others.
    pub const WIDTH: usize = 1024;

    /// The panorama with this many columns, an even number, and half as many rows.
    pub fn panorama(self, width: usize) -> Panorama {
        let height = width / 2;
        let texel = |i: usize| {
            let (row, column) = (i / width, i % width);
            let mut sum = DVec3::ZERO;
            for place in 0..PLACES * PLACES {
                let part = |at: usize| (at as f64 + 0.5) / PLACES as f64;
                let theta = (row as f64 + part(place / PLACES)) / height as f64 * 180.0;
                let phi = (column as f64 + part(place % PLACES)) / width as f64 * 360.0 - 180.0;
                sum += self.radiance(direction(theta, phi));
            }
            (sum / (PLACES * PLACES) as f64).as_vec3().to_array()
        };
        let texels = (0..width * height).into_par_iter().map(texel).collect();
        Panorama { width, height, texels }
    }

    /// Radiance from a unit vector, linear sRGB; z is up.
    pub fn radiance(self, wi: DVec3) -> DVec3 {
        match self {
            Studio::Softboxes => softboxes(wi),
            Studio::Window => room(wi),
            Studio::Gradient => gradient(wi),
        }
    }
}

/// A softbox on the sphere: a rectangle of the plane that touches the sphere in its middle.
struct Softbox {
    /// Angle from the axis and about it, of its middle, degrees.
    middle_deg: [f64; 2],
    /// Angle by which it is turned about its middle, degrees.
    roll_deg: f64,
    /// Tangents of the angles from its middle to the middles of its sides.
    half: [f64; 2],
    radiance: [f64; 3],
}

/// From the upper left of a viewer at phi = 90°; a strip to the right; and one from behind.
const SOFTBOXES: [Softbox; 3] = [
    Softbox {
        middle_deg: [52.0, 128.0],
        roll_deg: 12.0,
        half: [0.36, 0.24],
        radiance: [12.0, 11.6, 11.0],
    },
    Softbox {
        middle_deg: [66.0, 28.0],
        roll_deg: -8.0,
        half: [0.10, 0.46],
        radiance: [4.7, 4.9, 5.1],
    },
    Softbox {
        middle_deg: [40.0, -62.0],
        roll_deg: 25.0,
        half: [0.28, 0.13],
        radiance: [7.0, 7.0, 6.8],
    },
];

impl Softbox {
    fn contains(&self, wi: DVec3) -> bool {
        let [theta, phi] = self.middle_deg;
        let middle = direction(theta, phi);
        let ahead = wi.dot(middle);
        if ahead <= 0.0 {
            return false;
        }
        let across = DVec3::Z.cross(middle).normalize();
        let up = middle.cross(across);
        let (sin, cos) = self.roll_deg.to_radians().sin_cos();
        let (x, y) = (wi.dot(across) / ahead, wi.dot(up) / ahead);
        (cos * x + sin * y).abs() < self.half[0] && (cos * y - sin * x).abs() < self.half[1]
    }
}

fn softboxes(wi: DVec3) -> DVec3 {
    if let Some(softbox) = SOFTBOXES.iter().find(|softbox| softbox.contains(wi)) {
        return DVec3::from(softbox.radiance);
    }
    if wi.z >= 0.0 {
        // a little lighter towards the first softbox
        let near = wi.dot(direction(52.0, 128.0)).max(0.0);
        return DVec3::new(0.050, 0.050, 0.053) * (0.7 + 0.9 * near * near);
    }
    // the floor, one unit below, lit where the first softbox hangs over it
    let below = wi.truncate() / -wi.z;
    let pool = (-0.35 * below.distance_squared(DVec2::new(-0.7, 0.9))).exp();
    DVec3::new(0.035, 0.032, 0.030) + DVec3::new(0.30, 0.28, 0.26) * pool
}

/// The walls of the room, by their distances along x, y and z: the lower and the upper.
const ROOM: [[f64; 2]; 3] = [[-1.7, 2.3], [-2.1, 1.6], [-0.9, 1.4]];
/// The window in the wall at the lower x: from and to, along y and z; and the places of its bars.
const WINDOW: [[f64; 2]; 2] = [[-0.5, 1.1], [-0.15, 1.05]];
const BARS: [f64; 2] = [0.30, 0.60];
/// Half the width of a bar.
const BAR: f64 = 0.045;

fn room(wi: DVec3) -> DVec3 {
    let reach = |axis: usize| {
        let [lower, upper] = ROOM[axis];
        if wi[axis] == 0.0 { f64::INFINITY } else { (lower / wi[axis]).max(upper / wi[axis]) }
    };
    let wall = (0..3).min_by(|a, b| reach(*a).total_cmp(&reach(*b))).unwrap_or_default();
    let at = wi * reach(wall);
    let is_upper = wi[wall] > 0.0;
    let inside = |value: f64, [from, to]: [f64; 2]| value > from && value < to;
    if (wall, is_upper) == (0, false) && inside(at.y, WINDOW[0]) && inside(at.z, WINDOW[1]) {
        if (at.y - BARS[0]).abs() < BAR || (at.z - BARS[1]).abs() < BAR {
            return DVec3::new(0.06, 0.05, 0.045);
        }
        // the sky over a darker street
        return match at.z > 0.1 {
            true => DVec3::new(6.3, 8.4, 11.2) * (0.75 + 0.25 * at.z),
            false => DVec3::new(1.9, 2.1, 2.2),
        };
    }
    let colour = match (wall, is_upper) {
        (2, true) => DVec3::new(0.17, 0.15, 0.13),
        (2, false) => DVec3::new(0.62, 0.50, 0.38),
        // a dark cupboard in the wall opposite to the window
        (0, true) if inside(at.y, [-1.2, 0.1]) && inside(at.z, [-0.9, 0.5]) => {
            DVec3::new(0.06, 0.04, 0.03)
        }
        (0, _) => DVec3::new(0.34, 0.27, 0.20),
        (_, true) => DVec3::new(0.30, 0.24, 0.19),
        (_, false) => DVec3::new(0.38, 0.27, 0.17),
    };
    // darker away from the window
    let away = at.distance_squared(DVec3::new(ROOM[0][0], BARS[0], 0.4));
    colour * (0.35 + 1.2 / (1.0 + 0.5 * away))
}

fn gradient(wi: DVec3) -> DVec3 {
    let smooth = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    // lighter on the side of phi = 150°
    let side = 1.0 + 0.35 * wi.truncate().dot(direction(90.0, 150.0).truncate());
    let horizon = DVec3::new(1.05, 0.98, 0.90) * side;
    let base = if wi.z >= 0.0 {
        horizon.lerp(DVec3::new(0.16, 0.28, 0.55), smooth(wi.z.sqrt()))
    } else {
        horizon.lerp(DVec3::new(0.11, 0.085, 0.06), smooth((-6.0 * wi.z).sqrt()))
    };
    let away = wi.angle_between(direction(48.0, 118.0));
    let light = (-0.5 * (away / (PI / 16.0)).powi(2)).exp();
    base + DVec3::new(10.0, 9.4, 8.5) * light
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::Polygon;

    /// Integral of a channel over a hemisphere by the cosine to its axis.
    fn irradiance(of: &dyn Fn(DVec3) -> f64, axis: DVec3) -> f64 {
        let (rows, mut sum) = (600, 0.0);
        for row in 0..rows {
            let theta = 180.0 * (f64::from(row) + 0.5) / f64::from(rows);
            let part = theta.to_radians().sin() * (PI / f64::from(rows)).powi(2);
            for column in 0..2 * rows {
                let wi = direction(theta, 180.0 * (f64::from(column) + 0.5) / f64::from(rows));
                sum += part * of(wi) * wi.dot(axis).max(0.0);
            }
        }
        sum
    }

    #[test]
    fn pixels_are_means_of_the_formula() {
        for (word, studio) in Studio::WORDS {
            let panorama = studio.panorama(256);
            assert_eq!((panorama.width, panorama.height), (256, 128));
            let all = panorama.texels.iter().flatten();
            assert!(all.clone().all(|v| (0.01..=12.0).contains(v)), "{word}");
            assert!(all.clone().any(|v| *v > 9.0) && all.clone().any(|v| *v < 0.1), "{word}");
            // what has no edge near is the formula itself
            let mut near = 0;
            for (row, column) in (1..127).flat_map(|r| (0..256).map(move |c| (r, c))) {
                let theta = (row as f64 + 0.5) / 128.0 * 180.0;
                let wi = direction(theta, (column as f64 + 0.5) / 256.0 * 360.0 - 180.0);
                let texel = DVec3::from(panorama.texels[row * 256 + column].map(f64::from));
                let formula = studio.radiance(wi);
                near += usize::from(texel.distance(formula) < 0.05 * formula.length());
            }
            assert!(near as f64 > 0.95 * 126.0 * 256.0, "{word}: {near}");
            let (panorama_red, red) = (
                irradiance(
                    &|wi| panorama.at(wi.z.acos(), wi.y.atan2(wi.x)).x,
                    direction(40.0, 90.0),
                ),
                irradiance(&|wi| studio.radiance(wi).x, direction(40.0, 90.0)),
            );
            assert!((panorama_red / red - 1.0).abs() < 5e-3, "{word}: {panorama_red} {red}");
        }
    }

    /// No turn by a part of a circle, no mirror image and no exchange of up and down gives the same panorama.
    #[test]
    fn turned_and_mirrored_ones_are_others() {
        for (word, studio) in Studio::WORDS {
            let (width, height) = (64, 32);
            let panorama = studio.panorama(width);
            let texel = |row: usize, column: usize| {
                DVec3::from(panorama.texels[row * width + column % width].map(f64::from))
            };
            let apart = |other: &dyn Fn(usize, usize) -> DVec3| {
                let places = (0..height).flat_map(|row| (0..width).map(move |c| (row, c)));
                let all = places.map(|(row, c)| texel(row, c).distance(other(row, c)));
                all.sum::<f64>() / (width * height) as f64
            };
            let mean = apart(&|_, _| DVec3::ZERO);
            assert_eq!(apart(&texel), 0.0);
            assert!(apart(&|row, c| texel(height - 1 - row, c)) > 0.2 * mean, "{word}");
            for turn in (4..width).step_by(4) {
                let mirrored = apart(&|row, c| texel(row, turn + width - 1 - c));
                let turned = apart(&|row, c| texel(row, turn + c));
                assert!(mirrored > 0.1 * mean && turned > 0.1 * mean, "{word} {turn}");
            }
        }
    }

    #[test]
    fn a_softbox_is_the_polygon_of_its_corners() {
        let softbox = &SOFTBOXES[0];
        let middle = direction(52.0, 128.0);
        let across = DVec3::Z.cross(middle).normalize();
        let up = middle.cross(across);
        let (sin, cos) = 12_f64.to_radians().sin_cos();
        let corner = |(x, y): (f64, f64)| {
            let (x, y) = (0.36 * x, 0.24 * y);
            (middle + (cos * x - sin * y) * across + (sin * x + cos * y) * up).normalize()
        };
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner);
        let polygon = Polygon::new(&corners).unwrap();
        let inside = |wi: DVec3| f64::from(u8::from(polygon.margin(wi) > 0.0));
        let boxed = |wi: DVec3| f64::from(u8::from(softbox.contains(wi)));
        let apart = irradiance(&|wi| (inside(wi) - boxed(wi)).abs(), middle);
        assert!(apart < 1e-9 && irradiance(&inside, middle) > 0.3, "{apart}");
    }
}
