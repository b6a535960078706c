//! How the numbers of a block are written: which character separates them, and whether the comma is a decimal one.

use super::decode::{Line, line, lines};
use crate::error::{Error, Result};

/// How fields are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// `None`: white space.
    pub separator: Option<char>,
    pub has_decimal_comma: bool,
}

/// What the characters between digits of a whole block are.
#[derive(Default)]
struct Seen {
    semicolon: bool,
    blank: bool,
    point: bool,
    /// Commas before white space or the end of a line, and others.
    loose_comma: bool,
    tight_comma: bool,
}

/// The data of lines, with their numbers. Words before numbers are a corner: a block has no other words.
pub(super) fn data(text: &str, first_line: usize) -> impl Iterator<Item = (usize, &str)> {
    lines(text).filter_map(move |(number, raw)| match line(raw) {
        Line::Data(data) | Line::Words(data) => Some((first_line + number - 1, data)),
        _ => None,
    })
}

/// Decides how numbers are written. `names`: whether the header names as many columns as commas make.
pub(super) fn layout(
    text: &str,
    first_line: usize,
    has_two_names: bool,
    subject: &str,
) -> Result<Layout> {
    let mut seen = Seen::default();
    for (_, line) in data(text, first_line) {
        look(line.trim().as_bytes(), &mut seen);
    }
    let made = |separator, has_decimal_comma| Ok(Layout { separator, has_decimal_comma });
    let Seen { semicolon, blank, point, loose_comma, tight_comma } = seen;
    let between = if semicolon { Some(';') } else { None };
    match (loose_comma, tight_comma) {
        (false, false) => made(between, false),
        (false, true) if semicolon || blank => match (point, semicolon) {
            (false, _) => made(between, true),
            (true, false) => made(Some(','), false),
            (true, true) => Err(mixed(subject)),
        },
        (true, false) if !semicolon => made(Some(','), false),
        (true, true) if (point || !blank) && !semicolon => made(Some(','), false),
        (false, true) if point => made(Some(','), false),
        (false, true) => only_commas(text, first_line, has_two_names, subject),
        _ => Err(mixed(subject)),
    }
}

fn look(line: &[u8], seen: &mut Seen) {
    for (at, &byte) in line.iter().enumerate() {
        match byte {
            b';' => seen.semicolon = true,
            b' ' | b'\t' => seen.blank = true,
            b'.' => seen.point = true,
            b',' => match line.get(at + 1) {
                None | Some(b' ' | b'\t' | b'"') => seen.loose_comma = true,
                Some(_) => seen.tight_comma = true,
            },
            _ => {}
        }
    }
}

fn mixed(subject: &str) -> Error {
    Error::new(
        subject,
        "commas stand between digits in a way that may be read as decimal commas or as separators",
    )
    .remedy("write numbers with a decimal point, and blanks, tabs or semicolons between them")
}

/// Commas are all that stands between digits: decimal ones, or separators of whole numbers?
fn only_commas(
    text: &str,
    first_line: usize,
    has_two_names: bool,
    subject: &str,
) -> Result<Layout> {
    let (mut is_decimal, mut is_separator, mut example) = (false, has_two_names, None);
    let mut is_single = true;
    for (_, line) in data(text, first_line) {
        let fields: Vec<&str> =
            line.trim().split(',').map(|f| f.trim_matches(['"', ' '])).collect();
        is_single &= fields.len() <= 2;
        example = example.or_else(|| (fields.len() == 2).then(|| line.trim().to_owned()));
        for (at, field) in fields.iter().enumerate() {
            let is_whole = !field.is_empty() && field.bytes().all(|b| b.is_ascii_digit());
            // no whole number begins with a zero
            is_decimal |= at > 0 && is_whole && field.len() > 1 && field.starts_with('0');
            is_separator |= at > 0 && !is_whole && !field.contains(['e', 'E']);
        }
    }
    let made = |separator, has_decimal_comma| Ok(Layout { separator, has_decimal_comma });
    match (is_single, is_decimal, is_separator) {
        (true, true, false) => made(None, true),
        (_, false, true) | (false, false, false) => made(Some(','), false),
        _ => {
            let example = example.unwrap_or_else(|| "0,12".to_owned());
            let shown: String = example.chars().take(30).collect();
            let cause = format!(
                "`{shown}` may be the number {} or the numbers {}",
                shown.replacen(',', ".", 1),
                shown.replace(',', " and ")
            );
            Err(Error::new(subject, cause)
                .remedy("write a decimal point, or semicolons between numbers"))
        }
    }
}
