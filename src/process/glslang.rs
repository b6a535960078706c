//! What glslangValidator is told.

use crate::module::Stage;

/// The compiler of GLSL and HLSL.
pub const GLSLANG: &str = "glslangValidator";
/// The Debian package that brings it.
pub const GLSLANG_PACKAGE: &str = "glslang-tools";

/// Options that turn an entry point of an HLSL file into SPIR-V for Vulkan; the file itself follows them.
///
/// Registers become bindings and spaces descriptor sets, number by number.
pub fn hlsl_options(entry: &str, stage: Stage, output: &str) -> Vec<String> {
    let stage = match stage {
        Stage::Vertex => "vert",
        Stage::Fragment => "frag",
    };
    let words = ["-D", "-V", "-e", entry, "-S", stage, "-o", output];
    words.map(str::to_owned).to_vec()
}
