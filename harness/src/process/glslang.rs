//! The command lines of glslangValidator.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use diffraction_shaders::shader::module::Stage;

use super::{Fault, accepted};

/// The compiler of GLSL and HLSL.
pub const GLSLANG: &str = "glslangValidator";
/// The Debian package that contains it.
pub const GLSLANG_PACKAGE: &str = "glslang-tools";

/// Compiles an entry point of an HLSL file to SPIR-V for Vulkan. The error is the compiler's message.
///
/// Registers become bindings, spaces become descriptor sets, with the same numbers.
pub fn hlsl_to_spirv(
    compiler: &Path,
    text: &Path,
    (entry, stage): (&str, Stage),
    output: &Path,
    limit: Duration,
) -> Result<(), Fault> {
    let mut command = Command::new(compiler);
    command.args(hlsl_options(entry, stage, &output.to_string_lossy())).arg(text);
    let said = accepted(&mut command, limit)?;
    // glslang only warns and writes a shader that does nothing
    if said.contains("Entry point not found") {
        return Err(Fault::Refused(format!("{GLSLANG}: found no entry point {entry}")));
    }
    Ok(())
}

/// The options of [`hlsl_to_spirv`], with the output file `output`.
pub fn hlsl_options(entry: &str, stage: Stage, output: &str) -> Vec<String> {
    let stage = match stage {
        Stage::Vertex => "vert",
        Stage::Fragment => "frag",
    };
    let words = ["-D", "-V", "-e", entry, "-S", stage, "-o", output];
    words.map(str::to_owned).to_vec()
}
