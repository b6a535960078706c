//! A convex spherical polygon.

use glam::DVec3;

use super::Cap;

/// Maximum number of corners.
pub const MAX_CORNERS: usize = 8;

/// Smallest sine of the angle at which corners differ, and by which a corner must stand out.
const MIN_SINE: f64 = 1e-6;

/// A convex spherical polygon that fits into a hemisphere. Its edges are arcs of great circles.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    corners: Vec<DVec3>,
    /// Unit vectors that point to the inner side of each edge; edge `i` starts at corner `i`.
    normals: Vec<DVec3>,
}

/// Why corners are not those of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PolygonFault {
    /// Fewer than three or more than [`MAX_CORNERS`].
    Count,
    /// Two neighbouring corners, counted from 1, coincide or are opposite.
    Coincide(usize, usize),
    /// At this corner, counted from 1, the polygon is straight, bends inwards, or is wider than a hemisphere.
    NotConvex(usize),
}

impl Polygon {
    /// From its corners in either order, as unit vectors.
    pub fn new(corners: &[DVec3]) -> Result<Polygon, PolygonFault> {
        let count = corners.len();
        if !(3..=MAX_CORNERS).contains(&count) {
            return Err(PolygonFault::Count);
        }
        let mut corners = corners.to_vec();
        // counter-clockwise seen from outside the sphere, where the edges' normals add up to the side of the corners
        let middle: DVec3 = corners.iter().sum();
        let turning: DVec3 = (0..count).map(|i| corners[i].cross(corners[(i + 1) % count])).sum();
        if turning.dot(middle) < 0.0 {
            corners[1..].reverse();
        }
        let mut normals = Vec::with_capacity(count);
        for i in 0..count {
            let next = (i + 1) % count;
            let normal = corners[i].cross(corners[next]);
            if normal.length() < MIN_SINE {
                return Err(PolygonFault::Coincide(i + 1, next + 1));
            }
            normals.push(normal.normalize());
        }
        for (i, normal) in normals.iter().enumerate() {
            let others = (0..count).filter(|j| *j != i && *j != (i + 1) % count);
            for j in others {
                if normal.dot(corners[j]) < MIN_SINE {
                    return Err(PolygonFault::NotConvex(j + 1));
                }
            }
        }
        Ok(Polygon { corners, normals })
    }

    /// Its corners, counter-clockwise seen from outside the sphere.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// Unit vectors that point to the inner side of each edge.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// Smallest sine of the angle between a direction and an edge: positive inside.
    pub fn margin(&self, wi: DVec3) -> f64 {
        self.normals.iter().map(|normal| normal.dot(wi)).fold(f64::INFINITY, f64::min)
    }

    /// A cap about the mean of the corners that contains it.
    pub fn bounds(&self) -> Cap {
        let axis = self.corners.iter().sum::<DVec3>().normalize();
        let farthest = self.corners.iter().map(|c| (*c - axis).length()).fold(0.0, f64::max);
        // a cap within a hemisphere is convex, so it contains the edges if it contains the corners
        Cap { axis, radius_rad: 2.0 * (0.5 * farthest).min(1.0).asin() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::direction;

    fn square() -> Vec<DVec3> {
        vec![
            direction(10.0, 0.0),
            direction(30.0, -30.0),
            direction(50.0, 0.0),
            direction(30.0, 30.0),
        ]
    }

    #[test]
    fn either_order_is_the_same_polygon() {
        let mut turned = square();
        turned.reverse();
        let (one, other) = (Polygon::new(&square()).unwrap(), Polygon::new(&turned).unwrap());
        for wi in [direction(30.0, 0.0), direction(30.0, 60.0), direction(80.0, 0.0)] {
            assert!((one.margin(wi) - other.margin(wi)).abs() < 1e-15);
        }
        assert!(one.margin(direction(30.0, 0.0)) > 0.0 && one.margin(direction(5.0, 180.0)) < 0.0);
        assert!(one.margin(-direction(30.0, 0.0)) < 0.0);
    }

    #[test]
    fn what_is_no_convex_polygon_is_refused() {
        assert_eq!(Polygon::new(&square()[..2]), Err(PolygonFault::Count));
        let mut bent = square();
        bent[0] = direction(35.0, 0.0);
        assert!(matches!(Polygon::new(&bent), Err(PolygonFault::NotConvex(_))));
        let mut double = square();
        double[1] = double[0];
        assert_eq!(Polygon::new(&double), Err(PolygonFault::Coincide(1, 2)));
        let mut crossed = square();
        crossed.swap(1, 2);
        assert!(matches!(Polygon::new(&crossed), Err(PolygonFault::NotConvex(_))));
        let wide: Vec<DVec3> = (0..4).map(|i| direction(90.0, 90.0 * f64::from(i))).collect();
        assert!(Polygon::new(&wide).is_err(), "as wide as a hemisphere");
    }

    #[test]
    fn bounds_contain_the_polygon() {
        let polygon = Polygon::new(&square()).unwrap();
        let cap = polygon.bounds();
        for theta in 0..90 {
            for phi in 0..72 {
                let wi = direction(f64::from(theta), 5.0 * f64::from(phi));
                assert!(polygon.margin(wi) < 0.0 || cap.margin(wi) >= -1e-12);
            }
        }
    }
}
