//! Bessel functions of the first kind.

/// `J_0(x) … J_{count-1}(x)` by downward recurrence (Miller), which is stable where upward recurrence is not. The
/// result is scaled so that `J_0 + 2 Σ J_2k = 1`.
pub fn bessel(count: usize, x: f64) -> Vec<f64> {
    let size = x.abs();
    if size < 1e-300 {
        return (0..count).map(|n| if n == 0 { 1.0 } else { 0.0 }).collect();
    }
    // so high that the initial values of the recurrence have no effect on the result
    let max = (count as f64).max(size);
    let start = 2 * (0.5 * (max + 12.0 * max.cbrt() + 20.0)).ceil() as usize;
    let mut values = vec![0.0; start + 1];
    let (mut above, mut here) = (0.0, 1e-300);
    let mut sum = 0.0;
    for n in (0..=start).rev() {
        values[n] = here;
        if n % 2 == 0 {
            sum += if n == 0 { here } else { 2.0 * here };
        }
        let below = 2.0 * n as f64 / size * here - above;
        (above, here) = (here, below);
        if here.abs() > 1e150 {
            let shrink = 1e-150;
            (above, here, sum) = (above * shrink, here * shrink, sum * shrink);
            values[n..].iter_mut().for_each(|v| *v *= shrink);
        }
    }
    values.truncate(count);
    let sign = |n: usize| if x < 0.0 && n % 2 == 1 { -1.0 } else { 1.0 };
    values.iter().enumerate().map(|(n, v)| sign(n) * v / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bessel_agrees_with_the_library() {
        for x in [0.0, 1e-9, 0.1, 1.0, 2.975, 5.95, -7.3, 30.0, 121.0] {
            for (n, got) in bessel(60, x).iter().enumerate() {
                let want = libm::jn(n as i32, x);
                assert!(
                    (got - want).abs() < 1e-14 + 1e-12 * want.abs(),
                    "J_{n}({x}) = {got}, {want}"
                );
            }
        }
    }
}
