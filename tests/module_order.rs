//! The order of `pub mod` lines in each `lib.rs` is the order of the pipeline: a module uses only earlier ones.

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

/// The first name after every `crate::`, in code.
fn crate_uses(text: &str) -> Vec<String> {
    let code: String =
        text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let code: String = code.replace(" as ", "%").chars().filter(|c| !c.is_whitespace()).collect();
    let mut uses = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
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

fn read_all(folder: &Path, text: &mut String) {
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            read_all(&path, text);
        } else if path.extension().is_some_and(|e| e == "rs") {
            *text += &fs::read_to_string(&path).expect("text");
            text.push('\n');
        }
    }
}
