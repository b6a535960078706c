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
    /// Of `diffraction_disc`.
    Disc {
        /// To the middle of the disc.
        axis: DVec3,
        /// Angular radius, up to π/2.
        radius_rad: f64,
        /// To the viewer.
        wr: DVec3,
    },
    /// Of `diffraction_rectangle`.
    Rectangle {
        /// Corners in either order; neighbours may be the same.
        corners: [DVec3; 4],
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
            Arguments::Disc { .. } => FunctionKind::Disc,
            Arguments::Rectangle { .. } => FunctionKind::Rectangle,
            Arguments::Environment { .. } => FunctionKind::Environment,
        }
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
            Arguments::Disc { axis, radius_rad, wr } => Arguments::Disc {
                axis: single(axis),
                radius_rad: f64::from(radius_rad as f32),
                wr: single(wr),
            },
            Arguments::Rectangle { corners, wr } => {
                Arguments::Rectangle { corners: corners.map(single), wr: single(wr) }
            }
            Arguments::Environment { around, wr } => {
                Arguments::Environment { around, wr: single(wr) }
            }
        }
    }

    /// The light with a size, of radiance 1 or irradiance 1. `None` for a single direction, and for corners that are those of
    /// no convex polygon.
    pub fn lamp(&self) -> Option<Light> {
        match *self {
            Arguments::Direction(_) | Arguments::Spread { .. } | Arguments::Environment { .. } => {
                None
            }
            Arguments::Disc { axis, radius_rad, .. } => {
                Some(Light::Disc { cap: Cap { axis, radius_rad }, irradiance: 1.0 })
            }
            Arguments::Rectangle { corners, .. } => {
                let mut distinct = corners.to_vec();
                distinct.dedup();
                if distinct.len() > 1 && distinct.first() == distinct.last() {
                    distinct.pop();
                }
                let polygon = Polygon::new(&distinct).ok()?;
                Some(Light::Polygon { polygon, radiance: 1.0 })
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
            | Arguments::Environment { wr, .. } => wr,
        }
    }

    /// Calls whose results add up to the light with a size that a viewer sees, each with its factor. Empty for lights that no
    /// function has. A polygon is divided into a fan of quadrilaterals.
    pub fn under(light: &Light, wr: DVec3) -> Vec<(Arguments, f64)> {
        match light {
            Light::Disc { cap, irradiance } => {
                let Cap { axis, radius_rad } = *cap;
                vec![(Arguments::Disc { axis, radius_rad, wr }, *irradiance)]
            }
            Light::Polygon { polygon, radiance } => {
                let corners = polygon.corners();
                let last = corners.len() - 1;
                let part = |i: usize| {
                    let ends = [i, i + 1, (i + 2).min(last)].map(|i| corners[i]);
                    let corners = [corners[0], ends[0], ends[1], ends[2]];
                    (Arguments::Rectangle { corners, wr }, *radiance)
                };
                (1..last).step_by(2).map(part).collect()
            }
            light if light.is_all_round() => {
                vec![(Arguments::Environment { around: Around::Host, wr }, 1.0)]
            }
            // of coloured lamps there are no functions
            _ => Vec::new(),
        }
    }

    /// Number of numbers of [`Arguments::to_numbers`].
    pub fn width(kind: FunctionKind) -> usize {
        match kind {
            FunctionKind::Direction => 6,
            FunctionKind::Spread | FunctionKind::Disc => 7,
            FunctionKind::Rectangle => 15,
            FunctionKind::Environment => 20,
        }
    }

    /// The numbers, the viewer last.
    pub fn to_numbers(&self) -> Vec<f64> {
        match *self {
            Arguments::Direction(Directions { wi, wr }) => [wi, wr].map(|v| v.to_array()).concat(),
            Arguments::Spread { directions: Directions { wi, wr }, spread } => {
                [&wi.to_array()[..], &[spread], &wr.to_array()].concat()
            }
            Arguments::Disc { axis, radius_rad, wr } => {
                [&axis.to_array()[..], &[radius_rad], &wr.to_array()].concat()
            }
            Arguments::Rectangle { corners: [a, b, c, d], wr } => {
                [a, b, c, d, wr].map(|v| v.to_array()).concat()
            }
            Arguments::Environment { around, wr } => {
                let sky = match around {
                    Around::Sky(sky) => sky,
                    Around::Host => Sky::default(),
                };
                let lobe = |lobe: &Lobe| {
                    let Lobe { axis, sigma_rad, radiance } = *lobe;
                    [&axis.to_array()[..], &[sigma_rad], &radiance.to_array()].concat()
                };
                let lobes = sky.lobes.iter().flat_map(lobe).collect();
                [sky.constant.to_array().to_vec(), lobes, wr.to_array().to_vec()].concat()
            }
        }
    }

    /// The inverse of [`Arguments::to_numbers`]. `None` if there are too few numbers.
    pub fn from_numbers(kind: FunctionKind, numbers: &[f64]) -> Option<Arguments> {
        let vector = |at: usize| Some(DVec3::from(*numbers.get(at..)?.first_chunk::<3>()?));
        Some(match kind {
            FunctionKind::Direction => {
                Arguments::Direction(Directions { wi: vector(0)?, wr: vector(3)? })
            }
            FunctionKind::Spread => Arguments::Spread {
                directions: Directions { wi: vector(0)?, wr: vector(4)? },
                spread: *numbers.get(3)?,
            },
            FunctionKind::Disc => {
                Arguments::Disc { axis: vector(0)?, radius_rad: *numbers.get(3)?, wr: vector(4)? }
            }
            FunctionKind::Rectangle => Arguments::Rectangle {
                corners: [vector(0)?, vector(3)?, vector(6)?, vector(9)?],
                wr: vector(12)?,
            },
            FunctionKind::Environment => {
                let lobe = |at: usize| {
                    let (axis, radiance) = (vector(at)?, vector(at + 4)?);
                    Some(Lobe { axis, sigma_rad: *numbers.get(at + 3)?, radiance })
                };
                let sky = Sky { constant: vector(0)?, lobes: [lobe(3)?, lobe(10)?] };
                Arguments::Environment { around: Around::Sky(sky), wr: vector(17)? }
            }
        })
    }
}
