//! Some functions of a module, extracted into a module of their own.

use naga::{
    AddressSpace, Arena, Block, Handle, Span, Statement, TypeInner,
    compact::{KeepUnused, compact},
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use crate::shader::module::Module;
use crate::shader::module::shell::shell;
use crate::variant::HOSTS;

/// Name of the entry point that calls the functions.
pub const SHELL: &str = "main";

/// Functions with everything that they call, and an entry point that calls them.
pub struct Core {
    /// The requested functions that exist.
    pub names: Vec<String>,
    /// Functions that the host defines. In the modules they return zero.
    pub hosts: Vec<&'static str>,
    /// The module with the bindings of the templates.
    pub bound: naga::Module,
    /// The module without bindings, except those of samplers, which the writer of HLSL needs. Without bindings, writers
    /// keep the names of the templates and write no binding annotations.
    pub unbound: naga::Module,
    /// Validation result of `unbound`.
    pub info: ModuleInfo,
}

impl Core {
    /// The functions without the entry point.
    pub fn without_shell(&self) -> Result<(naga::Module, ModuleInfo), String> {
        let mut ir = self.unbound.clone();
        ir.entry_points.clear();
        let info = validate(&ir)?;
        Ok((ir, info))
    }
}

/// Extracts the functions with these names from a module. The first must exist. They may read textures and samplers,
/// but no other global.
pub fn extract(module: &Module, names: &[&str]) -> Result<Core, String> {
    let mut bound = module.ir().clone();
    let hosts = hollow(&mut bound);
    let find = |name: &&str| {
        let mut functions = bound.functions.iter();
        functions.find(|(_, f)| f.name.as_deref() == Some(*name)).map(|(handle, _)| handle)
    };
    let found: Vec<(&str, Handle<naga::Function>)> =
        names.iter().filter_map(|name| Some((*name, find(name)?))).collect();
    if found.first().map(|(name, _)| name) != names.first() {
        return Err(format!("there is no function `{}`", names.first().unwrap_or(&"")));
    }
    for (name, handle) in &found {
        let info = &module.info()[*handle];
        let read = bound.global_variables.iter().filter(|(global, _)| !info[*global].is_empty());
        let mut foreign = read.filter(|(_, global)| {
            let handle = global.space == AddressSpace::Handle;
            let inner = &bound.types[global.ty].inner;
            !(handle && matches!(inner, TypeInner::Image { .. } | TypeInner::Sampler { .. }))
        });
        if let Some((_, global)) = foreign.next() {
            let global = global.name.as_deref().unwrap_or_default();
            return Err(format!("`{name}` reads `{global}`, which is not a texture"));
        }
    }
    let shell = shell(&bound, SHELL, found.iter().map(|(_, handle)| *handle));
    bound.entry_points = vec![shell];
    compact(&mut bound, KeepUnused::No);
    let mut unbound = bound.clone();
    for (_, global) in unbound.global_variables.iter_mut() {
        if !matches!(unbound.types[global.ty].inner, TypeInner::Sampler { .. }) {
            global.binding = None;
        }
    }
    let info = validate(&unbound)?;
    let is_called = |host: &&str| {
        unbound.functions.iter().any(|(_, function)| function.name.as_deref() == Some(*host))
    };
    let hosts = hosts.into_iter().filter(|host| is_called(host)).collect();
    let names = found.into_iter().map(|(name, _)| name.to_owned()).collect();
    Ok(Core { names, hosts, bound, unbound, info })
}

/// Gives the functions of the host a body that returns zero. Returns their names.
fn hollow(ir: &mut naga::Module) -> Vec<&'static str> {
    let mut hosts = Vec::new();
    for (_, function) in ir.functions.iter_mut() {
        let name = function.name.as_deref();
        let Some(host) = HOSTS.into_iter().find(|host| name == Some(*host)) else { continue };
        hosts.push(host);
        let Some(result) = &function.result else { continue };
        let zero = naga::Expression::ZeroValue(result.ty);
        function.local_variables = Arena::new();
        function.named_expressions.clear();
        function.expressions = Arena::new();
        let value = function.expressions.append(zero, Span::UNDEFINED);
        function.body = Block::new();
        function.body.push(Statement::Return { value: Some(value) }, Span::UNDEFINED);
    }
    hosts
}

/// Validates like elsewhere, but globals need no bindings.
fn validate(ir: &naga::Module) -> Result<ModuleInfo, String> {
    let flags = ValidationFlags::all() - ValidationFlags::BINDINGS;
    let validated = Validator::new(flags, Capabilities::empty()).validate(ir);
    validated.map_err(|error| error.as_inner().to_string())
}
