//! What a package is made of: surfaces, variants on them, and the gaps.

use std::collections::BTreeMap;
use std::sync::Mutex;

use crate::diagnostic::Diagnostic;
use crate::error::Error;
use crate::input::SurfaceInput;
use crate::package::Gap;
use crate::plan::{Container, Target, Variant};
use crate::shader::template::Sources;
use crate::surface::{self, HeightField};
use crate::variant::{ExactProbe, Form, Ground};

use super::cache::Cache;

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
    /// Fails once the caller has given up.
    pub(super) go_on: &'a (dyn Fn() -> Result<(), Error> + Sync),
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

/// Takes those out that have no form on the heights.
pub(super) fn formed(
    input: &SurfaceInput,
    field: &HeightField,
    variants: &mut Vec<Variant>,
) -> Vec<Gap> {
    let mut gaps = Vec::new();
    variants.retain(|variant| match Form::new(variant, field) {
        Ok(_) => true,
        Err(error) => {
            gaps.push(gap(input, variant, &error));
            false
        }
    });
    gaps
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
    /// As they are on this surface.
    pub(super) variants: Vec<Variant>,
    pub(super) gaps: Vec<Gap>,
    /// Probes with their exact colours by their identity, one for every set of optics.
    pub(super) exact: Mutex<BTreeMap<String, Vec<ExactProbe>>>,
}

impl Loaded<'_> {
    pub(super) fn name(&self) -> &str {
        &self.input.spec().name
    }

    pub(super) fn rotate_deg(&self) -> f64 {
        self.input.spec().rotate_deg
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
        let (mut variants, mut gaps) = placed(work, input);
        for variant in &variants {
            if let Err(error) = surface.field.check_pitch(&subject, variant.wavelengths.min_nm) {
                errors.insert(error.to_string(), Diagnostic::from(&error).variant(&variant.name));
            }
        }
        if !errors.is_empty() {
            return Err(errors.into_values().collect());
        }
        let (field, notes) = (&surface.field, surface.notes.as_slice());
        gaps.extend(formed(input, field, &mut variants));
        Ok(Loaded { input, field, notes, variants, gaps, exact: Mutex::default() })
    };
    all_or_errors(work.surfaces.iter().map(load).collect())
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
