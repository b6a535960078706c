//! What holds for every file of the repository.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// The only files with unsafe code, each with its `#[expect(unsafe_code, reason = …)]`.
const UNSAFE_FILES: [&str; 2] = ["src/runner/egl/context.rs", "src/runner/gpu/spirv.rs"];

/// Beginnings of paths that exist on the machine of one person only.
const MACHINE_PATHS: [&str; 4] = [
    concat!("/", "home/"),
    concat!("/", "root/"),
    concat!("/", "Users/"),
    concat!("C:", "\\Users\\"),
];

#[test]
fn no_file_but_the_listed_has_unsafe_code() {
    let keyword = concat!("un", "safe");
    let mut found = Vec::new();
    for (path, bytes) in files() {
        if path.extension().is_some_and(|e| e == "rs") {
            let text = String::from_utf8(bytes).expect("Rust is UTF-8");
            let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
            let mut words =
                code.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'));
            if words.any(|word| word == keyword) {
                found.push(path.to_string_lossy().into_owned());
            }
        }
    }
    assert_eq!(found, UNSAFE_FILES, "files with {keyword} code, and those listed");
}

#[test]
fn no_file_names_a_path_of_one_machine() {
    let mut found = Vec::new();
    for (path, bytes) in files() {
        for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
            if names_machine_path(line) {
                found.push(format!("{}:{}", path.display(), number + 1));
            }
        }
    }
    assert!(found.is_empty(), "paths of one machine in {}", found.join(", "));
}

#[test]
fn machine_paths_are_told_from_addresses() {
    for prefix in MACHINE_PATHS {
        assert!(names_machine_path(format!("see \"{prefix}x\"").as_bytes()), "{prefix}");
        assert!(names_machine_path(format!("{prefix}x").as_bytes()), "{prefix}");
        assert!(!names_machine_path(format!("https://example.org{prefix}").as_bytes()), "{prefix}");
    }
}

/// Whether one of [`MACHINE_PATHS`] begins in `line`, and not in the middle of an address or a longer path.
fn names_machine_path(line: &[u8]) -> bool {
    MACHINE_PATHS.iter().any(|prefix| {
        let mut places = line.windows(prefix.len()).enumerate();
        places.any(|(at, window)| {
            let inside =
                at > 0 && (line[at - 1].is_ascii_alphanumeric() || b".-_~".contains(&line[at - 1]));
            window == prefix.as_bytes() && !inside
        })
    })
}

/// The files under version control, or where there is no checkout, as in a published crate, all but build output.
fn files() -> Vec<(PathBuf, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let listed = Command::new("git").args(["ls-files", "-z"]).current_dir(root).output();
    let mut paths = match listed {
        Ok(output) if output.status.success() => String::from_utf8(output.stdout)
            .expect("names are UTF-8")
            .split_terminator('\0')
            .map(PathBuf::from)
            .collect(),
        _ => {
            let mut paths = Vec::new();
            walk(root, Path::new(""), &mut paths);
            paths
        }
    };
    paths.sort();
    assert!(
        paths.iter().any(|path| path == Path::new("src/lib.rs")),
        "no files found in {}",
        root.display()
    );
    // a file may be listed and deleted
    paths
        .into_iter()
        .filter_map(|path| fs::read(root.join(&path)).ok().map(|bytes| (path, bytes)))
        .collect()
}

fn walk(root: &Path, folder: &Path, paths: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(root.join(folder)).expect("readable") {
        let entry = entry.expect("readable");
        let path = folder.join(entry.file_name());
        let kind = entry.file_type().expect("readable");
        if kind.is_dir() && path != Path::new("target") && path != Path::new(".git") {
            walk(root, &path, paths);
        } else if kind.is_file() {
            paths.push(path);
        }
    }
}
