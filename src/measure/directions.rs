//! Where colours are compared: a map's pixels, and directions drawn where the light is.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rustfft::num_complex::Complex64;

use crate::frame::view_directions;
use crate::height::HeightField;
use crate::optics;
use crate::plan::Optics;
use crate::reference::Directions;
use crate::transform::{Bins, axes, heights_upwards_um, ifft2};

/// Directions that are drawn beside the pixels of a map.
const DRAWN: usize = 4096;
/// Seed of the drawn directions.
const SEED: u64 = 1;
/// Orders that directions are drawn on, the strongest first.
const ORDERS: usize = 64;

/// The directions of a comparison: the pixel centres of a map of `size × size` under a light, and 4096 drawn by
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

/// `count` viewing directions on the surface's strongest orders, one in four around the mirror direction: `wr = -wi - λ f`
/// with `λ` between 400 and 700 nm and `f` at most 2σf from the order. Evanescent ones are drawn again. The same seed gives
/// the same directions, but for the last bits of the transform that ranks the orders.
pub fn on_orders(
    height: &HeightField,
    optics: &Optics,
    rotate_deg: f64,
    light: DVec3,
    count: usize,
    seed: u64,
) -> Vec<Directions> {
    let orders = strongest(height, light);
    let (sin, cos) = rotate_deg.to_radians().sin_cos();
    let mut random = Random(seed);
    let mut out = Vec::with_capacity(count);
    while out.len() < count {
        let order = match out.len() % 4 {
            0 => DVec2::ZERO,
            _ => orders[(random.next() * orders.len() as f64) as usize],
        };
        let lambda_nm = 400.0 + 300.0 * random.next();
        let sigma_cpum = 1.0 / (TAU * optics::window_sigma_um(optics, lambda_nm));
        let (radius, angle) = (2.0 * sigma_cpum * random.next().sqrt(), TAU * random.next());
        let uv = lambda_nm * 1e-3 * (order + radius * DVec2::from_angle(angle));
        // (u, v) of the surface, turned back into the frame of the directions
        let uv = DVec2::new(cos * uv.x - sin * uv.y, sin * uv.x + cos * uv.y);
        let across = -light.truncate() - uv;
        let squared = across.length_squared();
        if squared < 0.99 {
            out.push(Directions { wi: light, wr: across.extend((1.0 - squared).sqrt()) });
        }
    }
    out
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
        // what no viewer sees would be drawn for ever
        .filter(|(_, f)| (light.truncate() + 0.4 * *f).length_squared() < 0.98)
        .collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let least = ranked.first().map_or(0.0, |r| 1e-5 * r.0);
    ranked.into_iter().take(ORDERS).filter(|r| r.0 >= least).map(|r| r.1).collect()
}

/// SplitMix64 (Steele, Lea & Flood 2014): numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
