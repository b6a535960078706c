//! Synthetic surfaces: gratings with closed forms, and periodic random surfaces modelled on insects and snakes.
//!
//! One-dimensional gratings are sampled at the left edge of each pixel, `x = col/N · d` from the left edge of the
//! patch, and have [`EXTRUDED`] equal rows. (The phase origin at the centre only changes the phase of the orders.)
//! Their transform approaches the closed forms: the relative error of `|c_m|` is at most `m/N` for gratings with jumps
//! and `(πm/N)²/6` for others.
//!
//! | kind | height at `t = x/d` in `[0, 1)` |
//! | --- | --- |
//! | flat | `0` |
//! | sinusoidal | `(H/2)(1 + cos 2πt)` |
//! | blazed | `H t` (the jump lies on the seam; the highest pixel is `H (N-1)/N`) |
//! | lamellar | `H` for `t < duty`, else 0; `duty·N` is rounded to whole pixels, with a note |
//! | triangle | `H t/apex` up to the apex, then `H (1-t)/(1-apex)` |
//! | crossed | sum of one along x and one along y; a pitch for each axis |
//!
//! The random kinds are described at [`skin`]. All kinds use sines and exponentials of `libm`, so the heights are the
//! same numbers on every platform.

pub mod skin;
mod waves;

use crate::error::{Error, Result};
use crate::plan::Grating;
use crate::surface::{
    EXTRUDED, HeightField, MAX_HEIGHT_UM, MAX_SIDE, Surface, check_pixel, check_pixels, check_um,
};

/// Computes a surface; `subject` names it in errors.
///
/// The lowest height is 0. Errors name the key. Causes are lengths that are not positive, finite and plausible, shares
/// outside (0, 1), too few or too many pixels, and random surfaces too small for their features.
pub fn synthesise(grating: &Grating, subject: &str) -> Result<Surface> {
    let mut notes = Vec::new();
    let field = match grating {
        Grating::Bumps(rough) => skin::bumps(rough, subject, &mut notes)?,
        Grating::Fingers(rough) => skin::fingers(rough, subject, &mut notes)?,
        Grating::Rows(rough) => skin::rows(rough, subject, &mut notes)?,
        Grating::Crossed { x, y } => {
            let x = profile(x, &format!("{subject}: grating along x"), &mut notes)?;
            let y = profile(y, &format!("{subject}: grating along y"), &mut notes)?;
            let (columns, rows) =
                check_pixels(subject, x.heights_um.len() as u64, y.heights_um.len() as u64)?;
            // y grows upwards, but rows are counted downwards
            let heights = y
                .heights_um
                .iter()
                .rev()
                .flat_map(|hy| x.heights_um.iter().map(move |hx| hx + hy))
                .collect();
            HeightField::new(columns, rows, x.pitch_um, y.pitch_um, heights)?
        }
        _ => {
            let Section { pitch_um, heights_um } = profile(grating, subject, &mut notes)?;
            let columns = heights_um.len();
            HeightField::new(columns, EXTRUDED, pitch_um, pitch_um, heights_um.repeat(EXTRUDED))?
        }
    };
    Ok(Surface { field, notes })
}

/// One period of a one-dimensional grating.
struct Section {
    pitch_um: f64,
    heights_um: Vec<f64>,
}

fn profile(grating: &Grating, subject: &str, notes: &mut Vec<String>) -> Result<Section> {
    let sample = |period_um: f64, height_um: f64, pixels: usize, shape: &dyn Fn(f64) -> f64| {
        check_um(subject, "height_um", height_um, MAX_HEIGHT_UM)?;
        sampled(subject, period_um, pixels, |t| height_um * shape(t))
    };
    match *grating {
        Grating::Flat { period_um, pixels } => sampled(subject, period_um, pixels, |_| 0.0),
        Grating::Sinusoidal { period_um, height_um, pixels } => {
            sample(period_um, height_um, pixels, &|t| {
                0.5 + 0.5 * libm::cos(std::f64::consts::TAU * t)
            })
        }
        Grating::Blazed { period_um, height_um, pixels } => {
            sample(period_um, height_um, pixels, &|t| t)
        }
        Grating::Lamellar { period_um, height_um, pixels, duty } => {
            check_share(subject, "duty", duty)?;
            let wanted = duty * pixels as f64;
            // at least one pixel of each level
            let high = wanted.round().clamp(1.0, pixels.saturating_sub(1).max(1) as f64);
            if (wanted - high).abs() > 1e-9 * wanted {
                notes.push(format!(
                    "`duty = {duty}` is {high} of {pixels} pixels, {}",
                    high / pixels as f64
                ));
            }
            // half a pixel off the edge, so that rounding of t has no effect
            let edge = (high - 0.5) / pixels as f64;
            sample(period_um, height_um, pixels, &|t| f64::from(u8::from(t <= edge)))
        }
        Grating::Triangle { period_um, height_um, pixels, apex } => {
            check_share(subject, "apex", apex)?;
            sample(period_um, height_um, pixels, &|t| {
                if t <= apex { t / apex } else { (1.0 - t) / (1.0 - apex) }
            })
        }
        Grating::Crossed { .. } => {
            Err(Error::new(subject, "a crossed grating cannot be part of another")
                .remedy("use two one-dimensional gratings"))
        }
        Grating::Bumps(_) | Grating::Fingers(_) | Grating::Rows(_) => {
            Err(Error::new(subject, "a random surface cannot be part of a crossed grating")
                .remedy("use flat, sinusoidal, blazed, lamellar or triangle"))
        }
    }
}

/// `N` samples of a height in µm, as a function of the share `t` of the period.
fn sampled(
    subject: &str,
    period_um: f64,
    pixels: usize,
    height_um: impl Fn(f64) -> f64,
) -> Result<Section> {
    let pitch_um = grid(subject, "period_um", period_um, pixels)?;
    Ok(Section {
        pitch_um,
        heights_um: (0..pixels).map(|col| height_um(col as f64 / pixels as f64)).collect(),
    })
}

/// Pixel pitch of `pixels` over a length in µm, both checked.
fn grid(subject: &str, key: &str, length_um: f64, pixels: usize) -> Result<f64> {
    check_um(subject, key, length_um, f64::MAX)?;
    if !(2..=MAX_SIDE).contains(&pixels) {
        return Err(Error::new(subject, format!("`pixels = {pixels}` is outside 2 to {MAX_SIDE}"))
            .remedy("choose a pitch of about 50 nm for visible light"));
    }
    let pitch_um = length_um / pixels as f64;
    check_pixel(subject, &format!("`{key} = {length_um}` over {pixels} pixels"), pitch_um)?;
    Ok(pitch_um)
}

fn check_share(subject: &str, key: &str, share: f64) -> Result<()> {
    if share > 0.0 && share < 1.0 {
        return Ok(());
    }
    Err(Error::new(subject, format!("`{key} = {share}` is not between 0 and 1"))
        .remedy("give it as a share of the period"))
}
