//! Singular values of a small dense matrix.
//!
//! It uses one-sided Jacobi rotations instead of a linear-algebra crate. The matrices have a few dozen columns, small
//! singular values keep their relative accuracy, and plain loops give the same digits on every processor. Kernels that
//! are selected at run time do not.

/// Singular values in descending order, with the right singular vectors, of a matrix given by its columns. The sign of
/// each vector is chosen so that its entry of largest magnitude (the first of equal ones) is positive.
pub fn singular(mut columns: Vec<Vec<f64>>) -> Vec<(f64, Vec<f64>)> {
    let count = columns.len();
    let mut right: Vec<Vec<f64>> =
        (0..count).map(|i| (0..count).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for p in 0..count {
            for q in p + 1..count {
                let (a, b) = (dot(&columns[p], &columns[p]), dot(&columns[q], &columns[q]));
                let c = dot(&columns[p], &columns[q]);
                if c.abs() <= 1e-15 * (a * b).sqrt() {
                    continue;
                }
                turned = true;
                let zeta = (b - a) / (2.0 * c);
                let tangent = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                rotate(&mut columns, p, q, cosine, tangent * cosine);
                rotate(&mut right, p, q, cosine, tangent * cosine);
            }
        }
        if !turned {
            break;
        }
    }
    let mut found: Vec<(f64, Vec<f64>)> =
        columns.iter().map(|c| dot(c, c).sqrt()).zip(right.into_iter().map(signed)).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
}

const MAX_SWEEPS: usize = 40;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn rotate(columns: &mut [Vec<f64>], p: usize, q: usize, cosine: f64, sine: f64) {
    let (left, right) = columns.split_at_mut(q);
    for (x, y) in left[p].iter_mut().zip(right[0].iter_mut()) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
}

/// Entries that differ only by rounding count as equal, so that rounding does not decide the sign.
fn signed(vector: Vec<f64>) -> Vec<f64> {
    let max = vector.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
    let leading = vector.iter().copied().find(|v| v.abs() >= 0.999_999 * max).unwrap_or(1.0);
    vector.into_iter().map(|v| if leading < 0.0 { -v } else { v }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `diag(3, 2)` between two rotations: `A = R(0.4) D R(1.1)ᵀ`.
    #[test]
    fn known_values_and_vectors() {
        let ((s, c), (t, d)) = (0.4_f64.sin_cos(), 1.1_f64.sin_cos());
        let column = |x: f64, y: f64| {
            let (x, y) = (3.0 * x, 2.0 * y);
            vec![c * x - s * y, s * x + c * y]
        };
        let found = singular(vec![column(d, -t), column(t, d)]);
        assert!((found[0].0 - 3.0).abs() < 1e-14 && (found[1].0 - 2.0).abs() < 1e-14);
        assert!((found[0].1[0] - d).abs() < 1e-14 && (found[0].1[1] - t).abs() < 1e-14);
        assert!((found[1].1[0] + found[0].1[1]).abs() < 1e-14 || found[1].1[0] > 0.0);
    }

    /// Hilbert's matrix of order 8. Its smallest singular value is 1.11e-10, which a method that squares the matrix
    /// could not resolve.
    #[test]
    fn small_values_keep_their_digits() {
        let columns =
            (0..8).map(|i| (0..8).map(|j| 1.0 / f64::from(i + j + 1)).collect()).collect();
        let found = singular(columns);
        assert!((found[0].0 / 1.695_938_996_921_949 - 1.0).abs() < 1e-12, "{}", found[0].0);
        assert!((found[7].0 / 1.111_538_966e-10 - 1.0).abs() < 1e-4, "{:e}", found[7].0);
    }
}
