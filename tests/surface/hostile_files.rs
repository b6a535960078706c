//! The seeds of the fuzz targets with words of the dictionaries put in at random: read as documented, or refused; never a
//! crash. `PROPTEST_CASES=1000000` makes a longer run.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use diffraction_shaders::plan::{FileSource, Flip, Trust, VoidValue};
use diffraction_shaders::surface::MAX_PIXELS;
use diffraction_shaders::surface::read::parse;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

/// Every seed of a format: its file name and its bytes.
static SEEDS: LazyLock<Vec<(String, Vec<u8>)>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    let mut seeds = Vec::new();
    for format in ["text", "png", "tiff", "exr", "gsf", "npy"] {
        let entries = fs::read_dir(folder.join(format)).unwrap();
        for path in entries.map(|entry| entry.unwrap().path()) {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            seeds.push((name, fs::read(path).unwrap()));
        }
    }
    seeds.sort();
    assert!(seeds.len() > 40, "{}", seeds.len());
    seeds
});

/// The words of all dictionaries.
static WORDS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/dictionaries");
    let mut words = Vec::new();
    for format in ["text", "png", "tiff", "exr", "gsf", "npy"] {
        let text = fs::read_to_string(folder.join(format).with_extension("dict")).unwrap();
        let quoted = text.lines().filter_map(|line| line.strip_prefix('"')?.strip_suffix('"'));
        words.extend(quoted.map(unescaped));
    }
    assert!(words.len() > 150, "{}", words.len());
    words
});

/// A word of a dictionary, whose escapes are `\xNN`, `\"` and `\\`.
fn unescaped(word: &str) -> Vec<u8> {
    let (mut out, mut rest) = (Vec::new(), word.as_bytes());
    while let [first, tail @ ..] = rest {
        rest = match (first, tail) {
            (b'\\', [b'x', high, low, ..]) => {
                let digits = [*high, *low];
                out.push(u8::from_str_radix(str::from_utf8(&digits).unwrap(), 16).unwrap());
                &tail[3..]
            }
            (b'\\', [escaped, ..]) => {
                out.push(*escaped);
                &tail[1..]
            }
            _ => {
                out.push(*first);
                tail
            }
        };
    }
    out
}

/// Reads bytes under what plans say: nothing, a scale, everything.
fn check(name: &str, bytes: &[u8]) {
    let bare = FileSource { path: name.into(), ..FileSource::default() };
    let scaled = FileSource { size_um: Some(1.0), trust: Trust::Plan, ..bare.clone() };
    let grey = FileSource { height_um: Some(0.5), ..scaled.clone() };
    let all = FileSource {
        size_y_um: Some(2.0),
        channel: Some("2".to_owned()),
        void_value: Some(VoidValue::Number(-9999.0)),
        flip: Flip::Rows,
        ..scaled.clone()
    };
    for source in [bare, scaled, grey, all] {
        match parse(&source, "fuzz", bytes) {
            Ok(reading) => {
                let pitch = [reading.pitch_x_um, reading.pitch_y_um];
                assert_eq!(reading.heights_um.len(), reading.columns * reading.rows);
                assert!((1..=MAX_PIXELS).contains(&reading.heights_um.len()));
                assert!(reading.heights_um.iter().all(|h| !h.is_infinite()));
                assert!(pitch.iter().all(|p| p.is_finite() && *p > 0.0), "{pitch:?}");
            }
            Err(error) => assert!(error.to_string().contains(name), "{error}"),
        }
    }
}

#[test]
fn one_wrong_byte_or_a_cut_is_read_or_refused() {
    for (name, seed) in SEEDS.iter() {
        for at in 0..seed.len() {
            check(name, &seed[..at]);
            for flip in [0x01, 0x20, 0xff] {
                let mut damaged = seed.clone();
                damaged[at] ^= flip;
                check(name, &damaged);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn seeds_with_words_put_in_are_read_or_refused(
        seed in any::<Index>(),
        edits in vec((any::<Index>(), any::<Index>(), 0usize..12), 1..6),
    ) {
        let (name, bytes) = seed.get(&SEEDS);
        let mut bytes = bytes.clone();
        for (at, word, cut) in edits {
            let at = at.index(bytes.len() + 1);
            let end = (at + cut).min(bytes.len());
            bytes.splice(at..end, word.get(&WORDS).iter().copied());
        }
        check(name, &bytes);
    }
}
