//! Lights with a size on many orders: discs as sums of wider lobes, and surroundings by cells, against the exact sum over orders.

use std::f64::consts::PI;

use diffraction_shaders::field::orders::OrderSum;
use diffraction_shaders::light::{Cap, Light, Sky};
use diffraction_shaders::optics::direction;
use diffraction_shaders::random::SplitMix64;
use diffraction_shaders::variant::{Arguments, Around, CELLS, Function, SOFT_DISC, skies};
use glam::{DVec2, DVec3};

use crate::spread::{FINGERS, Shader, p95};
use crate::support::data;

/// A surface with the largest errors that are allowed on it.
struct Case {
    surface: String,
    limits: [f64; 2],
}

const ROWS: &str = "grating = { kind = \"rows\", size_um = 16, pixels = 240, pitch_um = 1.5, height_um = 0.25, seed = 7 }";
const BUMPS: &str = "grating = { kind = \"bumps\", size_um = 16, pixels = 240, pitch_um = 2.0, height_um = 0.25, seed = 7 }";

/// A scan of snake skin, if it is there.
fn scan() -> Option<String> {
    let path = data::find("elaphe_65um.png")?;
    Some(format!("file = {path:?}\nsize_um = 65.0\nheight_um = 0.375"))
}

/// Viewers, evenly by direction cosines; a quarter of them about the mirror direction of a light.
fn viewers(count: usize, mirror: DVec2) -> Vec<DVec3> {
    let mut random = SplitMix64::new(3);
    let view = |i: usize| {
        let turn = DVec2::from_angle(2.0 * PI * random.share());
        let plane = match i % 4 {
            0 => mirror + 0.15 * random.share() * turn,
            _ => 0.95 * random.share().sqrt() * turn,
        };
        plane.extend((1.0 - plane.length_squared()).sqrt())
    };
    (0..count).map(view).collect()
}

#[test]
fn discs_are_sums_of_lobes() {
    let cases = [
        Some(Case { surface: FINGERS.to_owned(), limits: [8.0, 14.0] }),
        Some(Case { surface: ROWS.to_owned(), limits: [8.0, 14.0] }),
        Some(Case { surface: BUMPS.to_owned(), limits: [8.0, 14.0] }),
        scan().map(|surface| Case { surface, limits: [5.0, 8.0] }),
    ];
    let mut failed = Vec::new();
    for Case { surface, limits } in cases.into_iter().flatten() {
        let shader = Shader::new(
            &surface,
            "coherence_um = 25\nspread_levels = \"auto\"\nbake_error = 1\nlights = [\"disc\"]",
        );
        println!("{surface}: {:?}", SOFT_DISC.errors(&shader.form));
        let orders = OrderSum::new(&shader.height, 0.0, &shader.variant.optics).unwrap();
        for theta in [30.0, 60.0] {
            let axis = direction(theta, 20.0);
            let views = viewers(48, -axis.truncate());
            for (radius_deg, limit) in [3.0_f64, 8.0].into_iter().zip(limits) {
                let radius_rad = radius_deg.to_radians();
                let light = Light::Disc { cap: Cap { axis, radius_rad }, irradiance: 1.0 };
                let exact =
                    orders.radiance_all_with(&[&*light.emitter().unwrap()], &views, &|_| ());
                let under = |radius_rad: f64| -> Vec<[f64; 3]> {
                    let call = |wr: &DVec3| {
                        shader.call(Arguments::Disc { axis, radius_rad, colour: None, wr: *wr })
                    };
                    views.iter().map(call).collect()
                };
                let all = under(radius_rad);
                let (found, narrow) = (p95(&exact, &all), p95(&exact, &under(0.005)));
                let light = |all: &[[f64; 3]]| all.iter().map(|xyz| xyz[1]).sum::<f64>();
                let ratio = light(&all) / light(&exact);
                println!(
                    "{radius_deg}° at {theta}°: {found:.2}, of 0.3°: {narrow:.1}, light {ratio:.3}"
                );
                if !(found <= limit && narrow > 2.0 * found && (ratio - 1.0).abs() < 0.05) {
                    failed.push(format!(
                        "{surface} {theta} {radius_deg}: {found:.2} {narrow:.2} {ratio:.3}"
                    ));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn cells_are_lit_by_the_surroundings() {
    let cases = [Some(FINGERS.to_owned()), Some(ROWS.to_owned()), scan()];
    let mut failed = Vec::new();
    for surface in cases.into_iter().flatten() {
        println!("{surface}");
        let views = viewers(24, DVec2::ZERO);
        let mut exact = None;
        for cells in [128] {
            let keys = format!(
                "coherence_um = 25\nspread_levels = 1\nbake_mib = 0.25\nlights = [\"environment\"]\ncells = {cells}"
            );
            let shader = Shader::new(&surface, &keys);
            let stated = CELLS.errors(&shader.form)[0].de2000_p95;
            let exact = exact.get_or_insert_with(|| {
                let orders = OrderSum::new(&shader.height, 0.0, &shader.variant.optics).unwrap();
                skies().map(|sky| orders.radiance_all_with(&[&sky], &views, &|_| ()))
            });
            let under = |sky: Sky| -> Vec<[f64; 3]> {
                let call = |wr: &DVec3| {
                    shader.call(Arguments::Environment { around: Around::Sky(sky), wr: *wr })
                };
                views.iter().map(call).collect()
            };
            for (i, (sky, exact)) in skies().into_iter().zip(exact.iter()).enumerate() {
                let found = p95(exact, &under(sky));
                // the same lobes on the other side
                let turned = Sky {
                    lobes: sky.lobes.map(|lobe| diffraction_shaders::light::Lobe {
                        axis: lobe.axis * DVec3::new(-1.0, -1.0, 1.0),
                        ..lobe
                    }),
                    ..sky
                };
                let wrong = p95(exact, &under(turned));
                println!("{cells} cells, sky {i}: {found:.2} of {stated:.1}, turned {wrong:.1}");
                if !(found <= stated && (i == 0 || wrong > 2.0 * found)) {
                    failed.push(format!("{surface} {cells} {i}: {found:.2} {wrong:.1}"));
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
