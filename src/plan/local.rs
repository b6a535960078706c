//! Variants on a surface: a surface may have its own optics, and a preset may be for some surfaces only.

use serde::{Serialize, Serializer};

use crate::error::{Error, Result};

use super::item::Table;
use super::optics::OPTICS;
use super::variants::{read_each, stated};
use super::{Optics, Plan, Rejected, SurfaceSpec, Variant, constraints};

/// Light and material of one surface. They override `[optics]`. A preset or an axis that states a value overrides them.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceOptics {
    keys: Vec<&'static str>,
    values: Optics,
}

impl SurfaceOptics {
    /// Reads a table. All keys are optional.
    pub(super) fn read(table: &Table) -> SurfaceOptics {
        table.only(&OPTICS.map(|axis| axis.key));
        let mut variant = Variant::standard(&Optics::standard());
        read_each(table, OPTICS.iter(), &mut variant);
        SurfaceOptics { keys: stated(table), values: variant.optics }
    }

    /// Whether the surface has no optics of its own.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// The optics of a plan, overridden by those of the surface.
    pub fn over(&self, optics: &Optics) -> Optics {
        let mut variant = Variant::standard(optics);
        self.apply(&mut variant);
        variant.optics
    }

    /// The optics that the surface states. Keys that it does not state have their defaults.
    pub(crate) fn values_mut(&mut self) -> &mut Optics {
        &mut self.values
    }

    /// Sets the values that the variant does not state itself.
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

/// Serialises only the keys that the table has.
impl Serialize for SurfaceOptics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let own = Variant::standard(&self.values);
        let axes = OPTICS.iter().filter(|axis| self.keys.contains(&axis.key));
        serializer.collect_map(axes.map(|axis| (axis.key, axis.value(&own))))
    }
}

impl Variant {
    /// The variant on a surface, with the surface's own optics. `None` if the variant is not for that surface. It is an
    /// error if the combination has no meaning under these optics.
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
        let remedy = format!(
            "change the optics of surface \"{}\", or leave it out with the variant's key surfaces",
            surface.name
        );
        Some(Err(Error::new(&self.name, reasons.join("; ")).remedy(remedy)))
    }

    /// Whether the variant is for the surface of that name.
    pub fn is_for(&self, surface: &str) -> bool {
        self.surfaces.as_ref().is_none_or(|names| names.iter().any(|name| name == surface))
    }
}

impl Plan {
    /// The plan restricted to one of its surfaces: only that surface, with its optics as `[optics]` and the variants as
    /// they are there. Variants that are not for the surface, or are impossible under its optics, are listed as
    /// rejected.
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
                None => format!(
                    "is not for surface \"{}\"; see the variant's key surfaces",
                    surface.name
                ),
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
