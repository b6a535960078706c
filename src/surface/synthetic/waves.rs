//! Smooth periodic fields made of random waves.

use std::f64::consts::TAU;

use crate::random::SplitMix64;

/// A smooth field over the unit square, periodic in both directions: a sum of products of cosines with whole wave numbers.
///
/// Values lie in `[-1, 1]`; evaluated from tables over the pixels of an `n × n` grid, rows counted from the bottom.
pub(super) struct Waves {
    /// `[mode][pixel]`, the amplitude in the first.
    x: Vec<Vec<f64>>,
    y: Vec<Vec<f64>>,
}

impl Waves {
    /// `modes` waves with wave numbers up to `max_x` and `max_y`, of equal amplitude; neither may be constant in both.
    pub(super) fn new(
        random: &mut SplitMix64,
        n: usize,
        modes: usize,
        max_x: usize,
        max_y: usize,
    ) -> Waves {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        let whole =
            |random: &mut SplitMix64, max: usize| (random.share() * (max + 1) as f64).floor();
        for _ in 0..modes {
            let (mut kx, ky) = (whole(random, max_x), whole(random, max_y));
            if kx == 0.0 && ky == 0.0 {
                kx = 1.0;
            }
            let (phase_x, phase_y) = (random.share(), random.share());
            let table = |k: f64, phase: f64, amplitude: f64| {
                (0..n)
                    .map(|i| amplitude * libm::cos(TAU * (k * i as f64 / n as f64 + phase)))
                    .collect()
            };
            x.push(table(kx, phase_x, 1.0 / modes as f64));
            y.push(table(ky, phase_y, 1.0));
        }
        Waves { x, y }
    }

    /// Value at pixel (`i` from the left, `j` from the bottom).
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.x.iter().zip(&self.y).map(|(x, y)| x[i] * y[j]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_stay_in_range_and_are_not_constant() {
        let waves = Waves::new(&mut SplitMix64::stream(5, 0), 32, 4, 3, 3);
        let values: Vec<f64> = (0..32)
            .flat_map(|j| (0..32).map(move |i| (i, j)))
            .map(|(i, j)| waves.at(i, j))
            .collect();
        assert!(values.iter().all(|v| v.abs() <= 1.0));
        assert!(values.iter().any(|v| v.abs() > 0.2));
    }
}
