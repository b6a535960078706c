//! The C++ main function that calls a Metal text: entry points and functions with what their parameters are bound to.

use serde_json::Value;

use super::text::{Parameter, parameters};

/// The main function for the emitted names of the entry point `probe` and of those of meshes.
pub(super) fn main_text(
    text: &str,
    probe: &str,
    mesh: Option<(&str, &str)>,
    bindings: &Bindings<'_>,
    has_pattern: bool,
) -> Result<String, String> {
    // `first` stands for the first parameters, which have no binding
    let call = |kind: &str, name: &str, first: &[String]| -> Result<String, String> {
        let parameters = parameters(text, &format!("{kind} {name}"))?;
        let rest = parameters.iter().skip(first.len()).map(|p| bindings.argument(p));
        let rest: Vec<String> = rest.collect::<Result<_, _>>()?;
        Ok(format!("{name}({})", [first, &rest[..]].concat().join(", ")))
    };
    let entry = |stage: &str, name: &str, input: &str| {
        call(&format!("{stage} {name}Output"), name, &[format!("{name}Input{{{input}}}")])
    };
    let mut directions = vec!["at.wi".to_owned(), "at.wr".to_owned()];
    if has_pattern {
        directions.push("at.pattern".to_owned());
    }
    let mut lines = vec![
        format!("const auto [xyz] = {};", entry("fragment", probe, "at.place")?),
        format!("const auto rgb = {};", call("metal::float3", "diffraction", &directions)?),
    ];
    let mut printed = "xyz, rgb".to_owned();
    if let Some((vert, mesh)) = mesh {
        let input = "metal::float3(), at.normal, at.tangent, metal::float2(), at.angle";
        let vertex = entry("vertex", vert, input)?;
        lines.push(format!("run::uniforms[{}] = at.mesh;", bindings.number("mesh_params")?));
        lines.push(format!("const auto [clip, place, normal, tangent, uv] = {vertex};"));
        let fragment = entry("fragment", mesh, "place, normal, tangent, uv")?;
        lines.push(format!("const auto [on_mesh] = {fragment};"));
        printed += ", on_mesh";
    }
    lines.push(format!("run::print({printed});"));
    let body: String = lines.iter().map(|line| format!("        {line}\n")).collect();
    Ok(format!(
        "#include \"run.h\"\n#include \"text.h\"\nint main(int, char** arguments) {{\n    \
         run::read(arguments[1]);\n    for (const run::probe& at : run::probes) {{\n{body}    }}\n}}\n"
    ))
}

/// The bindings of a target in a manifest.
pub(super) struct Bindings<'a>(pub &'a Value);

impl Bindings<'_> {
    fn find(&self, key: &str, name: &str) -> Result<(&Value, u64), String> {
        let mut all = self.0["bindings"].as_array().into_iter().flatten();
        let found = all.find(|binding| binding[key] == name);
        let found = found.ok_or_else(|| format!("the manifest has no binding `{name}`"))?;
        let number = found["emitted_binding"].as_u64();
        Ok((found, number.ok_or_else(|| format!("the binding `{name}` has no number"))?))
    }

    /// Number of a binding by its name in WGSL.
    pub(super) fn number(&self, source_name: &str) -> Result<u64, String> {
        Ok(self.find("source_name", source_name)?.1)
    }

    /// What a parameter is bound to.
    fn argument(&self, parameter: &Parameter<'_>) -> Result<String, String> {
        let Parameter { name, attribute } = *parameter;
        let (binding, number) = self.find("emitted_name", name)?;
        if let Some((kind, said)) = attribute
            && said != number
        {
            return Err(format!(
                "`{name}` is {kind}({said}) in the text, {number} in the manifest"
            ));
        }
        match binding["kind"].as_str().unwrap_or_default() {
            "texture" => Ok(format!("run::texture{{{number}}}")),
            "uniform_block" => Ok(format!("run::buffer{{{number}}}")),
            "sampler" => Ok("metal::sampler()".to_owned()),
            other => Err(format!("`{name}` has the unknown kind `{other}`")),
        }
    }
}
