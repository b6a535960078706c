//! Minimal shaders around function forms, since validators only read whole shaders.

use std::{
    fs,
    path::{Path, PathBuf},
};

use diffraction_cli::interrupt::TemporaryFolder;
use diffraction_shaders::shader::module::function_names;
use diffraction_shaders::variant::{DIRECTIONAL, FUNCTIONS, Function as _};

/// Prefix of the names of shells.
pub const NAME: &str = "shell";

/// The files that a validator gets in place of a file.
pub struct Inputs {
    /// One or more whole shaders.
    pub files: Vec<Input>,
    /// The folder of the shells, removed with this value.
    _folder: Option<TemporaryFolder>,
}

/// A whole shader.
pub struct Input {
    /// Its file name, whose extension gives the language.
    pub name: String,
    /// Its absolute path: a relative one might look like an option.
    pub file: PathBuf,
}

/// The file itself, or shells around its function form. An error if it breaks the rules of function forms.
pub fn inputs(file: &Path) -> Result<Inputs, String> {
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let language =
        ["wgsl", "glsl", "hlsl"].into_iter().find(|l| name.ends_with(&format!(".fn.{l}")));
    let Some(language) = language else {
        let file = fs::canonicalize(file).map_err(|error| error.to_string())?;
        return Ok(Inputs { files: vec![Input { name, file }], _folder: None });
    };
    let text = fs::read_to_string(file).map_err(|error| error.to_string())?;
    let folder = TemporaryFolder::new().map_err(|error| error.to_string())?;
    let mut files = Vec::new();
    for (name, text) in shells(language, &text)? {
        let file = folder.path().join(&name);
        fs::write(&file, text).map_err(|error| error.to_string())?;
        files.push(Input { name, file });
    }
    Ok(Inputs { files, _folder: Some(folder) })
}

/// Names and texts of the shells around a function form.
fn shells(language: &str, text: &str) -> Result<Vec<(String, String)>, String> {
    let forbidden: &[&str] = match language {
        "wgsl" => &["@group", "@binding", "@vertex", "@fragment"],
        "glsl" => &["#version", "precision ", "layout", "main"],
        _ => &["register", "SV_"],
    };
    if let Some(word) = forbidden.iter().find(|word| text.contains(**word)) {
        return Err(format!("a function form must not contain `{word}`"));
    }
    let text = &format!("{text}{}", host(language, text));
    match language {
        "wgsl" => Ok(vec![(format!("{NAME}.wgsl"), wgsl(text)?)]),
        "glsl" => {
            let sum = calls(text, ["vec3", "vec4"])?;
            let whole = |head: &str| {
                format!(
                    "{head}\n{text}\nout vec4 colour;\nvoid main() {{\n    colour = vec4({sum}, 1.0);\n}}\n"
                )
            };
            let desktop = whole("#version 450 core");
            let embedded = whole("#version 300 es\nprecision highp float;\nprecision highp int;");
            Ok(vec![
                (
                    format!("{NAME}.frag.glsl"),
                    desktop.replace("out vec4", "layout(location = 0) out vec4"),
                ),
                (format!("{NAME}.es300.frag"), embedded),
            ])
        }
        _ => {
            let sum = calls(text, ["float3", "float4"])?;
            let main =
                format!("float4 main() : SV_Target0 {{\n    return float4({sum}, 1.0);\n}}\n");
            Ok(vec![(format!("{NAME}.hlsl"), format!("{text}\n{main}"))])
        }
    }
}

/// What a host defines, if a text calls it: surroundings that are brighter above.
fn host(language: &str, text: &str) -> &'static str {
    if !text.contains("environment_radiance(") {
        return "";
    }
    match language {
        "wgsl" => {
            "fn environment_radiance(direction: vec3f, spread: f32) -> vec3f {\n    return vec3f(1.0 + direction.z + spread);\n}\n"
        }
        "glsl" => {
            "vec3 environment_radiance(vec3 direction, float spread) {\n    return vec3(1.0 + direction.z + spread);\n}\n"
        }
        _ => {
            "float3 environment_radiance(float3 direction, float spread) {\n    float all = 1.0 + direction.z + spread;\n    return float3(all, all, all);\n}\n"
        }
    }
}

/// The sum of all functions, each called with some arguments. `vectors`: the types with three and four numbers.
fn calls(text: &str, [three, four]: [&str; 2]) -> Result<String, String> {
    let call = |name: &str| {
        let declared = |result| Some((result, text.split_once(&format!("\n{result} {name}("))?.1));
        let (result, declared) = [three, four, "float"].into_iter().find_map(declared)?;
        let (parameters, _) = declared.split_once(')')?;
        let types = parameters.split(", ").filter_map(|parameter| parameter.split(' ').next());
        let arguments: Vec<String> = types.map(argument).collect();
        let call = format!("{name}({})", arguments.join(", "));
        Some(match result {
            "float" => format!("{call} * {}", argument(three)),
            _ if result == four => format!("{call}.xyz"),
            _ => call,
        })
    };
    let calls: Vec<String> = function_names(&FUNCTIONS).into_iter().filter_map(call).collect();
    let first = DIRECTIONAL.name();
    if !calls.iter().any(|call| call.starts_with(first)) {
        return Err(format!("has no function `{first}`"));
    }
    Ok(calls.join(" + "))
}

/// Some argument of a type: a direction or an angle.
fn argument(ty: &str) -> String {
    match ty {
        "f32" | "float" => "0.1".to_owned(),
        vector if vector.contains('4') => format!("{vector}(0.0, 0.6, 0.8, 0.5)"),
        vector => format!("{vector}(0.0, 0.6, 0.8)"),
    }
}

/// A shell for WGSL. Textures and the sampler are parameters, so the shell binds one for each.
fn wgsl(text: &str) -> Result<String, String> {
    let first = DIRECTIONAL.name();
    if !text.starts_with(&format!("fn {first}(")) {
        return Err(format!("the text does not begin with `fn {first}(`"));
    }
    let mut shell = text.to_owned();
    let mut calls = Vec::new();
    let mut bound: Vec<String> = Vec::new();
    for name in function_names(&FUNCTIONS) {
        let mut lines = text.lines();
        let Some(parameters) = lines.find_map(|l| l.strip_prefix(&format!("fn {name}("))) else {
            continue;
        };
        let (parameters, result) =
            parameters.split_once(") -> ").ok_or("a signature spans several lines")?;
        let mut arguments = Vec::new();
        for parameter in parameters.split(", ") {
            let (name, ty) = parameter.split_once(": ").ok_or("a parameter has no type")?;
            if !(ty.starts_with("texture") || ty == "sampler") {
                arguments.push(argument(ty));
                continue;
            }
            let bound_name = format!("{name}_of_shell");
            if !bound.contains(&bound_name) {
                let binding = bound.len();
                shell += &format!("@group(0) @binding({binding}) var {bound_name}: {ty};\n");
                bound.push(bound_name.clone());
            }
            arguments.push(bound_name);
        }
        let call = format!("{name}({})", arguments.join(", "));
        calls.push(match result {
            _ if result.starts_with("vec4") => format!("{call}.xyz"),
            _ if result.starts_with("f32") => format!("vec3f({call})"),
            _ => call,
        });
    }
    let sum = calls.join(" + ");
    shell += &format!(
        "@fragment\nfn shell() -> @location(0) vec4f {{\n    return vec4f({sum}, 1.0);\n}}\n"
    );
    Ok(shell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_that_break_their_rules_are_refused() {
        let refused = |language: &str, text: &str| shells(language, text).unwrap_err();
        assert_eq!(
            refused("wgsl", "// late\nfn diffraction(wi: vec3f) -> vec3f {\n}\n"),
            "the text does not begin with `fn diffraction(`"
        );
        assert_eq!(refused("wgsl", "@group(0)"), "a function form must not contain `@group`");
        assert_eq!(
            refused("glsl", "#version 450\n"),
            "a function form must not contain `#version`"
        );
        assert_eq!(refused("glsl", "float f();\n"), "has no function `diffraction`");
        assert_eq!(
            refused("hlsl", "Texture2D t : register(t0);"),
            "a function form must not contain `register`"
        );
    }
}
