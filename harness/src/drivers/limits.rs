//! Known limits of drivers that make a right shader give wrong colours without an error: one table.

use diffraction_shaders::shader::specialise::texels_per_step;

use super::driver::Prepared;

/// A limit that a driver keeps without a word.
struct Limit {
    /// Kinds of the routes that it is about.
    routes: &'static [&'static str],
    /// Whether only Mesa's software drivers have it.
    is_mesas: bool,
    /// What is counted.
    counted: fn(&Prepared<'_>) -> u64,
    /// The number above which results are wrong.
    max: u64,
    /// What the driver does, and what helps. Of the number there.
    says: fn(u64) -> String,
}

/// Routes on OpenGL.
const GL: &[&str] = &["gl", "glsl450", "glsl-es300"];

const LIMITS: [Limit; 3] = [
    Limit {
        routes: &["gl", "glsl450", "glsl-es300", "vulkan", "spirv", "hlsl"],
        is_mesas: true,
        counted: loop_steps,
        max: 65_535,
        says: |steps| {
            format!(
                "Mesa's software drivers (llvmpipe, lavapipe) end the loops of a pixel after 65535 steps in all, and this \
                 shader takes about {steps}: use a larger step_nm, fewer terms, a smaller window_radius, or another driver"
            )
        },
    },
    Limit {
        routes: GL,
        is_mesas: false,
        counted: table_bytes,
        max: 1 << 30,
        says: |bytes| {
            format!(
                "OpenGL reads a texture that it could not allocate as zeros, and a table here takes {} MiB: use fewer terms, \
                 table = \"f16\", a coarser scan (resample_um), or --runner vulkan, which reports it",
                bytes >> 20
            )
        },
    },
    Limit {
        routes: &["webgpu", "webgl2", "vulkan", "gl", "hlsl", "spirv"],
        is_mesas: false,
        counted: loop_steps,
        max: 1 << 20,
        says: |steps| {
            format!(
                "a pixel takes about {steps} steps, and watch-dogs of drivers end long frames: use a smaller --size, a larger \
                 step_nm or fewer terms"
            )
        },
    },
];

/// What probably made a route's colours wrong.
pub(super) fn likely_cause(route: &str, prepared: &Prepared<'_>) -> String {
    let (kind, adapter) = route.split_once(':').unwrap_or((route, ""));
    // routes without an adapter's name are on whatever OpenGL there is
    let is_mesa = adapter.is_empty() || adapter.contains("llvmpipe");
    let applies = |limit: &&Limit| limit.routes.contains(&kind) && (is_mesa || !limit.is_mesas);
    let exceeded = LIMITS.iter().filter(applies).find_map(|limit| {
        let number = (limit.counted)(prepared);
        (number > limit.max).then(|| (limit.says)(number))
    });
    exceeded.unwrap_or_else(|| {
        "no known limit is exceeded: the driver may compute with less than 32 bits (mediump), or be at fault; update it, or \
         try another --runner"
            .to_owned()
    })
}

/// About how often a pixel goes around all its loops, the ends included: for each evaluation of an amplitude once, and
/// once for every layer of terms, or every four of them.
fn loop_steps(prepared: &Prepared<'_>) -> u64 {
    let cost = prepared.form.cost();
    let taps = prepared.form.window_radius().map_or(1, |radius| u64::from(2 * radius + 1).pow(2));
    cost.evaluations * (2 + 2 * taps) + cost.term_fetches / texels_per_step(&prepared.form)
}

/// Bytes of the largest table.
fn table_bytes(prepared: &Prepared<'_>) -> u64 {
    prepared.terms.byte_count() as u64
}
