//! Samplers in HLSL, each with a register of its own.
//!
//! naga reads every sampler from a heap of 2048, through a buffer of indices. Only wgpu supports that. This module
//! removes these declarations from the text and declares the sampler as usual in HLSL. The other code reads the sampler
//! by its name and stays unchanged.

use naga::{TypeInner, back::hlsl};

/// Beginnings of the lines that naga writes once, before the first sampler.
const HEAPS: [&str; 2] =
    ["SamplerState nagaSamplerHeap[", "SamplerComparisonState nagaComparisonSamplerHeap["];
/// Beginning of the declaration of a bind group's buffer of indices.
const INDICES: &str = "StructuredBuffer<uint> nagaGroup";
/// Beginning of naga's declaration of a sampler.
const DECLARED: &str = "static const SamplerState ";

/// A register for every group's buffer of indices. The writer needs it, and [`plain`] removes it.
pub fn index_buffers(ir: &naga::Module) -> hlsl::SamplerIndexBufferBindingMap {
    let groups = samplers(ir).map(|(_, place)| hlsl::SamplerIndexBufferKey { group: place.group });
    groups.map(|group| (group, hlsl::BindTarget::default())).collect()
}

/// The text with plain declarations of samplers, with their registers if `registers` is set.
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
        let place =
            place.ok_or_else(|| format!("naga declares a sampler in an unknown way: `{line}`"))?;
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
        return Err(format!("naga reads a sampler in an unknown way, not by its name: `{line}`"));
    }
    if declared != samplers(ir).count() {
        return Err(format!("naga declares {declared} of {} samplers", samplers(ir).count()));
    }
    Ok(lines.join("\n") + "\n")
}

/// Names and bindings of the samplers.
fn samplers(ir: &naga::Module) -> impl Iterator<Item = (&str, naga::ResourceBinding)> {
    ir.global_variables.iter().filter_map(|(_, global)| {
        let sampler = matches!(ir.types[global.ty].inner, TypeInner::Sampler { .. });
        Some((global.name.as_deref()?, global.binding?)).filter(|_| sampler)
    })
}
