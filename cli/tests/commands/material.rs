//! `diffraction material` as a user runs it: glTF in, keys of a plan out.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use diffraction_shaders::input::read_plan;
use diffraction_shaders::optics::Matter;
use diffraction_shaders::plan::{Film, Material, Medium, Optics};
use serde_json::{Value, json};

fn diffraction(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffraction"))
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// A folder with `a.gltf`, which has these materials.
fn folder(materials: Value) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let file = json!({
        "asset": { "version": "2.0" },
        // extensions of meshes do not matter here, and buffers are not opened
        "extensionsRequired": ["KHR_draco_mesh_compression"],
        "buffers": [{ "byteLength": 12, "uri": "absent.bin" }],
        "materials": materials,
    });
    fs::write(folder.path().join("a.gltf"), file.to_string()).unwrap();
    folder
}

fn printed(folder: &Path, args: &[&str]) -> String {
    let done = diffraction(folder, &[&["material", "a.gltf"], args].concat());
    let text = String::from_utf8(done.stdout).unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!((done.status.code(), said.as_str()), (Some(0), ""), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    text
}

/// The optics of a surface with a printed block, after `list` has built a plan with it.
fn built(folder: &Path, block: &str) -> Optics {
    let grating = "grating = { kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 32 }";
    let plan = format!(
        "schema = 1\n[variants]\nmode = [\"adaptive\"]\n[[surface]]\nname = \"a\"\n{grating}\n{block}"
    );
    fs::write(folder.join("plan.toml"), &plan).unwrap();
    let done = diffraction(folder, &["list"]);
    assert_eq!(done.status.code(), Some(0), "{plan}\n{done:?}");
    let plan = read_plan(&folder.join("plan.toml")).unwrap();
    plan.surfaces[0].optics.over(&plan.optics)
}

#[test]
fn named_metals_are_recognised() {
    let gold = json!({ "baseColorFactor": [1.0, 0.766, 0.336, 1.0], "metallicFactor": 1.0 });
    let folder = folder(json!([{ "name": "Au", "pbrMetallicRoughness": gold }]));
    let text = printed(folder.path(), &[]);
    assert!(text.contains("the nearest named metal is gold, at a CIEDE2000 of 4."), "{text}");
    let optics = built(folder.path(), &text);
    assert_eq!(optics.material, Material::Medium(Medium::Named("gold")));
    assert_eq!((optics.cover_index, optics.films), (Medium::Constant(1.0), vec![]));

    // a table is made all the same where one is asked for
    let text = printed(folder.path(), &["--out", "mine.csv"]);
    assert!(text.contains("material = \"gold\" is recommended"), "{text}");
    let Material::Medium(Medium::File(data)) = built(folder.path(), &text).material else {
        panic!("{text}");
    };
    assert_eq!(data.name(), "mine.csv");
}

#[test]
fn other_metals_become_tables_of_their_colour() {
    let brass = json!({ "baseColorFactor": [0.887, 0.789, 0.434, 1.0] });
    let coat = json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 0.5 } });
    let materials = json!([
        { "name": "Glass", "pbrMetallicRoughness": { "metallicFactor": 0.0 } },
        { "name": "Brass, 1", "pbrMetallicRoughness": brass, "extensions": coat },
    ]);
    let folder = folder(materials);
    let text = printed(folder.path(), &["--name", "Brass, 1"]);
    for part in [
        "material = { nk = \"brass-1.csv\" }",
        "cover_index = 1.5",
        "beyond 5",
        "clearcoatFactor = 0.5",
        "#   380,",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    // the only metal
    let text = printed(folder.path(), &["--out", "b.csv", "--name", "Brass, 1"]);
    let csv = fs::read_to_string(folder.path().join("b.csv")).unwrap();
    let nm: Vec<&str> = csv.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(nm, ["wavelength_nm", "380", "465", "532", "630", "780"]);
    let optics = built(folder.path(), &text);
    let bare = Optics { cover_index: Medium::Constant(1.0), ..optics.clone() };
    let normal = Matter::new(&bare).unwrap().normal_reflectance();
    // luminance of the base colour, of whose red part some is outside of what the table's three channels can show
    let luminance = 0.2126 * 0.887 + 0.7152 * 0.789 + 0.0722 * 0.434;
    assert!((normal - luminance).abs() < 2e-3, "{normal} {luminance}");

    let done = diffraction(folder.path(), &["material", "a.gltf", "--name", "Brass, 1", "--json"]);
    let found: Value = serde_json::from_slice(&done.stdout).unwrap();
    let brass = &found["materials"][0];
    assert_eq!((&brass["name"], &brass["index"]), (&"Brass, 1".into(), &1.into()));
    assert_eq!(brass["optics"]["cover_index"], 1.5);
    assert_eq!(
        (brass["nk"].as_array().unwrap().len(), &brass["nk"][2]["wavelength_nm"]),
        (5, &532.0.into())
    );
    assert!(brass["nk_de2000"].as_f64().unwrap() < 0.1, "{brass}");
    assert_eq!(brass["nearest"]["material"], "gold");
}

#[test]
fn dielectrics_have_their_index_and_films() {
    let shell = json!({
        "KHR_materials_ior": { "ior": 1.56 },
        "KHR_materials_iridescence": {
            "iridescenceFactor": 1.0, "iridescenceIor": 1.8,
            "iridescenceThicknessMaximum": 350.0, "iridescenceThicknessTexture": { "index": 9 },
        },
        "KHR_materials_anisotropy": {},
        "KHR_materials_specular": { "specularFactor": 0.5 },
    });
    let plain = json!({ "metallicFactor": 0 });
    let coated = json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1 } });
    let soap = json!({ "KHR_materials_iridescence": { "iridescenceFactor": 1 } });
    let folder = folder(json!([
        { "name": "Shell", "pbrMetallicRoughness": plain, "extensions": shell },
        { "name": "Lacquer", "pbrMetallicRoughness": plain, "extensions": coated },
        { "pbrMetallicRoughness": plain, "extensions": soap },
    ]));
    let text = printed(folder.path(), &[]);
    for part in [
        "varies the film from 100 to 350 nm",
        "KHR_materials_anisotropy",
        "specularFactor = 0.5",
        "the coat is left out",
        "material 2 of a.gltf",
    ] {
        assert!(text.replace("\n#  ", "").contains(part), "{part} is not in\n{text}");
    }
    let blocks: Vec<&str> = text.split("\n\n").collect();
    let shell = built(folder.path(), blocks[0]);
    assert_eq!((shell.material, shell.refractive_index), (Material::Dielectric, 1.56));
    assert_eq!(shell.films, [Film { index: Medium::Constant(1.8), thickness_nm: 350.0 }]);
    let lacquer = built(folder.path(), blocks[1]);
    assert_eq!((lacquer.refractive_index, lacquer.cover_index), (1.5, Medium::Constant(1.0)));
    let soap = built(folder.path(), blocks[2]);
    assert_eq!(soap.films, [Film { index: Medium::Constant(1.3), thickness_nm: 400.0 }]);
}

#[test]
fn binary_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut text =
        json!({ "asset": { "version": "2.0" }, "materials": [{ "name": "Default" }] }).to_string();
    text += &" ".repeat(text.len().next_multiple_of(4) - text.len());
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((20 + text.len() as u32).to_le_bytes());
    file.extend((text.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(text.as_bytes());
    fs::write(folder.path().join("a.glb"), file).unwrap();
    let done = diffraction(folder.path(), &["material", "a.glb"]);
    let text = String::from_utf8(done.stdout).unwrap();
    // glTF's defaults: a white metal
    assert!(done.status.success() && text.contains("material = \"silver\""), "{text}");
}

#[test]
fn what_cannot_be_is_exit_code_two_with_a_remedy() {
    let ior = |ior: Value| json!({ "KHR_materials_ior": { "ior": ior } });
    let plain = json!({ "metallicFactor": 0 });
    let materials = json!([
        { "name": "Full", "pbrMetallicRoughness": plain, "extensions": ior(json!(0)) },
        { "name": "None", "pbrMetallicRoughness": plain, "extensions": ior(json!(1)) },
        { "name": "Less", "pbrMetallicRoughness": plain, "extensions": ior(json!(0.9)) },
        { "name": "Text", "pbrMetallicRoughness": plain, "extensions": ior(json!("x")) },
        { "name": "Black", "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] } },
        { "name": "Good", "pbrMetallicRoughness": plain },
        { "name": "Steel", "pbrMetallicRoughness": {} },
        { "name": "Tin", "pbrMetallicRoughness": {} },
        { "name": "Bad\n[surface]", "pbrMetallicRoughness": plain },
    ]);
    let folder = folder(materials);
    let path = folder.path();
    let fails = |args: &[&str], parts: &[&str]| {
        let done = diffraction(path, &[&["material"], args].concat());
        let said = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{said}");
        for part in parts {
            assert!(said.contains(part), "{part} is not in\n{said}");
        }
        String::from_utf8(done.stdout).unwrap()
    };
    for (name, part) in [
        ("Full", "has the ior 0"),
        ("None", "reflects nothing"),
        ("Less", "has the ior 0.9"),
        ("Text", "ior is not a number"),
        ("Black", "base colour is black"),
    ] {
        let out = fails(&["a.gltf", "--name", name], &[&format!("a.gltf: \"{name}\""), part, "("]);
        assert_eq!(out, "");
    }
    // the others are printed, and no name reaches beyond its comment
    let out = fails(&["a.gltf"], &["\"Full\"", "\"Black\""]);
    assert!(out.contains("\"Good\"") && !out.contains("\n[surface]\n"), "{out}");
    fails(&["a.gltf", "--name", "Goad"], &["has no material \"Goad\"", "nearest name is \"Good\""]);
    fails(&["a.gltf", "--name", "Good", "--out", "x.csv"], &["--out: 0 metals", "--name"]);
    fails(&["a.gltf", "--out", "x.csv"], &["--out: 2 metals"]);
    assert!(!path.join("x.csv").exists());
    fs::write(path.join("b.gltf"), "{}").unwrap();
    fs::write(path.join("c.glb"), b"glTF\x02\0\0\0\xff\xff\xff\xff").unwrap();
    fs::write(path.join("d.gltf"), r#"{ "asset": { "version": "2.0" } }"#).unwrap();
    fails(&["b.gltf"], &["b.gltf: is not a glTF 2.0 file", ".glb"]);
    fails(&["c.glb"], &["c.glb: is not a glTF 2.0 file"]);
    fails(&["d.gltf"], &["d.gltf: has no materials"]);
    fails(&["absent.gltf"], &["absent.gltf: cannot be read", "check the path"]);
    fails(&["."], &["cannot be read", "is a folder"]);
}
