//! Where the light of an order comes from, in f64; see `templates/arrivals.wgsl`.

use glam::{DVec2, DVec3};

use crate::variant::Orders;

use super::Twin;
use super::efficiencies::efficiency;
use super::matter::{dispersed, reflectance};

/// Direction in the frame of the surface.
pub fn in_surface(twin: &Twin<'_>, v: DVec3) -> DVec3 {
    if twin.rotate_deg == 0.0 {
        return v;
    }
    let (sin, cos) = twin.rotate_deg.to_radians().sin_cos();
    DVec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
}

/// Direction in the tangent frame, from one in the frame of the surface.
pub fn from_surface(twin: &Twin<'_>, v: DVec3) -> DVec3 {
    let (sin, cos) = twin.rotate_deg.to_radians().sin_cos();
    DVec3::new(cos * v.x - sin * v.y, cos * v.y + sin * v.x, v.z)
}

/// Reflectance at normal incidence.
pub fn normal_reflectance(form: &Orders) -> f64 {
    form.sum.coat.matter.normal_reflectance()
}

/// Frequency of an order, cycles per µm.
pub fn order_frequency(form: &Orders, order: DVec2) -> DVec2 {
    order / DVec2::from(form.sum.patch_um)
}

/// Length and direction of a frequency.
pub fn polar(frequency: DVec2) -> DVec3 {
    let size = frequency.length().max(1e-9);
    (frequency / size).extend(size)
}

/// Direction from which an order takes light of a wavelength; z is 0 where there is none.
pub fn arrival(frequency: DVec2, lambda_um: f64, wr: DVec3) -> DVec3 {
    let shift = lambda_um * frequency;
    let squared = wr.z * wr.z - shift.dot(2.0 * wr.truncate() + shift);
    (-wr.truncate() - shift).extend(squared.max(0.0).sqrt())
}

/// Shortest and longest wavelength at which an order takes light from above the horizon, µm.
pub fn propagating(form: &Orders, frequency: DVec2, wr: DVec3) -> [f64; 2] {
    let along = polar(frequency);
    let start = -wr.truncate().dot(along.truncate());
    let across = wr.y * along.x - wr.x * along.y;
    let half = (1.0 - across * across).max(0.0).sqrt();
    let [min_um, max_um] = form.wavelengths_um();
    [min_um.max((start - half) / along.z), max_um.min((start + half) / along.z)]
}

/// Share of the light that an order sends to the viewer, relative to the reflectance at normal incidence.
pub fn order_share(twin: &Twin<'_>, form: &Orders, order: DVec2, lambda_um: f64, wr: DVec3) -> f64 {
    let wi = arrival(order_frequency(form, order), lambda_um, wr);
    let coat = &form.sum.coat;
    let matter = &coat.matter;
    let turns = dispersed(twin, coat, matter.path(wi, wr, 0.0).z, lambda_um) / lambda_um;
    let reflected = reflectance(twin, coat, lambda_um, matter.facing_of(wi, wr));
    matter.geometry(wi, wr) / wi.z.max(1e-6) * reflected * efficiency(twin, form, order, turns)
}
