//! Heights of integer files come in steps, which is reported, and which colours show.

use crate::support::heights::*;
use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::input;
use diffraction_shaders::optics::colour_difference::{ColourDifference, colour_difference};
use diffraction_shaders::optics::{diffuser_scale, direction};
use diffraction_shaders::plan::{FileSource, Grating, Optics};
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::surface::{HeightField, Surface};
use glam::DVec3;
use image::ExtendedColorType;

/// Height of the full grey range, µm: steps of 2.94 nm in 8 bits, as in the texts.
const FULL_UM: f64 = 0.75;

/// Smooth and shallow: 34 of the 255 steps.
fn smooth() -> HeightField {
    let grating = Grating::Sinusoidal { period_um: 5.0, height_um: 0.1, pixels: 100 };
    synthesise(&grating, "smooth").unwrap().field
}

/// The grey levels of a field, of `top` for [`FULL_UM`].
fn greys(field: &HeightField, top: f64) -> Vec<u16> {
    field.heights_um().iter().map(|h| (h / FULL_UM * top).round() as u16).collect()
}

fn loaded(bytes: &[u8]) -> Surface {
    let dir = folder();
    let source = FileSource { height_um: Some(FULL_UM), ..integers(&put(&dir, "a.png", bytes)) };
    input::load_surface(&surface(FileSource { pixel_um: Some(0.05), ..source })).unwrap()
}

fn as_8_bits(field: &HeightField) -> Vec<u8> {
    let grey: Vec<u8> = greys(field, 255.0).iter().map(|g| *g as u8).collect();
    png(field.columns() as u32, field.rows() as u32, ExtendedColorType::L8, &grey)
}

fn as_16_bits(field: &HeightField, levels: &[u16]) -> Vec<u8> {
    let bytes: Vec<u8> = levels.iter().flat_map(|g| g.to_ne_bytes()).collect();
    png(field.columns() as u32, field.rows() as u32, ExtendedColorType::L16, &bytes)
}

#[test]
fn the_step_is_told() {
    let field = smooth();
    let grey = greys(&field, 255.0);
    let message = |bytes: &[u8]| loaded(bytes).notes.join("; ");
    assert_eq!(message(&as_8_bits(&field)), "heights come in steps of 2.94 nm (8-bit grey)");
    let fine = as_16_bits(&field, &greys(&field, 65535.0));
    assert_eq!(message(&fine), "heights come in steps of 0.0114 nm (16-bit grey)");
    // eight bits that were stored as sixteen are as coarse as before
    let widened: Vec<u16> = grey.iter().map(|g| g * 257).collect();
    assert_eq!(
        message(&as_16_bits(&field, &widened)),
        "heights come in steps of 2.94 nm (16-bit grey, of which only every 257th level is used)"
    );
    let even: Vec<u8> = grey.iter().map(|g| (g / 2 * 2) as u8).collect();
    let even = png(field.columns() as u32, field.rows() as u32, ExtendedColorType::L8, &even);
    assert!(
        message(&even).starts_with("heights come in steps of 5.88 nm (8-bit"),
        "{}",
        message(&even)
    );
    let flat = loaded(&png(4, 4, ExtendedColorType::L8, &[9; 16]));
    assert_eq!(flat.notes, ["heights come in steps of 2.94 nm (8-bit grey)"]);
    // floats have no steps
    let dir = folder();
    let text = floats(&put(&dir, "a.txt", b"0 0.1\n0.2 0.3\n"));
    assert!(input::load_surface(&surface(text)).unwrap().notes.is_empty());
}

/// The exact colours of a file's heights against those of the heights that it was made from, across the plane of
/// incidence and as bright as they are beside a white diffuser.
fn difference(smooth: &HeightField, file: &[u8]) -> ColourDifference {
    let wi = direction(20.0, 0.0);
    let towards = |x: f64| DVec3::new(x, 0.0, (1.0 - x * x).sqrt());
    let directions: Vec<Directions> =
        (-350..=350).map(|i| Directions { wi, wr: towards(0.0025 * f64::from(i)) }).collect();
    let optics = Optics { coherence_um: 20.0, ..Optics::standard() };
    let [exact, stepped] = [smooth, &loaded(file).field].map(|height| {
        let all = directions.iter().copied();
        let reference = Reference::new(height, 0.0, &optics, Reference::VISIBLE_NM, all).unwrap();
        reference.tristimulus_all(&directions)
    });
    colour_difference("stepped heights", &exact, &stepped, Some(diffuser_scale(&optics).unwrap()))
        .unwrap()
}

#[test]
fn eight_bits_are_seen_in_the_colours_and_sixteen_are_not() {
    let field = smooth();
    let coarse = difference(&field, &as_8_bits(&field));
    println!("8 bits: {coarse:?}");
    // a difference of 1 is just seen; terraces of 3 nm are a grating of their own
    assert!((2.0..5.0).contains(&coarse.de2000.p95), "{coarse:?}");
    assert!((3.0..10.0).contains(&coarse.de2000.max), "{coarse:?}");
    let fine = difference(&field, &as_16_bits(&field, &greys(&field, 65535.0)));
    println!("16 bits: {fine:?}");
    assert!(fine.de2000.max < 0.05, "{fine:?}");
}
