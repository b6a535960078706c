//! External validators: they accept what is emitted, and reject what is broken.

use std::{path::Path, time::Duration};

use diffraction_harness::process::Fault;
use diffraction_harness::validate::{
    External, Naga, Reads, Report, TIME_LIMIT, Tool, tools, validate,
};

use crate::support::package::files;
use crate::support::validators::validate_files;

fn corrupt(name: &str, bytes: &[u8]) -> Vec<u8> {
    if name.ends_with(".spv") {
        // an instruction of length 0 after the header of five words
        let mut bytes = bytes.to_vec();
        bytes[22..24].copy_from_slice(&[0, 0]);
        return bytes;
    }
    String::from_utf8(bytes.to_vec()).unwrap().replacen("0.0", "0.0 +", 1).into_bytes()
}

fn table(report: &Report) -> Vec<(&str, usize, usize)> {
    report.tools.iter().map(|tool| (tool.name.as_str(), tool.files, tool.rejected)).collect()
}

/// Number of files of the test shader that a tool reads.
fn expected(name: &str) -> usize {
    match name {
        "naga" | "tint" | "hlsl-spirv-val" | "dxc" => 2,
        "metal-cpu" => 1,
        "glslangValidator" => 9,
        _ => 3,
    }
}

#[test]
fn every_emitted_file_is_accepted() {
    let files = files();
    let report = validate_files(files.iter().map(|file| (file.name.as_str(), &file.bytes[..])));
    assert!(report.accepted(), "{report:#?}");
    for (name, count, rejected) in table(&report) {
        assert_eq!((count, rejected), (expected(name), 0), "{name}");
    }
    assert!(report.tools.iter().all(|tool| tool.version.is_some() && tool.trouble.is_none()));
    assert!(report.unread.is_empty(), "{:?}", report.unread);
}

#[test]
fn every_corrupted_file_is_rejected_by_every_tool() {
    let broken: Vec<(String, Vec<u8>)> = files()
        .into_iter()
        .map(|file| (file.name.clone(), corrupt(&file.name, &file.bytes)))
        .collect();
    let report = validate_files(broken.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])));
    assert!(!report.accepted());
    for (name, count, rejected) in table(&report) {
        assert_eq!((count, rejected), (expected(name), expected(name)), "{name}: {report:#?}");
    }
    assert_eq!(report.diagnostics().len(), report.failures.len());
}

#[test]
fn broken_spirv_of_right_form_is_rejected() {
    let files = files();
    let spirv = files.iter().find(|file| file.name == "diffraction.frag.spv").unwrap();
    // cut off in the middle of a function, at a word
    let half = spirv.bytes.len() / 8 * 4;
    let report = validate_files([("diffraction.frag.spv", &spirv.bytes[..half])]);
    for (name, count, rejected) in table(&report).into_iter().filter(|row| row.0 == "spirv-val") {
        assert_eq!((count, rejected), (1, 1), "{name}");
    }
}

#[test]
fn files_below_the_folder_are_found_and_all_failures_told() {
    let folder = tempfile::tempdir().unwrap();
    let deep = folder.path().join("shaders/cd/full");
    std::fs::create_dir_all(&deep).unwrap();
    for name in ["diffraction.wgsl", "diffraction.frag.glsl", "other.wgsl"] {
        std::fs::write(deep.join(name), "this is no shader").unwrap();
    }
    std::fs::write(deep.join("diffraction.hlsl"), "unread").unwrap();
    std::fs::write(deep.join("diffraction.metal"), "unread").unwrap();
    std::fs::write(folder.path().join("manifest.json"), "{}").unwrap();
    let missing = External::new("no-such-validator", "find it", Reads::GlslHlsl, |_| vec![]);
    let tools: Vec<Box<dyn Tool>> = vec![Box::new(Naga), Box::new(missing)];
    let report = validate(folder.path(), &tools, &[]).unwrap();
    let naga: Vec<&Path> =
        report.failures.iter().filter(|f| f.tool == "naga").map(|f| f.file.as_path()).collect();
    let relative = Path::new("shaders/cd/full");
    assert_eq!(naga, [relative.join("diffraction.wgsl"), relative.join("other.wgsl")]);
    let unread: Vec<_> =
        report.unread.iter().map(|u| (u.file.clone(), u.reason.as_str())).collect();
    let expected = [
        ("diffraction.frag.glsl", "needs one of these tools: no-such-validator"),
        ("diffraction.hlsl", "needs one of these tools: no-such-validator"),
        ("diffraction.metal", "no tool reads it"),
    ];
    assert_eq!(unread, expected.map(|(name, reason)| (relative.join(name), reason)));
}

#[test]
fn nothing_read_is_not_accepted() {
    let report = validate_files([]);
    assert!(report.failures.is_empty() && !report.accepted());
}

#[test]
fn required_tools() {
    let folder = tempfile::tempdir().unwrap();
    let run = |tools: &[Box<dyn Tool>], required: &str| {
        validate(folder.path(), tools, &[required.to_owned()]).map(|report| report.tools.len())
    };
    assert_eq!(run(&tools(TIME_LIMIT), "naga").unwrap(), 9);
    let error = run(&tools(TIME_LIMIT), "nagga").unwrap_err().to_string();
    assert!(error.starts_with("nagga: is not a known validator (one of naga, "), "{error}");
    let missing = External::new("no-such-validator", "find it", Reads::Wgsl, |_| vec![]);
    let error = run(&[Box::new(missing)], "no-such-validator").unwrap_err().to_string();
    let expected = "no-such-validator: is required, but not installed (find it)";
    assert_eq!(error, expected);
    assert!(validate(&folder.path().join("gone"), &tools(TIME_LIMIT), &[]).is_err());
}

/// Options of `sh`, once.
fn script(text: &str) -> Vec<Vec<String>> {
    vec![vec!["-c".to_owned(), text.to_owned()]]
}

#[cfg(unix)]
#[test]
fn a_tool_that_crashes_or_hangs_has_rejected_its_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.wgsl"), "").unwrap();
    let check = |tool: External| tool.check(&folder.path().join("a.wgsl"));
    // `sh` stands for a tool; its options make it crash, wait, talk and succeed
    let crash = External::new("sh", "", Reads::Wgsl, |_| script("kill -SEGV $$"));
    let Err(Fault::Crashed(said)) = check(crash) else { panic!("it crashed") };
    assert!(said.contains("signal: 11"), "{said}");
    let hang = External::new("sh", "", Reads::Wgsl, |_| script("exec sleep 50"));
    let error = check(hang.time_limit(Duration::from_millis(100))).unwrap_err();
    assert_eq!(error.to_string(), "did not end within 0.1 s");
    let talk = External::new("sh", "", Reads::Wgsl, |_| {
        script("i=0; while [ $i -lt 20000 ]; do echo far too much; i=$((i+1)); done; exit 3")
    });
    let error = check(talk).unwrap_err().to_string();
    assert!(error.contains("exit status: 3") && error.len() > 200_000);
    let good = External::new("sh", "", Reads::Wgsl, |_| script("true"));
    assert_eq!(check(good), Ok(None));
}

#[test]
fn function_forms_are_judged_inside_a_shell() {
    let files = files();
    let form = |language: &str| {
        let name = format!("diffraction.fn.{language}");
        let file = files.iter().find(|file| file.name == name).unwrap();
        (name, String::from_utf8(file.bytes.clone()).unwrap())
    };
    for (language, right, wrong) in [
        // valid on its own, but no shell can call it
        ("wgsl", "fn tristimulus(wi: vec3f", "fn tristimulus(wi: vec4f"),
        ("wgsl", "fn diffraction", "// late\nfn diffraction"),
        ("glsl", "vec3 diffraction(", "vec3 diffractive("),
        ("glsl", "uniform highp sampler2D spectrum", "uniform highp sampler3D spectrum"),
        ("glsl", "// @gen", "#version 450\n// @gen"),
        ("hlsl", "spectrum.Load(", "spectrum.Lood("),
        ("hlsl", "float3 diffraction(", "float3 diffractive("),
        ("hlsl", "spectrum;", "spectrum : register(t0);"),
    ] {
        let (name, text) = form(language);
        let good = validate_files([(name.as_str(), text.as_bytes())]);
        let broken = text.replacen(right, wrong, 1);
        assert_ne!(broken, text);
        let bad = validate_files([(name.as_str(), broken.as_bytes())]);
        let readers = table(&good).into_iter().filter(|(_, files, _)| *files > 0);
        for (tool, _, rejected) in readers {
            assert_eq!(rejected, 0, "{tool}: {good:#?}");
            let found = table(&bad).into_iter().find(|row| row.0 == tool).unwrap();
            assert_eq!(found.2, 1, "{tool} accepts {wrong}");
        }
    }
}
