//! Reproducible randomness: a generator, and smooth periodic fields made with it.

use std::f64::consts::TAU;

/// SplitMix64: G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014; the constants
/// are those of S. Vigna's public-domain `splitmix64.c`. Small, and the same on every platform.
pub(super) struct SplitMix64(u64);

impl SplitMix64 {
    /// `stream` separates the uses of one seed, so that adding a use does not change the others.
    pub(super) fn new(seed: u64, stream: u64) -> SplitMix64 {
        let mut mixed = SplitMix64(seed);
        let start = mixed.next_u64();
        SplitMix64(start ^ stream.wrapping_mul(0xd134_2543_de82_ef95))
    }

    fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `[0, 1)`, 53 bits.
    pub(super) fn share(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in `[-1, 1)`.
    pub(super) fn signed(&mut self) -> f64 {
        2.0 * self.share() - 1.0
    }
}

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
    fn generator_gives_the_published_sequence() {
        // first outputs of splitmix64.c for the state 1234567
        let mut random = SplitMix64(1_234_567);
        assert_eq!(random.next_u64(), 6_457_827_717_110_365_317);
        assert_eq!(random.next_u64(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn waves_stay_in_range_and_are_not_constant() {
        let waves = Waves::new(&mut SplitMix64::new(5, 0), 32, 4, 3, 3);
        let values: Vec<f64> = (0..32)
            .flat_map(|j| (0..32).map(move |i| (i, j)))
            .map(|(i, j)| waves.at(i, j))
            .collect();
        assert!(values.iter().all(|v| v.abs() <= 1.0));
        assert!(values.iter().any(|v| v.abs() > 0.2));
    }
}
