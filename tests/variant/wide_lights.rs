//! Lights with a size on many orders: discs as sums of wider lobes, and surroundings by cells, against the exact sum over orders.

use std::f64::consts::PI;
use std::sync::Arc;

use diffraction_shaders::field::orders::OrderSum;
use diffraction_shaders::light::{
    Cap, Emitter, Environment, Filtered, Light, Studio, Surroundings,
};
use diffraction_shaders::optics::direction;
use diffraction_shaders::random::SplitMix64;
use diffraction_shaders::variant::{
    Arguments, Around, ENVIRONMENT, Function, SOFT_DISC, Twin, skies,
};
use glam::{DVec2, DVec3};

use crate::spread::{FINGERS, Shader, p95};
use crate::support::data;

/// A surface with the largest errors that are allowed on it.
struct Case {
    surface: String,
    limits: [f64; 3],
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
        Some(Case { surface: FINGERS.to_owned(), limits: [8.0, 14.0, 25.0] }),
        Some(Case { surface: ROWS.to_owned(), limits: [8.0, 14.0, 25.0] }),
        Some(Case { surface: BUMPS.to_owned(), limits: [8.0, 14.0, 25.0] }),
        scan().map(|surface| Case { surface, limits: [5.0, 8.0, 25.0] }),
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
            for (radius_deg, limit) in [3.0_f64, 8.0, 20.0].into_iter().zip(limits) {
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

/// Colours of viewers among surroundings.
fn among(shader: &Shader, around: &dyn Surroundings, views: &[DVec3]) -> Vec<[f64; 3]> {
    let twin = Twin::new(&shader.form, &shader.tables, 0.0);
    let twin = Twin { surroundings: Some(around), ..twin };
    let call = |wr: &DVec3| Arguments::Environment { around: Around::Host, wr: *wr };
    views.iter().map(|wr| twin.evaluate(call(wr)).unwrap()).collect()
}

/// The same surroundings on the other side.
struct Turned<'a>(&'a dyn Surroundings);

impl Surroundings for Turned<'_> {
    fn seen(&self, direction: DVec3, spread_rad: f64) -> DVec3 {
        self.0.seen(direction * DVec3::new(-1.0, -1.0, 1.0), spread_rad)
    }
}

fn cells(surface: &str, count: u32) -> Shader {
    let keys = format!(
        "coherence_um = 25\nspread_levels = 1\nbake_mib = 0.25\nlights = [\"environment\"]\ncells = {count}"
    );
    Shader::new(surface, &keys)
}

/// Four skies by formula and the three studios on few orders; they must be within the stated error for each number of cells.
#[test]
fn cells_are_lit_by_the_surroundings() {
    let views = viewers(24, DVec2::ZERO);
    let studio = |kind: Studio| {
        let panorama = Arc::new(kind.panorama(256));
        Environment { panorama, scale: 1.0, rotate_deg: 0.0 }
    };
    let studios = [Studio::Softboxes, Studio::Window, Studio::Gradient].map(studio);
    let mut failed = Vec::new();
    for (surface, counts, with_studios) in
        [(FINGERS, &[64, 128, 256][..], true), (ROWS, &[128][..], false)]
    {
        let shaders: Vec<Shader> = counts.iter().map(|count| cells(surface, *count)).collect();
        let height = &shaders[0].height;
        let orders = OrderSum::new(height, 0.0, &shaders[0].variant.optics).unwrap();
        let mut check =
            |name: &str, emitter: &dyn Emitter, around: &dyn Surroundings, turns: bool| {
                let exact = orders.radiance_all_with(&[emitter], &views, &|_| ());
                for (shader, count) in shaders.iter().zip(counts) {
                    let stated = ENVIRONMENT.errors(&shader.form)[0].de2000_p95;
                    let found = p95(&exact, &among(shader, around, &views));
                    let wrong = p95(&exact, &among(shader, &Turned(around), &views));
                    println!("{name}, {count} cells: {found:.2} of {stated:.1}, turned {wrong:.1}");
                    if found > stated || (turns && wrong < stated) {
                        failed.push(format!("{surface} {count} {name}: {found:.2} {wrong:.1}"));
                    }
                }
            };
        for (i, sky) in skies().iter().enumerate() {
            // Turning shows nothing of sky 0, which is even, and little of sky 2, whose lamp is small.
            check(&format!("sky {i}"), sky, sky, i % 2 == 1);
        }
        for map in studios.iter().filter(|_| with_studios) {
            let light = Light::Environment(map.clone());
            let filtered = Filtered::blurred(&|d| map.radiance(d), 1);
            check("studio", &*light.emitter().unwrap(), &filtered, true);
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
