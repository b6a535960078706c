//! Sources of responses: the exact field, a runner, a closed form.

use std::f64::consts::TAU;

use diffraction_shaders::error::Result;
use diffraction_shaders::field::Scratch;
use diffraction_shaders::field::reference::{Reference, evaluate_all};
use diffraction_shaders::optics::{Matter, path_difference, window_sigma_um};
use diffraction_shaders::plan::Grating;
use diffraction_shaders::runner::{Placement, Runner};
use diffraction_shaders::variant::Form;

use super::{ClosedForm, Lobe, Measurement, Protocol, measure};

/// The exact field, prepared once for all wavelengths of a protocol. Only the optics of the variant are used.
pub fn exact(
    placement: Placement<'_>,
    protocol: Protocol,
) -> Result<impl FnMut(f64, &[f64]) -> Result<Vec<f64>>> {
    let Placement { height, rotate_deg, variant } = placement;
    let nodes = protocol.wavelengths.nodes_nm();
    let ends = |f: fn(f64, f64) -> f64| nodes.iter().copied().fold(nodes[0], f);
    let range = (ends(f64::min), ends(f64::max));
    // w is extreme at the horizon and at the normal, u at the horizons
    let extremes = [-90.0, 0.0, 90.0].map(|theta| protocol.directions(theta));
    let reference = Reference::new(height, rotate_deg, &variant.optics, range, extremes)?;
    Ok(move |lambda_nm: f64, angles: &[f64]| {
        let directions: Vec<_> = angles.iter().map(|&a| protocol.directions(a)).collect();
        let one = |d, scratch: &mut Scratch| [reference.response(d, lambda_nm, scratch), 0.0, 0.0];
        Ok(evaluate_all(&directions, &|_| (), one).into_iter().map(|r| r[0]).collect())
    })
}

/// Any runner. If its variant has no wavelength axis, it returns an error.
pub fn runner<'a>(
    runner: &'a dyn Runner,
    protocol: Protocol,
) -> impl FnMut(f64, &[f64]) -> Result<Vec<f64>> + 'a {
    move |lambda_nm, angles| {
        let directions: Vec<_> = angles.iter().map(|&a| protocol.directions(a)).collect();
        runner.response(&directions, lambda_nm)
    }
}

/// The closed form of a grating with its period along the surface's x axis, which is rotated, and under the cover of its matter.
pub fn profile<'a>(
    profile: &'a ClosedForm,
    protocol: Protocol,
    (rotate_deg, matter): (f64, &'a Matter),
    lobe: impl Fn(f64) -> Lobe + 'a,
) -> impl FnMut(f64, &[f64]) -> Result<Vec<f64>> + 'a {
    move |lambda_nm, angles| {
        let lambda_um = lambda_nm * 1e-3;
        let one = |&angle: &f64| {
            let directions = protocol.directions(angle);
            let path = path_difference(directions.wi, directions.wr, rotate_deg) / lambda_um;
            let z = TAU / lambda_um * matter.depth(directions.wi, directions.wr, lambda_nm);
            profile.response([path.x, path.y], z, lobe(lambda_nm))
        };
        Ok(angles.iter().map(one).collect())
    }
}

/// Measures the closed form of a grating, with the lobe of the variant. `None` for a surface without a closed form.
///
/// Two differences remain. The closed form is of a smooth profile, while samples at the left edges of pixels shift the cell by
/// half a pixel. A coherence window does not show this shift; the sharp ends of replicas do if the profile has no jump at its
/// seam (a sinusoid of 100 pixels: 0.02 nm, less with more pixels). And `pq` interpolates from few bins by default: enough for
/// the strength of an order, but not for the slope from its neighbours, which shifts a peak of a deep grating by nanometres.
pub fn yardstick(
    grating: &Grating,
    placement: Placement<'_>,
    protocol: &Protocol,
) -> Result<Option<Measurement>> {
    let Some(closed) = ClosedForm::new(grating) else { return Ok(None) };
    let optics = &placement.variant.optics;
    let replicas = Form::new(placement.variant, placement.height)?.replicas();
    let lobe = |lambda_nm: f64| match replicas {
        Some([(periods, _), (rows, side_um)]) => {
            Lobe::Replicas { periods, length_um: rows * side_um }
        }
        None => Lobe::Window { sigma_um: window_sigma_um(optics, lambda_nm) },
    };
    let protocol = Protocol { whole: false, ..*protocol };
    let extent_um = extent_um(placement, protocol.wavelengths.max_nm)?;
    let matter = Matter::new(optics)?;
    let respond = profile(&closed, protocol, (placement.rotate_deg, &matter), lobe);
    measure(&protocol, extent_um, respond).map(Some)
}

/// The maximum distance, in µm, over which points of the surface interfere at wavelengths up to `longest_nm`: the coherence
/// length, or for replicas the whole surface.
pub fn extent_um(placement: Placement<'_>, longest_nm: f64) -> Result<f64> {
    let coherence_um = 4.0 * window_sigma_um(&placement.variant.optics, longest_nm);
    let replicas = Form::new(placement.variant, placement.height)?.replicas();
    Ok(replicas.map_or(coherence_um, |replicas| {
        let sides = replicas.map(|(count, side_um)| count * side_um);
        coherence_um.max(sides[0]).max(sides[1])
    }))
}
