//! What shines on a surface: single directions, discs, polygons, the sky, maps of surroundings; as data, and as radiance from a
//! direction.
//!
//! Directions are unit vectors in the tangent frame that point away from the surface. Radiance 1 is that of a white of
//! `Y = 1` under the illuminant of the optics. Irradiance is measured perpendicular to the light: a white diffuser that
//! faces a light of irradiance E shows the radiance E/π. Colours are linear sRGB; white is the illuminant.

mod cap;
pub mod environment;
mod parse;
mod polygon;
mod sky;

use std::f64::consts::PI;

use glam::DVec3;

pub use cap::Cap;
pub use environment::filtered::Filtered;
pub use environment::{
    Environment, Lamp, LampSearch, MAX_LAMP_DEG, MAX_LAMPS, Panorama, Studio, TakenOut,
};
pub use polygon::{MAX_CORNERS, Polygon, PolygonFault};
pub use sky::{Lobe, Sky, Surroundings};

/// All lights of a `lights.toml`, in its order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// At least one.
    pub all: Vec<Light>,
    /// What a user should know about its files.
    pub notes: Vec<String>,
}

/// One light. It is white unless it is [`Light::Coloured`] or an environment.
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
    /// A map of the surroundings.
    Environment(Environment),
    /// A white light behind a filter.
    Coloured {
        /// The white light.
        light: Box<Light>,
        /// Linear sRGB.
        colour: DVec3,
    },
}

/// A light with a size, as radiance over directions.
pub trait Emitter: Sync {
    /// A cap that contains the light.
    fn bounds(&self) -> Cap;

    /// Positive inside the light, negative outside, and continuous.
    fn margin(&self, wi: DVec3) -> f64;

    /// Radiance from a direction inside the light, linear sRGB.
    fn radiance(&self, wi: DVec3) -> DVec3;

    /// Angle over which its radiance may be taken for a polynomial, radians.
    fn grain_rad(&self) -> f64 {
        PI
    }
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

    fn radiance(&self, _: DVec3) -> DVec3 {
        DVec3::splat(self.radiance)
    }
}

impl Emitter for Uniform<'_, Polygon> {
    fn bounds(&self) -> Cap {
        self.region.bounds()
    }

    fn margin(&self, wi: DVec3) -> f64 {
        self.region.margin(wi)
    }

    fn radiance(&self, _: DVec3) -> DVec3 {
        DVec3::splat(self.radiance)
    }
}

/// A light behind a filter.
struct Tinted<'a> {
    light: Box<dyn Emitter + 'a>,
    colour: DVec3,
}

impl Emitter for Tinted<'_> {
    fn bounds(&self) -> Cap {
        self.light.bounds()
    }

    fn margin(&self, wi: DVec3) -> f64 {
        self.light.margin(wi)
    }

    fn radiance(&self, wi: DVec3) -> DVec3 {
        self.colour * self.light.radiance(wi)
    }

    fn grain_rad(&self) -> f64 {
        self.light.grain_rad()
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
            Light::Sky { radiance } => Some(Box::new(Sky::everywhere(DVec3::splat(*radiance)))),
            Light::Environment(environment) => Some(Box::new(environment.clone())),
            Light::Coloured { light, colour } => {
                let light = light.emitter()?;
                Some(Box::new(Tinted { light, colour: *colour }))
            }
        }
    }

    /// The light without its filter, and the filter's colour; white for a light without one.
    pub fn white(&self) -> (&Light, DVec3) {
        match self {
            Light::Coloured { light, colour } => {
                let (white, inner) = light.white();
                (white, inner * *colour)
            }
            light => (light, DVec3::ONE),
        }
    }

    /// The light behind a filter; itself if the colour is white.
    #[must_use]
    pub fn coloured(self, colour: DVec3) -> Light {
        if colour == DVec3::ONE { self } else { Light::Coloured { light: Box::new(self), colour } }
    }

    /// Whether it comes from all around: a sky or a map.
    pub fn is_all_round(&self) -> bool {
        matches!(self.white().0, Light::Sky { .. } | Light::Environment(_))
    }

    /// What shaders see of it, blurred as far as asked for, if it comes from all around: a sky by its formula, a map in levels.
    pub fn surroundings(&self) -> Option<Box<dyn Surroundings>> {
        match self.white() {
            (Light::Sky { radiance }, colour) => {
                Some(Box::new(Sky::everywhere(*radiance * colour)))
            }
            _ => Some(Box::new(self.filtered()?)),
        }
    }

    /// Its radiance over all directions in levels of blur, if it comes from all around.
    pub fn filtered(&self) -> Option<Filtered> {
        let (light, colour) = self.white();
        match light {
            Light::Sky { radiance } => Some(Filtered::of(&Sky::everywhere(*radiance * colour))),
            Light::Environment(environment) => {
                let finer = environment.panorama.height.div_ceil(environment::filtered::ROWS);
                Some(Filtered::blurred(&|d| colour * environment.radiance(d), finer))
            }
            _ => None,
        }
    }

    /// The word of its kind in `lights.toml`.
    pub fn kind(&self) -> &'static str {
        match self {
            Light::Direction { .. } => "direction",
            Light::Disc { .. } => "disc",
            Light::Polygon { .. } => "polygon",
            Light::Sky { .. } => "sky",
            Light::Environment(_) => "environment",
            Light::Coloured { light, .. } => light.kind(),
        }
    }
}

impl Lights {
    /// Lights of single directions: unit vector, irradiance and colour.
    pub fn directions(&self) -> impl Iterator<Item = (DVec3, f64, DVec3)> {
        self.all.iter().filter_map(|light| match light.white() {
            (Light::Direction { direction, irradiance }, colour) => {
                Some((*direction, *irradiance, colour))
            }
            _ => None,
        })
    }

    /// Lights with a size.
    pub fn with_size(&self) -> impl Iterator<Item = &Light> {
        self.all.iter().filter(|light| !matches!(light.white().0, Light::Direction { .. }))
    }
}
