//! Random paths: their mean against the exact radiance, and their deviation against even sampling.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use diffraction_shaders::field::orders::OrderSum;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::input::load_surface;
use diffraction_shaders::light::{Cap, Emitter, Environment, Light, Lobe, Panorama, Sky};
use diffraction_shaders::optics::spectrum::Spectrum;
use diffraction_shaders::optics::{diffuser_scale, direction};
use diffraction_shaders::plan::{Plan, Variant};
use diffraction_shaders::random::SplitMix64;
use diffraction_shaders::shader::specialise;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::paths::{OrderPaths, order_paths_table};
use diffraction_shaders::tables::{PATHS, Table};
use diffraction_shaders::variant::{Arguments, Form, Function, PATH, Twin};
use glam::{DVec2, DVec3};

use crate::support::data::find;

const CD: &str = "grating = { kind = \"lamellar\", period_um = 1.6, height_um = 0.12, pixels = 100, duty = 0.69 }";
const BLAZED: &str =
    "grating = { kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 100 }";
const CROSSED: &str = "grating = { kind = \"crossed\", x = { kind = \"sinusoidal\", period_um = 1.5, height_um = 0.3, pixels = 48 }, y = { kind = \"lamellar\", period_um = 2.0, height_um = 0.1, duty = 0.4, pixels = 48 } }";
const ORDERS: &str = "mode = \"orders\"";
const BAKED: &str = "mode = \"baked\"\nbake_error = 1\ntable = \"f32\"\nsampling = \"load\"";

struct Shader {
    height: HeightField,
    variant: Variant,
    form: Form,
    tables: Vec<Table>,
    rotate_deg: f64,
}

impl Shader {
    fn new(surface: &str, keys: &str, rotate_deg: f64) -> Shader {
        let text = format!(
            "schema = 1\n[[surface]]\nname = \"a\"\n{surface}\n[optics]\nsource_diameter_deg = 0.87\n[[preset]]\nname = \"p\"\nlights = [\"direction\", \"path\"]\ncoherence = \"ensemble\"\n{keys}\n"
        );
        let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap();
        let (height, variant) =
            (load_surface(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone());
        let form = Form::new(&variant, &height).unwrap();
        let tables = specialise::tables(&form, &height, rotate_deg).unwrap();
        let tables = tables.into_iter().map(Table::rounded).collect();
        Shader { height, variant, form, tables, rotate_deg }
    }

    fn twin(&self) -> Twin<'_> {
        Twin::new(&self.form, &self.tables, self.rotate_deg)
    }

    fn with_paths(mut self, paths: Table) -> Shader {
        self.tables.retain(|table| table.binding != PATHS);
        self.tables.push(paths);
        self
    }

    /// The light of a path: its weight times the radiance from its direction.
    fn light(&self, emitter: &dyn Emitter, wr: DVec3, random: DVec3) -> DVec3 {
        let twin = self.twin();
        let path = twin.path(wr, random).unwrap();
        let wi = path.truncate();
        if wi.z <= 0.0 || emitter.margin(wi) < 0.0 {
            return DVec3::ZERO;
        }
        let weight = DVec3::from(twin.path_weight(wr, path).unwrap());
        let radiance = emitter.radiance(wi);
        // light on colours is grey here: they have no wavelengths
        twin.path_light(radiance, path.w).unwrap_or(radiance.y) * weight
    }

    /// Mean of the light of paths, and its standard error.
    fn mean(&self, emitter: &dyn Emitter, wr: DVec3, count: usize, seed: u64) -> [DVec3; 2] {
        let mut random = SplitMix64::new(seed);
        mean(count, || {
            let numbers = DVec3::new(random.share(), random.share(), random.share());
            self.light(emitter, wr, numbers)
        })
    }

    /// The radiance of a table of colours by a dense grid of directions.
    fn grid(&self, emitter: &dyn Emitter, wr: DVec3, count: usize) -> DVec3 {
        let twin = self.twin();
        let scale = diffuser_scale(&self.variant.optics).unwrap() / PI;
        let step = 2.0 / count as f64;
        let mut sum = DVec3::ZERO;
        for i in 0..count * count {
            let place = DVec2::new((i % count) as f64, (i / count) as f64) + 0.5;
            let plane = step * place - 1.0;
            let wi = plane.extend((1.0 - plane.length_squared()).max(0.0).sqrt());
            if wi.z <= 0.01 || emitter.margin(wi) < 0.0 {
                continue;
            }
            let rho = DVec3::from(twin.tristimulus(Directions { wi, wr }));
            sum += scale * step * step / wi.z * emitter.radiance(wi).y * rho;
        }
        sum
    }
}

fn mean(count: usize, mut sample: impl FnMut() -> DVec3) -> [DVec3; 2] {
    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
    for _ in 0..count {
        let light = sample();
        sum += light;
        squares += light * light;
    }
    let mean = sum / count as f64;
    let variance = (squares / count as f64 - mean * mean).max(DVec3::ZERO);
    [mean, (variance / count as f64).map(f64::sqrt)]
}

/// A map without symmetry, a sky by a formula, and a lamp about the mirror image of a viewer.
fn lights(is_grey: bool, wr: DVec3) -> [(&'static str, Light); 3] {
    let tint = |colour: DVec3| if is_grey { DVec3::splat(colour.y) } else { colour };
    let panorama = Panorama::drawn(64, &|d| {
        let window = d.x > 0.2 && d.x < 0.7 && d.y.abs() < 0.4;
        let lit = if window { DVec3::new(6.0, 4.0, 2.0) } else { DVec3::new(0.1, 0.3, 0.6) };
        tint(lit * (1.2 + d.y))
    });
    let map = Environment { panorama: std::sync::Arc::new(panorama), scale: 1.0, rotate_deg: 0.0 };
    let lobe = |theta, phi, colour| Lobe {
        axis: direction(theta, phi),
        sigma_rad: 0.3,
        radiance: tint(DVec3::from(colour)),
    };
    let sky = Sky {
        constant: tint(DVec3::new(0.4, 0.5, 0.7)),
        lobes: [lobe(40.0, 20.0, [3.0, 1.0, 0.2]), lobe(60.0, 200.0, [0.1, 1.0, 2.0])],
    };
    let axis = DVec3::new(0.1 - wr.x, -wr.y, wr.z).normalize();
    let cap = Cap { axis, radius_rad: 0.35 };
    let lamp = Light::Disc { cap, irradiance: PI * cap.radius_rad.sin().powi(2) };
    [("map", Light::Environment(map)), ("sky", Light::Environment(from_sky(sky))), ("lamp", lamp)]
}

/// A sky as a map: both are exact lights, and the formula is drawn finely.
fn from_sky(sky: Sky) -> Environment {
    let panorama = Panorama::drawn(512, &|d| sky.radiance(d));
    Environment { panorama: std::sync::Arc::new(panorama), scale: 1.0, rotate_deg: 0.0 }
}

const VIEWS: [[f64; 2]; 3] = [[0.0, 0.0], [35.0, 60.0], [65.0, 250.0]];

/// How far a mean is from the truth, in standard errors, and relative to the truth.
fn apart([mean, error]: [DVec3; 2], truth: DVec3) -> (f64, f64) {
    let away = (mean - truth).abs();
    ((away / error).max_element(), away.max_element() / truth.max_element())
}

/// The mean of all paths is the exact radiance.
#[test]
fn the_mean_of_paths_over_orders_is_exact() {
    for (name, surface, rotate_deg) in
        [("cd", CD, 0.0), ("blazed", BLAZED, 25.0), ("crossed", CROSSED, 0.0)]
    {
        let shader = Shader::new(surface, ORDERS, rotate_deg);
        let orders = OrderSum::new(&shader.height, rotate_deg, &shader.variant.optics).unwrap();
        for (i, [theta, phi]) in VIEWS.into_iter().enumerate() {
            let wr = direction(theta, phi);
            for (of, light) in &lights(false, wr) {
                let emitter = light.emitter().unwrap();
                let truth = DVec3::from(orders.radiance(&*emitter, wr));
                let found = shader.mean(&*emitter, wr, 400_000, 11 + i as u64);
                let (errors, relative) = apart(found, truth);
                println!(
                    "{name} {of} {theta}: {errors:.2} standard errors, {:.3} %",
                    100.0 * relative
                );
                assert!(errors < 4.0 && relative < 0.03, "{name} {of} {theta}: {found:?} {truth}");
            }
        }
    }
}

/// Probabilities from one angle and one wavelength, without a floor: where an order has no light there, it is never drawn, and
/// the mean is too dim. These pits are a quarter of a wavelength deep, so that they have no mirror image at the normal.
#[test]
fn probabilities_without_a_floor_lose_light() {
    const PITS: &str = "grating = { kind = \"lamellar\", period_um = 1.6, height_um = 0.145, pixels = 64, duty = 0.5 }";
    let shader = Shader::new(PITS, ORDERS, 0.0);
    let Form::Orders(form) = &shader.form else { panic!("orders") };
    let spectrum = Spectrum::new(&shader.variant.optics.illuminant).unwrap();
    let narrow = OrderPaths { steepness: [2.0; 2], floor: 0.0, averaged: [1, 1], ..form.paths() };
    let biased = Shader::new(PITS, ORDERS, 0.0)
        .with_paths(order_paths_table(&shader.height, &spectrum, &narrow).rounded());
    let orders = OrderSum::new(&shader.height, 0.0, &shader.variant.optics).unwrap();
    for [theta, phi] in &VIEWS[1..] {
        let wr = direction(*theta, *phi);
        for (of, light) in &lights(false, wr) {
            let emitter = light.emitter().unwrap();
            let truth = DVec3::from(orders.radiance(&*emitter, wr));
            let (right, _) = apart(shader.mean(&*emitter, wr, 200_000, 3), truth);
            let dim = biased.mean(&*emitter, wr, 200_000, 3);
            let (wrong, _) = apart(dim, truth);
            println!("{of} {theta}: biased {:.2} of the truth", dim[0].y / truth.y);
            assert!(right < 4.0 && wrong > 10.0, "{of} {theta}: {right} {wrong}");
            assert!(dim[0].y < 0.98 * truth.y, "{of} {theta}");
        }
    }
}

/// The same on tables of colours: against a dense grid of directions on the same table, and against the exact radiance of the
/// unwidened orders.
#[test]
fn the_mean_of_paths_over_colours_is_that_of_the_table() {
    let mut surfaces = vec![
        ("blazed", BLAZED.to_owned(), 25.0),
        ("bumps", "grating = { kind = \"bumps\", size_um = 12, pixels = 128, pitch_um = 1.5, height_um = 0.3, seed = 3 }".to_owned(), 0.0),
    ];
    if let Some(scan) = find("elaphe_65um.png") {
        let scan = format!("file = {scan:?}\nsize_um = 65\nheight_um = 0.375");
        surfaces.push(("elaphe", scan, 0.0));
    }
    for (name, surface, rotate_deg) in surfaces {
        let shader = Shader::new(&surface, BAKED, rotate_deg);
        let orders =
            OrderSum::new(&shader.height, rotate_deg, &shader.variant.optics).unwrap().for_skies();
        for (i, [theta, phi]) in VIEWS.into_iter().enumerate() {
            let wr = direction(theta, phi);
            for (of, light) in &lights(true, wr) {
                let emitter = light.emitter().unwrap();
                let truth = shader.grid(&*emitter, wr, 1200);
                let found = shader.mean(&*emitter, wr, 300_000, 51 + i as u64);
                let (errors, relative) = apart(found, truth);
                println!(
                    "{name} {of} {theta}: {errors:.2} standard errors, {:.3} %",
                    100.0 * relative
                );
                // the sum over the orders of a scan is long
                if name != "elaphe" || i == 1 && *of == "map" {
                    let exact = DVec3::from(orders.radiance(&*emitter, wr));
                    let away = apart(found, exact).1;
                    println!("    {:.2} % from the exact radiance", 100.0 * away);
                    assert!(away < 0.03, "{name} {of} {theta}: {found:?} {exact}");
                }
                let is_same = errors < 4.0 || relative < 2e-3;
                assert!(is_same && relative < 0.03, "{name} {of} {theta}: {found:?} {truth}");
            }
        }
    }
}

/// Deviation of one path under a map, against directions, or orders and wavelengths, that are drawn evenly.
#[test]
fn paths_deviate_less_than_even_ones() {
    let wr = direction(35.0, 60.0);
    let lights = lights(true, wr);
    let emitter = lights[0].1.emitter().unwrap();
    const COUNT: usize = 200_000;
    let deviation = |[_, error]: [DVec3; 2]| error.y * (COUNT as f64).sqrt();
    let shader = Shader::new(CD, BAKED, 0.0);
    let own = shader.mean(&*emitter, wr, COUNT, 3);
    let scale = diffuser_scale(&shader.variant.optics).unwrap() / PI;
    let mut random = SplitMix64::new(5);
    let even = mean(COUNT, || {
        let z = random.share();
        let plane = (1.0 - z * z).sqrt() * DVec2::from_angle(TAU * random.share());
        let wi = plane.extend(z);
        let rho = DVec3::from(shader.twin().tristimulus(Directions { wi, wr }));
        TAU * scale * emitter.radiance(wi).y * rho
    });
    let baked = deviation(even) / deviation(own);
    println!(
        "colours: {:.3} of the mean, even directions {:.1}: {baked:.0} times",
        deviation(own) / own[0].y,
        deviation(even) / even[0].y
    );
    let shader = Shader::new(CD, ORDERS, 0.0);
    let own = shader.mean(&*emitter, wr, COUNT, 3);
    let Form::Orders(form) = &shader.form else { panic!("orders") };
    let spectrum = Spectrum::new(&shader.variant.optics.illuminant).unwrap();
    let even = OrderPaths { floor: 1.0, ..form.paths() };
    let mut even = order_paths_table(&shader.height, &spectrum, &even).rounded();
    let (width, cells) = (even.width, even.width - 1);
    for edge in 0..=cells {
        even.texels[4 * (width + edge)] = edge as f64 / cells as f64;
        even.texels[4 * (2 * width + edge)] = 1.0 / cells as f64;
    }
    let truth = own[0].y;
    let even = Shader::new(CD, ORDERS, 0.0).with_paths(even).mean(&*emitter, wr, COUNT, 3);
    let orders = deviation(even) / deviation(own);
    println!(
        "orders: {:.3} of the mean, even ones {:.2}: {orders:.1} times",
        deviation(own) / truth,
        deviation(even) / truth
    );
    assert!((even[0].y - truth).abs() < 5.0 * even[1].y + 5.0 * own[1].y);
    assert!(baked > 10.0 && orders > 1.5, "{baked} {orders}");
}

/// The arguments of probes go to storage and back, and their mean is close to the exact result.
#[test]
fn probes_of_paths_are_calls() {
    for keys in [ORDERS, BAKED] {
        let shader = Shader::new(BLAZED, keys, 25.0);
        let (mut sum, mut exact) = (0.0, 0.0);
        for probe in PATH.probes(&shader.height, 25.0, &shader.variant.optics).unwrap() {
            let numbers = probe.arguments.to_numbers();
            assert_eq!(numbers.len(), Arguments::width(probe.arguments.kind()));
            let again = Arguments::from_numbers(probe.arguments.kind(), &numbers);
            assert_eq!(again, Some(probe.arguments));
            let [_, y, _] = shader.twin().evaluate(probe.arguments).unwrap();
            assert!(y >= 0.0 && y.is_finite());
            (sum, exact) = (sum + y, exact + probe.xyz[1]);
        }
        assert!(sum > 0.2 * exact && sum < 5.0 * exact, "{sum} {exact}");
    }
}
