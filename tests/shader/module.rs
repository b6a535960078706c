//! Compilation: errors of naga at template lines, and an accepting and a rejecting case of each lint.

use crate::support::package;
use std::collections::BTreeSet;

use diffraction_shaders::diagnostic::group;
use diffraction_shaders::shader::module::lint::LINTS;
use diffraction_shaders::shader::module::{Contract, Stage, compile, compile_with};
use diffraction_shaders::shader::template::{Defines, Sources, specialise};

use crate::support::package::{CORE, PROBE, ROOT, lines, sources};

/// Compiles the test shader with one text replaced by another in its template.
fn edited(
    template: &str,
    from: &str,
    to: &str,
    variant: &str,
) -> Vec<diffraction_shaders::diagnostic::Diagnostic> {
    let mut sources = sources();
    let text = sources.0.get_mut(template).unwrap();
    assert!(text.contains(from), "{from:?} is not in {template}");
    *text = text.replacen(from, to, 1);
    let specialised = specialise(&sources, "root", &package::defines()).unwrap();
    compile(&specialised, &sources, variant).unwrap_err()
}

/// Line, counted from 1, of the first line with that text.
fn line_of(text: &str, needle: &str) -> usize {
    text.lines().position(|line| line.contains(needle)).unwrap() + 1
}

#[test]
fn the_test_shader_compiles() {
    let module = package::module();
    let entries: Vec<_> = module.entry_points().collect();
    assert_eq!(
        entries,
        [("vert", Stage::Vertex), ("map", Stage::Fragment), ("probe", Stage::Fragment)]
    );
    assert_eq!(module.text().lines().count(), module.origins().len());
}

#[test]
fn a_type_error_in_an_import_is_told_at_its_line() {
    let errors = edited("core", "var power = 1.0;", "var power: f32 = vec2f(1.0);", "v");
    assert_eq!(errors.len(), 1, "{errors:#?}");
    let place = errors[0].primary.as_ref().unwrap();
    assert_eq!(place.file, "templates/core.wgsl");
    assert_eq!(place.line as usize, line_of(CORE, "var power"));
    assert_eq!(place.text, "        var power: f32 = vec2f(1.0);");
    let generated = errors[0].secondary.as_ref().unwrap();
    assert_eq!(generated.text, place.text);
    assert!(generated.line > place.line);
    assert_eq!(errors[0].variants, ["v".to_owned()].into());
}

#[test]
fn syntax_errors_have_line_and_column() {
    let errors = edited("probe", "let row = i32(position.y);", "let row = i32(position.y;", "v");
    let place = errors[0].primary.as_ref().unwrap();
    assert_eq!(place.file, "templates/probe.wgsl");
    assert_eq!(place.line as usize, line_of(PROBE, "let row"));
    assert_eq!(place.column, 29);
}

#[test]
fn validation_errors_have_a_line() {
    let errors = edited("probe", "position: vec4f", "position: vec3f", "v");
    let place = errors[0].primary.as_ref().unwrap();
    assert_eq!(place.file, "templates/probe.wgsl", "{errors:#?}");
    assert_eq!(place.line as usize, line_of(PROBE, "fn probe"), "{errors:#?}");
}

#[test]
fn one_error_of_three_variants_is_one_diagnostic() {
    let mut all = Vec::new();
    for variant in ["b", "a", "c"] {
        // generated lines differ: each variant has more comments than the one before
        let padding = "// more\n".repeat(all.len() + 1);
        let mut sources = sources();
        let core = sources.0.get_mut("core").unwrap();
        *core = core.replace("return sum", "return wrong + sum");
        sources.0.insert("root".into(), format!("{padding}{ROOT}"));
        let specialised = specialise(&sources, "root", &package::defines()).unwrap();
        all.extend(compile(&specialised, &sources, variant).unwrap_err());
    }
    assert_eq!(all.len(), 3);
    let grouped = group(all);
    assert_eq!(grouped.len(), 1);
    let line = line_of(CORE, "return sum");
    let expected =
        format!("templates/core.wgsl:{line}:12: no definition in scope for identifier: `wrong`");
    assert_eq!(lines(&grouped), [expected]);
    assert_eq!(grouped[0].variants, ["a", "b", "c"].map(String::from).into());
}

/// A shader that keeps every rule.
const CLEAN: &str = r#"struct Params {
    rows: array<vec4f, 4>,
    view: mat4x4f,
}
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var table: texture_2d<f32>;

struct Vertex {
    @builtin(position) position: vec4f,
}

fn shade(place: vec2f) -> vec3f {
    let row = params.rows[1];
    return row.xyz * textureLoad(table, vec2i(place), 0).xyz;
}

@vertex
fn vert(@builtin(vertex_index) index: u32) -> Vertex {
    var out: Vertex;
    out.position = params.view * vec4f(f32(index));
    return out;
}

@fragment
fn map(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(shade(position.xy), 1.0);
}
"#;

fn contract() -> Contract {
    let entry_points = [("vert", Stage::Vertex), ("map", Stage::Fragment)];
    Contract {
        entry_points: entry_points.map(|(name, stage)| (name.to_owned(), stage)).into(),
        samplers: BTreeSet::from(["linear".to_owned()]),
        functions: vec!["shade"],
    }
}

/// The names of the rules that find something, and what they say.
fn findings(text: &str) -> Vec<(String, String)> {
    let sources: Sources = [("root", text)].into_iter().collect();
    let specialised = specialise(&sources, "root", &Defines::default()).unwrap();
    let errors = match compile_with(&specialised, &sources, "v", &contract()) {
        Ok(_) => return Vec::new(),
        Err(errors) => errors,
    };
    let describe = |index: usize| {
        let error = &errors[index];
        let rule = error.notes.iter().find_map(|note| note.strip_prefix("rule "));
        let rule = rule.unwrap_or_else(|| panic!("not a lint: {error:#?}"));
        let name = rule.split(':').next().unwrap_or_default().to_owned();
        (name, lines(&errors)[index].replace("templates/root.wgsl:", ""))
    };
    (0..errors.len()).map(describe).collect()
}

/// `edits` applied to the clean shader.
fn with(edits: &[(&str, &str)]) -> String {
    edits.iter().fold(CLEAN.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from:?} is not in the text");
        text.replacen(from, to, 1)
    })
}

fn assert_finding(edits: &[(&str, &str)], rule: &str, message: &str) {
    let found = findings(&with(edits));
    assert_eq!(found, [(rule.to_owned(), message.to_owned())]);
}

#[test]
fn the_clean_shader_passes_every_lint() {
    assert_eq!(findings(CLEAN), []);
    assert_eq!(LINTS.len(), 8, "add both cases of the new rule below");
}

#[test]
fn names_end_in_letters() {
    assert_eq!(findings(&with(&[("let row =", "let row_2x ="), ("row.xyz", "row_2x.xyz")])), []);
    let rule = "trailing-digit";
    let cases: [(&[(&str, &str)], &str); 6] = [
        (
            &[("let row =", "let row2 ="), ("row.xyz", "row2.xyz")],
            "13:9: name `row2` ends in a digit",
        ),
        (
            &[("var table:", "var table1:"), ("(table,", "(table1,")],
            "6:27: name `table1` ends in a digit",
        ),
        (
            &[("place: vec2f", "p0: vec2f"), ("vec2i(place)", "vec2i(p0)")],
            "12:10: name `p0` ends in a digit",
        ),
        (
            &[("fn shade", "fn shade3"), ("(shade(", "(shade3(")],
            "12:4: name `shade3` ends in a digit",
        ),
        (
            &[("rows:", "rows4:"), ("params.rows", "params.rows4")],
            "2:5: name `rows4` ends in a digit",
        ),
        (
            &[("@vertex", "const N9: f32 = 2.0;\n@vertex"), ("f32(index)", "N9 * f32(index)")],
            "17:7: name `N9` ends in a digit",
        ),
    ];
    for (edits, message) in cases {
        assert_finding(edits, rule, message);
    }
}

#[test]
fn entry_points_of_the_contract() {
    let rule = "entry-points";
    let two_fragments =
        format!("{CLEAN}{}", "@fragment\nfn extra() -> @location(0) vec4f { return vec4f(); }\n");
    assert_eq!(findings(&two_fragments), []);
    assert_finding(&[("fn map", "fn other")], rule, "1:1: there is no fragment entry point `map`");
    let compute = format!("{CLEAN}@compute @workgroup_size(1)\nfn work() {{}}\n");
    let message = "29:4: entry point `work` is neither a vertex nor a fragment shader";
    assert_eq!(findings(&compute), [(rule.to_owned(), message.to_owned())]);
}

#[test]
fn resources_that_every_target_has() {
    let rule = "resources";
    let declared = ("@vertex", "@group(0) @binding(5) var linear: sampler;\n@vertex");
    assert_eq!(findings(&with(&[declared])), []);
    let other = ("@vertex", "@group(0) @binding(2) var other: sampler;\n@vertex");
    assert_finding(&[other], rule, "17:23: `other` is a sampler that is not declared");
    let elsewhere = ("@vertex", "@group(0) @binding(2) var linear: sampler;\n@vertex");
    let message = "17:23: `linear` is a sampler that is not at binding 5 of group 0";
    assert_finding(&[elsewhere], rule, message);
    let compares = ("@vertex", "@group(0) @binding(5) var linear: sampler_comparison;\n@vertex");
    assert_finding(&[compares], rule, "17:23: `linear` is a comparison sampler");
    let buffer = ("@vertex", "@group(0) @binding(2) var<storage> data: array<vec4f>;\n@vertex");
    assert_finding(&[buffer], rule, "17:23: `data` is a storage buffer");
    let image = (
        "@vertex",
        "@group(0) @binding(2) var image: texture_storage_2d<rgba8unorm, write>;\n@vertex",
    );
    assert_finding(&[image], rule, "17:23: `image` is a storage texture");
}

#[test]
fn textures_per_stage() {
    let many = |count: u32| {
        let names = (0..count).map(|i| format!("t{i}x"));
        let declare = |(i, name): (u32, String)| {
            format!("@group(0) @binding({}) var {name}: texture_2d<f32>;\n", i + 2)
        };
        let declarations: String = (0..).zip(names.clone()).map(declare).collect();
        let reads: String =
            names.map(|name| format!(" + textureLoad({name}, vec2i(), 0).xyz")).collect();
        with(&[
            ("@vertex", &format!("{declarations}@vertex")),
            ("(table, vec2i(place), 0).xyz", &format!("(table, vec2i(place), 0).xyz{reads}")),
        ])
    };
    assert_eq!(findings(&many(15)), []);
    let message = "41:4: entry point `map` reads 17 textures, above the limit of 16";
    assert_eq!(findings(&many(16)), [("texture-count".to_owned(), message.to_owned())]);
}

#[test]
fn uniform_blocks() {
    let rule = "uniform-layout";
    assert_eq!(findings(&with(&[("vec4f, 4>", "vec4f, 1020>")])), []);
    assert_finding(
        &[("vec4f, 4>", "vec4f, 1021>")],
        rule,
        "5:23: uniform block `params` has 16400 bytes, above the limit of 16384",
    );
    for ty in ["f32", "vec3f", "mat3x3f", "array<vec2u, 2>"] {
        let edited = with(&[("    view:", &format!("    odd: {ty},\n    view:"))]);
        let sources: Sources = [("root", edited.as_str())].into_iter().collect();
        let specialised = specialise(&sources, "root", &Defines::default()).unwrap();
        let errors = compile_with(&specialised, &sources, "v", &contract()).unwrap_err();
        if ty.starts_with("array") {
            // the validator itself refuses that stride
            continue;
        }
        let message = "`odd` of uniform block `params` is neither vec4 nor mat4x4";
        assert_eq!(lines(&errors), [format!("templates/root.wgsl:3:5: {message}")]);
    }
    let blocks = |count: u32| {
        let declare = |i: u32| format!("@group(1) @binding({i}) var<uniform> b{i}x: vec4f;\n");
        with(&[("@vertex", &format!("{}@vertex", (0..count).map(declare).collect::<String>()))])
    };
    assert_eq!(findings(&blocks(11)), []);
    let message = "28:24: uniform block `b11x` is number 13, above the limit of 12 blocks";
    assert_eq!(findings(&blocks(12)), [(rule.to_owned(), message.to_owned())]);
}

#[test]
fn no_gather() {
    let sampled = |call: &str| {
        let line = format!("return row.xyz * {call}.xyz * ");
        with(&[
            ("@vertex", "@group(0) @binding(5) var linear: sampler;\n@vertex"),
            ("return row.xyz * ", &line),
        ])
    };
    assert_eq!(findings(&sampled("textureSampleLevel(table, linear, place, 0.0)")), []);
    let message = "14:22: `textureGather` is used";
    assert_eq!(
        findings(&sampled("textureGather(0, table, linear, place)")),
        [("texture-gather".to_owned(), message.to_owned())]
    );
}

#[test]
fn no_dynamic_index_into_a_variable() {
    let rule = "dynamic-indexing";
    // a uniform array may be indexed so, and a variable by a number that is known
    let uniform = ("params.rows[1]", "params.rows[i32(place.x)]");
    assert_eq!(findings(&with(&[uniform])), []);
    let known = ("let row = params.rows[1];", "var a = array<vec4f, 2>();\n    let row = a[1];");
    assert_eq!(findings(&with(&[known])), []);
    let message = "a variable is indexed by a number known only at run time";
    let local =
        ("let row = params.rows[1];", "var a = array<vec4f, 2>(); let row = a[i32(place.x)];");
    assert_finding(&[local], rule, &format!("13:42: {message}"));
}

#[test]
fn no_structs_in_fragment_code() {
    let rule = "fragment-struct";
    // the clean shader has structs in its vertex shader and as a uniform block
    let pair = ("fn shade", "struct Pair { a: vec4f, b: vec4f }\nfn shade");
    let local = ("let row = params.rows[1];", "var p: Pair;\n    let row = p.a;");
    assert_finding(&[pair, local], rule, "14:5: variable `p` of `shade` is a struct");
    let whole = ("let row = params.rows[1];", "let all = params;\n    let row = all.rows[1];");
    assert_finding(&[whole], rule, "13:15: `shade` uses a struct as a value");
    let argument = [
        ("@builtin(position) position: vec4f) -> @loc", "input: Vertex) -> @loc"),
        ("(shade(position.xy", "(shade(input.position.xy"),
    ];
    assert_finding(&argument, rule, "25:4: argument `input` of `map` is a struct");
    let result = [
        pair,
        ("@vertex", "fn make() -> Pair { return Pair(); }\n@vertex"),
        ("= params.rows[1]", "= make().a"),
    ];
    let found = findings(&with(&result));
    assert!(found.iter().all(|(name, _)| name == rule), "{found:?}");
    assert!(found.iter().any(|(_, m)| m == "18:4: the result of `make` is a struct"), "{found:?}");
}
