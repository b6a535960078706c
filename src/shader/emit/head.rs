//! The comment at the top of every text.
//!
//! The lines that describe the shader are those at the top of its template, `templates/shader.wgsl`: frame of the inputs,
//! unit and range of the output, names of the files beside it. The WGSL has them already. The other writers repeat them,
//! since naga writes no comments. Nothing in them is computed.

use crate::shader::module::Module;
use crate::shader::template::GENERATED;

/// Where the comments are that naga leaves out.
const COMMENTED: &str =
    "The text with all comments is diffraction.wgsl, the same shader in the target wgsl.";

/// The generated-by line, the name, and the comment at the top of the WGSL, each line with its `//`.
pub fn lines(module: &Module) -> Vec<String> {
    let top = module.text().lines().skip(1).take_while(|line| line.starts_with("//"));
    let mut lines = vec![format!("// {GENERATED}"), format!("// {}", subject(module.name()))];
    lines.extend(top.map(str::to_owned));
    lines
}

/// The same for a text without comments: it also says where they are.
pub fn bare(module: &Module) -> String {
    let mut lines = lines(module);
    lines.push(format!("// {COMMENTED}"));
    lines.join("\n")
}

/// A module is named by its surface and its variant, or by its variant alone.
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
