//! Selection of variants and surfaces of a plan by name.

use crate::error::{Error, Result};

use super::item::suggest;
use super::{Plan, Rejected, SurfaceSpec, Variant};

impl Plan {
    /// The surface of that name. The error lists the names of the plan's surfaces.
    pub fn surface(&self, name: &str) -> Result<&SurfaceSpec> {
        let known: Vec<&str> = self.surfaces.iter().map(|surface| surface.name.as_str()).collect();
        let found = self.surfaces.iter().find(|surface| surface.name == name);
        found.ok_or_else(|| unknown("surface", name, &known))
    }

    /// The variant of that name; without a name, the only variant. `texts` is always found, although no plan lists it.
    pub fn variant(&self, name: Option<&str>) -> Result<Variant> {
        match (name, self.variants.as_slice()) {
            (Some(Variant::TEXTS), _) => Ok(Variant::texts(&self.optics)),
            (Some(name), variants) => {
                let found = variants.iter().find(|variant| variant.name == name).cloned();
                found.ok_or_else(|| self.absent(name))
            }
            (None, [only]) => Ok(only.clone()),
            (None, variants) => {
                let cause = format!("is not given, and the plan has {}", variants.len());
                let remedy =
                    format!("add --variant with one of {}", self.variant_names().join(", "));
                Err(Error::new("variant", cause).remedy(remedy))
            }
        }
    }

    /// The variants that match any of the patterns (`*`, `?`), in the order of the plan; all variants if there are no
    /// patterns. `texts` comes last, and only if it is named exactly. It is an error if a pattern matches nothing.
    pub fn select(&self, patterns: &[String]) -> Result<Vec<Variant>> {
        if patterns.is_empty() {
            return Ok(self.variants.clone());
        }
        for pattern in patterns.iter().filter(|pattern| *pattern != Variant::TEXTS) {
            if !self.variants.iter().any(|variant| matches(pattern, &variant.name)) {
                return Err(self.absent(pattern));
            }
        }
        let wanted =
            |variant: &&Variant| patterns.iter().any(|pattern| matches(pattern, &variant.name));
        let mut selected: Vec<Variant> = self.variants.iter().filter(wanted).cloned().collect();
        if patterns.iter().any(|pattern| pattern == Variant::TEXTS) {
            selected.push(Variant::texts(&self.optics));
        }
        Ok(selected)
    }

    /// The error for a pattern that matches no variant.
    fn absent(&self, pattern: &str) -> Error {
        match self.rejected.iter().find(|rejected| matches(pattern, &rejected.name)) {
            Some(Rejected { name, reason }) => Error::new(format!("variant \"{name}\""), reason),
            None => unknown("variant", pattern, &self.variant_names()),
        }
    }

    fn variant_names(&self) -> Vec<&str> {
        self.variants.iter().map(|variant| variant.name.as_str()).collect()
    }
}

fn unknown(what: &str, name: &str, known: &[&str]) -> Error {
    Error::new(format!("{what} \"{name}\""), "is not in the plan").remedy(suggest(name, known))
}

/// Whether a pattern of plain characters, `*` (any run) and `?` (any one) matches a whole text.
fn matches(pattern: &str, text: &str) -> bool {
    // `reached[i]`: the pattern so far matches the first `i` characters.
    let text: Vec<char> = text.chars().collect();
    let mut reached = vec![false; text.len() + 1];
    reached[0] = true;
    for symbol in pattern.chars() {
        let mut next = vec![false; text.len() + 1];
        for i in 0..=text.len() {
            next[i] = match symbol {
                '*' => reached[i] || (i > 0 && next[i - 1]),
                _ => i > 0 && reached[i - 1] && (symbol == '?' || symbol == text[i - 1]),
            };
        }
        reached = next;
    }
    reached[text.len()]
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn patterns_match_whole_names() {
        for (pattern, text, expected) in [
            ("*", "", true),
            ("full-*", "full-taylor-t31", true),
            ("full", "full-taylor-t31", false),
            ("*t31*", "full-taylor-t31-r2", true),
            ("*-t?1", "full-taylor-t31", true),
            ("**", "x", true),
            ("", "x", false),
        ] {
            assert_eq!(matches(pattern, text), expected, "{pattern} on {text}");
        }
    }
}
