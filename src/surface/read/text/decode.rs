//! Bytes to text: UTF-8, UTF-16 with a byte-order mark, otherwise Latin-1; and text to lines.

use std::borrow::Cow;

use crate::error::{Error, Result};

const UTF8: &[u8] = b"\xef\xbb\xbf";
const LITTLE: &[u8] = b"\xff\xfe";
const BIG: &[u8] = b"\xfe\xff";

/// Whether the first bytes are text.
pub fn is_text(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(1024)];
    let texty = |b: &u8| *b >= b' ' || b.is_ascii_whitespace();
    head.starts_with(LITTLE)
        || head.starts_with(BIG)
        || wide_without_mark(head)
        || head.iter().all(texty)
}

/// Whether every second byte is zero, as in UTF-16 without its mark.
fn wide_without_mark(head: &[u8]) -> bool {
    let pairs = head.as_chunks::<2>().0;
    let zeros = |at: usize| pairs.iter().filter(|pair| pair[at] == 0).count();
    let is_mostly = |n: usize| n * 10 >= pairs.len() * 9;
    pairs.len() >= 2
        && ((is_mostly(zeros(0)) && zeros(1) == 0) || (is_mostly(zeros(1)) && zeros(0) == 0))
}

/// The text of a file, without its mark.
pub(super) fn text<'b>(
    bytes: &'b [u8],
    subject: &str,
    notes: &mut Vec<String>,
) -> Result<Cow<'b, str>> {
    let error =
        |cause: &str| Error::new(subject, cause).remedy("save it as UTF-8, or export it again");
    let wide = |bytes: &[u8], from: fn([u8; 2]) -> u16| {
        let (pairs, rest) = bytes.as_chunks::<2>();
        let units: Vec<u16> = pairs.iter().map(|&pair| from(pair)).collect();
        match (String::from_utf16(&units), rest) {
            (Ok(text), []) => Ok(Cow::Owned(text)),
            _ => Err(error("the text begins as UTF-16 and is damaged")),
        }
    };
    if bytes.starts_with(b"\xff\xfe\0\0") || bytes.starts_with(b"\0\0\xfe\xff") {
        return Err(error("the text is UTF-32, which is not read"));
    }
    if let Some(rest) = bytes.strip_prefix(LITTLE) {
        return wide(rest, u16::from_le_bytes);
    }
    if let Some(rest) = bytes.strip_prefix(BIG) {
        return wide(rest, u16::from_be_bytes);
    }
    if wide_without_mark(&bytes[..bytes.len().min(1024)]) {
        let is_big = bytes.first() == Some(&0);
        return wide(bytes, if is_big { u16::from_be_bytes } else { u16::from_le_bytes });
    }
    let bytes = bytes.strip_prefix(UTF8).unwrap_or(bytes);
    if bytes.contains(&0) {
        return Err(error("the text has NUL bytes"));
    }
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        // every byte of Latin-1 is the character of the same number; only words of headers can be meant
        Err(_) => {
            notes.push("the text is not UTF-8: read as Latin-1".to_owned());
            Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect())
        }
    })
}

/// The lines of a text with their numbers from 1. A line ends in LF, CR LF or CR.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let pieces = text.split('\n').map(|line| line.strip_suffix('\r').unwrap_or(line));
    pieces.flat_map(|line| line.split('\r')).enumerate().map(|(i, line)| (i + 1, line))
}

/// The fields of one line, whichever single separator it has.
pub(super) fn fields(line: &str) -> Vec<&str> {
    let line = line.trim_end();
    match [';', '\t'].into_iter().find(|&c| line.contains(c)) {
        Some(separator) => line.split(separator).map(str::trim).collect(),
        None if line.contains(' ') => {
            line.split_whitespace().map(|f| f.trim_end_matches(',')).collect()
        }
        None => line.split(',').collect(),
    }
}

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Line<'t> {
    Blank,
    /// After `#`.
    Comment(&'t str),
    /// Begins with a word.
    Words(&'t str),
    /// Begins with a number, or with an empty field before one.
    Data(&'t str),
}

/// Words in place of a height that mean that there is none.
pub(super) const VOIDS: [&str; 12] =
    ["nan", "-nan", "bad", "n/a", "na", "null", "void", "invalid", "---", "--", "***", "no data"];

pub(super) fn line(line: &str) -> Line<'_> {
    let start = line.trim_start();
    if start.is_empty() {
        return Line::Blank;
    }
    if let Some(comment) = start.strip_prefix('#') {
        return Line::Comment(comment.trim());
    }
    let data = line.split('#').next().unwrap_or_default().trim_end();
    let field = data.trim_start_matches([' ', '\t', ';', ',', '"']);
    let unsigned = field.strip_prefix(['-', '+', '−']).unwrap_or(field);
    let digits = unsigned.strip_prefix(['.', ',']).unwrap_or(unsigned);
    if digits.starts_with(|c: char| c.is_ascii_digit()) {
        return Line::Data(data);
    }
    let end = field.find([' ', '\t', ';', ',', '"']).unwrap_or(field.len());
    let word = field[..end].to_ascii_lowercase();
    match VOIDS.contains(&word.as_str()) || matches!(word.as_str(), "inf" | "-inf" | "infinity") {
        true => Line::Data(data),
        false => Line::Words(line.trim()),
    }
}
