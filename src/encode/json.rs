//! JSON, of finite numbers only: the format has no others, and its writers put `null` in their place.

use std::fmt::{self, Display};

use serde::Serialize;
use serde::ser::{
    Error as _, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant,
    SerializeTuple, SerializeTupleStruct, SerializeTupleVariant, Serializer,
};

use crate::error::{Error, Result};

/// A value as JSON over several lines, with a line break at the end. `subject` names it in errors. It is an error, with the
/// place, if a number is not finite.
pub fn json(subject: impl Display, value: &impl Serialize) -> Result<String> {
    write(subject, value, |value| serde_json::to_string_pretty(value)).map(|text| text + "\n")
}

/// The same on one line, without a line break.
pub fn json_line(subject: impl Display, value: &impl Serialize) -> Result<String> {
    write(subject, value, |value| serde_json::to_string(value))
}

fn write<T: Serialize>(
    subject: impl Display,
    value: &T,
    write: impl FnOnce(&T) -> serde_json::Result<String>,
) -> Result<String> {
    let mut check = Check { path: Vec::new() };
    if let Err(NotFinite(cause)) = value.serialize(&mut check) {
        let remedy = "this is a fault of the program or of its input: numbers so far from sense are not written";
        return Err(Error::new(subject, format!("{}: {cause}", check.place())).remedy(remedy));
    }
    write(value).map_err(|error| Error::new(subject, "cannot be written as JSON").source(error))
}

/// A serialiser that writes nothing and fails at a number that is not finite.
struct Check {
    /// Keys and indices from the outermost value to the present one.
    path: Vec<String>,
}

impl Check {
    fn place(&self) -> String {
        self.path.join(".")
    }

    /// Checks a value under a key. The key stays in the path if the check fails.
    fn under(&mut self, key: impl ToString, value: &(impl Serialize + ?Sized)) -> Checked {
        self.path.push(key.to_string());
        value.serialize(&mut *self)?;
        self.path.pop();
        Ok(())
    }
}

#[derive(Debug)]
struct NotFinite(String);

type Checked = std::result::Result<(), NotFinite>;

impl Display for NotFinite {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

impl std::error::Error for NotFinite {}

impl serde::ser::Error for NotFinite {
    fn custom<T: Display>(cause: T) -> NotFinite {
        NotFinite(cause.to_string())
    }
}

/// A sequence or a map under way.
struct Inside<'a> {
    check: &'a mut Check,
    index: usize,
    key: String,
}

impl Inside<'_> {
    fn next(&mut self, value: &(impl Serialize + ?Sized)) -> Checked {
        let index = self.index;
        self.index += 1;
        self.check.under(index, value)
    }
}

/// Methods of scalars that are always fine.
macro_rules! fine {
    ($($method:ident: $type:ty),*) => {
        $(fn $method(self, _: $type) -> Checked { Ok(()) })*
    };
}

impl<'a> Serializer for &'a mut Check {
    type Ok = ();
    type Error = NotFinite;
    type SerializeSeq = Inside<'a>;
    type SerializeTuple = Inside<'a>;
    type SerializeTupleStruct = Inside<'a>;
    type SerializeTupleVariant = Inside<'a>;
    type SerializeMap = Inside<'a>;
    type SerializeStruct = Inside<'a>;
    type SerializeStructVariant = Inside<'a>;

    fine!(
        serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64, serialize_char: char,
        serialize_str: &str, serialize_bytes: &[u8]
    );

    fn serialize_f32(self, number: f32) -> Checked {
        self.serialize_f64(f64::from(number))
    }

    fn serialize_f64(self, number: f64) -> Checked {
        match number.is_finite() {
            true => Ok(()),
            false => Err(NotFinite::custom(format!("is {number}, not a finite number"))),
        }
    }

    fn serialize_none(self) -> Checked {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Checked {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Checked {
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Checked {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Checked {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Checked {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Checked {
        self.under(variant, value)
    }

    fn serialize_seq(self, _: Option<usize>) -> std::result::Result<Inside<'a>, NotFinite> {
        Ok(Inside { check: self, index: 0, key: String::new() })
    }

    fn serialize_tuple(self, _: usize) -> std::result::Result<Inside<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_tuple_struct(
        self,
        _: &'static str,
        _: usize,
    ) -> std::result::Result<Inside<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> std::result::Result<Inside<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_map(self, _: Option<usize>) -> std::result::Result<Inside<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_struct(
        self,
        _: &'static str,
        _: usize,
    ) -> std::result::Result<Inside<'a>, NotFinite> {
        self.serialize_seq(None)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> std::result::Result<Inside<'a>, NotFinite> {
        self.serialize_seq(None)
    }
}

/// Traits of sequences, which have one method for an element and one for the end.
macro_rules! sequence {
    ($($name:ident.$method:ident),*) => {
        $(impl $name for Inside<'_> {
            type Ok = ();
            type Error = NotFinite;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Checked {
                self.next(value)
            }

            fn end(self) -> Checked {
                Ok(())
            }
        })*
    };
}

/// Traits of structures, whose keys are known.
macro_rules! structure {
    ($($name:ident),*) => {
        $(impl $name for Inside<'_> {
            type Ok = ();
            type Error = NotFinite;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Checked {
                self.check.under(key, value)
            }

            fn end(self) -> Checked {
                Ok(())
            }
        })*
    };
}

sequence!(
    SerializeSeq.serialize_element,
    SerializeTuple.serialize_element,
    SerializeTupleStruct.serialize_field,
    SerializeTupleVariant.serialize_field
);
structure!(SerializeStruct, SerializeStructVariant);

impl SerializeMap for Inside<'_> {
    type Ok = ();
    type Error = NotFinite;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Checked {
        let text = serde_json::to_string(key).unwrap_or_default();
        text.trim_matches('"').clone_into(&mut self.key);
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Checked {
        let key = std::mem::take(&mut self.key);
        self.check.under(key, value)
    }

    fn end(self) -> Checked {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[derive(Serialize)]
    struct Row {
        name: &'static str,
        values: Vec<f64>,
        more: Option<f32>,
    }

    #[test]
    fn numbers_that_json_cannot_hold_are_named() {
        let with = |values: Vec<f64>, more| {
            let rows = vec![
                Row { name: "a", values: vec![1.0], more: None },
                Row { name: "b", values, more },
            ];
            json_line("probe.json", &BTreeMap::from([("probes", rows)])).map_err(|e| e.to_string())
        };
        let sound = with(vec![1e308, -0.5], Some(2.0));
        assert_eq!(
            sound.as_deref(),
            Ok(concat!(
                r#"{"probes":[{"name":"a","values":[1.0],"more":null},"#,
                r#"{"name":"b","values":[1e+308,-0.5],"more":2.0}]}"#
            ))
        );
        for (values, more, place) in [
            (vec![1.0, f64::NAN], None, "probes.1.values.1: is NaN"),
            (vec![f64::NEG_INFINITY], None, "probes.1.values.0: is -inf"),
            (vec![], Some(f32::INFINITY), "probes.1.more: is inf"),
        ] {
            let error = with(values, more).expect_err(place);
            assert!(error.starts_with("probe.json: ") && error.contains(place), "{error}");
        }
    }
}
