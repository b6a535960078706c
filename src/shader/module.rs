//! Parses, validates, lints and canonicalises a specialised shader.
//!
//! specialised text → parse → validate → lint → compact → write WGSL → parse → validate. All targets are emitted from
//! the last module, so they have the same names and expressions. The exception is the WGSL target, which is the
//! specialised text itself.

pub mod lint;
mod locate;
pub(in crate::shader) mod shell;

use std::collections::BTreeSet;

use naga::{
    back::wgsl,
    compact::{KeepUnused, compact},
    valid::{Capabilities, ModuleInfo, ValidationError, ValidationFlags, Validator},
};
use serde::Serialize;

use crate::diagnostic::Diagnostic;
use crate::shader::template::{Origin, Sources, Specialised};
use crate::tables::SAMPLER_NAME;
use crate::variant::{FUNCTIONS, Function};

use locate::Locator;

/// Shader stages that exist in every target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// Vertex.
    Vertex,
    /// Fragment.
    Fragment,
}

impl Stage {
    /// The stage in naga's terms.
    pub fn to_naga(self) -> naga::ShaderStage {
        match self {
            Stage::Vertex => naga::ShaderStage::Vertex,
            Stage::Fragment => naga::ShaderStage::Fragment,
        }
    }

    /// The stage from naga's terms. `None` for stages that do not exist in every target.
    pub fn from_naga(stage: naga::ShaderStage) -> Option<Stage> {
        match stage {
            naga::ShaderStage::Vertex => Some(Stage::Vertex),
            naga::ShaderStage::Fragment => Some(Stage::Fragment),
            _ => None,
        }
    }
}

/// What a module must define, and what it may use beyond the features common to all targets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contract {
    /// Entry points that must exist.
    pub entry_points: Vec<(String, Stage)>,
    /// Names of samplers that it may declare.
    pub samplers: BTreeSet<String>,
    /// Functions that it offers. The first must exist.
    pub functions: Vec<&'static str>,
}

impl Contract {
    /// The contract of a shipped shader: [`Contract::standard`] and the two stages of a mesh.
    pub fn package(functions: &[&'static dyn Function], filters: bool) -> Contract {
        let mut contract = Contract::standard(filters);
        contract.functions = function_names(functions);
        let mesh = [("mesh_vert", Stage::Vertex), ("mesh", Stage::Fragment)];
        contract.entry_points.extend(mesh.map(|(name, stage)| (name.to_owned(), stage)));
        contract
    }

    /// The contract of a shader that can be compared: entry points `vert`, `map` and `probe`, and the linear sampler if
    /// it `filters`.
    pub fn standard(filters: bool) -> Contract {
        let entry_points =
            [("vert", Stage::Vertex), ("map", Stage::Fragment), ("probe", Stage::Fragment)];
        Contract {
            entry_points: entry_points.map(|(name, stage)| (name.to_owned(), stage)).into(),
            samplers: filters.then(|| SAMPLER_NAME.to_owned()).into_iter().collect(),
            functions: function_names(&FUNCTIONS),
        }
    }
}

/// Names of functions in a shader's text, each followed by the name of the one that returns tristimulus values and of those that
/// belong to it.
pub fn function_names(functions: &[&'static dyn Function]) -> Vec<&'static str> {
    let names = |f: &&'static dyn Function| {
        let further = f.further(None).iter().map(|(name, _)| *name);
        [f.name(), f.tristimulus_name()].into_iter().chain(further)
    };
    functions.iter().flat_map(names).collect()
}

/// A valid shader in canonical form, with the text that it was parsed from.
#[derive(Clone, Debug)]
pub struct Module {
    name: String,
    functions: Vec<&'static str>,
    specialised: Specialised,
    ir: naga::Module,
    info: ModuleInfo,
}

impl Module {
    /// Name of the variant.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Names of the functions that the module offers.
    pub fn functions(&self) -> &[&'static str] {
        &self.functions
    }

    /// The specialised text, with its comments.
    pub fn text(&self) -> &str {
        &self.specialised.text
    }

    /// The template line of every line of [`Module::text`].
    pub fn origins(&self) -> &[Origin] {
        &self.specialised.origins
    }

    /// The canonical module, for reflection and emission.
    pub fn ir(&self) -> &naga::Module {
        &self.ir
    }

    /// The result of naga's validator for [`Module::ir`].
    pub fn info(&self) -> &ModuleInfo {
        &self.info
    }

    /// Name and stage of every entry point, in the order of the text.
    pub fn entry_points(&self) -> impl Iterator<Item = (&str, Stage)> {
        let entry_points = self.ir.entry_points.iter();
        entry_points.filter_map(|e| Some((e.name.as_str(), Stage::from_naga(e.stage)?)))
    }
}

/// Compiles a shader under [`Contract::standard`] without a sampler.
pub fn compile(
    specialised: &Specialised,
    sources: &Sources,
    variant: &str,
) -> Result<Module, Vec<Diagnostic>> {
    compile_with(specialised, sources, variant, &Contract::standard(false))
}

/// Compiles a shader under `contract`.
///
/// Errors of naga and of the [`lint`]s have the template line as primary place and the generated line as secondary place.
pub fn compile_with(
    specialised: &Specialised,
    sources: &Sources,
    variant: &str,
    contract: &Contract,
) -> Result<Module, Vec<Diagnostic>> {
    let locator = Locator::new(specialised, sources, variant);
    let mut ir = naga::front::wgsl::parse_str(&specialised.text)
        .map_err(|error| vec![parse_error(&error, &locator)])?;
    let info = validate(&ir).map_err(|error| vec![validation_error(&error, &locator)])?;
    let findings = lint::all(&ir, &info, contract, &locator);
    if !findings.is_empty() {
        return Err(findings);
    }
    // functions that only engines call must stay
    let offered = ir.functions.iter().filter(|(_, function)| {
        function.name.as_deref().is_some_and(|name| contract.functions.contains(&name))
    });
    let offered: Vec<_> = offered.map(|(handle, _)| handle).collect();
    let keeper = shell::shell(&ir, KEEPER, offered.into_iter());
    ir.entry_points.push(keeper);
    compact(&mut ir, KeepUnused::No);
    let (ir, info) = rewrite(&ir).map_err(|reason| {
        let message = format!("the shader cannot be brought into canonical form: {reason}");
        vec![Diagnostic::error(message).variant(variant)]
    })?;
    let functions = contract.functions.clone();
    Ok(Module { name: variant.to_owned(), functions, specialised: specialised.clone(), ir, info })
}

/// Name of an entry point that exists while unused functions are removed.
const KEEPER: &str = "keeper";

/// Validates with the features of every target: no capability beyond the core of WGSL.
fn validate(ir: &naga::Module) -> Result<ModuleInfo, Box<naga::WithSpan<ValidationError>>> {
    Ok(Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(ir)?)
}

/// Writes the module as WGSL with naga and parses it again, which fixes names and the order of expressions.
fn rewrite(compacted: &naga::Module) -> Result<(naga::Module, ModuleInfo), String> {
    let info = validate(compacted).map_err(|error| innermost(error.as_inner()))?;
    let text = wgsl::write_string(compacted, &info, wgsl::WriterFlags::empty())
        .map_err(|error| error.to_string())?;
    let mut ir =
        naga::front::wgsl::parse_str(&text).map_err(|error| error.emit_to_string(&text))?;
    ir.entry_points.retain(|entry| entry.name != KEEPER);
    restore_names(&mut ir);
    let info = validate(&ir).map_err(|error| innermost(error.as_inner()))?;
    Ok((ir, info))
}

/// Undoes the changes of naga's WGSL writer to names inside functions: it appends `_1`, `_2`, … to make them unique and
/// calls intermediate values `_e12`. No name in our templates ends in a digit, so such names are recognised by their
/// last digit. If they were kept, every target would have names such as `wi_1_` and `_e12_`.
fn restore_names(ir: &mut naga::Module) {
    let functions = ir.functions.iter_mut().map(|(_, function)| function);
    for function in functions.chain(ir.entry_points.iter_mut().map(|entry| &mut entry.function)) {
        let arguments = function.arguments.iter_mut().filter_map(|a| a.name.as_mut());
        let locals = function.local_variables.iter_mut().filter_map(|(_, l)| l.name.as_mut());
        arguments.chain(locals).for_each(without_suffix);
        function.named_expressions.retain(|_, name| {
            without_suffix(name);
            !name.is_empty() && name != "_e"
        });
    }
}

/// `wi_1` → `wi`, `_e12` → `_e`.
fn without_suffix(name: &mut String) {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    if stem.len() < name.len() {
        let length = stem.trim_end_matches('_').len();
        name.truncate(length);
    }
}

fn parse_error(error: &naga::front::wgsl::ParseError, locator: &Locator) -> Diagnostic {
    let mut labels = error.labels().filter(|(span, _)| span.is_defined());
    let first = labels.next();
    let span = first.map_or_else(naga::Span::default, |(span, _)| span);
    let mut diagnostic = locator.diagnostic(uncapitalised(error.message()), span);
    // most of naga's messages are complete; a label adds the type or the name that was found
    diagnostic
        .notes
        .extend(first.map(|(_, label)| label).filter(|l| !l.is_empty()).map(str::to_owned));
    for (span, label) in labels {
        let place = locator.place(span).map(|(place, _)| place);
        diagnostic.notes.push(match place {
            Some(place) => format!("{}:{}:{}: {label}", place.file, place.line, place.column),
            None => label.to_owned(),
        });
    }
    diagnostic.notes.extend(error.notes().map(str::to_owned));
    diagnostic
}

fn validation_error(error: &naga::WithSpan<ValidationError>, locator: &Locator) -> Diagnostic {
    let defined = error.spans().filter_map(|(span, _)| Some((span.to_range()?.len(), *span)));
    let smallest = defined.min_by_key(|(length, _)| *length);
    let span = match (smallest, error.as_inner()) {
        (Some((_, span)), _) => span,
        // such errors may have no span
        (
            None,
            ValidationError::Function { name, .. } | ValidationError::EntryPoint { name, .. },
        ) => locator.word(name),
        (None, _) => naga::Span::default(),
    };
    let chain = chain(error.as_inner());
    let message = chain.last().map_or_else(String::new, |text| uncapitalised(text));
    let mut diagnostic = locator.diagnostic(message, span);
    diagnostic.notes.extend(chain.iter().rev().skip(1).map(|text| uncapitalised(text)));
    diagnostic
}

fn innermost(error: &dyn std::error::Error) -> String {
    chain(error).pop().unwrap_or_default()
}

/// Texts of an error and of all its sources, outermost first.
fn chain(error: &dyn std::error::Error) -> Vec<String> {
    let mut texts = vec![error.to_string()];
    let mut beneath = error.source();
    while let Some(error) = beneath {
        texts.push(error.to_string());
        beneath = error.source();
    }
    texts
}

fn uncapitalised(text: &str) -> String {
    let mut characters = text.chars();
    match (characters.next(), characters.clone().next()) {
        (Some(first), Some(second)) if first.is_uppercase() && second.is_lowercase() => {
            first.to_lowercase().chain(characters).collect()
        }
        _ => text.to_owned(),
    }
}
