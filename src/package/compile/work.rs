//! What a package is made of: surfaces, variants on them, and the gaps.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Mutex;

use crate::diagnostic::Diagnostic;
use crate::error::Error;
use crate::field::orders::OrderSum;
use crate::input::SurfaceInput;
use crate::package::Gap;
use crate::package::manifest::Energy;
use crate::plan::{Container, Optics, Target, Variant};
use crate::shader::template::Sources;
use crate::surface::{self, HeightField};
use crate::variant::{ExactProbe, Form, Ground};

use super::cache::Cache;
use super::identity;

/// What to generate.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    /// The surfaces, their files read.
    pub(super) surfaces: &'a [SurfaceInput],
    /// The variants; each on every surface that it is for, under the optics of the surface.
    pub(super) variants: &'a [Variant],
    /// Languages.
    pub(super) targets: &'a [Target],
    /// File forms of tables beside the raw texels.
    pub(super) containers: &'a [Container],
    /// Templates.
    pub(super) sources: &'a Sources,
    /// Finished tables.
    pub(super) cache: &'a Cache<'a>,
    /// Which files are left as they are in the output folder: by path and target.
    pub(super) keep: &'a (dyn Fn(&str, Target) -> bool + Sync),
    /// Bytes of memory that may be taken.
    pub(super) memory: u64,
    /// Fails once the caller has given up.
    pub(super) go_on: &'a (dyn Fn() -> Result<(), Error> + Sync),
}

impl Work<'_> {
    /// Bytes of all surfaces that are read.
    pub(super) fn held_bytes(&self) -> u64 {
        self.surfaces.iter().map(SurfaceInput::held_bytes).sum()
    }
}

/// The variants that are for a surface as they are there, and those that cannot be.
pub(super) fn placed(work: &Work<'_>, input: &SurfaceInput) -> (Vec<Variant>, Vec<Gap>) {
    let (mut variants, mut gaps) = (Vec::new(), Vec::new());
    for variant in work.variants {
        match variant.on(input.spec()) {
            Some(Ok(variant)) => variants.push(variant),
            Some(Err(error)) => gaps.push(gap(input, variant, &error)),
            None => {}
        }
    }
    (variants, gaps)
}

/// How each variant computes on the heights, and the gaps of those that have no form there.
pub(super) fn formed(
    input: &SurfaceInput,
    field: &HeightField,
    variants: Vec<Variant>,
) -> (Vec<(Variant, Form)>, Vec<Gap>) {
    let (mut formed, mut gaps) = (Vec::new(), Vec::new());
    for variant in variants {
        match Form::new(&variant, field) {
            Ok(form) => formed.push((variant, form)),
            Err(error) => gaps.push(gap(input, &variant, &error)),
        }
    }
    (formed, gaps)
}

fn gap(input: &SurfaceInput, variant: &Variant, reason: &Error) -> Gap {
    let (surface, variant) = (input.spec().name.clone(), variant.name.clone());
    Gap { surface, variant, reason: reason.to_string() }
}

/// A surface with its variants.
pub(super) struct Loaded<'a> {
    pub(super) input: &'a SurfaceInput,
    pub(super) field: &'a HeightField,
    pub(super) notes: &'a [String],
    /// As they are on this surface, and how they compute there.
    pub(super) variants: Vec<(Variant, Form)>,
    pub(super) gaps: Vec<Gap>,
    /// Probes with their exact colours by their identity, one for every set of optics.
    pub(super) exact: Mutex<BTreeMap<String, Vec<ExactProbe>>>,
    /// What it returns of all light by its identity. Empty if its orders need too much memory.
    energy: BTreeMap<String, Energy>,
}

impl Loaded<'_> {
    pub(super) fn name(&self) -> &str {
        &self.input.spec().name
    }

    pub(super) fn rotate_deg(&self) -> f64 {
        self.input.spec().rotate_deg
    }

    /// What it returns of all light under the optics of a variant.
    pub(super) fn energy(&self, optics: &Optics) -> Option<Energy> {
        self.energy.get(&identity::energy_id(self.input.identity(), optics)).cloned()
    }

    pub(super) fn ground(&self) -> Ground<'_> {
        Ground { surface: self.input.identity(), rotate_deg: self.rotate_deg() }
    }
}

/// Prepares the heights of all surfaces, or returns every error.
pub(super) fn load<'a>(work: &Work<'a>) -> Result<Vec<Loaded<'a>>, Vec<Diagnostic>> {
    let load = |input: &'a SurfaceInput| -> Result<Loaded<'a>, Vec<Diagnostic>> {
        let surface = input.surface().map_err(|e| vec![Diagnostic::from(&e)])?;
        let subject = surface::subject(input.spec());
        let mut errors = BTreeMap::new();
        let (variants, mut gaps) = placed(work, input);
        for variant in &variants {
            if let Err(error) = surface.field.check_pitch(&subject, variant.wavelengths.min_nm) {
                errors.insert(error.to_string(), Diagnostic::from(&error).variant(&variant.name));
            }
        }
        if !errors.is_empty() {
            return Err(errors.into_values().collect());
        }
        let (field, notes) = (&surface.field, surface.notes.as_slice());
        let (variants, never) = formed(input, field, variants);
        gaps.extend(never);
        let energy =
            energies(work, input, field, &variants).map_err(|e| vec![Diagnostic::from(&e)])?;
        Ok(Loaded { input, field, notes, variants, gaps, exact: Mutex::default(), energy })
    };
    all_or_errors(work.surfaces.iter().map(load).collect())
}

/// What a surface returns of all light, for each set of optics of its variants.
fn energies(
    work: &Work<'_>,
    input: &SurfaceInput,
    field: &HeightField,
    variants: &[(Variant, Form)],
) -> Result<BTreeMap<String, Energy>, Error> {
    let mut energies = BTreeMap::new();
    for (Variant { optics, .. }, form) in variants {
        if !OrderSum::has_white_sky(field, form.matter()) {
            continue;
        }
        (work.go_on)()?;
        let id = identity::energy_id(input.identity(), optics);
        let Entry::Vacant(place) = energies.entry(id) else { continue };
        let numbers = work.cache.numbers(place.key(), 12, || {
            let orders = OrderSum::new(field, input.spec().rotate_deg, optics)?;
            Ok(orders.white_sky().concat())
        })?;
        let colour = |view: usize| std::array::from_fn(|c| numbers[3 * view + c]);
        place.insert(Energy { white_sky: std::array::from_fn(colour) });
    }
    Ok(energies)
}

/// All values, or all errors of all results.
pub(super) fn all_or_errors<T>(
    results: Vec<Result<T, Vec<Diagnostic>>>,
) -> Result<Vec<T>, Vec<Diagnostic>> {
    let (mut values, mut errors) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(value) => values.push(value),
            Err(more) => errors.extend(more),
        }
    }
    if errors.is_empty() { Ok(values) } else { Err(errors) }
}
