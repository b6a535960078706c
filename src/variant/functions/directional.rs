//! `diffraction(wi, wr)`: light from one direction.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::field::Scratch;
use crate::field::comparison_directions::pool;
use crate::field::reference::{Directions, Reference};
use crate::optics::colour_difference::{LIT, auto_exposure};
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::variant::{Cost, Form, Pattern};

use super::{Arguments, ExactProbe, Function, FunctionKind};

/// The function that every form has.
pub static DIRECTIONAL: Directional = Directional;

/// Light from one direction: `diffraction(wi, wr)`.
pub struct Directional;

/// Number of probes of the function.
const PROBES: usize = 64;

impl Function for Directional {
    fn name(&self) -> &'static str {
        "diffraction"
    }

    fn tristimulus_name(&self) -> &'static str {
        "tristimulus"
    }

    fn signature(&self) -> &'static str {
        "(wi: vec3f, wr: vec3f) -> vec3f"
    }

    fn arguments(&self) -> &'static str {
        "unit vectors pointing away from the surface; wi to the light, wr to the viewer"
    }

    fn kind(&self) -> FunctionKind {
        FunctionKind::Direction
    }

    fn unit(&self, form: &Form) -> &'static str {
        form.unit()
    }

    fn cost(&self, form: &Form) -> Cost {
        form.cost()
    }

    fn probe_count(&self) -> usize {
        PROBES
    }

    fn probes(
        &self,
        height: &HeightField,
        rotate_deg: f64,
        optics: &Optics,
    ) -> Result<Vec<ExactProbe>> {
        exact(height, rotate_deg, optics)
    }
}

/// Chooses [`PROBES`] lit pairs of directions on a surface: a third near mirror directions, a third on strong orders,
/// the others spread over the hemisphere. Time: one exact field and about twice as many exact colours, on all cores.
fn exact(height: &HeightField, rotate_deg: f64, optics: &Optics) -> Result<Vec<ExactProbe>> {
    let kinds = pool(height, optics, rotate_deg);
    let all: Vec<Directions> = kinds.iter().flatten().copied().collect();
    let visible = Reference::VISIBLE_NM;
    let reference = Reference::new(height, rotate_deg, optics, visible, all.iter().copied())?;
    let colour = |scratch: &mut Scratch, &directions: &Directions| {
        let xyz = reference.tristimulus(directions, scratch);
        let arguments = Arguments::Direction(directions);
        ExactProbe { arguments, pattern: Pattern::NONE, xyz }
    };
    let colours: Vec<ExactProbe> = all.par_iter().map_init(Scratch::default, colour).collect();
    let mut rest = colours.as_slice();
    let kinds = kinds.each_ref().map(|kind| {
        let (these, others) = rest.split_at(kind.len());
        rest = others;
        these
    });
    choose(kinds).ok_or_else(|| {
        Error::new("probe.json", format!("fewer than {PROBES} directions to choose from"))
    })
}

/// A third of each kind: the first lit ones. If a kind has too few, the brightest of the remaining directions are added.
fn choose(kinds: [&[ExactProbe]; 3]) -> Option<Vec<ExactProbe>> {
    let luminances: Vec<[f64; 3]> = kinds.iter().copied().flatten().map(|e| e.xyz).collect();
    let exposure = auto_exposure(&luminances).unwrap_or(1.0);
    let wanted = [PROBES.div_ceil(3), PROBES / 3, PROBES / 3];
    let (mut chosen, mut left) = (Vec::with_capacity(PROBES), Vec::new());
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
    chosen.extend(left.into_iter().take(PROBES - chosen.len()));
    (chosen.len() == PROBES).then_some(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_are_lit() {
        let heights_um = (0..40).map(|i| 0.005 * f64::from(i)).collect();
        let height = HeightField::new(40, 1, 0.05, 0.05, heights_um).expect("valid");
        let probes = exact(&height, 0.0, &Optics::standard()).expect("bright");
        assert_eq!(probes.len(), PROBES);
        let colours: Vec<[f64; 3]> = probes.iter().map(|p| p.xyz).collect();
        let exposure = auto_exposure(&colours).expect("lit");
        assert!(colours.iter().all(|c| exposure * c[1] > 0.5 * LIT), "{colours:?}");
        let mirrors = probes
            .iter()
            .filter_map(|probe| match probe.arguments {
                Arguments::Direction(Directions { wi, wr }) => Some(wi + wr),
                _ => None,
            })
            .filter(|sum| sum.truncate().length() < 0.02);
        assert!((22..35).contains(&mirrors.count()));
    }
}
