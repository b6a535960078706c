//! Reflection by a stack of layers, polarisation by polarisation.

use std::f64::consts::TAU;

use rustfft::num_complex::Complex64;

/// Reflectances for s and p polarisation (the electric field perpendicular and parallel to the plane of incidence) of a
/// stack under a transparent medium of index `above`, at the cosine `cos` of the angle there, 0 to 1. `films`: indices
/// n + ik and thicknesses in the unit of `lambda`, from the outside in; `base`: the medium below them.
///
/// Interfaces by Fresnel's formulas, layers by the recursion of Rouard (1937), which no thickness makes overflow: the
/// light that crosses a layer twice is damped, never amplified.
pub fn reflectances(
    above: f64,
    cos: f64,
    films: &[(Complex64, f64)],
    base: Complex64,
    lambda: f64,
) -> [f64; 2] {
    let across_squared = above * above * (1.0 - cos * cos).max(0.0);
    // index, and its product with the cosine
    let medium = |index: Complex64| (index, root(index * index - across_squared));
    let outside = (Complex64::new(above, 0.0), Complex64::new(above * cos, 0.0));
    let (mut below, mut found) = (medium(base), None);
    let films = films.iter().rev().map(|(index, thickness)| (medium(*index), *thickness));
    for (layer, thickness) in films {
        let inner = reflected(layer, below, found);
        let turn = (Complex64::I * (2.0 * TAU * thickness / lambda) * layer.1).exp();
        found = Some(inner.map(|amplitude| amplitude * turn));
        below = layer;
    }
    reflected(outside, below, found).map(|amplitude| amplitude.norm_sqr().min(1.0))
}

/// Amplitudes at an interface with what comes back from below it.
fn reflected(
    (upper, upper_cos): (Complex64, Complex64),
    (lower, lower_cos): (Complex64, Complex64),
    below: Option<[Complex64; 2]>,
) -> [Complex64; 2] {
    let (up, down) = (lower * lower * upper_cos, upper * upper * lower_cos);
    let own = [ratio(upper_cos, lower_cos), ratio(up, down)];
    match below {
        None => own,
        Some(below) => [0, 1].map(|p| (own[p] + below[p]) / (1.0 + own[p] * below[p])),
    }
}

/// `(a - b)/(a + b)`; where both are 0, light runs along the surface and all of it is reflected.
fn ratio(a: Complex64, b: Complex64) -> Complex64 {
    let sum = a + b;
    if sum.norm_sqr() == 0.0 { Complex64::new(-1.0, 0.0) } else { (a - b) / sum }
}

/// The square root with positive parts. It is made of square roots of real numbers, which are the same on every
/// processor.
fn root(z: Complex64) -> Complex64 {
    let size = (z.re * z.re + z.im * z.im).sqrt();
    let larger = (0.5 * (size + z.re.abs())).sqrt();
    let smaller = if larger > 0.0 { 0.5 * z.im.abs() / larger } else { 0.0 };
    if z.re >= 0.0 { Complex64::new(larger, smaller) } else { Complex64::new(smaller, larger) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn real(n: f64) -> Complex64 {
        Complex64::new(n, 0.0)
    }

    /// A quarter wave of index n on n_b at normal incidence: `((n0 n_b - n²)/(n0 n_b + n²))²` (Born & Wolf, 1.6.4).
    #[test]
    fn quarter_waves_have_the_closed_form() {
        for (film, base, above) in [(1.38, 1.52, 1.0), (2.3, 1.52, 1.0), (1.46, 3.9, 1.58)] {
            let quarter = 550.0 / (4.0 * film);
            let [s, p] = reflectances(above, 1.0, &[(real(film), quarter)], real(base), 550.0);
            let want = ((above * base - film * film) / (above * base + film * film)).powi(2);
            assert!((s - want).abs() < 1e-12 && (p - want).abs() < 1e-12, "{s} {p} {want}");
            // a half wave changes nothing
            let [half, _] =
                reflectances(above, 1.0, &[(real(film), 2.0 * quarter)], real(base), 550.0);
            assert!((half - ((base - above) / (base + above)).powi(2)).abs() < 1e-12);
        }
    }

    /// Pairs of quarter waves, high and low: admittance `(h/l)^(2N) n_b` (Macleod 2010, 5.1).
    #[test]
    fn stacks_of_quarter_waves_have_the_closed_form() {
        let (high, low, base) = (2.3, 1.38, 1.52_f64);
        let layer = |n: f64| (real(n), 550.0 / (4.0 * n));
        let films: Vec<_> = (0..6).flat_map(|_| [layer(high), layer(low)]).collect();
        let admittance = (high / low).powi(12) * base;
        let want = ((1.0 - admittance) / (1.0 + admittance)).powi(2);
        let [s, _] = reflectances(1.0, 1.0, &films, real(base), 550.0);
        assert!((s - want).abs() < 1e-12, "{s} {want}");
    }

    /// The same stack by characteristic matrices (Abelès 1950), an independent way.
    #[test]
    fn matrices_agree_at_every_angle() {
        let films = [
            (Complex64::new(1.46, 0.0), 80.0),
            (Complex64::new(0.2, 3.4), 15.0),
            (Complex64::new(2.1, 0.3), 60.0),
        ];
        let (above, base, lambda) = (1.3, Complex64::new(1.4, 7.0), 610.0);
        for degrees in [0.0_f64, 25.0, 50.0, 75.0, 89.0] {
            let cos = degrees.to_radians().cos();
            let across = above * above * (1.0 - cos * cos);
            for p in [false, true] {
                let admittance = |index: Complex64| {
                    let q = (index * index - across).sqrt();
                    if p { index * index / q } else { q }
                };
                let (mut b, mut c) = (real(1.0), admittance(base));
                for (index, thickness) in films.iter().rev() {
                    let phase = (index * index - across).sqrt() * (TAU * thickness / lambda);
                    let (y, (cos, sin)) = (admittance(*index), (phase.cos(), phase.sin()));
                    // time runs as exp(-iωt), so that k is positive
                    (b, c) = (
                        cos * b - Complex64::I * sin / y * c,
                        cos * c - Complex64::I * y * sin * b,
                    );
                }
                let outside = admittance(real(above));
                let want = ((outside * b - c) / (outside * b + c)).norm_sqr();
                let got = reflectances(above, cos, &films, base, lambda)[usize::from(p)];
                assert!((got - want).abs() < 1e-12, "{degrees}° {p}: {got} {want}");
            }
        }
    }

    #[test]
    fn limits() {
        // a dielectric at normal incidence, at Brewster's angle, along the surface, beyond the critical angle
        let n = 1.5_f64;
        let [s, p] = reflectances(1.0, 1.0, &[], real(n), 1.0);
        assert!((s - 0.04).abs() < 1e-15 && (p - 0.04).abs() < 1e-15);
        let brewster = n.atan().cos();
        assert!(reflectances(1.0, brewster, &[], real(n), 1.0)[1] < 1e-30);
        assert_eq!(reflectances(1.0, 0.0, &[], real(n), 1.0), [1.0, 1.0]);
        let [s, p] = reflectances(n, 0.5, &[], real(1.0), 1.0);
        assert!((s - 1.0).abs() < 1e-12 && (p - 1.0).abs() < 1e-12);
        // a perfect conductor
        for cos in [1.0, 0.5, 0.01] {
            let [s, p] = reflectances(1.0, cos, &[], Complex64::new(0.0, 1e9), 1.0);
            assert!(1.0 - s < 1e-8 && 1.0 - p < 1e-6, "{s} {p}");
        }
        // a metal film of any thickness is finite, and hides what is below
        let metal = Complex64::new(1.0, 6.0);
        let thick = reflectances(1.0, 0.7, &[(metal, 1e9)], real(1.5), 1.0);
        let whole = reflectances(1.0, 0.7, &[], metal, 1.0);
        assert!((thick[0] - whole[0]).abs() < 1e-12 && (thick[1] - whole[1]).abs() < 1e-12);
    }
}
