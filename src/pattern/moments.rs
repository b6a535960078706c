//! Sums over texels that may be filtered linearly, and what a filtered sum means.

use std::f64::consts::PI;

use super::{PatternMap, Texel, turn};

/// Standard deviation of angles that are spread evenly over a whole turn: π/√3. No spread is wider.
pub const MAX_ANGLE_SPREAD_RAD: f64 = PI / 1.732_050_807_568_877_2;

/// What a texture holds at a texel. All entries are multiplied by the mask, so that a filter weighs foil alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// `mask·(R cos φ, R sin φ, ln a, b)`: R is 1 without a spread of the angle, else `exp(-σφ²/2)`.
    pub a: [f64; 4],
    /// `mask·(1, (ln a)² + σ_ln²)`.
    pub b: [f64; 2],
}

impl Moments {
    /// The moments of a texel.
    pub fn new(texel: &Texel) -> Moments {
        let Texel { angle_rad, period_ratio, depth_ratio, mask, .. } = *texel;
        let (spread, ln_spread) = (texel.angle_spread_rad, texel.ln_period_spread);
        // the widest spread has no mean direction
        let length =
            if spread < MAX_ANGLE_SPREAD_RAD { (-0.5 * spread * spread).exp() } else { 0.0 };
        let (sin, cos) = angle_rad.sin_cos();
        let ln_period = period_ratio.ln();
        Moments {
            a: [length * cos, length * sin, ln_period, depth_ratio].map(|v| mask * v),
            b: [1.0, ln_period * ln_period + ln_spread * ln_spread].map(|v| mask * v),
        }
    }

    /// What filtered moments mean: mean direction, `σφ² = -2 ln R` with R the length of the mean of the unit vectors, geometric
    /// mean of the period, standard deviation of its logarithm, mean depth. Without foil it is the default with mask 0.
    pub fn decode(&self) -> Texel {
        let [x, y, ln_period, depth] = self.a;
        let [mask, ln_square] = self.b;
        if mask <= 0.0 {
            return Texel { mask: 0.0, ..Texel::default() };
        }
        let ln_mean = ln_period / mask;
        let variance = (ln_square / mask - ln_mean * ln_mean).max(0.0);
        let length = (x.hypot(y) / mask).min(1.0);
        Texel {
            angle_rad: turn(y.atan2(x)),
            period_ratio: ln_mean.exp(),
            depth_ratio: depth / mask,
            mask,
            angle_spread_rad: (-2.0 * length.ln()).max(0.0).sqrt().min(MAX_ANGLE_SPREAD_RAD),
            ln_period_spread: variance.sqrt(),
        }
    }

    fn add(&mut self, weight: f64, other: &Moments) {
        self.a.iter_mut().zip(other.a).for_each(|(sum, value)| *sum += weight * value);
        self.b.iter_mut().zip(other.b).for_each(|(sum, value)| *sum += weight * value);
    }
}

/// One level of a texture of moments.
#[derive(Clone, Debug, PartialEq)]
pub struct MomentMap {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// `[row][column]`, rows from the top.
    pub texels: Vec<Moments>,
}

impl PatternMap {
    /// The moments of all texels, the first level of a texture.
    pub fn moments(&self) -> MomentMap {
        let texels = self.texels.iter().map(Moments::new).collect();
        MomentMap { width: self.width, height: self.height, texels }
    }

    /// All levels, from the map itself to one texel. Sides are halved and rounded down, as graphics APIs ask.
    pub fn mips(&self) -> Vec<MomentMap> {
        let mut levels = vec![self.moments()];
        while let Some(next) = levels.last().and_then(MomentMap::halved) {
            levels.push(next);
        }
        levels
    }
}

impl MomentMap {
    /// The next level; `None` after the last. Each texel is the mean over its area: 2 × 2 texels, of an odd side parts of a third.
    fn halved(&self) -> Option<MomentMap> {
        if self.width.max(self.height) == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let columns: Vec<_> = (0..width).map(|i| covered(i, self.width, width)).collect();
        let mut texels = Vec::with_capacity(width * height);
        for row in 0..height {
            let rows = covered(row, self.height, height);
            for columns in &columns {
                let mut sum = Moments::default();
                for &(row, of_row) in &rows {
                    for &(column, of_column) in columns {
                        sum.add(of_row * of_column, &self.texels[row * self.width + column]);
                    }
                }
                texels.push(sum);
            }
        }
        Some(MomentMap { width, height, texels })
    }
}

/// Which of `from` texels in a line the `i`-th of `to` covers, each with its share of it.
fn covered(i: usize, from: usize, to: usize) -> Vec<(usize, f64)> {
    // in units of 1/to of a texel, all are whole numbers
    let (begin, end) = (i * from, (i + 1) * from);
    let part = |at: usize| end.min((at + 1) * to) - begin.max(at * to);
    (begin / to..end.div_ceil(to)).map(|at| (at, part(at) as f64 / from as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;
    use half::f16;

    fn map(width: usize, texels: Vec<Texel>) -> PatternMap {
        PatternMap::new(width, texels.len() / width, texels, "map").unwrap()
    }

    fn random(width: usize, height: usize) -> PatternMap {
        let mut random = SplitMix64::new(7);
        let mut texel = || Texel {
            angle_rad: 6.0 * random.share(),
            period_ratio: 0.5 + random.share(),
            depth_ratio: random.share(),
            mask: random.share(),
            ..Texel::default()
        };
        map(width, (0..width * height).map(|_| texel()).collect())
    }

    #[test]
    fn a_constant_map_is_constant_on_all_levels() {
        let texel = Texel {
            angle_rad: 5.9,
            period_ratio: 0.7,
            depth_ratio: 1.3,
            mask: 0.25,
            angle_spread_rad: 0.3,
            ln_period_spread: 0.1,
        };
        let levels = map(13, vec![texel; 13 * 6]).mips();
        let sizes: Vec<_> = levels.iter().map(|level| (level.width, level.height)).collect();
        assert_eq!(sizes, [(13, 6), (6, 3), (3, 1), (1, 1)]);
        for found in levels.iter().flat_map(|level| &level.texels).map(Moments::decode) {
            assert!((found.angle_rad - 5.9).abs() < 1e-12, "{found:?}");
            assert!((found.period_ratio - 0.7).abs() < 1e-12, "{found:?}");
            assert!((found.depth_ratio - 1.3).abs() < 1e-12, "{found:?}");
            assert!((found.mask - 0.25).abs() < 1e-12, "{found:?}");
            assert!((found.angle_spread_rad - 0.3).abs() < 1e-9, "{found:?}");
            assert!((found.ln_period_spread - 0.1).abs() < 1e-9, "{found:?}");
        }
    }

    /// No level loses weight, whatever the sides are. Dropping the last column of an odd side would.
    #[test]
    fn means_are_kept() {
        for (width, height) in [(64, 64), (37, 5), (1, 9), (31, 1), (6, 100)] {
            let map = random(width, height);
            let of_all = |level: &MomentMap, of: fn(&Moments) -> f64| {
                level.texels.iter().map(of).sum::<f64>() / level.texels.len() as f64
            };
            let levels = map.mips();
            for level in &levels {
                for of in [(|m| m.b[0]) as fn(&Moments) -> f64, |m| m.a[0], |m| m.a[2], |m| m.b[1]]
                {
                    let (first, found) = (of_all(&levels[0], of), of_all(level, of));
                    assert!((found - first).abs() < 1e-12, "{width} × {height}: {found} {first}");
                }
            }
            let last = levels[levels.len() - 1].texels[0].decode();
            assert!((last.mask - map.foil_share()).abs() < 1e-12);
        }
        let dropped = random(37, 5);
        let kept: f64 =
            dropped.texels().chunks(37).flat_map(|row| &row[..36]).map(|t| t.mask).sum();
        assert!((kept / 180.0 - dropped.foil_share()).abs() > 1e-4);
    }

    /// Two directions on both sides of the tangent. The mean of the numbers is on the other side: that is the control.
    #[test]
    fn directions_are_averaged_across_the_whole_turn() {
        let two = |delta: f64| {
            let texel = |angle_rad| Texel { angle_rad, ..Texel::default() };
            map(2, vec![texel(delta), texel(-delta)])
        };
        for delta in [0.01, 0.1, 0.3] {
            let map = two(delta);
            let found = map.mips()[1].texels[0].decode();
            assert!(
                found.angle_rad.sin().abs() < 1e-12 && found.angle_rad.cos() > 0.0,
                "{found:?}"
            );
            assert!((found.angle_spread_rad / delta - 1.0).abs() < 0.02, "{found:?}");
            let numbers = 0.5 * (map.texels()[0].angle_rad + map.texels()[1].angle_rad);
            assert!((numbers - PI).abs() < 1e-12, "{numbers}");
        }
        let opposite = two(PI / 2.0).mips()[1].texels[0].decode();
        assert_eq!(opposite.angle_spread_rad, MAX_ANGLE_SPREAD_RAD);
    }

    #[test]
    fn foil_alone_counts() {
        let foil = Texel { angle_rad: 1.0, period_ratio: 2.0, ..Texel::default() };
        let bare = Texel { angle_rad: 4.0, period_ratio: 0.5, mask: 0.0, ..Texel::default() };
        let found = map(2, vec![foil, bare]).mips()[1].texels[0].decode();
        let wanted = Texel { mask: 0.5, ..foil };
        assert!((found.angle_rad - wanted.angle_rad).abs() < 1e-12, "{found:?}");
        assert!((found.period_ratio - 2.0).abs() < 1e-12 && found.mask == 0.5, "{found:?}");
        assert!(found.angle_spread_rad < 1e-7 && found.ln_period_spread < 1e-7, "{found:?}");
        let nothing = map(1, vec![bare]).mips()[0].texels[0].decode();
        assert_eq!(nothing, Texel { mask: 0.0, ..Texel::default() });
    }

    #[test]
    fn periods_spread_in_their_logarithm() {
        let texel = |period_ratio| Texel { period_ratio, ..Texel::default() };
        let found = map(2, vec![texel(0.5), texel(2.0)]).mips()[1].texels[0].decode();
        assert!((found.period_ratio - 1.0).abs() < 1e-12, "{found:?}");
        assert!((found.ln_period_spread - 2f64.ln()).abs() < 1e-12, "{found:?}");
    }

    /// The numbers of docs/patterns.md: what textures of 16-bit and of 32-bit floats add to a spread of 0.
    #[test]
    fn narrow_floats_add_a_spread() {
        let worst = |round: fn(f64) -> f64| {
            let mut worst = [0.0_f64; 2];
            for i in 0..2000 {
                let (angle_rad, share) = (0.003 * f64::from(i), f64::from(i) / 2000.0);
                let texel =
                    Texel { angle_rad, period_ratio: 0.5 + 1.5 * share, ..Texel::default() };
                let Moments { a, b } = Moments::new(&texel);
                let found = Moments { a: a.map(round), b: b.map(round) }.decode();
                worst[0] = worst[0].max(found.angle_spread_rad);
                worst[1] = worst[1].max(found.ln_period_spread);
            }
            worst
        };
        let half = worst(|v| f16::from_f64(v).to_f64());
        assert!(half[0] > 0.02 && half[0] < 0.035 && half[1] < 0.025, "{half:?}");
        let single = worst(|v| f64::from(v as f32));
        assert!(single.iter().all(|spread| *spread < 5e-4), "{single:?}");
    }
}
