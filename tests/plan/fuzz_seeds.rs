//! The seeds of the fuzz targets: small valid files of every format that a reader knows.

use crate::support::words;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::heights as support;
use crate::support::heights::{COLUMNS, ROWS};
use diffraction_shaders::plan::{FileSource, Plan, Trust};
use diffraction_shaders::surface::read::parse;
use diffraction_shaders::surface::{HeightField, write_gsf};
use exr::prelude::*;
use image::ExtendedColorType;
use tiff::encoder::{Compression as TiffCompression, Predictor, TiffEncoder, colortype};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds")
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

#[test]
fn every_seed_is_small_and_read() {
    let mut total = 0;
    let mut formats = Vec::new();
    for format in entries(&folder()) {
        formats.push(format.file_name().unwrap().to_str().unwrap().to_owned());
        for path in entries(&format) {
            let bytes = fs::read(&path).unwrap();
            total += bytes.len();
            if format.ends_with("plan") {
                Plan::parse(std::str::from_utf8(&bytes).unwrap(), &path).unwrap();
                continue;
            }
            let read = |height_um| {
                let source = FileSource {
                    path: path.clone(),
                    pixel_um: Some(0.1),
                    height_um,
                    // seeds state all kinds of scales
                    trust: Trust::Plan,
                    ..FileSource::default()
                };
                parse(&source, "seed", &bytes)
            };
            assert!(read(None).is_ok() || read(Some(0.5)).is_ok(), "{}", path.display());
        }
    }
    assert_eq!(formats, ["exr", "gsf", "npy", "plan", "png", "text", "tiff"]);
    assert!(total < 50 << 10, "{total} bytes");
}

/// A fuzz target puts together what it is given: a word in no seed and not in the dictionary it hardly ever finds.
#[test]
fn seeds_and_dictionary_have_every_key_and_word_of_a_plan() {
    let known = words::all();
    let mut used = BTreeSet::new();
    for path in entries(&folder().join("plan")) {
        used.extend(words::used(&fs::read_to_string(path).unwrap()));
    }
    let missing: Vec<_> = known.difference(&used).collect();
    assert!(missing.is_empty(), "no seed of a plan has {missing:?}");
    let dictionary = fs::read_to_string(folder().join("../dictionaries/plan.dict")).unwrap();
    let entries: BTreeSet<&str> = dictionary.lines().collect();
    let words = known.iter().flat_map(|(_, key, word)| word.iter().chain([key]));
    let missing: BTreeSet<&String> =
        words.filter(|word| !entries.contains(format!("\"{word}\"").as_str())).collect();
    assert!(missing.is_empty(), "fuzz/dictionaries/plan.dict lacks {missing:?}");
}

/// `cargo test --release --test plan -- --ignored fuzz_seeds` writes the seeds of the files anew.
#[test]
#[ignore = "writes into the repository"]
fn write() {
    let floats: Vec<f32> = support::greys().into_iter().map(|g| f32::from(g) / 100.0).collect();
    let wide: Vec<u16> = support::greys().into_iter().map(|g| u16::from(g) * 200).collect();
    let (w, h) = (COLUMNS as u32, ROWS as u32);
    let seeds = pngs(w, h)
        .into_iter()
        .chain(tiffs(w, h, &floats, &wide))
        .chain(exrs(&floats))
        .chain(texts(&floats, &wide));
    for (name, bytes) in seeds {
        let path = folder().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
}

type Seeds = Vec<(String, Vec<u8>)>;

fn pngs(w: u32, h: u32) -> Seeds {
    [
        ("l8", ExtendedColorType::L8, 1),
        ("la8", ExtendedColorType::La8, 2),
        ("rgb8", ExtendedColorType::Rgb8, 3),
        ("rgba8", ExtendedColorType::Rgba8, 4),
        ("l16", ExtendedColorType::L16, 2),
        ("rgba16", ExtendedColorType::Rgba16, 8),
    ]
    .map(|(name, colour, bytes)| {
        let samples = vec![255; (w * h) as usize * bytes];
        (format!("png/{name}.png"), support::png(w, h, colour, &samples))
    })
    .into_iter()
    .chain([("png/gwyddion.png".to_owned(), keyed_png(w, h))])
    .collect()
}

fn tiffs(w: u32, h: u32, floats: &[f32], wide: &[u16]) -> Seeds {
    let packed = |compression| {
        let mut out = std::io::Cursor::new(Vec::new());
        TiffEncoder::new(&mut out)
            .unwrap()
            .with_compression(compression)
            .with_predictor(Predictor::Horizontal)
            .write_image::<colortype::Gray16>(w, h, wide)
            .unwrap();
        out.into_inner()
    };
    let rgb: Vec<u8> = support::greys().into_iter().flat_map(|g| [g; 3]).collect();
    let doubles: Vec<f64> = floats.iter().map(|&v| v.into()).collect();
    vec![
        ("tiff/l8.tiff".into(), support::tiff::<colortype::Gray8>(w, h, &support::greys())),
        ("tiff/l16.tiff".into(), support::tiff::<colortype::Gray16>(w, h, wide)),
        ("tiff/f32.tiff".into(), support::tiff::<colortype::Gray32Float>(w, h, floats)),
        ("tiff/f64.tiff".into(), support::tiff::<colortype::Gray64Float>(w, h, &doubles)),
        ("tiff/rgb8.tiff".into(), support::tiff::<colortype::RGB8>(w, h, &rgb)),
        ("tiff/lzw.tiff".into(), packed(TiffCompression::Lzw)),
        ("tiff/deflate.tiff".into(), packed(TiffCompression::Deflate(Default::default()))),
        ("tiff/packbits.tiff".into(), packed(TiffCompression::Packbits)),
        (
            "tiff/imagej.tiff".into(),
            described_tiff(w, h, "ImageJ=1\nunit=nm\ncf=0\nc0=1\nc1=2\nvunit=nm\n"),
        ),
        (
            "tiff/ome.tiff".into(),
            described_tiff(w, h, "<OME><Image><Pixels PhysicalSizeX=\"0.5\"/></Image></OME>"),
        ),
    ]
}

fn exrs(floats: &[f32]) -> Seeds {
    let encoded = |encoding: Encoding, samples: FlatSamples| {
        let list = [AnyChannel::new("Y", samples)].into_iter().collect();
        let size = (COLUMNS, ROWS);
        let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(list));
        let mut out = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut out).unwrap();
        out.into_inner()
    };
    let methods = [
        ("none", Compression::Uncompressed),
        ("rle", Compression::RLE),
        ("zips", Compression::ZIP1),
        ("zip", Compression::ZIP16),
        ("piz", Compression::PIZ),
        ("pxr24", Compression::PXR24),
        ("b44", Compression::B44),
    ];
    let mut seeds: Seeds = methods
        .into_iter()
        .map(|(name, compression)| {
            let encoding = Encoding { compression, ..Encoding::UNCOMPRESSED };
            let half = FlatSamples::F16(floats.iter().map(|&v| f16::from_f32(v)).collect());
            (format!("exr/{name}.exr"), encoded(encoding, half))
        })
        .collect();
    let tiles = Encoding { blocks: Blocks::Tiles(Vec2(2, 2)), ..Encoding::SMALL_LOSSLESS };
    seeds.push(("exr/tiles.exr".into(), encoded(tiles, FlatSamples::F32(floats.to_vec()))));
    let channels: Vec<(&str, Vec<f32>)> =
        ["A", "B", "G", "R"].map(|name| (name, floats.to_vec())).into();
    let list = [AnyChannel::new("Y", FlatSamples::F32(floats.to_vec()))].into_iter().collect();
    let mut keyed = Layer::new(
        (COLUMNS, ROWS),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(list),
    );
    for key in ["Gwy::XReal", "Gwy::ZScale"] {
        keyed.attributes.other.insert(Text::new_or_panic(key), AttributeValue::F32(1e-6));
    }
    let mut out = std::io::Cursor::new(Vec::new());
    Image::from_layer(keyed).write().to_buffered(&mut out).unwrap();
    seeds.push(("exr/gwyddion.exr".into(), out.into_inner()));
    seeds.push(("exr/rgba.exr".into(), support::exr(COLUMNS, ROWS, &channels, true)));
    seeds
}

const BLOCKS: &str = "# Channel: Height\n# Width: 1 µm\n# Value units: nm\n1 2\n3 4\n\n# Channel: Phase\n# Value units: deg\n5 6\n7 9\n";

const ZYGO: &str = "Zygo ASCII Data File - Format 2\n1 8 3 5 \"d\"\n0 0 0 0 0 0\n0 0 2 2\n\"\"\n\"\"\n\"\"\n0 0.5 6e-07 0 1 0 5e-07 1\n2 2 0 0 0 0 \"\"\n0\n1 1 20\n0 \"\"\n1 0\n\"\"\n#\n1 2 3 4\n#\n";

fn wide_text(text: &str) -> Vec<u8> {
    let units = text.encode_utf16().flat_map(u16::to_le_bytes);
    [0xff, 0xfe].into_iter().chain(units).collect()
}

/// A PNG whose texts have Gwyddion's keys.
fn keyed_png(w: u32, h: u32) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, w, h);
    encoder.set_color(png::ColorType::Grayscale);
    for (key, value) in [("Gwy::XReal", "1e-6"), ("Gwy::ZMin", "0"), ("Gwy::ZMax", "1e-7")] {
        encoder.add_text_chunk(key.into(), value.into()).unwrap();
    }
    encoder.add_itxt_chunk("Gwy::ZUnit".into(), "m".into()).unwrap();
    encoder.write_header().unwrap().write_image_data(&support::greys()).unwrap();
    out
}

/// A TIFF with a description and a resolution.
fn described_tiff(w: u32, h: u32, text: &str) -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut out).unwrap();
    let mut image = encoder.new_image::<colortype::Gray8>(w, h).unwrap();
    image.encoder().write_tag(tiff::tags::Tag::ImageDescription, text).unwrap();
    image.resolution(tiff::tags::ResolutionUnit::None, tiff::encoder::Rational { n: 2, d: 1 });
    image.write_data(&support::greys()).unwrap();
    out.into_inner()
}

/// The formats with a header of text.
fn texts(floats: &[f32], wide: &[u16]) -> Seeds {
    let f4: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    let f8: Vec<u8> = floats.iter().flat_map(|&v| f64::from(v).to_be_bytes()).collect();
    let u2: Vec<u8> = wide.iter().flat_map(|v| v.to_le_bytes()).collect();
    let field =
        HeightField::new(COLUMNS, ROWS, 0.1, 0.1, floats.iter().map(|&v| v.into()).collect());
    let gsf = r#"XRes = 5
YRes = 3
XReal = 5e-7
XYUnits = nm
ZUnits = µm
Title = a title
"#;
    vec![
        ("npy/f4.npy".into(), support::npy_of("<f4", false, "(3, 5)", &f4)),
        ("npy/f8.npy".into(), support::npy_of(">f8", true, "(3, 5)", &f8)),
        ("npy/u2.npy".into(), support::npy_of("<u2", false, "(3, 5)", &u2)),
        ("npy/u1.npy".into(), support::npy_of("|u1", false, "(15,)", &support::greys())),
        ("gsf/own.gsf".into(), write_gsf(&field.unwrap())),
        ("gsf/units.gsf".into(), support::gsf(gsf, floats)),
        ("text/comma.txt".into(), b"# heights\n0.1,0.2,nan\n1e-1,-.5,+3\n".to_vec()),
        ("text/blank.txt".into(), b"\xef\xbb\xbf0.1 0.2\r\n3 4 # end\r\n\r\n".to_vec()),
        ("text/semicolon.txt".into(), b"0.1; 0.2; 0.3\n1; 2; NaN".to_vec()),
        ("text/tab.txt".into(), b"0.1\t0.2\n0.3\t0.4\n".to_vec()),
        ("text/wide.txt".into(), wide_text("# Value units: nm\n1 2\n3 4\n")),
        ("text/latin.txt".into(), b"# Width: 1 \xb5m\r1 2\r3 4\r".to_vec()),
        ("text/decimal.txt".into(), b"0,12\n0,07\n-0,10\n".to_vec()),
        ("text/blocks.txt".into(), BLOCKS.into()),
        ("text/points.txt".into(), b"x y z in um\n0 0 1\n1 0 2\n0 1 3\n1 1 5\n".to_vec()),
        ("text/profile.txt".into(), b"# distance_um,height_nm\n0,1\n0.5,4\n1,2\n".to_vec()),
        ("text/coordinates.txt".into(), b"nan 0 1 2\n0 5 3 1\n1 2 8 4\n".to_vec()),
        ("text/esri.txt".into(), b"ncols 2\nnrows 2\ncellsize 5\nNODATA_value -9999\n1 2 3 -9999\n".to_vec()),
        ("text/columns.txt".into(), b"\\Samps/line: 2\n\\Lines: 2\n\\Scan Size: 5 um\nA(V)\tHeight(nm)\n1\t2\n3\t4\n5\t6\n7\t9\n".to_vec()),
        ("text/surfer.txt".into(), b"DSAA\n2 2\n0 1\n0 1\n0 9\n1 2\n3 4\n".to_vec()),
        ("text/zygo.txt".into(), ZYGO.into()),
    ]
}
