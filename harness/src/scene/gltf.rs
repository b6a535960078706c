//! Reads glTF 2.0, text or binary.

use std::path::Path;

use diffraction_shaders::error::{Error, Result};
use glam::{DMat4, DVec2, DVec3, DVec4};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::{Mode, Semantic};
use gltf::{Accessor, Document, Primitive};

use super::raw::Raw;
use crate::drivers::ColourMap;

/// Attribute of the orientation field, in radians. The reader removes the underscore of such names.
const ORIENTATION: &str = "ORIENTATION";

/// All triangles of the default scene in one mesh, in the file's world. The colour is the first material's base colour, the
/// orientation field is the vertices' attribute `_ORIENTATION`. Bones, morphs and further materials are ignored.
pub(super) fn read(path: &Path) -> Result<Raw> {
    let name = path.display().to_string();
    let fail = |what: &str, error: gltf::Error| {
        Error::new(&name, what).source(error).remedy("export it again")
    };
    let bytes =
        std::fs::read(path).map_err(|error| Error::new(&name, "cannot be read").source(error))?;
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes)
        .map_err(|error| fail("cannot be read as glTF 2.0", error))?;
    let base = path.parent().unwrap_or(Path::new("."));
    let buffers = gltf::import_buffers(&document, Some(base), blob)
        .map_err(|error| fail("its buffers cannot be read", error))?;
    bounded(&document, &buffers)
        .map_err(|cause| Error::new(&name, cause).remedy("export it again"))?;
    let mut raw = Raw {
        positions: Vec::new(),
        normals: Some(Vec::new()),
        tangents: Some(Vec::new()),
        uvs: Some(Vec::new()),
        angles: Some(Vec::new()),
        triangles: Vec::new(),
        colour: ColourMap::plain([128; 3]),
        notes: Vec::new(),
    };
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| Error::new(&name, "has no scene"))?;
    let mut nodes: Vec<(gltf::Node<'_>, DMat4)> =
        scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    let mut coloured = false;
    while let Some((node, above)) = nodes.pop() {
        let [x, y, z, w] = node.transform().matrix();
        let local = DMat4::from_cols_array_2d(&[x, y, z, w].map(|c| c.map(f64::from)));
        let world = above * local;
        nodes.extend(node.children().map(|child| (child, world)));
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            if primitive.mode() != Mode::Triangles {
                raw.notes.push(format!(
                    "{name}: {:?} left out: only triangles are drawn",
                    primitive.mode()
                ));
                continue;
            }
            append(&mut raw, &primitive, &buffers, world)
                .map_err(|cause| Error::new(&name, cause).remedy("export it again"))?;
            if !coloured {
                coloured = true;
                raw.colour = colour(&primitive, base, &buffers, &name, &mut raw.notes);
            }
        }
    }
    Ok(raw)
}

/// Appends one primitive. Missing lists are filled with NaN, which is repaired later.
fn append(
    raw: &mut Raw,
    primitive: &Primitive<'_>,
    buffers: &[gltf::buffer::Data],
    world: DMat4,
) -> Result<(), String> {
    let typed = |accessor: Option<Accessor<'_>>, dimensions| match accessor {
        Some(a) if a.data_type() != DataType::F32 || a.dimensions() != dimensions => {
            Err(format!("accessor {} is {:?} of {:?}", a.index(), a.dimensions(), a.data_type()))
        }
        _ => Ok(()),
    };
    typed(primitive.get(&Semantic::Positions), Dimensions::Vec3)?;
    typed(primitive.get(&Semantic::Normals), Dimensions::Vec3)?;
    typed(primitive.get(&Semantic::Tangents), Dimensions::Vec4)?;
    let angles = primitive.get(&Semantic::Extras(ORIENTATION.to_owned()));
    typed(angles.clone(), Dimensions::Scalar)?;
    let integer = |a: &Accessor<'_>| {
        matches!(a.data_type(), DataType::U8 | DataType::U16 | DataType::U32)
            && a.dimensions() == Dimensions::Scalar
    };
    if primitive.indices().is_some_and(|accessor| !integer(&accessor)) {
        return Err("its indices are not integers".into());
    }
    let bytes = |buffer: gltf::Buffer<'_>| buffers.get(buffer.index()).map(|b| &b.0[..]);
    let reader = primitive.reader(bytes);
    let first = raw.positions.len();
    let positions = reader.read_positions().ok_or("a primitive has no positions")?;
    raw.positions.extend(positions.map(|p| world.transform_point3(vector(p))));
    let count = raw.positions.len() - first;
    let turned = world.inverse().transpose();
    let mirrored = world.determinant() < 0.0;
    let normals = reader.read_normals().into_iter().flatten();
    let normals = normals.map(|n| turned.transform_vector3(vector(n)));
    fill(&mut raw.normals, normals, first + count, DVec3::ZERO);
    let tangents = reader.read_tangents().into_iter().flatten().map(|[x, y, z, w]| {
        let along = world.transform_vector3(vector([x, y, z]));
        along.extend(f64::from(if mirrored { -w } else { w }))
    });
    fill(&mut raw.tangents, tangents, first + count, DVec4::ZERO);
    let uvs = reader.read_tex_coords(0).into_iter().flat_map(|uvs| uvs.into_f32());
    let uvs = uvs.map(|[u, v]| DVec2::new(u.into(), v.into()));
    fill(&mut raw.uvs, uvs, first + count, DVec2::NAN);
    let angles = angles.and_then(|a| gltf::accessor::Iter::<f32>::new(a, bytes));
    fill(&mut raw.angles, angles.into_iter().flatten().map(f64::from), first + count, 0.0);
    let indices: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..count as u32).collect(),
    };
    if let Some(bad) = indices.iter().find(|i| **i as usize >= count) {
        return Err(format!(
            "a triangle has the vertex index {bad}, but there are {count} vertices"
        ));
    }
    let corner = |i: u32| first as u32 + i;
    // if the transform mirrors space, front faces must stay front faces
    let turn = |t: &[u32]| if mirrored { [t[0], t[2], t[1]] } else { [t[0], t[1], t[2]] };
    raw.triangles.extend(indices.chunks_exact(3).map(turn).map(|t| t.map(corner)));
    Ok(())
}

/// Appends values and fills the list up to `length`.
fn fill<T: Clone>(
    list: &mut Option<Vec<T>>,
    items: impl Iterator<Item = T>,
    length: usize,
    missing: T,
) {
    let list = list.get_or_insert_default();
    list.extend(items);
    list.resize(length, missing);
}

/// Checks that every accessor is inside its buffer, which the reader assumes.
fn bounded(document: &Document, buffers: &[gltf::buffer::Data]) -> Result<(), String> {
    for view in document.views() {
        let end = view.offset().checked_add(view.length());
        let held = buffers.get(view.buffer().index()).map_or(0, |buffer| buffer.0.len());
        if end.is_none_or(|end| end > held) {
            return Err(format!("buffer view {} ends beyond its buffer", view.index()));
        }
    }
    for accessor in document.accessors() {
        let index = accessor.index();
        if accessor.count() == 0 {
            return Err(format!("accessor {index} is empty"));
        }
        let Some(view) = accessor.view() else { continue };
        let stride = view.stride().unwrap_or(accessor.size());
        let last = stride.checked_mul(accessor.count() - 1);
        let end = last.and_then(|l| l.checked_add(accessor.size())?.checked_add(accessor.offset()));
        if end.is_none_or(|end| end > view.length()) {
            return Err(format!("accessor {index} ends beyond its buffer view"));
        }
    }
    Ok(())
}

/// The base colour's texture, else its factor.
fn colour(
    primitive: &Primitive<'_>,
    base: &Path,
    buffers: &[gltf::buffer::Data],
    name: &str,
    notes: &mut Vec<String>,
) -> ColourMap {
    let material = primitive.material().pbr_metallic_roughness();
    let [r, g, b, _] = material.base_color_factor();
    let code = |c: f32| {
        (255.0 * diffraction_shaders::optics::colour::srgb_encode(f64::from(c))).round() as u8
    };
    let plain = ColourMap::plain([r, g, b].map(code));
    let Some(texture) = material.base_color_texture() else { return plain };
    let source = texture.texture().source();
    let picture = match source.source() {
        gltf::image::Source::View { view, .. } => {
            let data = &buffers[view.buffer().index()].0;
            ColourMap::decode(name, &data[view.offset()..view.offset() + view.length()])
        }
        gltf::image::Source::Uri { uri, .. } => {
            // textures inside the file have long names
            let short: String = uri.chars().take(80).collect();
            let cause = format!("its texture \"{short}\" cannot be read");
            gltf::image::Data::from_source(source.source(), Some(base), buffers)
                .map_err(|e| Error::new(name, cause).source(e))
                .and_then(|data| convert(name, &data))
        }
    };
    picture.unwrap_or_else(|error| {
        notes.push(format!("{error}; using the material's plain colour"));
        plain
    })
}

fn convert(name: &str, data: &gltf::image::Data) -> Result<ColourMap> {
    let channels = match data.format {
        gltf::image::Format::R8G8B8 => 3,
        gltf::image::Format::R8G8B8A8 => 4,
        other => {
            return Err(Error::new(name, format!("its texture has the format {other:?}"))
                .remedy("convert it to 8-bit RGB or RGBA"));
        }
    };
    let texels = data.pixels.chunks_exact(channels).map(|p| [p[0], p[1], p[2], 255]).collect();
    Ok(ColourMap { width: data.width, height: data.height, texels })
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}
