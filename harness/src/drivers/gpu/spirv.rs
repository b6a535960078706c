//! SPIR-V for Vulkan's driver, unchanged.

use std::collections::{BTreeMap, BTreeSet};

use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::shader::module::Stage;

use super::{Backend, guard::Shared};

/// Numbers from the specification of SPIR-V 1.0 (Khronos, 2015), sections 2.3 and 3.
const MAGIC: u32 = 0x0723_0203;
const HEADER_WORDS: usize = 5;
const OP_ENTRY_POINT: u32 = 15;
const OP_FUNCTION_END: u32 = 56;
const OP_DECORATE: u32 = 71;
const DECORATION_BINDING: u32 = 33;
const DECORATION_DESCRIPTOR_SET: u32 = 34;

/// Refuses a device that does not take SPIR-V.
pub(super) fn supported(shared: &Shared) -> Result<()> {
    let passes = shared.device.features().contains(wgpu::Features::PASSTHROUGH_SHADERS);
    if shared.info.backend == Backend::Vulkan && passes {
        return Ok(());
    }
    let subject = format!("{} adapter {}", shared.info.backend, shared.info);
    Err(Error::new(subject, "does not take SPIR-V").remedy("choose the backend vulkan"))
}

/// Walks through all instructions. The error states why they are not a module with that entry point, or which binding outside
/// `bound`, the bindings of descriptor set 0, it reads.
///
/// Operands of instructions are not checked: `spirv-val` does that.
pub(super) fn check(
    words: &[u32],
    stage: Stage,
    entry: &str,
    bound: &BTreeSet<u32>,
) -> Result<(), String> {
    if words.len() <= HEADER_WORDS || words[0] != MAGIC {
        return Err("does not begin with a SPIR-V header".to_owned());
    }
    let mut found = false;
    let mut places: BTreeMap<u32, (u32, u32)> = BTreeMap::new();
    let mut last = 0;
    let mut at = HEADER_WORDS;
    while at < words.len() {
        let (length, operation) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        let instruction = words.get(at..at + length).filter(|words| !words.is_empty());
        let instruction = instruction
            .ok_or_else(|| format!("the instruction at word {at} has a wrong length"))?;
        match (operation, &instruction[1..]) {
            (OP_ENTRY_POINT, [model, _, name @ ..]) => {
                found |= *model == execution_model(stage) && literal(name) == entry.as_bytes();
            }
            (OP_DECORATE, [target, DECORATION_BINDING, binding]) => {
                places.entry(*target).or_default().1 = *binding;
            }
            (OP_DECORATE, [target, DECORATION_DESCRIPTOR_SET, set]) => {
                places.entry(*target).or_default().0 = *set;
            }
            _ => {}
        }
        (last, at) = (operation, at + length);
    }
    if last != OP_FUNCTION_END {
        return Err("is cut off: the last instruction does not end a function".to_owned());
    }
    if !found {
        let stage = match stage {
            Stage::Vertex => "vertex",
            Stage::Fragment => "fragment",
        };
        return Err(format!("has no {stage} entry point {entry}"));
    }
    match places.values().find(|(set, binding)| *set != 0 || !bound.contains(binding)) {
        Some((set, binding)) => {
            Err(format!("reads binding {binding} of descriptor set {set}, where nothing is bound"))
        }
        None => Ok(()),
    }
}

/// A module of words that passed [`check`].
#[expect(unsafe_code, reason = "wgpu cannot vouch for shaders that it does not translate")]
pub(super) fn module(device: &wgpu::Device, entry: &str, words: &[u32]) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        label: Some(entry),
        entry_points: vec![wgpu::PassthroughShaderEntryPoint {
            name: entry.into(),
            workgroup_size: (1, 1, 1),
        }]
        .into(),
        spirv: Some(words.into()),
        ..Default::default()
    };
    // SAFETY: `check` found whole instructions with this entry point that read only what the layout binds. `Shader::Spirv`
    // requires that the words keep the other rules of SPIR-V: they come from a compiler or have passed `spirv-val`.
    unsafe { device.create_shader_module_passthrough(descriptor) }
}

fn execution_model(stage: Stage) -> u32 {
    match stage {
        Stage::Vertex => 0,
        Stage::Fragment => 4,
    }
}

/// A string: bytes in little-endian words, up to a zero.
fn literal(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The minimal module that passes the walk: entry point `map`, a binding, the end of a function.
    fn words() -> Vec<u32> {
        let name = u32::from_le_bytes(*b"map\0");
        let instruction = |operation: u32, operands: &[u32]| {
            [&[(operands.len() as u32 + 1) << 16 | operation], operands].concat()
        };
        [
            vec![MAGIC, 0x1_0000, 0, 9, 0],
            instruction(OP_ENTRY_POINT, &[4, 1, name]),
            instruction(OP_DECORATE, &[7, DECORATION_DESCRIPTOR_SET, 0]),
            instruction(OP_DECORATE, &[7, DECORATION_BINDING, 2]),
            instruction(OP_FUNCTION_END, &[]),
        ]
        .concat()
    }

    #[test]
    fn what_is_not_a_module_is_refused() {
        let bound = BTreeSet::from([0, 2]);
        let says = |words: &[u32], stage, entry, bound: &BTreeSet<u32>| {
            check(words, stage, entry, bound).err().unwrap_or_default()
        };
        let of = |words: &[u32]| says(words, Stage::Fragment, "map", &bound);
        let whole = words();
        assert_eq!(of(&whole), "");
        assert_eq!(of(&[]), "does not begin with a SPIR-V header");
        assert_eq!(of(&whole[..5]), "does not begin with a SPIR-V header");
        let swapped: Vec<u32> = whole.iter().map(|word| word.swap_bytes()).collect();
        assert_eq!(of(&swapped), "does not begin with a SPIR-V header");
        for end in 6..whole.len() {
            let message = of(&whole[..end]);
            assert!(
                message.contains("wrong length") || message.contains("cut off"),
                "{end}: {message}"
            );
        }
        let mut still = whole.clone();
        still[5] &= 0xffff;
        assert_eq!(of(&still), "the instruction at word 5 has a wrong length");
        let other = says(&whole, Stage::Vertex, "map", &bound);
        assert_eq!(other, "has no vertex entry point map");
        let other = says(&whole, Stage::Fragment, "probe", &bound);
        assert_eq!(other, "has no fragment entry point probe");
        let unbound = says(&whole, Stage::Fragment, "map", &BTreeSet::from([0, 1]));
        assert_eq!(unbound, "reads binding 2 of descriptor set 0, where nothing is bound");
    }
}
