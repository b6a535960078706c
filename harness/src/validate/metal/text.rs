//! A Metal text as C++, and what its functions take.

/// The text for a C++ compiler: `v.xyz` becomes `v.xyz()`. An error if it holds what emitted texts do not: it is going to be
/// executed, so it may not reach for more than arithmetic.
pub(super) fn for_cpp(text: &str) -> Result<String, String> {
    const INCLUDES: [&str; 2] = ["#include <metal_stdlib>", "#include <simd/simd.h>"];
    for (number, line) in text.lines().enumerate() {
        let code = line.split("//").next().unwrap_or_default();
        let foreign = (code.contains('#') && !INCLUDES.contains(&code.trim()))
            || code.contains(['"', '\\'])
            || ["/*", "%:"].iter().any(|digraph| code.contains(digraph))
            || words(code).any(|word| ["asm", "extern"].contains(&word) || word.contains("__"));
        if foreign {
            return Err(format!(
                "line {}: `{}` is not what emitted texts hold, so the text is not run",
                number + 1,
                line.trim()
            ));
        }
    }
    let mut cpp = String::with_capacity(text.len() + text.len() / 16);
    let mut rest = text;
    while let Some(at) = rest.find('.') {
        let (before, after) = rest.split_at(at + 1);
        cpp += before;
        let end = after.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(after.len());
        let (member, left) = after.split_at(end);
        cpp += member;
        if (2..=4).contains(&end) && member.chars().all(|c| "xyzw".contains(c)) {
            cpp += "()";
        }
        rest = left;
    }
    Ok(cpp + rest)
}

fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

/// A parameter of a function: its name, and its binding where it has one.
pub(super) struct Parameter<'a> {
    pub name: &'a str,
    /// `texture`, `buffer`, `sampler` or `stage_in`, and a number.
    pub attribute: Option<(&'a str, u64)>,
}

/// The parameters of a function that the text defines. `declared` is the text from its type to its name.
pub(super) fn parameters<'a>(text: &'a str, declared: &str) -> Result<Vec<Parameter<'a>>, String> {
    let wanted = format!("{declared}(");
    let begin = text.find(&wanted).ok_or_else(|| format!("has no `{declared}`"))? + wanted.len();
    let list = text[begin..].split(") {").next().unwrap_or_default();
    Ok(list.split(",\n").flat_map(|part| part.split("\n,")).filter_map(parameter).collect())
}

fn parameter(text: &str) -> Option<Parameter<'_>> {
    let (declared, attribute) = match text.split_once("[[") {
        Some((declared, attribute)) => (declared, Some(attribute)),
        None => (text, None),
    };
    let attribute = attribute.map(|attribute| {
        let mut words = words(attribute);
        let (kind, number) = (words.next().unwrap_or_default(), words.next());
        (kind, number.and_then(|number| number.parse().ok()).unwrap_or_default())
    });
    Some(Parameter { name: words(declared).last()?, attribute })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_vectors_become_calls() {
        let text = "a = b.xyz + c.x + d.yx.yy; // e.xyz\nf.width = 1.0; xy = g.xy";
        let expected = "a = b.xyz() + c.x + d.yx().yy(); // e.xyz()\nf.width = 1.0; xy = g.xy()";
        assert_eq!(for_cpp(text).as_deref(), Ok(expected));
    }

    #[test]
    fn a_text_that_reaches_out_is_not_run() {
        for line in [
            "#include <cstdlib>",
            "  # define float double",
            "%:include <cstdlib>",
            "int x = system(\"ls\");",
            "asm(0);",
            "__attribute__((constructor)) void f() {}",
            "extern int f();",
        ] {
            let refused = for_cpp(&format!("#include <metal_stdlib>\n{line}\n")).unwrap_err();
            assert!(refused.starts_with("line 2: `"), "{line}: {refused}");
        }
        let good = "#include <metal_stdlib>\n#include <simd/simd.h>\n// \"quoted\" __asm__ #if\n";
        assert_eq!(for_cpp(good).as_deref(), Ok(good));
    }

    #[test]
    fn parameters_are_found_with_their_bindings() {
        let text = "fragment aOutput a(\n  aInput v [[stage_in]]\n, metal::texture2d<float, metal::access::sample> t [[texture(2)]]\n\
                    , constant P& p [[buffer(8)]]\n) {\n}\nmetal::float3 f(\n    metal::float3 wi,\n    metal::sampler s\n) {\n}\n";
        let of = |declared| -> Vec<_> {
            let list = parameters(text, declared).unwrap();
            list.into_iter()
                .map(|p| (p.name.to_owned(), p.attribute.map(|a| (a.0.to_owned(), a.1))))
                .collect()
        };
        let bound =
            |name: &str, kind: &str, number| (name.to_owned(), Some((kind.to_owned(), number)));
        let entry = [bound("v", "stage_in", 0), bound("t", "texture", 2), bound("p", "buffer", 8)];
        assert_eq!(of("fragment aOutput a"), entry);
        assert_eq!(of("metal::float3 f"), [("wi".to_owned(), None), ("s".to_owned(), None)]);
        assert!(parameters(text, "metal::float3 g").is_err());
    }
}
