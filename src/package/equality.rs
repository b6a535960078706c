//! Comparison of a file on disk with a newly generated one.

use serde_json::Value;

use crate::plan::TableFormat;
use crate::tables::TexelFormat;
use crate::tables::container::decode;

use super::Equality;

/// Smaller numbers are rounding errors of values of order one.
const RESIDUE: f64 = 1e-15;

/// Whether the bytes on disk equal the new ones within the tolerance.
pub(super) fn same(compare: Equality, fresh: &[u8], disk: &[u8]) -> bool {
    if fresh == disk {
        return true;
    }
    match compare {
        Equality::Bytes => false,
        Equality::Json { tolerance } => {
            match (serde_json::from_slice(fresh), serde_json::from_slice(disk)) {
                (Ok(fresh), Ok(disk)) => same_json(&fresh, &disk, tolerance, 0.0),
                _ => false,
            }
        }
        Equality::Table { format, tolerance, layer } => {
            let format = match format {
                TableFormat::F32 => TexelFormat::Rg32Float,
                TableFormat::F16 => TexelFormat::Rg16Float,
                TableFormat::Rgb9e5 => TexelFormat::Rgb9e5Ufloat,
            };
            same_numbers(fresh, disk, tolerance, layer, format)
        }
        Equality::Container { container, shape, tolerance } => {
            // an edited file may be of any length
            if fresh.len() != disk.len() {
                return false;
            }
            let texels = |file| decode(container, &shape, file);
            let (Some(fresh), Some(disk)) = (texels(fresh), texels(disk)) else { return false };
            same_numbers(&fresh, &disk, tolerance, shape.layer_numbers(), shape.format)
        }
    }
}

/// `scale`: the largest magnitude in the array that both numbers belong to.
fn same_json(fresh: &Value, disk: &Value, tolerance: f64, scale: f64) -> bool {
    match (fresh, disk) {
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len()
                && a.iter()
                    .all(|(key, x)| b.get(key).is_some_and(|y| same_json(x, y, tolerance, 0.0)))
        }
        (Value::Array(a), Value::Array(b)) => {
            let scale =
                a.iter().filter_map(Value::as_f64).fold(0.0, |max: f64, x| max.max(x.abs()));
            a.len() == b.len() && a.iter().zip(b).all(|(x, y)| same_json(x, y, tolerance, scale))
        }
        (Value::Number(a), Value::Number(b)) => {
            if a == b {
                return true;
            }
            let whole = |n: &serde_json::Number| n.is_i64() || n.is_u64();
            match (a.as_f64(), b.as_f64()) {
                (Some(x), Some(y)) if !(whole(a) && whole(b)) => {
                    (x - y).abs() <= tolerance * x.abs().max(y.abs()).max(scale) + RESIDUE
                }
                _ => false,
            }
        }
        _ => fresh == disk,
    }
}

/// `layer`: number of consecutive numbers that are compared relative to their largest magnitude; 0 for all.
fn same_numbers(
    fresh: &[u8],
    disk: &[u8],
    tolerance: f64,
    layer: usize,
    format: TexelFormat,
) -> bool {
    let texel = format.texel_bytes();
    if fresh.len() != disk.len() || !fresh.len().is_multiple_of(texel) {
        return false;
    }
    let texels = if layer == 0 { fresh.len() } else { layer / format.channels() };
    let layer_bytes = texels.saturating_mul(texel).max(texel);
    fresh.chunks(layer_bytes).zip(disk.chunks(layer_bytes)).all(|(fresh, disk)| {
        let (fresh, disk) = (format.decode(fresh), format.decode(disk));
        let largest = fresh.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
        // This form of the comparison makes a NaN on either side a difference.
        fresh.iter().zip(&disk).all(|(x, y)| (x - y).abs() <= tolerance * largest)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const JSON: Equality = Equality::Json { tolerance: 1e-9 };

    #[test]
    fn json_compares_numbers_by_value_and_the_rest_exactly() {
        for (a, b, expected) in [
            (r#"{"a":1.0,"b":[1,2]}"#, r#"{ "b": [1, 2], "a": 1.0000000001 }"#, true),
            (r#"{"a":1.0}"#, r#"{"a":1.00001}"#, false),
            (r#"{"a":1}"#, r#"{"a":2}"#, false),
            (r#"{"a":10000000000}"#, r#"{"a":10000000001}"#, false),
            (r#"{"a":"x"}"#, r#"{"a":"y"}"#, false),
            (r#"{"a":1}"#, r#"{"a":1,"b":1}"#, false),
            ("[1.0, 1e-12]", "[1.0, 3e-12]", true),
            ("[1e-12]", "[3e-12]", false),
            ("[1.0]", "[1.0, 2.0]", false),
            ("[1.0]", "nonsense", false),
        ] {
            assert_eq!(same(JSON, a.as_bytes(), b.as_bytes()), expected, "{a} and {b}");
        }
    }

    #[test]
    fn tables_compare_each_layer_by_its_own_magnitude() {
        let bytes =
            |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let table = |layer| Equality::Table { format: TableFormat::F32, tolerance: 1e-3, layer };
        let fresh = bytes(&[100.0, 0.0, 0.001, 0.0]);
        assert!(same(table(0), &fresh, &bytes(&[100.05, 0.0, 0.05, 0.0])));
        assert!(
            !same(table(2), &fresh, &bytes(&[100.0, 0.0, 0.05, 0.0])),
            "the second layer is small"
        );
        assert!(!same(table(0), &fresh, &bytes(&[100.0, 0.0, f32::NAN, 0.0])));
        assert!(!same(table(0), &fresh, &bytes(&[100.0, 0.0])));
        assert!(!same(table(0), &bytes(&[f32::NAN, 0.0]), &bytes(&[1.0, 0.0])));
    }
}
