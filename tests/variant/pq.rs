//! Replicas of the patch without a window: against the direct sum, against the full sum, and the misprinted product.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use diffraction_shaders::field::coefficient_brute;
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::field::replicas;
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Grating, Plan, Variant};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner};
use diffraction_shaders::shader::specialise;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::tables::Table;
use diffraction_shaders::variant::Twin;
use diffraction_shaders::variant::{Form, Pq, replica_tail};
use glam::{DVec2, DVec3};
use rustfft::num_complex::Complex64;

fn variant(keys: &str) -> Variant {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "a"
grating = {{ kind = "flat", period_um = 2.5, pixels = 100 }}
[variants]
terms = "auto"
term_error = 1e-12
{keys}
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap_or_else(|e| panic!("{keys}: {e}"));
    plan.variants[0].clone()
}

fn rough(columns: usize, rows: usize) -> HeightField {
    let heights_um = (0..columns * rows).map(|i| 0.003 * ((i * 7919) % 101) as f64).collect();
    HeightField::new(columns, rows, 0.06, 0.07, heights_um).unwrap()
}

fn blazed() -> HeightField {
    let grating = Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 100 };
    synthesise(&grating, "blazed").unwrap().field
}

/// `|P|²` of the twin at a frequency, cycles per µm, and `z`, 1/µm.
fn response(twin: &Twin<'_>, f: DVec2, z: f64) -> f64 {
    let lambda_um = 0.5;
    let path = DVec3::new(f.x * lambda_um, f.y * lambda_um, z * lambda_um / TAU);
    twin.response(path, lambda_um).unwrap()
}

fn prepared(variant: &Variant, height: &HeightField) -> (Form, Vec<Table>) {
    let form = Form::new(variant, height).unwrap();
    let tables = specialise::tables(&form, height, 0.0).unwrap();
    (form, tables)
}

fn pq_of(form: &Form) -> &Pq {
    let Form::Pq(pq) = form else { panic!("{form:?} is not pq") };
    pq
}

const FREQUENCIES: [DVec2; 6] = [
    DVec2::new(0.31, -0.77),
    DVec2::new(1.6, 1.41),
    DVec2::new(-2.3, 0.4),
    DVec2::ZERO,
    DVec2::new(1.0 / 0.72, 2.0 / 0.63),
    DVec2::new(3.0, -3.3),
];

#[test]
fn all_bins_of_odd_and_even_patches_give_the_direct_sum() {
    for (columns, rows) in [(9, 7), (12, 9), (8, 6), (5, 4)] {
        let height = rough(columns, rows);
        for periods in ["[1, 1]", "[3, 2]", "[4, 7]"] {
            let variant =
                variant(&format!("mode = \"pq\"\nwindow_radius = 6\nperiods = {periods}"));
            let (form, tables) = prepared(&variant, &height);
            assert_eq!(pq_of(&form).taps, [columns as u32, rows as u32]);
            let twin = Twin::new(&form, &tables, 0.0);
            for f in FREQUENCIES {
                for z in [-14.0, -22.0, -3.0] {
                    let direct =
                        replicas::amplitude(&height, f, z, pq_of(&form).periods).norm_sqr();
                    let got = response(&twin, f, z);
                    assert!((got - direct).abs() < 1e-9, "{columns}×{rows} {f}: {got}, {direct}");
                }
            }
        }
    }
}

#[test]
fn fewer_bins_err_less_than_is_stated() {
    let height = rough(41, 37);
    for radius in [0, 1, 2, 4, 8] {
        let variant =
            variant(&format!("mode = \"pq\"\nwindow_radius = {radius}\nperiods = [1, 1]"));
        let (form, tables) = prepared(&variant, &height);
        let twin = Twin::new(&form, &tables, 0.0);
        let (mut errors, mut squares) = (0.0, 0.0);
        for i in 0..400 {
            let f = DVec2::new(0.0117 * f64::from(i) - 2.1, 0.0071 * f64::from(i) - 1.3);
            let direct = replicas::amplitude(&height, f, -20.0, [1, 1]).norm();
            errors += (response(&twin, f, -20.0).sqrt() - direct).powi(2);
            squares += direct.powi(2);
        }
        let tail = replica_tail([1, 1], pq_of(&form).taps, pq_of(&form).pixels);
        let share = errors / squares;
        println!("radius {radius}: {share:.1e} of the light, {tail:.1e} stated");
        assert!(share < tail, "radius {radius}: {share} of {tail}");
    }
    // all bins: nothing is left out
    assert!(replica_tail([1, 1], [41, 37], [41, 37]).abs() < 1e-9);
}

#[test]
fn order_peaks_are_those_of_the_full_sum_and_of_the_closed_form() {
    let height = blazed();
    let (pq, full) = (variant("mode = \"pq\""), variant("mode = \"full\"\nwindow_radius = 2"));
    let (form, tables) = prepared(&pq, &height);
    let (full_form, full_tables) = prepared(&full, &height);
    assert_eq!(pq_of(&form).periods, [26, 650], "the coherence length over 2.5 µm and 0.1 µm");
    let twin = Twin::new(&form, &tables, 0.0);
    let full = Twin::new(&full_form, &full_tables, 0.0);
    for m in -5..=5 {
        for z in [-9.1, -16.0, -22.2] {
            let f = DVec2::new(f64::from(m) / 2.5, 0.0);
            let (got, windowed) = (response(&twin, f, z), response(&full, f, z));
            let t = z * 0.3 / TAU + f64::from(m);
            let closed = if t == 0.0 { 1.0 } else { ((PI * t).sin() / (PI * t)).powi(2) };
            assert!((got - windowed).abs() < 1e-3, "order {m}: {got} against {windowed}");
            // 100 pixels a period
            assert!((got - closed).abs() < 1e-2, "order {m}: {got} against {closed}");
        }
    }
}

/// An isolated lobe's area: `1/(QL)` against the Gaussian's `√π σf`; and so the colours, but for the side lobes that
/// replicas have and a Gaussian has not.
#[test]
fn colours_are_in_the_ratio_of_the_line_areas() {
    let height = blazed();
    let keys = "wavelengths = { step_nm = 0.25 }";
    let pq = variant(&format!("mode = \"pq\"\nwindow_radius = 2\n{keys}"));
    let full = variant(&format!("mode = \"full\"\n{keys}"));
    let ratio = 1.0 / (26.0 * 2.5) / (PI.sqrt() / (TAU * 65.0 / 4.0));
    let area = |variant: &Variant, m: f64| {
        let (form, tables) = prepared(variant, &height);
        let twin = Twin::new(&form, &tables, 0.0);
        let at = |i: i32| DVec2::new((m + (f64::from(i) + 0.5) / 400.0) / 2.5, 0.0);
        (-200..200).map(|i| response(&twin, at(i), -20.9)).sum::<f64>()
    };
    // the blaze sends this z into order 1
    let got = area(&pq, 1.0) / area(&full, 1.0);
    assert!((got / ratio - 1.0).abs() < 0.01, "areas: {got} against {ratio}");

    let wi = direction(20.0, 0.0);
    let directions: Vec<Directions> = (0..60)
        .map(|i| {
            let x = -wi.x - (0.42 + 0.004 * f64::from(i)) / 2.5;
            Directions { wi, wr: DVec3::new(x, 0.0, (1.0 - x * x).sqrt()) }
        })
        .collect();
    let luminance = |variant: &Variant| -> f64 {
        let placement = Placement { height: &height, rotate_deg: 0.0, variant };
        let twin = TwinRunner::new(placement, true).unwrap();
        twin.tristimulus(&directions).unwrap().iter().map(|c| c[1]).sum()
    };
    let got = luminance(&pq) / luminance(&full);
    assert!((got / ratio - 1.0).abs() < 0.03, "colours: {got} against {ratio}");
}

/// The interpolation written out, with a product of complex numbers to choose.
fn interpolated(
    height: &HeightField,
    f: DVec2,
    z: f64,
    product: impl Fn(Complex64, Complex64) -> Complex64,
) -> f64 {
    let size = DVec2::new(height.size_x_um(), height.size_y_um());
    let pixels = DVec2::new(height.columns() as f64, height.rows() as f64);
    let place = f * size;
    let first = (place - 0.5 * (pixels - 1.0) + 0.5).floor();
    let sinc = |t: f64| if t == 0.0 { 1.0 } else { (PI * t).sin() / (PI * t) };
    let kernel = |t: f64, n: f64| Complex64::cis(-PI * t / n) * (sinc(t) / sinc(t / n));
    let mut sum = Complex64::default();
    for s in 0..height.rows() {
        for r in 0..height.columns() {
            let bin = first + DVec2::new(r as f64, s as f64);
            let weight =
                product(kernel(place.y - bin.y, pixels.y), kernel(place.x - bin.x, pixels.x));
            sum += product(weight, coefficient_brute(height, bin.x as i64, bin.y as i64, z));
        }
    }
    sum.norm_sqr()
}

/// `q = p1 p2 + q1 q2` in place of `p1 q2 + q1 p2`: not the field's numbers anywhere, not even at the peaks.
#[test]
fn the_misprinted_product_is_far_away() {
    let height = rough(9, 7);
    let variant = variant("mode = \"pq\"\nwindow_radius = 6\nperiods = [1, 1]");
    let (form, tables) = prepared(&variant, &height);
    let twin = Twin::new(&form, &tables, 0.0);
    let misprint = |a: Complex64, b: Complex64| {
        Complex64::new(a.re * b.re - a.im * b.im, a.re * b.re + a.im * b.im)
    };
    for f in FREQUENCIES {
        let right = response(&twin, f, -14.0);
        assert!((interpolated(&height, f, -14.0, |a, b| a * b) - right).abs() < 1e-9);
        let wrong = interpolated(&height, f, -14.0, misprint);
        assert!((wrong - right).abs() > 0.2 * right, "{f}: {wrong} against {right}");
    }
}
