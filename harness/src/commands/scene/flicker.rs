//! `cargo xtask scene --sweep flicker`: how much pictures change while the camera moves by less than a pixel.

use std::time::Instant;

use anyhow::Result;
use diffraction_cli::progress;

use super::args::Args;
use super::lights::Lamps;
use super::skin::{Skin, orbit};
use crate::drivers::gpu::Gpu;
use crate::drivers::{ColourMap, Prepared, check};
use crate::scene::Mesh;
use crate::scene::drawing::{Drawing, Hdr, Lobes};
use crate::scene::flicker::{BRIGHT, CHANGE, STEPS, flicker, light, moved, within_pixel};
use crate::scene::lights::middle;

/// Points of a pixel along each side of which the light is the mean.
const POINTS: u32 = 8;
/// What is compared, with its name.
const SUBJECTS: [(Lobes, &str); 3] =
    [(Lobes::Points, "none"), (Lobes::Footprint, "footprint"), (Lobes::Ggx, "ggx")];

/// Prints a line for each subject. Returns their first frames.
pub(super) fn measured(
    args: &Args,
    gpu: &Gpu,
    lamps: &Lamps,
    skin: &Skin,
    mesh: &Mesh,
) -> Result<Vec<Hdr>> {
    let (prepared, size) = (Prepared::new(skin.placement())?, args.size.0);
    if !args.unchecked {
        check(&prepared, gpu)?;
    }
    // the body's own colour would hide changes and losses
    let mut mesh = mesh.clone();
    mesh.colour = ColourMap::plain([0; 3]);
    let lights = lamps.on(skin.has_disc, None);
    let toward = middle(&lights[0]);
    let look = lamps.look(lights, args);
    let drawings: Vec<Drawing<'_>> = SUBJECTS
        .iter()
        .map(|(lobes, _)| Drawing::new(gpu, &prepared, mesh.clone(), *lobes, None))
        .collect::<Result<_, _>>()?;
    let orbit = orbit(args, &mesh);
    let middle = orbit.params(&mesh, size, toward)?;
    let bar = progress::bar(
        (POINTS * POINTS) as usize + 1,
        &format!("drawing {} points of a pixel", POINTS * POINTS),
    );
    let mut whole = 0.0;
    for i in 0..POINTS * POINTS {
        let place =
            [i % POINTS, i / POINTS].map(|i| (f64::from(i) + 0.5) / f64::from(POINTS) - 0.5);
        let picture = drawings[0].draw(&within_pixel(&middle, size, place), &look, size)?;
        whole += light(&picture) / f64::from(POINTS * POINTS);
        bar.inc(1);
    }
    let mut frames = vec![Vec::new(); SUBJECTS.len()];
    let mut seconds = [f64::INFINITY; SUBJECTS.len()];
    // in turns, so that a busy machine slows all of them
    for pixels in STEPS.into_iter().chain((0..args.time).map(|_| 0.0)) {
        let params = moved(orbit, &mesh, size, pixels)?.params(&mesh, size, toward)?;
        for (i, drawing) in drawings.iter().enumerate() {
            let begun = Instant::now();
            let picture = drawing.draw(&params, &look, size)?;
            seconds[i] = seconds[i].min(begun.elapsed().as_secs_f64());
            if frames[i].len() < STEPS.len() {
                frames[i].push(picture);
            }
        }
    }
    bar.finish_and_clear();
    let exposure = args.exposure.unwrap_or_else(|| lamps.exposure());
    let mut first = Vec::new();
    for (((lobes, name), mut frames), seconds) in SUBJECTS.into_iter().zip(frames).zip(seconds) {
        let mean = frames.iter().map(light).sum::<f64>() / frames.len() as f64;
        if lobes == Lobes::Ggx {
            let factor = (whole / mean) as f32;
            for texel in frames.iter_mut().flat_map(|frame| &mut frame.pixels) {
                texel[..3].iter_mut().for_each(|c| *c *= factor);
            }
        }
        let found = flicker(&frames, exposure);
        let record = serde_json::json!({
            "kind": "flicker",
            "surface": skin.spec.name,
            "variant": skin.variant.name,
            "route": format!("{}:{}", gpu.info().backend, gpu.info().name),
            "mesh": mesh.name,
            "size": size,
            "filter": name,
            "exposure": exposure,
            "bright_above": BRIGHT,
            "change_above": CHANGE,
            "bright_pixels": found.bright,
            "flicker": found.flicker,
            "light": if lobes == Lobes::Ggx { 1.0 } else { mean / whole },
            "seconds": seconds,
        });
        println!("{record}");
        first.push(frames.swap_remove(0));
    }
    Ok(first)
}
