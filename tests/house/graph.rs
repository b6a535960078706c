//! Which file of a crate uses which, read from the text of its paths; re-exports are followed to where a name is defined.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A file of the crate.
pub struct File {
    /// Its place below `src`, with `/`.
    pub path: String,
    /// Its module, from the root: `["tables", "bake"]`.
    module: Vec<String>,
    /// Its text without comments and unit tests.
    pub code: String,
    /// What it re-exports or imports: a name, and the path that it stands for.
    names: BTreeMap<String, Vec<String>>,
}

/// The files of a crate, and its rooms: the public modules of `lib.rs`, in their order.
pub struct Graph {
    pub rooms: Vec<String>,
    pub files: Vec<File>,
}

impl Graph {
    /// Reads all files below a crate's `src`. Files named `tests.rs` hold unit tests alone and are left out.
    pub fn read(src: &Path) -> Graph {
        let lib = fs::read_to_string(src.join("lib.rs")).expect("lib.rs");
        let room = |line: &str| Some(line.strip_prefix("pub mod ")?.strip_suffix(';')?.to_owned());
        let rooms = lib.lines().filter_map(|line| room(line.trim())).collect();
        let mut files = Vec::new();
        let mut folders = vec![src.to_path_buf()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                let relative = path.strip_prefix(src).expect("below").to_string_lossy();
                let relative = relative.replace('\\', "/");
                if path.is_dir() {
                    folders.push(path);
                } else if let Some(stem) = relative.strip_suffix(".rs")
                    && !["lib", "main"].contains(&stem)
                    && !stem.ends_with("tests")
                {
                    let module: Vec<String> = stem.split('/').map(str::to_owned).collect();
                    let code = code(&fs::read_to_string(&path).expect("text"));
                    let names = imports(&code, &module);
                    files.push(File { path: relative, module, code, names });
                }
            }
        }
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Graph { rooms, files }
    }

    /// Which room uses which, sorted.
    pub fn room_arrows(&self) -> Vec<(String, String)> {
        let mut found = BTreeSet::new();
        for (from, to) in self.arrows() {
            let room = |file: usize| self.files[file].module[0].clone();
            if room(from) != room(to) {
                found.insert((room(from), room(to)));
            }
        }
        found.into_iter().collect()
    }

    /// Arrows from a room to a later one.
    pub fn back_arrows(&self) -> Vec<(String, String)> {
        let place = |room: &String| self.rooms.iter().position(|known| known == room);
        self.room_arrows().into_iter().filter(|(from, to)| place(to) > place(from)).collect()
    }

    /// Groups of files each of which reaches every other one, sorted. That a file uses what its own parent defines is no
    /// part of a circle: a parent declares its children.
    pub fn circles(&self) -> Vec<Vec<&str>> {
        let count = self.files.len();
        let mut reach = vec![vec![false; count]; count];
        for (from, to) in self.arrows() {
            let is_parent = self.files[from].module.starts_with(&self.files[to].module);
            reach[from][to] |= !is_parent;
        }
        for middle in 0..count {
            let through = reach[middle].clone();
            for line in reach.iter_mut().filter(|line| line[middle]) {
                line.iter_mut().zip(&through).for_each(|(to, more)| *to |= more);
            }
        }
        let mut found = BTreeSet::new();
        for one in (0..count).filter(|&one| reach[one][one]) {
            let circle = (0..count).filter(|&other| reach[one][other] && reach[other][one]);
            found.insert(circle.map(|file| self.files[file].path.as_str()).collect::<Vec<_>>());
        }
        found.into_iter().collect()
    }

    /// Which file uses which, by index.
    fn arrows(&self) -> BTreeSet<(usize, usize)> {
        let mut found = BTreeSet::new();
        for (index, file) in self.files.iter().enumerate() {
            for path in absolute(&file.code, &file.module) {
                if let Some(target) = self.file_of(&path, 0)
                    && target != index
                {
                    found.insert((index, target));
                }
            }
        }
        found
    }

    /// The file that defines the item of a path from the crate's root.
    fn file_of(&self, path: &[String], depth: usize) -> Option<usize> {
        let longest = (1..=path.len()).rev().find_map(|length| {
            let file = self.files.iter().position(|file| file.module == path[..length])?;
            Some((file, length))
        });
        let (file, length) = longest?;
        let Some(name) = path.get(length) else { return Some(file) };
        match self.files[file].names.get(name) {
            Some(target) if depth < 8 => {
                let mut whole = target.clone();
                whole.extend(path[length + 1..].iter().cloned());
                self.file_of(&whole, depth + 1).or(Some(file))
            }
            _ => Some(file),
        }
    }
}

/// Text without comments, and without the unit tests at its end.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect()
}

/// The paths of a file, from the crate's root.
fn absolute(code: &str, module: &[String]) -> Vec<Vec<String>> {
    let mut found = uses(code, "crate");
    let parent = &module[..module.len() - 1];
    let below = |base: &[String], path: Vec<String>| [base.to_vec(), path].concat();
    found.extend(uses(code, "super").into_iter().map(|path| below(parent, path)));
    found.extend(uses(code, "self").into_iter().map(|path| below(module, path)));
    for child in children(code) {
        let of_child = uses(code, &child).into_iter();
        found.extend(of_child.map(|path| below(module, [vec![child.clone()], path].concat())));
    }
    found
}

/// What the `use` lines bind: the last name of each path to the path from the crate's root.
fn imports(code: &str, module: &[String]) -> BTreeMap<String, Vec<String>> {
    let lines: String = code
        .split(';')
        .filter_map(|statement| {
            let at = statement.rfind("use ")?;
            Some(format!("{};", &statement[at..]))
        })
        .collect();
    let lines =
        children(code).iter().map(|child| format!("mod {child};")).collect::<String>() + &lines;
    let paths = absolute(&lines, module).into_iter();
    paths.filter_map(|path| Some((path.last()?.clone(), path))).collect()
}

/// Modules that a file declares.
fn children(code: &str) -> Vec<String> {
    let child = |line: &str| {
        let line = line.trim().strip_prefix("pub").map_or(line.trim(), |rest| {
            rest.trim_start().strip_prefix("(super)").unwrap_or(rest).trim_start()
        });
        Some(line.strip_prefix("mod ")?.strip_suffix(';')?.to_owned())
    };
    code.split_inclusive(';').filter_map(|part| child(part.lines().last()?)).collect()
}

/// Every path after `prefix::` in code, without the prefix.
pub fn uses(text: &str, prefix: &str) -> Vec<Vec<String>> {
    let code: String = code(text).replace(" as ", "%");
    let code: String = code.split_whitespace().collect::<Vec<_>>().join(" ");
    let code = code.replace(" ::", "::").replace(":: ", "::");
    let mut found = Vec::new();
    let wanted = format!("{prefix}::");
    for (at, _) in code.match_indices(&wanted) {
        let before = code[..at].chars().next_back();
        if before.is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != ':' && c != '.') {
            tree(&code[at + wanted.len()..], &[], &mut found);
        }
    }
    found
}

/// Reads a path or a list of paths in braces; returns how many bytes it took.
fn tree(text: &str, before: &[String], found: &mut Vec<Vec<String>>) -> usize {
    let Some(list) = text.strip_prefix('{') else {
        let name: String = text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let mut path = before.to_vec();
        if name != "self" && !name.is_empty() {
            path.push(name.clone());
        }
        let rest = &text[name.len()..];
        if let Some(more) = rest.strip_prefix("::")
            && more.starts_with(|c: char| c.is_alphabetic() || c == '_' || c == '{')
        {
            return name.len() + 2 + tree(more, &path, found);
        }
        if !path.is_empty() {
            found.push(path);
        }
        return name.len();
    };
    let mut at = 0;
    while let Some(c) = list[at..].chars().next() {
        match c {
            '}' => return at + 2,
            _ if c.is_alphabetic() || c == '_' || c == '{' => {
                at += tree(&list[at..], before, found).max(1);
                // an alias
                if list[at..].starts_with('%') {
                    at += list[at..].find([',', '}']).unwrap_or(list.len() - at);
                }
            }
            _ => at += c.len_utf8(),
        }
    }
    at + 1
}
