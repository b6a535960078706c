//! Emission: files, names, headers, determinism.

use crate::support::package;
use std::collections::BTreeMap;

use diffraction_shaders::plan::Target;
use diffraction_shaders::shader::emit::{BindingKind, EmittedFile, emit};
use diffraction_shaders::shader::module::{Stage, compile};
use diffraction_shaders::shader::template::{GENERATED, specialise};

fn text(file: &EmittedFile) -> &str {
    std::str::from_utf8(&file.bytes).unwrap()
}

/// The lines that are not comments.
fn without_comments(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.map(|line| format!("{line}\n")).collect()
}

#[test]
fn files_are_named_by_target_and_stage() {
    let files = package::files();
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "diffraction.wgsl",
            "diffraction.fn.wgsl",
            "diffraction.vert.glsl",
            "diffraction.frag.glsl",
            "diffraction.probe.frag.glsl",
            "diffraction.fn.glsl",
            "diffraction.es300.vert",
            "diffraction.es300.frag",
            "diffraction.probe.es300.frag",
            "diffraction.vert.spv",
            "diffraction.frag.spv",
            "diffraction.probe.frag.spv",
            "diffraction.hlsl",
            "diffraction.fn.hlsl",
            "diffraction.metal",
        ]
    );
    for file in files {
        let entry_points = file.entry_points.iter();
        let entries: Vec<_> = entry_points.map(|e| (e.source_name.as_str(), e.stage)).collect();
        let all = [("vert", Stage::Vertex), ("map", Stage::Fragment), ("probe", Stage::Fragment)];
        let expected = match file.name.as_str() {
            name if name.contains(".fn.") => &[],
            "diffraction.wgsl" | "diffraction.hlsl" | "diffraction.metal" => &all[..],
            name if name.contains("probe") => &all[2..],
            name if name.contains("vert") => &all[..1],
            _ => &all[1..2],
        };
        assert_eq!(entries, expected, "{}", file.name);
        let glsl = matches!(file.target, Target::Glsl450 | Target::GlslEs300);
        for entry in &file.entry_points {
            let name = if glsl { "main" } else { entry.source_name.as_str() };
            assert_eq!(entry.emitted_name, name);
        }
    }
}

#[test]
fn texts_begin_with_their_header() {
    let header = format!("// {GENERATED}");
    for file in package::files().iter().filter(|file| file.target != Target::Spirv) {
        let lines: Vec<&str> = text(file).lines().take(2).collect();
        let version = matches!(file.target, Target::Glsl450 | Target::GlslEs300);
        let begin = match file.name.as_str() {
            // begins with the function
            "diffraction.fn.wgsl" => lines[1].trim_start(),
            "diffraction.fn.glsl" => lines[0],
            _ => lines[usize::from(version)],
        };
        assert_eq!(begin, header, "{}", file.name);
        match file.target {
            _ if file.name.contains(".fn.") => {}
            Target::Glsl450 => assert_eq!(lines[0], "#version 450 core"),
            Target::GlslEs300 => assert_eq!(lines[0], "#version 300 es"),
            _ => {}
        }
        assert!(text(file).ends_with("}\n"), "{}", file.name);
        assert!(!text(file).contains(env!("CARGO_MANIFEST_DIR")), "{}", file.name);
    }
}

/// The comment at the top, without its first line.
fn head(text: &str) -> Vec<String> {
    let lines = text.lines().map(str::trim_start).skip_while(|line| !line.contains(GENERATED));
    let head = lines.skip(1).take_while(|line| line.starts_with("//"));
    head.map(str::to_owned).collect()
}

#[test]
fn every_text_says_what_it_is() {
    let module = package::module();
    let top = "// A small shader with the resources of the real ones.";
    for target in package::TARGETS.into_iter().filter(|target| *target != Target::Spirv) {
        for file in emit(&module, target).unwrap() {
            let head = head(text(&file));
            match file.name.as_str() {
                "diffraction.wgsl" => assert_eq!(head[0], top),
                name => assert_eq!(head[..2], ["// Variant test.", top], "{name}"),
            }
            let pointer = head.iter().any(|line| line.contains("diffraction.wgsl"));
            assert_eq!(pointer, target != Target::Wgsl, "{}", file.name);
        }
    }
}

#[test]
fn shipped_texts_say_what_goes_in_and_what_comes_out() {
    let package = package::package();
    let mut texts = 0;
    for (path, file) in package.files().iter().filter(|(path, _)| path.contains("/diffraction.")) {
        let bytes = file.content.read().unwrap();
        let Ok(text) = std::str::from_utf8(&bytes) else { continue };
        let head = head(text);
        let said = head.join(" ");
        for word in ["wi to the light", "tangent frame", "scene-linear", "not clamped", "negative"]
        {
            assert!(said.contains(word), "{path}: {word}");
        }
        for file in ["probe.json", "manifest.json"] {
            assert!(said.contains(file), "{path}: {file}");
        }
        let named = said.contains("Surface tiny, variant ");
        assert_eq!(named, !path.ends_with("/diffraction.wgsl"), "{path}");
        let others = !path.ends_with(".wgsl");
        assert!(said.is_ascii() || !others, "{path}: not every compiler reads more than ASCII");
        assert!((8..=12).contains(&head.len()) || !others, "{path}: {} lines", head.len());
        assert!(!text.contains("//-"), "{path}");
        texts += 1;
    }
    assert!(texts > 20, "{texts}");
}

#[test]
fn constants_of_shipped_wgsl_have_their_meaning_behind_them() {
    let package = package::package();
    let mut constants = 0;
    for (path, file) in package.files().iter().filter(|(path, _)| path.ends_with(".wgsl")) {
        let bytes = file.content.read().unwrap();
        let text = std::str::from_utf8(&bytes).unwrap();
        for line in text.lines().filter(|line| line.starts_with("const ")) {
            assert!(
                line.split_once("; // ").is_some_and(|(_, said)| !said.is_empty()),
                "{path}: {line}"
            );
            constants += 1;
        }
    }
    assert!(constants > 20, "{constants}");
}

#[test]
fn wgsl_is_our_own_text() {
    let module = package::module();
    let files = emit(&module, Target::Wgsl).unwrap();
    assert_eq!(text(&files[0]), module.text());
    assert!(text(&files[0]).contains("// Sums all terms over all wavelengths."));
}

#[test]
fn es_is_high_precision_throughout() {
    let function_form = |file: &EmittedFile| file.name.contains(".fn.");
    for file in package::files()
        .iter()
        .filter(|file| file.target == Target::GlslEs300 && !function_form(file))
    {
        let text = text(file);
        assert!(text.contains("precision highp float;") && text.contains("precision highp int;"));
        let samplers =
            text.lines().filter(|line| line.starts_with("uniform") && line.contains("sampler"));
        for sampler in samplers {
            assert!(sampler.contains("highp sampler2D"), "{sampler}");
        }
    }
}

#[test]
fn every_binding_is_found_under_its_emitted_name() {
    for file in package::files() {
        let sources: BTreeMap<&str, BindingKind> =
            file.bindings.iter().map(|b| (b.source_name.as_str(), b.kind)).collect();
        let fragment = [
            ("params", BindingKind::UniformBlock),
            ("spectrum", BindingKind::Texture),
            ("terms", BindingKind::Texture),
        ];
        let mut expected = BTreeMap::from(fragment);
        let entries: Vec<&str> =
            file.entry_points.iter().map(|entry| entry.source_name.as_str()).collect();
        if entries.contains(&"probe") {
            expected.insert("directions", BindingKind::Texture);
        }
        let function_form = entries.is_empty();
        if function_form {
            expected.remove("params");
        }
        if file.name.contains("vert") {
            expected.clear();
        }
        assert_eq!(sources, expected, "{}", file.name);
        for binding in &file.bindings {
            let number = ["params", "terms", "spectrum", "directions"]
                .iter()
                .position(|name| *name == binding.source_name)
                .unwrap() as u32;
            assert_eq!((binding.group, binding.binding), (0, number));
            let unset = file.target == Target::GlslEs300 || function_form;
            assert_eq!(binding.emitted_binding, (!unset).then_some(number), "{}", file.name);
            if file.target != Target::Spirv {
                let names = [Some(&binding.emitted_name), binding.member_name.as_ref()];
                for name in names.into_iter().flatten() {
                    assert!(text(&file).contains(name.as_str()), "{}: {name}", file.name);
                }
            }
            let block = binding.kind == BindingKind::UniformBlock;
            let mark = match file.target {
                Target::Glsl450 => format!("binding = {number}"),
                Target::Hlsl => format!("register({}{number})", if block { 'b' } else { 't' }),
                Target::Msl => {
                    format!("[[{}({number})]]", if block { "buffer" } else { "texture" })
                }
                _ => continue,
            };
            assert_eq!(text(&file).contains(&mark), !unset, "{}", text(&file));
        }
        let blocks: Vec<&str> = file.uniform_blocks().collect();
        match (file.target, file.bindings.is_empty()) {
            (_, true) => assert!(blocks.is_empty()),
            _ if function_form => assert!(blocks.is_empty()),
            (Target::Wgsl | Target::Spirv | Target::Hlsl | Target::Msl, _) => {
                assert_eq!(blocks, ["params"]);
            }
            (_, _) => assert_eq!(blocks, ["Params_block_0Fragment"]),
        }
    }
}

#[test]
fn spirv_is_version_1_0_with_names() {
    for file in package::files().iter().filter(|file| file.target == Target::Spirv) {
        assert_eq!(file.bytes[..8], [0x03, 0x02, 0x23, 0x07, 0, 0, 1, 0], "{}", file.name);
        let entry = &file.entry_points[0].emitted_name;
        let holds = |name: &str| file.bytes.windows(name.len()).any(|part| part == name.as_bytes());
        assert!(holds(entry), "{}", file.name);
        assert!(file.bindings.iter().all(|b| holds(&b.emitted_name)), "{}", file.name);
    }
}

#[test]
fn loops_and_fetches_are_as_written() {
    for file in package::files().iter().filter(|file| {
        matches!(file.target, Target::Glsl450 | Target::GlslEs300) && !file.name.contains("vert")
    }) {
        let text = text(file);
        assert!(!text.contains("loop_bound"), "{text}");
        assert_eq!(
            text.matches("texelFetch(").count(),
            if file.name.contains("probe") { 4 } else { 2 }
        );
    }
}

#[test]
fn emission_is_deterministic() {
    assert_eq!(package::files(), package::files());
}

#[test]
fn clip_space_is_not_rewritten() {
    for file in package::files()
        .iter()
        .filter(|file| file.name.contains("vert") && file.target != Target::Spirv)
    {
        assert!(!text(file).contains("gl_Position.yz"), "{}", text(file));
    }
}

#[test]
fn names_are_those_of_the_templates() {
    for file in package::files().iter().filter(|file| file.target != Target::Spirv) {
        let words = text(file).split(|c: char| !(c.is_alphanumeric() || c == '_'));
        // `out` is a word of GLSL
        let strange = words.filter(|word| word.ends_with('_') && *word != "out_");
        assert_eq!(strange.collect::<Vec<_>>(), Vec::<&str>::new(), "{}", file.name);
        if !file.name.contains("vert") {
            for name in ["texel", "amplitude", "weight", "WAVELENGTHS"] {
                assert!(text(file).contains(name), "{}: {name}", file.name);
            }
        }
    }
}

#[test]
fn targets_that_are_kept_write_nothing_but_what_another_shares() {
    let names = |wanted: &[Target]| {
        let package = package::package_in(wanted);
        let below = format!("{}/diffraction.", package::VARIANT_FOLDER);
        let files = package.files().keys().filter_map(|path| path.strip_prefix(&below));
        files.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(names(&[]), Vec::<String>::new());
    assert_eq!(names(&[Target::Hlsl]), ["fn.hlsl", "hlsl"]);
    let desktop = [
        "fn.glsl",
        "frag.glsl",
        "mesh.frag.glsl",
        "mesh.vert.glsl",
        "probe.frag.glsl",
        "vert.glsl",
    ];
    assert_eq!(names(&[Target::Glsl450]), desktop);
    let embedded = [
        "es300.frag",
        "es300.vert",
        "fn.glsl",
        "mesh.es300.frag",
        "mesh.es300.vert",
        "probe.es300.frag",
    ];
    assert_eq!(names(&[Target::GlslEs300]), embedded);
    assert_eq!(names(&[Target::Msl, Target::Wgsl]), ["fn.wgsl", "metal", "wgsl"]);
}

/// The function form of a language, and the signatures that it states.
fn function_form(target: Target) -> (String, Vec<String>) {
    let module = package::module();
    let files = emit(&module, target).unwrap();
    let file = files.iter().find(|file| file.name.contains(".fn.")).unwrap();
    let signatures = file.functions.iter().map(|function| function.signature.clone());
    (text(file).to_owned(), signatures.collect())
}

#[test]
fn function_forms_offer_both_functions_and_nothing_else() {
    let signatures = |target| function_form(target).1;
    let textures = "terms: texture_2d_array<f32>, spectrum: texture_2d<f32>";
    assert_eq!(
        signatures(Target::Wgsl),
        ["diffraction", "tristimulus"]
            .map(|name| format!("fn {name}(wi: vec3f, wr: vec3f, {textures}) -> vec3f"))
    );
    for (target, vector) in
        [(Target::Glsl450, "vec3"), (Target::GlslEs300, "vec3"), (Target::Hlsl, "float3")]
    {
        for (signature, name) in signatures(target).iter().zip(["diffraction", "tristimulus"]) {
            assert!(signature.starts_with(&format!("{vector} {name}({vector} wi")), "{signature}");
            assert!(signature.ends_with(')'), "{signature}");
        }
        assert_eq!(signatures(target).len(), 2);
    }
    for target in [Target::Wgsl, Target::Glsl450, Target::Hlsl] {
        let (text, _) = function_form(target);
        let text = without_comments(&text);
        let foreign = [
            "#version",
            "precision ",
            "main",
            "layout",
            "@group",
            "@binding",
            "@fragment",
            "register",
            "params",
            "Params",
            "directions",
            "probe",
            "map",
            "vert",
            "_group_",
        ];
        assert_eq!(foreign.iter().find(|word| text.contains(**word)), None, "{text}");
    }
    assert_eq!(function_form(Target::Glsl450), function_form(Target::GlslEs300));
}

#[test]
fn the_function_form_of_wgsl_begins_with_the_function_and_keeps_comments() {
    let (text, _) = function_form(Target::Wgsl);
    let expected = "\
fn diffraction(wi: vec3f, wr: vec3f, terms: texture_2d_array<f32>, spectrum: texture_2d<f32>) -> vec3f {
    // @generated by `cargo xtask generate`; do not edit
    // Variant test.
    // A small shader with the resources of the real ones.
    //
    // terms: Transforms, one layer each.
    return tristimulus(wi, wr, terms, spectrum) * SCALE;
}

";
    assert!(text.starts_with(expected), "{text}");
    assert!(text.contains("\n\n// Sums all terms over all wavelengths.\nfn tristimulus("));
    assert!(text.contains("\nconst WAVELENGTHS: i32 = 81; // number of wavelengths\n"));
}

#[test]
fn a_core_function_that_reads_a_uniform_block_has_no_function_form() {
    let mut sources = package::sources();
    let core = sources.0.get_mut("core").unwrap();
    *core = core.replace("* SCALE", "* SCALE * params.gain.xyz");
    let specialised = specialise(&sources, "root", &package::defines()).unwrap();
    let module = compile(&specialised, &sources, "test").unwrap();
    for (target, name) in
        [(Target::Wgsl, "wgsl"), (Target::GlslEs300, "glsl-es300"), (Target::Hlsl, "hlsl")]
    {
        assert_eq!(
            emit(&module, target).unwrap_err().to_string(),
            format!(
                "test: {name}: function form: `diffraction` reads `params`, which is not a texture"
            )
        );
    }
    assert!(emit(&module, Target::Msl).is_ok());
}
