//! Inputs of a template: flags that keep or drop its lines, and the constants of its one generated block.

use std::collections::BTreeMap;

/// Flags and constants of one specialised shader.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Defines {
    /// Every flag that a template may test, on or off.
    pub flags: BTreeMap<String, bool>,
    /// The constants of the `#constants` block. Those that only dropped branches use are left out of the text.
    pub constants: BTreeMap<String, Constant>,
}

impl Defines {
    /// Sets a flag.
    pub fn flag(&mut self, name: &str, on: bool) {
        self.flags.insert(name.to_owned(), on);
    }

    /// Adds a whole number. Numbers above the largest `i32` become the largest `i32`.
    pub fn count(&mut self, name: &str, count: usize, meaning: &'static str) {
        let count = i32::try_from(count).unwrap_or(i32::MAX);
        self.constants.insert(name.to_owned(), Constant::new(Value::I32(count), meaning));
    }

    /// Adds a number. Its meaning states the unit.
    pub fn number(&mut self, name: &str, number: f64, meaning: &'static str) {
        self.constants.insert(name.to_owned(), Constant::new(Value::F32(number), meaning));
    }
}

/// A generated constant: `const NAME: TYPE = VALUE; // meaning`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    /// The value. It determines the type.
    pub value: Value,
    /// The comment behind the declaration: one line of at least one word. It is a literal, so it cannot contain a
    /// computed number.
    pub meaning: &'static str,
}

impl Constant {
    /// A value and its meaning.
    pub fn new(value: Value, meaning: &'static str) -> Constant {
        Constant { value, meaning }
    }

    /// The line that declares it; `None` for a number that is not finite in single precision.
    pub fn declaration(&self, name: &str) -> Option<String> {
        let Constant { value, meaning } = self;
        Some(format!("const {name}: {} = {}; // {meaning}", value.ty(), value.literal()?))
    }
}

/// Value of a generated constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// `i32`.
    I32(i32),
    /// `u32`.
    U32(u32),
    /// `f32`: rounded to single precision, printed in the shortest form that reads back as the same number.
    F32(f64),
}

impl Value {
    /// The WGSL type.
    pub fn ty(self) -> &'static str {
        match self {
            Value::I32(_) => "i32",
            Value::U32(_) => "u32",
            Value::F32(_) => "f32",
        }
    }

    /// The WGSL literal; `None` for a number that is not finite in single precision.
    pub fn literal(self) -> Option<String> {
        match self {
            // WGSL reads `-2147483648` as the negation of an abstract number, which fits
            Value::I32(value) => Some(value.to_string()),
            Value::U32(value) => Some(format!("{value}u")),
            Value::F32(value) => {
                let single = value as f32;
                let text = format!("{single:?}");
                let point = match text.split_once('e') {
                    Some((digits, power)) if !digits.contains('.') => format!("{digits}.0e{power}"),
                    _ => text,
                };
                single.is_finite().then_some(point)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_read_back() {
        let cases = [
            (Value::F32(1.0), "1.0"),
            (Value::F32(0.1), "0.1"),
            (Value::F32(-2.5e-9), "-2.5e-9"),
            (Value::F32(1e-7), "1.0e-7"),
            (Value::F32(3e20), "3.0e20"),
            (Value::F32(std::f64::consts::PI), "3.1415927"),
            (Value::I32(i32::MIN), "-2147483648"),
            (Value::I32(7), "7"),
            (Value::U32(u32::MAX), "4294967295u"),
        ];
        for (constant, expected) in cases {
            let literal = constant.literal().unwrap();
            assert_eq!(literal, expected);
            let text = format!("const X: {} = {literal};", constant.ty());
            naga::front::wgsl::parse_str(&text).unwrap();
            if let Value::F32(value) = constant {
                assert_eq!(literal.parse::<f32>().unwrap(), value as f32);
            }
        }
        assert_eq!(Value::F32(1e39).literal(), None);
        assert_eq!(Value::F32(f64::NAN).literal(), None);
    }
}
