//! Exact colours against tristimulus values from a separate program that evaluates the definition directly.

use crate::support::data;
use std::fs;
use std::path::Path;

use diffraction_shaders::field::reference::{Directions, Reference};
use diffraction_shaders::input;
use diffraction_shaders::plan::{
    FileSource, Level, Optics, SurfaceOptics, SurfaceSource, SurfaceSpec,
};
use diffraction_shaders::surface::HeightField;

/// Of the largest component of a direction's XYZ; the two programs were seen to agree to 5e-4.
const TOLERANCE: f64 = 2e-3;

const SURFACE: &str = "elaphe_crop_100px.png";
const FILES: [(&str, f64); 2] =
    [("vectors/crop_coherence65.csv", 65.0), ("vectors/crop_coherence8.csv", 8.0)];

/// Reads the surface at its documented scale.
fn surface(path: &Path) -> HeightField {
    let source = FileSource {
        path: path.to_owned(),
        pixel_um: Some(0.0586),
        height_um: Some(0.375),
        ..FileSource::default()
    };
    let spec = SurfaceSpec {
        name: "crop".into(),
        source: SurfaceSource::File(source),
        rotate_deg: 0.0,
        level: Level::None,
        clip_percent: 0.0,
        optics: SurfaceOptics::default(),
    };
    input::load_surface(&spec).unwrap().field
}

/// Directions and XYZ of a file.
fn vectors(path: &Path) -> Vec<(Directions, [f64; 3])> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("theta_i,phi_i,theta_r,phi_r,X,Y,Z"));
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let [theta_i, phi_i, theta_r, phi_r, x, y, z] = numbers[..] else { panic!("{line}") };
        (Directions::from_degrees([theta_i, phi_i, theta_r, phi_r]), [x, y, z])
    };
    lines.map(row).collect()
}

/// The greatest difference over all vectors, of the largest component of each.
fn worst(height: &HeightField, coherence_um: f64, vectors: &[(Directions, [f64; 3])]) -> f64 {
    let optics = Optics { coherence_um, ..Optics::standard() };
    let directions: Vec<Directions> = vectors.iter().map(|(d, _)| *d).collect();
    let reference =
        Reference::new(height, 0.0, &optics, Reference::VISIBLE_NM, directions.iter().copied());
    let colours = reference.unwrap().tristimulus_all(&directions);
    let error = |(got, (_, want)): (&[f64; 3], &(Directions, [f64; 3]))| {
        let largest = want.iter().copied().fold(0.0, f64::max);
        (0..3).map(|c| (got[c] - want[c]).abs() / largest).fold(0.0, f64::max)
    };
    colours.iter().zip(vectors).map(error).fold(0.0, f64::max)
}

/// Pixels taken from elsewhere: `from(column, row)`.
fn moved(height: &HeightField, from: impl Fn(usize, usize) -> (usize, usize)) -> HeightField {
    let (columns, rows) = (height.columns(), height.rows());
    let heights_um = (0..columns * rows)
        .map(|i| from(i % columns, i / columns))
        .map(|(column, row)| height.heights_um()[row * columns + column])
        .collect();
    HeightField::new(columns, rows, height.pitch_x_um(), height.pitch_y_um(), heights_um).unwrap()
}

#[test]
fn colours_agree_and_wrong_readings_of_the_surface_do_not() {
    let Some(path) = data::find(SURFACE) else { return };
    let height = surface(&path);
    let (columns, rows) = (height.columns(), height.rows());
    for (file, coherence_um) in FILES {
        let Some(path) = data::find(file) else { continue };
        let vectors = vectors(&path);
        assert!(vectors.len() > 30, "{file} has {} vectors", vectors.len());
        let error = worst(&height, coherence_um, &vectors);
        println!("{file}: {error:.1e} of the largest component");
        assert!(error <= TOLERANCE, "{file}: {error:e}");

        let mirrored = moved(&height, |column, row| (column, rows - 1 - row));
        // what the centre of the window sees when the window's maximum lies on pixel 0
        let from_pixel_0 = moved(&height, |column, row| {
            ((column + columns / 2) % columns, (row + rows / 2) % rows)
        });
        let transposed = moved(&height, |column, row| (row, column));
        let mut wrong = vec![("mirrored", mirrored), ("transposed", transposed)];
        // under the long window the lobes are apart, so that the phases of the orders do not matter
        if coherence_um < 10.0 {
            wrong.push(("from pixel 0", from_pixel_0));
        }
        for (what, wrong) in wrong {
            let error = worst(&wrong, coherence_um, &vectors);
            println!("{file}, {what}: {error:.1e}");
            assert!(error > 50.0 * TOLERANCE, "{file}, {what}: {error:e} is no difference");
        }
        let error = worst(&height, 0.9 * coherence_um, &vectors);
        assert!(error > 10.0 * TOLERANCE, "{file}, a shorter window: {error:e} is no difference");
    }
}
