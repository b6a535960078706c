//! Canonical names and hashes of configurations, the built-in preset, numbers of samples.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::hash::sha256;

use super::mode;
use super::variants::Draft;
use super::{Auto, Basis, Mode, Optics, Packing};
use super::{Reconstruction, Sampling, TableFormat, Variant, Wavelengths};

impl Variant {
    /// Name of the built-in preset.
    pub const TEXTS: &str = "texts";

    /// The shader as the texts print it, baseline of every speed claim: 31 `taylor-zero` terms, 3 × 3 bins,
    /// 380–780 nm by 5 nm, one complex term per texel, nothing hoisted.
    pub fn texts(optics: &Optics) -> Variant {
        Variant {
            name: Variant::TEXTS.to_owned(),
            mode: Mode::Full,
            basis: Basis::TaylorZero,
            terms: Auto::Value(31),
            term_error: 1e-3,
            reconstruction: Reconstruction::Window,
            window_radius: Auto::Value(1),
            periods: None,
            wavelengths: Wavelengths { min_nm: 380.0, max_nm: 780.0, step_nm: 5.0 },
            table: TableFormat::F32,
            packing: Packing::Single,
            bake_error: 0.5,
            bake_mib: 32.0,
            sampling: Sampling::Load,
            hoist: false,
            optics: optics.clone(),
        }
    }

    /// The configuration as one line of JSON with sorted keys: what the hash is of. The name is not in it, nor is
    /// anything that the variant does not read.
    pub fn canonical(&self) -> String {
        let waves = &self.wavelengths;
        let mut map: BTreeMap<&str, Value> = BTreeMap::from([
            ("mode", json!(self.mode)),
            ("basis", json!(self.basis)),
            ("terms", auto_value(self.terms)),
            ("window_radius", auto_value(self.window_radius)),
            ("min_nm", json!(waves.min_nm)),
            ("max_nm", json!(waves.max_nm)),
            ("table", json!(self.table)),
            ("packing", json!(self.packing)),
            ("hoist", json!(self.hoist)),
        ]);
        map.extend(self.optics.settings());
        if self.terms == Auto::Auto {
            map.insert("term_error", json!(self.term_error));
        }
        if waves.max_nm > waves.min_nm && self.mode != Mode::Adaptive {
            map.insert("step_nm", json!(waves.step_nm));
        }
        match (self.mode, self.periods) {
            (Mode::Pq, Some(periods)) => map.insert("periods", json!(periods)),
            (Mode::Pq, None) => map.insert("periods", json!("auto")),
            _ => None,
        };
        map.retain(|key, _| mode::reads(self.mode, self.periods.is_some(), key));
        if self.reconstruction == Reconstruction::Prefiltered {
            map.insert("reconstruction", json!(self.reconstruction));
            map.retain(|key, _| !["window_radius", "hoist"].contains(key));
        }
        if self.mode == Mode::Baked {
            map.insert("bake_error", json!(self.bake_error));
            map.insert("bake_mib", json!(self.bake_mib));
        }
        if self.reads_between() {
            map.insert("sampling", json!(self.sampling));
        }
        let pairs: Vec<String> =
            map.iter().map(|(key, value)| format!("\"{key}\":{value}")).collect();
        format!("{{{}}}", pairs.join(","))
    }

    /// Whether its wavelengths are those of its configuration, the same for every direction.
    pub fn has_uniform_wavelengths(&self) -> bool {
        mode::reads(self.mode, self.periods.is_some(), "step_nm")
    }

    /// Whether its shader reads what lies between the texels of a table, so that `sampling` means something.
    pub fn reads_between(&self) -> bool {
        mode::reads_between(self.mode, Some(self.reconstruction))
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
    /// The nodes of the integral, nm: `min`, `min + step`, …, and always `max`, so that the last interval is shorter
    /// where the step does not divide the range. A range of no width is one node.
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

/// The canonical name: mode, basis and terms, then every part that is read and differs from its documented default.
/// It depends on nothing but the configuration, and two configurations never share one.
pub(super) fn name_of(draft: &Draft) -> String {
    let standard = Draft::standard(Optics::standard());
    if draft.mode.1 == Some(Mode::Gems) {
        return draft.mode.0.to_owned();
    }
    let mut parts = vec![draft.mode.0.to_owned()];
    if draft.mode.1 != Some(Mode::Baked) {
        parts.extend([draft.basis.0.to_owned(), format!("t{}", auto(draft.terms))]);
    }
    let mut add = |present: bool, part: String| {
        if present {
            parts.push(part);
        }
    };
    let error_is_read = draft.terms == Auto::Auto;
    add(
        error_is_read && draft.term_error != standard.term_error,
        format!("e{}", exponent(draft.term_error)),
    );
    add(draft.reconstruction != standard.reconstruction, draft.reconstruction.0.to_owned());
    add(draft.window_radius != standard.window_radius, format!("r{}", auto(draft.window_radius)));
    if let Some([x, y]) = draft.periods {
        add(true, format!("q{x}x{y}"));
    }
    let waves = wavelengths(draft);
    add(waves != wavelengths(&Draft { mode: draft.mode, ..standard.clone() }), waves);
    add(draft.table != standard.table, draft.table.0.to_owned());
    add(draft.packing != standard.packing, draft.packing.as_str().to_owned());
    add(draft.sampling != standard.sampling, draft.sampling.as_str().to_owned());
    add(!draft.hoist, "nohoist".to_owned());
    add(draft.bake_error != standard.bake_error, format!("e{}", number(draft.bake_error)));
    add(draft.bake_mib != standard.bake_mib, format!("m{}", number(draft.bake_mib)));
    parts.extend(draft.optics.name_parts());
    parts.join("-")
}

fn auto_value(value: Auto<u32>) -> Value {
    match value {
        Auto::Value(n) => json!(n),
        Auto::Auto => json!("auto"),
    }
}

fn auto(value: Auto<u32>) -> String {
    match value {
        Auto::Value(n) => n.to_string(),
        Auto::Auto => "auto".to_owned(),
    }
}

fn wavelengths(draft: &Draft) -> String {
    let waves = &draft.wavelengths;
    let (min, max) = (number(waves.min_nm), number(waves.max_nm));
    match draft.mode.0 {
        "adaptive" | "baked" => format!("{min}to{max}"),
        _ if waves.max_nm <= waves.min_nm => format!("{min}nm"),
        _ => format!("{min}to{max}by{}", number(waves.step_nm)),
    }
}

/// A number in a file name: the decimal point is a `p`.
pub(super) fn number(x: f64) -> String {
    format!("{x}").replace('.', "p")
}

fn exponent(x: f64) -> String {
    format!("{x:e}").replace('.', "p")
}
