//! Maps by formula.
//!
//! Each kind is a function of a place in the picture, in texels from the upper left. It says which groove is there, or none.

mod guilloche;
mod stencil;

use std::f64::consts::TAU;

use glam::{DVec2, USizeVec2};
use rayon::prelude::*;

use super::{PatternMap, Ranges, Texel, check_size};
use crate::error::{Error, Result};
use crate::random::SplitMix64;

pub use stencil::Stencil;

/// Places along each side of a texel whose share with foil is the mask, where a kind has edges.
const PLACES: usize = 4;
/// By how much the logarithm of the period of a flake differs from the mean at most.
const FLAKE_PERIODS: f64 = 0.15;

/// The grating at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Groove {
    /// Direction across the grooves.
    pub angle_rad: f64,
    /// Period over that of the profile.
    pub period_ratio: f64,
    /// Depth over that of the profile.
    pub depth_ratio: f64,
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A disc with concentric grooves: the direction is radial. Rings of equal width have ratios at a third and at two thirds of the
    /// ranges in turns, from the centre.
    Circles {
        /// Number of rings. Without them all has [`Drawing::period_ratio`] and the highest depth.
        rings: Option<u32>,
    },
    /// A picture's shape, centred and as large as fits, with the highest depth. The edge is where [`Stencil`] is 0.5.
    Logo {
        /// The shape.
        logo: Stencil,
        /// The grating outside. Without it there is no foil, and the mask is the share of a texel inside.
        ground: Option<Groove>,
    },
    /// Rosettes of two families of curves that cross, in four rings. Grooves follow the curves, in cells.
    Guilloche,
    /// Random flakes that repeat without a seam: each with its own angle of the whole turn, a period up to 16 % from
    /// [`Drawing::period_ratio`] within the range, and a depth of the range.
    Flakes {
        /// Mean side of a flake, texels.
        size: f64,
        /// Of the random numbers.
        seed: u64,
    },
    /// Period from the lowest on the left to the highest on the right, depth from the lowest below to the highest above.
    Ramp,
    /// Square cells of one grating each.
    Cells {
        /// Side of a cell, texels.
        size: u32,
        /// From a cell to its right and its upper neighbour the angle grows by this, degrees. From a diagonal to the next, ratios go through
        /// a fifth to four fifths of the ranges.
        step_deg: f64,
        /// A picture instead of that: black cells have [`Drawing::angle_deg`], white ones a quarter turn more, at [`Drawing::period_ratio`]
        /// and the highest depth. Transparent ones have no foil.
        picture: Option<Stencil>,
    },
}

/// A map by formula.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// The ratios that may occur.
    pub ranges: Ranges,
    /// Angle of kinds with one direction; others are turned by it.
    pub angle_deg: f64,
    /// Period of kinds with one period.
    pub period_ratio: f64,
    /// What is drawn.
    pub kind: Kind,
}

impl Drawing {
    /// The map, the same for the same drawing.
    pub fn map(&self) -> Result<PatternMap> {
        let subject = "drawing";
        check_size(self.width, self.height, subject)?;
        self.ranges.check(subject)?;
        self.check()?;
        let texel: Box<dyn Fn(DVec2) -> Texel + Sync + '_> = match &self.kind {
            Kind::Circles { rings } => {
                Box::new(edged(move |at| self.circle(self.centred(at), *rings)))
            }
            Kind::Guilloche => Box::new(edged(|at| self.guilloche(self.centred(at)))),
            Kind::Logo { logo, ground } => {
                let inside = self.plain(self.period_ratio, 1.0);
                let fit = logo.fit([self.width, self.height]);
                let is_inside = move |at: DVec2| logo.value(fit(at)) >= 0.5;
                let ground = *ground;
                Box::new(move |at| logo_texel(at, &is_inside, inside, ground))
            }
            Kind::Flakes { size, seed } => {
                let flakes = self.flakes(*size, *seed);
                Box::new(move |at| flakes.groove(at).into())
            }
            Kind::Ramp => Box::new(|at| {
                let share = at / self.size();
                self.plain(self.period(share.x), 1.0 - share.y).into()
            }),
            Kind::Cells { size, step_deg, picture } => {
                let cell = move |at: DVec2| self.cell(at, *size, *step_deg, picture.as_ref());
                Box::new(move |at| cell(at).map_or(NO_FOIL, Texel::from))
            }
        };
        let centre =
            |i: usize| DVec2::new((i % self.width) as f64 + 0.5, (i / self.width) as f64 + 0.5);
        let texels = (0..self.width * self.height).into_par_iter().map(|i| texel(centre(i)));
        PatternMap::new(self.width, self.height, texels.collect(), subject)
    }

    fn check(&self) -> Result<()> {
        let [low, high] = self.ranges.period_ratio;
        let inside = |period: f64| period >= low && period <= high;
        let error = |cause: String| Error::new("drawing", cause);
        let ground = match &self.kind {
            Kind::Logo { ground, .. } => *ground,
            _ => None,
        };
        for period in [Some(self.period_ratio), ground.map(|ground| ground.period_ratio)] {
            if let Some(period) = period.filter(|_| self.has_one_period())
                && !inside(period)
            {
                let cause = format!("has the period ratio {period}, outside of {low} to {high}");
                return Err(error(cause).remedy("give another one, or a wider range"));
            }
        }
        let (name, value) = match self.kind {
            Kind::Circles { rings: Some(rings) } => ("number of rings", f64::from(rings)),
            Kind::Flakes { size, .. } => ("size of flakes", size),
            Kind::Cells { size, .. } => ("size of cells", f64::from(size)),
            _ => return Ok(()),
        };
        if value >= 1.0 && value.is_finite() {
            return Ok(());
        }
        Err(error(format!("has {value} as {name}")).remedy("give at least 1"))
    }

    /// Whether the kind reads [`Drawing::period_ratio`].
    pub fn has_one_period(&self) -> bool {
        match &self.kind {
            Kind::Circles { rings } => rings.is_none(),
            Kind::Logo { .. } | Kind::Flakes { .. } => true,
            Kind::Cells { picture, .. } => picture.is_some(),
            Kind::Guilloche | Kind::Ramp => false,
        }
    }

    fn size(&self) -> DVec2 {
        USizeVec2::new(self.width, self.height).as_dvec2()
    }

    /// A place as seen from the centre, y up; 1 is half the shorter side.
    fn centred(&self, at: DVec2) -> DVec2 {
        let from = 2.0 * at - self.size();
        DVec2::new(from.x, -from.y) / self.size().min_element()
    }

    /// A period from the lowest (0) to the highest (1), in equal steps.
    fn period(&self, share: f64) -> f64 {
        lerp(self.ranges.period_ratio, share)
    }

    /// A groove at [`Drawing::angle_deg`], with a share of the range of depths.
    fn plain(&self, period_ratio: f64, depth: f64) -> Groove {
        self.groove(0.0, period_ratio, depth)
    }

    /// The same, turned.
    fn groove(&self, angle_rad: f64, period_ratio: f64, depth: f64) -> Groove {
        let angle_rad = angle_rad + self.angle_deg.to_radians();
        Groove { angle_rad, period_ratio, depth_ratio: lerp(self.ranges.depth_ratio, depth) }
    }

    fn circle(&self, from: DVec2, rings: Option<u32>) -> Option<Groove> {
        let radius = from.length();
        let angle = from.y.atan2(from.x);
        let third = rings.map(|rings| 1 + (radius * f64::from(rings)) as u32 % 2);
        let groove = match third.map(|third| f64::from(third) / 3.0) {
            None => self.groove(angle, self.period_ratio, 1.0),
            Some(share) => self.groove(angle, self.period(share), share),
        };
        (radius < 1.0).then_some(groove)
    }

    fn cell(
        &self,
        at: DVec2,
        size: u32,
        step_deg: f64,
        picture: Option<&Stencil>,
    ) -> Option<Groove> {
        let size = f64::from(size);
        let cell = (at / size).floor();
        if let Some(picture) = picture {
            let fit = picture.fit([self.width, self.height]);
            let end = ((cell + 1.0) * size).min(self.size());
            let [bright, opaque] = picture.mean(fit(cell * size), fit(end));
            let angle_rad = 0.25 * TAU * bright;
            return (opaque >= 0.5).then(|| self.groove(angle_rad, self.period_ratio, 1.0));
        }
        // counted from the lower left, as angles are
        let up = (self.height as f64 / size).ceil() - 1.0 - cell.y;
        let share = ((cell.x - up).rem_euclid(4.0) + 1.0) / 5.0;
        let angle_rad = ((cell.x + up) * step_deg).to_radians();
        Some(self.groove(angle_rad, self.period(share), share))
    }

    /// Centres on a grid, each moved within its place. The grid repeats at the picture's sides.
    fn flakes(&self, size: f64, seed: u64) -> Flakes {
        let counts = (self.size() / size).round().max(DVec2::ONE).as_usizevec2();
        let middle = self.period_ratio.ln();
        let [low, high] = self.ranges.period_ratio;
        let flake = |i: usize| {
            let mut random = SplitMix64::stream(seed, i as u64);
            let place = DVec2::new((i % counts.x) as f64, (i / counts.x) as f64);
            let centre = place + DVec2::new(random.share(), random.share());
            let angle = TAU * random.share();
            let period = (middle + FLAKE_PERIODS * random.signed()).exp().max(low).min(high);
            (centre, self.groove(angle, period, random.share()))
        };
        let flakes = (0..counts.x * counts.y).map(flake).collect();
        Flakes { scale: counts.as_dvec2() / self.size(), counts, flakes }
    }
}

/// Cells of the nearest centre.
struct Flakes {
    /// Places of the grid per texel.
    scale: DVec2,
    counts: USizeVec2,
    /// Centre in places of the grid, and groove.
    flakes: Vec<(DVec2, Groove)>,
}

impl Flakes {
    fn groove(&self, at: DVec2) -> Groove {
        let at = at * self.scale;
        let counts = self.counts.as_dvec2();
        let mut nearest = (f64::INFINITY, self.flakes[0].1);
        // a place's own centre is at most √2 away, so that none beyond two places is nearer
        for row in -2..=2 {
            for column in -2..=2 {
                let place = at.floor() + DVec2::new(f64::from(column), f64::from(row));
                let wrapped = place.rem_euclid(counts);
                let at_wrapped = wrapped.y as usize * self.counts.x + wrapped.x as usize;
                let (centre, groove) = self.flakes[at_wrapped % self.flakes.len()];
                // in texels, since places of the grid need not be square
                let distance = ((centre + place - wrapped - at) / self.scale).length_squared();
                if distance < nearest.0 {
                    nearest = (distance, groove);
                }
            }
        }
        nearest.1
    }
}

impl From<Groove> for Texel {
    fn from(groove: Groove) -> Texel {
        let Groove { angle_rad, period_ratio, depth_ratio } = groove;
        Texel { angle_rad, period_ratio, depth_ratio, ..Texel::default() }
    }
}

const NO_FOIL: Texel = Texel {
    angle_rad: 0.0,
    period_ratio: 1.0,
    depth_ratio: 1.0,
    mask: 0.0,
    angle_spread_rad: 0.0,
    ln_period_spread: 0.0,
};

fn lerp([low, high]: [f64; 2], share: f64) -> f64 {
    // the ends are exact
    low * (1.0 - share) + high * share
}

/// Places of a texel.
fn places(centre: DVec2) -> impl Iterator<Item = DVec2> {
    let part = |i: usize| (i as f64 + 0.5) / PLACES as f64 - 0.5;
    (0..PLACES * PLACES).map(move |i| centre + DVec2::new(part(i % PLACES), part(i / PLACES)))
}

/// Texels of a kind with edges: the groove of the centre, or else of any other place, and the share of places with one.
fn edged(groove: impl Fn(DVec2) -> Option<Groove> + Sync) -> impl Fn(DVec2) -> Texel + Sync {
    move |centre| {
        let mut found = groove(centre);
        let mut count = 0;
        for here in places(centre).filter_map(&groove) {
            count += 1;
            found.get_or_insert(here);
        }
        let mask = f64::from(count) / (PLACES * PLACES) as f64;
        found.map_or(NO_FOIL, |groove| Texel { mask, ..Texel::from(groove) })
    }
}

/// With a ground, a texel belongs to the side that has more of it.
fn logo_texel(
    centre: DVec2,
    is_inside: &impl Fn(DVec2) -> bool,
    inside: Groove,
    ground: Option<Groove>,
) -> Texel {
    let count = places(centre).filter(|at| is_inside(*at)).count();
    let share = count as f64 / (PLACES * PLACES) as f64;
    match ground {
        Some(ground) if share < 0.5 => ground.into(),
        Some(_) => inside.into(),
        None => Texel { mask: share, ..Texel::from(inside) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing(kind: Kind) -> Drawing {
        let ranges = Ranges { period_ratio: [0.5, 2.0], depth_ratio: [0.8, 1.2] };
        Drawing { width: 48, height: 32, ranges, angle_deg: 0.0, period_ratio: 1.0, kind }
    }

    /// The flake of a place is that of the nearest centre among all, those of the neighbouring repeats included.
    #[test]
    fn a_flake_is_that_of_the_nearest_centre() {
        let drawing = drawing(Kind::Ramp);
        let flakes = drawing.flakes(7.0, 3);
        let repeat = drawing.size();
        for i in 0..500 {
            let mut random = SplitMix64::stream(1, i);
            let at = DVec2::new(random.share(), random.share()) * repeat;
            let distance = |centre: DVec2| {
                let mut distances = Vec::new();
                for x in [-1.0, 0.0, 1.0] {
                    for y in [-1.0, 0.0, 1.0] {
                        let centre = centre / flakes.scale + DVec2::new(x, y) * repeat;
                        distances.push(centre.distance(at));
                    }
                }
                distances.into_iter().fold(f64::INFINITY, f64::min)
            };
            let all = flakes.flakes.iter();
            let nearest = all.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0))).unwrap();
            assert_eq!(flakes.groove(at), nearest.1, "{at}");
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let outside = Drawing { period_ratio: 3.0, ..drawing(Kind::Circles { rings: None }) };
        assert!(outside.map().unwrap_err().to_string().contains("outside of 0.5 to 2"));
        // rings do not read it
        assert!(Drawing { kind: Kind::Circles { rings: Some(3) }, ..outside }.map().is_ok());
        for kind in [
            Kind::Circles { rings: Some(0) },
            Kind::Flakes { size: f64::NAN, seed: 0 },
            Kind::Flakes { size: 0.0, seed: 0 },
            Kind::Cells { size: 0, step_deg: 1.0, picture: None },
        ] {
            assert!(drawing(kind).map().is_err());
        }
        assert!(Drawing { width: 0, ..drawing(Kind::Ramp) }.map().is_err());
        assert!(Drawing { angle_deg: f64::NAN, ..drawing(Kind::Ramp) }.map().is_err());
    }
}
