//! Meshes from files: what is read, what is mended and said, what is refused.

use std::fs;
use std::path::PathBuf;

use base64::{Engine, prelude::BASE64_STANDARD};
use diffraction_harness::scene::{Mesh, read};
use glam::{DVec3, DVec4};
use serde_json::{Value, json};

/// A square in the plane z = 0 of two triangles, as the attributes of a glTF file.
struct Square {
    positions: [[f32; 3]; 4],
    normals: Option<[[f32; 3]; 4]>,
    tangents: Option<[[f32; 4]; 4]>,
    uvs: Option<[[f32; 2]; 4]>,
    angles: Option<[f32; 4]>,
    indices: Vec<u16>,
}

impl Square {
    fn whole() -> Square {
        Square {
            positions: [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            normals: Some([[0.0, 0.0, 1.0]; 4]),
            tangents: Some([[1.0, 0.0, 0.0, 1.0]; 4]),
            // v runs down in the picture
            uvs: Some([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]),
            angles: Some([0.0, 0.1, 0.2, 0.3]),
            indices: vec![0, 1, 2, 0, 2, 3],
        }
    }

    fn gltf(&self) -> Value {
        let (mut data, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
        let mut attributes = serde_json::Map::new();
        let mut add = |bytes: &[u8], count: usize, component: u32, ty: &str, more: Value| {
            views.push(json!({"buffer": 0, "byteOffset": data.len(), "byteLength": bytes.len()}));
            data.extend_from_slice(bytes);
            data.resize(data.len().next_multiple_of(4), 0);
            let mut accessor = json!({"bufferView": views.len() - 1, "componentType": component, "count": count, "type": ty});
            accessor.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            accessors.push(accessor);
            accessors.len() - 1
        };
        let ends = json!({"min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0]});
        let bytes: &[u8] = bytemuck::cast_slice(&self.positions);
        attributes.insert("POSITION".into(), add(bytes, 4, 5126, "VEC3", ends).into());
        let lists: [(&str, Option<&[u8]>, &str); 4] = [
            ("NORMAL", self.normals.as_ref().map(|n| bytemuck::cast_slice(n)), "VEC3"),
            ("TANGENT", self.tangents.as_ref().map(|t| bytemuck::cast_slice(t)), "VEC4"),
            ("TEXCOORD_0", self.uvs.as_ref().map(|t| bytemuck::cast_slice(t)), "VEC2"),
            ("_ORIENTATION", self.angles.as_ref().map(|t| bytemuck::cast_slice(t)), "SCALAR"),
        ];
        for (name, bytes, ty) in lists {
            if let Some(bytes) = bytes {
                attributes.insert(name.into(), add(bytes, 4, 5126, ty, json!({})).into());
            }
        }
        let indices = bytemuck::cast_slice(&self.indices);
        let indices = add(indices, self.indices.len(), 5123, "SCALAR", json!({}));
        let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&data));
        json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": attributes, "indices": indices}]}],
            "buffers": [{"uri": uri, "byteLength": data.len()}],
            "bufferViews": views,
            "accessors": accessors,
        })
    }

    fn read(&self) -> Result<Mesh, String> {
        read_json(&self.gltf())
    }
}

/// The error's text is that of `Error`, with the file's name left out.
fn read_json(gltf: &Value) -> Result<Mesh, String> {
    read_text("square.gltf", &gltf.to_string())
}

fn read_text(name: &str, text: &str) -> Result<Mesh, String> {
    let folder = tempfile::tempdir().unwrap();
    let file: PathBuf = folder.path().join(name);
    fs::write(&file, text).unwrap();
    read(&file).map_err(|error| error.to_string().replace(&file.display().to_string(), name))
}

fn notes(mesh: &Mesh) -> String {
    mesh.notes
        .iter()
        .map(|note| note.rsplit("gltf: ").next().unwrap())
        .collect::<Vec<_>>()
        .join("; ")
}

#[test]
fn a_whole_file_is_taken_as_it_is() {
    let mesh = Square::whole().read().unwrap();
    assert_eq!(mesh.notes, Vec::<String>::new());
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 2));
    let vertex = mesh.vertices[2];
    assert_eq!((vertex.position, vertex.normal), (DVec3::new(1.0, 1.0, 0.0), DVec3::Z));
    assert_eq!(vertex.tangent, DVec4::new(1.0, 0.0, 0.0, 1.0));
    assert!((vertex.orientation_angle - 0.2).abs() < 1e-7);
}

#[test]
fn nodes_move_scale_and_mirror() {
    let mut gltf = Square::whole().gltf();
    gltf["nodes"] = json!([{"children": [1], "translation": [0.0, 0.0, 5.0]}, {"mesh": 0, "scale": [-2.0, 1.0, 1.0]}]);
    let mesh = read_json(&gltf).unwrap();
    let vertex = mesh.vertices[1];
    assert_eq!(vertex.position, DVec3::new(-2.0, 0.0, 5.0));
    assert_eq!(vertex.normal, DVec3::Z);
    // the bitangent still points up
    assert_eq!(vertex.tangent, DVec4::new(-1.0, 0.0, 0.0, -1.0));
}

#[test]
fn missing_tangents_follow_the_texture_and_its_mirror_image() {
    for (mirrored, expected) in [(false, [1.0, 0.0, 0.0, 1.0]), (true, [-1.0, 0.0, 0.0, -1.0])] {
        let mut square = Square { tangents: None, ..Square::whole() };
        if mirrored {
            square.uvs.as_mut().unwrap().iter_mut().for_each(|uv| uv[0] = 1.0 - uv[0]);
        }
        let mesh = square.read().unwrap();
        assert_eq!(
            notes(&mesh),
            "4 vertices have no tangent; all tangents generated by MikkTSpace"
        );
        for vertex in &mesh.vertices {
            assert!(vertex.tangent.distance(DVec4::from(expected)) < 1e-6, "{}", vertex.tangent);
        }
    }
}

#[test]
fn without_texture_coordinates_tangents_are_arbitrary_and_said_to_be() {
    let mesh = Square { tangents: None, uvs: None, ..Square::whole() }.read().unwrap();
    let said = notes(&mesh);
    assert!(said.contains("4 vertices have no valid texture coordinates"), "{said}");
    assert!(said.contains("6 corners got no tangent from their texture coordinates"), "{said}");
    assert!(mesh.vertices.iter().all(|v| (v.tangent.truncate().length() - 1.0).abs() < 1e-6));
}

#[test]
fn normals_that_are_no_numbers_come_from_the_triangles() {
    let mut square = Square::whole();
    square.normals.as_mut().unwrap()[1] = [f32::NAN; 3];
    square.normals.as_mut().unwrap()[3] = [0.0; 3];
    let mesh = square.read().unwrap();
    assert_eq!(
        notes(&mesh),
        "2 normals are missing or invalid; computed from the adjacent triangles"
    );
    assert!(mesh.vertices.iter().all(|v| v.normal == DVec3::Z));
}

#[test]
fn triangles_without_area_are_left_out() {
    let mut square = Square::whole();
    square.indices.extend([0, 0, 1]);
    let mesh = square.read().unwrap();
    assert_eq!(notes(&mesh), "1 triangles without area left out");
    assert_eq!(mesh.triangles.len(), 2);
    let nothing = Square { indices: vec![0, 0, 1], ..Square::whole() }.read().unwrap_err();
    assert_eq!(nothing, "square.gltf: has no triangle with an area");
}

#[test]
fn a_missing_texture_is_said_and_the_plain_colour_taken() {
    let mut gltf = Square::whole().gltf();
    gltf["images"] = json!([{"uri": "nowhere.png"}]);
    gltf["textures"] = json!([{"source": 0}]);
    gltf["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1.0, 0.0, 0.0, 1.0]}}]);
    gltf["meshes"][0]["primitives"][0]["material"] = json!(0);
    let mesh = read_json(&gltf).unwrap();
    assert_eq!(mesh.colour.texels, [[255, 0, 0, 255]]);
    assert!(
        mesh.notes[0].contains("its texture: cannot be read: \"nowhere.png\""),
        "{:?}",
        mesh.notes
    );
    let obj = "mtllib nowhere.mtl\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    let mesh = read_text("one.obj", obj).unwrap();
    assert!(mesh.notes[0].contains("its materials cannot be read"), "{:?}", mesh.notes);
    // OBJ counts v upwards
    let tangents = mesh.vertices.iter().map(|v| v.tangent);
    assert!(tangents.into_iter().all(|t| t.distance(DVec4::new(1.0, 0.0, 0.0, 1.0)) < 1e-6));
}

#[test]
fn broken_files_are_refused_by_name_and_cause() {
    let edited = |edit: &dyn Fn(&mut Value)| {
        let mut gltf = Square::whole().gltf();
        edit(&mut gltf);
        read_json(&gltf).unwrap_err()
    };
    type Edit<'a> = &'a dyn Fn(&mut Value);
    let cases: [(Edit<'_>, &str); 8] = [
        (
            &|g| g["bufferViews"][0]["byteLength"] = json!(100_000),
            "buffer view 0 ends beyond its buffer",
        ),
        (&|g| g["accessors"][0]["count"] = json!(1000), "accessor 0 ends beyond its buffer view"),
        (&|g| g["accessors"][0]["count"] = json!(0), "accessor 0 is empty"),
        (&|g| g["accessors"][1]["type"] = json!("VEC2"), "accessor 1 is Vec2 of F32"),
        (&|g| g["scenes"] = json!([]), "cannot be read as glTF 2.0"),
        (&|g| g["buffers"][0]["uri"] = json!("nowhere.bin"), "its buffers cannot be read"),
        (
            &|g| g["accessors"][5]["componentType"] = json!(5126),
            "accessor 5 ends beyond its buffer view",
        ),
        (&|g| g["meshes"][0]["primitives"][0]["mode"] = json!(1), "has no triangle with an area"),
    ];
    for (edit, expected) in cases {
        let said = edited(edit);
        assert!(said.starts_with("square.gltf: ") && said.contains(expected), "{said}");
    }
    let far = Square { indices: vec![0, 1, 9], ..Square::whole() }.read().unwrap_err();
    assert!(far.contains("a triangle has the vertex index 9, but there are 4 vertices"), "{far}");
    let mut square = Square::whole();
    square.positions[2][1] = f32::INFINITY;
    let said = square.read().unwrap_err();
    assert!(said.contains("vertex 2 has no valid position"), "{said}");
    assert!(read_text("no.gltf", "{").unwrap_err().contains("cannot be read as glTF 2.0"));
    assert!(read_text("no.glb", "glTF").unwrap_err().contains("cannot be read as glTF 2.0"));
    assert!(read_text("no.obj", "f 1 2 3\n").unwrap_err().contains("cannot be read as OBJ"));
    assert_eq!(
        read_text("no.stl", "").unwrap_err(),
        "no.stl: the name must end in .gltf, .glb or .obj (convert the file)"
    );
}
