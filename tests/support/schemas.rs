//! Walks a JSON schema and a value together: which places of the schema a value reaches, and what stands there.

use std::collections::BTreeMap;

use serde_json::Value;

/// A place of a schema as a JSON pointer.
pub type Place = String;

/// Every subschema that describes values, by its place. Conditions (`if`, `then`) only narrow what others describe.
pub fn places(root: &Value) -> BTreeMap<Place, &Value> {
    let mut found = BTreeMap::new();
    collect(root, root, String::new(), &mut found);
    found
}

fn collect<'a>(
    root: &'a Value,
    schema: &'a Value,
    at: Place,
    found: &mut BTreeMap<Place, &'a Value>,
) {
    let (schema, at) = resolved(root, schema, at);
    if found.insert(at.clone(), schema).is_some() {
        return;
    }
    for (below, inner) in parts(schema) {
        collect(root, inner, format!("{at}{below}"), found);
    }
}

/// The subschemas of a schema with their places below it.
fn parts(schema: &Value) -> Vec<(String, &Value)> {
    let mut parts = Vec::new();
    for (name, inner) in schema["properties"].as_object().into_iter().flatten() {
        parts.push((format!("/properties/{name}"), inner));
    }
    for key in ["additionalProperties", "propertyNames", "items"] {
        if schema[key].is_object() {
            parts.push((format!("/{key}"), &schema[key]));
        }
    }
    for key in ["oneOf", "anyOf"] {
        for (i, inner) in schema[key].as_array().into_iter().flatten().enumerate() {
            parts.push((format!("/{key}/{i}"), inner));
        }
    }
    parts
}

/// The schema that a reference names, and its place.
fn resolved<'a>(root: &'a Value, schema: &'a Value, at: Place) -> (&'a Value, Place) {
    match schema["$ref"].as_str().and_then(|reference| reference.strip_prefix('#')) {
        Some(pointer) => (root.pointer(pointer).unwrap_or(&Value::Null), pointer.to_owned()),
        None => (schema, at),
    }
}

/// What a walk finds: a place of the schema, its subschema, and the value there with its own pointer.
pub struct Visit<'a> {
    pub place: Place,
    pub schema: &'a Value,
    pub value: &'a Value,
    pub pointer: String,
}

/// Every place that a valid value reaches, in the order of the value.
pub fn walk<'a>(root: &'a Value, value: &'a Value, see: &mut dyn FnMut(Visit<'a>)) {
    visit(root, root, String::new(), value, String::new(), see);
}

fn visit<'a>(
    root: &'a Value,
    schema: &'a Value,
    place: Place,
    value: &'a Value,
    pointer: String,
    see: &mut dyn FnMut(Visit<'a>),
) {
    let (schema, place) = resolved(root, schema, place);
    see(Visit { place: place.clone(), schema, value, pointer: pointer.clone() });
    for key in ["oneOf", "anyOf"] {
        let branches = schema[key].as_array().into_iter().flatten().enumerate();
        for (i, branch) in branches.filter(|(_, branch)| may_be(branch, value)) {
            visit(root, branch, format!("{place}/{key}/{i}"), value, pointer.clone(), see);
        }
    }
    for (name, inner) in value.as_object().into_iter().flatten() {
        let below = format!("{pointer}/{}", name.replace('~', "~0").replace('/', "~1"));
        if let Some(of) = schema["properties"].get(name) {
            visit(root, of, format!("{place}/properties/{name}"), inner, below, see);
        } else if schema["additionalProperties"].is_object() {
            let of = &schema["additionalProperties"];
            visit(root, of, format!("{place}/additionalProperties"), inner, below, see);
        }
    }
    for (i, inner) in value.as_array().into_iter().flatten().enumerate() {
        if schema["items"].is_object() {
            let of = &schema["items"];
            visit(root, of, format!("{place}/items"), inner, format!("{pointer}/{i}"), see);
        }
    }
}

/// Whether a branch of alternatives is the one of a valid value: by its type, its words and its constants.
fn may_be(branch: &Value, value: &Value) -> bool {
    let constant = |(name, of): (&String, &Value)| match of.get("const") {
        Some(constant) => value.get(name) == Some(constant),
        None => true,
    };
    let words = branch["enum"].as_array();
    is_of_type(&branch["type"], value)
        && words.is_none_or(|words| words.contains(value))
        && branch["properties"].as_object().into_iter().flatten().all(constant)
}

/// Whether a value has the type, or one of the types, that a schema states; any has where it states none.
pub fn is_of_type(stated: &Value, value: &Value) -> bool {
    match stated {
        Value::String(name) => match name.as_str() {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "number" => value.is_number(),
            "integer" => value.is_i64() || value.is_u64(),
            "null" => value.is_null(),
            _ => false,
        },
        Value::Array(names) => names.iter().any(|name| is_of_type(name, value)),
        _ => true,
    }
}
