//! Reads every template that a root imports, directly or indirectly, and finds all errors of the dialect.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::Diagnostic;

use super::argument::Argument;
use super::{Defines, Sources, Words};

/// Beginning of a note to the developers of the templates.
const NOTE: &str = "//-";

/// Characters that end a line comment of WGSL.
const LINE_BREAKS: [char; 7] = ['\n', '\u{b}', '\u{c}', '\r', '\u{85}', '\u{2028}', '\u{2029}'];

/// One line of a template.
pub enum Line<'a> {
    Text(&'a str),
    Note,
    Import(&'a str),
    Condition { flag: &'a str, wanted: bool },
    Else,
    Endif,
    Constants,
    Argument(Argument<'a>),
}

/// Templates by name, line by line.
pub type Templates<'a> = BTreeMap<&'a str, Vec<Line<'a>>>;

/// The templates that `root` imports, directly or indirectly, or all errors in them.
pub fn check<'a>(
    sources: &'a Sources,
    root: &'a str,
    defines: &Defines,
) -> Result<Templates<'a>, Vec<Diagnostic>> {
    let mut check = Check {
        sources,
        defines,
        root,
        templates: BTreeMap::new(),
        used: BTreeSet::new(),
        constants_block: None,
        errors: Vec::new(),
    };
    if !sources.0.contains_key(root) {
        let error = Diagnostic::error(format!("unknown template `{root}`"));
        return Err(vec![with_nearest(error, root, sources.0.keys())]);
    }
    check.template(root);
    check.defines();
    if check.errors.is_empty() { Ok(check.templates) } else { Err(check.errors) }
}

struct Check<'a, 'd> {
    sources: &'a Sources,
    defines: &'d Defines,
    root: &'a str,
    templates: Templates<'a>,
    /// Flags that are tested and words that occur, in any template and any branch.
    used: BTreeSet<&'a str>,
    /// Line of the `#constants` directive.
    constants_block: Option<u32>,
    errors: Vec<Diagnostic>,
}

/// An open block: its beginning, and whether its `#else` was read.
struct Block {
    line: u32,
    column: u32,
    otherwise: bool,
}

impl<'a> Check<'a, '_> {
    /// Reads one template, then those it imports.
    fn template(&mut self, name: &'a str) {
        let Some(text) = self.sources.0.get(name) else { return };
        self.templates.insert(name, Vec::new());
        let mut lines = Vec::new();
        let mut blocks = Vec::new();
        let mut imports = Vec::new();
        let mut words = Words::default();
        for (number, text) in (1..).zip(text.lines()) {
            let line = if text.trim_start().starts_with('#') {
                self.directive(name, number, text, &mut blocks).unwrap_or(Line::Text(""))
            } else if text.trim_start().starts_with(NOTE) && !words.in_block_comment() {
                if text.contains(LINE_BREAKS) {
                    self.error(
                        name,
                        number,
                        1,
                        "a note contains a line break, so code would be dropped with it",
                    );
                }
                Line::Note
            } else {
                self.used.extend(words.of(text).into_iter().map(|(_, word)| word));
                if let Some(at) = text.find(NOTE) {
                    let column = text[..at].chars().count() as u32 + 1;
                    let message = "a note must be on a line of its own, outside block comments";
                    self.error(name, number, column, message);
                }
                Line::Text(text.trim_end())
            };
            if let Line::Import(import) = line {
                imports.push(import);
            }
            lines.push(line);
        }
        for block in blocks {
            self.error(name, block.line, block.column, "block without `#endif`");
        }
        self.templates.insert(name, lines);
        for import in imports {
            if !self.templates.contains_key(import) {
                self.template(import);
            }
        }
    }

    /// Reads a directive. Returns `None` after an error.
    fn directive(
        &mut self,
        file: &str,
        number: u32,
        text: &'a str,
        blocks: &mut Vec<Block>,
    ) -> Option<Line<'a>> {
        let code = text.find("//").map_or(text, |comment| &text[..comment]);
        let mut tokens = code.split_whitespace().map(|token| {
            let offset = token.as_ptr() as usize - text.as_ptr() as usize;
            (text[..offset].chars().count() as u32 + 1, token)
        });
        let (column, directive) = tokens.next()?;
        let operands =
            usize::from(matches!(directive, "#import" | "#ifdef" | "#ifndef" | "#argument"));
        let known = ["#import", "#ifdef", "#ifndef", "#else", "#endif", "#constants", "#argument"];
        if !known.contains(&directive) {
            let error = Diagnostic::error(format!("unknown directive `{directive}`"))
                .at(self.sources.place(file, number, column));
            self.errors.push(with_nearest(error, directive, known));
            return None;
        }
        let operand = if operands == 1 { tokens.next() } else { None };
        let of_type = if directive == "#argument" { tokens.next() } else { None };
        if let Some((column, extra)) = tokens.next() {
            let message = format!("unexpected `{extra}` after `{directive}`");
            self.error(file, number, column, message);
        }
        if operands == 1 && operand.is_none() {
            let what = match directive {
                "#import" => "template",
                "#argument" => "argument",
                _ => "flag",
            };
            self.error(file, number, column, format!("`{directive}` without the name of a {what}"));
        }
        match directive {
            "#ifdef" | "#ifndef" => {
                blocks.push(Block { line: number, column, otherwise: false });
                let (column, flag) = operand?;
                self.flag(file, number, column, flag);
                Some(Line::Condition { flag, wanted: directive == "#ifdef" })
            }
            "#else" => {
                match blocks.last_mut() {
                    None => self.error(file, number, column, "`#else` outside a block"),
                    Some(block) if block.otherwise => {
                        let message = format!(
                            "second `#else` of the block that begins in line {}",
                            block.line
                        );
                        self.error(file, number, column, message);
                    }
                    Some(block) => block.otherwise = true,
                }
                Some(Line::Else)
            }
            "#endif" => {
                if blocks.pop().is_none() {
                    self.error(file, number, column, "`#endif` outside a block");
                }
                Some(Line::Endif)
            }
            "#argument" => {
                let (column, name) = operand?;
                let Some((name, (_, of_type))) = name.strip_suffix(':').zip(of_type) else {
                    self.error(file, number, column, "`#argument` needs `name: type`");
                    return None;
                };
                Some(Line::Argument(Argument { name, of_type }))
            }
            "#import" => {
                let (column, import) = operand?;
                if !self.sources.0.contains_key(import) {
                    let error = Diagnostic::error(format!("unknown template `{import}`"))
                        .at(self.sources.place(file, number, column));
                    self.errors.push(with_nearest(error, import, self.sources.0.keys()));
                    return None;
                }
                Some(Line::Import(import))
            }
            _ => {
                if file != self.root {
                    let message =
                        format!("`#constants` belongs in the root template `{}`", self.root);
                    self.error(file, number, column, message);
                } else if !blocks.is_empty() {
                    self.error(file, number, column, "`#constants` inside a block");
                } else if let Some(first) = self.constants_block {
                    let message = format!("second `#constants`; the first is in line {first}");
                    self.error(file, number, column, message);
                }
                self.constants_block.get_or_insert(number);
                Some(Line::Constants)
            }
        }
    }

    /// Records that a flag is tested. It must be declared.
    fn flag(&mut self, file: &str, line: u32, column: u32, flag: &'a str) {
        self.used.insert(flag);
        if self.defines.flags.contains_key(flag) {
            return;
        }
        let place = self.sources.place(file, line, column);
        let error = Diagnostic::error(format!("`{flag}` is not a declared flag")).at(place);
        self.errors.push(if self.defines.constants.contains_key(flag) {
            error.help("it is a constant; only flags can be tested")
        } else {
            with_nearest(error, flag, self.defines.flags.keys())
        });
    }

    /// Checks that every flag and constant is used, and that every constant has a value, a meaning and a place.
    fn defines(&mut self) {
        let root = self.root;
        let line = self.constants_block.unwrap_or(1);
        let (flags, constants) = (&self.defines.flags, &self.defines.constants);
        let mut found = Vec::new();
        for flag in flags.keys().filter(|flag| !self.used.contains(flag.as_str())) {
            found.push((
                1,
                format!(
                    "flag `{flag}` is declared, but this template and its imports do not test it"
                ),
            ));
        }
        for (name, constant) in constants {
            if !self.used.contains(name.as_str()) {
                found.push((
                    line,
                    format!(
                        "constant `{name}` is given, but this template and its imports do not use it"
                    ),
                ));
            }
            if constant.value.literal().is_none() {
                let value = constant.value;
                found.push((line, format!("constant `{name}` is not a finite f32: {value:?}")));
            }
            let meaning = constant.meaning;
            if meaning.trim().is_empty() || meaning.contains(LINE_BREAKS) {
                found.push((
                    line,
                    format!("the meaning of constant `{name}` is not one line of text"),
                ));
            }
        }
        if !constants.is_empty() && self.constants_block.is_none() {
            found.push((
                1,
                "constants are given, but the template does not contain `#constants`".to_owned(),
            ));
        }
        for (line, message) in found {
            self.error(root, line, 1, message);
        }
    }

    fn error(&mut self, file: &str, line: u32, column: u32, message: impl Into<String>) {
        let place = self.sources.place(file, line, column);
        self.errors.push(Diagnostic::error(message).at(place));
    }
}

/// Adds the most similar known name, if one is similar enough.
fn with_nearest<N: AsRef<str>>(
    error: Diagnostic,
    name: &str,
    known: impl IntoIterator<Item = N>,
) -> Diagnostic {
    let nearest = known
        .into_iter()
        .map(|known| (strsim::jaro_winkler(name, known.as_ref()), known))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match nearest {
        Some((likeness, known)) if likeness > 0.8 => {
            error.help(format!("did you mean `{}`?", known.as_ref()))
        }
        _ => error,
    }
}
