//! The lights of a scene, with directions in the world, and what a white diffuser shows under them.

use std::f64::consts::PI;

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::light::{Cap, Light, Polygon};
use diffraction_shaders::optics::colour::luminance;
use diffraction_shaders::runner::{NO_SPECTRUM, missing};
use diffraction_shaders::variant::Form;
use glam::DVec3;

use super::surroundings::{Surroundings, turned};

/// Maximum number of lights of each kind in a picture.
pub const MAX_LIGHTS: usize = 4;

/// A light of a file in the world: theta counts from `+y`, phi from `+x` towards `+z`. A map keeps its own frame, which
/// [`turned`] takes into the world.
pub fn in_world(light: &Light) -> Result<Light> {
    Ok(match light {
        Light::Direction { direction, irradiance } => {
            Light::Direction { direction: turned(*direction), irradiance: *irradiance }
        }
        Light::Disc { cap: Cap { axis, radius_rad }, irradiance } => Light::Disc {
            cap: Cap { axis: turned(*axis), radius_rad: *radius_rad },
            irradiance: *irradiance,
        },
        Light::Polygon { polygon, radiance } => {
            let corners: Vec<DVec3> = polygon.corners().iter().map(|c| turned(*c)).collect();
            let fault = |_| Error::new("light", "is no convex polygon in the world");
            Light::Polygon { polygon: Polygon::new(&corners).map_err(fault)?, radiance: *radiance }
        }
        Light::Sky { radiance } => Light::Sky { radiance: *radiance },
        Light::Environment(environment) => Light::Environment(environment.clone()),
        Light::Coloured { light, colour } => in_world(light)?.coloured(*colour),
    })
}

/// Why a scene cannot show what a variant diffracts of a light. `None` if it can. `subject` names the light, `name` the variant.
pub fn refused(subject: &str, name: &str, form: &Form, light: &Light) -> Option<Error> {
    let kind = light.kind();
    let alone = "--no-diffraction draws the body and what is behind it alone";
    match light.white() {
        (Light::Direction { .. }, colour) if colour != DVec3::ONE => {
            let DVec3 { x, y, z } = colour;
            let cause = format!(
                "a light of kind {kind:?} has the colour [{x:.3}, {y:.3}, {z:.3}], but {NO_SPECTRUM}"
            );
            let remedy = "make it a light of kind \"disc\", as wide as its source, for a variant with mode = \"orders\", or remove its colour";
            Some(Error::new(subject, cause).remedy(format!("{remedy}; {alone}")))
        }
        (Light::Direction { .. }, _) => None,
        (white, _) => missing(name, form, light).map(|_| {
            let function = if white.is_all_round() { "environment" } else { kind };
            let cause =
                format!("the variant {name} has no function for a light of kind \"{kind}\"");
            Error::new(subject, cause).remedy(format!(
                "use a variant with mode = \"orders\" and {function:?} in its lights; {alone}"
            ))
        }),
    }
}

/// Direction to the middle of a light.
pub fn middle(light: &Light) -> DVec3 {
    match light {
        Light::Direction { direction, .. } => *direction,
        Light::Disc { cap, .. } => cap.axis,
        Light::Polygon { polygon, .. } => polygon.corners().iter().sum::<DVec3>().normalize(),
        Light::Sky { .. } | Light::Environment(_) => DVec3::Y,
        Light::Coloured { light, .. } => middle(light),
    }
}

/// Radiance of a white diffuser that faces a light; that of coloured light is a luminance. Of a map it is the most that any diffuser
/// shows.
pub fn facing(light: &Light) -> f64 {
    match light {
        Light::Direction { irradiance, .. } | Light::Disc { irradiance, .. } => irradiance / PI,
        Light::Polygon { polygon, radiance } => {
            let corners = polygon.corners();
            let edges = corners.iter().zip(corners.iter().cycle().skip(1));
            radiance / PI * 0.5 * edges.map(|(a, b)| edge(*a, *b)).sum::<DVec3>().length()
        }
        Light::Sky { radiance } => *radiance,
        Light::Environment(_) => brightest(light),
        Light::Coloured { light: map, colour } => match **map {
            Light::Environment(_) => brightest(light),
            _ => luminance(*colour) * facing(map),
        },
    }
}

fn brightest(map: &Light) -> f64 {
    Surroundings::new(std::slice::from_ref(map)).map_or(0.0, |found| found.brightest())
}

/// Irradiance of a surface with this normal, linear sRGB; for skies and maps see [`Surroundings`], here they give none. Of a disc it is that of its middle: a disc across the horizon counts whole or not at
/// all. That of a polygon is exact.
pub fn irradiance(light: &Light, normal: DVec3) -> DVec3 {
    let (light, colour) = light.white();
    colour
        * match light {
            Light::Direction { direction: axis, irradiance }
            | Light::Disc { cap: Cap { axis, .. }, irradiance } => {
                irradiance * axis.dot(normal).max(0.0)
            }
            Light::Polygon { polygon, radiance } => radiance * above(polygon.corners(), normal),
            Light::Sky { .. } | Light::Environment(_) | Light::Coloured { .. } => 0.0,
        }
}

/// Integral of the cosine to the normal over the part of a polygon above the horizon: half the sum over its edges (Lambert 1760;
/// Arvo 1995, "Applications of irradiance tensors to the simulation of non-Lambertian phenomena"). Where the polygon is cut, the
/// horizon is an edge.
fn above(corners: &[DVec3], normal: DVec3) -> f64 {
    let mut part = Vec::new();
    for (i, &start) in corners.iter().enumerate() {
        let end = corners[(i + 1) % corners.len()];
        let (from, to) = (start.dot(normal), end.dot(normal));
        if from > 0.0 {
            part.push(start);
        }
        if (from > 0.0) != (to > 0.0) {
            part.push(start.lerp(end, from / (from - to)).normalize());
        }
    }
    let edges = part.iter().zip(part.iter().cycle().skip(1));
    0.5 * edges.map(|(a, b)| edge(*a, *b).dot(normal)).sum::<f64>().abs()
}

/// The angle of an edge times the normal of its plane.
fn edge(start: DVec3, end: DVec3) -> DVec3 {
    let across = start.cross(end);
    across.normalize_or_zero() * across.length().atan2(start.dot(end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffraction_shaders::optics::direction;

    fn polygon(corners: &[[f64; 2]]) -> Light {
        let corners: Vec<DVec3> = corners.iter().map(|[t, p]| direction(*t, *p)).collect();
        Light::Polygon { polygon: Polygon::new(&corners).unwrap(), radiance: 2.0 }
    }

    /// The same by summing over directions.
    fn summed(light: &Light, normal: DVec3) -> f64 {
        let Light::Polygon { polygon, radiance } = light else { return 0.0 };
        let (mut sum, steps) = (0.0, 1200);
        for row in 0..steps {
            let z = 2.0 * (f64::from(row) + 0.5) / f64::from(steps) - 1.0;
            for column in 0..2 * steps {
                let phi = PI * (f64::from(column) + 0.5) / f64::from(steps);
                let wi = (DVec3::new(phi.cos(), phi.sin(), 0.0) * (1.0 - z * z).sqrt()).with_z(z);
                if polygon.margin(wi) > 0.0 {
                    sum += wi.dot(normal).max(0.0);
                }
            }
        }
        radiance * sum * 2.0 * PI / f64::from(steps * steps)
    }

    #[test]
    fn irradiance_of_polygons_is_the_sum_over_directions() {
        let window = polygon(&[[10.0, 0.0], [60.0, 0.0], [60.0, 70.0], [30.0, 90.0]]);
        for normal in [DVec3::Z, direction(60.0, 30.0), direction(120.0, 10.0), DVec3::NEG_Y] {
            let (exact, sum) = (irradiance(&window, normal).x, summed(&window, normal));
            assert!((exact - sum).abs() < 2e-3, "{normal}: {exact} {sum}");
        }
        assert!(irradiance(&window, direction(120.0, 10.0)).x > 0.01, "partly above the horizon");
        assert_eq!(irradiance(&window, DVec3::NEG_Z), DVec3::ZERO);
        // a diffuser shows most where it faces the light
        let most = (0..2000).map(|i| {
            let normal = direction(0.09 * f64::from(i % 1000), if i < 1000 { 38.0 } else { 42.0 });
            irradiance(&window, normal).x / PI
        });
        let most = most.fold(0.0, f64::max);
        assert!((most / facing(&window) - 1.0).abs() < 1e-2, "{most} {}", facing(&window));
    }

    #[test]
    fn files_count_from_y_and_from_x_towards_z() {
        let of = |theta, phi| {
            let light = Light::Direction { direction: direction(theta, phi), irradiance: 1.0 };
            middle(&in_world(&light).unwrap())
        };
        assert!(of(0.0, 0.0).distance(DVec3::Y) < 1e-12);
        assert!(of(90.0, 0.0).distance(DVec3::X) < 1e-12);
        assert!(of(90.0, 90.0).distance(DVec3::Z) < 1e-12);
        let window = polygon(&[[10.0, 0.0], [60.0, 0.0], [60.0, 70.0], [30.0, 90.0]]);
        let seen = in_world(&window).unwrap();
        let (m, w) = (middle(&window), middle(&seen));
        assert!(w.distance(DVec3::new(m.x, m.z, m.y)) < 1e-12);
        assert!((facing(&window) - facing(&seen)).abs() < 1e-12);
    }
}
