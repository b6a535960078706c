//! Lamps in a panorama: small and bright spots, such as the sun and bulbs, found and taken out.
//!
//! A pixel of a map is wider than the sun, and what blurs a map blurs its lamps. As discs they keep their edge. What is taken out is a lamp's
//! excess over its surroundings, so that the integral over all directions stays what it is.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;

use super::{Environment, Panorama};
use crate::light::{Cap, Light};
use crate::optics::colour::luminance;

/// Angular radius of the widest lamp, degrees. Wider ones, such as softboxes and windows, stay in the map.
pub const MAX_LAMP_DEG: f64 = 5.0;

/// Most lamps that are taken out of one map: those with the most light.
pub const MAX_LAMPS: usize = 4;

/// The first threshold that is tried, over the mean luminance of the map.
const BRIGHT: f64 = 16.0;

/// A lamp without a given threshold is this many times as bright as its surroundings.
const CONTRAST: f64 = 4.0;

/// How many times the threshold is doubled.
const DOUBLINGS: u32 = 30;

/// A lamp's radius by the spread of its light is at most this many times that by its solid angle: longer ones are tubes.
const ROUND: f64 = 1.25;

/// Whether lamps are taken out of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampSearch {
    /// They stay in the map.
    None,
    /// The threshold is found: 16 times the mean luminance of the map, doubled where a bright spot is too wide to be a lamp.
    Auto,
    /// What is above this radiance (luminance, the map's scale included), if it is small enough.
    Above(f64),
}

/// A lamp that was taken out of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Where it is, in the frame of the light. The place of one that is smaller than a pixel is known to half a pixel.
    pub cap: Cap,
    /// Irradiance perpendicular to its axis, linear sRGB.
    pub irradiance: DVec3,
    /// Luminance above which it was found.
    pub threshold: f64,
}

impl Lamp {
    /// The lamp as a disc. Its irradiance is the luminance of the lamp's, its colour the rest.
    pub fn light(&self) -> Light {
        let irradiance = luminance(self.irradiance);
        let colour = self.irradiance / irradiance;
        // grey but for rounding
        let is_white = (colour - DVec3::ONE).abs().max_element() < 1e-5;
        let disc = Light::Disc { cap: self.cap, irradiance };
        if is_white { disc } else { disc.coloured(colour) }
    }
}

/// A map without its lamps.
#[derive(Clone, Debug, PartialEq)]
pub struct TakenOut {
    /// What stays.
    pub rest: Environment,
    /// The lamps, that with the most light first.
    pub lamps: Vec<Lamp>,
    /// The least luminance that was looked at.
    pub threshold: f64,
    /// Number of further lamps, which stay in the map.
    pub others: usize,
}

impl Environment {
    /// Takes lamps out of the map. `None` if they are not asked for.
    pub fn without_lamps(&self, search: LampSearch) -> Option<TakenOut> {
        let picture = Picture::new(&self.panorama);
        let (threshold, levels, contrast) = match search {
            LampSearch::None => return None,
            LampSearch::Auto => (BRIGHT * picture.mean(), DOUBLINGS, CONTRAST),
            LampSearch::Above(radiance) => (radiance / self.scale, 0, 1.0),
        };
        let mut found: Vec<Spot> = match threshold > 0.0 && threshold.is_finite() {
            true => picture.spots(threshold, levels, contrast),
            false => Vec::new(),
        };
        found.sort_by(|a, b| b.light().total_cmp(&a.light()));
        let mut rest = Panorama::clone(&self.panorama);
        let mut taken = Vec::new();
        for spot in found.iter().take(MAX_LAMPS) {
            // what an earlier one has taken of a pixel that both cover is gone
            let Some(spot) = Picture::new(&rest).spot(&spot.group, spot.threshold, 1.0, 0) else {
                continue;
            };
            for (place, kept) in &spot.kept {
                rest.texels[*place] = *kept;
            }
            taken.push(spot);
        }
        let others = found.len() - taken.len();
        let turned = |axis: DVec3| {
            let (sin, cos) = self.rotate_deg.to_radians().sin_cos();
            DVec3::new(cos * axis.x - sin * axis.y, sin * axis.x + cos * axis.y, axis.z)
        };
        let lamp = |spot: &Spot| Lamp {
            cap: Cap { axis: turned(spot.cap.axis), radius_rad: spot.cap.radius_rad },
            // the integral of a uniform disc's radiance is E·2/(1 + cos a)
            irradiance: self.scale * spot.integral * 0.5 * (1.0 + spot.cap.radius_rad.cos()),
            threshold: self.scale * spot.threshold,
        };
        Some(TakenOut {
            lamps: taken.iter().map(lamp).collect(),
            rest: Environment { panorama: Arc::new(rest), ..self.clone() },
            threshold: self.scale * threshold,
            others,
        })
    }
}

/// A lamp as it stands in a picture.
struct Spot {
    cap: Cap,
    /// Integral of its excess over the surroundings.
    integral: DVec3,
    threshold: f64,
    /// Its pixels above the threshold.
    group: Vec<usize>,
    /// Its pixels and those around, with what stays of them.
    kept: Vec<(usize, [f32; 3])>,
}

impl Spot {
    fn light(&self) -> f64 {
        luminance(self.integral)
    }
}

/// A panorama with what the search needs.
struct Picture<'a> {
    panorama: &'a Panorama,
    luminance: Vec<f64>,
    /// Of a pixel, by row.
    solid_angles: Vec<f64>,
}

impl<'a> Picture<'a> {
    fn new(panorama: &'a Panorama) -> Picture<'a> {
        let of_texel = |texel: &[f32; 3]| luminance(DVec3::from(texel.map(f64::from)));
        Picture {
            panorama,
            luminance: panorama.texels.iter().map(of_texel).collect(),
            solid_angles: panorama.solid_angles(),
        }
    }

    fn mean(&self) -> f64 {
        luminance(self.panorama.integral()) / (4.0 * PI)
    }

    fn part(&self, place: usize) -> f64 {
        self.solid_angles[place / self.panorama.width]
    }

    fn texel(&self, place: usize) -> DVec3 {
        DVec3::from(self.panorama.texels[place].map(f64::from))
    }

    /// Direction of the centre of a pixel.
    fn direction(&self, place: usize) -> DVec3 {
        let Panorama { width, height, .. } = *self.panorama;
        let (row, column) = ((place / width) as f64, (place % width) as f64);
        Panorama::direction([width, height], row + 0.5, column + 0.5)
    }

    /// The eight pixels around one. Columns go on at the other side, and all pixels of a row at a pole touch there.
    fn around(&self, place: usize) -> Vec<usize> {
        let Panorama { width, height, .. } = *self.panorama;
        let (row, column) = (place / width, place % width);
        let mut found = Vec::with_capacity(8);
        for near in row.saturating_sub(1)..=(row + 1).min(height - 1) {
            found.extend([width - 1, 0, 1].map(|c| near * width + (column + c) % width));
        }
        if row == 0 || row + 1 == height {
            found.extend(row * width..(row + 1) * width);
        }
        found.retain(|other| *other != place);
        found
    }

    /// Groups of touching pixels above a threshold, among these pixels.
    fn groups(&self, among: &[usize], threshold: f64) -> Vec<Vec<usize>> {
        let is_bright = |place: &&usize| self.luminance[**place] > threshold;
        let mut open: BTreeSet<usize> = among.iter().filter(is_bright).copied().collect();
        let mut groups = Vec::new();
        while let Some(first) = open.pop_first() {
            let mut group = vec![first];
            let mut next = 0;
            while let Some(place) = group.get(next) {
                group.extend(self.around(*place).into_iter().filter(|other| open.remove(other)));
                next += 1;
            }
            groups.push(group);
        }
        groups
    }

    /// All lamps above a threshold. Where a group is no lamp, up to `doublings` higher thresholds are tried within it.
    fn spots(&self, threshold: f64, doublings: u32, contrast: f64) -> Vec<Spot> {
        let is_bright = |place: &usize| self.luminance[*place] > threshold;
        let all = (0..self.luminance.len()).filter(is_bright).collect();
        let mut open: Vec<(Vec<usize>, f64, u32)> = vec![(all, threshold, 0)];
        let mut found = Vec::new();
        while let Some((among, threshold, level)) = open.pop() {
            for group in self.groups(&among, threshold) {
                match self.spot(&group, threshold, contrast, level) {
                    Some(spot) => found.push(spot),
                    None if level < doublings => open.push((group, 2.0 * threshold, level + 1)),
                    None => {}
                }
            }
        }
        found
    }

    /// A group as a lamp. `None` if it is too wide, too long, or too little above its surroundings; at a higher threshold, also if another
    /// group is near: then they are parts of something wide.
    fn spot(&self, group: &[usize], threshold: f64, contrast: f64, level: u32) -> Option<Spot> {
        let pixels: f64 = group.iter().map(|place| self.part(*place)).sum();
        let widest = 2.0 * PI * (1.0 - MAX_LAMP_DEG.to_radians().cos());
        // its edges may count by half
        if pixels > 2.0 * widest {
            return None;
        }
        // pixels that it covers in part lie around it; its surroundings lie two pixels further out
        let core: BTreeSet<usize> = group.iter().copied().collect();
        let whole = self.grown(&core);
        let ring = self.grown(&self.grown(&whole));
        let is_dark = |place: &usize| self.luminance[*place] <= threshold;
        let ring: Vec<usize> = ring.difference(&whole).copied().collect();
        let dark: Vec<usize> = ring.iter().copied().filter(is_dark).collect();
        let mean = |places: &[usize]| {
            let parts: f64 = places.iter().map(|place| self.part(*place)).sum();
            places.iter().map(|place| self.part(*place) * self.texel(*place)).sum::<DVec3>() / parts
        };
        if dark.is_empty() || level > 0 && dark.len() < ring.len() {
            return None;
        }
        let beside = mean(&dark);
        if luminance(mean(group)) < contrast * luminance(beside) {
            return None;
        }
        let (mut integral, mut towards, mut light, mut squares) =
            (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
        let mut kept = Vec::new();
        for place in &whole {
            let texel = self.panorama.texels[*place];
            let below = beside.as_vec3().to_array();
            let stays: [f32; 3] = std::array::from_fn(|c| texel[c].min(below[c]));
            let excess = self.texel(*place) - DVec3::from(stays.map(f64::from));
            let (part, bright) = (self.part(*place), luminance(excess));
            integral += part * excess;
            towards += part * bright * self.direction(*place);
            light += part * bright;
            squares += part * bright * bright;
            kept.push((*place, stays));
        }
        let axis = towards.try_normalize()?;
        let spread = whole.iter().zip(&kept).map(|(place, (_, stays))| {
            let excess = self.texel(*place) - DVec3::from(stays.map(f64::from));
            let away = (self.direction(*place) - axis).length_squared();
            self.part(*place) * luminance(excess) * away
        });
        // a uniform disc has half its squared radius; a pixel adds a twelfth of its squared sides
        let high = PI / self.panorama.height as f64;
        let wide = TAU / self.panorama.width as f64 * axis.truncate().length();
        let squared = 2.0 * (spread.sum::<f64>() / light - (high * high + wide * wide) / 12.0);
        let radius_rad = squared.max(0.0).sqrt().max(0.25 * high);
        let by_angle = (light * light / squares / PI).sqrt();
        let is_round = radius_rad <= ROUND * by_angle;
        let is_small = radius_rad <= MAX_LAMP_DEG.to_radians();
        let cap = Cap { axis, radius_rad };
        let group = group.to_vec();
        let spot = Spot { cap, integral, threshold, group, kept };
        (is_round && is_small).then_some(spot)
    }

    /// Pixels, and those around them.
    fn grown(&self, pixels: &BTreeSet<usize>) -> BTreeSet<usize> {
        let around = pixels.iter().flat_map(|place| self.around(*place));
        around.chain(pixels.iter().copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::environment::Studio;
    use crate::optics::direction;

    /// A lamp of a test: angles of its middle, angular radius in degrees, radiance.
    type Placed = ([f64; 2], f64, DVec3);

    /// A dim coloured sky with lamps; each pixel is a mean.
    fn map(lamps: &[Placed], width: usize) -> Arc<Panorama> {
        let height = width / 2;
        let texel = |i: usize| {
            let mut sum = DVec3::ZERO;
            for place in 0..64 {
                let part = |at: usize| (at as f64 + 0.5) / 8.0;
                let theta = ((i / width) as f64 + part(place / 8)) / height as f64 * 180.0;
                let phi = ((i % width) as f64 + part(place % 8)) / width as f64 * 360.0 - 180.0;
                let wi = direction(theta, phi);
                let lamp = lamps.iter().find(|([theta, phi], radius, _)| {
                    wi.angle_between(direction(*theta, *phi)) < radius.to_radians()
                });
                let sky = DVec3::new(0.3, 0.4, 0.6) * (1.0 + 0.5 * wi.x);
                sum += lamp.map_or(sky, |(.., radiance)| *radiance);
            }
            (sum / 64.0).as_vec3().to_array()
        };
        let texels = (0..width * height).map(texel).collect();
        Arc::new(Panorama { width, height, texels })
    }

    fn around(panorama: Arc<Panorama>) -> Environment {
        Environment { panorama, scale: 2.0, rotate_deg: 25.0 }
    }

    /// Integral over all directions of what stays and of the lamps as discs.
    fn whole(taken: &TakenOut) -> DVec3 {
        let disc = |lamp: &Lamp| {
            let radius = lamp.cap.radius_rad;
            let radiance = lamp.irradiance / (PI * radius.sin().powi(2));
            radiance * 2.0 * PI * (1.0 - radius.cos())
        };
        let lamps = taken.lamps.iter().map(disc).sum::<DVec3>();
        taken.rest.scale * taken.rest.panorama.integral() + lamps
    }

    #[test]
    fn solid_angles_are_those_of_the_interpolation() {
        for (width, height) in [(1, 1), (8, 4), (512, 256)] {
            let mut panorama = Panorama { width, height, texels: vec![[1.0; 3]; width * height] };
            let all = panorama.integral();
            assert!((all.x / (4.0 * PI) - 1.0).abs() < 1e-12, "{width}: {all}");
            if width == 8 {
                panorama.texels[3] = [5.0; 3];
                panorama.texels[20] = [7.0; 3];
                let (steps, mut sum) = (2000, 0.0);
                for theta in (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps) * PI) {
                    for phi in (0..800).map(|i| (f64::from(i) + 0.5) / 400.0 * PI - PI) {
                        sum += theta.sin() * panorama.at(theta, phi).x;
                    }
                }
                sum *= PI / f64::from(steps) * PI / 400.0;
                assert!((panorama.integral().x / sum - 1.0).abs() < 1e-5, "{sum}");
            }
        }
    }

    /// At the seam, at both poles, in the middle; of one pixel and of several; with the map's turn and scale.
    #[test]
    fn lamps_are_found_where_they_are_and_no_light_is_lost() {
        let warm = DVec3::new(900.0, 700.0, 400.0);
        let cases: [(&str, Vec<Placed>); 6] = [
            ("middle", vec![([50.0, 70.0], 2.0, warm)]),
            ("seam", vec![([80.0, 179.7], 3.0, warm)]),
            ("pole", vec![([1.0, -60.0], 2.5, warm)]),
            ("other pole", vec![([179.9, 10.0], 4.0, warm)]),
            ("sun", vec![([35.0, -110.0], 0.265, 100.0 * warm)]),
            ("two", vec![([60.0, 20.0], 3.0, 3.0 * warm), ([63.0, 28.0], 2.0, warm)]),
        ];
        for (name, lamps) in cases {
            let environment = around(map(&lamps, 512));
            let before = environment.scale * environment.panorama.integral();
            for search in [LampSearch::Auto, LampSearch::Above(40.0)] {
                let taken = environment.without_lamps(search).unwrap();
                assert_eq!(
                    (taken.lamps.len(), taken.others),
                    (lamps.len(), 0),
                    "{name}: {taken:?}"
                );
                let off = (whole(&taken) / before - DVec3::ONE).abs().max_element();
                println!("{name} {search:?}: energy {off:.1e}, threshold {}", taken.threshold);
                assert!(off < 1e-4, "{name}: {off}");
                // one lamp more or less is noticed
                let without = TakenOut { lamps: Vec::new(), ..taken.clone() };
                assert!(
                    (whole(&without) / before - DVec3::ONE).abs().max_element() > 0.05,
                    "{name}"
                );
                for (found, ([theta, phi], radius, radiance)) in taken.lamps.iter().zip(&lamps) {
                    let away = found.cap.axis.angle_between(direction(*theta, phi + 25.0));
                    let width = found.cap.radius_rad.to_degrees() / radius;
                    // 2 is the map's scale; the sky behind stays
                    let sine = radius.to_radians().sin();
                    let expected = 2.0 * *radiance * PI * sine * sine;
                    let colour = (found.irradiance / expected - DVec3::ONE).abs().max_element();
                    println!(
                        "  {:.4}° away, width {width:.3}, colour {colour:.1e}",
                        away.to_degrees()
                    );
                    // what is smaller than a pixel may stand anywhere in it; a pole's pixels meet, so that what lies between
                    // their centres is no mean
                    let allowed = match name {
                        "sun" => [0.35, 0.5, 0.06],
                        "pole" | "other pole" => [0.02, 0.04, 0.025],
                        _ => [0.02, 0.04, 0.005],
                    };
                    let errors = [away.to_degrees(), (width - 1.0).abs(), colour];
                    assert!((0..3).all(|i| errors[i] < allowed[i]), "{name}: {errors:?} {found:?}");
                }
                let most = taken.rest.panorama.texels.iter().flatten().copied();
                assert!(most.fold(0.0, f32::max) < 1.0, "{name}: something stays");
            }
        }
    }

    #[test]
    fn what_is_wide_or_long_or_even_stays() {
        let bright = DVec3::splat(500.0);
        let wide = around(map(&[([60.0, 20.0], 6.5, bright)], 256));
        let taken = wide.without_lamps(LampSearch::Auto).unwrap();
        assert_eq!((taken.lamps.len(), &taken.rest), (0, &wide));
        // a tube
        let tube = |i: i32| ([70.0, 10.0 + f64::from(i)], 0.8, bright);
        let tube = around(map(&(0..10).map(tube).collect::<Vec<_>>(), 256));
        assert!(tube.without_lamps(LampSearch::Auto).unwrap().lamps.is_empty());
        for (word, studio) in Studio::WORDS {
            let studio = around(Arc::new(studio.panorama(256)));
            let taken = studio.without_lamps(LampSearch::Auto).unwrap();
            assert!(taken.lamps.is_empty() && taken.others == 0, "{word}: {:?}", taken.lamps);
        }
        // a sun in a bright haze that is wider than a lamp: the threshold rises until it is alone
        let sun = ([40.0, 30.0], 1.0, DVec3::splat(4e4));
        let hazy = around(map(&[sun, ([40.0, 30.0], 9.0, DVec3::splat(900.0))], 256));
        let taken = hazy.without_lamps(LampSearch::Auto).unwrap();
        assert_eq!(taken.lamps.len(), 1);
        assert!(taken.lamps[0].threshold > 1.5 * taken.threshold, "{taken:?}");
        assert!((taken.lamps[0].cap.radius_rad.to_degrees() - 1.0).abs() < 0.05, "{taken:?}");
        assert_eq!(hazy.without_lamps(LampSearch::None), None);
    }

    #[test]
    fn only_the_strongest_are_taken_and_the_rest_is_counted() {
        let lamp = |i: i32| {
            let radiance = 300.0 * (1.0 + f64::from((i * 5) % 7));
            ([40.0 + 7.0 * f64::from(i), 50.0 * f64::from(i)], 1.5, DVec3::splat(radiance))
        };
        let environment = around(map(&(0..7).map(lamp).collect::<Vec<_>>(), 256));
        let before = 2.0 * environment.panorama.integral();
        let taken = environment.without_lamps(LampSearch::Auto).unwrap();
        assert_eq!((taken.lamps.len(), taken.others), (MAX_LAMPS, 3));
        assert!((whole(&taken) / before - DVec3::ONE).abs().max_element() < 1e-4);
        let light = |lamp: &Lamp| lamp.irradiance.x;
        assert!(taken.lamps.windows(2).all(|pair| light(&pair[0]) > light(&pair[1])));
        let Light::Disc { .. } = taken.lamps[0].light() else {
            // the sky behind is coloured, so that what is above it is, too
            return assert!(matches!(taken.lamps[0].light(), Light::Coloured { .. }));
        };
    }
}
