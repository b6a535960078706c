//! The colours of numbers in pictures.

/// Viridis (van der Walt & Smith 2015, CC0), perceptually uniform, at eighths.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The colour of a share from 0 to 1; beyond, that of the end.
pub fn viridis(share: f64) -> [u8; 3] {
    let place = share.clamp(0.0, 1.0) * 8.0;
    let low = (place as usize).min(7);
    let part = place - low as f64;
    let mix = |c: usize| {
        f64::from(VIRIDIS[low][c]) * (1.0 - part) + f64::from(VIRIDIS[low + 1][c]) * part
    };
    [0, 1, 2].map(|c| mix(c).round() as u8)
}
