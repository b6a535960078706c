//! The comment at the top of every text.
//!
//! The lines that describe the shader come from the top of its template, `templates/shader.wgsl`: frame of the inputs,
//! unit and range of the output, names of the files beside it. The WGSL text already has them. The other writers repeat
//! them, since naga does not write comments. They do not contain computed numbers.

use crate::shader::module::Module;
use crate::shader::template::GENERATED;

/// States where the comments are, since naga leaves them out.
const COMMENTED: &str = "This text has no further comments. The same shader with all comments is diffraction.wgsl of the target wgsl.";

/// The generated-by line, the name, and the comment at the top of the WGSL text, each line with its `//`.
pub fn lines(module: &Module) -> Vec<String> {
    let top = module.text().lines().skip(1).take_while(|line| line.starts_with("//"));
    let mut lines = vec![format!("// {GENERATED}"), format!("// {}", subject(module.name()))];
    lines.extend(top.map(str::to_owned));
    lines
}

/// The same for a text without comments. It also states where the comments are.
pub fn bare(module: &Module) -> String {
    let mut lines = lines(module);
    lines.push(format!("// {COMMENTED}"));
    lines.join("\n")
}

/// A module is named by surface and variant, or only by its variant.
fn subject(name: &str) -> String {
    match name.split_once(' ') {
        Some((surface, variant)) => format!("Surface {surface}, variant {variant}."),
        None => format!("Variant {name}."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_are_named_in_words() {
        assert_eq!(subject("cd full-taylor-t19"), "Surface cd, variant full-taylor-t19.");
        assert_eq!(subject("preview"), "Variant preview.");
    }
}
