//! What glslangValidator is told.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use diffraction_shaders::shader::module::Stage;

use super::accepted;

/// The compiler of GLSL and HLSL.
pub const GLSLANG: &str = "glslangValidator";
/// The Debian package that brings it.
pub const GLSLANG_PACKAGE: &str = "glslang-tools";

/// Compiles an entry point of an HLSL file to SPIR-V for Vulkan; the error is what the compiler had to say.
///
/// Registers become bindings and spaces descriptor sets, number by number.
pub fn hlsl_to_spirv(
    compiler: &Path,
    text: &Path,
    (entry, stage): (&str, Stage),
    output: &Path,
    limit: Duration,
) -> Result<(), String> {
    let mut command = Command::new(compiler);
    command.args(hlsl_options(entry, stage, &output.to_string_lossy())).arg(text);
    let said = accepted(&mut command, limit)?;
    // only a warning, beside a shader that does nothing
    if said.contains("Entry point not found") {
        return Err(format!("{GLSLANG}: there is no entry point {entry}"));
    }
    Ok(())
}

/// The options of [`hlsl_to_spirv`], for whoever needs the file named `output` no further.
pub fn hlsl_options(entry: &str, stage: Stage, output: &str) -> Vec<String> {
    let stage = match stage {
        Stage::Vertex => "vert",
        Stage::Fragment => "frag",
    };
    let words = ["-D", "-V", "-e", entry, "-S", stage, "-o", output];
    words.map(str::to_owned).to_vec()
}
