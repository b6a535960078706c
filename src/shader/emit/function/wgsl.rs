//! The functions as WGSL text with comments. Textures are parameters.
//!
//! naga determines which declarations are needed and which function reads which texture. The text of declarations is
//! cut out of the specialised text by spans. Calls are found by tokens: in WGSL, the name of a function followed by a
//! parenthesis is always a call. The result is parsed and validated again.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use naga::{
    AddressSpace, Span,
    valid::{Capabilities, ValidationFlags, Validator},
};

use crate::shader::module::Module;
use crate::shader::template::GENERATED;

use super::core::Core;
use super::head;

/// The text. Its first function is the first one of `core`.
pub fn write(module: &Module, core: &Core) -> Result<String, String> {
    let first = core.names.first().ok_or("there is no function")?;
    let text = hollow(module.text(), &core.hosts)?;
    let source = Source::read(&text)?;
    let mut needed = BTreeSet::new();
    for name in &core.names {
        source.collect(name, &mut needed);
    }
    let is_host = |name: &str| core.hosts.contains(&name);
    let mut items: Vec<&Item> = needed.iter().filter_map(|name| source.items.get(name)).collect();
    items.sort_by_key(|item| (item.start, item.text.len()));
    let mut out = source.first(first, &head::lines(module))?;
    let constants = items.iter().filter(|item| item.kind == Kind::Constant);
    let constants: Vec<String> = constants.map(|item| item.with_comments()).collect();
    if !constants.is_empty() {
        out += &format!("\n\n{}", constants.join("\n"));
    }
    for item in &items {
        match item.kind {
            Kind::Structure => out += &format!("\n\n{}", item.with_comments()),
            Kind::Function if item.name != *first && !is_host(&item.name) => {
                out += &format!("\n\n{}{}", item.comments, source.threaded(item)?);
            }
            _ => {}
        }
    }
    out.push('\n');
    let hosts = items.iter().filter(|item| is_host(&item.name)).map(|item| item.text);
    check(&out, &hosts.collect::<Vec<_>>().concat())?;
    Ok(out)
}

/// The text in which the functions of the host return zero.
fn hollow(text: &str, hosts: &[&str]) -> Result<String, String> {
    let mut out = text.to_owned();
    for host in hosts {
        let missing = || format!("`{host}` is not in the text");
        let start = out.find(&format!("\nfn {host}(")).ok_or_else(missing)? + 1;
        let body = start + out[start..].find(" {\n").ok_or_else(missing)?;
        let end = body + out[body..].find("\n}").ok_or_else(missing)?;
        out.replace_range(body..end, " {\n    return vec3f(0.0);");
    }
    Ok(out)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Constant,
    Structure,
    Function,
    Texture,
}

/// A declaration.
struct Item<'a> {
    name: String,
    kind: Kind,
    start: usize,
    text: &'a str,
    /// The comment lines above it, with their line ends.
    comments: &'a str,
    /// The comment after it in its last line, with the blank before it.
    remark: &'a str,
}

impl Item<'_> {
    fn with_comments(&self) -> String {
        let end = if self.text.ends_with(['}', ';']) { "" } else { ";" };
        format!("{}{}{end}{}", self.comments, self.text, self.remark)
    }

    /// The type of a variable as written in the text.
    fn ty(&self) -> &str {
        let ty = self.text.rsplit_once(':').map_or("", |(_, ty)| ty);
        ty.trim().trim_end_matches(';').trim_end()
    }
}

/// The declarations of a text, and the textures that each function reads, in the order of their bindings.
struct Source<'a> {
    items: BTreeMap<String, Item<'a>>,
    textures: BTreeMap<String, Vec<String>>,
}

impl<'a> Source<'a> {
    fn read(text: &'a str) -> Result<Source<'a>, String> {
        let ir = naga::front::wgsl::parse_str(text).map_err(|e| e.message().to_owned())?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&ir)
            .map_err(|error| error.as_inner().to_string())?;
        let mut source = Source { items: BTreeMap::new(), textures: BTreeMap::new() };
        for (handle, constant) in ir.constants.iter() {
            source.add(text, &constant.name, Kind::Constant, ir.constants.get_span(handle));
        }
        for (handle, ty) in ir.types.iter() {
            if matches!(ty.inner, naga::TypeInner::Struct { .. }) {
                source.add(text, &ty.name, Kind::Structure, ir.types.get_span(handle));
            }
        }
        for (handle, global) in ir.global_variables.iter() {
            if global.space == AddressSpace::Handle {
                source.add(text, &global.name, Kind::Texture, ir.global_variables.get_span(handle));
            }
        }
        for (handle, function) in ir.functions.iter() {
            source.add(text, &function.name, Kind::Function, ir.functions.get_span(handle));
            let globals = ir.global_variables.iter();
            let mut read: Vec<_> = globals
                .filter(|(global, _)| !info[handle][*global].is_empty())
                .filter_map(|(_, global)| {
                    let place = global.binding?;
                    Some(((place.group, place.binding), global.name.clone()?))
                })
                .collect();
            read.sort();
            let read = read.into_iter().map(|(_, name)| name).collect();
            source.textures.insert(function.name.clone().unwrap_or_default(), read);
        }
        Ok(source)
    }

    fn add(&mut self, text: &'a str, name: &Option<String>, kind: Kind, span: Span) {
        let (Some(name), Some(range)) = (name.clone(), span.to_range()) else { return };
        let Range { start, end } = range;
        let Some(declaration) = text.get(range) else { return };
        let item = Item {
            name: name.clone(),
            kind,
            start,
            text: declaration.trim_end(),
            comments: comments_above(text, start),
            remark: remark_behind(text, end),
        };
        self.items.insert(name, item);
    }

    /// Adds a declaration and all declarations that it refers to.
    fn collect(&self, name: &str, needed: &mut BTreeSet<String>) {
        let Some(item) = self.items.get(name).filter(|item| item.kind != Kind::Texture) else {
            return;
        };
        if needed.insert(name.to_owned()) {
            tokens(item.text).into_iter().for_each(|(_, token)| self.collect(token, needed));
        }
    }

    /// The first function. The comment of the file and the function's own comment are moved below its first line.
    fn first(&self, name: &str, head: &[String]) -> Result<String, String> {
        let item = self.items.get(name).ok_or(format!("there is no function `{name}`"))?;
        let threaded = self.threaded(item)?;
        let (declaration, body) = threaded
            .split_once('\n')
            .ok_or(format!("`{name}` has its body in the same line as its name"))?;
        let mut lines = vec![declaration.to_owned()];
        lines.extend(head.iter().map(|line| format!("    {line}")));
        lines.push("    //".to_owned());
        lines.extend(item.comments.lines().map(|line| format!("    {}", line.trim())));
        for texture in self.textures.get(name).into_iter().flatten() {
            let comments = self.items.get(texture).map_or("", |item| item.comments);
            let said: Vec<&str> =
                comments.lines().map(|l| l.trim().trim_start_matches('/').trim()).collect();
            if !said.is_empty() {
                lines.push(format!("    // {texture}: {}", said.join(" ")));
            }
        }
        Ok(lines.join("\n") + "\n" + body)
    }

    /// The text of a function with textures as further parameters: the textures that it reads and those of the
    /// functions that it calls.
    fn threaded(&self, item: &Item) -> Result<String, String> {
        let tokens = tokens(item.text);
        let mut insertions = BTreeMap::new();
        let mut open: Vec<Option<String>> = Vec::new();
        let mut previous = ["", ""];
        for (index, (_, token)) in tokens.iter().enumerate() {
            match *token {
                "(" => open.push(self.addition(previous)),
                ")" => {
                    let (at, last) = tokens[index.saturating_sub(1)];
                    if let Some(addition) = open.pop().ok_or("unbalanced parentheses")? {
                        let separator = match last {
                            "(" => "",
                            "," => " ",
                            _ => ", ",
                        };
                        insertions.insert(at + last.len(), format!("{separator}{addition}"));
                    }
                }
                _ => {}
            }
            previous = [previous[1], token];
        }
        let mut text = item.text.to_owned();
        for (at, insertion) in insertions.iter().rev() {
            text.insert_str(*at, insertion);
        }
        Ok(text)
    }

    /// The text to add at the end of a list in parentheses after these two tokens.
    fn addition(&self, [before, name]: [&str; 2]) -> Option<String> {
        let textures = self.textures.get(name).filter(|textures| !textures.is_empty())?;
        let parts = textures.iter().map(|texture| match (before, self.items.get(texture)) {
            ("fn", Some(item)) => format!("{texture}: {}", item.ty()),
            _ => texture.clone(),
        });
        Some(parts.collect::<Vec<_>>().join(", "))
    }
}

/// The comment lines directly above a declaration.
fn comments_above(text: &str, start: usize) -> &str {
    let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
    let mut begin = line_start;
    for line in text[..line_start].split_inclusive('\n').rev() {
        if !line.starts_with("//") || line.contains(GENERATED) {
            break;
        }
        begin -= line.len();
    }
    &text[begin..line_start]
}

/// The comment after a declaration in the same line, with the blank before it. Empty if there is no comment.
fn remark_behind(text: &str, end: usize) -> &str {
    let rest = text[end..].lines().next().unwrap_or_default();
    let rest = rest.strip_prefix(';').unwrap_or(rest);
    if rest.trim_start().starts_with("//") { rest } else { "" }
}

/// Words and single characters, without blanks and comments, each with its byte offset.
fn tokens(text: &str) -> Vec<(usize, &str)> {
    let mut tokens = Vec::new();
    let mut at = 0;
    let mut depth = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let word = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let length = if rest.starts_with("/*") {
            depth += 1;
            2
        } else if depth > 0 && rest.starts_with("*/") {
            depth -= 1;
            2
        } else if depth == 0 && rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else {
            let length = word.max(c.len_utf8());
            if depth == 0 && !c.is_whitespace() {
                tokens.push((at, &rest[..length]));
            }
            length
        };
        at += length;
    }
    tokens
}

/// Checks that the text, with the functions of the host, is a valid module that begins with a function and has no bindings.
fn check(text: &str, hosts: &str) -> Result<(), String> {
    let text = &format!("{text}{hosts}");
    let ir = naga::front::wgsl::parse_str(text).map_err(|error| error.emit_to_string(text))?;
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&ir)
        .map_err(|error| error.emit_to_string(text))?;
    if !text.starts_with("fn ") || !ir.global_variables.is_empty() {
        return Err("the text does not begin with a function, or has a binding".to_owned());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_skip_comments() {
        let found: Vec<&str> = tokens("f(a /* ( /* ) */ , */, b_a) // g(\n-1.0é")
            .into_iter()
            .map(|(_, token)| token)
            .collect();
        assert_eq!(found, ["f", "(", "a", ",", "b_a", ")", "-", "1", ".", "0é"]);
    }

    #[test]
    fn textures_go_through_every_call() {
        let text = "\
@group(0) @binding(1) var other: texture_2d<f32>;
@group(0) @binding(0) var table: texture_2d<f32>;
fn leaf() -> f32 { return textureLoad(table, vec2i(0), 0).x; }
fn plain(x: f32) -> f32 { return x; }
fn both(x: f32, /* y( */ y: f32,) -> f32 {
    return plain(leaf( )) + textureLoad(other, vec2i(0), 0).x + plain(x) + y;
}
fn top(x: f32) -> f32 {
    return both(
        plain(leaf()),
        x, // last
    ) + both(x, leaf());
}
";
        let source = Source::read(text).unwrap();
        let threaded = |name: &str| source.threaded(&source.items[name]).unwrap();
        assert_eq!(
            threaded("leaf"),
            "fn leaf(table: texture_2d<f32>) -> f32 { return textureLoad(table, vec2i(0), 0).x; }"
        );
        assert_eq!(threaded("plain"), "fn plain(x: f32) -> f32 { return x; }");
        assert!(threaded("both").starts_with(
            "fn both(x: f32, /* y( */ y: f32, table: texture_2d<f32>, other: texture_2d<f32>) -> f32 {\n    return plain(leaf(table ))"
        ), "{}", threaded("both"));
        assert!(threaded("top").contains(
            "both(\n        plain(leaf(table)),\n        x, table, other // last\n    ) + both(x, leaf(table), table, other);"
        ), "{}", threaded("top"));
    }
}
