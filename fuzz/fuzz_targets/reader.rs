//! What the targets of the file formats share: any bytes give heights that keep the documented promises, or an error.

use diffraction_shaders::plan::{FileSource, Flip, Trust, VoidValue};
use diffraction_shaders::surface::read::parse;
use diffraction_shaders::surface::{MAX_PIXELS, voids};

/// The key of a plan that integers need.
#[allow(dead_code, reason = "not every format has integers")]
pub const INTEGERS: Option<f64> = Some(0.375);
/// … and that floats refuse.
#[allow(dead_code, reason = "not every format has floats")]
pub const FLOATS: Option<f64> = None;

/// What plans say about a file: nothing, a scale, or everything.
fn plans(name: &str, height_um: Option<f64>) -> [FileSource; 3] {
    let bare = FileSource { path: name.into(), height_um, ..FileSource::default() };
    let scaled = FileSource { size_um: Some(1.0), trust: Trust::Plan, ..bare.clone() };
    let all = FileSource {
        size_y_um: Some(2.0),
        channel: Some("2".to_owned()),
        void_value: Some(VoidValue::Number(-9999.0)),
        flip: Flip::Rows,
        ..scaled.clone()
    };
    [bare, scaled, all]
}

/// Reads `bytes` as a file named `name`, with each of the values of `height_um` and each of [`plans`].
pub fn read(name: &str, heights_um: &[Option<f64>], bytes: &[u8]) {
    for source in heights_um.iter().flat_map(|&height_um| plans(name, height_um)) {
        match parse(&source, "fuzz", bytes) {
            Ok(reading) => {
                assert_eq!(reading.heights_um.len(), reading.columns * reading.rows);
                assert!((1..=MAX_PIXELS).contains(&reading.heights_um.len()));
                assert!(reading.heights_um.iter().all(|h| !h.is_infinite()));
                assert!(reading.pitch_x_um.is_finite() && reading.pitch_x_um > 0.0);
                assert!(reading.pitch_y_um.is_finite() && reading.pitch_y_um > 0.0);
                if let Ok((field, _)) = voids::fill(reading, "fuzz") {
                    assert!(field.heights_um().iter().all(|h| h.is_finite()));
                }
            }
            Err(error) => assert!(error.to_string().contains(name), "{error}"),
        }
    }
}
