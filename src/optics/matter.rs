//! What a surface is made of: a material, films that follow the relief, and a plane-parallel cover, with the gain that
//! follows.
//!
//! Under a cover of index n, directions inside are `(α/n, sqrt(1 - |α|²/n²))`, where α is the xy part of the direction
//! outside. So u and v are the same inside and outside, and the phase per height is `z = k n w'` with
//! `w' = -(cos θi' + cos θr')`. Both faces of light's path lose what the cover's face reflects. Light that the face
//! reflects back, outside or inside, is left out.
//!
//! Shaders take the directions inside at 550 nm. The dispersion of a cover enters through the phase and through what its
//! face lets pass at normal incidence.

mod layers;

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::DVec3;
use rustfft::num_complex::Complex64;

use crate::defines::Defines;
use crate::error::{Error, Result};
use crate::optics::medium::Index;
use crate::optics::spectrum::{Spectrum, TABLE_MAX_NM, TABLE_MIN_NM};
use crate::optics::{REFERENCE_NM, path_difference, window_sigma_um};
use crate::plan::{Film, Material, Medium, Obliquity, Optics};

use super::gain::{HORIZON, fresnel_ratio, normal_reflectance, obliquity, schlick_gain, shadowing};

pub use layers::reflectances;

/// Largest k of a cover. A tenth of a millimetre takes 2 % of the light at 1e-5.
const MAX_COVER_K: f64 = 1e-5;

/// Smallest mean reflectance at normal incidence. Results are relative to it.
const MIN_REFLECTANCE: f64 = 1e-5;

/// Largest share of X, Y or Z that may lie beyond the table of a medium.
const MAX_BEYOND: f64 = 0.01;

/// Material, films and cover of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Matter {
    refractive_index: f64,
    /// `None`: Schlick's reflectance of `refractive_index` in air.
    stack: Option<Stack>,
    obliquity: Obliquity,
    has_shadowing: bool,
    /// Reflectance at normal incidence, without the cover's face: the mean over the light, weighted by luminance.
    normal: f64,
}

#[derive(Clone, Debug, PartialEq)]
struct Stack {
    cover: Index,
    /// Index of the cover at 550 nm.
    cover_index: f64,
    /// Indices, and thicknesses in nm.
    films: Vec<(Index, f64)>,
    base: Index,
}

/// What the reflectance depends on, beside the wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    /// Cosine between half vector and viewer, on the relief.
    pub cos_half: f64,
    /// Share of the obliquity factor that s polarisation has.
    pub s_share: f64,
}

impl Matter {
    /// The matter of a surface. It is an error, with the reason, if a table cannot be used, if a cover absorbs, or if
    /// nothing is reflected. Files must have been read.
    pub fn new(optics: &Optics) -> Result<Matter> {
        let Optics { refractive_index, obliquity, shadowing: has_shadowing, .. } = *optics;
        let normal = normal_reflectance(refractive_index);
        let plain = Matter { refractive_index, stack: None, obliquity, has_shadowing, normal };
        if optics.is_plain() {
            return Ok(plain);
        }
        let spectrum = Spectrum::new(&optics.illuminant)?;
        let index =
            |key: &str, medium: &Medium| checked(key, medium, &spectrum).map(|(index, _)| index);
        let cover = index("cover_index", &optics.cover_index)?;
        check_cover(&optics.cover_index, &cover)?;
        let base = match &optics.material {
            Material::Dielectric => Index::Constant(Complex64::new(refractive_index, 0.0)),
            Material::Medium(medium) => index("material", medium)?,
        };
        let film = |film: &Film| Ok((index("films", &film.index)?, film.thickness_nm));
        let films = optics.films.iter().map(film).collect::<Result<Vec<_>>>()?;
        let cover_index = cover.at(REFERENCE_NM).re;
        let stack = Stack { cover, cover_index, films, base };
        let normal = mean(&spectrum, |nm| stack.reflectances(nm, 1.0)[0]);
        if normal < MIN_REFLECTANCE {
            let cause = format!(
                "the relief reflects {normal:.1e} of the light at normal incidence: its index is that of what lies above it"
            );
            let remedy = "choose a material or a cover with another refractive index";
            return Err(Error::new("optics.material", cause).remedy(remedy));
        }
        Ok(Matter { stack: Some(stack), normal, ..plain })
    }

    /// Whether the surface is a dielectric in air with Stam's obliquity.
    pub fn is_plain(&self) -> bool {
        self.stack.is_none()
    }

    /// Reflectance at normal incidence, without the cover's face: the mean over the light, weighted by luminance.
    pub fn normal_reflectance(&self) -> f64 {
        self.normal
    }

    /// Share of the light that reaches a body below the relief and returns, at normal incidence: none below a material
    /// that absorbs. `None` for a dielectric in air, where it depends on the direction.
    pub fn body_share(&self) -> Option<f64> {
        let stack = self.stack.as_ref()?;
        let absorbs = stack.base.at(REFERENCE_NM).im > MAX_COVER_K;
        let faces = transmittance(1.0, 1.0, self.cover_index())[0].powi(2);
        Some(if absorbs { 0.0 } else { faces * (1.0 - self.normal) })
    }

    /// Refractive index of the cover at a wavelength, nm; 1 without a cover.
    pub fn cover_at(&self, lambda_nm: f64) -> f64 {
        self.stack.as_ref().map_or(1.0, |stack| stack.cover.at(lambda_nm).re)
    }

    /// The same at 550 nm.
    pub fn cover_index(&self) -> f64 {
        self.stack.as_ref().map_or(1.0, |stack| stack.cover_index)
    }

    /// Whether there is a cover.
    pub fn is_covered(&self) -> bool {
        self.stack.as_ref().is_some_and(|stack| stack.cover != Index::Constant(Complex64::ONE))
    }

    /// Reflectances of the relief for s and p polarisation, without the cover's face. `cos_half`: cosine between half
    /// vector and viewer, on the relief.
    pub fn reflectances(&self, lambda_nm: f64, cos_half: f64) -> [f64; 2] {
        match &self.stack {
            None => [self.normal * fresnel_ratio(cos_half, self.refractive_index); 2],
            Some(stack) => stack.reflectances(lambda_nm, cos_half.clamp(0.0, 1.0)),
        }
    }

    /// The exact gain at a wavelength, nm, relative to a mirror of the material at normal incidence. It is zero where
    /// either direction is at or below the horizon.
    pub fn gain(&self, wi: DVec3, wr: DVec3, lambda_nm: f64) -> f64 {
        let Some(stack) = &self.stack else {
            return schlick_gain(wi, wr, self.refractive_index, self.has_shadowing);
        };
        let Some(inside) = Inside::new(wi, wr, self.cover_at(lambda_nm)) else { return 0.0 };
        let factor = self.factor(&inside);
        let [s, p] = stack.reflectances(lambda_nm, inside.cos_half());
        (s * factor.s + p * factor.p) / self.normal
    }

    /// The exact `n w'` at a wavelength, nm: phase per height divided by the wave number in air, negative.
    pub fn depth(&self, wi: DVec3, wr: DVec3, lambda_nm: f64) -> f64 {
        if !self.is_covered() {
            return -(wi.z + wr.z);
        }
        let n = self.cover_at(lambda_nm);
        -n * (inside(wi, n).z + inside(wr, n).z)
    }

    /// `(u, v, n w')` at 550 nm in the frame of a surface that is rotated about its normal: what shaders compute.
    pub fn path(&self, wi: DVec3, wr: DVec3, rotate_deg: f64) -> DVec3 {
        let path = path_difference(wi, wr, rotate_deg);
        if self.is_covered() {
            path.truncate().extend(self.depth(wi, wr, REFERENCE_NM))
        } else {
            path
        }
    }

    /// What remains of the gain at 550 nm without the reflectance of the material: what shaders compute. For a
    /// dielectric in air it is the whole gain.
    pub fn geometry(&self, wi: DVec3, wr: DVec3) -> f64 {
        if self.is_plain() {
            return schlick_gain(wi, wr, self.refractive_index, self.has_shadowing);
        }
        Inside::new(wi, wr, self.cover_index()).map_or(0.0, |inside| self.factor(&inside).both())
    }

    /// What the reflectance of the relief depends on, at 550 nm.
    pub fn facing_of(&self, wi: DVec3, wr: DVec3) -> Facing {
        let Some(inside) = Inside::new(wi, wr, self.cover_index()) else {
            return Facing { cos_half: 1.0, s_share: 0.5 };
        };
        let factor = self.factor(&inside);
        let s_share = factor.s / factor.both();
        Facing { cos_half: inside.cos_half(), s_share }
    }

    /// The factor that remains of the gain beside [`Matter::geometry`]: reflectance relative to
    /// [`Matter::normal_reflectance`], with the cover's dispersion at normal incidence.
    pub fn ratio(&self, lambda_nm: f64, facing: Facing) -> f64 {
        let [s, p] = self.ratios(lambda_nm, facing.cos_half);
        p + facing.s_share * (s - p)
    }

    /// The largest [`Matter::ratios`] over the angles and a range of wavelengths, nm, in coarse steps.
    pub fn brightest(&self, [min_nm, max_nm]: [f64; 2]) -> f64 {
        let least = self.least_cos_half();
        let cosines = (0..=32).map(|i| least + (1.0 - least) * f64::from(i) / 32.0);
        let each = cosines.flat_map(|cos| {
            (0..=8).flat_map(move |i| {
                self.ratios(min_nm + (max_nm - min_nm) * f64::from(i) / 8.0, cos)
            })
        });
        each.fold(0.0, f64::max)
    }

    /// The same for s and p polarisation. A dielectric in air has 1, since its gain is whole without it.
    pub fn ratios(&self, lambda_nm: f64, cos_half: f64) -> [f64; 2] {
        let Some(stack) = &self.stack else { return [1.0; 2] };
        let face = |nm: f64| transmittance(1.0, 1.0, self.cover_at(nm))[0].powi(2);
        let faces = face(lambda_nm) / face(REFERENCE_NM);
        stack.reflectances(lambda_nm, cos_half).map(|r| r * faces / self.normal)
    }

    /// What is added to the square of `n w'` at 550 nm for that at another wavelength: `4(n² - n550²)`. It is exact where
    /// light and viewer are equally far from the normal; elsewhere the phase of a relief of 0.2 µm under polycarbonate errs by at most 4e-3.
    pub fn dispersion(&self, lambda_nm: f64) -> f64 {
        4.0 * (self.cover_at(lambda_nm).powi(2) - self.cover_index().powi(2))
    }

    /// `n w'` at a wavelength, from that at 550 nm; both negative.
    pub fn dispersed(&self, w: f64, lambda_nm: f64) -> f64 {
        if self.is_dispersive() { -(w * w + self.dispersion(lambda_nm)).max(0.0).sqrt() } else { w }
    }

    /// Whether the index of the cover depends on the wavelength.
    pub fn is_dispersive(&self) -> bool {
        self.stack.as_ref().is_some_and(|stack| matches!(stack.cover, Index::Rows(_)))
    }

    /// Share of the obliquity factor that s polarisation has. `None` if it depends on the directions.
    pub fn s_share(&self) -> Option<f64> {
        match self.obliquity {
            Obliquity::Stam => Some(0.5),
            Obliquity::Te => Some(1.0),
            Obliquity::Tm => Some(0.0),
            Obliquity::Unpolarised => None,
        }
    }

    /// Whether the shares of the polarisations depend on the directions.
    pub fn is_mixed(&self) -> bool {
        self.s_share().is_none()
    }

    /// Smallest cosine between half vector and viewer, on the relief.
    pub fn least_cos_half(&self) -> f64 {
        (1.0 - self.cover_index().powi(-2)).max(0.0).sqrt()
    }

    /// Least square of `n w'` at 550 nm: with both directions at the horizon.
    pub fn least_w_squared(&self) -> f64 {
        4.0 * (self.cover_index().powi(2) - 1.0).max(0.0)
    }

    /// The wavelength in air, nm, at which the greatest phase per height would be that of the shortest wavelength here:
    /// without a cover the shortest wavelength itself.
    pub fn phase_min_nm(&self, [min_nm, max_nm]: [f64; 2]) -> f64 {
        if !self.is_covered() {
            return min_nm;
        }
        let at = |nm: f64| nm / self.cover_at(nm);
        nodes(min_nm, max_nm).map(at).fold(f64::INFINITY, f64::min)
    }

    /// Least phase per height, 1/µm, over a range of wavelengths and all directions above the horizon.
    pub fn least_z(&self, [min_nm, max_nm]: [f64; 2]) -> f64 {
        let w = |nm: f64| 2.0 * (self.cover_at(nm).powi(2) - 1.0).max(0.0).sqrt();
        let at = |nm: f64| TAU * w(nm) / (nm * 1e-3);
        match self.is_covered() {
            true => nodes(min_nm, max_nm).map(at).fold(f64::INFINITY, f64::min),
            false => 0.0,
        }
    }

    /// Greatest phase per height at a wavelength, 1/µm: both directions along the normal.
    pub fn max_z(&self, lambda_nm: f64) -> f64 {
        2.0 * TAU / (lambda_nm * 1e-3) * self.cover_at(lambda_nm)
    }

    /// Least and greatest `-n w'` over the visible wavelengths, if the sum of the cosines outside is from `shortest` to
    /// `longest`.
    pub fn w_span(&self, shortest: f64, longest: f64) -> (f64, f64) {
        if !self.is_covered() {
            return (shortest, longest);
        }
        let long = |n: f64, cos: f64| (n * n - 1.0 + cos * cos).sqrt();
        let low = |n: f64| 2.0 * long(n, 0.5 * shortest);
        let high = |n: f64| long(n, longest.min(1.0)) + long(n, (longest - 1.0).max(0.0));
        let all = || nodes(TABLE_MIN_NM, TABLE_MAX_NM).map(|nm| self.cover_at(nm));
        (all().map(low).fold(f64::INFINITY, f64::min), all().map(high).fold(0.0, f64::max))
    }

    /// The height in µm whose phase in air changes as fast with the wavelength as that of a relief of `height_um` under
    /// the cover, with the interference in the films.
    pub fn detail_um(&self, height_um: f64) -> f64 {
        let Some(stack) = &self.stack else { return height_um };
        let film = |(index, nm): &(Index, f64)| index.at(REFERENCE_NM).re * nm * 1e-3;
        height_um * stack.cover_index + stack.films.iter().map(film).sum::<f64>()
    }

    /// Radiance relative to a white diffuser, per unit of ρ: `4π² R0 σs²/λ0²`, λ0 = 550 nm, `sigma_um` the standard
    /// deviation of the coherence window there.
    pub fn diffuser_scale(&self, sigma_um: f64) -> f64 {
        let ratio = TAU * sigma_um / (REFERENCE_NM * 1e-3);
        self.normal * ratio * ratio
    }

    /// The same for a finite number of replicas without a window: `π R0 Ax Ay/λ0²`, with the sides of the whole surface
    /// in µm. Both scales are `π R0/(λ0² ∫|P|² df)` of a mirror.
    pub fn replica_diffuser_scale(&self, [x_um, y_um]: [f64; 2]) -> f64 {
        let area = x_um * y_um / (REFERENCE_NM * 1e-3).powi(2);
        PI * self.normal * area
    }

    /// Flags and constants of the template `gain`.
    pub fn define(&self, into: &mut Defines) {
        // below √2 some directions inside are steep enough for a shadow
        into.flag("SHADOWING", self.has_shadowing && self.cover_index() < SQRT_2);
        into.flag("MATERIAL", !self.is_plain());
        into.flag("COVER", self.is_covered());
        into.flag("DISPERSION", self.is_dispersive());
        into.flag("UNPOLARISED", self.is_mixed());
        into.flag("POLARISED", self.obliquity != Obliquity::Stam);
        into.flag("TRANSVERSE_ELECTRIC", self.obliquity == Obliquity::Te);
        into.flag("TRANSVERSE_MAGNETIC", self.obliquity == Obliquity::Tm);
        let index = "refractive index of the material, relative to air";
        into.number("REFRACTIVE_INDEX", self.refractive_index, index);
        let cover = "refractive index of the cover at 550 nm, relative to air";
        into.number("COVER_INDEX", self.cover_index(), cover);
    }

    /// Share of the light that crosses the cover's face twice, for each polarisation, or of both.
    fn crossed(&self, inside: &Inside) -> [f64; 2] {
        let Inside { wi, wr, above, n } = *inside;
        let [[si, pi], [sr, pr]] =
            [(above[0], wi.z), (above[1], wr.z)].map(|(out, cos)| transmittance(out, cos, n));
        match self.obliquity {
            Obliquity::Te | Obliquity::Tm => [si * sr, pi * pr],
            _ => [0.25 * (si + pi) * (sr + pr); 2],
        }
    }

    /// The gain without reflectance, for each polarisation.
    fn factor(&self, inside: &Inside) -> Factor {
        let Inside { wi, wr, above: [above, _], n } = *inside;
        let faces = if n == 1.0 { [1.0; 2] } else { self.crossed(inside) };
        let entry = if n == 1.0 { 1.0 } else { above / wi.z };
        let shadow = if self.has_shadowing { shadowing(wi, wr) } else { 1.0 };
        let [s, p] = obliquity(wi, wr, self.obliquity);
        Factor { s: s * entry * shadow * faces[0], p: p * entry * shadow * faces[1] }
    }

    /// Reflectances for unpolarised light in the mirror direction, from 0 to 1, at a wavelength in nm and an angle from the
    /// normal in air in degrees, at least 0 and below 90: of the relief alone, and as seen from outside, times the
    /// transmittances of the cover's face on both ways. Each factor is the mean of both polarisations, as in
    /// [`Matter::gain`]. Without a cover both are the same.
    pub fn seen_reflectances(&self, lambda_nm: f64, theta_deg: f64) -> [f64; 2] {
        let n = self.cover_at(lambda_nm);
        let (sin, outside) = theta_deg.to_radians().sin_cos();
        let inside = (1.0 - (sin / n).powi(2)).sqrt();
        let mean = |[s, p]: [f64; 2]| 0.5 * (s + p);
        let relief = mean(self.reflectances(lambda_nm, inside));
        [relief, relief * mean(transmittance(outside, inside, n)).powi(2)]
    }
}

/// The dielectric of a plan's defaults, in air.
impl Default for Matter {
    fn default() -> Matter {
        let refractive_index = 1.5;
        Matter {
            refractive_index,
            stack: None,
            obliquity: Obliquity::Stam,
            has_shadowing: true,
            normal: normal_reflectance(refractive_index),
        }
    }
}

/// Radiance relative to a white diffuser per unit of ρ, under the coherence window of the optics.
pub fn diffuser_scale(optics: &Optics) -> Result<f64> {
    Ok(Matter::new(optics)?.diffuser_scale(window_sigma_um(optics, REFERENCE_NM)))
}

/// The gain without reflectance, in parts for s and p polarisation.
struct Factor {
    s: f64,
    p: f64,
}

impl Factor {
    fn both(&self) -> f64 {
        self.s + self.p
    }
}

/// A pair of directions on the relief.
struct Inside {
    wi: DVec3,
    wr: DVec3,
    /// Cosines outside.
    above: [f64; 2],
    n: f64,
}

impl Inside {
    /// `None` where either direction is at or below the horizon.
    fn new(wi: DVec3, wr: DVec3, n: f64) -> Option<Inside> {
        let above = [wi.z, wr.z];
        if !above.iter().all(|cos| *cos > HORIZON) {
            return None;
        }
        let (wi, wr) = if n == 1.0 { (wi, wr) } else { (inside(wi, n), inside(wr, n)) };
        Some(Inside { wi, wr, above, n })
    }

    fn cos_half(&self) -> f64 {
        (self.wi + self.wr).normalize().dot(self.wr)
    }
}

impl Stack {
    fn reflectances(&self, lambda_nm: f64, cos_half: f64) -> [f64; 2] {
        let film = |(index, nm): &(Index, f64)| (index.at(lambda_nm), *nm);
        let films: Vec<(Complex64, f64)> = self.films.iter().map(film).collect();
        let above = self.cover.at(lambda_nm).re;
        reflectances(above, cos_half, &films, self.base.at(lambda_nm), lambda_nm)
    }
}

/// The direction inside a medium of index n.
fn inside(v: DVec3, n: f64) -> DVec3 {
    let plane = v.truncate() / n;
    plane.extend((1.0 - plane.length_squared()).max(0.0).sqrt())
}

/// Transmittances of the face of a medium of index n for s and p polarisation, from the cosines outside and inside
/// (Fresnel).
fn transmittance(outside: f64, inside: f64, n: f64) -> [f64; 2] {
    let s = (outside - n * inside) / (outside + n * inside);
    let p = (n * outside - inside) / (n * outside + inside);
    [1.0 - s * s, 1.0 - p * p]
}

/// Whole nm of a range, and its ends.
fn nodes(min_nm: f64, max_nm: f64) -> impl Iterator<Item = f64> {
    let count = (max_nm - min_nm).max(0.0).ceil() as usize;
    (0..=count).map(move |i| (min_nm + i as f64).min(max_nm))
}

/// The mean over the light, weighted by luminance.
fn mean(spectrum: &Spectrum, value: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut light) = (0.0, 0.0);
    for nm in nodes(TABLE_MIN_NM, TABLE_MAX_NM) {
        let [_, y, _] = spectrum.per_nm(nm);
        sum += y * value(nm);
        light += y;
    }
    sum / light
}

/// Notes about the media of a surface, under its light: wavelengths beyond their tables. Media that cannot be used have none;
/// [`Matter::new`] says why.
pub fn notes(optics: &Optics) -> Vec<String> {
    let Ok(spectrum) = Spectrum::new(&optics.illuminant) else { return Vec::new() };
    let media = optics.media().into_iter();
    media.filter_map(|(key, medium)| checked(key, medium, &spectrum).ok()?.1).collect()
}

/// The index of the medium of a key, and a note about it.
fn checked(key: &str, medium: &Medium, spectrum: &Spectrum) -> Result<(Index, Option<String>)> {
    let subject = format!("optics.{key} = {}", medium.name());
    let index = Index::new(&subject, medium)?;
    let note = beyond(&subject, &index, spectrum)?;
    Ok((index, note))
}

/// A note about light beyond the table of a medium. It is an error if there is more than a hundredth of X, Y or Z.
fn beyond(subject: &str, index: &Index, spectrum: &Spectrum) -> Result<Option<String>> {
    let Some([first, last]) = index.range_nm() else { return Ok(None) };
    let (mut all, mut lost) = ([0.0; 3], [0.0; 3]);
    for nm in nodes(TABLE_MIN_NM, TABLE_MAX_NM) {
        let weights = spectrum.per_nm(nm);
        let is_lost = !(first..=last).contains(&nm);
        for c in 0..3 {
            all[c] += weights[c];
            lost[c] += if is_lost { weights[c] } else { 0.0 };
        }
    }
    let most = (0..3).map(|c| lost[c] / all[c].max(f64::MIN_POSITIVE)).fold(0.0, f64::max);
    let range = format!("its table is from {first} to {last} nm");
    if most > MAX_BEYOND {
        let cause = format!("{range}: up to {:.1} % of a colour's light is beyond", 100.0 * most);
        let remedy = "extend the table, to 380 and 780 nm if possible";
        return Err(Error::new(subject, cause).remedy(remedy));
    }
    let ends = "beyond, the index of its nearest wavelength is used";
    let note =
        || format!("{subject}: {range}; {ends} (at most {:.2} % of X, Y or Z)", 100.0 * most);
    Ok((most > 0.0).then(note))
}

/// A cover must be transparent and denser than air.
fn check_cover(medium: &Medium, cover: &Index) -> Result<()> {
    let fail = |cause: String, remedy: &str| {
        let subject = format!("optics.cover_index = {}", medium.name());
        Err(Error::new(subject, cause).remedy(remedy))
    };
    for nm in nodes(TABLE_MIN_NM, TABLE_MAX_NM) {
        let Complex64 { re: n, im: k } = cover.at(nm);
        if k > MAX_COVER_K {
            let cause = format!("absorbs: k is {k:.1e} at {nm} nm, above {MAX_COVER_K:.0e}");
            return fail(
                cause,
                "use a transparent cover: how much another one takes depends on its thickness, which is not part of the model",
            );
        }
        if !(1.0..=4.0).contains(&n) {
            let cause = format!("has the index {n} at {nm} nm, which must be from 1 to 4");
            return fail(cause, "use the index of a transparent solid, or 1 for none");
        }
    }
    Ok(())
}
