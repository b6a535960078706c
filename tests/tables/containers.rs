//! Tables in KTX2 and OpenEXR, read back by the readers of their crates: the bits of the raw texels.

use std::{fs, io::Cursor, path::Path};

use diffraction_shaders::Compiler;
use diffraction_shaders::package::{self, Package};
use diffraction_shaders::plan::{Container, Plan};
use diffraction_shaders::random::SplitMix64;
use diffraction_shaders::tables::TexelFormat;
use diffraction_shaders::tables::container::{Atlas, Shape, decode, encode};
use exr::image::{FlatSamples, read::read as reader};
use exr::prelude::{ReadChannels, ReadLayers};
use serde_json::Value;

const BOTH: [Container; 2] = [Container::Ktx2, Container::Exr];

fn shapes() -> Vec<Shape> {
    use TexelFormat::{Rg16Float, Rg32Float, Rgb9e5Ufloat, Rgba16Float, Rgba32Float};
    let sizes = [(31, 7, 10), (3, 5, 7), (1, 1, 1), (81, 2, 0), (5, 3, 0), (2, 40, 6)];
    let formats = [Rg16Float, Rgba16Float, Rg32Float, Rgba32Float, Rgb9e5Ufloat];
    let shape =
        |format| sizes.map(|(width, height, layers)| Shape { format, width, height, layers });
    formats.into_iter().flat_map(shape).collect()
}

/// Any bits, among them those of infinities, of negative zero, of no number.
fn bits(shape: &Shape) -> Vec<u8> {
    let mut random = SplitMix64::new(7);
    let mut texels: Vec<u8> =
        (0..shape.byte_count().unwrap()).map(|_| random.next_u64() as u8).collect();
    let special = match shape.format {
        // every word of shared exponents has a meaning, but not every one is what rounding gives
        TexelFormat::Rgb9e5Ufloat => {
            let numbers = shape.format.decode(&texels);
            return shape.format.encode(&numbers);
        }
        TexelFormat::Rg16Float | TexelFormat::Rgba16Float => {
            [0x7c00_u16, 0x8000].map(|b| b.to_le_bytes().to_vec()).concat()
        }
        _ => [f32::NEG_INFINITY, -0.0].map(|v| v.to_le_bytes().to_vec()).concat(),
    };
    texels[..special.len()].copy_from_slice(&special);
    texels
}

/// The texels of an OpenEXR file, by its own reader; the rest of the atlas is 0.
fn read_exr(file: &[u8], shape: &Shape) -> Vec<u8> {
    let image = reader()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(file))
        .unwrap();
    let (layer, atlas) = (image.layer_data, Atlas::new(shape));
    assert_eq!((layer.size.x(), layer.size.y()), (atlas.width, atlas.height));
    let names = &["R", "G", "B", "A"][..shape.format.channels()];
    let planes: Vec<Vec<Vec<u8>>> = names
        .iter()
        .map(|name| {
            let mut channels = layer.channel_data.list.iter();
            match &channels.find(|c| c.name.eq(name)).unwrap().sample_data {
                FlatSamples::F16(v) => v.iter().map(|v| v.to_le_bytes().to_vec()).collect(),
                FlatSamples::F32(v) => v.iter().map(|v| v.to_le_bytes().to_vec()).collect(),
                FlatSamples::U32(_) => panic!("integers"),
            }
        })
        .collect();
    assert_eq!(layer.channel_data.list.len(), planes.len());
    let mut texels = Vec::new();
    let mut seen = vec![false; atlas.width * atlas.height];
    for [x, y] in &atlas.offsets {
        for pixel in (0..shape.height)
            .flat_map(|row| (0..shape.width).map(move |column| (y + row, x + column)))
            .map(|(y, x)| y * atlas.width + x)
        {
            assert!(!std::mem::replace(&mut seen[pixel], true), "layers overlap");
            planes.iter().for_each(|plane| texels.extend(&plane[pixel]));
        }
    }
    let rest = (0..seen.len()).filter(|pixel| !seen[*pixel]);
    assert!(rest.into_iter().all(|p| planes.iter().all(|plane| plane[p].iter().all(|b| *b == 0))));
    texels
}

/// The texels of a KTX2 file, by its own reader, and what the format asks of its layout.
fn read_ktx2(file: &[u8], shape: &Shape) -> Vec<u8> {
    let ktx = ktx2::Reader::new(file).unwrap();
    let header = ktx.header();
    let (format, number) = match shape.format {
        TexelFormat::Rg16Float => (ktx2::Format::R16G16_SFLOAT, 2),
        TexelFormat::Rgba16Float => (ktx2::Format::R16G16B16A16_SFLOAT, 2),
        TexelFormat::Rg32Float => (ktx2::Format::R32G32_SFLOAT, 4),
        TexelFormat::Rgba32Float => (ktx2::Format::R32G32B32A32_SFLOAT, 4),
        TexelFormat::Rgb9e5Ufloat => (ktx2::Format::E5B9G9R9_UFLOAT_PACK32, 4),
    };
    assert_eq!((header.format, header.type_size), (Some(format), number));
    let size = [header.pixel_width, header.pixel_height, header.pixel_depth, header.layer_count];
    assert_eq!(size.map(|n| n as usize), [shape.width, shape.height, 0, shape.layers]);
    assert_eq!((header.face_count, header.level_count), (1, 1));
    assert_eq!(header.supercompression_scheme, None);
    assert_eq!((header.index.sgd_byte_offset, header.index.sgd_byte_length), (0, 0));
    assert_eq!((header.index.dfd_byte_offset % 4, header.index.kvd_byte_offset % 4), (0, 0));
    let basic = ktx.basic_dfd().unwrap();
    let texel = shape.format.texel_bytes();
    assert_eq!(usize::from(basic.bytes_planes[0]), texel);
    // a shared exponent is stored once for each channel
    let parts = if shape.format == TexelFormat::Rgb9e5Ufloat { 2 } else { 1 };
    assert_eq!(basic.sample_information.len(), parts * shape.format.channels());
    assert_eq!(basic.transfer_function, Some(ktx2::TransferFunction::Linear));
    let keys: Vec<_> = ktx.key_value_data().collect();
    assert_eq!(
        keys,
        [("KTXorientation", &b"rd\0"[..]), ("KTXwriter", &b"diffraction-shaders\0"[..])]
    );
    let levels: Vec<_> = ktx.levels().collect();
    assert_eq!(levels[0].uncompressed_byte_length as usize, levels[0].data.len());
    let start = levels[0].data.as_ptr() as usize - file.as_ptr() as usize;
    assert!(start.is_multiple_of(texel) && start.is_multiple_of(4), "{start}");
    assert_eq!(start + levels[0].data.len(), file.len());
    levels[0].data.to_vec()
}

#[test]
fn independent_readers_find_the_same_bits() {
    for shape in shapes() {
        let texels = bits(&shape);
        for container in BOTH {
            let file = encode(container, &shape, &texels).unwrap();
            assert_eq!(file, encode(container, &shape, &texels).unwrap(), "not deterministic");
            let read = match container {
                Container::Ktx2 => read_ktx2(&file, &shape),
                Container::Exr => read_exr(&file, &shape),
            };
            // half precision holds what shared exponents do
            let same = match (container, shape.format) {
                (Container::Exr, TexelFormat::Rgb9e5Ufloat) => {
                    let numbers = TexelFormat::Rg16Float.decode(&read);
                    numbers == shape.format.decode(&texels)
                }
                _ => read == texels,
            };
            assert!(same, "{container:?} {shape:?}");
            assert_eq!(decode(container, &shape, &file), Some(texels.clone()));
        }
    }
}

#[test]
fn damaged_files_and_other_shapes_are_no_containers() {
    for shape in shapes() {
        let texels = bits(&shape);
        for container in BOTH {
            assert!(encode(container, &shape, &texels[1..]).is_err());
            let file = encode(container, &shape, &texels).unwrap();
            for length in [0, 11, 79, 104, file.len() / 2, file.len() - 1] {
                let cut = &file[..length.min(file.len() - 1)];
                assert_eq!(decode(container, &shape, cut), None);
                let unreadable = match container {
                    Container::Ktx2 => ktx2::Reader::new(cut).is_err(),
                    Container::Exr => exr::prelude::read()
                        .no_deep_data()
                        .largest_resolution_level()
                        .all_channels()
                        .all_layers()
                        .all_attributes()
                        .from_buffered(Cursor::new(cut))
                        .is_err(),
                };
                assert!(unreadable, "{container:?} of {} bytes", cut.len());
            }
            for at in [0, 13, 21, 60, 110] {
                let mut changed = file.clone();
                changed[at] ^= 1;
                assert_eq!(decode(container, &shape, &changed), None, "{container:?} byte {at}");
            }
            let wider = Shape { width: shape.width + 1, ..shape };
            assert_eq!(decode(container, &wider, &file), None);
            let huge = Shape { width: usize::MAX, ..shape };
            assert_eq!(decode(container, &huge, &file), None);
        }
    }
}

#[test]
fn atlases_are_about_square_and_hold_every_layer() {
    let atlas = |width, height, layers| {
        let format = TexelFormat::Rgba32Float;
        Atlas::new(&Shape { format, width, height, layers })
    };
    let wide = atlas(31, 7, 10);
    assert_eq!((wide.columns, wide.rows, wide.width, wide.height), (2, 5, 62, 35));
    assert_eq!((wide.offsets[0], wide.offsets[3]), ([0, 0], [31, 7]));
    let square = atlas(9, 9, 10);
    assert_eq!((square.columns, square.rows), (4, 3));
    let plain = atlas(81, 2, 0);
    assert_eq!((plain.columns, plain.rows, plain.offsets.len()), (1, 1, 1));
}

fn package(tables: &str) -> Package {
    let text = format!(
        r#"schema = 1
[[surface]]
name = "tiny"
grating = {{ kind = "blazed", period_um = 1.0, height_um = 0.02, pixels = 16 }}
[variants]
terms = [3]
table = ["f32", "f16"]
packing = ["paired", "single"]
[targets]
emit = ["wgsl"]
tables = {tables}
"#
    );
    let plan = Plan::parse(&text, Path::new("plan.toml")).unwrap();
    Compiler::new(&plan).compile().unwrap_or_else(|e| panic!("{e}"))
}

fn schema(name: &str) -> jsonschema::Validator {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("schemas/{name}.schema.json"));
    let schema = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    jsonschema::validator_for(&schema).unwrap()
}

fn tables(package: &Package) -> Vec<(String, Value)> {
    let paths = package.files().keys();
    let described = paths.filter(|p| p.starts_with("surfaces/") && p.ends_with(".json"));
    let read = |path: &String| {
        let value = serde_json::from_slice(package.bytes(path).unwrap()).unwrap();
        (path.trim_end_matches(".json").to_owned(), value)
    };
    described.map(read).collect()
}

/// The texels of a table, wherever they are until the package is written.
fn texels(package: &Package, stem: &str) -> Vec<u8> {
    package.files()[&format!("{stem}.bin")].content.read().unwrap().into_owned()
}

#[test]
fn packages_hold_the_containers_that_are_asked_for() {
    assert!(tables(&package("[\"bin\"]")).iter().all(|(_, d)| d.get("containers").is_none()));
    let package = package("[\"exr\", \"ktx2\", \"exr\"]");
    let (table_schema, found) = (schema("table"), tables(&package));
    let mut formats = std::collections::BTreeSet::new();
    for (stem, description) in &found {
        assert!(table_schema.is_valid(description), "{description}");
        let number = |key: &str| description[key].as_u64().unwrap() as usize;
        let shape = Shape {
            format: serde_json::from_value(description["format"].clone()).unwrap(),
            width: number("width"),
            height: number("height"),
            layers: if description["dimension"] == "2d" { 0 } else { number("layers") },
        };
        formats.insert(description["format"].to_string());
        let texels = texels(&package, stem);
        assert_eq!(read_ktx2(package.bytes(&format!("{stem}.ktx2")).unwrap(), &shape), texels);
        assert_eq!(read_exr(package.bytes(&format!("{stem}.exr")).unwrap(), &shape), texels);
        let containers = &description["containers"];
        assert_eq!(containers["exr"]["atlas"], serde_json::to_value(Atlas::new(&shape)).unwrap());
        for container in ["ktx2", "exr"] {
            let file = containers[container]["file"].as_str().unwrap();
            assert!(stem.ends_with(file.trim_end_matches(&format!(".{container}"))), "{file}");
        }
    }
    assert_eq!(formats.len(), 4, "{formats:?}");
    let manifest: Value = serde_json::from_slice(package.bytes("manifest.json").unwrap()).unwrap();
    assert!(schema("package").is_valid(&manifest));
}

#[test]
fn containers_are_checked_by_value_and_their_headers_by_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let package = package("[\"ktx2\", \"exr\"]");
    package::write(&package, &out).unwrap();
    let is_terms = |(_, d): &&(String, Value)| d["format"] == "rgba32float" && d["layers"] == 2;
    let tables = tables(&package);
    let (stem, _) = tables.iter().find(is_terms).unwrap();
    let texels = texels(&package, stem);
    let numbers: Vec<f32> =
        texels.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let largest = (0..numbers.len() / 2)
        .max_by(|a, b| numbers[*a].abs().total_cmp(&numbers[*b].abs()))
        .unwrap();
    for container in BOTH {
        let path = format!("{stem}.{}", container.as_str());
        let file = package.bytes(&path).unwrap();
        // the place of a number in the file, whatever its form
        let at = file.windows(4).rposition(|w| *w == numbers[largest].to_le_bytes()).unwrap();
        for (relative, stale) in [(1e-7_f32, false), (1e-5, true)] {
            let mut other = file.to_vec();
            let number = numbers[largest] * (1.0 + relative);
            assert_ne!(number.to_bits(), numbers[largest].to_bits());
            other[at..at + 4].copy_from_slice(&number.to_le_bytes());
            fs::write(out.join(&path), &other).unwrap();
            let report = package::check(&package, &out).unwrap();
            assert_eq!(report.is_stale(), stale, "{path} off by {relative}: {report:?}");
        }
        let writer = file.windows(11).position(|w| w == b"diffraction").unwrap();
        let mut other = file.to_vec();
        other[writer] = b'D';
        for wrong in [&other[..], &file[..file.len() - 4], b"nonsense"] {
            fs::write(out.join(&path), wrong).unwrap();
            assert_eq!(
                package::check(&package, &out).unwrap().changed,
                std::slice::from_ref(&path)
            );
        }
        fs::write(out.join(&path), file).unwrap();
        assert!(!package::check(&package, &out).unwrap().is_stale());
    }
}
