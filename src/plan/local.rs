//! Variants on a surface: its own optics, and presets that are for some surfaces only.

use serde::{Serialize, Serializer};

use crate::error::{Error, Result};

use super::item::Table;
use super::optics::OPTICS;
use super::variants::{read_each, stated};
use super::{Illuminant, Optics, Plan, Rejected, SurfaceSpec, Variant, constraints};

/// Light and material of one surface. They win over `[optics]`, and what a preset or an axis states wins over them.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceOptics {
    keys: Vec<&'static str>,
    values: Optics,
}

impl SurfaceOptics {
    /// Reads a table, in which no key is needed.
    pub(super) fn read(table: &Table) -> SurfaceOptics {
        table.only(&OPTICS.map(|axis| axis.key));
        let mut variant = Variant::standard(&Optics::standard());
        read_each(table, OPTICS.iter(), &mut variant);
        SurfaceOptics { keys: stated(table), values: variant.optics }
    }

    /// Whether the surface has none of its own.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// The optics of a plan with those of the surface.
    pub fn over(&self, optics: &Optics) -> Optics {
        let mut variant = Variant::standard(optics);
        self.apply(&mut variant);
        variant.optics
    }

    /// Its illuminant, if it has one of its own.
    pub(crate) fn illuminant_mut(&mut self) -> Option<&mut Illuminant> {
        self.keys.contains(&"illuminant").then_some(&mut self.values.illuminant)
    }

    /// Sets what the variant does not state itself.
    fn apply(&self, variant: &mut Variant) {
        let own = Variant::standard(&self.values);
        for axis in OPTICS.iter().filter(|axis| self.keys.contains(&axis.key)) {
            if !variant.stated.contains(&axis.key) {
                axis.copy(&own, variant);
            }
        }
    }
}

impl Default for SurfaceOptics {
    fn default() -> SurfaceOptics {
        SurfaceOptics { keys: Vec::new(), values: Optics::standard() }
    }
}

/// The keys that it has.
impl Serialize for SurfaceOptics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let own = Variant::standard(&self.values);
        let axes = OPTICS.iter().filter(|axis| self.keys.contains(&axis.key));
        serializer.collect_map(axes.map(|axis| (axis.key, axis.value(&own))))
    }
}

impl Variant {
    /// The variant as it is on a surface, under the surface's own optics; `None` where it is not for that surface. An error
    /// is a combination that has no meaning under those optics.
    pub fn on(&self, surface: &SurfaceSpec) -> Option<Result<Variant>> {
        if !self.is_for(&surface.name) {
            return None;
        }
        let mut variant = self.clone();
        if surface.optics.is_empty() {
            return Some(Ok(variant));
        }
        surface.optics.apply(&mut variant);
        constraints::normalise(&mut variant);
        let reasons: Vec<String> =
            constraints::broken(&variant).into_iter().map(|(_, r)| r).collect();
        if reasons.is_empty() {
            return Some(Ok(variant));
        }
        let remedy = format!("the optics of surface \"{}\" make it so", surface.name);
        Some(Err(Error::new(&self.name, reasons.join("; ")).remedy(remedy)))
    }

    /// Whether it is wanted on the surface of a name.
    pub fn is_for(&self, surface: &str) -> bool {
        self.surfaces.as_ref().is_none_or(|names| names.iter().any(|name| name == surface))
    }
}

impl Plan {
    /// The plan as it is on one of its surfaces: that surface alone, its optics as `[optics]`, and the variants as they are
    /// there. Those that are not for it, or cannot be under its optics, are among the rejected ones.
    #[must_use]
    pub fn on(&self, surface: &SurfaceSpec) -> Plan {
        let (mut variants, mut rejected) = (Vec::new(), self.rejected.clone());
        for variant in &self.variants {
            let reason = match variant.on(surface) {
                Some(Ok(variant)) => {
                    variants.push(variant);
                    continue;
                }
                Some(Err(error)) => error.to_string(),
                None => format!("is not for surface \"{}\", see its key surfaces", surface.name),
            };
            rejected.push(Rejected { name: variant.name.clone(), reason });
        }
        Plan {
            optics: surface.optics.over(&self.optics),
            surfaces: vec![surface.clone()],
            variants,
            rejected,
            ..self.clone()
        }
    }
}
