//! What the tests of browsers share.

use super::tools;
use diffraction_harness::drivers::browser::Browser;
use diffraction_shaders::plan::{
    Auto, Basis, Grating, Optics, Packing, Reconstruction, Sampling, Variant,
};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;

/// The machine's browser.
pub fn browser() -> Option<Browser> {
    tools::found(Browser::open())
}

/// 19 terms about the mid-range height, 3 × 3 bins, paired.
pub fn centred(name: &str) -> Variant {
    Variant {
        name: name.to_owned(),
        basis: Basis::Taylor,
        terms: Auto::Value(19),
        packing: Packing::Paired,
        reconstruction: Reconstruction::Window,
        sampling: Sampling::Load,
        hoist: true,
        ..Variant::texts(&Optics::standard())
    }
}

pub fn blazed() -> HeightField {
    let grating = Grating::Blazed { period_um: 2.5, height_um: 0.25, pixels: 60 };
    synthesise(&grating, "blazed").unwrap().field
}

/// Light from the normal, a square picture.
pub fn params(size: u32) -> [f32; 8] {
    [0.0, 0.0, 1.0, 0.0, size as f32, size as f32, 0.0, 0.0]
}
