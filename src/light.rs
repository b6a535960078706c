//! What shines on a surface: single directions, discs, polygons, the sky; as data, and as radiance from a direction.
//!
//! Directions are unit vectors in the tangent frame that point away from the surface. Radiance 1 is that of a white of
//! `Y = 1` under the illuminant of the optics. Irradiance is measured perpendicular to the light: a white diffuser that
//! faces a light of irradiance E shows the radiance E/π.

mod cap;
mod parse;
mod polygon;

use std::f64::consts::PI;

use glam::DVec3;

pub use cap::Cap;
pub use polygon::{MAX_CORNERS, Polygon, PolygonFault};

/// All lights of a `lights.toml`, in its order.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    /// At least one.
    pub all: Vec<Light>,
}

/// One white light.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Light from a single direction.
    Direction {
        /// Unit vector towards the light.
        direction: DVec3,
        /// Irradiance perpendicular to the light.
        irradiance: f64,
    },
    /// A cap of the sphere: the sun, a bulb, a round softbox.
    Disc {
        /// Where it is.
        cap: Cap,
        /// Irradiance perpendicular to its axis.
        irradiance: f64,
    },
    /// A convex spherical polygon: a window, a rectangular softbox.
    Polygon {
        /// Where it is.
        polygon: Polygon,
        /// Its radiance.
        radiance: f64,
    },
    /// The same radiance everywhere.
    Sky {
        /// Its radiance.
        radiance: f64,
    },
}

/// A light with a size, as radiance over directions.
pub trait Emitter: Sync {
    /// A cap that contains the light.
    fn bounds(&self) -> Cap;

    /// Positive inside the light, negative outside, and continuous.
    fn margin(&self, wi: DVec3) -> f64;

    /// Radiance from a direction inside the light.
    fn radiance(&self, wi: DVec3) -> f64;
}

/// A disc or polygon of uniform radiance.
struct Uniform<'a, R> {
    region: &'a R,
    radiance: f64,
}

impl Emitter for Uniform<'_, Cap> {
    fn bounds(&self) -> Cap {
        *self.region
    }

    fn margin(&self, wi: DVec3) -> f64 {
        self.region.margin(wi)
    }

    fn radiance(&self, _: DVec3) -> f64 {
        self.radiance
    }
}

impl Emitter for Uniform<'_, Polygon> {
    fn bounds(&self) -> Cap {
        self.region.bounds()
    }

    fn margin(&self, wi: DVec3) -> f64 {
        self.region.margin(wi)
    }

    fn radiance(&self, _: DVec3) -> f64 {
        self.radiance
    }
}

/// A sky of the same radiance everywhere.
pub struct Everywhere(pub f64);

impl Emitter for Everywhere {
    fn bounds(&self) -> Cap {
        Cap { axis: DVec3::Z, radius_rad: PI }
    }

    fn margin(&self, _: DVec3) -> f64 {
        1.0
    }

    fn radiance(&self, _: DVec3) -> f64 {
        self.0
    }
}

impl Light {
    /// The light as radiance over directions. `None` for a single direction, whose radiance is infinite.
    pub fn emitter(&self) -> Option<Box<dyn Emitter + '_>> {
        match self {
            Light::Direction { .. } => None,
            Light::Disc { cap, irradiance } => {
                Some(Box::new(Uniform { region: cap, radiance: cap.radiance(*irradiance) }))
            }
            Light::Polygon { polygon, radiance } => {
                Some(Box::new(Uniform { region: polygon, radiance: *radiance }))
            }
            Light::Sky { radiance } => Some(Box::new(Everywhere(*radiance))),
        }
    }

    /// The word of its kind in `lights.toml`.
    pub fn kind(&self) -> &'static str {
        match self {
            Light::Direction { .. } => "direction",
            Light::Disc { .. } => "disc",
            Light::Polygon { .. } => "polygon",
            Light::Sky { .. } => "sky",
        }
    }
}

impl Lights {
    /// Lights of single directions: unit vector and irradiance.
    pub fn directions(&self) -> impl Iterator<Item = (DVec3, f64)> {
        self.all.iter().filter_map(|light| match light {
            Light::Direction { direction, irradiance } => Some((*direction, *irradiance)),
            _ => None,
        })
    }

    /// Lights with a size.
    pub fn with_size(&self) -> impl Iterator<Item = &Light> {
        self.all.iter().filter(|light| !matches!(light, Light::Direction { .. }))
    }
}
