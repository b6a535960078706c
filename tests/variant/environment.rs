//! Mode `orders` under surroundings: its quadrature against the exact colours, and what is used without it.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use diffraction_shaders::field::orders::OrderSum;
use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::input::load_surface;
use diffraction_shaders::light::environment::filtered::ROWS;
use diffraction_shaders::light::{Environment, Filtered, Light, Panorama, Sky, Surroundings};
use diffraction_shaders::optics::colour::{from_rgb, to_rgb};
use diffraction_shaders::optics::colour_difference::colour_difference;
use diffraction_shaders::optics::{diffuser_scale, direction};
use diffraction_shaders::plan::{Colour, Plan, Variant};
use diffraction_shaders::random::SplitMix64;
use diffraction_shaders::runner::{Exact, Placement, Runner, rounded};
use diffraction_shaders::shader::specialise;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::Table;
use diffraction_shaders::variant::{
    Arguments, Around, ENVIRONMENT, Form, Function, Twin, environment_error, light_tolerance,
    nodes_for, skies,
};
use glam::{DVec2, DVec3};

const CD: &str =
    "{ kind = \"lamellar\", period_um = 1.6, height_um = 0.12, pixels = 100, duty = 0.69 }";
const BLAZED: &str = "{ kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 100 }";
const DVD: &str =
    "{ kind = \"lamellar\", period_um = 0.74, height_um = 0.12, pixels = 100, duty = 0.57 }";

fn subject(grating: &str, keys: &str) -> (HeightField, Variant) {
    let text = format!(
        "schema = 1\n[[surface]]\nname = \"a\"\ngrating = {grating}\n[optics]\nsource_diameter_deg = 0.53\n[[preset]]\nname = \"sun\"\nmode = \"orders\"\ncoherence = \"ensemble\"\n{keys}\n"
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap();
    (load_surface(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone())
}

/// What a variant gives among surroundings, in f64 from its rounded tables.
struct Shader {
    form: Form,
    tables: Vec<Table>,
    rotate_deg: f64,
}

impl Shader {
    fn new((height, variant): &(HeightField, Variant), rotate_deg: f64) -> Shader {
        let form = Form::new(variant, height).unwrap();
        let tables = specialise::tables(&form, height, rotate_deg).unwrap();
        Shader { form, tables: tables.into_iter().map(Table::rounded).collect(), rotate_deg }
    }

    fn among(&self, filtered: &Filtered, views: &[DVec3]) -> Vec<[f64; 3]> {
        let twin = Twin::new(&self.form, &self.tables, self.rotate_deg);
        let twin = Twin { surroundings: Some(filtered), ..twin };
        let call = |wr: &DVec3| Arguments::Environment { around: Around::Host, wr: *wr };
        views.iter().map(|wr| twin.evaluate(call(wr)).unwrap()).collect()
    }
}

fn environment(radiance: &(dyn Fn(DVec3) -> DVec3 + Sync)) -> Environment {
    let panorama = Arc::new(Panorama::drawn(ROWS, radiance));
    Environment { panorama, scale: 1.0, rotate_deg: 0.0 }
}

fn softbox(d: DVec3, axis: DVec3, [x, y]: [f64; 2]) -> bool {
    let (across, up) = axis.any_orthonormal_pair();
    let z = d.dot(axis);
    z > 0.0 && d.dot(across).abs() < x * z && d.dot(up).abs() < y * z
}

/// Softboxes in a dark studio; windows in a warm room; a clouded sky over a meadow; lanterns at night. None was looked at when
/// the quadrature was made.
fn surroundings() -> [(&'static str, Environment); 4] {
    let mut random = SplitMix64::new(77);
    let mut axes = |count: usize| -> Vec<DVec3> {
        (0..count).map(|_| direction(85.0 * random.share(), 360.0 * random.share())).collect()
    };
    let (boxes, windows, lanterns, waves) = (axes(4), axes(3), axes(30), axes(6));
    let studio = environment(&|d| {
        let lit = boxes.iter().enumerate().filter(|(i, axis)| {
            softbox(d, **axis, [0.12 + 0.1 * *i as f64, 0.4 - 0.08 * *i as f64])
        });
        DVec3::splat(0.03) + lit.map(|(i, _)| DVec3::new(5.0, 4.8, 4.4 + i as f64)).sum::<DVec3>()
    });
    let room = environment(&|d| {
        let wall = 0.1 * (1.0 + 0.5 * d.z) * DVec3::new(1.0, 0.9, 0.75);
        let lit = windows.iter().any(|axis| softbox(d, *axis, [0.25, 0.35]));
        if lit { DVec3::new(4.0, 4.5, 5.0) } else { wall }
    });
    let meadow = environment(&|d| {
        let clouds: f64 = waves
            .iter()
            .zip([3.0, 5.0, 8.0, 13.0, 21.0, 34.0])
            .map(|(axis, pace)| (pace * d.dot(*axis) + pace).sin() / pace)
            .sum();
        let sky = DVec3::new(0.3, 0.5, 1.0) * (1.0 - 0.6 * d.z) + (4.0 * clouds).clamp(0.0, 1.0);
        if d.z > 0.0 { sky } else { DVec3::new(0.1, 0.12, 0.06) }
    });
    let night = environment(&|d| {
        let lit = lanterns.iter().enumerate().map(|(i, axis)| {
            let colour = DVec3::new(3.0, 1.0 + 0.05 * i as f64, 0.1 * i as f64);
            (-0.5 * d.distance_squared(*axis) / 2e-3).exp() * colour
        });
        DVec3::splat(0.02) + lit.sum::<DVec3>()
    });
    [("studio", studio), ("room", room), ("meadow", meadow), ("night", night)]
}

fn views(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = SplitMix64::new(seed);
    let view = |_| {
        let sine = random.share().sqrt().min(80_f64.to_radians().sin());
        let plane = sine * DVec2::from_angle(2.0 * PI * random.share());
        rounded(plane.extend((1.0 - sine * sine).sqrt()))
    };
    (0..count).map(view).collect()
}

fn exact(
    (height, variant): &(HeightField, Variant),
    rotate_deg: f64,
    light: &Light,
    views: &[DVec3],
) -> Vec<[f64; 3]> {
    Exact(Placement { height, rotate_deg, variant }).under(light, views, &|_| ()).unwrap()
}

/// The light of the map as that of its four strongest directions: each has the light of all that is nearer to it than to the others.
fn strongest(
    (height, variant): &(HeightField, Variant),
    around: &Environment,
    views: &[DVec3],
) -> Vec<[f64; 3]> {
    let rows = 64;
    let cells: Vec<(DVec3, f64)> = (0..2 * rows * rows)
        .map(|i| {
            let theta = (i / (2 * rows)) as f64 + 0.5;
            let d = direction(
                180.0 * theta / rows as f64,
                180.0 * ((i % (2 * rows)) as f64 + 0.5) / rows as f64,
            );
            let angle = (PI / rows as f64).powi(2) * d.truncate().length();
            (d, angle * to_luminance(around.radiance(d)))
        })
        .filter(|(d, _)| d.z > 0.0)
        .collect();
    let near = |d: DVec3| {
        cells.iter().filter(|(other, _)| other.dot(d) > 0.9).map(|(_, e)| e).sum::<f64>()
    };
    let mut chosen: Vec<DVec3> = Vec::new();
    for _ in 0..4 {
        let free = cells.iter().filter(|(d, _)| chosen.iter().all(|c| c.dot(*d) < 0.8));
        let best = free.map(|(d, _)| *d).max_by(|a, b| near(*a).total_cmp(&near(*b)));
        chosen.extend(best);
    }
    let mut sum = vec![DVec3::ZERO; views.len()];
    for (i, wi) in chosen.iter().enumerate() {
        let nearest = |d: DVec3| {
            (0..chosen.len()).max_by(|a, b| chosen[*a].dot(d).total_cmp(&chosen[*b].dot(d)))
        };
        let irradiance: f64 =
            cells.iter().filter(|(d, _)| nearest(*d) == Some(i)).map(|(_, e)| e).sum();
        let all: Vec<Directions> = views.iter().map(|wr| Directions { wi: *wi, wr: *wr }).collect();
        let range = Reference::VISIBLE_NM;
        let reference =
            Reference::new(height, 0.0, &variant.optics, range, all.iter().copied()).unwrap();
        let scale = diffuser_scale(&variant.optics).unwrap() / PI * irradiance;
        for (sum, xyz) in sum.iter_mut().zip(reference.tristimulus_all_with(&all, &|_| ())) {
            *sum += scale * DVec3::from(xyz);
        }
    }
    sum.into_iter().map(|xyz| xyz.to_array()).collect()
}

fn to_luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// The table of docs/lights.md. The controls, the four strongest directions of the map and the product of white sky and mirror
/// image, must be far off.
#[test]
fn streaks_are_near_the_truth_and_shortcuts_are_not() {
    let views = views(150, 5);
    let maps = surroundings().map(|(name, around)| {
        let filtered = Filtered::blurred(&|d| around.radiance(d), 1);
        (name, around, filtered)
    });
    let (mut worst, mut shortcut) = ([0.0_f64; 3], f64::INFINITY);
    for (name, grating) in [("cd", CD), ("blazed", BLAZED), ("dvd", DVD)] {
        let own = subject(grating, "");
        let shaders = [8, 16, 32]
            .map(|nodes| Shader::new(&subject(grating, &format!("nodes = {nodes}")), 0.0));
        let looks =
            shaders.each_ref().map(|shader| ENVIRONMENT.cost(&shader.form).evaluations_mean);
        let white = exact(&own, 0.0, &Light::Sky { radiance: 1.0 }, &views);
        for (around, environment, filtered) in &maps {
            let truth = exact(&own, 0.0, &Light::Environment(environment.clone()), &views);
            let p95 = |colours: &[[f64; 3]]| {
                colour_difference("views", &truth, colours, None).unwrap().de2000.p95
            };
            let found = shaders.each_ref().map(|shader| p95(&shader.among(filtered, &views)));
            let split: Vec<[f64; 3]> = views
                .iter()
                .zip(&white)
                .map(|(wr, white)| {
                    let image = environment.radiance(DVec3::new(-wr.x, -wr.y, wr.z));
                    let rgb = DVec3::from(to_rgb(*white, Colour::Srgb)) * image;
                    from_rgb(rgb.to_array(), Colour::Srgb)
                })
                .collect();
            let (split, four) = (p95(&split), p95(&strongest(&own, environment, &views)));
            println!(
                "{name} {around}: 8/16/32 {found:.2?} look-ups {looks:.0?}, split sum {split:.1}, four directions {four:.1}"
            );
            worst = std::array::from_fn(|i| worst[i].max(found[i]));
            assert!(split > found[0] && four > 15.0, "{name} {around}: {split} {four}");
            shortcut = shortcut.min(split.max(4.0 * found[0]));
        }
    }
    println!("worst {worst:.2?}");
    assert!(shortcut > 6.0, "{shortcut}");
    for (nodes, worst) in [8, 16, 32].into_iter().zip(worst) {
        assert!(worst <= environment_error(nodes), "{nodes}: {worst}");
    }
}

/// A turned surface under a map without symmetry: the map stays where it is. Turned the other way it must be wrong.
#[test]
fn a_turned_surface_keeps_its_surroundings() {
    let (_, around) = &surroundings()[0];
    let filtered = Filtered::blurred(&|d| around.radiance(d), 1);
    let views = views(100, 9);
    let own = subject(CD, "nodes = 32");
    let truth = exact(&own, 25.0, &Light::Environment(around.clone()), &views);
    let p95 = |rotate_deg: f64| {
        let colours = Shader::new(&own, rotate_deg).among(&filtered, &views);
        colour_difference("views", &truth, &colours, None).unwrap().de2000.p95
    };
    let (right, wrong) = (p95(25.0), p95(-25.0));
    assert!(right < environment_error(32) && wrong > 10.0, "{right} {wrong}");
}

/// A white sky gives the sum of all shares, a map's colour comes back from a flat mirror.
#[test]
fn skies_come_back() {
    let own = subject(BLAZED, "nodes = 32");
    let orders = OrderSum::new(&own.0, 0.0, &own.1.optics).unwrap();
    let shader = Shader::new(&own, 0.0);
    let views = views(40, 3);
    for sky in skies() {
        let twin = Twin::new(&shader.form, &shader.tables, 0.0);
        for wr in &views {
            let call = Arguments::Environment { around: Around::Sky(sky), wr: *wr };
            let (found, truth) = (twin.evaluate(call).unwrap(), orders.radiance(&sky, *wr));
            let apart = (0..3).map(|c| (found[c] - truth[c]).abs()).fold(0.0, f64::max);
            let most = truth.into_iter().fold(0.0, f64::max);
            assert!(
                apart < 0.02 * most + 1e-4 * sky.brightest(),
                "{sky:?} {wr}: {found:?} {truth:?}"
            );
        }
    }
    let flat = subject("{ kind = \"flat\", period_um = 1.0, pixels = 16 }", "");
    let shader = Shader::new(&flat, 0.0);
    let twin = Twin::new(&shader.form, &shader.tables, 0.0);
    for colour in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.2, 3.0, 0.1)] {
        let around = Around::Sky(Sky::everywhere(colour));
        let xyz = twin.evaluate(Arguments::Environment { around, wr: DVec3::Z }).unwrap();
        let rgb = DVec3::from(to_rgb(xyz, Colour::Srgb)) / 0.04;
        assert!((rgb - colour).abs().max_element() < 2e-3 * colour.max_element(), "{rgb} {colour}");
    }
}

/// The probes notice a host that does not blur.
#[test]
fn probes_see_the_spread() {
    struct Sharp(Sky);
    impl Surroundings for Sharp {
        fn seen(&self, direction: DVec3, _: f64) -> DVec3 {
            self.0.seen(direction, 0.0)
        }
    }
    for grating in [CD, BLAZED, DVD] {
        let own = subject(grating, "");
        let shader = Shader::new(&own, 0.0);
        let twin = Twin::new(&shader.form, &shader.tables, 0.0);
        let mut worst = 0.0_f64;
        for probe in ENVIRONMENT.probes(&own.0, 0.0, &own.1.optics).unwrap() {
            let Arguments::Environment { around: Around::Sky(sky), wr } = probe.arguments else {
                panic!("{probe:?}")
            };
            let right = twin.evaluate(probe.arguments).unwrap();
            let sharp = Twin { surroundings: Some(&Sharp(sky)), ..twin };
            let call = Arguments::Environment { around: Around::Host, wr };
            let wrong = sharp.evaluate(call).unwrap();
            let allowed = light_tolerance(&shader.form, &probe.arguments, &right);
            let apart = (0..3).map(|c| (right[c] - wrong[c]).abs()).fold(0.0, f64::max);
            worst = worst.max(apart / allowed);
        }
        println!("without blur: {worst:.2} tolerances");
        assert!(worst > 1.5, "{worst}");
    }
}

#[test]
fn nodes_keep_the_error_that_is_asked_for() {
    for error in [0.5, 1.0, 2.5, 6.0, 20.0] {
        let nodes = nodes_for(error);
        assert!(environment_error(nodes) <= error, "{error}");
        assert!(nodes == 2 || environment_error(nodes - 1) > error, "{error}");
    }
    let (_, variant) = subject(CD, "nodes = \"auto\"\nenvironment_error = 1.0");
    let (height, _) = subject(CD, "");
    let Form::Orders(form) = Form::new(&variant, &height).unwrap() else { panic!("orders") };
    assert_eq!(form.nodes, nodes_for(1.0));
    // too many look-ups are refused with their number
    let wide = "{ kind = \"crossed\", x = { kind = \"sinusoidal\", period_um = 2.5, height_um = 0.2, pixels = 64 }, y = { kind = \"sinusoidal\", period_um = 2.5, height_um = 0.2, pixels = 64 } }";
    let (height, variant) = subject(wide, "nodes = 64");
    let refused = Form::new(&variant, &height).unwrap_err().to_string();
    assert!(refused.contains("look-ups under surroundings"), "{refused}");
}
