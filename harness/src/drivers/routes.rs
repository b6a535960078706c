//! Opens routes to drivers by name. A route is opened once and used for many variants.

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::runner::Runner;

use crate::process::watched::{self, Place};

use super::browser::{Api, Browser, Web};
use super::egl::{Dialect, Egl};
use super::gpu::{Backend, Gpu};
use super::passthrough::{Language, Passthrough};
use super::{Driver, DriverRunner, Prepared};

/// An open route to a driver.
pub trait Route {
    /// Name of the route, as in records.
    fn name(&self) -> String;

    /// A runner for a variant. Nothing is compiled yet.
    fn runner<'a>(&self, prepared: Prepared<'a>) -> Box<dyn Runner + 'a>;
}

impl<D: Driver + Clone + 'static> Route for D {
    fn name(&self) -> String {
        self.route()
    }

    fn runner<'a>(&self, prepared: Prepared<'a>) -> Box<dyn Runner + 'a> {
        Box::new(DriverRunner::with(prepared, self.clone()))
    }
}

/// The outcome of opening a route.
pub struct Found {
    /// Name of the route, or its kind if it could not be opened.
    pub name: String,
    /// The open route, or why it could not be opened.
    pub route: Result<Box<dyn Route>>,
}

/// Kinds of routes to drivers, in the order in which they are tried.
pub const KINDS: [&str; 8] =
    ["vulkan", "gl", "spirv", "hlsl", "glsl450", "glsl-es300", "webgpu", "webgl2"];

/// Opens every route of the wanted kinds, `KIND` or `KIND:SUBSTRING` with a part of the adapter's name; all kinds for an empty
/// list. A kind with several adapters gives one route for each. An unknown kind is an error.
pub fn open(wanted: &[String]) -> Result<Vec<Found>> {
    let mut found: Vec<Found> = Vec::new();
    let history = watched::child::history();
    // one browser for both routes
    let mut browser = None;
    let all: Vec<String> = KINDS.iter().map(ToString::to_string).collect();
    for wanted in if wanted.is_empty() { &all } else { wanted } {
        let (kind, adapter) = match wanted.split_once(':') {
            Some((kind, adapter)) => (kind, Some(adapter)),
            None => (wanted.as_str(), None),
        };
        // a kind whose adapters could not even be listed; single adapters are left out where they are opened
        if let Some(reason) = history.refusal(kind) {
            found.push(Found { name: wanted.clone(), route: Err(Error::new(wanted, reason)) });
            continue;
        }
        enter(kind);
        match kind {
            "vulkan" => found.extend(on_adapters(Backend::Vulkan, wanted, adapter, Ok)),
            "gl" => found.extend(on_adapters(Backend::Gl, wanted, adapter, Ok)),
            "spirv" => found.extend(untranslated(Language::Spirv, wanted, adapter)),
            "hlsl" => found.extend(untranslated(Language::Hlsl, wanted, adapter)),
            "glsl450" => found.push(one(wanted, Egl::open(Dialect::Glsl450, adapter))),
            "glsl-es300" => found.push(one(wanted, Egl::open(Dialect::GlslEs300, adapter))),
            "webgpu" => found.push(one(wanted, web(&mut browser, Api::WebGpu))),
            "webgl2" => found.push(one(wanted, web(&mut browser, Api::WebGl2))),
            _ => {
                return Err(Error::new(format!("route {kind}"), "is not a route")
                    .remedy(format!("one of {}", KINDS.join(", "))));
            }
        }
    }
    Ok(found)
}

fn web(browser: &mut Option<Browser>, api: Api) -> Result<Web> {
    let open = match browser.take() {
        Some(open) => open,
        None => Browser::open()?,
    };
    browser.insert(open).api(api)
}

fn untranslated(language: Language, wanted: &str, adapter: Option<&str>) -> Vec<Found> {
    on_adapters(Backend::Vulkan, wanted, adapter, |gpu| Passthrough::with(language, gpu))
}

/// Opens a route on each adapter of a backend.
fn on_adapters<R: Route + 'static>(
    backend: Backend,
    wanted: &str,
    adapter: Option<&str>,
    route: impl Fn(Gpu) -> Result<R>,
) -> Vec<Found> {
    let part = adapter.unwrap_or_default().to_lowercase();
    let mut names: Vec<String> = Gpu::adapters_of(backend)
        .into_iter()
        .filter(|info| info.name.to_lowercase().contains(&part))
        .map(|info| info.name)
        .collect();
    // two adapters of the same name are one route
    names.dedup();
    if names.is_empty() {
        // the error of opening lists the adapters and what to do
        return vec![one(wanted, Gpu::open(backend, adapter).and_then(route))];
    }
    let kind = wanted.split(':').next().unwrap_or_default();
    let open = |adapter: &String| {
        let name = format!("{kind}:{adapter}");
        if let Some(reason) = watched::child::history().refusal(&name) {
            return Found { route: Err(Error::new(&name, reason)), name };
        }
        enter(&name);
        one(wanted, Gpu::open(backend, Some(adapter.as_str())).and_then(&route))
    };
    names.iter().map(open).collect()
}

/// Says that a route is about to be opened.
fn enter(route: &str) {
    watched::child::enter(Place { route: route.to_owned(), ..Place::default() });
}

fn one<R: Route + 'static>(wanted: &str, opened: Result<R>) -> Found {
    match opened {
        Ok(route) => Found { name: route.name(), route: Ok(Box::new(route)) },
        Err(error) => Found { name: wanted.to_owned(), route: Err(error) },
    }
}
