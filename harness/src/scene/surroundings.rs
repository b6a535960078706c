//! Skies and maps around a scene: what is seen behind a body, and what a white body shows under them.

use std::f64::consts::{PI, TAU};

use diffraction_shaders::light::{Emitter, Environment, Filtered, Light};
use diffraction_shaders::optics::colour::luminance;
use diffraction_shaders::optics::direction;
use diffraction_shaders::variant::mesh::MeshParams;
use glam::{DVec3, DVec4};
use rayon::prelude::*;

/// Rows and columns of [`Surroundings`]' table.
pub const TABLE: [usize; 2] = [45, 90];
/// Rows and columns of the parts into which maps are divided. A part counts by the integral of its light times direction, which is
/// exact for normals from which it is above the horizon as a whole, or not at all.
const PARTS: [usize; 2] = [64, 128];
/// Fewest rows at which a map is read.
const ROWS: usize = 256;

/// All skies and maps among lights in levels of blur, in the frame of the file of lights. `None` if there are none.
pub fn filtered(lights: &[Light]) -> Option<Filtered> {
    let found = lights.iter().filter_map(Light::filtered);
    found.reduce(|sum, next| sum.plus(&next))
}

/// From the frame of a file of lights to the world, and back: theta counts from `+y`, phi from `+x` towards `+z`. It mirrors.
pub fn turned(direction: DVec3) -> DVec3 {
    DVec3::new(direction.x, direction.z, direction.y)
}

/// The radiance of a white diffuser by its normal, under all skies and maps of a scene, linear sRGB: the integral of the radiance times
/// the cosine, over π.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// `[row][column]`: theta from `+y`, the first and the last row at the poles; phi from `+x` towards `+z`, the first column at -180°.
    whites: Vec<DVec3>,
}

impl Surroundings {
    /// Of the lights in the world that are skies and maps. `None` if there are none.
    pub fn new(lights: &[Light]) -> Option<Surroundings> {
        if !lights.iter().any(Light::is_all_round) {
            return None;
        }
        let (mut even, mut parts) = (DVec3::ZERO, Vec::new());
        for (light, colour) in lights.iter().map(Light::white) {
            match light {
                Light::Sky { radiance } => even += *radiance * colour,
                Light::Environment(environment) => parts.extend(moments(environment, colour)),
                _ => {}
            }
        }
        let [rows, columns] = TABLE;
        let white = |i: usize| {
            let theta = (i / columns) as f64 / (rows - 1) as f64 * 180.0;
            let phi = (i % columns) as f64 / columns as f64 * 360.0 - 180.0;
            let normal = turned(direction(theta, phi));
            even + parts.iter().map(|part| above(part, normal)).sum::<DVec3>() / PI
        };
        Some(Surroundings { whites: (0..rows * columns).into_par_iter().map(white).collect() })
    }

    /// What a white diffuser with this normal shows. The table is bilinear, as in the shader.
    pub fn white(&self, normal: DVec3) -> DVec3 {
        let [rows, columns] = TABLE;
        let theta = normal.x.hypot(normal.z).atan2(normal.y);
        let row = (theta / PI * (rows - 1) as f64).clamp(0.0, (rows - 1) as f64);
        let column = (normal.z.atan2(normal.x) + PI) / TAU * columns as f64;
        let (top, left) = (row.floor(), column.floor());
        let texel = |row: f64, column: f64| {
            let row = (row as usize).min(rows - 1);
            self.whites[row * columns + column as usize % columns]
        };
        let line = |row: f64| texel(row, left).lerp(texel(row, left + 1.0), column - left);
        line(top).lerp(line(top + 1.0), row - top)
    }

    /// The most that a white diffuser shows, whatever it faces: luminance.
    pub fn brightest(&self) -> f64 {
        self.whites.iter().map(|white| luminance(*white)).fold(0.0, f64::max)
    }

    /// The table for a shader, four numbers to a texel.
    pub fn numbers(&self) -> Vec<f32> {
        self.whites.iter().flat_map(|white| white.extend(0.0).as_vec4().to_array()).collect()
    }
}

/// Of a part of a map: integral of its red, green and blue radiance times the direction, in the world.
type Moment = [DVec3; 3];

/// What a part gives to a normal: red, green, blue.
fn above(part: &Moment, normal: DVec3) -> DVec3 {
    DVec3::from(part.map(|channel| channel.dot(normal).max(0.0)))
}

fn moments(environment: &Environment, colour: DVec3) -> Vec<Moment> {
    let panorama = &environment.panorama;
    let fold = ROWS.div_ceil(panorama.height);
    let (rows, columns) = (fold * panorama.height, fold * panorama.width.max(2));
    let [part_rows, part_columns] = PARTS;
    let line = |part_row: usize| {
        let mut line = vec![[DVec3::ZERO; 3]; part_columns];
        let edge = |i: usize| i * rows / part_rows;
        for row in edge(part_row)..edge(part_row + 1) {
            let angle = |row: f64| row / rows as f64 * PI;
            let (theta, step) = (angle(row as f64 + 0.5), TAU / columns as f64);
            let share = step * (angle(row as f64).cos() - angle(row as f64 + 1.0).cos());
            for column in 0..columns {
                let phi = (column as f64 + 0.5) * step - PI;
                let radiance = environment.scale * colour * panorama.at(theta, phi);
                let wi = direction(theta.to_degrees(), phi.to_degrees() + environment.rotate_deg);
                let part = &mut line[column * part_columns / columns];
                for (channel, value) in part.iter_mut().zip(radiance.to_array()) {
                    *channel += share * value * turned(wi);
                }
            }
        }
        line
    };
    (0..part_rows).into_par_iter().flat_map_iter(line).collect()
}

/// Adds what is seen behind a body: the lights with a size of a scene, if one of them is a sky or a map. Pixels are radiances
/// times coverage, and coverage, `[row][column]`; coverage stays as it is. Each pixel takes the mean of `side²` places.
pub fn add_behind(
    pixels: &mut [[f32; 4]],
    width: u32,
    lights: &[Light],
    params: &MeshParams,
    side: u32,
) {
    if !lights.iter().any(Light::is_all_round) {
        return;
    }
    let emitters: Vec<(bool, Box<dyn Emitter + '_>)> = lights
        .iter()
        .filter_map(|light| {
            let is_map = matches!(light.white().0, Light::Environment(_));
            Some((is_map, light.emitter()?))
        })
        .collect();
    let radiance = |ray: DVec3| {
        let each = emitters.iter().map(|(is_map, emitter)| {
            let wi = if *is_map { turned(ray) } else { ray };
            if emitter.margin(wi) < 0.0 { DVec3::ZERO } else { emitter.radiance(wi) }
        });
        each.sum::<DVec3>()
    };
    let height = pixels.len() / width as usize;
    let to_world = (params.projection * params.view).inverse();
    let ray = |x: f64, y: f64| {
        let clip =
            DVec4::new(2.0 * x / f64::from(width) - 1.0, 1.0 - 2.0 * y / height as f64, 1.0, 1.0);
        let far = to_world * clip;
        (far.truncate() / far.w - params.eye).normalize()
    };
    pixels.par_iter_mut().enumerate().filter(|(_, pixel)| pixel[3] < 1.0).for_each(|(i, pixel)| {
        let (column, row) = (i % width as usize, i / width as usize);
        let part = |k: u32| (f64::from(k) + 0.5) / f64::from(side);
        let places = (0..side * side).map(|k| [part(k % side), part(k / side)]);
        let sum = places.map(|[x, y]| radiance(ray(column as f64 + x, row as f64 + y)));
        let mean = sum.sum::<DVec3>() / f64::from(side * side);
        let seen = (1.0 - f64::from(pixel[3])) * mean;
        for (channel, value) in pixel.iter_mut().zip(seen.to_array()) {
            *channel += value as f32;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffraction_shaders::light::{Panorama, Studio};
    use std::sync::Arc;

    fn around(panorama: Panorama) -> Environment {
        Environment { panorama: Arc::new(panorama), scale: 1.5, rotate_deg: 40.0 }
    }

    /// The same by summing over directions of the world.
    fn summed(environment: &Environment, normal: DVec3) -> DVec3 {
        let (rows, mut sum) = (400, DVec3::ZERO);
        for row in 0..rows {
            let y = 2.0 * (f64::from(row) + 0.5) / f64::from(rows) - 1.0;
            for column in 0..2 * rows {
                let phi = PI * (f64::from(column) + 0.5) / f64::from(rows);
                let flat = (1.0 - y * y).sqrt();
                let wi = DVec3::new(flat * phi.cos(), y, flat * phi.sin());
                // theta from +y, phi from +x towards +z
                let (theta, phi) = (y.acos(), phi - environment.rotate_deg.to_radians());
                let radiance = environment.scale * environment.panorama.at(theta, phi);
                sum += radiance * wi.dot(normal).max(0.0);
            }
        }
        sum * 2.0 * PI / f64::from(rows * rows) / PI
    }

    fn normals() -> impl Iterator<Item = DVec3> {
        let golden = PI * (3.0 - 5_f64.sqrt());
        (0..60).map(move |i| {
            let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / 60.0;
            let (sin, cos) = (golden * f64::from(i)).sin_cos();
            DVec3::new((1.0 - y * y).sqrt() * cos, y, (1.0 - y * y).sqrt() * sin)
        })
    }

    #[test]
    fn a_white_body_shows_the_integral_over_directions() {
        for (word, studio) in Studio::WORDS {
            for width in [32, 512] {
                let environment = around(studio.panorama(width));
                let found = Surroundings::new(&[Light::Environment(environment.clone())]).unwrap();
                let mirrored = Environment {
                    panorama: Arc::new({
                        let mut panorama = studio.panorama(width);
                        panorama.texels.chunks_exact_mut(width).for_each(<[_]>::reverse);
                        panorama
                    }),
                    ..environment.clone()
                };
                let mirrored = Surroundings::new(&[Light::Environment(mirrored)]).unwrap();
                let most = found.brightest();
                let (mut worst, mut wrong) = (0.0_f64, 0.0_f64);
                for normal in normals() {
                    let sum = summed(&environment, normal);
                    worst = worst.max((found.white(normal) - sum).abs().max_element() / most);
                    wrong = wrong.max((mirrored.white(normal) - sum).abs().max_element() / most);
                }
                println!("{word} {width}: {worst:.1e} of {most:.3}; mirrored: {wrong:.2}");
                assert!(worst < 5e-3, "{word} {width}: {worst}");
                assert!(wrong > 0.1, "{word} {width}: {wrong}");
            }
        }
    }

    #[test]
    fn skies_add_up_with_their_colours() {
        let colour = DVec3::new(0.2, 0.5, 1.0);
        let skies = [Light::Sky { radiance: 2.0 }.coloured(colour), Light::Sky { radiance: 1.0 }];
        let found = Surroundings::new(&skies).unwrap();
        for normal in normals() {
            assert!(found.white(normal).distance(DVec3::new(1.4, 2.0, 3.0)) < 1e-9);
        }
        let one = Panorama { width: 1, height: 1, texels: vec![[0.5, 1.0, 2.0]] };
        let found = Surroundings::new(&[Light::Environment(around(one))]).unwrap();
        for normal in normals() {
            let white = found.white(normal);
            assert!(white.distance(DVec3::new(0.75, 1.5, 3.0)) < 5e-3, "{white}");
        }
        let sun = Light::Direction { direction: DVec3::Y, irradiance: 1.0 };
        assert_eq!(Surroundings::new(&[sun]), None);
    }
}
