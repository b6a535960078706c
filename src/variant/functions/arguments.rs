//! Arguments of functions.

use glam::DVec3;

use crate::field::reference::Directions;
use crate::light::{Cap, Light, Lobe, Polygon, Sky};

use super::FunctionKind;

/// Arguments of one call. All directions are unit vectors in the tangent frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arguments {
    /// Of `diffraction`.
    Direction(Directions),
    /// Of `diffraction_spread`.
    Spread {
        /// To the light and to the viewer.
        directions: Directions,
        /// Standard deviation that widens lobes, in direction cosines.
        spread: f64,
    },
    /// Of `diffraction_disc` and `diffraction_disc_coloured`.
    Disc {
        /// To the middle of the disc.
        axis: DVec3,
        /// Angular radius, up to π/2.
        radius_rad: f64,
        /// Linear sRGB. `None` calls the function of white discs.
        colour: Option<DVec3>,
        /// To the viewer.
        wr: DVec3,
    },
    /// Of `diffraction_rectangle` and `diffraction_rectangle_coloured`.
    Rectangle {
        /// Corners in either order; neighbours may be the same.
        corners: [DVec3; 4],
        /// Linear sRGB. `None` calls the function of white quadrilaterals.
        colour: Option<DVec3>,
        /// To the viewer.
        wr: DVec3,
    },
    /// Of `diffraction_environment`.
    Environment {
        /// The surroundings.
        around: Around,
        /// To the viewer.
        wr: DVec3,
    },
    /// Of `diffraction_path`; the result is the light of the path.
    Path {
        /// Where the light comes from. Only the first lobe counts.
        sky: Sky,
        /// Random numbers, 0 to 1.
        random: DVec3,
        /// To the viewer.
        wr: DVec3,
    },
}

/// What surrounds the surface in a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Around {
    /// A sky that is given by a formula.
    Sky(Sky),
    /// What whoever evaluates the call has.
    Host,
}

impl Arguments {
    /// The function that has these arguments.
    pub fn kind(&self) -> FunctionKind {
        match self {
            Arguments::Direction(_) => FunctionKind::Direction,
            Arguments::Spread { .. } => FunctionKind::Spread,
            Arguments::Disc { colour: None, .. } => FunctionKind::Disc,
            Arguments::Disc { .. } => FunctionKind::DiscColoured,
            Arguments::Rectangle { colour: None, .. } => FunctionKind::Rectangle,
            Arguments::Rectangle { .. } => FunctionKind::RectangleColoured,
            Arguments::Environment { .. } => FunctionKind::Environment,
            Arguments::Path { .. } => FunctionKind::Path,
        }
    }

    /// The same under a lamp of another colour, linear sRGB. Directions have none, and surroundings bring their own.
    #[must_use]
    pub fn coloured(mut self, of: DVec3) -> Arguments {
        match &mut self {
            Arguments::Disc { colour, .. } | Arguments::Rectangle { colour, .. } => {
                *colour = Some(of);
            }
            Arguments::Direction(_)
            | Arguments::Spread { .. }
            | Arguments::Environment { .. }
            | Arguments::Path { .. } => {}
        }
        self
    }

    /// The same with the nearest numbers of 32 bits, as a shader receives them.
    #[must_use]
    pub fn rounded(self) -> Arguments {
        let single = |v: DVec3| v.as_vec3().as_dvec3();
        match self {
            Arguments::Direction(Directions { wi, wr }) => {
                Arguments::Direction(Directions { wi: single(wi), wr: single(wr) })
            }
            Arguments::Spread { directions: Directions { wi, wr }, spread } => Arguments::Spread {
                directions: Directions { wi: single(wi), wr: single(wr) },
                spread: f64::from(spread as f32),
            },
            Arguments::Disc { axis, radius_rad, colour, wr } => Arguments::Disc {
                axis: single(axis),
                radius_rad: f64::from(radius_rad as f32),
                colour: colour.map(single),
                wr: single(wr),
            },
            Arguments::Rectangle { corners, colour, wr } => Arguments::Rectangle {
                corners: corners.map(single),
                colour: colour.map(single),
                wr: single(wr),
            },
            Arguments::Environment { around, wr } => {
                Arguments::Environment { around, wr: single(wr) }
            }
            Arguments::Path { sky, random, wr } => {
                Arguments::Path { sky, random: single(random), wr: single(wr) }
            }
        }
    }

    /// The light with a size, of radiance 1 or irradiance 1. `None` for a single direction, and for corners that are those of
    /// no convex polygon.
    pub fn lamp(&self) -> Option<Light> {
        match *self {
            Arguments::Direction(_)
            | Arguments::Spread { .. }
            | Arguments::Environment { .. }
            | Arguments::Path { .. } => None,
            Arguments::Disc { axis, radius_rad, colour, .. } => {
                let disc = Light::Disc { cap: Cap { axis, radius_rad }, irradiance: 1.0 };
                Some(disc.coloured(colour.unwrap_or(DVec3::ONE)))
            }
            Arguments::Rectangle { corners, colour, .. } => {
                let mut distinct = corners.to_vec();
                distinct.dedup();
                if distinct.len() > 1 && distinct.first() == distinct.last() {
                    distinct.pop();
                }
                let polygon = Polygon::new(&distinct).ok()?;
                let polygon = Light::Polygon { polygon, radiance: 1.0 };
                Some(polygon.coloured(colour.unwrap_or(DVec3::ONE)))
            }
        }
    }

    /// To the viewer.
    pub fn wr(&self) -> DVec3 {
        match *self {
            Arguments::Direction(Directions { wr, .. })
            | Arguments::Spread { directions: Directions { wr, .. }, .. }
            | Arguments::Disc { wr, .. }
            | Arguments::Rectangle { wr, .. }
            | Arguments::Environment { wr, .. }
            | Arguments::Path { wr, .. } => wr,
        }
    }

    /// Calls whose results add up to the light with a size that a viewer sees, each with its factor. Empty for lights that no
    /// function has. A polygon is divided into a fan of quadrilaterals.
    pub fn under(light: &Light, wr: DVec3) -> Vec<(Arguments, f64)> {
        let (white, colour) = light.white();
        let colour = Some(colour).filter(|colour| *colour != DVec3::ONE);
        match white {
            Light::Disc { cap, irradiance } => {
                let Cap { axis, radius_rad } = *cap;
                vec![(Arguments::Disc { axis, radius_rad, colour, wr }, *irradiance)]
            }
            Light::Polygon { polygon, radiance } => {
                let corners = polygon.corners();
                let last = corners.len() - 1;
                let part = |i: usize| {
                    let ends = [i, i + 1, (i + 2).min(last)].map(|i| corners[i]);
                    let corners = [corners[0], ends[0], ends[1], ends[2]];
                    (Arguments::Rectangle { corners, colour, wr }, *radiance)
                };
                (1..last).step_by(2).map(part).collect()
            }
            Light::Sky { .. } | Light::Environment(_) => {
                vec![(Arguments::Environment { around: Around::Host, wr }, 1.0)]
            }
            Light::Direction { .. } | Light::Coloured { .. } => Vec::new(),
        }
    }

    /// Number of numbers of [`Arguments::to_numbers`].
    pub fn width(kind: FunctionKind) -> usize {
        match kind {
            FunctionKind::Direction => 6,
            FunctionKind::Spread | FunctionKind::Disc => 7,
            FunctionKind::DiscColoured => 10,
            FunctionKind::Rectangle => 15,
            FunctionKind::RectangleColoured => 18,
            FunctionKind::Environment => 20,
            FunctionKind::Path => 23,
        }
    }

    /// The numbers, the viewer last.
    pub fn to_numbers(&self) -> Vec<f64> {
        let numbers = |colour: Option<DVec3>| {
            colour.map_or_else(Vec::new, |colour| colour.to_array().to_vec())
        };
        match *self {
            Arguments::Direction(Directions { wi, wr }) => [wi, wr].map(|v| v.to_array()).concat(),
            Arguments::Spread { directions: Directions { wi, wr }, spread } => {
                [&wi.to_array()[..], &[spread], &wr.to_array()].concat()
            }
            Arguments::Disc { axis, radius_rad, colour, wr } => {
                [&axis.to_array()[..], &[radius_rad], &numbers(colour), &wr.to_array()].concat()
            }
            Arguments::Rectangle { corners, colour, wr } => {
                let corners = corners.map(|v| v.to_array()).concat();
                [corners, numbers(colour), wr.to_array().to_vec()].concat()
            }
            Arguments::Environment { around, wr } => {
                let sky = match around {
                    Around::Sky(sky) => sky,
                    Around::Host => Sky::default(),
                };
                [of_sky(&sky), wr.to_array().to_vec()].concat()
            }
            Arguments::Path { sky, random, wr } => {
                [of_sky(&sky), random.to_array().to_vec(), wr.to_array().to_vec()].concat()
            }
        }
    }

    /// The inverse of [`Arguments::to_numbers`]. `None` if there are too few numbers.
    pub fn from_numbers(kind: FunctionKind, numbers: &[f64]) -> Option<Arguments> {
        let vector = |at: usize| Some(DVec3::from(*numbers.get(at..)?.first_chunk::<3>()?));
        let lobe = |at: usize| {
            let (axis, radiance) = (vector(at)?, vector(at + 4)?);
            Some(Lobe { axis, sigma_rad: *numbers.get(at + 3)?, radiance })
        };
        let sky = || Some(Sky { constant: vector(0)?, lobes: [lobe(3)?, lobe(10)?] });
        Some(match kind {
            FunctionKind::Direction => {
                Arguments::Direction(Directions { wi: vector(0)?, wr: vector(3)? })
            }
            FunctionKind::Spread => Arguments::Spread {
                directions: Directions { wi: vector(0)?, wr: vector(4)? },
                spread: *numbers.get(3)?,
            },
            FunctionKind::Disc => Arguments::Disc {
                axis: vector(0)?,
                radius_rad: *numbers.get(3)?,
                colour: None,
                wr: vector(4)?,
            },
            FunctionKind::DiscColoured => Arguments::Disc {
                axis: vector(0)?,
                radius_rad: *numbers.get(3)?,
                colour: Some(vector(4)?),
                wr: vector(7)?,
            },
            FunctionKind::Rectangle => Arguments::Rectangle {
                corners: [vector(0)?, vector(3)?, vector(6)?, vector(9)?],
                colour: None,
                wr: vector(12)?,
            },
            FunctionKind::RectangleColoured => Arguments::Rectangle {
                corners: [vector(0)?, vector(3)?, vector(6)?, vector(9)?],
                colour: Some(vector(12)?),
                wr: vector(15)?,
            },
            FunctionKind::Environment => {
                Arguments::Environment { around: Around::Sky(sky()?), wr: vector(17)? }
            }
            FunctionKind::Path => {
                Arguments::Path { sky: sky()?, random: vector(17)?, wr: vector(20)? }
            }
        })
    }
}

/// The numbers of a sky.
fn of_sky(sky: &Sky) -> Vec<f64> {
    let lobe = |lobe: &Lobe| {
        let Lobe { axis, sigma_rad, radiance } = *lobe;
        [&axis.to_array()[..], &[sigma_rad], &radiance.to_array()].concat()
    };
    let lobes = sky.lobes.iter().flat_map(lobe).collect();
    [sky.constant.to_array().to_vec(), lobes].concat()
}
