//! Arguments that functions hand on: `#argument name: type`.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::Words;

/// A name that functions read without declaring it, and its type in WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Argument<'a> {
    /// The name.
    pub name: &'a str,
    /// The type.
    pub of_type: &'a str,
}

/// A word of the text, with its byte offset.
type Word<'a> = (usize, &'a str);

/// A function: its name, and its further words.
struct Function<'a> {
    name: &'a str,
    words: Range<usize>,
}

/// The text in which every function that reads the argument, or calls one that has it, has it as its last argument. Functions that
/// declare the name themselves, such as entry points, are where it comes from. The number of lines stays.
/// `given`: functions of another text that have it.
pub fn hand_on<'a>(text: &'a str, argument: Argument<'_>, given: &[&'a str]) -> String {
    let words = words_of(text);
    let functions = functions_of(text, &words);
    let having = having(&functions, &words, argument.name, given);
    let mut inserted: BTreeMap<usize, String> = BTreeMap::new();
    for (index, (at, word)) in words.iter().enumerate() {
        if !having.contains(word) || !text[at + word.len()..].starts_with('(') {
            continue;
        }
        let is_declared = index > 0 && words[index - 1].1 == "fn";
        let open = at + word.len();
        let Some(close) = closing(text, open) else { continue };
        let last = text[..close].trim_end();
        let comma = if last.ends_with([',', '(']) { "" } else { ", " };
        let space = if last.ends_with(',') { " " } else { "" };
        let own = match is_declared {
            true => format!("{}: {}", argument.name, argument.of_type),
            false => argument.name.to_owned(),
        };
        let trailing = if last.ends_with(',') { "," } else { "" };
        inserted.insert(last.len(), format!("{comma}{space}{own}{trailing}"));
    }
    let mut out = String::with_capacity(text.len());
    let mut from = 0;
    for (at, what) in inserted {
        out.push_str(&text[from..at]);
        out.push_str(&what);
        from = at;
    }
    out.push_str(&text[from..]);
    out
}

/// All words outside comments.
fn words_of(text: &str) -> Vec<Word<'_>> {
    let mut words = Words::default();
    let mut found = Vec::new();
    let mut from = 0;
    for line in text.split_inclusive('\n') {
        found.extend(words.of(line).into_iter().map(|(at, word)| (from + at, word)));
        from += line.len();
    }
    found
}

/// The functions, which begin and end at the first column.
fn functions_of<'a>(text: &'a str, words: &[Word<'a>]) -> Vec<Function<'a>> {
    let mut found = Vec::new();
    for (index, (at, word)) in words.iter().enumerate() {
        let is_first = *at == 0 || text[..*at].ends_with('\n');
        let Some((_, name)) = words.get(index + 1).filter(|_| *word == "fn" && is_first) else {
            continue;
        };
        let end = text[*at..].find("\n}").map_or(text.len(), |end| at + end);
        let last = words.partition_point(|(at, _)| *at < end);
        found.push(Function { name, words: index + 2..last });
    }
    found
}

/// Names of the functions that have the argument.
fn having<'a>(
    functions: &[Function<'a>],
    words: &[Word<'a>],
    argument: &str,
    given: &[&'a str],
) -> BTreeSet<&'a str> {
    let is_declared =
        |pair: &[Word<'_>]| matches!(pair[0].1, "let" | "var") && pair[1].1 == argument;
    let mut having: BTreeSet<&str> = given.iter().copied().collect();
    loop {
        let before = having.len();
        for function in functions {
            let own = &words[function.words.clone()];
            let reads = own.iter().any(|(_, word)| *word == argument || having.contains(word));
            if reads && !own.windows(2).any(is_declared) {
                having.insert(function.name);
            }
        }
        if having.len() == before {
            return having;
        }
    }
}

/// Where the bracket closes that opens at `open`.
fn closing(text: &str, open: usize) -> Option<usize> {
    let mut depth = 0;
    for (at, c) in text[open..].char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(open + at);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARGUMENT: Argument<'_> = Argument { name: "pattern", of_type: "vec4f" };

    #[test]
    fn readers_and_their_callers_have_the_argument() {
        let text = "\
// pattern: scaled(1.0) in a comment
fn scaled(x: f32) -> f32 {
    return x * pattern.z;
}
fn plain(x: f32) -> f32 {
    return x;
}
fn sum(
    x: f32,
    y: f32,
) -> f32 {
    return scaled(scaled(x)) + plain(y) + none();
}
fn none() -> f32 {
    return scaled(
        1.0,
    );
}
@fragment
fn entry() -> f32 {
    let pattern = vec4f(1.0);
    return sum(1.0, scaled(2.0));
}
";
        let expected = "\
// pattern: scaled(1.0) in a comment
fn scaled(x: f32, pattern: vec4f) -> f32 {
    return x * pattern.z;
}
fn plain(x: f32) -> f32 {
    return x;
}
fn sum(
    x: f32,
    y: f32, pattern: vec4f,
) -> f32 {
    return scaled(scaled(x, pattern), pattern) + plain(y) + none(pattern);
}
fn none(pattern: vec4f) -> f32 {
    return scaled(
        1.0, pattern,
    );
}
@fragment
fn entry() -> f32 {
    let pattern = vec4f(1.0);
    return sum(1.0, scaled(2.0, pattern), pattern);
}
";
        assert_eq!(hand_on(text, ARGUMENT, &[]), expected);
    }

    #[test]
    fn functions_of_another_text_have_it_if_given() {
        let text = "fn sum() -> f32 {\n    let pattern = vec4f(1.0);\n    return scaled(1.0) + other(2.0);\n}\n";
        let expected = text.replace("scaled(1.0)", "scaled(1.0, pattern)");
        assert_eq!(hand_on(text, ARGUMENT, &["scaled"]), expected);
    }

    #[test]
    fn a_text_that_does_not_read_it_stays() {
        let text = "fn plain(x: f32) -> f32 {\n    return x;\n}\n";
        assert_eq!(hand_on(text, ARGUMENT, &[]), text);
    }
}
