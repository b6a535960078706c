//! How much a picture flickers while the camera moves by less than a pixel.

use diffraction_shaders::error::Result;
use diffraction_shaders::optics::colour::{srgb_encode, tone_map};
use diffraction_shaders::variant::mesh::MeshParams;
use glam::{DMat4, DVec3};

use super::drawing::Hdr;
use super::{Mesh, Orbit};

/// Displayed luminance, 0 to 1, above which a pixel counts as bright.
pub const BRIGHT: f64 = 0.5;
/// Change of the displayed luminance above which a pixel flickers.
pub const CHANGE: f64 = 0.25;
/// Steps of the camera between frames, in pixels.
pub const STEPS: [f64; 3] = [0.0, 1.0 / 3.0, 2.0 / 3.0];
/// Coverage above which a pixel counts as filled by the body; what changes at its edge is its shape.
const FILLED: f32 = 0.999;

/// The flicker of frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flicker {
    /// Number of pixels within the body that are bright in at least one frame.
    pub bright: usize,
    /// Share of these whose displayed luminance changes by more than [`CHANGE`] between any two frames.
    pub flicker: f64,
}

/// Compares frames of the same size, as displayed with this exposure.
pub fn flicker(frames: &[Hdr], exposure: f64) -> Flicker {
    let (mut bright, mut changed) = (0, 0);
    for i in 0..frames.iter().map(|frame| frame.pixels.len()).min().unwrap_or(0) {
        let texels = || frames.iter().map(|frame| frame.pixels[i]);
        if texels().any(|texel| texel[3] < FILLED) {
            continue;
        }
        let shown = texels().map(|texel| displayed(texel, exposure));
        let (least, most) = shown.fold((1.0_f64, 0.0_f64), |(l, m), y| (l.min(y), m.max(y)));
        bright += usize::from(most > BRIGHT);
        changed += usize::from(most > BRIGHT && most - least > CHANGE);
    }
    Flicker { bright, flicker: changed as f64 / bright.max(1) as f64 }
}

/// Luminance as displayed, encoded as sRGB, 0 to 1.
fn displayed([r, g, b, _]: [f32; 4], exposure: f64) -> f64 {
    let rgb = tone_map([r, g, b].map(|c| exposure * f64::from(c)));
    srgb_encode(luminance(rgb))
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Sum of the luminance of a picture.
pub fn light(picture: &Hdr) -> f64 {
    let of = |texel: &[f32; 4]| luminance([texel[0], texel[1], texel[2]].map(f64::from));
    picture.pixels.iter().map(of).sum()
}

/// The camera moved to the right by a share of a pixel of the plane through its target.
pub fn moved(orbit: Orbit, mesh: &Mesh, size: [u32; 2], pixels: f64) -> Result<Orbit> {
    let right = orbit.params(mesh, size, DVec3::Y)?.view.row(0).truncate();
    let slope = (0.5 * orbit.view_deg.to_radians()).tan();
    let pixel = 2.0 * slope * orbit.distance / orbit.zoom / f64::from(size[1]);
    Ok(Orbit { target: orbit.target + pixels * pixel * right, ..orbit })
}

/// The same view, with the middles of pixels at another place within them: from -0.5 to 0.5, to the right and up.
pub fn within_pixel(params: &MeshParams, size: [u32; 2], place: [f64; 2]) -> MeshParams {
    let [x, y] = [0, 1].map(|axis| -2.0 * place[axis] / f64::from(size[axis]));
    let shift = DMat4::from_translation(DVec3::new(x, y, 0.0));
    MeshParams { projection: shift * params.projection, ..*params }
}
