//! Rules that a module must satisfy to work in all targets and drivers, in addition to naga's checks.

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
        why: "naga appends `_` to names that end in a digit, so names would differ between targets",
        find: trailing_digits,
    },
    Lint {
        name: "resources",
        why: "WebGL2 does not support storage buffers and storage textures; separate samplers differ between targets, \
              so only the linear sampler is allowed, at its fixed binding and only in shaders that declare it",
        find: interface::resources,
    },
    Lint {
        name: "texture-count",
        why: "the API with the lowest limits guarantees only that many textures per stage",
        find: interface::texture_count,
    },
    Lint {
        name: "uniform-layout",
        why: "blocks that contain only vec4 and mat4x4 have the same layout in every language, and the API with the lowest \
              limits guarantees only that many bytes and blocks",
        find: interface::uniform_layout,
    },
    Lint {
        name: "texture-gather",
        why: "GLSL ES 3.00 does not support textureGather, but naga writes it without an error",
        find: fragment::gather,
    },
    Lint {
        name: "dynamic-indexing",
        why: "a variable with an array, vector or matrix that is indexed by a number known only at run time does not stay in \
              registers, and HLSL compilers reject such an index into constants; use a uniform array or a texture",
        find: fragment::dynamic_indices,
    },
    Lint {
        name: "fragment-struct",
        why: "some drivers store members of structs in fragment code in half precision; uniform blocks are exempt if their \
              members are read one by one",
        find: fragment::structs,
    },
];

/// The module that the rules examine.
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
        // predeclared types are not named in the text
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
        subject
            .locator
            .diagnostic(message, subject.locator.word(name))
            .help("rename it so that it ends in a letter")
    };
    bad.map(find).collect()
}
