//! What the functions of lights with a size share: their probes and their cost.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::error::{Error, Result};
use crate::field::orders::OrderSum;
use crate::optics::{Matter, direction};
use crate::plan::Optics;
use crate::surface::HeightField;
use crate::variant::cost::mean_and_worst_views;
use crate::variant::twin::lamps::{Caps, panel_count};
use crate::variant::{Cost, Form, Pattern};

use super::{Arguments, Around, ExactProbe};

/// Number of probes of a function of a light with a size.
pub(super) const PROBES: usize = 16;

/// Number of candidates that probes are chosen from.
pub(super) const CANDIDATES: usize = 40 * PROBES;

/// A probe is lit if its Y is at least this part of what a mirror of the material shows.
const LIT: f64 = 1e-3;

/// Where the light of a candidate is, and its viewer.
pub(super) struct Place<'a> {
    /// To the middle of the light.
    pub(super) axis: DVec3,
    /// A viewer to whom an order brings light from a direction at most that far from the middle, in direction cosines.
    pub(super) near: &'a dyn Fn(f64) -> DVec3,
}

/// The first lit candidates, with their exact colours. The middle of the light is anywhere above the horizon; viewers look where orders, the mirror's among them, send visible light from it.
pub(super) fn probes(
    height: &HeightField,
    rotate_deg: f64,
    optics: &Optics,
    candidate: &dyn Fn(usize, Place<'_>) -> Arguments,
) -> Result<Vec<ExactProbe>> {
    let matter = Matter::new(optics)?;
    let orders = OrderSum::new(height, rotate_deg, optics)?;
    let mut found = Vec::with_capacity(PROBES);
    for i in 0..CANDIDATES {
        let axis = direction(88.0 * part(i, 1), 360.0 * part(i, 2));
        let near = |away: f64| viewer(height, rotate_deg, i, axis, away);
        let arguments = candidate(i, Place { axis, near: &near }).rounded();
        // at grazing angles a rounded direction is another one
        if arguments.wr().z <= 0.1 {
            continue;
        }
        let Some(lamp) = arguments.lamp() else { continue };
        let Some(emitter) = lamp.emitter() else { continue };
        let xyz = orders.radiance(&*emitter, arguments.wr());
        if xyz[1] > LIT * mirrored(&arguments, &matter) {
            found.push(ExactProbe { arguments, pattern: Pattern::NONE, xyz });
            if found.len() == PROBES {
                return Ok(found);
            }
        }
    }
    let cause = format!("only {} of {PROBES} probes are lit", found.len());
    Err(Error::new("probe.json", cause))
}

/// The coordinate of that power of a candidate, 0 to 1: a sequence that fills the cube evenly (Roberts 2018).
pub(super) fn part(candidate: usize, power: i32) -> f64 {
    (0.5 + (candidate + 1) as f64 / 1.220_744_084_605_759_5_f64.powi(power)).fract()
}

/// A viewer to whom an order brings visible light from a direction at most `away` from `axis`, in direction cosines.
pub(super) fn viewer(
    height: &HeightField,
    rotate_deg: f64,
    candidate: usize,
    axis: DVec3,
    away: f64,
) -> DVec3 {
    let part = |power| part(candidate, power);
    let reach = |size_um: f64| (0.55 * size_um).floor().clamp(1.0, 6.0);
    let sizes = DVec2::new(height.size_x_um(), height.size_y_um());
    let whole = |part: f64, size_um: f64| {
        let reach = if size_um < 0.35 { 0.0 } else { 2.0 * reach(size_um) };
        (part * (2.0 * reach + 1.0)).floor() - reach
    };
    let order = DVec2::new(whole(part(3), sizes.x), whole(part(4), sizes.y));
    let lambda_um = 0.43 + 0.22 * part(5);
    let frequency = DVec2::from_angle(rotate_deg.to_radians()).rotate(order / sizes);
    let jitter = away * part(6).sqrt() * DVec2::from_angle(TAU * part(7));
    let plane = -axis.truncate() - lambda_um * frequency + jitter;
    plane.extend((1.0 - plane.length_squared()).max(0.0).sqrt())
}

/// Radiance of the light of a call, seen in a mirror of the material at normal incidence; of a coloured light, that of its strongest
/// primary.
pub(super) fn mirrored(arguments: &Arguments, matter: &Matter) -> f64 {
    let strongest = |colour: Option<DVec3>| colour.map_or(1.0, |colour| colour.max_element());
    let radiance = match *arguments {
        Arguments::Disc { radius_rad, colour, .. } => {
            strongest(colour) / (std::f64::consts::PI * radius_rad.sin().powi(2))
        }
        Arguments::Rectangle { colour, .. } => strongest(colour),
        Arguments::Environment { around: Around::Sky(sky), .. } | Arguments::Path { sky, .. } => {
            sky.brightest()
        }
        _ => 1.0,
    };
    matter.normal_reflectance() * radiance
}

/// Cost under a light of usual size as mean over viewers, and the maximum under the widest light. `lights`: of how many lights each
/// end of a range needs moments.
pub(super) fn cost(
    form: &Form,
    lights: u64,
    usual: &dyn Fn(DVec3) -> Arguments,
    widest: &dyn Fn(DVec3) -> Arguments,
) -> Cost {
    let Form::Orders(orders) = form else { return Cost::default() };
    let panels = |arguments: Arguments| {
        let mut count = 0;
        let caps = match arguments {
            Arguments::Direction(_)
            | Arguments::Spread { .. }
            | Arguments::Environment { .. }
            | Arguments::Path { .. } => {
                return 0;
            }
            Arguments::Disc { axis, radius_rad, .. } => Caps::disc(axis, radius_rad),
            Arguments::Rectangle { corners, .. } => Caps::rectangle(corners),
        };
        let wr = arguments.wr();
        caps.visit(orders, wr, &mut |order, range_um| {
            count += u64::from(panel_count(orders, order, range_um, wr));
        });
        count
    };
    let (mean, _) = mean_and_worst_views(|wr| panels(usual(wr)));
    let (_, worst) = mean_and_worst_views(|wr| panels(widest(wr)));
    /// Four shares, and at both ends four rows of moments for each light.
    const SHARES: u64 = 4;
    const MOMENTS: u64 = 2 * 4;
    let bytes = form.cost().table_bytes;
    Cost::of_evaluations(
        (SHARES as f64 * mean, SHARES * worst),
        1,
        lights * MOMENTS / SHARES,
        bytes,
    )
}
