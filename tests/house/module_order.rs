//! The house as a graph: a room uses only rooms that stand before it in its crate's `lib.rs`, which is the order of the
//! pipeline; no files use each other in a circle; and of the outside world nothing, but for the few whose work it is.
//!
//! `cargo test --test house -- --nocapture` prints rooms, arrows and circles.

use std::{fs, path::Path};

use crate::graph::{Graph, uses};

#[test]
fn a_room_uses_only_earlier_ones() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (crate_name, first) in [("src", "error"), ("harness/src", "process")] {
        let graph = Graph::read(&root.join(crate_name));
        assert!(graph.rooms.iter().any(|room| room == first), "{:?}", graph.rooms);
        let (arrows, back) = (graph.room_arrows(), graph.back_arrows());
        let circles = graph.circles();
        println!(
            "{crate_name}: {} rooms, {} arrows, {} back, {} files, {} circles of files",
            graph.rooms.len(),
            arrows.len(),
            back.len(),
            graph.files.len(),
            circles.len()
        );
        assert!(back.is_empty(), "a room uses a later one:\n{}", lines(&back));
        assert!(circles.is_empty(), "files use each other:\n{circles:#?}");
    }
}

fn lines(arrows: &[(String, String)]) -> String {
    arrows.iter().map(|(from, to)| format!("{from} uses {to}\n")).collect()
}

/// The graph finds what it is to find: a back arrow and a circle through a re-export, in a house made for it.
#[test]
fn back_arrows_and_circles_are_found() {
    let house = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = house.path().join(name);
        fs::create_dir_all(path.parent().expect("below")).expect("a folder");
        fs::write(path, text).expect("written");
    };
    write("lib.rs", "pub mod low;\npub mod high;\n");
    write("low.rs", "mod a;\nmod b;\npub use a::{A, make};\n");
    write("low/a.rs", "use super::b::B;\npub struct A(B);\npub fn make() {}\n");
    write("low/b.rs", "pub struct B;\n");
    write("high.rs", "use crate::low::A;\n#[cfg(test)]\nmod tests {\n    use crate::late::X;\n}\n");
    let graph = Graph::read(house.path());
    assert_eq!(graph.room_arrows(), [("high".to_owned(), "low".to_owned())]);
    assert!(graph.back_arrows().is_empty() && graph.circles().is_empty());

    write(
        "low/b.rs",
        "pub struct B;\nfn f() {\n    crate::low::make();\n    crate::high::g();\n}\n",
    );
    let graph = Graph::read(house.path());
    assert_eq!(graph.back_arrows(), [("low".to_owned(), "high".to_owned())]);
    assert_eq!(graph.circles(), [["high.rs", "low/a.rs", "low/b.rs"]]);
}

/// Files of the compiler that read or write the outside world: inputs, the package, the cache of tables. What else there
/// is computes from values.
const OUTSIDE: [&str; 16] = [
    "disk/lock.rs",
    "disk/mount.rs",
    "disk/owner.rs",
    "disk/spill.rs",
    "disk/whole.rs",
    "input.rs",
    "package/cancel.rs",
    "package/compile/cache.rs",
    "package/content.rs",
    "package/exchange.rs",
    "package/folder.rs",
    "package/in_place.rs",
    "package/leftover.rs",
    "package/stage.rs",
    "package/stamp.rs",
    "package/write.rs",
];

/// Parts of the standard library that reach outside of the process, or that read the clock.
const DOORS: [&str; 7] = ["env", "fs", "net", "os", "process", "thread", "time"];

#[test]
fn only_the_listed_files_of_the_compiler_touch_the_outside_world() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let graph = Graph::read(&src);
    let found: Vec<&str> =
        graph.files.iter().filter(|file| touches(&file.code)).map(|f| f.path.as_str()).collect();
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
    for text in ["// std::fs", "let name = env!(\"CARGO_PKG_NAME\");", "use std::f64::consts::PI;"]
    {
        assert!(!touches(text), "{text}");
    }
}

/// Whether code names a door, or a library whose purpose is one.
fn touches(code: &str) -> bool {
    let of_std = uses(code, "std");
    let libraries = ["rustix", "tempfile"].iter().any(|library| !uses(code, library).is_empty());
    libraries || of_std.iter().any(|path| DOORS.contains(&path[0].as_str()))
}

#[test]
fn uses_are_found_in_all_their_forms() {
    let text = r#"use crate::a::X; // crate::no
/// crate::no
use crate::{b, c::{d, e as f},
  g};
let x = crate :: h::i();"#;
    let found: Vec<String> = uses(text, "crate").iter().map(|path| path.join("::")).collect();
    assert_eq!(found, ["a::X", "b", "c::d", "c::e", "g", "h::i"]);
}
