//! Maps as PNG files: numbers in four channels, and the ranges of two of them as text.

use std::f64::consts::TAU;
use std::io::Cursor;
use std::ops::RangeInclusive;

use png::{BitDepth, ColorType, Decoder, Info, Limits};

use super::{DEPTH_RATIOS, PERIOD_RATIOS, PatternMap, Ranges, Texel, check_range, check_size};
use crate::encode;
use crate::error::{Error, Result};
use crate::surface::read::check_length;

/// Key of the text chunk with the lowest and the highest period ratio, such as `0.5 2`.
pub const PERIOD_KEY: &str = "diffraction:period_ratio";
/// Key of the text chunk with the lowest and the highest depth ratio.
pub const DEPTH_KEY: &str = "diffraction:depth_ratio";

const AGAIN: &str = "the file is truncated or damaged; export it again";

/// Ranges that a caller gives. They go before those that a file states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenRanges {
    /// Lowest and highest period ratio.
    pub period_ratio: Option<[f64; 2]>,
    /// Lowest and highest depth ratio.
    pub depth_ratio: Option<[f64; 2]>,
}

/// Bits of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bits {
    /// 256 angles, 1.4° apart.
    Eight,
    /// 65536 angles.
    Sixteen,
}

impl Bits {
    /// The greatest number of a channel.
    fn top(self) -> u16 {
        match self {
            Bits::Eight => 0xff,
            Bits::Sixteen => 0xffff,
        }
    }
}

impl PatternMap {
    /// Decodes a PNG file with red, green, blue and alpha, of 8 or 16 bits. What it states of colours (gAMA, sRGB, iCCP) is ignored.
    ///
    /// With `n` the greatest number of a channel, 255 or 65535: red is the angle, `R/(n + 1)` of a turn; green the period ratio,
    /// `low·(high/low)^(G/n)`; blue the depth ratio, `low + (high - low)·B/n`; alpha the mask, `A/n`. `subject` names the file in
    /// errors.
    pub fn decode(bytes: &[u8], given: &GivenRanges, subject: &str) -> Result<PatternMap> {
        let pixels = Pixels::decode(bytes, &[ColorType::Rgba], subject)?;
        let period = pixels.range(PERIOD_KEY, given.period_ratio, &PERIOD_RATIOS, subject)?;
        let depth = pixels.range(DEPTH_KEY, given.depth_ratio, &DEPTH_RATIOS, subject)?;
        let top = f64::from(pixels.bits.top());
        let (ln_low, ln_step) = (period[0].ln(), (period[1] / period[0]).ln() / top);
        let texel = |samples: &[u16]| {
            let [r, g, b, a] = [0, 1, 2, 3].map(|c| f64::from(samples[c]));
            // rounding must not leave the range that the file states
            let period_ratio = (ln_low + g * ln_step).exp().max(period[0]).min(period[1]);
            Texel {
                angle_rad: r / (top + 1.0) * TAU,
                period_ratio,
                depth_ratio: (depth[0] + (depth[1] - depth[0]) * (b / top)).min(depth[1]),
                mask: a / top,
                ..Texel::default()
            }
        };
        let texels = pixels.samples.chunks_exact(4).map(texel).collect();
        PatternMap::new(pixels.width, pixels.height, texels, subject)
    }

    /// A PNG file of the map. Numbers are rounded to the nearest that the file can hold.
    ///
    /// Refused are ratios of foil outside of the ranges, and spreads, which the file has no place for.
    pub fn png(&self, ranges: &Ranges, bits: Bits) -> Result<Vec<u8>> {
        let subject = "pattern map";
        ranges.check(subject)?;
        let [period, depth] = [ranges.period_ratio, ranges.depth_ratio];
        let inside = |value: f64, [low, high]: [f64; 2]| {
            value >= low * (1.0 - 1e-9) && value <= high * (1.0 + 1e-9)
        };
        for (i, texel) in self.texels.iter().enumerate().filter(|(_, texel)| texel.mask > 0.0) {
            let place = format_args!("at column {}, row {}", i % self.width, i / self.width);
            if texel.angle_spread_rad > 0.0 || texel.ln_period_spread > 0.0 {
                let cause = format!("has a spread {place}, which the file cannot hold");
                return Err(Error::new(subject, cause).remedy("write the map without spreads"));
            }
            let is_inside = inside(texel.period_ratio, period) && inside(texel.depth_ratio, depth);
            if !is_inside {
                let (a, b) = (texel.period_ratio, texel.depth_ratio);
                let cause = format!(
                    "has the period ratio {a} and the depth ratio {b} {place}, outside of the ranges {period:?} and {depth:?}"
                );
                return Err(Error::new(subject, cause).remedy("give wider ranges"));
            }
        }
        let top = f64::from(bits.top());
        let share = |value: f64, low: f64, high: f64| match high > low {
            true => (top * ((value - low) / (high - low)).clamp(0.0, 1.0)).round() as u16,
            false => 0,
        };
        let sample = |texel: &Texel| {
            let turns = (texel.angle_rad / TAU * (top + 1.0)).round() as u32;
            [
                // the whole turn is the angle 0
                (turns % (u32::from(bits.top()) + 1)) as u16,
                share(texel.period_ratio.ln(), period[0].ln(), period[1].ln()),
                share(texel.depth_ratio, depth[0], depth[1]),
                (top * texel.mask).round() as u16,
            ]
        };
        let samples: Vec<[u16; 4]> = self.texels.iter().map(sample).collect();
        let text = |[low, high]: [f64; 2]| format!("{low} {high}");
        let texts = [(PERIOD_KEY, text(period)), (DEPTH_KEY, text(depth))];
        let size = [self.width as u32, self.height as u32];
        encode::png_of_numbers(size, &samples, bits == Bits::Sixteen, &texts)
    }
}

/// A PNG file as its numbers.
pub(super) struct Pixels {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) bits: Bits,
    /// Numbers of a pixel.
    pub(super) channels: usize,
    /// `[row][column][channel]`.
    pub(super) samples: Vec<u16>,
    texts: Vec<(String, String)>,
}

impl Pixels {
    /// Decodes a file that has one of these kinds of pixels.
    pub(super) fn decode(bytes: &[u8], kinds: &[ColorType], subject: &str) -> Result<Pixels> {
        let error = |cause: &str| Error::new(subject, cause);
        let broken =
            |e: png::DecodingError| error("the PNG cannot be decoded").source(e).remedy(AGAIN);
        if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            return Err(error("is not a PNG file").remedy("save it as PNG"));
        }
        let decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 64 << 20 });
        let mut reader = decoder.read_info().map_err(broken)?;
        let (width, height) = (reader.info().width as usize, reader.info().height as usize);
        check_size(width, height, subject)?;
        let (kind, depth) = reader.output_color_type();
        if !kinds.contains(&kind) {
            let what = match kind {
                ColorType::Indexed => "has a palette",
                ColorType::Grayscale | ColorType::GrayscaleAlpha => "is grey",
                ColorType::Rgb => "has no alpha channel, which is the mask",
                ColorType::Rgba => "has an alpha channel",
            };
            let wanted = match kinds.contains(&ColorType::Rgb) {
                true => "save it with red, green and blue",
                false => {
                    "save it with red, green, blue and alpha (RGBA), also where alpha is 1 everywhere"
                }
            };
            return Err(error(what).remedy(wanted));
        }
        let (bits, size) = match depth {
            BitDepth::Sixteen => (Bits::Sixteen, 2),
            _ => (Bits::Eight, 1),
        };
        let channels = kind.samples();
        let total = width * height * channels * size;
        check_length(subject, bytes.len(), total as u64, true)?;
        let mut raw = vec![0; total];
        reader.next_frame(&mut raw).map_err(broken)?;
        // text may follow the pixels
        reader.finish().map_err(broken)?;
        let samples = match bits {
            Bits::Eight => raw.into_iter().map(u16::from).collect(),
            Bits::Sixteen => {
                raw.as_chunks::<2>().0.iter().map(|b| u16::from_be_bytes(*b)).collect()
            }
        };
        let texts = texts(reader.info());
        Ok(Pixels { width, height, bits, channels, samples, texts })
    }

    /// The greatest number of a channel.
    pub(super) fn top(&self) -> f64 {
        f64::from(self.bits.top())
    }

    /// A range that the caller gives, or else the file states.
    fn range(
        &self,
        key: &str,
        given: Option<[f64; 2]>,
        limits: &RangeInclusive<f64>,
        subject: &str,
    ) -> Result<[f64; 2]> {
        let range = match (given, self.texts.iter().find(|(name, _)| name == key)) {
            (Some(given), _) => given,
            (None, Some((_, text))) => two_numbers(text).ok_or_else(|| {
                Error::new(subject, format!("has the text {text:?} for {key}"))
                    .remedy("write two numbers with a space between them, such as \"0.5 2\"")
            })?,
            (None, None) => {
                let cause = format!("does not state {key}");
                let remedy = format!(
                    "add a text chunk of that name with two numbers, such as \"0.5 2\", or give the range: without it channels have no scale"
                );
                return Err(Error::new(subject, cause).remedy(remedy));
            }
        };
        check_range(key, range, limits, subject)?;
        Ok(range)
    }
}

fn two_numbers(text: &str) -> Option<[f64; 2]> {
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    numbers?.try_into().ok()
}

/// Keys and texts, in all kinds of chunks: image programs change one into another.
fn texts(info: &Info) -> Vec<(String, String)> {
    let plain = info.uncompressed_latin1_text.iter().map(|c| (c.keyword.clone(), c.text.clone()));
    let packed = info.compressed_latin1_text.iter();
    let packed = packed.map(|c| (c.keyword.clone(), c.get_text().unwrap_or_default()));
    let wide = info.utf8_text.iter();
    let wide = wide.map(|c| (c.keyword.clone(), c.get_text().unwrap_or_default()));
    plain.chain(packed).chain(wide).collect()
}
