//! Mode `orders`: its tables, its directional function, and its closed forms under lights with a size against the truth.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use diffraction_shaders::field::comparison_directions::under_lights;
use diffraction_shaders::field::orders::OrderSum;
use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::field::{coefficient_brute, transform::Bins};
use diffraction_shaders::input::load_surface as load;
use diffraction_shaders::light::{Cap, Light, Lights, Polygon};
use diffraction_shaders::optics::colour::{from_rgb, to_rgb};
use diffraction_shaders::optics::colour_difference::colour_difference;
use diffraction_shaders::optics::{Matter, diffuser_scale, direction};
use diffraction_shaders::plan::{Colour, Plan, Variant};
use diffraction_shaders::runner::{Exact, Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::tables::Table;
use diffraction_shaders::tables::orders::{EfficiencyAxes, efficiencies_table};
use diffraction_shaders::variant::Form;
use glam::DVec3;

const CD: &str =
    "{ kind = \"lamellar\", period_um = 1.6, height_um = 0.12, pixels = 100, duty = 0.69 }";
const BLAZED: &str = "{ kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 100 }";
const DVD: &str =
    "{ kind = \"lamellar\", period_um = 0.74, height_um = 0.12, pixels = 100, duty = 0.6 }";

fn plan(grating: &str, keys: &str) -> Result<Plan, String> {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "a"
grating = {grating}
[optics]
source_diameter_deg = 0.53
[[preset]]
name = "sun"
mode = "orders"
coherence = "ensemble"
{keys}
"#
    );
    Plan::parse(&text, Path::new("plan.toml")).map_err(|errors| format!("{errors:?}"))
}

fn grating(grating: &str) -> (HeightField, Variant) {
    let plan = plan(grating, "").unwrap();
    (load(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone())
}

/// A cell with crests in no direction of its own: 1.7 × 1.3 µm.
fn skewed() -> (HeightField, Variant) {
    let (columns, rows) = (40, 30);
    let height = |i: usize| {
        let (x, y) = ((i % columns) as f64 / 40.0, (i / columns) as f64 / 30.0);
        let wave = |r: f64, s: f64, phase: f64| (TAU * (r * x + s * y) + phase).cos();
        0.06 * wave(1.0, 1.0, 0.3) + 0.04 * wave(2.0, -1.0, 1.0) + 0.03 * wave(1.0, 0.0, 2.0)
    };
    let heights_um = (0..columns * rows).map(height).collect();
    let field = HeightField::new(columns, rows, 1.7 / 40.0, 1.3 / 30.0, heights_um).unwrap();
    (field, grating(BLAZED).1)
}

fn disc(axis: DVec3, radius_deg: f64) -> Light {
    Light::Disc { cap: Cap { axis, radius_rad: radius_deg.to_radians() }, irradiance: 1.0 }
}

fn polygon(corners: &[[f64; 2]]) -> Light {
    let corners: Vec<DVec3> = corners.iter().map(|c| direction(c[0], c[1])).collect();
    Light::Polygon { polygon: Polygon::new(&corners).unwrap(), radiance: 1.0 }
}

/// A rectangle about a direction, in degrees.
fn rectangle(theta_deg: f64, [width, height]: [f64; 2]) -> Light {
    let axis = direction(theta_deg, 30.0);
    let (across, up) = axis.any_orthonormal_pair();
    let [x, y] = [width, height].map(|deg| (0.5 * deg).to_radians().tan());
    let corners =
        [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| (axis + x * across + y * up).normalize());
    Light::Polygon { polygon: Polygon::new(&corners).unwrap(), radiance: 1.0 }
}

fn twin<'a>((height, variant): &'a (HeightField, Variant)) -> TwinRunner<'a> {
    TwinRunner::new(Placement { height, rotate_deg: 0.0, variant }, true).unwrap()
}

fn exact(subject: &(HeightField, Variant), light: &Light, views: &[DVec3]) -> Vec<[f64; 3]> {
    let (height, variant) = subject;
    Exact(Placement { height, rotate_deg: 0.0, variant }).under(light, views, &|_| ()).unwrap()
}

/// Two hundred viewers of strong orders of a light.
fn views((height, variant): &(HeightField, Variant), light: &Light) -> Vec<DVec3> {
    let lights = Lights { all: vec![light.clone()], notes: Vec::new() };
    let all = under_lights(height, &variant.optics, 0.0, &lights, 1);
    let step = all.len() / 200;
    all.into_iter().skip(1).step_by(step).take(200).map(rounded).collect()
}

/// Radiance under one direction of the same irradiance.
fn from_one_direction(
    (height, variant): &(HeightField, Variant),
    wi: DVec3,
    irradiance: f64,
    views: &[DVec3],
) -> Vec<[f64; 3]> {
    let optics = &variant.optics;
    let all: Vec<Directions> = views.iter().map(|wr| Directions { wi, wr: *wr }).collect();
    let range = Reference::VISIBLE_NM;
    let reference = Reference::new(height, 0.0, optics, range, all.iter().copied()).unwrap();
    let scale = diffuser_scale(optics).unwrap() / PI * irradiance;
    let colours = reference.tristimulus_all_with(&all, &|_| ());
    colours.into_iter().map(|xyz| xyz.map(|c| scale * c)).collect()
}

/// The table of docs/lights.md. A single direction of the same irradiance is the control: it must be far off.
#[test]
fn closed_forms_are_near_the_truth_and_one_direction_is_not() {
    let subjects = [
        ("cd", grating(CD)),
        ("blazed", grating(BLAZED)),
        ("dvd", grating(DVD)),
        ("skewed", skewed()),
    ];
    let axis = direction(20.0, 30.0);
    let lights = [
        ("sun 0.53°", disc(axis, 0.265), 0.3),
        ("disc, radius 5°", disc(axis, 5.0), 0.7),
        ("disc, radius 15°", disc(axis, 15.0), 2.5),
        ("rectangle 24 × 10°", rectangle(20.0, [24.0, 10.0]), 2.0),
        ("rectangle 50 × 30°", rectangle(30.0, [50.0, 30.0]), 2.0),
    ];
    for (name, subject) in &subjects {
        for (lit, light, allowed) in &lights {
            let views = views(subject, light);
            assert_eq!(views.len(), 200);
            let truth = exact(subject, light, &views);
            let got = twin(subject).under(light, &views, &|_| ()).unwrap();
            let found = colour_difference(name, &truth, &got, None).unwrap();
            let (single, irradiance) = match light {
                Light::Disc { cap, irradiance } => (cap.axis, *irradiance),
                Light::Polygon { polygon, .. } => {
                    // perpendicular to the middle, by the solid angle of a small rectangle
                    let corners = polygon.corners();
                    let sides = [
                        corners[0].angle_between(corners[1]),
                        corners[1].angle_between(corners[2]),
                    ];
                    (polygon.bounds().axis, sides[0] * sides[1])
                }
                _ => unreachable!(),
            };
            let other = from_one_direction(subject, single, irradiance, &views);
            let other = colour_difference(name, &truth, &other, None).unwrap();
            println!(
                "{name:7} {lit:19} p95 {:.2} max {:.2} lit {:.2}; one direction {:.0}",
                found.de2000.p95, found.de2000.max, found.lit, other.de2000.p95
            );
            assert!(found.lit > 0.2, "{name} {lit}: {}", found.lit);
            assert!(found.de2000.p95 <= *allowed, "{name} {lit}: {}", found.de2000.p95);
            assert!(other.de2000.p95 > 10.0, "{name} {lit}: one direction {}", other.de2000.p95);
        }
    }
}

/// Lamps of saturated colours, as near the truth as white ones. The control is the white lamp times the colour.
#[test]
fn coloured_lamps_are_as_near_the_truth_as_white_ones() {
    let subjects = [("cd", grating(CD)), ("dvd", grating(DVD)), ("skewed", skewed())];
    let axis = direction(20.0, 30.0);
    let lights = [
        ("sun 0.53°", disc(axis, 0.265)),
        ("disc, radius 5°", disc(axis, 5.0)),
        ("disc, radius 15°", disc(axis, 15.0)),
        ("rectangle 24 × 10°", rectangle(20.0, [24.0, 10.0])),
    ];
    let colours = [
        ("white", DVec3::ONE),
        ("red", DVec3::new(1.0, 0.05, 0.0)),
        ("green", DVec3::new(0.0, 1.0, 0.1)),
        ("blue", DVec3::Z),
    ];
    let mut most = 0.0_f64;
    for (name, subject) in &subjects {
        for (lit, light) in &lights {
            let views = views(subject, light);
            let runner = twin(subject);
            let white = runner.under(light, &views, &|_| ()).unwrap();
            for (word, colour) in colours {
                let lamp = light.clone().coloured(colour);
                let truth = exact(subject, &lamp, &views);
                let got = runner.under(&lamp, &views, &|_| ()).unwrap();
                let filtered = |xyz: &[f64; 3]| {
                    let seen = colour * DVec3::from(to_rgb(*xyz, Colour::Srgb));
                    from_rgb(seen.to_array(), Colour::Srgb)
                };
                let wrong: Vec<[f64; 3]> = white.iter().map(filtered).collect();
                let found = colour_difference(name, &truth, &got, None).unwrap();
                let wrong = colour_difference(name, &truth, &wrong, None).unwrap();
                println!(
                    "{name:7} {lit:19} {word:6} p95 {:.2} max {:.2} lit {:.2}; times the colour p50 {:.1} p95 {:.1}",
                    found.de2000.p95,
                    found.de2000.max,
                    found.lit,
                    wrong.de2000.p50,
                    wrong.de2000.p95
                );
                assert!(found.lit > 0.1, "{name} {lit} {word}: {}", found.lit);
                assert!(found.de2000.p95 <= 0.5, "{name} {lit} {word}: {}", found.de2000.p95);
                if colour != DVec3::ONE {
                    assert!(wrong.de2000.p95 > 2.0, "{name} {lit} {word}: {wrong:?}");
                    most = most.max(wrong.de2000.p95);
                }
            }
        }
    }
    assert!(most > 15.0, "times the colour: {most}");
}

/// Grey light is white light, coloured light is the sum of its primaries, and a mirror shows the colour.
#[test]
fn colours_of_lamps_add_up() {
    let subject = grating(BLAZED);
    let runner = twin(&subject);
    for light in [disc(direction(20.0, 30.0), 5.0), rectangle(20.0, [24.0, 10.0])] {
        let views = views(&subject, &light);
        let under =
            |colour: DVec3| runner.under(&light.clone().coloured(colour), &views, &|_| ()).unwrap();
        let white = under(DVec3::ONE);
        let largest = white.iter().flatten().copied().fold(0.0, f64::max);
        let apart = |found: &[[f64; 3]], expected: &[[f64; 3]]| {
            let pairs = found.iter().flatten().zip(expected.iter().flatten());
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
        };
        let twice: Vec<[f64; 3]> = white.iter().map(|xyz| xyz.map(|c| 2.0 * c)).collect();
        assert!(apart(&under(DVec3::splat(2.0)), &twice) < 1e-12);
        let nearly = under(DVec3::new(1.0, 1.0 + 1e-9, 1.0));
        assert!(apart(&nearly, &white) < 1e-6, "{}", apart(&nearly, &white));
        let primaries = DVec3::AXES.map(under);
        let sum: Vec<[f64; 3]> = (0..white.len())
            .map(|i| [0, 1, 2].map(|c| primaries.iter().map(|of| of[i][c]).sum()))
            .collect();
        assert!(apart(&sum, &white) < 1e-3, "{}", apart(&sum, &white));
        assert!(apart(&primaries[0], &white) > 0.3);
        let dim = primaries.iter().flatten().flatten().copied().fold(0.0, f64::min);
        assert!(dim > -1e-6 * largest, "{dim} of {largest}");
    }
    // a flat surface shows the disc in its mirror
    let flat = HeightField::new(4, 1, 0.25, 0.25, vec![0.0; 4]).unwrap();
    let mirror = (flat, subject.1.clone());
    let colour = DVec3::new(0.9, 0.1, 0.4);
    let wr = direction(20.0, 210.0);
    let of = |light: Light| {
        let seen = twin(&mirror).under(&light, &[wr], &|_| ()).unwrap()[0];
        DVec3::from(to_rgb(seen, Colour::Srgb))
    };
    let light = disc(direction(20.0, 30.0), 5.0);
    let seen = of(light.clone().coloured(colour)) / of(light).element_sum() * 3.0;
    assert!((seen - colour).abs().max_element() < 2e-3, "{seen} {colour}");
}

/// Lamps on and across the horizon, viewers within the mirror image of a lamp, tiny and huge radii, corners below the horizon
/// and at the normal.
#[test]
fn lights_in_awkward_places_are_right_and_finite() {
    let lights = [
        disc(direction(90.0, 10.0), 5.0),
        disc(direction(88.0, 10.0), 0.265),
        disc(direction(93.0, 200.0), 10.0),
        disc(direction(120.0, 200.0), 89.0),
        disc(direction(30.0, 40.0), 0.05),
        disc(direction(30.0, 40.0), 89.0),
        disc(DVec3::Z, 89.9),
        polygon(&[[70.0, -9.0], [100.0, -9.0], [100.0, 40.0], [70.0, 40.0]]),
        polygon(&[[0.0, 0.0], [30.0, 3.0], [30.0, 44.0]]),
        polygon(&[[95.0, 3.0], [120.0, 3.0], [120.0, 44.0]]),
        // eight corners: three quadrilaterals
        polygon(&[
            [20.0, 0.0],
            [20.0, 45.0],
            [20.0, 90.0],
            [20.0, 135.0],
            [20.0, 180.0],
            [20.0, 225.0],
            [20.0, 270.0],
            [20.0, 315.0],
        ]),
    ];
    for subject in [grating(BLAZED), skewed()] {
        for light in &lights {
            let mut views: Vec<DVec3> = [
                [1.0, 77.0],
                [30.0, 220.0],
                [30.0, 221.0],
                [88.0, 190.0],
                [89.99, 20.0],
                [60.0, 20.0],
            ]
            .map(|[theta, phi]| rounded(direction(theta, phi)))
            .to_vec();
            views.extend([direction(90.0, 0.0), direction(120.0, 0.0)]);
            let truth = exact(&subject, light, &views);
            let got = twin(&subject).under(light, &views, &|_| ()).unwrap();
            let largest = truth.iter().flatten().copied().fold(0.0, f64::max);
            for ((wr, truth), got) in views.iter().zip(&truth).zip(&got) {
                let own = truth.iter().copied().fold(0.0, f64::max);
                for (a, b) in truth.iter().zip(got) {
                    let allowed = 2e-2 * own + 1e-4 * largest;
                    assert!((a - b).abs() <= allowed, "{light:?} {wr}: {truth:?} {got:?}");
                }
                assert!(wr.z > 1e-6 || got == &[0.0; 3], "{wr} {got:?}");
            }
        }
        let below = twin(&subject).under(&lights[9], &[DVec3::Z], &|_| ()).unwrap();
        assert_eq!(below, [[0.0; 3]], "all of the light is below the horizon");
    }
}

/// Corners in either order, and neighbours that are the same, give the same radiance.
#[test]
fn the_order_of_corners_does_not_matter() {
    let subject = grating(CD);
    let runner = twin(&subject);
    let [a, b, c, d] = [[10.0, 0.0], [34.0, 0.0], [34.0, 18.0], [10.0, 60.0]]
        .map(|[theta, phi]| direction(theta, phi));
    let of = |corners: &[DVec3]| {
        let polygon = Polygon::new(corners).unwrap();
        let light = Light::Polygon { polygon, radiance: 1.0 };
        let views: Vec<DVec3> = (0..40).map(|i| direction(2.0 * f64::from(i), 190.0)).collect();
        runner.under(&light, &views, &|_| ()).unwrap()
    };
    let right = of(&[a, b, c, d]);
    assert!(right.iter().any(|xyz| xyz[1] > 1e-3));
    let near = |other: Vec<[f64; 3]>| {
        let pairs = right.iter().flatten().zip(other.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    assert!(near(of(&[d, c, b, a])) < 1e-7);
    // two triangles are the quadrilateral
    let (one, two) = (of(&[a, b, c]), of(&[a, c, d]));
    let sum = one.iter().zip(&two).map(|(a, b)| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]).collect();
    let largest = right.iter().flatten().copied().fold(0.0, f64::max);
    let apart = near(sum);
    assert!(apart < 5e-3 * largest, "{apart} of {largest}");
    assert!(near(of(&[a, b, c])) > 1e-3, "a triangle is not the quadrilateral");
}

#[test]
fn the_table_of_efficiencies_is_the_transform() {
    let (height, _) = skewed();
    let axes = EfficiencyAxes::new(&height, [380.0, 780.0], &Matter::default(), [1.0; 2]);
    let table: Table = efficiencies_table(&height, &axes);
    let Bins { r_max, s_max } = axes.bins;
    let (mut worst, mut linear): (f64, f64) = (0.0, 0.0);
    for order in [[0, 0], [1, 1], [-2, 1], [3, -2]] {
        for i in 0..60 {
            let place = (f64::from(i) + 0.37) / 60.0 * f64::from(axes.columns);
            let column = place.floor();
            let row = (order[1] + s_max as i64) * (2 * r_max as i64 + 1) + order[0] + r_max as i64;
            let [f, df, g, dg] = table.load(column as i64, row, 0);
            let t = place - column;
            let cubic = f * (1.0 + 2.0 * t) * (1.0 - t).powi(2)
                + df * t * (1.0 - t).powi(2)
                + g * t * t * (3.0 - 2.0 * t)
                + dg * t * t * (t - 1.0);
            let z = -2.0 * TAU / 0.38 * place / f64::from(axes.columns);
            let truth = coefficient_brute(&height, order[0], order[1], z).norm_sqr();
            worst = worst.max((cubic - truth).abs());
            linear = linear.max((f + t * (g - f) - truth).abs());
        }
    }
    assert!(worst < 1e-4, "{worst}");
    assert!(linear > 1e-3, "without slopes: {linear}");
}

/// Under one direction it is the sum over lobes of `adaptive`, whose terms the efficiencies replace.
#[test]
fn one_direction_is_as_in_adaptive() {
    let keys =
        "[[preset]]\nname = \"lobes\"\nmode = \"adaptive\"\ncoherence = \"ensemble\"\nterms = 25\n";
    let plan = plan(BLAZED, keys).unwrap();
    let height = load(&plan.surfaces[0]).unwrap().field;
    let of = |name: &str| {
        let variant = plan.variant(Some(name)).unwrap();
        let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
        let runner = TwinRunner::new(placement, true).unwrap();
        let wi = direction(20.0, 10.0);
        let all: Vec<Directions> = (0..600)
            .map(|i| Directions { wi, wr: direction(0.14 * f64::from(i), 190.0) })
            .collect();
        runner.tristimulus(&all).unwrap()
    };
    let (orders, lobes) = (of("sun"), of("lobes"));
    let largest = lobes.iter().flatten().copied().fold(0.0, f64::max);
    let pairs = orders.iter().flatten().zip(lobes.iter().flatten());
    let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
    assert!(largest > 1e-3 && apart < 2e-4, "{apart} of {largest}");
}

#[test]
fn what_has_too_many_orders_or_no_light_with_a_size_is_refused() {
    let large = "{ kind = \"fingers\", size_um = 12.1, pixels = 200, pitch_um = 1.1, height_um = 0.3, seed = 1 }";
    let plan = plan(large, "").unwrap();
    let height = load(&plan.surfaces[0]).unwrap().field;
    let error = Form::new(&plan.variants[0], &height).unwrap_err().to_string();
    assert!(error.contains("orders of the cell") && error.contains("above 1024"), "{error}");
    let refused = |keys: &str| self::plan(CD, keys).unwrap_err();
    let fixed = "coherence_um = 65\ncoherence_scaling = \"fixed\"";
    let error = refused(fixed);
    assert!(error.contains("lights with a size have no meaning"), "{error}");
    // with single directions alone it has a meaning
    self::plan(CD, &format!("{fixed}\nlights = [\"direction\"]")).unwrap();
    let error = refused("wavelengths = { min_nm = 550, max_nm = 550 }");
    assert!(error.contains("a range of wavelengths"), "{error}");
    let error = refused("lights = [\"direction\", \"discs\"]");
    assert!(error.contains("did you mean \"disc\""), "{error}");
}

/// A variant without the function of a light says what has it.
#[test]
fn a_missing_function_is_named() {
    let plan = plan(CD, "lights = [\"direction\"]").unwrap();
    let subject = (load(&plan.surfaces[0]).unwrap().field, plan.variants[0].clone());
    let error = twin(&subject).under(&disc(DVec3::Z, 5.0), &[DVec3::Z], &|_| ()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("no function for a light of kind \"disc\""), "{text}");
    assert!(text.contains("mode = \"orders\""), "{text}");
    let sky = Light::Sky { radiance: 1.0 };
    let text = twin(&subject).under(&sky, &[DVec3::Z], &|_| ()).unwrap_err().to_string();
    assert!(text.contains("\"environment\" in its lights"), "{text}");
}

/// A test of the truth at hand: closed forms use nothing of it.
#[test]
fn energy_of_a_hemisphere_of_quadrilaterals_is_the_white_sky() {
    let subject = grating(CD);
    let (height, variant) = &subject;
    let sky = OrderSum::new(height, 0.0, &variant.optics).unwrap();
    let runner = twin(&subject);
    // four corners at the horizon would be a hemisphere's edge; triangles from the normal are quarters of it
    let quarter = |phi: f64| polygon(&[[0.0, 0.0], [90.0, phi], [90.0, phi + 90.0]]);
    let wr = direction(30.0, 0.0);
    // no edge lies in the plane of the orders
    let mut sum = [0.0; 3];
    for phi in [17.0, 107.0, 197.0, 287.0] {
        let part = runner.under(&quarter(phi), &[wr], &|_| ()).unwrap()[0];
        sum = std::array::from_fn(|c| sum[c] + part[c]);
    }
    let white = sky.white_sky()[1];
    for (sum_of, white_of) in sum.iter().zip(white) {
        assert!((sum_of / white_of - 1.0).abs() < 5e-3, "{sum:?} {white:?}");
    }
}
