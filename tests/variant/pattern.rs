//! Patterns: one table for every angle, period and depth of a grating, against the same grating compiled for itself.

use std::path::Path;

use diffraction_shaders::field::comparison_directions::under_lights;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::light::{Cap, Light, Lights};
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Plan, Variant};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::variant::{Form, Pattern, Twin, probes_of};
use glam::{DVec2, DVec3};

use crate::spread::p95;

const BLAZED: &str = "{ kind = \"blazed\", period_um = 1.5, height_um = 0.25, pixels = 96 }";
const LAMELLAR: &str =
    "{ kind = \"lamellar\", period_um = 1.2, height_um = 0.15, pixels = 96, duty = 0.5 }";

const RANGES: &str = "pattern = true\nperiod_ratio = [0.5, 2.0]\ndepth_ratio = [0.4, 1.6]\n";

fn plan(grating: &str, keys: &str) -> Result<Plan, String> {
    let text = format!(
        "schema = 1\n[[surface]]\nname = \"a\"\ngrating = {grating}\n[optics]\nsource_diameter_deg = 0.53\ncoherence = \"ensemble\"\n[[preset]]\nname = \"foil\"\nmode = \"orders\"\n{keys}"
    );
    Plan::parse(&text, Path::new("plan.toml")).map_err(|errors| format!("{errors:?}"))
}

fn subject(grating: &str, keys: &str) -> (HeightField, Variant) {
    let plan = plan(grating, keys).unwrap();
    (load(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone())
}

/// Ten patterns over the whole ranges.
fn patterns() -> Vec<Pattern> {
    let part = |i: u32, pace: f64| (0.5 + f64::from(i) * pace).fract();
    let pattern = |i| Pattern {
        angle_deg: 360.0 * part(i, 0.618),
        period_ratio: 0.5 * 4.0_f64.powf(part(i, 0.7549)),
        depth_ratio: 0.4 + 1.2 * part(i, 0.5698),
    };
    (0..10).map(pattern).collect()
}

/// `T_{a,b}(u, v, w) = T(a u, a v, b w)` with lobes of the same width: the order sum of a scaled cell is that of the cell at scaled
/// phases. The twin of the scaled form on exact tables is the twin of the scaled surface.
#[test]
fn a_scaled_cell_is_the_cell_at_a_scaled_phase() {
    let (height, variant) = subject(BLAZED, "lights = [\"direction\"]");
    let form = Form::new(&variant, &height).unwrap();
    for pattern in patterns() {
        let scaled = pattern.scaled(&height).unwrap();
        let own = Form::new(&variant, &scaled).unwrap();
        let (Form::Orders(of_texel), Form::Orders(own)) = (form.patterned(&pattern), own) else {
            panic!("not orders")
        };
        for (a, b) in of_texel.sum.patch_um.iter().zip(own.sum.patch_um) {
            assert!((a - b).abs() < 1e-12, "{pattern:?}");
        }
        // |c(z)|² of the scaled heights is |c(b z)|²
        let z = 2.0 * std::f64::consts::TAU / 0.45;
        for order in -3..=3 {
            let amplitude = |field: &HeightField, z: f64| {
                let step = std::f64::consts::TAU * f64::from(order) / field.columns() as f64;
                let heights = field.heights_um()[..field.columns()].iter().enumerate();
                let sum = heights.fold(DVec2::ZERO, |sum, (i, h)| {
                    sum + DVec2::from_angle(-z * h - step * i as f64)
                });
                sum / field.columns() as f64
            };
            let apart = amplitude(&scaled, z).length_squared()
                - amplitude(&height, pattern.depth_ratio * z).length_squared();
            assert!(apart.abs() < 1e-12, "{pattern:?}: {apart:e}");
        }
    }
}

/// A texel's colours against those of the grating that it is. Without the depth, the period, or the angle they are far off.
#[test]
fn texels_are_the_gratings_that_they_stand_for() {
    let disc = |radius_deg: f64| {
        let cap = Cap { axis: direction(25.0, 40.0), radius_rad: radius_deg.to_radians() };
        Light::Disc { cap, irradiance: 1.0 }
    };
    let sky = Light::Sky { radiance: 1.0 };
    let wi = direction(25.0, 40.0);
    for grating in [BLAZED, LAMELLAR] {
        let (height, variant) = subject(grating, &format!("nodes = 32\n{RANGES}"));
        let (mut worst, mut caught) = ([0.0_f64; 3], [f64::MAX; 3]);
        for pattern in patterns() {
            let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
            let twin =
                |pattern: &Pattern| TwinRunner::new(placement, true).unwrap().patterned(pattern);
            let own = pattern.scaled(&height).unwrap();
            let rotate_deg = pattern.angle_deg;
            let exact = Exact(Placement { height: &own, rotate_deg, variant: &variant });
            for (i, light) in [None, Some(disc(3.0)), Some(sky.clone())].iter().enumerate() {
                let all = vec![light.clone().unwrap_or_else(|| disc(0.3))];
                let lights = Lights { all, notes: Vec::new() };
                let views = under_lights(&own, &variant.optics, rotate_deg, &lights, 1);
                // the exact sky takes long
                let count = if i == 2 { 16 } else { 60 };
                let step = (views.len() / count).max(1);
                let views: Vec<DVec3> =
                    views.into_iter().step_by(step).take(count).map(rounded).collect();
                let colours = |runner: &dyn Runner| match light {
                    Some(light) => runner.under(light, &views, &|_| ()).unwrap(),
                    None => {
                        let wi = rounded(wi);
                        let all: Vec<Directions> =
                            views.iter().map(|wr| Directions { wi, wr: *wr }).collect();
                        runner.tristimulus(&all).unwrap()
                    }
                };
                let right = colours(&exact);
                worst[i] = worst[i].max(p95(&right, &colours(&twin(&pattern))));
                if i == 1 {
                    let wrong = [
                        Pattern { depth_ratio: 1.0, ..pattern },
                        Pattern { period_ratio: 1.0, ..pattern },
                        Pattern { angle_deg: pattern.angle_deg + 30.0, ..pattern },
                    ];
                    for (caught, wrong) in caught.iter_mut().zip(wrong) {
                        // the first texel is the surface as it is
                        if wrong != pattern {
                            *caught = caught.min(p95(&right, &colours(&twin(&wrong))));
                        }
                    }
                }
            }
        }
        println!("{grating}: {worst:.3?}; depth, period, angle forgotten: at least {caught:.1?}");
        assert!(worst.iter().all(|worst| *worst <= 0.5), "{worst:?}");
        assert!(caught.iter().all(|caught| *caught > 1.0), "{caught:?}");
    }
}

/// Probes are on four patterns, and the reference is that of the scaled relief.
#[test]
fn probes_cover_the_ranges() {
    let (height, variant) = subject(BLAZED, RANGES);
    let form = Form::new(&variant, &height).unwrap();
    let tables = diffraction_shaders::shader::specialise::tables(&form, &height, 0.0).unwrap();
    let tables: Vec<_> = tables.into_iter().map(|table| table.rounded()).collect();
    let twin = Twin::new(&form, &tables, 0.0);
    for function in form.functions() {
        let probes = probes_of(function, &variant, &height, 0.0).unwrap();
        assert_eq!(probes.len(), function.probe_count());
        for (i, probe) in probes.iter().enumerate() {
            assert_eq!(probe.pattern, Pattern::probes(&variant)[i % 4]);
            let found = twin.evaluate_on(&probe.pattern, probe.arguments).unwrap();
            let apart = (0..3).map(|c| (found[c] - probe.xyz[c]).abs()).fold(0.0, f64::max);
            let most = probe.xyz.into_iter().fold(0.0, f64::max);
            let allowed = 0.25 * most + 0.02;
            assert!(apart <= allowed, "{} {i}: {found:?} {probe:?}", function.name());
        }
    }
    // the least and the greatest ratios are among them
    let all = Pattern::probes(&variant).map(|p| [p.period_ratio, p.depth_ratio]);
    assert!(all.iter().any(|p| p[0] == 0.5) && all.iter().any(|p| p[0] == 2.0));
}

#[test]
fn patterns_outside_the_ranges_are_refused() {
    let (_, variant) = subject(BLAZED, RANGES);
    let pattern = |period_ratio, depth_ratio| Pattern { angle_deg: 3.0, period_ratio, depth_ratio };
    assert!(pattern(2.0, 1.6).check(&variant).is_ok());
    for (bad, key) in [
        (pattern(2.1, 1.0), "period_ratio"),
        (pattern(0.4, 1.0), "period_ratio"),
        (pattern(1.0, 1.7), "depth_ratio"),
        (pattern(f64::NAN, 1.0), "period_ratio"),
    ] {
        let said = bad.check(&variant).unwrap_err().to_string();
        assert!(said.contains(key), "{said}");
    }
    let (_, plain) = subject(BLAZED, "");
    let said = Pattern::NONE.check(&plain).unwrap_err().to_string();
    assert!(said.contains("pattern = true"), "{said}");
}
