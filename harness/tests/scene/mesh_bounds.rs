//! Meshes that are spoilt on purpose: nodes without end, files out of reach, counts that lie.

use std::fs;
use std::path::Path;

use base64::{Engine, prelude::BASE64_STANDARD};
use diffraction_harness::scene::{Mesh, read};
use serde_json::{Value, json};

/// One triangle. `uri` names its buffer, whose bytes are [`triangle`].
fn gltf(uri: &str) -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"uri": uri, "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0]}],
    })
}

fn triangle() -> Vec<u8> {
    let corners: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    bytemuck::cast_slice(&corners).to_vec()
}

fn inside() -> String {
    format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(triangle()))
}

fn read_in(folder: &Path, value: &Value) -> Result<Mesh, String> {
    let file = folder.join("mesh.gltf");
    fs::write(&file, value.to_string()).unwrap();
    read(&file).map_err(|error| error.to_string())
}

fn read_alone(value: &Value) -> Result<Mesh, String> {
    read_in(tempfile::tempdir().unwrap().path(), value)
}

#[test]
fn nodes_are_trees_of_a_limited_size() {
    let mut right = gltf(&inside());
    right["nodes"] = json!([{"children": [1, 2]}, {"mesh": 0}, {"mesh": 0}]);
    assert_eq!(read_alone(&right).unwrap().triangles.len(), 2, "a mesh may stand twice");

    let mut ancestor = gltf(&inside());
    ancestor["nodes"] = json!([{"children": [1]}, {"mesh": 0, "children": [0]}]);
    let said = read_alone(&ancestor).unwrap_err();
    assert!(said.contains("node 0 is below itself"), "{said}");

    // each node has the next one twice, so the last would stand 2^40 times
    let mut doubled = gltf(&inside());
    let mut nodes: Vec<Value> = (1..=40).map(|next| json!({"children": [next, next]})).collect();
    nodes.push(json!({"mesh": 0}));
    doubled["nodes"] = json!(nodes);
    let said = read_alone(&doubled).unwrap_err();
    assert!(said.contains("nodes must form trees"), "{said}");

    let mut many = gltf(&inside());
    let count = (1 << 16) + 1;
    many["nodes"] = json!((0..count).map(|_| json!({})).collect::<Vec<_>>());
    let said = read_alone(&many).unwrap_err();
    assert!(said.contains("more than 65536 nodes"), "{said}");

    // a deep chain within the limit is no trouble
    let mut deep = gltf(&inside());
    let mut chain: Vec<Value> = (1..60_000).map(|next| json!({"children": [next]})).collect();
    chain.push(json!({"mesh": 0}));
    deep["nodes"] = json!(chain);
    assert_eq!(read_alone(&deep).unwrap().triangles.len(), 1);
}

/// Few bytes, but very many vertices: a mesh at every node, and an accessor that states no bytes at all.
#[test]
fn vertices_are_counted_before_they_are_made() {
    let mut many = gltf(&inside());
    let parts: Vec<Value> = (0..300).map(|_| json!({"attributes": {"POSITION": 0}})).collect();
    many["meshes"] = json!([{ "primitives": parts }]);
    let nodes = 1000;
    many["nodes"] = json!((0..nodes).map(|_| json!({"mesh": 0})).collect::<Vec<_>>());
    many["scenes"] = json!([{"nodes": (0..nodes).collect::<Vec<_>>()}]);
    let said = read_alone(&many).unwrap_err();
    assert!(said.contains("more than 65536 primitives"), "{said}");

    let sparse = |accessor: u64, count: u64, places: u64| {
        let mut value = gltf(&inside());
        value["accessors"][0] = json!({
            "componentType": 5126, "count": accessor, "type": "VEC3",
            "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0],
            "sparse": {
                "count": count,
                "indices": {"bufferView": 0, "byteOffset": places, "componentType": 5121},
                "values": {"bufferView": 0},
            },
        });
        value
    };
    for (value, expected) in [
        (sparse(4_000_000_000, 3, 0), "more than 25165824 items in an accessor"),
        (sparse(20_000_000, 3, 0), "more than 4194304 vertices"),
        (sparse(3, 4, 0), "its sparse items end beyond"),
        (sparse(100, 4, 0), "its sparse items end beyond"),
        (sparse(3, 3, 34), "its sparse items end beyond"),
        (sparse(3, 0, 0), "its sparse items end beyond"),
    ] {
        let said = read_alone(&value).unwrap_err();
        assert!(said.contains(expected), "{said}");
    }
    let said = read_alone(&sparse(3, 3, 0)).unwrap_err();
    assert!(said.contains("has no triangle with an area"), "read, but nothing to draw: {said}");
}

#[test]
fn counts_and_views_that_lie_are_refused() {
    type Edit<'a> = &'a dyn Fn(&mut Value);
    let cases: [(Edit<'_>, &str); 6] = [
        (&|g| g["buffers"][0]["byteLength"] = json!(37), "has 36 bytes, 37 are stated"),
        (&|g| g["buffers"][0]["byteLength"] = json!(1_u64 << 60), "are stated"),
        (&|g| g["bufferViews"][0]["byteOffset"] = json!(u64::MAX), "mesh.gltf"),
        (&|g| g["accessors"][0]["byteOffset"] = json!(u64::MAX - 8), "ends beyond its buffer view"),
        (&|g| g["bufferViews"][0]["byteStride"] = json!(4), "ends beyond its buffer view"),
        (&|g| g["bufferViews"][0]["byteStride"] = json!(0), "mesh.gltf"),
    ];
    for (edit, expected) in cases {
        let mut value = gltf(&inside());
        edit(&mut value);
        let said = read_alone(&value).unwrap_err();
        assert!(said.contains(expected), "{said}");
    }
}

/// Every way out of the folder is refused, and the same file inside is read: the control.
#[test]
fn a_mesh_reads_only_files_below_its_folder() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("mesh");
    fs::create_dir_all(folder.join("parts and more")).unwrap();
    let outside = place.path().join("outside.bin");
    for file in [&outside, &folder.join("here.bin"), &folder.join("parts and more/it.bin")] {
        fs::write(file, triangle()).unwrap();
    }
    for uri in ["here.bin", "./here.bin", "parts%20and%20more/it.bin", "parts and more/it.bin"] {
        let read = read_in(&folder, &gltf(uri));
        assert_eq!(read.map(|mesh| mesh.triangles.len()), Ok(1), "{uri}");
    }
    let mut out = vec![
        format!("file://{}", outside.display()),
        format!("FILE:{}", outside.display()),
        outside.display().to_string(),
        "../outside.bin".to_owned(),
        "%2e%2e/outside.bin".to_owned(),
        "parts%20and%20more/../../outside.bin".to_owned(),
        "..\\outside.bin".to_owned(),
        "https://example.org/outside.bin".to_owned(),
        "/dev/zero".to_owned(),
        "%2Fdev%2Fzero".to_owned(),
        "here.bin%00".to_owned(),
        "parts and more".to_owned(),
        "data:application/octet-stream,AAAA".to_owned(),
        "data:application/octet-stream;base64,!".to_owned(),
    ];
    #[cfg(unix)]
    {
        let link = |to: &Path, name: &str| {
            std::os::unix::fs::symlink(to, folder.join(name)).unwrap();
            name.to_owned()
        };
        out.push(link(&outside, "link.bin"));
        out.push(link(place.path(), "up") + "/outside.bin");
        out.push(link(Path::new("/dev/zero"), "zero.bin"));
        out.push(link(Path::new("loop.bin"), "loop.bin"));
        let made = std::process::Command::new("mkfifo").arg(folder.join("pipe.bin")).status();
        assert!(made.unwrap().success());
        out.push("pipe.bin".to_owned());
        link(&folder.join("here.bin"), "inner.bin");
        assert!(read_in(&folder, &gltf("inner.bin")).is_ok(), "a link inside the folder");
    }
    for uri in &out {
        let said = read_in(&folder, &gltf(uri)).unwrap_err();
        assert!(said.contains("its buffers cannot be read"), "{uri}: {said}");
        // the same name for a picture: only the colour is lost
        let mut value = gltf(&inside());
        value["images"] = json!([{ "uri": uri }]);
        value["textures"] = json!([{"source": 0}]);
        value["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        value["meshes"][0]["primitives"][0]["material"] = json!(0);
        let mesh = read_in(&folder, &value).unwrap();
        assert!(mesh.notes[0].contains("using the material's plain colour"), "{:?}", mesh.notes);
    }
}

#[test]
fn the_same_holds_for_obj_and_its_materials() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("mesh");
    fs::create_dir(&folder).unwrap();
    let red = "newmtl skin\nKd 1 0 0\n";
    fs::write(place.path().join("outside.mtl"), red).unwrap();
    fs::write(folder.join("here.mtl"), red).unwrap();
    let text = |library: &str| {
        format!("mtllib {library}\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    };
    let mesh = |library: &str| {
        let file = folder.join("mesh.obj");
        fs::write(&file, text(library)).unwrap();
        read(&file).unwrap()
    };
    assert_eq!(mesh("here.mtl").colour.texels, [[255, 0, 0, 255]]);
    for library in ["../outside.mtl", "/dev/zero", "/etc/passwd"] {
        let mesh = mesh(library);
        assert_eq!(mesh.colour.texels, [[128, 128, 128, 255]], "{library}");
        assert!(mesh.notes[0].contains("below the mesh's folder"), "{:?}", mesh.notes);
    }
    for picture in ["../outside.mtl", "/dev/zero"] {
        fs::write(folder.join("here.mtl"), format!("{red}map_Kd {picture}\n")).unwrap();
        let mesh = mesh("here.mtl");
        assert_eq!(mesh.colour.texels, [[255, 0, 0, 255]], "{picture}");
        assert!(mesh.notes[0].contains("below the mesh's folder"), "{:?}", mesh.notes);
    }
    for (text, expected) in [
        ("v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "vertex 2 has no valid position"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "out of bounds"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9\n", "cannot be read as OBJ"),
        ("v 0 0 0\nv 1 0", "cannot be read as OBJ"),
    ] {
        let file = folder.join("bad.obj");
        fs::write(&file, text).unwrap();
        let said = read(&file).unwrap_err().to_string();
        assert!(said.contains(expected), "{said}");
    }
    // 25 million corners in one face
    let mut face = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nf");
    face.push_str(&" 1 2 3".repeat(8 * 1024 * 1024 + 1));
    let file = folder.join("face.obj");
    fs::write(&file, face).unwrap();
    let said = read(&file).unwrap_err().to_string();
    assert!(said.contains("more than 25165824 corners of faces"), "{said}");
}

#[cfg(unix)]
#[test]
fn the_mesh_itself_is_a_regular_file_with_an_end() {
    let place = tempfile::tempdir().unwrap();
    for name in ["pipe.gltf", "pipe.obj"] {
        let pipe = place.path().join(name);
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let said = read(&pipe).unwrap_err().to_string();
        assert!(said.contains("is not a regular file"), "{said}");
    }
    for name in ["zero.glb", "zero.obj"] {
        let device = place.path().join(name);
        std::os::unix::fs::symlink("/dev/zero", &device).unwrap();
        let said = read(&device).unwrap_err().to_string();
        assert!(said.contains("is not a regular file"), "{said}");
    }
    let huge = place.path().join("huge.obj");
    fs::File::create(&huge).unwrap().set_len(1 << 40).unwrap();
    let said = read(&huge).unwrap_err().to_string();
    assert!(said.contains("above the limit of 536870912"), "{said}");
    fs::create_dir(place.path().join("folder.obj")).unwrap();
    let said = read(&place.path().join("folder.obj")).unwrap_err().to_string();
    assert!(said.contains("is a folder"), "{said}");
    // a file cut short, at every place
    let whole = gltf(&inside()).to_string();
    for end in (0..whole.len()).step_by(37) {
        let file = place.path().join("cut.gltf");
        fs::write(&file, &whole[..end]).unwrap();
        assert!(read(&file).is_err(), "cut after {end} bytes");
    }
}
