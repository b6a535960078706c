//! What all targets and drivers can take, beyond what naga checks.

mod fragment;
mod interface;

use std::collections::BTreeSet;

use naga::valid::ModuleInfo;

use crate::diagnostic::Diagnostic;

use super::{Contract, locate::Locator};

/// One rule over a valid module.
pub struct Lint {
    /// Short name, shown with each finding.
    pub name: &'static str,
    /// Why the rule exists.
    pub why: &'static str,
    find: fn(&Linted) -> Vec<Diagnostic>,
}

/// All rules, in the order in which they are applied.
pub const LINTS: &[Lint] = &[
    Lint {
        name: "entry-points",
        why: "packages name their files and their manifest after the entry points, and only vertex and fragment \
              stages exist in every target",
        find: interface::entry_points,
    },
    Lint {
        name: "trailing-digit",
        why: "naga appends `_` to names that end in a digit, so that targets would disagree about them",
        find: trailing_digits,
    },
    Lint {
        name: "resources",
        why: "WebGL2 has no storage buffers and no storage textures; separate samplers differ between the targets, \
              so there is none but the linear one at its place, and that only where it has been declared",
        find: interface::resources,
    },
    Lint {
        name: "texture-count",
        why: "the narrowest API guarantees that many textures in a stage",
        find: interface::texture_count,
    },
    Lint {
        name: "uniform-layout",
        why: "blocks of nothing but vec4 and mat4 have the same layout in every language, and the narrowest API \
              guarantees that many bytes and blocks",
        find: interface::uniform_layout,
    },
    Lint {
        name: "texture-gather",
        why: "GLSL ES 3.00 has no textureGather, and naga writes it without an error",
        find: fragment::gather,
    },
    Lint {
        name: "dynamic-indexing",
        why: "an array, vector or matrix in a variable that is indexed by a number known only at run time spills out of \
              registers, and compilers of HLSL reject it in constants; uniform arrays and textures are the places for that",
        find: fragment::dynamic_indices,
    },
    Lint {
        name: "fragment-struct",
        why: "some drivers keep members of structs in fragment code in half precision; uniform blocks are exempt as \
              long as their members are read one by one",
        find: fragment::structs,
    },
];

/// What the rules look at.
pub(super) struct Linted<'a> {
    ir: &'a naga::Module,
    info: &'a ModuleInfo,
    contract: &'a Contract,
    locator: &'a Locator<'a>,
}

/// All findings of all rules.
pub(super) fn all(
    ir: &naga::Module,
    info: &ModuleInfo,
    contract: &Contract,
    locator: &Locator,
) -> Vec<Diagnostic> {
    let subject = Linted { ir, info, contract, locator };
    let findings = LINTS.iter().flat_map(|lint| {
        let explain = |d: Diagnostic| d.note(format!("rule {}: {}", lint.name, lint.why));
        (lint.find)(&subject).into_iter().map(explain)
    });
    findings.collect()
}

fn trailing_digits(subject: &Linted) -> Vec<Diagnostic> {
    let ir = subject.ir;
    let mut names = BTreeSet::new();
    names.extend(ir.global_variables.iter().filter_map(|(_, global)| global.name.as_deref()));
    names.extend(ir.constants.iter().filter_map(|(_, constant)| constant.name.as_deref()));
    names.extend(ir.overrides.iter().filter_map(|(_, constant)| constant.name.as_deref()));
    for (_, ty) in ir.types.iter() {
        // predeclared types have no name of their own
        names.extend(ty.name.as_deref());
        if let naga::TypeInner::Struct { members, .. } = &ty.inner {
            names.extend(members.iter().filter_map(|member| member.name.as_deref()));
        }
    }
    let functions = ir.functions.iter().map(|(_, function)| function);
    for function in functions.chain(ir.entry_points.iter().map(|entry| &entry.function)) {
        names.extend(function.name.as_deref());
        names.extend(function.arguments.iter().filter_map(|argument| argument.name.as_deref()));
        names
            .extend(function.local_variables.iter().filter_map(|(_, local)| local.name.as_deref()));
        names.extend(function.named_expressions.values().map(String::as_str));
    }
    names.extend(ir.entry_points.iter().map(|entry| entry.name.as_str()));
    let bad = names.into_iter().filter(|name| name.ends_with(|c: char| c.is_ascii_digit()));
    let find = |name| {
        let message = format!("name `{name}` ends in a digit");
        subject.locator.diagnostic(message, subject.locator.word(name)).help("end it in a letter")
    };
    bad.map(find).collect()
}
