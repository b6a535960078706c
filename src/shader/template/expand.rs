//! Writes the text of checked templates.

use std::collections::BTreeSet;

use super::{
    Defines, GENERATED, Origin, Specialised, Words,
    argument::{Argument, hand_on},
    check::{Line, Templates},
};

/// The specialised text of template `root`.
pub fn expand(templates: &Templates, root: &str, defines: &Defines) -> Specialised {
    let mut expansion = Expansion {
        templates,
        defines,
        imported: BTreeSet::new(),
        words: Words::default(),
        used: BTreeSet::new(),
        constants_at: None,
        arguments: Vec::new(),
        lines: vec![(format!("// {GENERATED}"), Origin { file: root.to_owned(), line: 1 })],
    };
    expansion.template(root);
    expansion.constants();
    let arguments = std::mem::take(&mut expansion.arguments);
    let mut text = String::new();
    let mut origins = Vec::with_capacity(expansion.lines.len());
    for (line, origin) in expansion.lines {
        let blank_after_blank = line.is_empty() && (text.is_empty() || text.ends_with("\n\n"));
        if !blank_after_blank {
            text.push_str(&line);
            text.push('\n');
            origins.push(origin);
        }
    }
    while text.ends_with("\n\n") {
        text.pop();
        origins.pop();
    }
    for argument in arguments {
        text = hand_on(&text, argument, &[]);
    }
    Specialised { text, origins }
}

struct Expansion<'a> {
    templates: &'a Templates<'a>,
    defines: &'a Defines,
    imported: BTreeSet<&'a str>,
    words: Words,
    /// Constants that kept lines use.
    used: BTreeSet<&'a str>,
    /// Index in `lines` and origin of the generated declarations.
    constants_at: Option<(usize, Origin)>,
    arguments: Vec<Argument<'a>>,
    lines: Vec<(String, Origin)>,
}

impl<'a> Expansion<'a> {
    /// Appends the kept lines of a template, unless it was imported before.
    fn template(&mut self, name: &'a str) {
        let Some((name, lines)) = self.templates.get_key_value(name) else { return };
        if !self.imported.insert(name) {
            return;
        }
        let mut kept: Vec<bool> = Vec::new();
        for (number, line) in (1..).zip(lines) {
            let active = kept.iter().all(|kept| *kept);
            match line {
                Line::Condition { flag, wanted } => {
                    kept.push(self.defines.flags.get(*flag) == Some(wanted));
                }
                Line::Else => {
                    if let Some(last) = kept.last_mut() {
                        *last = !*last;
                    }
                }
                Line::Endif => {
                    kept.pop();
                }
                _ if !active => {}
                Line::Import(import) => self.template(import),
                Line::Constants => {
                    let origin = Origin { file: (*name).to_owned(), line: number };
                    self.constants_at = Some((self.lines.len(), origin));
                }
                Line::Argument(argument) => self.arguments.push(*argument),
                Line::Note => {}
                Line::Text(text) => {
                    let words = self.words.of(text).into_iter().map(|(_, word)| word);
                    self.used.extend(words.filter(|w| self.defines.constants.contains_key(*w)));
                    let origin = Origin { file: (*name).to_owned(), line: number };
                    self.lines.push(((*text).to_owned(), origin));
                }
            }
        }
    }

    /// Inserts the declarations of the used constants at `#constants`.
    fn constants(&mut self) {
        let Some((at, origin)) = self.constants_at.take() else { return };
        let used =
            self.defines.constants.iter().filter(|(name, _)| self.used.contains(name.as_str()));
        let declarations =
            used.filter_map(|(name, constant)| Some((constant.declaration(name)?, origin.clone())));
        let declarations: Vec<_> = declarations.collect();
        self.lines.splice(at..at, declarations);
    }
}
