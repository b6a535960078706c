//! The table of cells: the colours over `(u, v)`, divided into parts that surroundings light one by one.
//!
//! The radiance under surroundings `L` is `∫ g/cos θi · T(u, v, w) L d(u, v)`, with the gain `g` and a table of colours `T`. A cell is
//! a part of the plane of `(u, v)` with the integral of T over it. It asks for the surroundings once, at its centroid, blurred over
//! its own width. The cells are those of Lloyd (1982, Least squares quantization in PCM): every place belongs to the nearest
//! centroid of energy, so that of all divisions they are the narrowest.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::random::SplitMix64;

use super::bake::Colours;
use super::{STREAKS, Table, TexelFormat};

/// Rounds of the division. After these the centroids move by less than a hundredth of a cell's width.
const ROUNDS: usize = 40;

/// A part of the plane: its middle, its energy, and X, Y, Z of red, green and blue light on each layer of w.
struct Place {
    middle: DVec2,
    energy: f64,
    area: f64,
    /// Index of the first of its corners, and of the one beside it.
    corners: [usize; 2],
}

/// The table, 2-D. Column: a cell. Row 0: u and v of its centroid, then the standard deviation of its light on each axis, in
/// direction cosines. Then three rows for each layer of w, red, green and blue light: X, Y, Z of the radiance that it sends under
/// surroundings of radiance 1, without the gain, relative to a white of radiance 1.
///
/// `colours`: under red, green and blue light, on the same axes. `unit`: factor of their integral.
pub fn cells_table(colours: &[Colours; 3], count: u32, unit: f64) -> Table {
    let places = places(&colours[0], |corner| {
        colours
            .iter()
            .map(|of| of.xyz[corner].iter().map(|part| f64::from(*part)).sum::<f64>())
            .sum()
    });
    let owners = divided(&places, count as usize);
    let axes = &colours[0].axes;
    let layers = axes.levels as usize;
    let shape = cells_shape(count, axes.levels);
    let mut texels = vec![[0.0; 4]; shape.texel_count()];
    let mut sums = vec![Moments::default(); count as usize];
    for (place, owner) in places.iter().zip(&owners) {
        sums[*owner].add(place);
    }
    for (cell, sum) in sums.iter().enumerate() {
        let middle = sum.middle();
        texels[cell] = [middle.x, middle.y, sum.deviation(), 0.0];
    }
    let layer_size = (axes.rows * axes.columns) as usize;
    for (layer, of) in (0..layers).flat_map(|layer| (0..3).map(move |of| (layer, of))) {
        let row = &mut texels[(1 + 3 * layer + of) * count as usize..][..count as usize];
        for (place, owner) in places.iter().zip(&owners) {
            let at = |corner: usize| {
                DVec3::from(colours[of].xyz[layer * layer_size + corner].map(f64::from))
            };
            let [first, beside] = place.corners;
            let below = axes.columns as usize;
            let mean = 0.25 * (at(first) + at(beside) + at(first + below) + at(beside + below));
            let light = unit * place.area * mean;
            let out = &mut row[*owner];
            *out = [out[0] + light.x, out[1] + light.y, out[2] + light.z, 0.0];
        }
    }
    Table { texels: texels.concat(), ..shape }
}

/// The table without its texels.
pub fn cells_shape(count: u32, layers: u32) -> Table {
    Table {
        name: "cells",
        binding: STREAKS,
        format: TexelFormat::Rgba32Float,
        width: count as usize,
        height: 1 + 3 * layers as usize,
        layers: 0,
        filtered: false,
        texels: Vec::new(),
    }
}

/// The parts between columns and rows of a table of colours, with the energy that viewers see of them: that of all layers, times
/// the share of viewers for whom light comes from there.
fn places(colours: &Colours, light: impl Fn(usize) -> f64) -> Vec<Place> {
    let axes = &colours.axes;
    let (columns, rows) = (axes.columns as usize, axes.rows as usize);
    let angle = |column: usize| {
        let [x, y] = axes.direction((column % columns) as u32);
        y.atan2(x)
    };
    let turned = |column: usize| {
        let span = (angle(column + 1) - angle(column)).rem_euclid(2.0 * PI);
        (angle(column) + 0.5 * span, span)
    };
    let turns: Vec<(f64, f64)> = (0..columns).map(turned).collect();
    let mut places = Vec::with_capacity(columns * (rows - 1));
    for row in 0..rows - 1 {
        let radii = [row, row + 1].map(|row| axes.radius(row as u32).min(2.0));
        let middle = (0.5 * (radii[0] * radii[0] + radii[1] * radii[1])).sqrt();
        let seen = visible(middle);
        for (column, (turn, span)) in turns.iter().enumerate() {
            let area = 0.5 * span * (radii[1] * radii[1] - radii[0] * radii[0]);
            let corners = [row * columns + column, row * columns + (column + 1) % columns];
            let layers = 0..axes.levels as usize;
            let of = |layer: usize| {
                let at = |corner: usize| light(layer * rows * columns + corner);
                corners.map(|corner| at(corner) + at(corner + columns)).iter().sum::<f64>()
            };
            let energy = seen * area * layers.map(of).sum::<f64>().max(0.0);
            let middle = middle * DVec2::from_angle(*turn);
            places.push(Place { middle, energy, area, corners });
        }
    }
    places
}

/// Share of all viewers, counted by direction cosines, whom light reaches over a distance: where two discs of radius 1 overlap.
fn visible(distance: f64) -> f64 {
    let half = (0.5 * distance).clamp(0.0, 1.0);
    2.0 / PI * (half.acos() - half * (1.0 - half * half).sqrt())
}

/// Sums over a cell.
#[derive(Clone, Copy, Default)]
struct Moments {
    energy: f64,
    first: DVec2,
    second: f64,
}

impl Moments {
    fn add(&mut self, place: &Place) {
        self.energy += place.energy;
        self.first += place.energy * place.middle;
        self.second += place.energy * place.middle.length_squared();
    }

    fn middle(&self) -> DVec2 {
        if self.energy > 0.0 { self.first / self.energy } else { DVec2::ZERO }
    }

    /// Standard deviation on each axis.
    fn deviation(&self) -> f64 {
        if self.energy <= 0.0 {
            return 0.0;
        }
        let variance = self.second / self.energy - self.middle().length_squared();
        (0.5 * variance).max(0.0).sqrt()
    }
}

/// The cell of each place.
fn divided(places: &[Place], count: usize) -> Vec<usize> {
    let mut centres = seeds(places, count);
    let nearest = |centres: &[DVec2]| -> Vec<usize> {
        let of = |place: &Place| {
            let far = |cell: &usize| centres[*cell].distance_squared(place.middle);
            (0..centres.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
        };
        places.par_iter().map(of).collect()
    };
    for _ in 0..ROUNDS {
        let mut sums = vec![Moments::default(); count];
        for (place, owner) in places.iter().zip(nearest(&centres)) {
            sums[owner].add(place);
        }
        for (centre, sum) in centres.iter_mut().zip(&sums) {
            // an empty cell stays where it is
            if sum.energy > 0.0 {
                *centre = sum.middle();
            }
        }
    }
    nearest(&centres)
}

/// First centres, far from each other where there is energy (Arthur and Vassilvitskii 2007, k-means++): each is a random place,
/// with a probability in proportion to its energy times its squared distance from the nearest centre so far.
fn seeds(places: &[Place], count: usize) -> Vec<DVec2> {
    let mut random = SplitMix64::new(1);
    let mut centres = vec![DVec2::ZERO];
    let mut far: Vec<f64> = places.iter().map(|place| place.middle.length_squared()).collect();
    while centres.len() < count {
        let chance = |(place, far): (&Place, &f64)| place.energy * far;
        let whole: f64 = places.iter().zip(&far).map(chance).sum();
        let mut rest = random.share() * whole;
        let next = places.iter().zip(&far).position(|each| {
            rest -= chance(each);
            rest <= 0.0
        });
        let centre = places[next.unwrap_or(places.len() - 1)].middle;
        for (far, place) in far.iter_mut().zip(places) {
            *far = far.min(centre.distance_squared(place.middle));
        }
        centres.push(centre);
    }
    centres
}
