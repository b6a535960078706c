//! Metal texts on the processor: the committed ones give the colours of their probes, wrong ones do not.

use crate::support::tools;
use std::fs;
use std::path::{Path, PathBuf};

use diffraction_harness::validate::{MetalCpu, TIME_LIMIT, Tool};

/// A copy of a committed variant with its tables.
fn variant(place: &Path) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for folder in ["shaders/fingers/preview", "surfaces/fingers"] {
        fs::create_dir_all(place.join(folder)).unwrap();
        for entry in fs::read_dir(root.join("generated").join(folder)).unwrap() {
            let path = entry.unwrap().path();
            fs::copy(&path, place.join(folder).join(path.file_name().unwrap())).unwrap();
        }
    }
    place.join("shaders/fingers/preview")
}

fn tool() -> Option<MetalCpu> {
    let tool = MetalCpu::new(TIME_LIMIT);
    tools::found(tool.version().map(|_| ()))?;
    Some(tool)
}

#[test]
fn wrong_texts_fail_their_probes_or_are_not_compiled() {
    let Some(tool) = tool() else { return };
    let place = tempfile::tempdir().unwrap();
    let file = variant(place.path()).join("diffraction.metal");
    let good = fs::read_to_string(&file).unwrap();
    let worst = tool.check(&file).unwrap().expect("it was executed");
    assert!(worst > 0.0 && worst < 0.5, "{worst}");

    let half_turn = "metal::float3 path_1 = -(wi_2) - wr_2;";
    for (right, wrong, expected) in [
        ("float gain(", "flaot gain(", "flaot"),
        ("return metal::exp(-(", "return metal::exp(metal::float2(", "metal::float2"),
        ("3.2406, -1.5372", "3.2406, 1.5372", "RGB of diffraction()"),
        (
            half_turn,
            "metal::float3 path_1 = metal::float3(wi_2.x + wr_2.x, -(wi_2.y) - wr_2.y, -(wi_2.z) - wr_2.z);",
            "XYZ of the entry point probe",
        ),
        // a bitangent the wrong way round, in the fragment and in the vertex shader
        (
            "? -1.0 : 1.0) * metal::cross(",
            "? 1.0 : -1.0) * metal::cross(",
            "RGB of the entry point mesh",
        ),
        (
            "float handedness = ((tangent.w * ",
            "float handedness = ((-tangent.w * ",
            "RGB of the entry point mesh",
        ),
        // a mirrored mesh forgotten
        ("metal::sign(_e27) * cofactors", "cofactors", "RGB of the entry point mesh"),
        (
            "terms [[texture(1)]]",
            "terms [[texture(7)]]",
            "texture(7) in the text, 1 in the manifest",
        ),
        ("int layer = 6;", "int layer = 7;", "reads outside of a texture"),
        ("using metal::uint;", "using metal::uint;\n#include <cstdlib>", "the text is not run"),
    ] {
        assert!(good.contains(right), "{right}");
        fs::write(&file, good.replace(right, wrong)).unwrap();
        let said = tool.check(&file).expect_err(wrong).to_string();
        assert!(said.contains(expected), "{wrong}: {said}");
    }
}

#[test]
fn wrong_packages_around_a_text_are_found() {
    let Some(tool) = tool() else { return };
    let place = tempfile::tempdir().unwrap();
    let folder = variant(place.path());
    for (name, right, wrong, expected) in [
        (
            "manifest.json",
            "\"size\": 32,",
            "\"size\": 48,",
            "32 bytes in the text and 48 in the manifest",
        ),
        ("manifest.json", "diffraction.metal", "other.metal", "lists no Metal file"),
        ("probe.json", "\"probes\"", "\"prose\"", "has no probes"),
        (
            "probe.json",
            "\"expected\":{\"xyz\":[0.0373",
            "\"expected\":{\"xyz\":[0.0383",
            "probe 0: XYZ",
        ),
    ] {
        let good = fs::read_to_string(folder.join(name)).unwrap();
        assert!(good.contains(right), "{right}");
        fs::write(folder.join(name), good.replace(right, wrong)).unwrap();
        let said = tool.check(&folder.join("diffraction.metal")).expect_err(wrong).to_string();
        assert!(said.contains(expected), "{wrong}: {said}");
        fs::write(folder.join(name), good).unwrap();
    }
    let tables = place.path().join("surfaces/fingers");
    let table = fs::read_dir(tables).unwrap().map(|entry| entry.unwrap().path());
    for path in table.filter(|path| path.extension().is_some_and(|e| e == "bin")) {
        fs::write(path, b"short").unwrap();
    }
    let said = tool.check(&folder.join("diffraction.metal")).unwrap_err().to_string();
    assert!(said.contains("another size than its description says"), "{said}");
}
