//! A property: a GSF file and texts of the same heights give the same heights and pitch.

use crate::support::heights::*;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::surface::{HeightField, write_gsf};
use proptest::collection::vec;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(100) })]

    #[test]
    fn gsf_and_texts_agree(
        (columns, rows, heights) in (2usize..12, 2usize..12).prop_flat_map(|(c, r)| {
            (Just(c), Just(r), vec(-0.5f64..0.5, c * r))
        }),
        pitch in (0.01f64..0.09, 0.01f64..0.09),
        comma in any::<bool>(),
    ) {
        let field = HeightField::new(columns, rows, pitch.0, pitch.1, heights).unwrap();
        let dir = folder();
        let gsf = read(&bare(&put(&dir, "a.gsf", &write_gsf(&field))), "probe").unwrap();
        let spelled = |text: String| if comma { text.replace('.', ",") } else { text };
        // GSF rounds to single precision
        let nm = |i: usize| format!("{:.7}", field.heights_um()[i] * 1e3);
        let line = |row: usize| (0..columns).map(|c| nm(row * columns + c)).collect::<Vec<_>>().join("\t");
        let matrix = (0..rows).map(line).collect::<Vec<_>>().join("\r\n");
        let (width, height) = (field.size_x_um(), field.size_y_um());
        let header = format!("# Width: {width:.12} µm\n# Height: {height:.12} µm\n# Value units: nm\n");
        let points: String = (0..columns * rows)
            .map(|i| {
                let (x, y) = (i % columns, rows - 1 - i / columns);
                format!("{:.9}\t{:.9}\t{}\n", x as f64 * pitch.0 * 1e3, y as f64 * pitch.1 * 1e3, nm(i))
            })
            .collect();
        for text in [header + &matrix, format!("x[nm]\ty[nm]\tz[nm]\n{points}")] {
            let text = spelled(text);
            let found = read(&bare(&put(&dir, "a.txt", text.as_bytes())), "probe").unwrap();
            prop_assert_eq!((found.columns, found.rows), (columns, rows));
            prop_assert!((found.pitch_x_um - gsf.pitch_x_um).abs() < 1e-9);
            prop_assert!((found.pitch_y_um - gsf.pitch_y_um).abs() < 1e-9);
            for (a, b) in found.heights_um.iter().zip(&gsf.heights_um) {
                prop_assert!((a - b).abs() < 1e-7, "{} {}", a, b);
            }
        }
    }
}
