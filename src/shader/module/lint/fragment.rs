//! Rules about the code of functions.

use std::collections::BTreeSet;

use naga::{
    Block, Expression, Function, Handle, ShaderStage, Statement, Type, TypeInner,
    valid::FunctionInfo,
};

use crate::diagnostic::Diagnostic;

use super::Linted;

/// No `textureGather` in any function.
pub fn gather(subject: &Linted) -> Vec<Diagnostic> {
    let functions = subject.ir.functions.iter().map(|(_, function)| function);
    let all = functions.chain(subject.ir.entry_points.iter().map(|entry| &entry.function));
    let spans = all.flat_map(|function| {
        let gathers = function.expressions.iter().filter(|(_, expression)| {
            matches!(expression, Expression::ImageSample { gather: Some(_), .. })
        });
        gathers.map(|(handle, _)| function.expressions.get_span(handle))
    });
    spans.map(|span| subject.locator.diagnostic("`textureGather` is used", span)).collect()
}

/// Indices that are known only at run time are allowed only into uniform blocks.
pub fn dynamic_indices(subject: &Linted) -> Vec<Diagnostic> {
    let functions = subject.ir.functions.iter().map(|(_, function)| function);
    let all = functions.chain(subject.ir.entry_points.iter().map(|entry| &entry.function));
    let spans = all.flat_map(|function| {
        let dynamic = function.expressions.iter().filter(|(_, expression)| {
            matches!(expression, Expression::Access { base, .. } if !is_global(function, *base))
        });
        dynamic.map(|(handle, _)| function.expressions.get_span(handle))
    });
    let find = |span| {
        let message = "a variable is indexed by a number known only at run time";
        subject
            .locator
            .diagnostic(message, span)
            .help("read a texture instead, or write a case for every index")
    };
    spans.map(find).collect()
}

/// Whether the accessed value is in a global variable.
fn is_global(function: &Function, expression: Handle<Expression>) -> bool {
    match function.expressions[expression] {
        Expression::GlobalVariable(_) => true,
        Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
            is_global(function, base)
        }
        Expression::Load { pointer } => is_global(function, pointer),
        _ => false,
    }
}

/// No value, variable, argument or result of struct type in functions that a fragment shader reaches.
pub fn structs(subject: &Linted) -> Vec<Diagnostic> {
    let mut reached = BTreeSet::new();
    let mut found = Vec::new();
    for (index, entry) in subject.ir.entry_points.iter().enumerate() {
        if entry.stage == ShaderStage::Fragment {
            callees(subject.ir, &entry.function.body, &mut reached);
            let info = subject.info.get_entry_point(index);
            found.extend(first_struct(subject, &entry.name, &entry.function, info));
        }
    }
    for handle in reached {
        let function = &subject.ir.functions[handle];
        let name = function.name.as_deref().unwrap_or_default();
        found.extend(first_struct(subject, name, function, &subject.info[handle]));
    }
    found.into_iter().map(|d| d.help("use separate vectors and numbers")).collect()
}

/// The first use of a struct in a function. One finding per function suffices.
fn first_struct(
    subject: &Linted,
    name: &str,
    function: &Function,
    info: &FunctionInfo,
) -> Option<Diagnostic> {
    let locator = subject.locator;
    if let Some(argument) = function.arguments.iter().find(|a| holds_struct(subject, a.ty)) {
        let argument = argument.name.as_deref().unwrap_or_default();
        let message = format!("argument `{argument}` of `{name}` is a struct");
        return Some(locator.diagnostic(message, locator.word(name)));
    }
    if function.result.as_ref().is_some_and(|result| holds_struct(subject, result.ty)) {
        let message = format!("the result of `{name}` is a struct");
        return Some(locator.diagnostic(message, locator.word(name)));
    }
    let mut locals = function.local_variables.iter();
    if let Some((handle, local)) = locals.find(|(_, local)| holds_struct(subject, local.ty)) {
        let local = local.name.as_deref().unwrap_or_default();
        let message = format!("variable `{local}` of `{name}` is a struct");
        return Some(locator.diagnostic(message, function.local_variables.get_span(handle)));
    }
    let (handle, _) = function.expressions.iter().find(|(handle, _)| {
        let inner = info[*handle].ty.inner_with(&subject.ir.types);
        matches!(inner, TypeInner::Struct { .. })
    })?;
    let message = format!("`{name}` uses a struct as a value");
    Some(locator.diagnostic(message, function.expressions.get_span(handle)))
}

fn holds_struct(subject: &Linted, ty: Handle<Type>) -> bool {
    match subject.ir.types[ty].inner {
        TypeInner::Struct { .. } => true,
        TypeInner::Array { base, .. } => holds_struct(subject, base),
        _ => false,
    }
}

/// Adds the functions that a block calls, and those that they call.
fn callees(ir: &naga::Module, block: &Block, reached: &mut BTreeSet<Handle<Function>>) {
    for statement in block {
        match statement {
            Statement::Call { function, .. } if reached.insert(*function) => {
                callees(ir, &ir.functions[*function].body, reached);
            }
            Statement::Block(inner) => callees(ir, inner, reached),
            Statement::If { accept, reject, .. } => {
                callees(ir, accept, reached);
                callees(ir, reject, reached);
            }
            Statement::Switch { cases, .. } => {
                cases.iter().for_each(|case| callees(ir, &case.body, reached));
            }
            Statement::Loop { body, continuing, .. } => {
                callees(ir, body, reached);
                callees(ir, continuing, reached);
            }
            _ => {}
        }
    }
}
