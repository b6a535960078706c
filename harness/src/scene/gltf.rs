//! Reads glTF 2.0, text or binary.

use std::path::Path;

use diffraction_shaders::error::{Error, Result};
use glam::{DMat4, DVec2, DVec3, DVec4};
use gltf::accessor::{DataType, Dimensions, sparse::IndexType};
use gltf::buffer::{Source, View};
use gltf::mesh::{Mode, Semantic};
use gltf::{Accessor, Document, Primitive};

use super::named::{MAX_TRIANGLES, MAX_VERTICES, Named, within};
use super::raw::Raw;
use crate::drivers::ColourMap;

/// Attribute of the orientation field, in radians. The reader removes the underscore of such names.
const ORIENTATION: &str = "ORIENTATION";

/// Maximum nodes of a scene, one above the other or side by side.
const MAX_NODES: usize = 1 << 16;
/// Maximum parts: primitives, each counted in every node that has it.
const MAX_PARTS: usize = 1 << 16;
/// Maximum notes about parts that are left out; the rest is counted.
const MAX_NOTES: usize = 8;

/// The buffers of a file, read.
type Buffers = Vec<Vec<u8>>;

/// All triangles of the default scene in one mesh, in the file's world. The colour is the first material's base colour, the
/// orientation field is the vertices' attribute `_ORIENTATION`. Bones, morphs and further materials are ignored.
pub(super) fn read(path: &Path) -> Result<Raw> {
    let name = path.display().to_string();
    let again = |cause: String| Error::new(&name, cause).remedy("export it again");
    let (mut files, bytes) = Named::open(path)?;
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes)
        .map_err(|error| again("cannot be read as glTF 2.0".to_owned()).source(error))?;
    drop(bytes);
    let buffers = buffers(&document, blob, &mut files)
        .map_err(|error| Error::new(&name, "its buffers cannot be read").source(error))?;
    bounded(&document, &buffers).map_err(again)?;
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
    within(document.nodes().len(), MAX_NODES, "nodes").map_err(again)?;
    // the nodes of a scene are trees (glTF 2.0, 3.5.2); a node below itself would never end
    let mut is_seen = vec![false; document.nodes().len()];
    let (mut parts, mut coloured, mut left_out) = (0, false, 0);
    while let Some((node, above)) = nodes.pop() {
        if std::mem::replace(&mut is_seen[node.index()], true) {
            return Err(again(format!(
                "node {} is below itself, or below two nodes: nodes must form trees",
                node.index()
            )));
        }
        let [x, y, z, w] = node.transform().matrix();
        let local = DMat4::from_cols_array_2d(&[x, y, z, w].map(|c| c.map(f64::from)));
        let world = above * local;
        nodes.extend(node.children().map(|child| (child, world)));
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            parts += 1;
            within(parts, MAX_PARTS, "primitives").map_err(again)?;
            if primitive.mode() != Mode::Triangles {
                left_out += 1;
                if left_out <= MAX_NOTES {
                    raw.notes.push(format!(
                        "{name}: {:?} left out: only triangles are drawn",
                        primitive.mode()
                    ));
                }
                continue;
            }
            append(&mut raw, &primitive, &buffers, world).map_err(again)?;
            if !coloured {
                coloured = true;
                raw.colour = colour(&primitive, &mut files, &buffers, &name, &mut raw.notes);
            }
        }
    }
    if left_out > MAX_NOTES {
        raw.notes.push(format!("{name}: {} more parts left out", left_out - MAX_NOTES));
    }
    Ok(raw)
}

/// The content of all buffers, each at least as long as the file says.
fn buffers(document: &Document, blob: Option<Vec<u8>>, files: &mut Named) -> Result<Buffers> {
    let mut blob = blob;
    let mut read = Vec::new();
    for buffer in document.buffers() {
        let subject = format!("buffer {}", buffer.index());
        let content = match buffer.source() {
            Source::Bin => {
                blob.take().ok_or_else(|| Error::new(&subject, "is missing from the file"))?
            }
            Source::Uri(uri) => files.uri(uri)?,
        };
        if content.len() < buffer.length() {
            let cause = format!("has {} bytes, {} are stated", content.len(), buffer.length());
            return Err(Error::new(subject, cause));
        }
        read.push(content);
    }
    Ok(read)
}

/// Appends one primitive. Missing lists are filled with NaN, which is repaired later.
fn append(
    raw: &mut Raw,
    primitive: &Primitive<'_>,
    buffers: &Buffers,
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
    let bytes = |buffer: gltf::Buffer<'_>| buffers.get(buffer.index()).map(Vec::as_slice);
    let reader = primitive.reader(bytes);
    let first = raw.positions.len();
    let positions = reader.read_positions().ok_or("a primitive has no positions")?;
    within(first + positions.len(), MAX_VERTICES, "vertices")?;
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
    let corners = primitive.indices().map_or(count, |accessor| accessor.count());
    within(raw.triangles.len() + corners / 3, MAX_TRIANGLES, "triangles")?;
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
    // a longer list than that of the positions has no vertices for the rest
    list.extend(items.take(length.saturating_sub(list.len())));
    list.resize(length, missing);
}

/// Checks that every accessor is inside its buffer, which the reader assumes, and has no more items than a mesh may have.
fn bounded(document: &Document, buffers: &Buffers) -> Result<(), String> {
    for view in document.views() {
        let end = view.offset().checked_add(view.length());
        let held = buffers.get(view.buffer().index()).map_or(0, Vec::len);
        if end.is_none_or(|end| end > held) {
            return Err(format!("buffer view {} ends beyond its buffer", view.index()));
        }
    }
    let inside = |view: &View<'_>, offset: usize, count: usize, size: usize| {
        let stride = view.stride().unwrap_or(size);
        let last = stride.checked_mul(count - 1);
        let end = last.and_then(|last| last.checked_add(size)?.checked_add(offset));
        stride >= size && end.is_some_and(|end| end <= view.length())
    };
    for accessor in document.accessors() {
        let (index, count) = (accessor.index(), accessor.count());
        if count == 0 {
            return Err(format!("accessor {index} is empty"));
        }
        within(count, 3 * MAX_TRIANGLES, "items in an accessor")?;
        let size = accessor.size();
        if accessor.view().is_some_and(|view| !inside(&view, accessor.offset(), count, size)) {
            return Err(format!("accessor {index} ends beyond its buffer view"));
        }
        // such an accessor states only some items, and where they are
        let Some(sparse) = accessor.sparse() else { continue };
        let (places, values) = (sparse.indices(), sparse.values());
        let width = match places.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let stated = 1..=count;
        if !stated.contains(&sparse.count())
            || !inside(&places.view(), places.offset(), sparse.count(), width)
            || !inside(&values.view(), values.offset(), sparse.count(), size)
        {
            return Err(format!("accessor {index}: its sparse items end beyond their buffer view"));
        }
    }
    Ok(())
}

/// The base colour's texture, else its factor.
fn colour(
    primitive: &Primitive<'_>,
    files: &mut Named,
    buffers: &Buffers,
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
    let about = format!("{name}: its texture");
    let picture = match texture.texture().source().source() {
        gltf::image::Source::View { view, .. } => {
            let data = &buffers[view.buffer().index()];
            ColourMap::decode(&about, &data[view.offset()..view.offset() + view.length()])
        }
        gltf::image::Source::Uri { uri, .. } => files
            .uri(uri)
            .map_err(|error| Error::new(&about, "cannot be read").source(error))
            .and_then(|bytes| ColourMap::decode(&about, &bytes)),
    };
    picture.unwrap_or_else(|error| {
        notes.push(format!("{error}; using the material's plain colour"));
        plain
    })
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}
