//! Generated Rust bindings: they compile, and wrong ones do not.

use crate::support::package;
use std::{path::Path, process::Command};

use diffraction_shaders::package::Package;
use diffraction_shaders::shader::template::GENERATED;

/// All generated bindings by path.
fn texts(package: &Package) -> Vec<(String, String)> {
    let files = package.files().keys().filter(|path| path.ends_with("/bindings.rs"));
    let text = |path: &String| {
        let bytes = package.bytes(path).unwrap().to_vec();
        (path.clone(), String::from_utf8(bytes).unwrap())
    };
    files.map(text).collect()
}

/// What rustc says against a library of that text, which needs nothing but `core`.
fn compile(text: &str) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bindings.rs");
    std::fs::write(&file, text).unwrap();
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .args(["--edition", "2024", "--crate-type", "lib", "--emit", "metadata", "-D", "warnings"])
        .arg("--out-dir")
        .args([folder.path(), Path::new(&file)])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(()) } else { Err(said) }
}

#[test]
fn bindings_compile_for_every_kind_of_variant() {
    let texts = texts(&package::package());
    assert_eq!(texts.len(), 2);
    for (path, text) in texts {
        assert!(text.starts_with(&format!("// {GENERATED}\n")), "{path}");
        let bare = format!("#![no_std]\n#![deny(missing_docs)]\n//! Bindings.\n{text}");
        assert_eq!(compile(&bare), Ok(()), "{path}");
        let held = format!("#![no_std]\nmod held {{ {text} }}\npub use held::*;");
        assert_eq!(compile(&held), Ok(()), "{path}");
    }
}

#[test]
fn bindings_say_what_the_manifest_says() {
    let package = package::package();
    let text = |name: &str| {
        let path = format!("shaders/tiny/{name}/bindings.rs");
        String::from_utf8(package.bytes(&path).unwrap().to_vec()).unwrap()
    };
    let checks = r#"
const _: () = {
    assert!(PARAMS_GROUP == 0 && PARAMS_BINDING == 0);
    assert!(TERMS_BINDING == 1 && SPECTRUM_BINDING == 2 && DIRECTIONS_BINDING == 3);
    assert!(size_of::<Params>() == 32 && TABLES.len() == 2);
    assert!(MESH_PARAMS_BINDING == 8 && ORIENTATION_MAP_BINDING == 9 && size_of::<MeshParams>() == 224);
    assert!(TERMS_TABLE.binding == TERMS_BINDING && TERMS_TABLE.layers == LAYERS);
    assert!(SPECTRUM_TABLE.width == 81 && SPECTRUM_TABLE.height == 2);
    assert!(SPECTRUM_TABLE.bytes == 81 * 2 * 16);
    let size = TERMS_TABLE.width * TERMS_TABLE.height * TERMS_TABLE.layers * TEXEL;
    assert!(TERMS_TABLE.bytes == size as usize);
};
"#;
    let paired = "const LAYERS: u32 = 2; const TEXEL: u32 = 16;";
    let single = "const LAYERS: u32 = 2; const TEXEL: u32 = 8;";
    for (name, numbers) in [("full-taylor-t3", paired), ("one", single)] {
        assert_eq!(compile(&format!("{}{checks}{numbers}", text(name))), Ok(()), "{name}");
    }
    assert!(text("one").contains("\"rg32float\"") && text("one").contains("\"2d-array\""));
    for path in text("one").split('"').filter(|part| part.starts_with("../../../surfaces/")) {
        assert!(package.bytes(path.trim_start_matches("../")).is_some(), "{path}");
    }
}

#[test]
fn a_wrong_layout_does_not_compile() {
    let (_, text) = texts(&package::package()).remove(0);
    for (right, wrong) in [
        ("size) == 16", "size) == 32"),
        ("light: [f32; 4]", "light: [f32; 3]"),
        ("PARAMS_BYTES == 32", "PARAMS_BYTES == 48"),
    ] {
        let broken = text.replacen(right, wrong, 1);
        assert_ne!(broken, text, "{right}");
        let said = compile(&broken).unwrap_err();
        assert!(said.contains("assertion failed"), "{wrong}: {said}");
    }
}
