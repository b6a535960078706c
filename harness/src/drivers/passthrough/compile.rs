//! From an emitted file to SPIR-V words for a driver.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use diffraction_cli::interrupt::TemporaryFolder;
use diffraction_shaders::error::{Error, Result};
use diffraction_shaders::plan::Target;
use diffraction_shaders::shader::module::Stage;

use crate::drivers::stages::StageFile;
use crate::process::{accepted, hlsl_to_spirv, on_path};

/// Maximum time of a tool for one file.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// The words of an entry point: the file itself, or what `compiler` compiles from it. `name` is the variant's name, for errors.
///
/// What `spirv-val` has against them is an error, where it is installed.
pub(super) fn words(
    compiler: Option<&Path>,
    name: &str,
    (file, entry): StageFile<'_>,
    stage: Stage,
) -> Result<Vec<u32>> {
    let subject = format!("{name}: {}: {entry}", file.name);
    let fail = |cause: String| Error::new(&subject, cause);
    let folder = TemporaryFolder::new()
        .map_err(|e| fail("a temporary folder cannot be created".to_owned()).source(e))?;
    let spirv = folder.path().join("shader.spv");
    let unwritten = |e| fail(format!("{}: cannot be used", spirv.display())).source(e);
    let bytes = match (file.target, compiler) {
        (Target::Spirv, _) => file.bytes.clone(),
        (Target::Hlsl, Some(compiler)) => {
            let text = folder.path().join("shader.hlsl");
            fs::write(&text, &file.bytes).map_err(unwritten)?;
            hlsl_to_spirv(compiler, &text, (entry, stage), &spirv, TIME_LIMIT)
                .map_err(|fault| fail(fault.to_string()))?;
            fs::read(&spirv).map_err(unwritten)?
        }
        (target, _) => return Err(fail(format!("this route does not run {}", target.as_str()))),
    };
    let words = bytes.chunks_exact(4);
    if !words.remainder().is_empty() {
        return Err(fail(format!("has {} bytes, which is not a multiple of 4", bytes.len())));
    }
    let words: Vec<u32> =
        words.map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect();
    if let Some(validator) = on_path("spirv-val") {
        fs::write(&spirv, &bytes).map_err(unwritten)?;
        let mut validate = Command::new(validator);
        accepted(validate.args(["--target-env", "vulkan1.0"]).arg(&spirv), TIME_LIMIT)
            .map_err(|fault| fail(fault.to_string()))?;
    }
    if let Some(location) = far_location(&words) {
        let cause = format!("an input or output has location {location}, above {MAX_LOCATION}");
        return Err(fail(cause));
    }
    Ok(words)
}

/// The largest location that a driver is given. SwiftShader ends the process at larger ones, which `spirv-val` accepts.
const MAX_LOCATION: u32 = 31;

/// A location above the limit, if a decoration has one (Khronos, *SPIR-V Specification*: opcode 71 `OpDecorate`, decoration 30).
fn far_location(words: &[u32]) -> Option<u32> {
    const HEADER_WORDS: usize = 5;
    let mut rest = words.get(HEADER_WORDS..)?;
    while let [first, ..] = rest {
        let (opcode, count) = (first & 0xffff, (first >> 16).max(1) as usize);
        match rest.get(1..count.min(rest.len())) {
            Some([_, 30, location]) if opcode == 71 && *location > MAX_LOCATION => {
                return Some(*location);
            }
            _ => rest = rest.get(count..)?,
        }
    }
    None
}
