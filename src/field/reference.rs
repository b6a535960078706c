//! Exact colours, with which all other results are compared.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::field::{Domain, Field, MAX_BYTES, Scratch};
use crate::optics::spectrum::{Spectrum, TABLE_MAX_NM, TABLE_MIN_NM};
use crate::optics::{self, Matter};
use crate::plan::{Optics, Window};
use crate::surface::HeightField;

/// A pair of unit vectors in the surface's frame, both pointing away from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directions {
    /// To the light.
    pub wi: DVec3,
    /// To the viewer.
    pub wr: DVec3,
}

impl Directions {
    /// From angles in degrees, `[theta_i, phi_i, theta_r, phi_r]`.
    pub fn from_degrees([theta_i, phi_i, theta_r, phi_r]: [f64; 4]) -> Directions {
        Directions { wi: optics::direction(theta_i, phi_i), wr: optics::direction(theta_r, phi_r) }
    }
}

/// Exact evaluation of one surface for directions whose `w` lies in a stated range.
pub struct Reference {
    field: Field,
    spectrum: Spectrum,
    optics: Optics,
    matter: Matter,
    rotate_deg: f64,
    coarsest_step_nm: f64,
}

impl Reference {
    /// Prepares the field for a batch of directions and a range of wavelengths, nm.
    ///
    /// Refuses a table larger than 6 GiB, which only a very large patch with a very short coherence length needs.
    pub fn new(
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
        (min_nm, max_nm): (f64, f64),
        directions: impl IntoIterator<Item = Directions>,
    ) -> Result<Reference> {
        let matter = Matter::new(optics)?;
        let (mut shortest, mut longest, mut widest) = (2.0_f64, 0.0_f64, 0.0_f64);
        for Directions { wi, wr } in directions {
            let uvw = wi + wr;
            shortest = shortest.min(uvw.z.max(0.0));
            longest = longest.max(uvw.z);
            widest = widest.max(uvw.truncate().length());
        }
        let domain =
            domain(optics.into(), &matter, (min_nm, max_nm), Span { shortest, longest, widest });
        let subject = format!("surface of {} × {} pixels", height.columns(), height.rows());
        let bytes = Field::bytes_needed(height, &domain);
        if bytes > MAX_BYTES {
            let cause =
                format!("its exact field needs {:.1} GiB", bytes as f64 / f64::from(1 << 30));
            return Err(
                Error::new(subject, cause).remedy("crop the scan, or lengthen coherence_um")
            );
        }
        let spectrum = Spectrum::new(&optics.illuminant)?;
        let field = Field::new(height, &domain);
        Ok(Reference {
            field,
            spectrum,
            optics: optics.clone(),
            matter,
            rotate_deg,
            coarsest_step_nm: 1.0,
        })
    }

    /// Bytes that the reference takes for colours, beside the heights: an estimate.
    pub fn working_bytes(
        height: &HeightField,
        window: impl Into<Window>,
        matter: &Matter,
        span: Span,
    ) -> u64 {
        Field::working_bytes(height, &domain(window.into(), matter, Reference::VISIBLE_NM, span))
    }

    /// The colour range of the tables, 380–780 nm: what the reference always integrates.
    pub const VISIBLE_NM: (f64, f64) = (TABLE_MIN_NM, TABLE_MAX_NM);

    /// Sets an upper limit of the wavelength step, to show that finer steps change nothing.
    #[must_use]
    pub fn with_coarsest_step_nm(mut self, step_nm: f64) -> Reference {
        self.coarsest_step_nm = step_nm;
        self
    }

    /// The same under light of a colour, linear sRGB.
    #[must_use]
    pub fn tinted(mut self, colour: DVec3) -> Reference {
        self.spectrum = self.spectrum.tinted(colour);
        self
    }

    /// The exact field that colours are computed from.
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// `|P(f; k w)|²` (or its ensemble mean) at one wavelength, nm.
    pub fn response(
        &self,
        Directions { wi, wr }: Directions,
        lambda_nm: f64,
        scratch: &mut Scratch,
    ) -> f64 {
        let uvw = optics::path_difference(wi, wr, self.rotate_deg);
        let lambda_um = lambda_nm * 1e-3;
        let sigma_um = optics::window_sigma_um(&self.optics, lambda_nm);
        let w = self.matter.depth(wi, wr, lambda_nm);
        self.field.intensity(uvw.truncate() / lambda_um, TAU * w / lambda_um, sigma_um, scratch)
    }

    /// Relative tristimulus values of `ρ`, gain included.
    ///
    /// Trapezoidal rule in λ over 380–780 nm. Along the radial segment `f = (u, v)/λ` the response is a sum of
    /// Gaussians no narrower than `σf/√2`. A step of one such standard deviation integrates them to 3e-9. So the step
    /// starts at 1 nm and is halved until it is that small for the direction.
    pub fn tristimulus(&self, directions: Directions, scratch: &mut Scratch) -> [f64; 3] {
        let gain = |nm: f64| self.matter.gain(directions.wi, directions.wr, nm);
        let at_reference = gain(optics::REFERENCE_NM);
        if at_reference == 0.0 {
            return [0.0; 3];
        }
        // without dispersion it is the same at all wavelengths
        let whole = if self.matter.is_plain() { at_reference } else { 1.0 };
        let per_nm = self.steps_per_nm(directions);
        let (min_nm, max_nm) = Reference::VISIBLE_NM;
        let count = ((max_nm - min_nm) * per_nm).round() as usize;
        let mut xyz = [0.0; 3];
        for i in 0..=count {
            let lambda_nm = min_nm + i as f64 / per_nm;
            let end = if i == 0 || i == count { 0.5 } else { 1.0 };
            let mut response = self.response(directions, lambda_nm, scratch) * end / per_nm;
            if !self.matter.is_plain() {
                response *= gain(lambda_nm);
            }
            let weights = self.spectrum.per_nm(lambda_nm);
            xyz = std::array::from_fn(|c| xyz[c] + weights[c] * response);
        }
        xyz.map(|c| c * whole)
    }

    /// [`Reference::tristimulus`] of many directions, on all cores.
    pub fn tristimulus_all(&self, directions: &[Directions]) -> Vec<[f64; 3]> {
        self.tristimulus_all_with(directions, &|_| ())
    }

    /// [`Reference::tristimulus_all`] with progress: `done` is called with the number of directions finished since the
    /// last call.
    pub fn tristimulus_all_with(
        &self,
        directions: &[Directions],
        done: &(dyn Fn(usize) + Sync),
    ) -> Vec<[f64; 3]> {
        evaluate_all(directions, done, |d, scratch| self.tristimulus(d, scratch))
    }

    fn steps_per_nm(&self, Directions { wi, wr }: Directions) -> f64 {
        let (min_nm, max_nm) = Reference::VISIBLE_NM;
        let widest_um = [min_nm, max_nm].map(|nm| optics::window_sigma_um(&self.optics, nm));
        let sigma_cpum = 1.0 / (TAU * widest_um[0].max(widest_um[1]) * std::f64::consts::SQRT_2);
        let uv = (wi + wr).truncate().length();
        let needed_nm = sigma_cpum * (min_nm * 1e-3).powi(2) / uv.max(1e-9) * 1e3;
        let mut step_nm = self.coarsest_step_nm;
        while step_nm > needed_nm && step_nm > MIN_STEP_NM {
            step_nm *= 0.5;
        }
        1.0 / step_nm
    }
}

/// What a batch of directions covers: the extreme sums of their cosines, and the maximum of `|(u, v)|`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Least sum of the cosines of light and viewer.
    pub shortest: f64,
    /// Greatest sum of the cosines.
    pub longest: f64,
    /// Maximum of `|(u, v)|`.
    pub widest: f64,
}

impl Span {
    /// Every direction.
    pub const ANYWHERE: Span = Span { shortest: 0.0, longest: 2.0, widest: 2.0 };
    /// The directions of a package's probes. On the plan's surfaces they cover 0.42 to 2, and up to 1.65.
    pub const PROBES: Span = Span { shortest: 0.47, longest: 2.0, widest: 1.58 };
}

/// What a field must cover.
fn domain(
    window: Window,
    matter: &Matter,
    (min_nm, max_nm): (f64, f64),
    Span { shortest, longest, widest }: Span,
) -> Domain {
    let k = |nm: f64| TAU / (nm * 1e-3);
    let sigma_um = [min_nm, max_nm].map(|nm| optics::window_sigma_um(window, nm));
    let (shortest, longest) = match matter.is_covered() {
        true => matter.w_span(shortest, longest),
        false => (shortest.min(longest), longest.max(shortest)),
    };
    Domain {
        coherence: window.coherence,
        sigma_um: (sigma_um[0].min(sigma_um[1]), sigma_um[0].max(sigma_um[1])),
        // z = k w with w = -(cos θi + cos θr), or n w' under a cover
        z: (-k(min_nm) * longest, -k(max_nm) * shortest),
        reach_cpum: widest / (min_nm * 1e-3),
    }
}

/// Evaluates directions on all cores, in blocks, with one scratch buffer per block.
pub fn evaluate_all<S: Default>(
    directions: &[Directions],
    done: &(dyn Fn(usize) + Sync),
    evaluate: impl Fn(Directions, &mut S) -> [f64; 3] + Sync,
) -> Vec<[f64; 3]> {
    const BLOCK: usize = 64;
    let mut out = vec![[0.0; 3]; directions.len()];
    out.par_chunks_mut(BLOCK).zip(directions.par_chunks(BLOCK)).for_each(|(out, block)| {
        let mut scratch = S::default();
        for (value, &d) in out.iter_mut().zip(block) {
            *value = evaluate(d, &mut scratch);
        }
        done(block.len());
    });
    out
}

/// Minimum wavelength step. It suffices for coherence lengths up to 4 mm.
const MIN_STEP_NM: f64 = 1.0 / 128.0;
