//! `studio`: panoramas by formula as files, and what is refused.

use std::path::Path;
use std::process::{Command, Output};

use diffraction_shaders::light::{Panorama, Studio};

fn studio(folder: &Path, line: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_diffraction");
    let mut command = Command::new(program);
    command.arg("studio").args(line.split_whitespace()).current_dir(folder).output().unwrap()
}

/// The file is the panorama of the lights' key, texel by texel; a mirrored one is not.
#[test]
fn an_exr_is_the_panorama_and_a_png_its_preview() {
    let folder = tempfile::tempdir().unwrap();
    for (word, kind) in Studio::WORDS {
        let done = studio(folder.path(), &format!("--kind {word} --out {word}.exr --width 128"));
        assert_eq!(done.status.code(), Some(0), "{done:?}");
        let bytes = std::fs::read(folder.path().join(format!("{word}.exr"))).unwrap();
        let (found, notes) = Panorama::decode(&bytes, word).unwrap();
        let expected = kind.panorama(128);
        assert_eq!((found == expected, notes.len()), (true, 0), "{word}");
        let mut mirrored = expected.clone();
        mirrored.texels.chunks_exact_mut(128).for_each(<[_]>::reverse);
        assert_ne!(found, mirrored);

        let done = studio(folder.path(), &format!("--kind {word} --out {word}.PNG --width 128"));
        assert_eq!(done.status.code(), Some(0), "{done:?}");
        let path = folder.path().join(format!("{word}.PNG"));
        let bytes = std::fs::read(path).unwrap();
        let picture = image::load_from_memory(&bytes).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (128, 64));
        let preview = expected.preview(0.5);
        let same = picture.pixels().zip(&preview.texels).all(|(a, b)| a.0 == b[..3]);
        assert!(same, "{word}");
        let spread = picture.pixels().map(|p| p.0[1]);
        assert!(spread.clone().max() > Some(200) && spread.min() < Some(100), "{word}");
    }
}

#[test]
fn what_is_wrong_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (line, wanted) in [
        ("--out a.exr", "--kind"),
        ("--kind sun --out a.exr", "softboxes"),
        ("--kind window", "--out"),
        ("--kind window --out a.hdr", "must end in .exr or .png"),
        ("--kind window --out a", "must end in .exr or .png"),
        ("--kind window --out absent/a.exr", "does not exist; make it first"),
        ("--kind window --out a.exr --width 3", "an even number from 2 to 8192"),
        ("--kind window --out a.exr --width 0", "an even number from 2 to 8192"),
        ("--kind window --out a.exr --width 9000", "an even number from 2 to 8192"),
        ("--kind window --out a.png --exposure 0", "a positive number"),
        ("--kind window --out a.png --exposure nan", "a positive number"),
    ] {
        let done = studio(folder.path(), line);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(2), "{line}: {said}");
        assert!(said.contains(wanted), "{line}: {said}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
