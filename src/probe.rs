//! `probe.json`: directions with their colours, so that who builds a shader into an engine can test the result.
//!
//! The directions and their exact colours belong to a surface and its optics, and are the same for all variants there.
//! `expected` is the variant's own algorithm in f64 on its packed tables; a shader that is built in correctly gives that
//! within `tolerance`, whatever the variant's distance from `exact`.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::{Error, Result, Stage};
use crate::field::Scratch;
use crate::height::HeightField;
use crate::manifest::SCHEMA_VERSION;
use crate::measure::{LIT, auto_exposure, pool};
use crate::plan::{Colour, Optics};
use crate::reference::{Directions, Reference};
use crate::resolve::Resolved;
use crate::spectrum::to_rgb;
use crate::template::GENERATED;
use crate::twin::Twin;

/// Probes of a variant.
pub const COUNT: usize = 64;

/// Relative tolerance of the numbers in a `probe.json` between processors.
///
/// Most agree to 1e-9, like all JSON, but not all: a dim direction on the flank of a lobe is the small end of
/// `exp(-|f - f_rs|²/2σf²)` or of a sum that cancels, where the last digits of a sine or a transform count up to a thousand
/// times as much. It is still a tenth, or less, of the tolerance that a shader is granted.
pub const TOLERANCE: f64 = 1e-6;

/// A direction pair and its exact colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact {
    /// To the light and to the viewer, of components that 32-bit floats hold exactly.
    pub directions: Directions,
    /// Relative tristimulus values, gain included.
    pub xyz: [f64; 3],
}

/// Chooses [`COUNT`] lit pairs on a surface, a third near mirror directions, a third on strong orders, the rest spread over
/// the hemisphere. Time: one exact field and about twice as many exact colours, on all cores.
pub fn exact(height: &HeightField, rotate_deg: f64, optics: &Optics) -> Result<Vec<Exact>> {
    let kinds = pool(height, optics, rotate_deg);
    let all: Vec<Directions> = kinds.iter().flatten().copied().collect();
    let visible = Reference::VISIBLE_NM;
    let reference = Reference::new(height, rotate_deg, optics, visible, all.iter().copied())?;
    let colour = |scratch: &mut Scratch, &directions: &Directions| {
        let xyz = reference.tristimulus(directions, scratch);
        Exact { directions, xyz }
    };
    let colours: Vec<Exact> = all.par_iter().map_init(Scratch::default, colour).collect();
    let mut rest = colours.as_slice();
    let kinds = kinds.each_ref().map(|kind| {
        let (these, others) = rest.split_at(kind.len());
        rest = others;
        these
    });
    choose(kinds).ok_or_else(|| {
        Error::new(Stage::Compute, "probe.json", "too few directions to choose from")
    })
}

/// A third of each kind, lit ones in the order of drawing first; what a kind lacks is made up from the brightest left.
fn choose(kinds: [&[Exact]; 3]) -> Option<Vec<Exact>> {
    let luminances: Vec<[f64; 3]> = kinds.iter().copied().flatten().map(|e| e.xyz).collect();
    let exposure = auto_exposure(&luminances).unwrap_or(1.0);
    let wanted = [COUNT.div_ceil(3), COUNT / 3, COUNT / 3];
    let (mut chosen, mut left) = (Vec::with_capacity(COUNT), Vec::new());
    for (kind, wanted) in kinds.into_iter().zip(wanted) {
        let mut taken = 0;
        for one in kind {
            if taken < wanted && exposure * one.xyz[1] > LIT {
                chosen.push(*one);
                taken += 1;
            } else {
                left.push(*one);
            }
        }
    }
    left.sort_by(|a, b| b.xyz[1].total_cmp(&a.xyz[1]));
    chosen.extend(left.into_iter().take(COUNT - chosen.len()));
    (chosen.len() == COUNT).then_some(chosen)
}

/// The numbers of probes, for storing: nine of each.
pub fn to_numbers(probes: &[Exact]) -> Vec<f64> {
    let numbers = |e: &Exact| [e.directions.wi.to_array(), e.directions.wr.to_array(), e.xyz];
    probes.iter().flat_map(numbers).flatten().collect()
}

/// The reverse of [`to_numbers`].
pub fn from_numbers(numbers: &[f64]) -> Vec<Exact> {
    let (probes, _) = numbers.as_chunks::<9>();
    let probe = |&[a, b, c, d, e, f, x, y, z]: &[f64; 9]| Exact {
        directions: Directions { wi: [a, b, c].into(), wr: [d, e, f].into() },
        xyz: [x, y, z],
    };
    probes.iter().map(probe).collect()
}

/// What a variant's algorithm gives in f64, relative tristimulus values, on all cores.
pub fn expected(twin: &Twin<'_>, probes: &[Exact]) -> Vec<[f64; 3]> {
    probes.par_iter().map(|probe| twin.tristimulus(probe.directions)).collect()
}

/// `probe.json`. Time: none worth counting.
pub fn json(
    surface: &str,
    variant: &str,
    colour: Colour,
    resolved: &Resolved,
    probes: &[Exact],
    expected: &[[f64; 3]],
) -> Result<String> {
    #[derive(Serialize)]
    struct Xyz {
        xyz: [f64; 3],
    }
    #[derive(Serialize)]
    struct Expected {
        xyz: [f64; 3],
        rgb: [f64; 3],
    }
    #[derive(Serialize)]
    struct Probe {
        wi: [f64; 3],
        wr: [f64; 3],
        exact: Xyz,
        expected: Expected,
        tolerance: f64,
    }
    let lines = probes.iter().zip(expected).zip(tolerances(resolved, expected));
    let lines = lines.map(|((probe, &xyz), tolerance)| {
        let Directions { wi, wr } = probe.directions;
        let probe = Probe {
            wi: wi.to_array(),
            wr: wr.to_array(),
            exact: Xyz { xyz: probe.xyz },
            expected: Expected { xyz, rgb: to_rgb(xyz, colour) },
            tolerance,
        };
        serde_json::to_string(&probe).map_err(|e| {
            Error::new(Stage::Compute, variant, "has a probe without a number").source(e)
        })
    });
    let lines: Vec<String> = lines.collect::<Result<_>>()?;
    let lines = lines.join(",\n    ");
    Ok(format!(
        "{{\n  \"generated_by\": {generated_by},\n  \"schema_version\": {SCHEMA_VERSION},\n  \"surface\": \"{surface}\",\n  \
         \"variant\": \"{variant}\",\n  \"probes\": [\n    {lines}\n  ]\n}}\n",
        generated_by = serde_json::Value::from(GENERATED),
    ))
}

/// Relative part of the tolerance, of the direction's own greatest value: the flanks of a lobe are steep, so that the
/// rounding of a direction counts there.
const OWN: f64 = 1e-3;
/// The same of a table of colours: filters of graphics cards round their weights to 8 bits.
const OWN_BAKED: f64 = 4e-3;
/// Least part of the greatest value of all probes: what a centred series needs.
const CENTRED: f64 = 2e-5;

/// How far each of X, Y and Z may lie from `expected` in a shader of 32-bit floats: the larger of 1e-3 of the direction's
/// own greatest value (4e-3 of `baked`) and, of the greatest value of all probes, 2e-5 or twice the sum of the terms' greatest values in
/// units of 2⁻²⁴, where that is larger. The latter counts for a series about the lowest height, whose large terms cancel.
pub fn tolerances(resolved: &Resolved, expected: &[[f64; 3]]) -> Vec<f64> {
    let greatest = |xyz: &[f64; 3]| xyz.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
    let terms: f64 = resolved.expansion.term_sizes().iter().sum();
    let share = (terms * 2.0_f64.powi(-23)).clamp(CENTRED, 1.0);
    let floor = share * expected.iter().map(greatest).fold(f64::MIN_POSITIVE, f64::max);
    let own = if resolved.axes.columns > 0 { OWN_BAKED } else { OWN };
    expected.iter().map(|xyz| floor.max(own * greatest(xyz))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_are_lit_and_survive_storing() {
        let heights_um = (0..40).map(|i| 0.005 * f64::from(i)).collect();
        let height = HeightField::new(40, 1, 0.05, 0.05, heights_um).expect("valid");
        let probes = exact(&height, 0.0, &Optics::standard()).expect("bright");
        assert_eq!(probes.len(), COUNT);
        let colours: Vec<[f64; 3]> = probes.iter().map(|p| p.xyz).collect();
        let exposure = auto_exposure(&colours).expect("lit");
        assert!(colours.iter().all(|c| exposure * c[1] > 0.5 * LIT), "{colours:?}");
        let mirrors = probes
            .iter()
            .filter(|p| (p.directions.wi + p.directions.wr).truncate().length() < 0.02);
        assert!((22..35).contains(&mirrors.count()));
        assert_eq!(from_numbers(&to_numbers(&probes)), probes);
    }
}
