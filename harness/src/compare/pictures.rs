//! Pictures of a comparison: maps, their difference, and FLIP.

use diffraction_shaders::optics::brdf_map::BrdfMap;
use diffraction_shaders::optics::colour::{srgb_encode, to_rgb};
use diffraction_shaders::optics::colour_difference::LIT;
use diffraction_shaders::plan::Colour;
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, flip};

/// Factor on differences in pictures.
pub const AMPLIFIED: f64 = 10.0;

/// `|a - b|` for each channel in linear sRGB, amplified, as a map of colours.
pub fn difference(a: &BrdfMap, b: &BrdfMap) -> BrdfMap {
    let pixel = |(a, b): (&Option<[f64; 3]>, &Option<[f64; 3]>)| {
        let ([a, b], srgb) = ([(*a)?, (*b)?], Colour::Srgb);
        let (a, b) = (to_rgb(a, srgb), to_rgb(b, srgb));
        let apart = std::array::from_fn(|c| AMPLIFIED * (a[c] - b[c]).abs());
        Some(diffraction_shaders::optics::colour::from_rgb(apart, srgb))
    };
    BrdfMap { size: a.size, xyz: a.xyz.iter().zip(&b.xyz).map(pixel).collect() }
}

/// Mean FLIP (Andersson et al. 2020, *FLIP: a difference evaluator for alternating images*) over the pixels that are lit in
/// one of the maps, at the viewing distance that the authors propose (67 pixels per degree). `None` if no pixel is lit.
pub fn mean_flip(reference: &BrdfMap, other: &BrdfMap, exposure: f64) -> Option<f64> {
    let image = |frame: &BrdfMap| {
        let pixel = |xyz: &Option<[f64; 3]>| {
            let rgb = xyz.map_or([0.0; 3], |xyz| to_rgb(xyz, Colour::Srgb));
            rgb.map(|c| (255.0 * srgb_encode(exposure * c)).round() as u8)
        };
        let bytes: Vec<u8> = frame.xyz.iter().flat_map(pixel).collect();
        FlipImageRgb8::with_data(frame.size as u32, frame.size as u32, &bytes)
    };
    let map = flip(image(reference), image(other), DEFAULT_PIXELS_PER_DEGREE).to_vec();
    let lit = |i: &usize| {
        let y = |frame: &BrdfMap| frame.xyz[*i].map_or(0.0, |xyz| xyz[1]);
        exposure * y(reference).max(y(other)) >= LIT
    };
    let values: Vec<f64> = (0..map.len()).filter(lit).map(|i| f64::from(map[i])).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffraction_shaders::optics::brdf_map::view_directions;
    use diffraction_shaders::optics::colour::D65_WHITE;

    #[test]
    fn flip_is_zero_of_equals_and_large_of_black() {
        let colours: Vec<[f64; 3]> =
            view_directions(16).iter().map(|d| D65_WHITE.map(|c| 0.3 * c * d.z)).collect();
        let map = BrdfMap::from_disc(16, &colours);
        let black = BrdfMap::from_disc(16, &vec![[0.0; 3]; colours.len()]);
        assert_eq!(mean_flip(&map, &map, 1.0), Some(0.0));
        assert!(mean_flip(&map, &black, 1.0).is_some_and(|flip| flip > 0.3));
        assert_eq!(mean_flip(&black, &black, 1.0), None);
        let apart = difference(&map, &black).disc();
        assert!((apart[0][1] - AMPLIFIED * colours[0][1]).abs() < 1e-9);
    }
}
