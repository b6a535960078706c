//! Emission: files, names, headers, determinism.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::collections::BTreeMap;

use diffraction_shaders::{
    emit::{BindingKind, EmittedFile, emit},
    module::Stage,
    plan::Target,
    template::GENERATED,
};

fn text(file: &EmittedFile) -> &str {
    std::str::from_utf8(&file.bytes).unwrap()
}

#[test]
fn files_are_named_by_target_and_stage() {
    let files = common::files();
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "diffraction.wgsl",
            "diffraction.vert.glsl",
            "diffraction.frag.glsl",
            "diffraction.probe.frag.glsl",
            "diffraction.es300.vert",
            "diffraction.es300.frag",
            "diffraction.probe.es300.frag",
            "diffraction.vert.spv",
            "diffraction.frag.spv",
            "diffraction.probe.frag.spv",
        ]
    );
    for file in files {
        let entry_points = file.entry_points.iter();
        let entries: Vec<_> = entry_points.map(|e| (e.source_name.as_str(), e.stage)).collect();
        let all = [("vert", Stage::Vertex), ("map", Stage::Fragment), ("probe", Stage::Fragment)];
        let expected = match file.name.as_str() {
            "diffraction.wgsl" => &all[..],
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
    for file in common::files().iter().filter(|file| file.target != Target::Spirv) {
        let lines: Vec<&str> = text(file).lines().take(2).collect();
        let expected = match file.target {
            Target::Wgsl => 0,
            _ => 1,
        };
        assert_eq!(lines[expected], header, "{}", file.name);
        match file.target {
            Target::Glsl450 => assert_eq!(lines[0], "#version 450 core"),
            Target::GlslEs300 => assert_eq!(lines[0], "#version 300 es"),
            _ => {}
        }
        assert!(text(file).ends_with("}\n"), "{}", file.name);
        assert!(!text(file).contains("/work"), "{}", file.name);
    }
}

#[test]
fn wgsl_is_our_own_text() {
    let module = common::module();
    let files = emit(&module, Target::Wgsl).unwrap();
    assert_eq!(text(&files[0]), module.text());
    assert!(text(&files[0]).contains("// Sums all terms over all wavelengths."));
}

#[test]
fn es_is_high_precision_throughout() {
    for file in common::files().iter().filter(|file| file.target == Target::GlslEs300) {
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
    for file in common::files() {
        let sources: BTreeMap<&str, BindingKind> =
            file.bindings.iter().map(|b| (b.source_name.as_str(), b.kind)).collect();
        let fragment = [
            ("params", BindingKind::UniformBlock),
            ("spectrum", BindingKind::Texture),
            ("terms", BindingKind::Texture),
        ];
        let mut expected = BTreeMap::from(fragment);
        if file.entry_points[0].source_name == "probe" || file.target == Target::Wgsl {
            expected.insert("directions", BindingKind::Texture);
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
            let es = file.target == Target::GlslEs300;
            assert_eq!(binding.emitted_binding, (!es).then_some(number), "{}", file.name);
            if file.target != Target::Spirv {
                let names = [Some(&binding.emitted_name), binding.member_name.as_ref()];
                for name in names.into_iter().flatten() {
                    assert!(text(&file).contains(name.as_str()), "{}: {name}", file.name);
                }
            }
            if file.target == Target::Glsl450 {
                assert!(text(&file).contains(&format!("binding = {number}")), "{}", text(&file));
            }
        }
        let blocks: Vec<&str> = file.uniform_blocks().collect();
        match (file.target, file.bindings.is_empty()) {
            (_, true) => assert!(blocks.is_empty()),
            (Target::Wgsl | Target::Spirv, _) => assert_eq!(blocks, ["params"]),
            (_, _) => assert_eq!(blocks, ["Params_block_0Fragment"]),
        }
    }
}

#[test]
fn spirv_is_version_1_0_with_names() {
    for file in common::files().iter().filter(|file| file.target == Target::Spirv) {
        assert_eq!(file.bytes[..8], [0x03, 0x02, 0x23, 0x07, 0, 0, 1, 0], "{}", file.name);
        let entry = &file.entry_points[0].emitted_name;
        let holds = |name: &str| file.bytes.windows(name.len()).any(|part| part == name.as_bytes());
        assert!(holds(entry), "{}", file.name);
        assert!(file.bindings.iter().all(|b| holds(&b.emitted_name)), "{}", file.name);
    }
}

#[test]
fn loops_and_fetches_are_as_written() {
    for file in common::files().iter().filter(|file| {
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
    assert_eq!(common::files(), common::files());
}

#[test]
fn clip_space_is_not_rewritten() {
    for file in common::files()
        .iter()
        .filter(|file| file.name.contains("vert") && file.target != Target::Spirv)
    {
        assert!(!text(file).contains("gl_Position.yz"), "{}", text(file));
    }
}

#[test]
fn names_are_those_of_the_templates() {
    for file in common::files().iter().filter(|file| file.target != Target::Spirv) {
        let words = text(file).split(|c: char| !(c.is_alphanumeric() || c == '_'));
        let temporaries = words.filter(|word| word.starts_with("_e") && word.ends_with('_'));
        assert_eq!(temporaries.collect::<Vec<_>>(), Vec::<&str>::new(), "{}", file.name);
        if !file.name.contains("vert") {
            for name in ["texel", "amplitude", "weight", "WAVELENGTHS"] {
                assert!(text(file).contains(name), "{}: {name}", file.name);
            }
        }
    }
}
