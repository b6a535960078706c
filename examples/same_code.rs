//! Whether two packages of one plan have the same code, tables, manifests and probes, whatever their comments say:
//!
//! ```console
//! cargo run --release --example same_code -- OLD NEW
//! ```
//!
//! - Texts are compared without comments and blank lines. Constants are compared by their values, wherever they stand: their
//!   declarations are taken out, and their names replaced by the values.
//! - Of SPIR-V, whose identifiers follow the order of constants, the operations of functions are compared in order and the
//!   declarations sorted. It may declare constants that it did not declare before: the texts show whether they are used.
//! - In the index and the manifest of the package, sizes and hashes of texts may differ.
//! - All other files are compared byte by byte: tables, manifests, probes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs, io};

fn main() -> ExitCode {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [old, new] = arguments.as_slice() else {
        eprintln!("usage: same_code OLD NEW");
        return ExitCode::FAILURE;
    };
    match differences(old, new) {
        Ok((files, found)) => {
            found.iter().for_each(|difference| println!("{difference}"));
            println!("{files} files, {} differ in more than comments", found.len());
            if found.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Number of files, and what differs.
fn differences(old: &Path, new: &Path) -> io::Result<(usize, Vec<String>)> {
    let (before, after) = (files(old, Path::new(""))?, files(new, Path::new(""))?);
    let once = before.symmetric_difference(&after);
    let mut found: Vec<String> =
        once.map(|path| format!("{}: in one package only", path.display())).collect();
    for path in before.intersection(&after) {
        let [a, b] = [fs::read(old.join(path))?, fs::read(new.join(path))?];
        if a != b {
            let difference = difference(path, &a, &b);
            found.extend(difference.map(|what| format!("{}: {what}", path.display())));
        }
    }
    Ok((before.union(&after).count(), found))
}

/// Paths of all files below a folder, relative to the root.
fn files(root: &Path, below: &Path) -> io::Result<BTreeSet<PathBuf>> {
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(root.join(below))? {
        let entry = entry?;
        let path = below.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            found.extend(files(root, &path)?);
        } else {
            found.insert(path);
        }
    }
    Ok(found)
}

/// The first difference of two files that are not the same byte by byte.
fn difference(path: &Path, old: &[u8], new: &[u8]) -> Option<String> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let first = |a: Vec<String>, b: Vec<String>| {
        let lines = a.len().max(b.len());
        let differ = (0..lines).find(|i| a.get(*i) != b.get(*i))?;
        let show = |lines: &[String]| lines.get(differ).cloned().unwrap_or("nothing".to_owned());
        Some(format!("`{}` became `{}`", show(&a), show(&b)))
    };
    match extension {
        "wgsl" | "glsl" | "vert" | "frag" | "hlsl" | "metal" => {
            let [a, b] = [old, new].map(|bytes| code(&String::from_utf8_lossy(bytes)));
            first(a, b)
        }
        "spv" => {
            let [a, b] = [old, new].map(instructions);
            let b = without_new(b, &a);
            first(a, b)
        }
        "md" => first(unsized_lines(old), unsized_lines(new)),
        "json" if path == Path::new("manifest.json") => {
            let [a, b] = [old, new].map(unsealed);
            first(a, b)
        }
        _ => Some("the bytes differ".to_owned()),
    }
}

/// The lines of the index without the numbers in its tables, most of which are sizes of texts.
fn unsized_lines(bytes: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(bytes);
    let words = |line: &str| {
        let cells = line.split('|').filter(|cell| cell.trim().parse::<f64>().is_err());
        cells.collect::<Vec<_>>().join("|")
    };
    text.lines().map(words).collect()
}

/// The lines of a manifest without the sizes and hashes of files.
fn unsealed(bytes: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(bytes);
    let sealed = |line: &&str| {
        let line = line.trim_start();
        !(line.starts_with("\"sha256\":") || line.starts_with("\"bytes\":"))
    };
    text.lines().filter(sealed).map(str::to_owned).collect()
}

/// The lines of a text without comments, names of constants replaced by their values.
fn code(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut constants = BTreeMap::new();
    for line in text.lines() {
        let line = line.split("//").next().unwrap_or_default().trim();
        match constant(line) {
            Some((name, value)) => drop(constants.insert(name, value)),
            None if line.is_empty() => {}
            None => lines.push(line.to_owned()),
        }
    }
    lines.iter().map(|line| folded(replaced(line, &constants))).collect()
}

/// Name and value of a constant that a line declares, in any of the languages.
fn constant(line: &str) -> Option<(String, String)> {
    let declares = ["const ", "static const ", "constant "];
    declares.iter().find(|word| line.starts_with(**word))?;
    let (declaration, value) = line.split_once(" = ")?;
    let name = declaration.split(':').next()?.split_whitespace().last()?;
    let value = value.trim_end_matches(';');
    // one number has several spellings
    let spelling = value.parse::<f32>().map_or(value.to_owned(), |number| number.to_string());
    Some((name.to_owned(), spelling))
}

/// The line with names of constants replaced by their values.
fn replaced(line: &str, constants: &BTreeMap<String, String>) -> String {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut out = String::new();
    let mut rest = line;
    while let Some(c) = rest.chars().next() {
        let word = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        let (token, after) = rest.split_at(if is_word(c) { word } else { c.len_utf8() });
        out += constants.get(token).map_or(token, String::as_str);
        rest = after;
    }
    out
}

/// The line with sums of whole numbers in parentheses computed.
fn folded(line: String) -> String {
    let is_sum = |c: char| c.is_ascii_digit() || " +-*".contains(c);
    for (open, _) in line.match_indices('(') {
        let Some(length) = line[open + 1..].find(')') else { continue };
        let inner = &line[open + 1..open + 1 + length];
        if inner.contains(' ') && inner.chars().all(is_sum) {
            let plus = inner.replace(" - ", " + -1 * ");
            let product = |term: &str| -> Option<i64> {
                term.split('*').map(|factor| factor.trim().parse::<i64>().ok()).product()
            };
            if let Some(sum) = plus.split(" + ").map(product).sum::<Option<i64>>() {
                return folded(line.replacen(inner, &sum.to_string(), 1));
            }
        }
    }
    line
}

/// What a module's constants begin with in its lines.
const CONSTANT: &str = "constant ";

/// The lines without constants that the other module lacks: a named constant stands in every module, used or not.
fn without_new(lines: Vec<String>, other: &[String]) -> Vec<String> {
    let known = |line: &String| !line.starts_with(CONSTANT) || other.contains(line);
    lines.into_iter().filter(known).collect()
}

/// Operations and sizes of a SPIR-V module: those of declarations sorted, with the numbers of constants, those of functions
/// in order.
fn instructions(bytes: &[u8]) -> Vec<String> {
    const NAMES: [u32; 2] = [5, 6];
    const SCALAR: u32 = 43;
    const FUNCTION: u32 = 54;
    let words: Vec<u32> = bytes
        .chunks_exact(4)
        .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
        .collect();
    let (mut declarations, mut functions) = (Vec::new(), Vec::new());
    let mut at = 5;
    while let Some(first) = words.get(at) {
        let (length, operation) = ((first >> 16).max(1) as usize, first & 0xffff);
        let line = match words.get(at + 3) {
            Some(number) if operation == SCALAR => format!("{CONSTANT}{number:#x}"),
            _ => format!("operation {operation}, {length} words"),
        };
        if operation == FUNCTION || !functions.is_empty() {
            functions.push(line);
        } else if !NAMES.contains(&operation) {
            declarations.push(line);
        }
        at += length;
    }
    declarations.sort();
    declarations.dedup();
    declarations.extend(functions);
    declarations
}
