//! Uniform blocks by the offsets of a manifest.

use serde_json::Value;

/// A uniform block of a manifest.
pub(super) struct Block {
    /// Its size in floats.
    pub size: usize,
    /// Names and offsets of its members, in floats.
    members: Vec<(String, usize)>,
}

impl Block {
    /// The block of this name.
    pub(super) fn of(manifest: &Value, name: &str) -> Option<Block> {
        let mut blocks = manifest["uniforms"].as_array()?.iter();
        let block = blocks.find(|block| block["name"] == name)?;
        let floats = |value: &Value| value.as_u64().map(|bytes| bytes as usize / 4);
        let members = block["members"].as_array()?.iter();
        let member = |m: &Value| Some((m["name"].as_str()?.to_owned(), floats(&m["offset"])?));
        Some(Block { size: floats(&block["size"])?, members: members.filter_map(member).collect() })
    }

    /// The block's floats: these members, zeros elsewhere.
    pub(super) fn floats(&self, values: &[(&str, &[f64])]) -> Vec<f64> {
        let mut all = vec![0.0; self.size];
        for (name, numbers) in values {
            let offset = self.members.iter().find(|(member, _)| member == name);
            let place = offset.and_then(|(_, at)| all.get_mut(*at..*at + numbers.len()));
            if let Some(place) = place {
                place.copy_from_slice(numbers);
            }
        }
        all
    }
}
