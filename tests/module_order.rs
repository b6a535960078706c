//! What modules may use: only earlier ones, in the order of the `pub mod` lines of each `lib.rs`, which is that of the
//! pipeline; and of the outside world nothing, but for the few whose work it is.

use std::{fs, path::Path};

#[test]
fn a_module_uses_only_earlier_ones() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    check(&root.join("src"), "error");
    check(&root.join("harness/src"), "process");
}

/// All of a crate, of which `first` is a module.
fn check(src: &Path, first: &str) {
    let lib = fs::read_to_string(src.join("lib.rs")).expect("lib.rs");
    let modules: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.trim().strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    assert!(modules.contains(&first), "lib.rs declares {modules:?}");
    let mut wrong = Vec::new();
    for (place, module) in modules.iter().enumerate() {
        let mut text = String::new();
        read_all(&src.join(module), &mut text);
        text += &fs::read_to_string(src.join(format!("{module}.rs"))).unwrap_or_default();
        for used in crate_uses(&text) {
            let position = modules.iter().position(|m| *m == used);
            if position.is_some_and(|position| position > place) {
                wrong.push(format!("{module} uses {used}, which comes later"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn uses_are_found_in_all_their_forms() {
    let text = "use crate::a::X; // crate::no\n/// crate::no\nuse crate::{b, c::{d, e as f},\n  g};\nlet x = crate :: h::i();";
    assert_eq!(crate_uses(text), ["a", "b", "c", "g", "h"]);
}

/// Files of the compiler that read or write the outside world: inputs, the package, the cache of tables. What else there
/// is computes from values.
const OUTSIDE: [&str; 7] = [
    "generate/cache.rs",
    "input.rs",
    "package.rs",
    "package/check.rs",
    "package/folder.rs",
    "package/stamp.rs",
    "package/write.rs",
];

/// Parts of the standard library that reach outside of the process, or that tell the time.
const DOORS: [&str; 7] = ["env", "fs", "net", "os", "process", "thread", "time"];

#[test]
fn only_the_listed_files_of_the_compiler_touch_the_outside_world() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    for file in files(&src) {
        let text = fs::read_to_string(src.join(&file)).expect("text");
        if touches(&text) {
            found.push(file);
        }
    }
    assert_eq!(found, OUTSIDE);
}

#[test]
fn doors_are_found_in_all_their_forms() {
    for text in [
        "use std::fs;",
        "use std::{collections::BTreeMap, env,\n  fmt};",
        "let now = std::time::Instant::now();",
        "use rustix::fs::renameat;",
    ] {
        assert!(touches(text), "{text}");
    }
    for text in [
        "// std::fs",
        "let name = env!(\"CARGO_PKG_NAME\");",
        "use std::f64::consts::PI;",
        "fn f() {}\n#[cfg(test)]\nmod tests {\n    use std::fs;\n}",
    ] {
        assert!(!touches(text), "{text}");
    }
}

/// Whether code, tests apart, names a door, or a library whose purpose is one.
fn touches(text: &str) -> bool {
    let code = text.split("#[cfg(test)]\nmod").next().unwrap_or_default();
    let of_std = uses(code, "std::");
    let libraries =
        ["rustix::", "tempfile::"].iter().any(|library| !uses(code, library).is_empty());
    libraries || of_std.iter().any(|name| DOORS.contains(&name.as_str()))
}

/// Rust files below a folder, sorted, relative to it.
fn files(src: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![src.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") && !is_of_tests(&path) {
                let relative = path.strip_prefix(src).expect("below it");
                found.push(relative.to_string_lossy().replace('\\', "/"));
            }
        }
    }
    found.sort();
    found
}

fn crate_uses(text: &str) -> Vec<String> {
    uses(text, "crate::")
}

/// The first name after every `crate::` or other prefix, in code.
fn uses(text: &str, prefix: &str) -> Vec<String> {
    let code: String =
        text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let code: String = code.replace(" as ", "%").chars().filter(|c| !c.is_whitespace()).collect();
    let mut uses = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        let rest = &code[at + prefix.len()..];
        let Some(list) = rest.strip_prefix('{') else {
            uses.push(name(rest));
            continue;
        };
        let (mut depth, mut start) = (1, true);
        for (i, c) in list.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                break;
            }
            if start {
                uses.push(name(&list[i..]));
            }
            start = c == ',' && depth == 1;
        }
    }
    uses
}

fn name(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Whether a file holds unit tests alone.
fn is_of_tests(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == "tests.rs")
}

fn read_all(folder: &Path, text: &mut String) {
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            read_all(&path, text);
        } else if path.extension().is_some_and(|e| e == "rs") && !is_of_tests(&path) {
            *text += &fs::read_to_string(&path).expect("text");
            text.push('\n');
        }
    }
}
