//! What the index of a package says beside its list of files, and the hash of everything that a package is made from.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use crate::error::Error;
use crate::hash::{TOOL_VERSION, of_value};
use crate::input::SurfaceInput;
use crate::package::Gap;
use crate::package::manifest::SCHEMA_VERSION;
use crate::plan::{Target, Variant};

use super::NAGA_VERSION;
use super::work::{Work, formed, placed};

/// Hash of everything that a package is made from but the program and the templates: surfaces with their files, variants
/// with their illuminants and media, languages, containers of tables.
pub(super) fn input_hash(work: &Work<'_>) -> String {
    let surface = |input: &SurfaceInput| {
        let variant = |v: &Variant| {
            let light = json!(v.optics.illuminant.identity());
            // the content of tables of n and k counts, and not only their names
            let files = v.optics.matter().map_or(light.clone(), |matter| json!([light, matter]));
            (v.name.clone(), v.hash(), files)
        };
        let variants: Vec<_> = placed(work, input).0.iter().map(variant).collect();
        (input.spec().name.clone(), input.identity().to_owned(), variants)
    };
    let surfaces: Vec<_> = work.surfaces.iter().map(surface).collect();
    of_value(&json!([TOOL_VERSION, surfaces, names(work), work.targets, work.containers]))
}

/// Names and hashes of all variants under `[optics]`.
fn names(work: &Work<'_>) -> BTreeMap<String, String> {
    work.variants.iter().map(|v| (v.name.clone(), v.hash())).collect()
}

/// The keys of the package's `manifest.json` beside its list of files; the same in any order of the work. `known`: the gaps
/// that were found, those of an earlier run included. What the plan says of a gap now replaces what is known of it.
pub(super) fn index(work: &Work<'_>, known: Vec<Gap>) -> Result<BTreeMap<String, Value>, Error> {
    let (mut surfaces, mut gaps) = (BTreeMap::new(), Vec::new());
    for input in work.surfaces {
        surfaces.insert(input.spec().name.clone(), json!({ "input_hash": input.identity() }));
        let (variants, never) = placed(work, input);
        gaps.extend(never);
        gaps.extend(formed(input, &input.surface()?.field, variants).1);
    }
    let place = |gap: &Gap| (gap.surface.clone(), gap.variant.clone());
    let found: BTreeSet<_> = gaps.iter().map(place).collect();
    let is_asked_for = |gap: &Gap| {
        let is_variant = work.variants.iter().any(|variant| variant.name == gap.variant);
        is_variant && work.surfaces.iter().any(|input| input.spec().name == gap.surface)
    };
    let is_new = |gap: &Gap| !found.contains(&place(gap)) && is_asked_for(gap);
    gaps.extend(known.into_iter().filter(is_new));
    gaps.sort();
    let mut variants = BTreeMap::new();
    for variant in work.variants {
        let mut about = BTreeMap::from([("configuration_hash", json!(variant.hash()))]);
        let here: Vec<_> = work.surfaces.iter().map(|i| (i.spec(), variant.on(i.spec()))).collect();
        // where it is not the same everywhere
        if here.iter().any(|(_, on)| !matches!(on, Some(Ok(on)) if on.hash() == variant.hash())) {
            let hashes = here.iter().filter_map(|(spec, on)| match on {
                Some(Ok(on)) => Some((spec.name.clone(), on.hash())),
                _ => None,
            });
            about.insert("surfaces", json!(hashes.collect::<BTreeMap<_, _>>()));
        }
        variants.insert(variant.name.as_str(), json!(about));
    }
    let targets: BTreeSet<Target> = work.targets.iter().copied().collect();
    Ok(BTreeMap::from([
        ("schema_version".to_owned(), json!(SCHEMA_VERSION)),
        ("tool_version".to_owned(), json!(TOOL_VERSION)),
        ("naga_version".to_owned(), json!(NAGA_VERSION)),
        ("surfaces".to_owned(), json!(surfaces)),
        ("variants".to_owned(), json!(variants)),
        ("targets".to_owned(), json!(targets)),
        ("gaps".to_owned(), json!(gaps)),
    ]))
}
