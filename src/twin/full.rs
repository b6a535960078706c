//! The full sum in f64; see `templates/full.wgsl`.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rustfft::num_complex::Complex64;

use crate::optics::{self, gain, path_difference};
use crate::plan::{Coherence, Optics, Packing, Variant};
use crate::reference::Directions;
use crate::resolve::Resolved;
use crate::tables::Table;

/// Everything that one pixel reads.
pub struct Twin<'a> {
    /// Counts and sizes.
    pub resolved: &'a Resolved,
    /// Term table, rounded or not.
    pub terms: &'a Table,
    /// Spectrum table, rounded or not.
    pub spectrum: &'a Table,
    /// The variant; only what the template's defines hold is read.
    pub variant: &'a Variant,
    /// Rotation of the surface, degrees.
    pub rotate_deg: f64,
}

impl Twin<'_> {
    /// Relative tristimulus values of `ρ`.
    pub fn tristimulus(&self, Directions { wi, wr }: Directions) -> [f64; 3] {
        let factor = gain(wi, wr, self.optics());
        if factor == 0.0 {
            return [0.0; 3];
        }
        let path = path_difference(wi, wr, self.rotate_deg);
        let mut xyz = [0.0; 3];
        for node in 0..self.spectrum.width as i64 {
            let [x, y, z, lambda_um] = self.spectrum.load(node, 0, 0);
            let response = self.response(path, lambda_um);
            xyz = std::array::from_fn(|c| xyz[c] + [x, y, z][c] * response);
        }
        xyz.map(|c| c * factor)
    }

    /// `|P|²` of this variant at one wavelength, µm, along `path = (u, v, w)`.
    pub fn response(&self, path: DVec3, lambda_um: f64) -> f64 {
        let place = path.truncate() / lambda_um * DVec2::from(self.resolved.patch_um);
        let nearest = (place + 0.5).floor();
        // z over its greatest value
        let tau = 0.5 * path.z * (self.variant.wavelengths.min_nm * 1e-3) / lambda_um;
        let sharpness = self.window_sharpness(lambda_um);
        let radius = i64::from(self.resolved.window_radius);
        let mut amplitude = Complex64::default();
        let mut intensity = 0.0;
        for s in -radius..=radius {
            for r in -radius..=radius {
                let bin = nearest + DVec2::new(r as f64, s as f64);
                let weight = window(place - bin, sharpness);
                let tap = self.bin_amplitude(bin, tau) * weight;
                amplitude += tap;
                intensity += tap.norm_sqr();
            }
        }
        match self.optics().coherence {
            Coherence::Single => amplitude.norm_sqr(),
            Coherence::Ensemble => intensity,
        }
    }

    /// `c_rs(z) = Σ_n τ^n table_n` of one bin, by Horner's rule.
    fn bin_amplitude(&self, bin: DVec2, tau: f64) -> Complex64 {
        let column = bin.x as i64 + self.resolved.bins.r_max as i64;
        let row = bin.y as i64 + self.resolved.bins.s_max as i64;
        let mut sum = Complex64::default();
        for layer in (0..self.resolved.layers as usize).rev() {
            let [re, im, next_re, next_im] = self.terms.load(column, row, layer);
            if self.variant.packing == Packing::Paired {
                sum = sum * tau + Complex64::new(next_re, next_im);
            }
            sum = sum * tau + Complex64::new(re, im);
        }
        sum
    }

    /// `1/(2 σ²)` of the window on each axis, in bins.
    fn window_sharpness(&self, lambda_um: f64) -> DVec2 {
        let sigma_um = optics::window_sigma_um(self.optics(), lambda_um * 1e3);
        let turns = 2.0 * PI * sigma_um / DVec2::from(self.resolved.patch_um);
        0.5 * turns * turns
    }

    fn optics(&self) -> &Optics {
        &self.variant.optics
    }
}

/// Weight of the coherence window at an offset in bins, peak 1.
fn window(offset: DVec2, sharpness: DVec2) -> f64 {
    (-(offset * offset).dot(sharpness)).exp()
}
