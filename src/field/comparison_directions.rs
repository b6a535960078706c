//! Directions in which colours are compared: the pixels of a map, and random directions where the light is.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rustfft::num_complex::Complex64;

use crate::field::reference::Directions;
use crate::field::transform::{Bins, axes, heights_upwards_um, ifft2};
use crate::light::{Light, Lights};
use crate::optics;
use crate::optics::brdf_map::view_directions;
use crate::plan::Optics;
use crate::random::SplitMix64;
use crate::surface::HeightField;

/// Number of random directions, in addition to the pixels of a map.
const DRAWN: usize = 4096;
/// Seed of the random directions.
const SEED: u64 = 1;
/// Maximum number of orders that random directions lie on, the strongest first.
const ORDERS: usize = 64;

/// The directions of a comparison: the pixel centres of a map of `size × size` under a light, and 4096 directions of
/// [`on_orders`].
pub fn standard(
    height: &HeightField,
    optics: &Optics,
    rotate_deg: f64,
    light: DVec3,
    size: usize,
) -> Vec<Directions> {
    let mut all: Vec<Directions> =
        view_directions(size).into_iter().map(|wr| Directions { wi: light, wr }).collect();
    all.extend(on_orders(height, optics, rotate_deg, light, DRAWN, SEED));
    all
}

/// Random directions that are drawn from each light with a size.
const OF_LIGHT: usize = 64;

/// The viewers of a comparison under lights: the pixels of a map of `size × size`, and 4096 on strong orders of random
/// directions within the lights.
pub fn under_lights(
    height: &HeightField,
    optics: &Optics,
    rotate_deg: f64,
    lights: &Lights,
    size: usize,
) -> Vec<DVec3> {
    let mut random = SplitMix64::new(SEED);
    let each = DRAWN.div_ceil(OF_LIGHT * lights.all.len());
    let mut all = view_directions(size);
    for light in &lights.all {
        for _ in 0..OF_LIGHT {
            let wi = within(light, &mut random);
            if wi.z > 0.05 {
                let seed = (random.share() * 1e9) as u64;
                let drawn = on_orders(height, optics, rotate_deg, wi, each, seed);
                all.extend(drawn.into_iter().map(|directions| directions.wr));
            }
        }
    }
    all
}

/// A random direction within a light; not evenly distributed.
fn within(light: &Light, random: &mut SplitMix64) -> DVec3 {
    match light {
        Light::Direction { direction, .. } => *direction,
        Light::Disc { cap, .. } => {
            let away = (cap.radius_rad * random.share().sqrt()).tan().min(10.0);
            let (first, second) = cap.axis.any_orthonormal_pair();
            let plane = DVec2::from_angle(TAU * random.share());
            (cap.axis + away * (plane.x * first + plane.y * second)).normalize()
        }
        Light::Polygon { polygon, .. } => {
            let sum: DVec3 = polygon.corners().iter().map(|corner| random.share() * *corner).sum();
            sum.normalize()
        }
        Light::Coloured { light, .. } => within(light, random),
        Light::Sky { .. } | Light::Environment(_) => {
            let plane = random.share().sqrt() * DVec2::from_angle(TAU * random.share());
            plane.extend((1.0 - plane.length_squared()).max(0.0).sqrt())
        }
    }
}

/// `count` random viewing directions on the surface's strongest orders, one in four near the mirror direction: `wr =
/// -wi - λ f` with `λ` between 400 and 700 nm and `f` at most 2σf from the order. Evanescent directions are replaced.
/// The same seed gives the same directions, except for the last bits of the transform that ranks the orders.
pub fn on_orders(
    height: &HeightField,
    optics: &Optics,
    rotate_deg: f64,
    light: DVec3,
    count: usize,
    seed: u64,
) -> Vec<Directions> {
    // the light in the frame of the surface
    let turned = DVec2::from_angle(-rotate_deg.to_radians()).rotate(light.truncate());
    let orders = strongest(height, turned.extend(light.z));
    let mut random = SplitMix64::new(seed);
    let mut out = Vec::with_capacity(count);
    // no viewer sees the mirror image of a light at the horizon, and some lights have no order that is seen
    let is_mirrored = light.truncate().length_squared() < SEEN;
    if !is_mirrored && orders.is_empty() {
        return out;
    }
    while out.len() < count {
        let order = match out.len() % 4 {
            0 if is_mirrored => DVec2::ZERO,
            _ => orders[(random.share() * orders.len() as f64) as usize],
        };
        out.extend(near(order, optics, rotate_deg, light, &mut random));
    }
    out
}

/// Maximum square of the plane part of an order's direction that counts as seen: below the limit of [`near`].
const SEEN: f64 = 0.98;

/// A viewing direction within 2σf of an order; `None` if it is evanescent, or nearly so.
fn near(
    order: DVec2,
    optics: &Optics,
    rotate_deg: f64,
    light: DVec3,
    random: &mut SplitMix64,
) -> Option<Directions> {
    let (sin, cos) = rotate_deg.to_radians().sin_cos();
    let lambda_nm = 400.0 + 300.0 * random.share();
    let sigma_cpum = 1.0 / (TAU * optics::window_sigma_um(optics, lambda_nm));
    let (radius, angle) = (2.0 * sigma_cpum * random.share().sqrt(), TAU * random.share());
    let uv = lambda_nm * 1e-3 * (order + radius * DVec2::from_angle(angle));
    // (u, v) of the surface, turned back into the frame of the directions
    let uv = DVec2::new(cos * uv.x - sin * uv.y, sin * uv.x + cos * uv.y);
    let across = -light.truncate() - uv;
    let squared = across.length_squared();
    (squared < 0.99).then(|| Directions { wi: light, wr: across.extend((1.0 - squared).sqrt()) })
}

/// Lights of [`pool`], `[theta, phi]` in degrees.
const LIGHTS: [[f64; 2]; 8] = [
    [20.0, 0.0],
    [0.0, 0.0],
    [40.0, 90.0],
    [60.0, 200.0],
    [30.0, 300.0],
    [50.0, 135.0],
    [70.0, 20.0],
    [10.0, 250.0],
];

/// Candidates for a package's probes, more of each kind than are chosen, all components rounded to 32 bits. The kinds:
/// within 2σf of the mirror direction of several lights; on strong orders of these lights; lights and viewers spread
/// over the hemisphere, first uniformly, then on strong orders.
pub fn pool(height: &HeightField, optics: &Optics, rotate_deg: f64) -> [Vec<Directions>; 3] {
    const KIND: usize = 28;
    const ANYWHERE: usize = 28;
    const TRIES: usize = 100;
    let lights = LIGHTS.map(|[theta, phi]| optics::direction(theta, phi));
    let orders = lights.map(|light| {
        let mut orders = strongest(height, light);
        if orders.len() > 1 {
            orders.retain(|order| *order != DVec2::ZERO);
        }
        orders
    });
    let mut random = SplitMix64::new(SEED);
    let mut on_any_order = |i: usize, light: DVec3| {
        let orders = &orders[i % LIGHTS.len()];
        let mut draw = || {
            let at = (random.share() * orders.len() as f64) as usize;
            let order = orders.get(at).copied().unwrap_or_default();
            near(order, optics, rotate_deg, light, &mut random)
        };
        (0..TRIES).find_map(|_| draw())
    };
    let on_orders: Vec<Directions> =
        (0..KIND).filter_map(|i| on_any_order(i, lights[i % LIGHTS.len()])).collect();
    let mut other = SplitMix64::new(SEED + 1);
    // uniform in solid angle, up to 72° from the normal
    let mut anywhere = || {
        let (z, angle) = (0.3 + 0.7 * other.share(), TAU * other.share());
        ((1.0 - z * z).sqrt() * DVec2::from_angle(angle)).extend(z)
    };
    let mut spread: Vec<Directions> =
        (0..ANYWHERE).map(|_| Directions { wi: anywhere(), wr: anywhere() }).collect();
    spread.extend((0..2 * KIND).filter_map(|i| on_any_order(i, anywhere())));
    let mut third = SplitMix64::new(SEED + 2);
    let mirror = (0..KIND)
        .filter_map(|i| near(DVec2::ZERO, optics, rotate_deg, lights[i % LIGHTS.len()], &mut third))
        .collect();
    [mirror, on_orders, spread].map(|all| all.into_iter().map(rounded).collect())
}

/// Components as 32-bit floats, so that every consumer reads the same numbers.
fn rounded(Directions { wi, wr }: Directions) -> Directions {
    Directions { wi: wi.as_vec3().as_dvec3(), wr: wr.as_vec3().as_dvec3() }
}

/// Frequencies of the strongest orders at 550 nm, cycles per µm, the zero order among them.
fn strongest(height: &HeightField, light: DVec3) -> Vec<DVec2> {
    let lambda_um = optics::REFERENCE_NM * 1e-3;
    let (x_um, y_um) = (height.size_x_um(), height.size_y_um());
    let bins = Bins::reachable(x_um, y_um, 2.0 / lambda_um, 0);
    let z = -TAU / lambda_um * (light.z + 0.9);
    let mut signal: Vec<Complex64> =
        heights_upwards_um(height).iter().map(|h| Complex64::cis(z * h)).collect();
    let coefficients = ifft2(&mut signal, axes(height), bins);
    let mut ranked: Vec<(f64, DVec2)> = coefficients
        .iter()
        .enumerate()
        .map(|(i, c)| {
            let r = (i % bins.width()) as f64 - bins.r_max as f64;
            let s = (i / bins.width()) as f64 - bins.s_max as f64;
            (c.norm_sqr(), DVec2::new(r / x_um, s / y_um))
        })
        // an order that no viewer sees would be retried for ever
        .filter(|(_, f)| (light.truncate() + 0.4 * *f).length_squared() < SEEN)
        .collect();
    let largest = ranked.iter().map(|r| r.0).fold(0.0, f64::max);
    // equally strong orders stay in the order of their bins, whatever their last digits
    let rank = |strength: f64| (strength / largest * 1e9).round();
    ranked.sort_by(|a, b| rank(b.0).total_cmp(&rank(a.0)));
    let min = 1e-5 * largest;
    ranked.into_iter().take(ORDERS).filter(|r| r.0 >= min).map(|r| r.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pool_holds_unit_vectors_of_32_bits_and_repeats() {
        let heights_um = (0..40).map(|i| 0.005 * f64::from(i)).collect();
        let height = HeightField::new(40, 1, 0.05, 0.05, heights_um).expect("valid");
        let optics = Optics::standard();
        let kinds = pool(&height, &optics, 0.0);
        assert_eq!(kinds, pool(&height, &optics, 0.0));
        for (kind, min) in kinds.iter().zip([22, 22, 64]) {
            assert!(kind.len() >= min, "{}", kind.len());
            for v in kind.iter().flat_map(|d| [d.wi, d.wr]) {
                assert!((v.length() - 1.0).abs() < 2e-7 && v.z > 0.0, "{v}");
                assert_eq!(v, v.as_vec3().as_dvec3());
            }
        }
        for d in &kinds[0] {
            assert!((d.wi + d.wr).truncate().length() < 0.02, "{d:?}");
        }
    }

    #[test]
    fn lights_at_the_horizon_have_viewers_or_none() {
        let heights_um = (0..40).map(|i| 0.005 * f64::from(i)).collect();
        let height = HeightField::new(40, 1, 0.05, 0.05, heights_um).expect("valid");
        let optics = Optics { coherence_um: 107.0, ..Optics::standard() };
        for (phi, rotate_deg) in [(0.0, 0.0), (0.0, 180.0), (90.0, 0.0), (90.0, 90.0)] {
            let light = optics::direction(89.0, phi);
            let drawn = on_orders(&height, &optics, rotate_deg, light, 50, 7);
            // across the grooves an order comes back, along them none does
            let across = (phi - rotate_deg).to_radians().cos().abs() > 0.5;
            assert_eq!(drawn.len(), if across { 50 } else { 0 }, "{phi} {rotate_deg}");
        }
    }

    #[test]
    fn drawn_directions_lie_on_orders_and_repeat() {
        let heights_um = (0..40).map(|i| 0.005 * f64::from(i)).collect();
        let height = HeightField::new(40, 1, 0.05, 0.05, heights_um).expect("valid");
        let (optics, light) = (Optics::standard(), optics::direction(20.0, 0.0));
        let drawn = on_orders(&height, &optics, 25.0, light, 200, 7);
        assert_eq!(drawn, on_orders(&height, &optics, 25.0, light, 200, 7));
        assert_ne!(drawn, on_orders(&height, &optics, 25.0, light, 200, 8));
        let reach_um = 2.0 / (TAU * 65.0 / 4.0);
        for d in &drawn {
            assert!((d.wr.length() - 1.0).abs() < 1e-12 && d.wr.z > 0.0);
            let path = optics::path_difference(d.wi, d.wr, 25.0);
            // 2 µm period along x: v is nearly 0, u near a multiple of λ/2 for some λ
            assert!(path.y.abs() <= 0.7 * reach_um + 1e-9);
            let near = (400..=700).any(|nm| {
                let lambda_um = f64::from(nm) * 1e-3;
                let order = path.x / lambda_um * 2.0;
                (order - order.round()).abs() / 2.0 < reach_um + 0.02
            });
            assert!(near, "{path}");
        }
    }
}
