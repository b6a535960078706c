//! The adapters that the options select.

use anyhow::Result;
use diffraction_shaders::error;

use crate::bench::driver::Group;
use crate::drivers::gpu::{AdapterInfo, Backend, Gpu};
use crate::process::watched::{self, Place};
use crate::results::Gap;

use super::output::Output;
use super::{Args, Interface};

/// All adapters that match. An interface without any is recorded as a gap.
pub(super) fn chosen(args: &Args, output: &mut Output<'_>) -> Result<Vec<AdapterInfo>> {
    let mut wanted: Vec<Backend> = args.backend.iter().map(|b| backend(*b)).collect();
    if wanted.is_empty() {
        wanted = vec![Backend::Vulkan, Backend::Gl];
    }
    let text = args.adapter.as_deref().unwrap_or_default().to_lowercase();
    let mut adapters = Vec::new();
    for backend in wanted {
        let fits = |info: &&AdapterInfo| {
            info.backend == backend && info.to_string().to_lowercase().contains(&text)
        };
        if watched::child::history().crashes.iter().any(|crash| crash.place.route == backend.name())
        {
            // recorded as a crash
            continue;
        }
        watched::child::enter(Place { route: backend.name().to_owned(), ..Place::default() });
        let found = Gpu::adapters_of(backend);
        let of_backend: Vec<AdapterInfo> = found.iter().filter(fits).cloned().collect();
        if of_backend.is_empty() {
            let reason = match Gpu::open(backend, args.adapter.as_deref()) {
                Ok(_) => "the driver listed no adapter".to_owned(),
                Err(error) => error.to_string(),
            };
            let route = backend.name().to_owned();
            output.gap(Gap { route, surface: None, variant: None, reason, failed: false })?;
        }
        adapters.extend(of_backend);
    }
    Ok(adapters)
}

/// Opens exactly this adapter, found by its name or by its driver.
pub(super) fn open(info: &AdapterInfo) -> error::Result<Gpu> {
    let by_name = Gpu::open(info.backend, Some(&info.name))?;
    if by_name.info() == info {
        return Ok(by_name);
    }
    let by_driver = Gpu::open(info.backend, Some(&info.driver))?;
    if by_driver.info() == info {
        return Ok(by_driver);
    }
    let subject = format!("{} adapter {info}", info.backend);
    Err(error::Error::new(subject, "another adapter has the same name and driver"))
}

/// States which clock is used on an adapter, and why.
pub(super) fn clock(info: &AdapterInfo, group: &Group) -> String {
    let why = match group.disagreement {
        None => "the driver has no time stamps".to_owned(),
        Some(apart) => {
            format!("its time stamps differ from the wall clock by at most {:.2} %", 100.0 * apart)
        }
    };
    format!("{} {info}: times by {}: {why}", info.backend, group.timing.name())
}

fn backend(interface: Interface) -> Backend {
    match interface {
        Interface::Vulkan => Backend::Vulkan,
        Interface::Gl => Backend::Gl,
        Interface::Metal => Backend::Metal,
        Interface::Dx12 => Backend::Dx12,
    }
}
