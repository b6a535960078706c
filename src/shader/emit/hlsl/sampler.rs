//! Samplers as registers of their own.
//!
//! naga reads every sampler out of a heap of 2048 by way of a buffer of indices, which serves wgpu and no engine. What it
//! declares for that is taken out again, and the sampler declared as HLSL has it; all else reads the sampler by its name.

use naga::{TypeInner, back::hlsl};

/// Lines that naga writes once before the first sampler.
const HEAPS: [&str; 2] =
    ["SamplerState nagaSamplerHeap[", "SamplerComparisonState nagaComparisonSamplerHeap["];
/// The buffer of indices of a bind group.
const INDICES: &str = "StructuredBuffer<uint> nagaGroup";
/// What declares a sampler.
const DECLARED: &str = "static const SamplerState ";

/// A place for the buffer of indices of every group, which the writer wants to know and which [`plain`] takes out.
pub fn index_buffers(ir: &naga::Module) -> hlsl::SamplerIndexBufferBindingMap {
    let groups = samplers(ir).map(|(_, place)| hlsl::SamplerIndexBufferKey { group: place.group });
    groups.map(|group| (group, hlsl::BindTarget::default())).collect()
}

/// The text with its samplers declared plainly, in their registers where `registers`.
pub fn plain(text: &str, ir: &naga::Module, registers: bool) -> Result<String, String> {
    let mut lines = Vec::new();
    let mut declared = 0;
    for line in text.lines() {
        if HEAPS.iter().any(|heap| line.starts_with(heap)) || line.starts_with(INDICES) {
            continue;
        }
        let Some(rest) = line.strip_prefix(DECLARED) else {
            lines.push(line.to_owned());
            continue;
        };
        let name = rest.split_once(" = nagaSamplerHeap[").map_or("", |(name, _)| name);
        let place = samplers(ir).find(|(known, _)| *known == name).map(|(_, place)| place);
        let place = place.ok_or_else(|| format!("naga declares a sampler as `{line}`"))?;
        let register = match (registers, place.group) {
            (false, _) => String::new(),
            (true, 0) => format!(" : register(s{})", place.binding),
            (true, group) => format!(" : register(s{}, space{group})", place.binding),
        };
        lines.push(format!("SamplerState {name}{register};"));
        declared += 1;
    }
    let rest = lines
        .iter()
        .find(|line| line.contains("nagaSamplerHeap") || line.contains("SamplerIndexArray"));
    if let Some(line) = rest {
        return Err(format!("naga reads a sampler otherwise than by its name: `{line}`"));
    }
    if declared != samplers(ir).count() {
        return Err(format!("naga declares {declared} samplers out of {}", samplers(ir).count()));
    }
    Ok(lines.join("\n") + "\n")
}

/// Names and places of the samplers.
fn samplers(ir: &naga::Module) -> impl Iterator<Item = (&str, naga::ResourceBinding)> {
    ir.global_variables.iter().filter_map(|(_, global)| {
        let sampler = matches!(ir.types[global.ty].inner, TypeInner::Sampler { .. });
        Some((global.name.as_deref()?, global.binding?)).filter(|_| sampler)
    })
}
