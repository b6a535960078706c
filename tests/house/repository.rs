//! What holds for every file of the repository.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// The only files with unsafe code, each with its `#[expect(unsafe_code, reason = …)]`.
const UNSAFE_FILES: [&str; 2] =
    ["harness/src/drivers/egl/context.rs", "harness/src/drivers/gpu/spirv.rs"];

/// Beginnings of paths that exist on the machine of one person only.
const MACHINE_PATHS: [&str; 4] = [
    concat!("/", "home/"),
    concat!("/", "root/"),
    concat!("/", "Users/"),
    concat!("C:", "\\Users\\"),
];

#[test]
fn no_file_but_the_listed_has_unsafe_code() {
    let keyword = "unsafe";
    let mut found = Vec::new();
    for (path, bytes) in files() {
        if path.extension().is_some_and(|e| e == "rs") {
            let code = code(&String::from_utf8(bytes).expect("Rust is UTF-8"));
            let mut words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
            if words.any(|word| word == keyword) {
                found.push(path.to_string_lossy().into_owned());
            }
        }
    }
    assert_eq!(found, UNSAFE_FILES, "files with {keyword} code, and those listed");
}

/// Text and remarks may speak of what code must not do.
#[test]
fn code_is_told_from_text_and_remarks() {
    let text = r##"a("b // \"c", '"', '\'') // d
        /* e /* f */ g */ h(r#"i " j"#, br"k", 'l: loop {}, '\\') "m
        n" o"##;
    let code = code(text);
    let words: String = code.chars().filter(|c| c.is_alphanumeric()).collect();
    assert_eq!(words, "ahblloopo", "{code}");
}

/// The compiler forbids in its own code what the harness needs in two files.
#[test]
fn the_compiler_forbids_it() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"));
    let text = text.expect("lib.rs");
    assert!(text.lines().any(|line| line == "#![forbid(unsafe_code)]"));
}

/// What a user of the library compiles, whatever a lock file holds.
#[test]
fn the_compiler_needs_no_driver_browser_or_command_line() {
    const ELSEWHERE: [&str; 17] = [
        "anyhow",
        "base64",
        "bevy_mikktspace",
        "clap",
        "glow",
        "gltf",
        "http-body-util",
        "hyper",
        "hyper-util",
        "khronos-egl",
        "maud",
        "nv-flip",
        "plotters",
        "pollster",
        "tobj",
        "tokio",
        "wgpu",
    ];
    let normal = tree("diffraction-shaders");
    let found: Vec<_> = ELSEWHERE.iter().filter(|name| normal.contains(**name)).collect();
    assert!(found.is_empty(), "the compiler depends on {found:?}");
    assert!(normal.contains("naga"), "{normal:?}");
    // and it would be seen, by the same names
    let harness = tree("diffraction-harness");
    let absent: Vec<_> = ELSEWHERE.iter().filter(|name| !harness.contains(**name)).collect();
    assert!(absent.is_empty(), "not in the harness: {absent:?}");
}

/// Names of all crates that a package needs when it is used.
fn tree(package: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "-p", package, "-e", "normal", "--prefix", "none"])
        .args(["--format", "{p}", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("names are UTF-8");
    text.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect()
}

/// Rust without its remarks and without what stands in quotes.
fn code(text: &str) -> String {
    let (mut code, mut rest) = (String::new(), text);
    while let Some(first) = rest.chars().next() {
        let end = if rest.starts_with("//") {
            rest.find('\n')
        } else if rest.starts_with("/*") {
            Some(remark(rest))
        } else if let Some(hashes) = raw(&code, rest) {
            let close = format!("\"{}", "#".repeat(hashes));
            rest[hashes + 2..].find(&close).map(|at| hashes + 2 + at + close.len())
        } else if first == '"' {
            quoted(rest, '"')
        } else if first == '\'' && is_character(rest) {
            quoted(rest, '\'')
        } else {
            code.push(first);
            rest = &rest[first.len_utf8()..];
            continue;
        };
        code.push(' ');
        rest = end.map_or("", |end| &rest[end..]);
    }
    code
}

/// Where a remark ends, those within it included.
fn remark(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let bytes = &text.as_bytes()[at..];
        match () {
            () if bytes.starts_with(b"/*") => (depth, at) = (depth + 1, at + 2),
            () if bytes.starts_with(b"*/") => (depth, at) = (depth - 1, at + 2),
            () => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at
}

/// The `#`s of a raw string that begins here, after `code`.
fn raw(code: &str, text: &str) -> Option<usize> {
    let hashes = text.strip_prefix('r')?.chars().take_while(|c| *c == '#').count();
    let before = code.strip_suffix(['b', 'c']).unwrap_or(code);
    let is_name = before.ends_with(|c: char| c.is_alphanumeric() || c == '_');
    (!is_name && text[1 + hashes..].starts_with('"')).then_some(hashes)
}

/// Where a text in quotes ends.
fn quoted(text: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    let end = text.char_indices().skip(1).find(|(_, c)| {
        let ends = !escaped && *c == quote;
        escaped = !escaped && *c == '\\';
        ends
    });
    end.map(|(at, _)| at + 1)
}

/// Whether a single quote begins a character, and not the name of a lifetime or a loop.
fn is_character(text: &str) -> bool {
    let mut inside = text.chars().skip(1);
    inside.next() == Some('\\') || inside.next() == Some('\'')
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
