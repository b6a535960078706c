//! Lights as intersections of caps, and the search for orders that are lit.

use glam::{DVec2, DVec3};

use crate::variant::Orders;
use crate::variant::twin::Twin;

use super::{
    Cap, arrival, crossings, disc_chord_squared, edge_normal, in_surface, normal_reflectance,
    order_colour, order_columns, order_frequency, order_rows, propagating, within,
};

/// A light of radiance 1.
pub struct Caps {
    /// It is their intersection.
    all: Vec<Cap>,
    /// A cap that contains it.
    bounds: Cap,
}

impl Caps {
    /// A disc.
    pub fn disc(axis: DVec3, radius_rad: f64) -> Caps {
        let cap = (axis, disc_chord_squared(radius_rad));
        Caps { all: vec![cap], bounds: cap }
    }

    /// A quadrilateral, as an intersection of hemispheres.
    pub fn rectangle(corners: [DVec3; 4]) -> Caps {
        let centre = corners.iter().sum::<DVec3>().normalize();
        let next = |i: usize| corners[(i + 1) % 4];
        let turning: DVec3 = (0..4).map(|i| corners[i].cross(next(i))).sum();
        let side = if turning.dot(centre) > 0.0 { 1.0 } else { -1.0 };
        let all = (0..4).map(|i| (edge_normal(corners[i], next(i), side, centre), 2.0)).collect();
        let farthest = corners.iter().map(|c| c.distance_squared(centre)).fold(0.0, f64::max);
        Caps { all, bounds: (centre, farthest) }
    }

    /// X, Y, Z towards a viewer if its radiance is a colour in linear sRGB.
    pub fn seen(&self, twin: &Twin<'_>, form: &Orders, colour: DVec3, wr: DVec3) -> DVec3 {
        if wr.z <= 1e-6 {
            return DVec3::ZERO;
        }
        let turned = |(axis, chord_squared): Cap| (in_surface(twin, axis), chord_squared);
        let here = Caps {
            all: self.all.iter().copied().map(turned).collect(),
            bounds: turned(self.bounds),
        };
        let viewer = in_surface(twin, wr);
        let mut xyz = DVec3::ZERO;
        here.visit(form, viewer, &mut |order, range_um| {
            xyz += order_colour(twin, form, order, range_um, colour, viewer);
        });
        normal_reflectance(form) * xyz
    }

    /// Calls `lit` with each order that takes light from it, and the range of wavelengths in µm. All directions are in the
    /// frame of the surface.
    pub fn visit(&self, form: &Orders, wr: DVec3, lit: &mut dyn FnMut(DVec2, [f64; 2])) {
        let (axis, chord_squared) = self.bounds;
        let offset = (axis + wr).truncate();
        let reach = chord_squared.sqrt();
        let rows = order_rows(form, offset, reach);
        for row in rows[0]..=rows[1] {
            let columns = order_columns(form, row, offset, reach);
            for column in columns[0]..=columns[1] {
                self.ranges(form, DVec2::new(f64::from(column), f64::from(row)), wr, lit);
            }
        }
    }

    /// The ranges of wavelengths at which an order takes light from it. Between the wavelengths at which the order's
    /// direction crosses an edge it is inside or outside, which is tested in the middle.
    fn ranges(&self, form: &Orders, order: DVec2, wr: DVec3, lit: &mut dyn FnMut(DVec2, [f64; 2])) {
        let frequency = order_frequency(form, order);
        let [mut from_um, last_um] = propagating(form, frequency, wr);
        let mut edges: Vec<f64> =
            self.all.iter().flat_map(|cap| crossings(frequency, wr, *cap).to_array()).collect();
        edges.sort_by(f64::total_cmp);
        edges.push(last_um);
        for to_um in edges.into_iter().map(|edge| edge.min(last_um)) {
            if from_um >= to_um {
                continue;
            }
            let middle = arrival(frequency, 0.5 * (from_um + to_um), wr);
            if self.all.iter().all(|cap| within(middle, *cap)) {
                lit(order, [from_um, to_um]);
            }
            from_um = to_um;
        }
    }
}
