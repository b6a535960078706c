//! Canonical names and hashes of configurations, and their wavelengths.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::hash::sha256;

use super::axis::Part;
use super::number::number;
use super::reads::{declares, reads};
use super::variant::{STEP_NM, axes};
use super::{LightFunction, Mode, Optics, Sampling, Variant, Wavelengths};

impl Variant {
    /// The configuration as one line of JSON with sorted keys. This is the text that is hashed. It contains neither the
    /// name nor keys that the variant does not read.
    pub fn canonical(&self) -> String {
        let entries = axes().flat_map(|axis| axis.entries);
        let map: BTreeMap<&str, Value> = entries
            .filter(|entry| reads(self, entry.key))
            .map(|entry| (entry.key, (entry.value)(self)))
            .collect();
        let pairs: Vec<String> =
            map.iter().map(|(key, value)| format!("\"{key}\":{value}")).collect();
        format!("{{{}}}", pairs.join(","))
    }

    /// Every key of a preset with its value, in the order of the product, whether the variant reads it or not.
    pub fn settings(&self) -> impl Iterator<Item = (&'static str, Value)> {
        axes().filter(|axis| !axis.is_alias()).map(|axis| (axis.key, axis.value(self)))
    }

    /// Whether it uses the configured wavelengths, the same for every direction.
    pub fn has_uniform_wavelengths(&self) -> bool {
        declares(self.mode, "step_nm")
    }

    /// Whether its shader interpolates between the texels of a table, so that `sampling` has an effect.
    pub fn reads_between(&self) -> bool {
        reads(self, "sampling")
    }

    /// Whether its shader has a function for a kind of light.
    pub fn has_function(&self, light: LightFunction) -> bool {
        let has_others = self.mode != Mode::Baked || light != LightFunction::Polygon;
        light == LightFunction::Direction
            || (has_others && reads(self, "lights") && self.lights.contains(&light))
    }

    /// Whether its shader reads a table through a linear filter.
    pub fn filters(&self) -> bool {
        self.reads_between() && self.sampling == Sampling::Filter
    }

    /// SHA-256 of [`Variant::canonical`], hexadecimal: the identity of the configuration.
    pub fn hash(&self) -> String {
        sha256(self.canonical().as_bytes())
    }
}

impl Wavelengths {
    /// The nodes of the integral, nm: `min`, `min + step`, …, and always `max`. The last interval is shorter if the
    /// step does not divide the range. A range with `min = max` is one node.
    pub fn nodes_nm(&self) -> Vec<f64> {
        let span = self.max_nm - self.min_nm;
        let whole = (span / self.step_nm + 1e-9).floor().max(0.0) as usize;
        let mut nodes: Vec<f64> =
            (0..=whole).map(|i| self.min_nm + i as f64 * self.step_nm).collect();
        match nodes.last_mut() {
            Some(last) if span > 0.0 && (self.max_nm - *last).abs() < 1e-6 * self.step_nm => {
                *last = self.max_nm
            }
            _ if span > 0.0 => nodes.push(self.max_nm),
            _ => nodes.truncate(1),
        }
        nodes
    }
}

/// The canonical name: mode, basis and terms, then every part that differs from its documented default. It depends only
/// on the configuration, and two different normalised configurations never have the same name.
pub(super) fn name_of(variant: &Variant) -> String {
    let standard = Variant::standard(&Optics::standard());
    let parts = axes().filter_map(|axis| match axis.part {
        Part::Always(part) => reads(variant, axis.key).then(|| part(variant)),
        Part::Alias => None,
        Part::Wavelengths => axis.differs(variant, &standard).then(|| range(variant)),
        Part::Changed(part) => axis.differs(variant, &standard).then(|| part(variant)),
    });
    parts.collect::<Vec<_>>().join("-")
}

/// The wavelengths in a name. The step is included if the mode has one and the range is more than a single wavelength.
fn range(variant: &Variant) -> String {
    let Wavelengths { min_nm, max_nm, step_nm } = variant.wavelengths;
    let (min, max) = (number(min_nm), number(max_nm));
    if !declares(variant.mode, STEP_NM) {
        return format!("{min}to{max}");
    }
    if max_nm <= min_nm {
        return format!("{min}nm");
    }
    format!("{min}to{max}by{}", number(step_nm))
}
