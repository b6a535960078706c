//! Splits WGSL into words, without comments.

/// Reads a text line by line. It keeps track of open block comments, which nest in WGSL.
#[derive(Default)]
pub(crate) struct Words {
    depth: u32,
}

impl Words {
    /// Whether the next line begins inside a block comment.
    pub(crate) fn in_block_comment(&self) -> bool {
        self.depth > 0
    }

    /// Identifiers, keywords and numbers of the next line, each with its byte offset.
    pub(crate) fn of<'a>(&mut self, line: &'a str) -> Vec<(usize, &'a str)> {
        let bytes = line.as_bytes();
        let mut words = Vec::new();
        let mut at = 0;
        while at < bytes.len() {
            let rest = &line[at..];
            if rest.starts_with("/*") {
                self.depth += 1;
                at += 2;
            } else if self.depth > 0 && rest.starts_with("*/") {
                self.depth -= 1;
                at += 2;
            } else if self.depth == 0 && rest.starts_with("//") {
                break;
            } else {
                let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_'));
                let length = end.unwrap_or(rest.len());
                if length > 0 && self.depth == 0 {
                    words.push((at, &rest[..length]));
                }
                at += length.max(rest.chars().next().map_or(1, char::len_utf8));
            }
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_skipped() {
        let mut words = Words::default();
        assert_eq!(words.of("let é = a_1; // b"), [(0, "let"), (4, "é"), (9, "a_1")]);
        assert_eq!(words.of("x /* y /* z */ w"), [(0, "x")]);
        assert_eq!(words.of("v */ u // t"), [(5, "u")]);
    }
}
