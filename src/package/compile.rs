//! From a plan to a complete package: every variant on every surface, all errors at once.
//!
//! Tables are shared by the variants of a surface that need the same one; their names are hashes of inputs. Work is
//! spread over the current thread pool; the package is the same for any number of threads.

mod build;
mod cache;
mod identity;
mod index;
mod step;
mod work;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::OnceLock;

use rayon::prelude::*;

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::error::Error;
use crate::input::{SurfaceInput, read_surfaces};
use crate::package::{Cancel, Equality, Gap, Package, readme};
use crate::plan::{Plan, Target, Variant};
use crate::shader::template::Sources;

use build::build;
use cache::Cache;
use index::{index, input_hash};
use work::{Work, all_or_errors, load};

pub use step::Step;

/// Version of naga, as pinned in `Cargo.toml`.
pub const NAGA_VERSION: &str = "30.0.1";

/// Compiles a plan: all of it, with the templates of this library, in memory and silently, unless asked otherwise. The front
/// page of this crate has an example.
pub struct Compiler<'a> {
    plan: &'a Plan,
    variants: Option<&'a [Variant]>,
    targets: Option<&'a [Target]>,
    rest: Option<&'a Path>,
    cache: Option<&'a Path>,
    templates: Sources,
    progress: &'a (dyn Fn(Step<'_>) + Sync),
    cancel: Cancel,
    surfaces: OnceLock<Vec<SurfaceInput>>,
}

impl<'a> Compiler<'a> {
    /// Everything that a plan asks for.
    pub fn new(plan: &'a Plan) -> Compiler<'a> {
        Compiler {
            plan,
            variants: None,
            targets: None,
            rest: None,
            cache: None,
            templates: Sources::builtin(),
            progress: &|_| (),
            cancel: Cancel::new(),
            surfaces: OnceLock::new(),
        }
    }

    /// Compiles these variants in place of the plan's.
    #[must_use]
    pub fn variants(self, variants: &'a [Variant]) -> Compiler<'a> {
        Compiler { variants: Some(variants), ..self }
    }

    /// Emits these languages in place of the plan's.
    #[must_use]
    pub fn targets(self, targets: &'a [Target]) -> Compiler<'a> {
        Compiler { targets: Some(targets), ..self }
    }

    /// Takes what is not compiled anew from the package in this folder: other variants of the plan, other languages.
    #[must_use]
    pub fn rest_from(self, folder: &'a Path) -> Compiler<'a> {
        Compiler { rest: Some(folder), ..self }
    }

    /// Keeps finished tables in this folder and takes them from there. Their names are hashes of what they are made from, and
    /// their content is verified.
    #[must_use]
    pub fn cache(self, folder: &'a Path) -> Compiler<'a> {
        Compiler { cache: Some(folder), ..self }
    }

    /// Calls a function with every step, from any thread.
    #[must_use]
    pub fn progress(self, progress: &'a (dyn Fn(Step<'_>) + Sync)) -> Compiler<'a> {
        Compiler { progress, ..self }
    }

    /// Gives up, with an error, soon after `cancel` is cancelled: before the next variant or table.
    #[must_use]
    pub fn cancel(self, cancel: &Cancel) -> Compiler<'a> {
        Compiler { cancel: cancel.clone(), ..self }
    }

    /// The surfaces of the plan, their files read once.
    pub fn surfaces(&self) -> Result<&[SurfaceInput], Diagnostics> {
        if let Some(surfaces) = self.surfaces.get() {
            return Ok(surfaces);
        }
        let surfaces = read_surfaces(&self.plan.surfaces)?;
        Ok(self.surfaces.get_or_init(|| surfaces))
    }

    /// SHA-256, hexadecimal, of everything that the package is made from but the program and the templates: surfaces with
    /// their files, variants with their illuminants, languages, containers of tables.
    pub fn input_hash(&self) -> Result<String, Diagnostics> {
        self.with_work(|work| Ok(input_hash(work)))
    }

    /// The package, with its index and its README; or every error.
    pub fn compile(&self) -> Result<Package, Diagnostics> {
        self.with_work(|work| {
            let mut package = generate(work, self.progress)?;
            let mut listed = work.variants.to_vec();
            let mut gaps = package.gaps.clone();
            if let Some(folder) = self.rest {
                let is_kept = |gap: &Gap| work.variants.iter().all(|v| v.name != gap.variant);
                gaps.extend(Gap::of_package(folder)?.into_iter().filter(is_kept));
                package.overlay(folder, |path| path != readme::FILE)?;
                let new =
                    listed.into_iter().filter(|variant| !self.plan.variants.contains(variant));
                listed = self.plan.variants.iter().cloned().chain(new).collect();
            }
            let index = index(&Work { variants: &listed, ..*work }, gaps)?;
            let readme = readme::readme(&package, &index, &self.plan.rejected)?;
            package.insert(readme::FILE, readme, Equality::Bytes)?;
            package.seal(index)?;
            Ok(package)
        })
    }

    fn with_work<T>(
        &self,
        run: impl FnOnce(&Work<'_>) -> Result<T, Diagnostics>,
    ) -> Result<T, Diagnostics> {
        let fresh = self.targets.unwrap_or(&self.plan.targets);
        // a manifest names all languages of the plan, whichever of them are written anew
        let all: BTreeSet<Target> = match self.rest {
            Some(_) => self.plan.targets.iter().chain(fresh).copied().collect(),
            None => fresh.iter().copied().collect(),
        };
        let targets: Vec<Target> = all.into_iter().collect();
        let keep = |path: &str, target: Target| {
            !fresh.contains(&target) && self.rest.is_some_and(|rest| rest.join(path).is_file())
        };
        let go_on = || match self.cancel.is_cancelled() {
            true => Err(Error::new("compilation", "was cancelled")),
            false => Ok(()),
        };
        run(&Work {
            surfaces: self.surfaces()?,
            variants: self.variants.unwrap_or(&self.plan.variants),
            targets: &targets,
            containers: &self.plan.containers,
            sources: &self.templates,
            cache: self.cache,
            keep: &keep,
            go_on: &go_on,
        })
    }
}

/// Everything but index and README.
fn generate(
    work: &Work<'_>,
    progress: &(dyn Fn(Step<'_>) + Sync),
) -> Result<Package, Vec<Diagnostic>> {
    let surfaces = load(work)?;
    Cache(work.cache).sweep();
    let mut gaps: Vec<Gap> = Vec::new();
    let mut pairs = Vec::new();
    for surface in &surfaces {
        gaps.extend(surface.gaps.iter().cloned());
        pairs.extend(surface.variants.iter().map(|variant| (surface, variant)));
    }
    let built = pairs.into_par_iter().map(|(s, v)| build(work, s, v));
    let mut built = all_or_errors(built.collect())?;
    // so that the variants that share a table come together, and one term table at a time is in memory
    built.sort_by_cached_key(|one| (one.surface.name().to_owned(), one.ids.clone()));
    let mut package = Package::new();
    let mut last = None;
    let mut errors = Vec::new();
    for one in built {
        (work.go_on)().map_err(|error| vec![Diagnostic::from(&error)])?;
        let label = format!("{} {}", one.surface.name(), one.variant.name);
        let baked = |columns, of| progress(Step::Baked { label: &label, columns, of });
        match one.insert(work, &mut package, &mut last, &baked) {
            Ok(gap) => gaps.extend(gap),
            Err(error) => errors.push(Diagnostic::from(&error).variant(&label)),
        }
        progress(Step::Finished(&label));
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    if package.files().is_empty() {
        let nothing = "nothing is left to generate";
        let error = match gaps.first() {
            Some(Gap { surface, reason, .. }) => {
                Error::new(format!("surface {surface}"), format!("{nothing}: {reason}"))
            }
            None => Error::new("plan", format!("{nothing}: no variant is for a surface"))
                .remedy("see the key surfaces of its presets"),
        };
        return Err(vec![Diagnostic::from(&error)]);
    }
    for surface in &surfaces {
        let notes = surface.notes.iter().map(|note| format!("{}: {note}", surface.name()));
        package.notes.extend(notes);
    }
    let left_out = gaps.iter().map(|gap| format!("{}: left out: {}", gap.surface, gap.reason));
    package.notes.extend(left_out);
    package.gaps = gaps;
    Ok(package)
}
