//! A surface with a variant on a body, and the camera.

use diffraction_shaders::plan::{SurfaceSpec, Variant};
use diffraction_shaders::runner::Placement;
use diffraction_shaders::surface::Surface;
use glam::DVec3;

use super::args::{Args, Sweep};
use crate::scene::{Mesh, Orbit};

/// A surface with a variant of the plan.
pub(super) struct Skin {
    pub(super) spec: SurfaceSpec,
    pub(super) surface: Surface,
    /// The variant as built on the surface.
    pub(super) variant: Variant,
    /// Whether it has a function for discs.
    pub(super) has_disc: bool,
}

impl Skin {
    pub(super) fn placement(&self) -> Placement<'_> {
        let (height, variant) = (&self.surface.field, &self.variant);
        Placement { height, rotate_deg: self.spec.rotate_deg, variant }
    }
}

/// The camera of a picture.
pub(super) fn orbit(args: &Args, mesh: &Mesh) -> Orbit {
    let [width, height] = args.size.0;
    let shape = f64::from(width) / f64::from(height);
    let around = match args.sweep {
        Some(Sweep::Turntable) => Orbit::all_round(mesh, shape),
        _ => Orbit::around(mesh, shape),
    };
    Orbit {
        target: args.target.map_or(around.target, |t| DVec3::from(t.0)),
        distance: args.distance.unwrap_or(around.distance),
        azimuth_deg: args.azimuth,
        elevation_deg: args.elevation,
        zoom: args.zoom,
        ..around
    }
}
