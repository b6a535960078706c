//! Exact colours under lights with a size: the sum over the propagating orders of a patch that tiles the plane.
//!
//! `L_o = Σ_rs ∫ η_rs(λ) L_i(wi_rs(λ)) S(λ)(x̄,ȳ,z̄)(λ) dλ`, `wi_rs = (-αr - λ f_rs, ·)`, where `α` is the xy part of a unit
//! vector, `f_rs = (r/Lx, s/Ly)`, and `η_rs = R O |c_rs(k w)|² S` is the share of an order, with
//! `O = (1 + wi·wr)²/(cos θi cos θr w²)` (for other matter see [`Matter`]). This is `(s/π) ∫ ρ L_i dΩ` of Stam's ρ (1999, eqs. 7 and 11) for a coherence
//! length that follows the wavelength. The window does not appear: it stands for a light's size, which is here.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use crate::error::{Error, Result};
use crate::light::{Emitter, Sky};
use crate::optics::spectrum::{Spectrum, TABLE_MAX_NM, TABLE_MIN_NM};
use crate::optics::{Matter, direction, primary_shares};
use crate::plan::Optics;
use crate::surface::HeightField;

use super::transform::{Bins, axes, heights_upwards_um, ifft2};
use super::{MAX_BYTES, Nodes};

/// Longest panel of the wavelength integral, nm. Each has four Gauss–Legendre nodes, so that they are about half a nm apart.
const PANEL_NM: f64 = 2.0;

/// Number of orders beyond which panels of [`OrderSum::for_skies`] grow with it: the errors of that many orders cancel.
const MANY: f64 = 1000.0;

/// Largest table for which the radiance under a white sky is computed without being asked for, bytes.
const MAX_SKY_BYTES: usize = 512 << 20;

/// The light is sought at steps of this part of its radius.
const SEARCH: f64 = 1.0 / 32.0;

/// Nodes and weights of Gauss and Legendre on [-1, 1].
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// Angles from the normal of the viewers of [`OrderSum::white_sky`], degrees; they look along the tangent.
pub const SKY_VIEWS_DEG: [f64; 4] = [0.0, 30.0, 60.0, 75.0];

/// `|c_rs(z)|²` of all orders that can propagate, and what else their shares need.
pub struct OrderSum {
    bins: Bins,
    nodes: Nodes,
    /// `[s][r][node]`.
    squares: Vec<f64>,
    size_um: DVec2,
    spectrum: Spectrum,
    matter: Matter,
    rotate_deg: f64,
    panel_nm: f64,
}

impl OrderSum {
    /// Transforms the phase function of a surface at as many `z` as its height range needs. It is refused above 6 GiB.
    pub fn new(height: &HeightField, rotate_deg: f64, optics: &Optics) -> Result<OrderSum> {
        let matter = Matter::new(optics)?;
        let (bins, nodes, bytes) = OrderSum::layout(height, &matter);
        if bytes > MAX_BYTES {
            let subject = format!("surface of {} × {} pixels", height.columns(), height.rows());
            let cause = format!("its orders need {:.1} GiB", bytes as f64 / f64::from(1 << 30));
            return Err(Error::new(subject, cause).remedy("crop the scan"));
        }
        let count = nodes.z.len();
        let heights_um = heights_upwards_um(height);
        let mut squares = vec![0.0; bins.len() * count];
        for (n, &z) in nodes.z.iter().enumerate() {
            let mut phase: Vec<Complex64> =
                heights_um.par_iter().map(|h| Complex64::cis(z * h)).collect();
            let coefficients = ifft2(&mut phase, axes(height), bins);
            squares
                .par_chunks_mut(count)
                .zip(&coefficients)
                .for_each(|(order, c)| order[n] = c.norm_sqr());
        }
        Ok(OrderSum {
            bins,
            nodes,
            squares,
            size_um: DVec2::new(height.size_x_um(), height.size_y_um()),
            spectrum: Spectrum::new(&optics.illuminant)?,
            matter,
            rotate_deg,
            panel_nm: PANEL_NM,
        })
    }

    /// Whether [`OrderSum::white_sky`] is worth its time and memory: up to a table of half a GiB.
    pub fn has_white_sky(height: &HeightField, matter: &Matter) -> bool {
        OrderSum::layout(height, matter).2 <= MAX_SKY_BYTES
    }

    /// The most that [`OrderSum::new`] takes, in bytes: its table, and one transform.
    pub fn working_bytes(height: &HeightField, matter: &Matter) -> u64 {
        let (bins, _, bytes) = OrderSum::layout(height, matter);
        // heights, signal and columns of the transform, coefficients
        (bytes + 24 * height.heights_um().len() + 32 * bins.len()) as u64
    }

    /// Orders, nodes, and the bytes of the table.
    fn layout(height: &HeightField, matter: &Matter) -> (Bins, Nodes, usize) {
        let (low_um, high_um) = height.range_um();
        let longest = TAU / (TABLE_MIN_NM * 1e-3);
        let (shortest_w, longest_w) = matter.w_span(0.0, 2.0);
        // without a cover w is from -2 to 0
        let last = -shortest_w * TAU / (TABLE_MAX_NM * 1e-3);
        let nodes = Nodes::new((-longest_w * longest, last), high_um - low_um);
        let reach_cpum = 2e3 / TABLE_MIN_NM;
        let bins = Bins::reachable(height.size_x_um(), height.size_y_um(), reach_cpum, 0);
        let bytes = bins.len().saturating_mul(nodes.z.len()).saturating_mul(size_of::<f64>());
        (bins, nodes, bytes)
    }

    /// Sets the longest panel of the wavelength integral, to show that shorter ones change nothing.
    #[must_use]
    pub fn with_panel_nm(mut self, panel_nm: f64) -> OrderSum {
        self.panel_nm = panel_nm;
        self
    }

    /// Tristimulus values of the radiance towards a viewer, relative to a white of radiance 1.
    pub fn radiance(&self, emitter: &dyn Emitter, wr: DVec3) -> [f64; 3] {
        if wr.z <= 0.0 {
            return [0.0; 3];
        }
        let (r_max, s_max) = (self.bins.r_max as i64, self.bins.s_max as i64);
        let cap = emitter.bounds();
        let turn = DVec2::from_angle(self.rotate_deg.to_radians());
        let of_row = |s: i64| {
            let of_order = |r: i64| {
                // in the tangent frame
                let f = turn.rotate(DVec2::new(r as f64, s as f64) / self.size_um);
                let place = ((s + s_max) * (2 * r_max + 1) + r + r_max) as usize;
                let count = self.nodes.z.len();
                let squares = &self.squares[place * count..(place + 1) * count];
                let order = Order { sum: self, f, squares, wr };
                if f == DVec2::ZERO {
                    return order.mirror(emitter);
                }
                let range = order.within(cap.axis.truncate(), cap.radius_rad);
                range.map_or(DVec3::ZERO, |range| order.shifted(emitter, cap.radius_rad, range))
            };
            (-r_max..=r_max).map(of_order).sum::<DVec3>()
        };
        // rows are added in their order, so that the sum does not depend on the number of threads
        let rows: Vec<DVec3> = (-s_max..=s_max).into_par_iter().map(of_row).collect();
        rows.into_iter().sum::<DVec3>().to_array()
    }

    /// Sets panels that are long enough under skies: the errors of many orders cancel.
    #[must_use]
    pub fn for_skies(self) -> OrderSum {
        let many = (self.bins.len() as f64 / MANY).clamp(1.0, 20.0);
        self.with_panel_nm(many * PANEL_NM)
    }

    /// Radiance under a sky of radiance 1, X, Y, Z, towards the viewers of [`SKY_VIEWS_DEG`]: the sum of all shares. It is the
    /// surface's reflectance as the scalar theory has it, which may exceed that of the material.
    pub fn white_sky(self) -> [[f64; 3]; 4] {
        let coarse = self.for_skies();
        let sky = Sky::everywhere(DVec3::ONE);
        SKY_VIEWS_DEG.map(|theta_deg| coarse.radiance(&sky, direction(theta_deg, 0.0)))
    }

    /// [`OrderSum::radiance`] of many viewers, on all cores. `done` is called with the number of viewers finished since
    /// the last call.
    pub fn radiance_all_with(
        &self,
        emitters: &[&dyn Emitter],
        views: &[DVec3],
        done: &(dyn Fn(usize) + Sync),
    ) -> Vec<[f64; 3]> {
        let view = |wr: &DVec3| {
            let each = emitters.iter().map(|emitter| DVec3::from(self.radiance(*emitter, *wr)));
            let sum = each.sum::<DVec3>().to_array();
            done(1);
            sum
        };
        views.par_iter().map(view).collect()
    }
}

/// One order, seen from one direction.
struct Order<'a> {
    sum: &'a OrderSum,
    /// Its frequency in the tangent frame, cycles per µm.
    f: DVec2,
    squares: &'a [f64],
    wr: DVec3,
}

impl Order<'_> {
    /// The wavelengths, µm, at which the light's direction cosines are within `reach` of those of `middle`.
    fn within(&self, middle: DVec2, reach: f64) -> Option<[f64; 2]> {
        let (low, high) = (TABLE_MIN_NM * 1e-3, TABLE_MAX_NM * 1e-3);
        let start = self.wr.truncate() + middle;
        // |start + λ f| ≤ reach
        let (a, b) = (self.f.length_squared(), start.dot(self.f));
        let root = b * b - a * (start.length_squared() - reach * reach);
        if root < 0.0 {
            return None;
        }
        let ends = [(-b - root.sqrt()) / a, (-b + root.sqrt()) / a];
        let range = [ends[0].max(low), ends[1].min(high)];
        (range[0] < range[1]).then_some(range)
    }

    /// Colour of the order whose light moves over a small circle as the wavelength changes:
    /// `wi = (ρ0 sin ψ, y0, ρ0 cos ψ)` in the frame of `f`, its normal in the plane, and the surface's normal. Then
    /// `dλ = cos θi dψ/|f|`, which keeps the integral finite where light comes along the horizon.
    fn shifted(&self, emitter: &dyn Emitter, radius_rad: f64, range_um: [f64; 2]) -> DVec3 {
        let length = self.f.length();
        let along = self.f / length;
        let across = along.perp();
        let offset = self.wr.truncate();
        let (x0, y0) = (-offset.dot(along), -offset.dot(across));
        let rho0 = (1.0 - y0 * y0).max(0.0).sqrt();
        let direction = |psi: f64| {
            let (sin, cos) = psi.sin_cos();
            let plane = rho0 * sin * along + y0 * across;
            plane.extend(rho0 * cos)
        };
        let angle = |lambda_um: f64| {
            ((x0 - lambda_um * length) / rho0).clamp(-1.0, 1.0).asin().clamp(-FRAC_PI_2, FRAC_PI_2)
        };
        let [first, last] = [angle(range_um[1]), angle(range_um[0])];
        if last <= first {
            return DVec3::ZERO;
        }
        let margin = |psi: f64| emitter.margin(direction(psi));
        let mut xyz = DVec3::ZERO;
        for [from, to] in lit(first, last, SEARCH * radius_rad, &margin) {
            let longest = rho0 * (to - from) / (length * self.sum.panel_nm * 1e-3);
            let panels = longest.max((to - from) / emitter.grain_rad()).ceil().max(1.0);
            let half = 0.5 * (to - from) / panels;
            for panel in 0..panels as u32 {
                let middle = from + (2.0 * f64::from(panel) + 1.0) * half;
                for (node, weight) in GAUSS {
                    let psi = middle + half * node;
                    let lambda_um = (x0 - rho0 * psi.sin()) / length;
                    let wi = direction(psi);
                    let share = self.share(wi, lambda_um) * wi.z;
                    let colour = self.light(emitter.radiance(wi), lambda_um * 1e3) * 1e3;
                    xyz += weight * half / length * share * colour;
                }
            }
        }
        xyz
    }

    /// Colour of the order that mirrors.
    fn mirror(&self, emitter: &dyn Emitter) -> DVec3 {
        let wi = DVec3::new(-self.wr.x, -self.wr.y, self.wr.z);
        if emitter.margin(wi) < 0.0 {
            return DVec3::ZERO;
        }
        let panels = ((TABLE_MAX_NM - TABLE_MIN_NM) / self.sum.panel_nm).ceil();
        let half_nm = 0.5 * (TABLE_MAX_NM - TABLE_MIN_NM) / panels;
        let radiance = emitter.radiance(wi);
        let mut xyz = DVec3::ZERO;
        for panel in 0..panels as u32 {
            let middle_nm = TABLE_MIN_NM + (2.0 * f64::from(panel) + 1.0) * half_nm;
            for (node, weight) in GAUSS {
                let lambda_nm = middle_nm + half_nm * node;
                let share = self.share(wi, lambda_nm * 1e-3);
                xyz += weight * half_nm * share * self.light(radiance, lambda_nm);
            }
        }
        xyz
    }

    /// X, Y, Z per nm of light of a radiance in linear sRGB.
    fn light(&self, radiance: DVec3, lambda_nm: f64) -> DVec3 {
        let is_white = radiance.x == radiance.y && radiance.y == radiance.z;
        let part = if is_white { radiance.x } else { radiance.dot(primary_shares(lambda_nm)) };
        part * DVec3::from(self.sum.spectrum.per_nm(lambda_nm))
    }

    /// `η` of the order.
    fn share(&self, wi: DVec3, lambda_um: f64) -> f64 {
        let matter = &self.sum.matter;
        let lambda_nm = lambda_um * 1e3;
        let whole = whole_share(matter, wi, self.wr, lambda_nm);
        if whole == 0.0 {
            return 0.0;
        }
        let z = TAU / lambda_um * matter.depth(wi, self.wr, lambda_nm);
        whole * self.sum.nodes.interpolate(z, self.squares).re
    }
}

/// `η` of an order that has all light: `|c|² = 1`.
pub(super) fn whole_share(matter: &Matter, wi: DVec3, wr: DVec3, lambda_nm: f64) -> f64 {
    matter.normal_reflectance() * matter.gain(wi, wr, lambda_nm) / wi.z
}

/// The intervals of `first..last` in which the margin is positive. It is sampled in steps of at most `step`; ends, and
/// intervals or gaps shorter than a step, are sought between samples.
fn lit(first: f64, last: f64, step: f64, margin: &dyn Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let count = ((last - first) / step).ceil().clamp(1.0, 1e6) as usize + 1;
    let place = |i: usize| first + (last - first) * i as f64 / count as f64;
    let mut samples: Vec<(f64, f64)> = (0..=count).map(|i| (place(i), margin(place(i)))).collect();
    // the extremum between three samples, where it may lie on the other side
    let hidden: Vec<(f64, f64)> = samples
        .windows(3)
        .filter_map(|three| {
            let [(a, fa), (_, fb), (c, fc)] = *three else { return None };
            let sign = fb.signum();
            let towards_zero = fb * sign <= fa * sign && fb * sign <= fc * sign;
            (fa.signum() == sign && fc.signum() == sign && towards_zero)
                .then(|| lowest(a, c, &|x| sign * margin(x)))
                .filter(|(_, value)| *value < 0.0)
                .map(|(x, value)| (x, sign * value))
        })
        .collect();
    samples.extend(hidden);
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found = Vec::new();
    let mut start = (samples[0].1 >= 0.0).then_some(first);
    for pair in samples.windows(2) {
        let [(a, fa), (b, fb)] = *pair else { continue };
        if (fa >= 0.0) == (fb >= 0.0) {
            continue;
        }
        let edge = edge(a, b, margin);
        match start.take() {
            Some(from) => found.push([from, edge]),
            None => start = Some(edge),
        }
    }
    found.extend(start.map(|from| [from, last]));
    found
}

/// The place between `a` and `b` where the margin changes its sign.
fn edge(mut a: f64, mut b: f64, margin: &dyn Fn(f64) -> f64) -> f64 {
    let inside = margin(a) >= 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if (margin(middle) >= 0.0) == inside {
            a = middle;
        } else {
            b = middle;
        }
    }
    0.5 * (a + b)
}

/// The lowest value between `a` and `b`, by the golden section.
fn lowest(mut a: f64, mut b: f64, value: &dyn Fn(f64) -> f64) -> (f64, f64) {
    const SECTION: f64 = 0.618_033_988_749_894_9;
    for _ in 0..60 {
        let (left, right) = (b - SECTION * (b - a), a + SECTION * (b - a));
        if value(left) < value(right) {
            b = right;
        } else {
            a = left;
        }
    }
    let middle = 0.5 * (a + b);
    (middle, value(middle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_and_gaps_shorter_than_a_step_are_found() {
        let hump = |x: f64| 1e-3 - (x - 0.512_345).abs();
        let found = lit(0.0, 1.0, 0.03, &hump);
        assert_eq!(found.len(), 1);
        assert!((found[0][0] - 0.511_345).abs() < 1e-9 && (found[0][1] - 0.513_345).abs() < 1e-9);
        let gap = |x: f64| -hump(x);
        let found = lit(0.0, 1.0, 0.03, &gap);
        assert_eq!((found.len(), found[0][0], found[1][1]), (2, 0.0, 1.0));
        assert!(lit(0.0, 1.0, 0.03, &|_| -1.0).is_empty());
        assert_eq!(lit(0.0, 1.0, 0.03, &|_| 1.0), [[0.0, 1.0]]);
    }
}
