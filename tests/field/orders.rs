//! Exact colours under lights with a size: against a brute sum, against the integral of ρ, and against what is known.

use std::f64::consts::{PI, TAU};

use diffraction_shaders::field::coefficient_brute;
use diffraction_shaders::field::orders::OrderSum;
use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::light::{Cap, Emitter, Light, Polygon};
use diffraction_shaders::optics::spectrum::Spectrum;
use diffraction_shaders::optics::{Matter, diffuser_scale, direction};
use diffraction_shaders::plan::{
    Coherence, CoherenceScaling, Film, Grating, Material, Medium, Obliquity, Optics,
};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use glam::{DVec2, DVec3};

fn optics() -> Optics {
    Optics { coherence_scaling: CoherenceScaling::Wavelength, ..Optics::standard() }
}

fn blazed() -> HeightField {
    let grating = Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 100 };
    synthesise(&grating, "blazed").unwrap().field
}

/// A small cell without any symmetry, 1.5 × 1.1 µm.
fn cell() -> HeightField {
    let (columns, rows) = (18, 14);
    let height = |i: usize| {
        let (x, y) = ((i % columns) as f64 / 18.0, (i / columns) as f64 / 14.0);
        0.09 * (TAU * x).sin() + 0.06 * (TAU * (x + y) + 0.7).cos() + 0.04 * (2.0 * TAU * y).sin()
    };
    let heights_um = (0..columns * rows).map(height).collect();
    HeightField::new(columns, rows, 1.5 / 18.0, 1.1 / 14.0, heights_um).unwrap()
}

/// The definition, with nothing but sums over wavelengths, orders and pixels.
fn brute(
    height: &HeightField,
    rotate_deg: f64,
    optics: &Optics,
    emitter: &dyn Emitter,
    wr: DVec3,
) -> [f64; 3] {
    // light without edges is smooth
    let step_nm = if emitter.bounds().radius_rad < PI { 0.02 } else { 0.25 };
    let spectrum = Spectrum::new(&optics.illuminant).unwrap();
    let matter = Matter::new(optics).unwrap();
    let turn = DVec2::from_angle(rotate_deg.to_radians());
    let mut xyz = DVec3::ZERO;
    for r in -8i64..=8 {
        for s in -6i64..=6 {
            let f = DVec2::new(r as f64 / height.size_x_um(), s as f64 / height.size_y_um());
            let f = turn.rotate(f);
            for i in 0..(400.0 / step_nm) as u32 {
                let lambda_nm = 380.0 + (f64::from(i) + 0.5) * step_nm;
                let plane = -wr.truncate() - lambda_nm * 1e-3 * f;
                if plane.length_squared() >= 1.0 {
                    continue;
                }
                let wi = plane.extend((1.0 - plane.length_squared()).sqrt());
                if emitter.margin(wi) < 0.0 {
                    continue;
                }
                let z = TAU / (lambda_nm * 1e-3) * matter.depth(wi, wr, lambda_nm);
                let square = coefficient_brute(height, r, s, z).norm_sqr();
                let share = matter.normal_reflectance() * matter.gain(wi, wr, lambda_nm) / wi.z;
                let weight = share * square * emitter.radiance(wi).x * step_nm;
                xyz += weight * DVec3::from(spectrum.per_nm(lambda_nm));
            }
        }
    }
    xyz.to_array()
}

fn disc(theta_deg: f64, phi_deg: f64, radius_deg: f64) -> Light {
    let cap = Cap { axis: direction(theta_deg, phi_deg), radius_rad: radius_deg.to_radians() };
    Light::Disc { cap, irradiance: 1.0 }
}

fn rectangle() -> Light {
    let corners = [[20.0, 0.0], [45.0, 10.0], [50.0, 60.0], [25.0, 80.0]];
    let corners = corners.map(|[theta, phi]| direction(theta, phi));
    Light::Polygon { polygon: Polygon::new(&corners).unwrap(), radiance: 0.7 }
}

fn largest(colour: [f64; 3]) -> f64 {
    colour.into_iter().fold(0.0, f64::max)
}

#[test]
fn a_brute_sum_gives_the_same() {
    let height = cell();
    let optics = optics();
    let orders = OrderSum::new(&height, 25.0, &optics).unwrap();
    let lights = [
        disc(30.0, 40.0, 12.0),
        disc(5.0, 0.0, 1.0),
        disc(85.0, 200.0, 15.0), // across the horizon
        rectangle(),
        Light::Sky { radiance: 1.0 },
    ];
    let mut bright = 0;
    for light in &lights {
        let emitter = light.emitter().unwrap();
        for (theta, phi) in [(0.0, 0.0), (33.0, 215.0), (70.0, 20.0)] {
            let wr = direction(theta, phi);
            let exact = orders.radiance(&*emitter, wr);
            let other = brute(&height, 25.0, &optics, &*emitter, wr);
            let scale = largest(other).max(1e-3 * emitter.radiance(wr).x);
            bright += usize::from(largest(other) > 1e-3);
            for c in 0..3 {
                let error = (exact[c] - other[c]).abs() / scale;
                // the brute sum knows the edges of a light to one step
                assert!(error < 2e-3, "{light:?} {theta} {phi}: {exact:?} {other:?}");
            }
        }
    }
    assert!(bright >= 7, "{bright}");
    // the control: another cell
    let emitter = lights[3].emitter().unwrap();
    let wr = direction(33.0, 215.0);
    let other = brute(&height, 0.0, &optics, &*emitter, wr);
    let exact = orders.radiance(&*emitter, wr);
    let apart = (0..3).map(|c| (exact[c] - other[c]).abs()).fold(0.0, f64::max);
    assert!(apart > 0.05 * largest(other), "{exact:?} {other:?}");
}

#[test]
fn shorter_panels_change_nothing() {
    let optics = optics();
    for height in [blazed(), cell()] {
        let orders = OrderSum::new(&height, 0.0, &optics).unwrap();
        let fine = OrderSum::new(&height, 0.0, &optics).unwrap().with_panel_nm(0.5);
        for light in [disc(20.0, 0.0, 0.265), disc(20.0, 0.0, 15.0), Light::Sky { radiance: 1.0 }] {
            let emitter = light.emitter().unwrap();
            for theta in [0.0, 12.0, 40.0, 80.0] {
                let wr = direction(theta, 180.0);
                let (one, other) = (orders.radiance(&*emitter, wr), fine.radiance(&*emitter, wr));
                let scale = largest(other).max(1e-6);
                let worst = (0..3).map(|c| (one[c] - other[c]).abs() / scale).fold(0.0, f64::max);
                assert!(worst < 1e-4, "{light:?} {theta}: {one:?} {other:?}");
            }
        }
    }
}

/// `exp(-(1 - wi·l)/σ²)` about an axis: a light without edges.
struct Glow {
    axis: DVec3,
    sigma: f64,
}

impl Emitter for Glow {
    fn bounds(&self) -> Cap {
        Cap { axis: self.axis, radius_rad: PI }
    }

    fn margin(&self, _: DVec3) -> f64 {
        1.0
    }

    fn radiance(&self, wi: DVec3) -> DVec3 {
        DVec3::splat((-(1.0 - wi.dot(self.axis)) / (self.sigma * self.sigma)).exp())
    }
}

/// `(s/π) ∫ ρ L dΩ` over directions of the light is the sum over orders, if the coherence length follows the wavelength.
/// With a fixed one it is not: the control.
#[test]
fn the_integral_of_the_directional_colours_is_the_sum_over_orders() {
    let height = cell();
    let glow = Glow { axis: direction(25.0, 70.0), sigma: 0.35 };
    let wr = direction(30.0, 200.0);
    let integral = |optics: &Optics| {
        // the midpoint rule over direction cosines; lobes are 0.006 wide
        const SIDE: i32 = 600;
        let place = |i: i32| (f64::from(i) + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
        let directions: Vec<Directions> = (0..SIDE * SIDE)
            .filter_map(|i| {
                let plane = DVec2::new(place(i % SIDE), place(i / SIDE));
                let rest = 1.0 - plane.length_squared();
                let wi = plane.extend(rest.max(0.0).sqrt());
                // what is left out is below 1e-5 of the brightest
                (rest > 0.0 && glow.radiance(wi).x > 1e-5).then_some(Directions { wi, wr })
            })
            .collect();
        let all = directions.iter().copied();
        let reference = Reference::new(&height, 0.0, optics, Reference::VISIBLE_NM, all).unwrap();
        let reference = reference.with_coarsest_step_nm(2.0);
        let colours = reference.tristimulus_all(&directions);
        let cell = (2.0 / f64::from(SIDE)).powi(2);
        let sum: DVec3 = directions
            .iter()
            .zip(colours)
            .map(|(d, colour)| DVec3::from(colour) * (glow.radiance(d.wi).x / d.wi.z * cell))
            .sum();
        (sum * diffuser_scale(optics).unwrap() / PI).to_array()
    };
    let worst = |a: [f64; 3], b: [f64; 3]| {
        (0..3).map(|c| (a[c] - b[c]).abs() / largest(b)).fold(0.0, f64::max)
    };
    let window = Optics {
        coherence_um: 40.0,
        coherence: Coherence::Ensemble,
        coherence_scaling: CoherenceScaling::Wavelength,
        ..Optics::standard()
    };
    let covered = Optics {
        material: Material::Medium(Medium::Named("copper")),
        cover_index: Medium::Named("polycarbonate"),
        films: vec![Film { index: Medium::Constant(2.2), thickness_nm: 60.0 }],
        obliquity: Obliquity::Unpolarised,
        ..window.clone()
    };
    let exact = |optics: &Optics| OrderSum::new(&height, 0.0, optics).unwrap().radiance(&glow, wr);
    for optics in [&window, &covered] {
        let (sum, exact) = (integral(optics), exact(optics));
        println!("{exact:?} {sum:?}: {:.1e}", worst(sum, exact));
        assert!(worst(sum, exact) < 1e-3, "{exact:?} {sum:?}");
    }
    let fixed = Optics { coherence_scaling: CoherenceScaling::Fixed, ..window.clone() };
    assert!(worst(integral(&fixed), exact(&window)) > 0.01);
}

/// A flat mirror returns the light of the mirror direction, times its reflectance.
#[test]
fn a_mirror_shows_the_light() {
    let height = HeightField::new(8, 8, 0.05, 0.05, vec![0.0; 64]).unwrap();
    let optics = optics();
    let orders = OrderSum::new(&height, 0.0, &optics).unwrap();
    let white = Spectrum::new(&"D65".into()).unwrap().white();
    let sky = Light::Sky { radiance: 2.0 };
    let colour = orders.radiance(&*sky.emitter().unwrap(), direction(0.0, 0.0));
    for c in 0..3 {
        assert!((colour[c] - 0.08 * white[c]).abs() < 2e-5, "{colour:?}");
    }
    let Light::Disc { cap, .. } = disc(30.0, 50.0, 2.0) else { unreachable!() };
    let lamp = Light::Disc { cap, irradiance: 1.0 };
    let emitter = lamp.emitter().unwrap();
    let inside = orders.radiance(&*emitter, direction(31.0, 230.0));
    assert!((inside[1] / (0.0400 * cap.radiance(1.0)) - 1.0).abs() < 0.05, "{inside:?}");
    assert_eq!(orders.radiance(&*emitter, direction(33.0, 230.0)), [0.0; 3]);
    assert_eq!(orders.radiance(&*emitter, direction(90.5, 230.0)), [0.0; 3]);
}

#[test]
fn lamps_at_the_horizon_and_of_any_size_give_finite_colours() {
    let height = blazed();
    for shadowing in [true, false] {
        let optics = Optics { shadowing, ..optics() };
        let orders = OrderSum::new(&height, 0.0, &optics).unwrap();
        for radius in [0.05, 0.265, 5.0, 45.0, 89.0] {
            for theta in [0.0, 45.0, 89.9, 90.0, 95.0] {
                let light = disc(theta, 0.0, radius);
                for view in [0.0, 20.0, 60.0, 89.0, 90.0] {
                    let wr = direction(view, 180.0);
                    let colour = orders.radiance(&*light.emitter().unwrap(), wr);
                    let fine = colour.iter().all(|c| c.is_finite() && *c >= 0.0);
                    assert!(fine, "{radius} {theta} {view}: {colour:?}");
                }
            }
        }
    }
}
