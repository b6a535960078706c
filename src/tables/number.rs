//! Numbers of texels as bytes.

use half::f16;

use super::TexelFormat;

impl TexelFormat {
    /// Rounds numbers to the format, texel by texel.
    pub(super) fn round(self, texels: &mut [f64]) {
        match self {
            TexelFormat::Rg16Float | TexelFormat::Rgba16Float => {
                texels.iter_mut().for_each(|v| *v = f16::from_f64(*v).to_f64());
            }
            TexelFormat::Rg32Float | TexelFormat::Rgba32Float => {
                texels.iter_mut().for_each(|v| *v = f64::from(*v as f32));
            }
            TexelFormat::Rgb9e5Ufloat => {
                for texel in texels.as_chunks_mut::<3>().0 {
                    *texel = unpacked(packed(*texel));
                }
            }
        }
    }

    /// Numbers as little-endian bytes, rounded.
    pub fn encode(self, texels: &[f64]) -> Vec<u8> {
        match self {
            TexelFormat::Rg16Float | TexelFormat::Rgba16Float => {
                texels.iter().flat_map(|&v| f16::from_f64(v).to_le_bytes()).collect()
            }
            TexelFormat::Rg32Float | TexelFormat::Rgba32Float => {
                texels.iter().flat_map(|&v| (v as f32).to_le_bytes()).collect()
            }
            TexelFormat::Rgb9e5Ufloat => {
                texels.as_chunks().0.iter().flat_map(|&v| packed(v).to_le_bytes()).collect()
            }
        }
    }

    /// Numbers from little-endian bytes.
    pub fn decode(self, bytes: &[u8]) -> Vec<f64> {
        match self {
            TexelFormat::Rg16Float | TexelFormat::Rgba16Float => {
                let pairs = bytes.as_chunks().0;
                pairs.iter().map(|&pair| f16::from_le_bytes(pair).to_f64()).collect()
            }
            TexelFormat::Rg32Float | TexelFormat::Rgba32Float => {
                let fours = bytes.as_chunks().0;
                fours.iter().map(|&four| f64::from(f32::from_le_bytes(four))).collect()
            }
            TexelFormat::Rgb9e5Ufloat => {
                let fours = bytes.as_chunks().0;
                fours.iter().flat_map(|&four| unpacked(u32::from_le_bytes(four))).collect()
            }
        }
    }
}

/// Bits of a number's mantissa.
const MANTISSA: i32 = 9;
/// Bias of the exponent.
const BIAS: i32 = 15;
/// The maximum number of the format, `511/512·2^16`.
const LARGEST: f64 = 65408.0;

/// Three numbers with the exponent of the largest of them (Vulkan 1.0, "RGB to Shared Exponent Conversion").
fn packed(texel: [f64; 3]) -> u32 {
    let texel = texel.map(|v| if v > 0.0 { v.min(LARGEST) } else { 0.0 });
    let largest = texel.iter().copied().fold(0.0, f64::max);
    let mut exponent = (0..=31).find(|e| largest < power(e - BIAS)).unwrap_or(31);
    let share =
        |v: f64, exponent: i32| (v / power(exponent - BIAS - MANTISSA) + 0.5).floor() as u32;
    if share(largest, exponent) == 1 << MANTISSA {
        exponent += 1;
    }
    let [x, y, z] = texel.map(|v| share(v, exponent));
    x | y << MANTISSA | z << (2 * MANTISSA) | (exponent as u32) << (3 * MANTISSA)
}

fn unpacked(bits: u32) -> [f64; 3] {
    let unit = power((bits >> (3 * MANTISSA)) as i32 - BIAS - MANTISSA);
    [0, MANTISSA, 2 * MANTISSA].map(|shift| f64::from(bits >> shift & 0x1FF) * unit)
}

/// A power of two.
fn power(exponent: i32) -> f64 {
    2.0_f64.powi(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_exponents_keep_nine_bits_of_the_largest() {
        let near = |texel: [f64; 3]| {
            let largest = texel.iter().copied().fold(0.0, f64::max);
            let found = unpacked(packed(texel));
            found.iter().zip(texel).all(|(a, b)| (a - b).abs() <= largest * 2.0_f64.powi(-9))
        };
        for texel in [[1.0, 0.5, 0.25], [0.9999, 0.3, 0.0], [3e4, 1.0, 7e3], [2e-4, 1e-4, 0.0]] {
            assert!(near(texel), "{texel:?} {:?}", unpacked(packed(texel)));
        }
        assert!(near([511.9, 512.0, 0.1]) && unpacked(packed([511.9, 0.0, 0.0]))[0] == 512.0);
        assert_eq!(unpacked(packed([-1.0, f64::NAN, 0.0])), [0.0; 3]);
        assert_eq!(unpacked(packed([1e9, 0.0, 0.0])), [LARGEST, 0.0, 0.0]);
        // 1.0 in Vulkan's format: exponent 16, mantissa 256
        assert_eq!(packed([1.0, 0.0, 0.0]), 16 << 27 | 256);
    }

    #[test]
    fn what_was_rounded_stays() {
        for bits in [0, 16 << 27 | 256, 31 << 27 | 511 << 9 | 3, 5 << 27 | 300 << 18 | 511] {
            assert_eq!(packed(unpacked(bits)), bits, "{bits:x}");
        }
    }
}
