//! Lists and opens adapters.

use diffraction_shaders::error::{Error, Result};

use super::backend::{AdapterInfo, Backend};
use super::guard::Shared;

/// The environment variable and its value that make Mesa's GL render to 32-bit float targets.
///
/// It must be set before the process loads the driver, so before the process starts.
pub const MESA_FLOAT_TARGETS: (&str, &str) =
    ("MESA_EXTENSION_OVERRIDE", "+GL_ARB_color_buffer_float");

/// All adapters of all backends.
pub(super) fn list() -> Vec<AdapterInfo> {
    Backend::ALL.into_iter().flat_map(list_of).collect()
}

/// The adapters of one backend.
pub(super) fn list_of(backend: Backend) -> Vec<AdapterInfo> {
    enumerate(backend).1.into_iter().map(|(info, _)| info).collect()
}

/// Opens the first adapter of `backend` that matches `wanted`.
pub(super) fn open(backend: Backend, wanted: Option<&str>) -> Result<Shared> {
    let (instance, found) = enumerate(backend);
    let Some((info, adapter)) = found.into_iter().find(|(info, _)| matches(info, wanted)) else {
        return Err(none(backend, wanted));
    };
    let features = adapter.get_texture_format_features(super::render::TARGET);
    if !features.allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT) {
        let error = Error::new(
            format!("{backend} adapter {info}"),
            "cannot render to 32-bit float targets",
        );
        let (name, value) = MESA_FLOAT_TARGETS;
        return Err(match backend {
            Backend::Gl => error.remedy(format!(
                "with Mesa, set {name}={value} in the environment before the program starts"
            )),
            _ => error.remedy("choose another adapter or backend"),
        });
    }
    let limits = adapter.limits();
    let request = adapter.request_device(&wgpu::DeviceDescriptor {
        label: None,
        // time stamps for the times of frames; unchanged SPIR-V, which does not affect shaders that wgpu translates
        required_features: adapter.features()
            & (wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::PASSTHROUGH_SHADERS),
        required_limits: limits.clone(),
        experimental_features: wgpu::ExperimentalFeatures::disabled(),
        memory_hints: wgpu::MemoryHints::MemoryUsage,
        trace: wgpu::Trace::Off,
    });
    let (device, queue) = pollster::block_on(request).map_err(|e| {
        Error::new(format!("{backend} adapter {info}"), "cannot open a device").source(e)
    })?;
    Ok(Shared::new(instance, device, queue, info, limits))
}

/// The adapters of one backend: graphics cards before software drivers, SwiftShader last, otherwise in the driver's order.
fn enumerate(backend: Backend) -> (wgpu::Instance, Vec<(AdapterInfo, wgpu::Adapter)>) {
    let backends = wgpu::Backends::from(backend.wgpu());
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        // WGPU_DEBUG, WGPU_VALIDATION and the like have an effect; there are no indirect draws to validate
        flags: wgpu::InstanceFlags::empty().with_env(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut adapters: Vec<_> = pollster::block_on(instance.enumerate_adapters(backends))
        .into_iter()
        .map(|adapter| {
            let info = adapter.get_info();
            let driver = match (info.driver.trim(), info.driver_info.trim()) {
                ("", "") => "unnamed driver".to_owned(),
                ("", one) | (one, "") => one.to_owned(),
                (driver, version) => format!("{driver} {version}"),
            };
            let rank = match info.device_type {
                wgpu::DeviceType::DiscreteGpu => 0,
                wgpu::DeviceType::IntegratedGpu => 1,
                wgpu::DeviceType::VirtualGpu => 2,
                wgpu::DeviceType::Other => 3,
                wgpu::DeviceType::Cpu if !info.name.contains("SwiftShader") => 4,
                // machines without a graphics card have two drivers; this is the slower one
                wgpu::DeviceType::Cpu => 5,
            };
            (rank, AdapterInfo { backend, name: info.name, driver }, adapter)
        })
        .collect();
    adapters.sort_by_key(|(rank, ..)| *rank);
    (instance, adapters.into_iter().map(|(_, info, adapter)| (info, adapter)).collect())
}

fn matches(info: &AdapterInfo, wanted: Option<&str>) -> bool {
    let Some(wanted) = wanted.map(str::to_lowercase) else { return true };
    [&info.name, &info.driver].iter().any(|text| text.to_lowercase().contains(&wanted))
}

fn none(backend: Backend, wanted: Option<&str>) -> Error {
    let cause = match wanted {
        Some(wanted) => format!("no adapter whose name contains '{wanted}'"),
        None => "no adapter".to_owned(),
    };
    let found = list();
    let listing: Vec<String> = Backend::ALL
        .into_iter()
        .filter(|b| {
            *b == backend || wgpu::Instance::enabled_backend_features().contains(b.wgpu().into())
        })
        .map(|b| {
            let names: Vec<String> = found
                .iter()
                .filter(|info| info.backend == b)
                .map(|info| info.to_string())
                .collect();
            format!("{b}: {}", if names.is_empty() { "none".to_owned() } else { names.join(", ") })
        })
        .collect();
    Error::new(backend, cause).remedy(format!(
        "this machine has {}; Debian's software drivers are mesa-vulkan-drivers libvulkan1 for vulkan, libegl1 libgles2 libgl1-mesa-dri for gl",
        listing.join("; ")
    ))
}
