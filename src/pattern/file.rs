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
                let remedy = "add a text chunk of that name with two numbers, such as \"0.5 2\", or give the range: without it channels have no scale";
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Anisotropy, MAX_ANGLE_SPREAD_RAD};
    use png::{Encoder, SrgbRenderingIntent};

    const RANGES: Ranges = Ranges { period_ratio: [0.5, 2.0], depth_ratio: [0.8, 1.2] };

    /// A file as another program writes it.
    fn file(kind: ColorType, depth: BitDepth, size: [u32; 2], data: &[u8]) -> Vec<u8> {
        with_texts(kind, depth, size, data, &[])
    }

    fn with_texts(
        kind: ColorType,
        depth: BitDepth,
        size: [u32; 2],
        data: &[u8],
        texts: &[(&str, &str)],
    ) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(kind);
        encoder.set_depth(depth);
        if kind == ColorType::Indexed {
            encoder.set_palette(vec![0; 6]);
        }
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        for (key, text) in texts {
            encoder.add_itxt_chunk((*key).to_owned(), (*text).to_owned()).unwrap();
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        bytes
    }

    const GIVEN: GivenRanges =
        GivenRanges { period_ratio: Some([0.5, 2.0]), depth_ratio: Some([0.8, 1.2]) };

    fn rgba(data: &[u8]) -> Vec<u8> {
        file(ColorType::Rgba, BitDepth::Eight, [data.len() as u32 / 4, 1], data)
    }

    /// What a user who reads the manual expects of the channels; a colour profile changes nothing.
    #[test]
    fn channels_are_as_the_manual_says() {
        let map = PatternMap::decode(
            &rgba(&[0, 0, 0, 0, 64, 255, 255, 255, 192, 51, 51, 51]),
            &GIVEN,
            "x",
        );
        let map = map.unwrap();
        let [first, second, third] = map.texels().try_into().unwrap();
        let texel = |angle_rad, period_ratio, depth_ratio, mask| Texel {
            angle_rad,
            period_ratio,
            depth_ratio,
            mask,
            ..Texel::default()
        };
        assert_eq!(first, texel(0.0, 0.5, 0.8, 0.0));
        assert_eq!(second, texel(0.25 * TAU, 2.0, 1.2, 1.0));
        assert_eq!((third.angle_rad, third.mask), (0.75 * TAU, 0.2));
        // a fifth of the way: 0.5 · 4^0.2 and 0.8 + 0.2 · 0.4
        assert!((third.period_ratio - 0.5 * 4f64.powf(0.2)).abs() < 1e-12, "{third:?}");
        assert!((third.depth_ratio - 0.88).abs() < 1e-12, "{third:?}");
    }

    #[test]
    fn a_written_map_is_read_back() {
        for (bits, step) in [(Bits::Eight, 256.0), (Bits::Sixteen, 65536.0)] {
            let texel = |i: usize| Texel {
                // the last is nearer to the whole turn than half a step
                angle_rad: (i as f64 / 20.0 * TAU).min(TAU - 1e-6),
                period_ratio: 0.5 * 4f64.powf(i as f64 / 20.0),
                depth_ratio: 0.8 + 0.02 * i as f64,
                mask: i as f64 / 20.0,
                ..Texel::default()
            };
            let map = PatternMap::new(3, 7, (0..21).map(texel).collect(), "map").unwrap();
            let bytes = map.png(&RANGES, bits).unwrap();
            let back = PatternMap::decode(&bytes, &GivenRanges::default(), "map").unwrap();
            assert_eq!((back.width(), back.height()), (3, 7));
            let half = 0.51 / (step - 1.0);
            for (a, b) in map.texels().iter().zip(back.texels()) {
                let turned = (a.angle_rad - b.angle_rad).rem_euclid(TAU);
                assert!(turned.min(TAU - turned) < half * TAU, "{a:?} {b:?}");
                assert!((a.period_ratio / b.period_ratio).ln().abs() < half * 4f64.ln());
                assert!((a.depth_ratio - b.depth_ratio).abs() < half * 0.4 + 1e-12);
                assert!((a.mask - b.mask).abs() < half, "{a:?} {b:?}");
            }
            assert_eq!(back.texels()[20].angle_rad, 0.0);
            // what has been rounded once stays
            assert_eq!(back.png(&RANGES, bits).unwrap(), bytes);
        }
    }

    #[test]
    fn a_range_of_one_number_leaves_its_channel_unread() {
        let given = GivenRanges { period_ratio: Some([1.5, 1.5]), depth_ratio: Some([0.0, 0.0]) };
        let map = PatternMap::decode(&rgba(&[0, 17, 99, 255]), &given, "x").unwrap();
        let texel = map.texels()[0];
        assert_eq!((texel.period_ratio, texel.depth_ratio), (1.5, 0.0));
    }

    #[test]
    fn given_ranges_go_before_those_of_the_file() {
        let texts = [(PERIOD_KEY, "1 3"), (DEPTH_KEY, " 1\t1 ")];
        let bytes = with_texts(ColorType::Rgba, BitDepth::Eight, [1, 1], &[0, 255, 0, 255], &texts);
        let read =
            |given| PatternMap::decode(&bytes, &given, "x").unwrap().texels()[0].period_ratio;
        assert_eq!(read(GivenRanges::default()), 3.0);
        assert_eq!(read(GivenRanges { period_ratio: Some([1.0, 2.0]), depth_ratio: None }), 2.0);
    }

    #[test]
    fn a_map_without_a_scale_is_refused() {
        let one = [0, 0, 0, 255];
        let read = |texts: &[(&str, &str)]| {
            let bytes = with_texts(ColorType::Rgba, BitDepth::Eight, [1, 1], &one, texts);
            PatternMap::decode(&bytes, &GivenRanges::default(), "foil.png").unwrap_err().to_string()
        };
        let text = read(&[(DEPTH_KEY, "1 1")]);
        for part in ["foil.png", PERIOD_KEY, "text chunk", "\"0.5 2\""] {
            assert!(text.contains(part), "{text}");
        }
        assert!(read(&[(PERIOD_KEY, "1 1")]).contains(DEPTH_KEY));
        for bad in ["", "1", "1 2 3", "a b", "1,2"] {
            assert!(
                read(&[(PERIOD_KEY, bad), (DEPTH_KEY, "1 1")]).contains("two numbers"),
                "{bad}"
            );
        }
        for bad in ["2 1", "NaN 1", "0 1", "1 inf"] {
            assert!(read(&[(PERIOD_KEY, bad), (DEPTH_KEY, "1 1")]).contains("lower one first"));
        }
    }

    #[test]
    fn other_files_are_refused() {
        let good = rgba(&[1, 2, 3, 4, 5, 6, 7, 8]);
        let eight = BitDepth::Eight;
        let wide = file(ColorType::Grayscale, BitDepth::One, [8193, 1], &[0; 1025]);
        for (bytes, wanted) in [
            (file(ColorType::Indexed, eight, [1, 1], &[0]), "has a palette"),
            (file(ColorType::Grayscale, eight, [1, 1], &[0]), "is grey"),
            (file(ColorType::GrayscaleAlpha, eight, [1, 1], &[0; 2]), "is grey"),
            (file(ColorType::Rgb, eight, [1, 1], &[0; 3]), "no alpha channel"),
            (wide, "8193 × 1 texels; a side may have 1 to 8192"),
            (good[..good.len() - 13].to_vec(), "cannot be decoded"),
            (good[..good.len() / 2].to_vec(), "cannot be decoded"),
            (good[..20].to_vec(), "cannot be decoded"),
            (Vec::new(), "is not a PNG file"),
            (b"\xff\xd8\xff\xe0 and so on".to_vec(), "is not a PNG file"),
        ] {
            let error = PatternMap::decode(&bytes, &GIVEN, "foil.png").unwrap_err();
            assert!(error.to_string().contains(wanted), "{wanted}: {error}");
            assert!(error.subject() == "foil.png" && error.advice().is_some(), "{error}");
        }
    }

    #[test]
    fn what_the_file_cannot_hold_is_not_written() {
        let one = |texel| PatternMap::new(1, 1, vec![texel], "map").unwrap();
        let write =
            |texel| one(texel).png(&RANGES, Bits::Eight).map(drop).map_err(|e| e.to_string());
        let texel = Texel::default();
        for (bad, wanted) in [
            (Texel { period_ratio: 2.1, ..texel }, "period ratio 2.1"),
            (Texel { depth_ratio: 0.7, ..texel }, "depth ratio 0.7"),
            (Texel { angle_spread_rad: 0.1, ..texel }, "a spread at column 0, row 0"),
        ] {
            assert!(write(bad).unwrap_err().contains(wanted));
            // without foil it means nothing
            assert!(write(Texel { mask: 0.0, ..bad }).is_ok());
        }
        let reversed = Ranges { period_ratio: [2.0, 0.5], ..RANGES };
        assert!(one(texel).png(&reversed, Bits::Eight).is_err());
    }

    fn anisotropy(data: &[u8]) -> Result<PatternMap, String> {
        let bytes = file(ColorType::Rgb, BitDepth::Eight, [data.len() as u32 / 3, 1], data);
        PatternMap::from_anisotropy(&bytes, &Anisotropy::default(), "a.png")
            .map_err(|e| e.to_string())
    }

    /// Red is the direction along the tangent, green along the bitangent. The default of the extension is (1, 0.5, 1), the tangent.
    #[test]
    fn a_texture_of_anisotropy_is_read() {
        let map = anisotropy(&[255, 128, 255, 128, 255, 255, 0, 128, 255, 218, 218, 230]).unwrap();
        for (texel, wanted_deg) in map.texels().iter().zip([0.0, 90.0, 180.0, 45.0]) {
            let off = texel.angle_rad.to_degrees() - wanted_deg;
            assert!(off.abs() < 0.5, "{texel:?}");
            assert_eq!((texel.period_ratio, texel.depth_ratio, texel.mask), (1.0, 1.0, 1.0));
        }
        let spreads: Vec<f64> =
            map.texels().iter().map(|t| t.angle_spread_rad.to_degrees()).collect();
        assert_eq!(spreads[..3], [0.0; 3]);
        assert!((spreads[3] - 26.0).abs() < 0.5, "{spreads:?}");
        // all 8-bit unit vectors count as unit vectors
        for i in 0..720 {
            let (sin, cos) = (0.5 * f64::from(i)).to_radians().sin_cos();
            let byte = |v: f64| (127.5 + 127.5 * v).round() as u8;
            let texel = anisotropy(&[byte(cos), byte(sin), 255]).unwrap().texels()[0];
            assert_eq!(texel.angle_spread_rad, 0.0, "{i}");
        }
        let bytes = file(ColorType::Rgb, BitDepth::Eight, [1, 1], &[255, 128, 255]);
        let of = Anisotropy { strength: 0.5, rotation_rad: -0.1 };
        let texel = PatternMap::from_anisotropy(&bytes, &of, "a").unwrap().texels()[0];
        assert!((texel.angle_rad - (TAU - 0.1)).abs() < 0.01, "{texel:?}");
        assert!((texel.angle_spread_rad - (2.0 * 2f64.ln()).sqrt()).abs() < 1e-12, "{texel:?}");
    }

    #[test]
    fn directions_of_no_length_are_refused() {
        let text =
            anisotropy(&[255, 128, 255, 128, 128, 9, 128, 127, 255, 127, 127, 0]).unwrap_err();
        for part in ["a.png", "2 texels", "column 1, row 0"] {
            assert!(text.contains(part), "{text}");
        }
        // without a strength there is no direction to miss
        let isotropic = anisotropy(&[127, 128, 0]).unwrap().texels()[0];
        assert_eq!(isotropic.angle_spread_rad, MAX_ANGLE_SPREAD_RAD);
        assert!(anisotropy(&[131, 128, 255]).is_ok());
        let grey = file(ColorType::Grayscale, BitDepth::Eight, [1, 1], &[0]);
        let text = PatternMap::from_anisotropy(&grey, &Anisotropy::default(), "a").unwrap_err();
        assert!(text.to_string().contains("is grey"), "{text}");
        let of = Anisotropy { strength: f64::NAN, rotation_rad: 0.0 };
        assert!(PatternMap::from_anisotropy(&grey, &of, "a").is_err());
    }
}
