//! How numbers are written: ends of lines, encodings, decimal commas.

use crate::support::heights::*;
use diffraction_shaders::error::Result;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::surface::read::Reading;

fn open(bytes: impl AsRef<[u8]>) -> Result<Reading> {
    let dir = folder();
    read(&floats(&put(&dir, "a.txt", bytes.as_ref())), "probe")
}

#[test]
fn every_end_of_line() {
    for end in ["\n", "\r\n", "\r", "\n\n", "\r\r\n", "\r\r"] {
        assert_upright(&open(rows(" ").join(end)).unwrap(), 0.01);
        let header =
            format!("# Channel: Height{end}# Value units: um{end}{}{end}", rows("\t").join(end));
        assert_upright(&open(header).unwrap(), 0.01);
    }
    // a CR is no blank between numbers
    assert_says(open("0.1 0.2\r0.3\n"), &["line 2 has 1 numbers"]);
}

#[test]
fn a_long_line_is_a_profile_and_says_so() {
    let line = vec!["0.1 0.2"; 512].join(" ");
    let reading = open(&line).unwrap();
    assert_eq!((reading.columns, reading.rows), (1024, 1));
    assert!(
        reading.notes.iter().any(|n| n.contains("32 × 32") && n.contains("x-pixels")),
        "{:?}",
        reading.notes
    );
    let reading = open(format!("# x-pixels = 32\n# y-pixels = 32\n{line}\n")).unwrap();
    assert_eq!((reading.columns, reading.rows), (32, 32));
    // a number that fills no square is a profile without a word
    assert!(open(line + " 0.3").unwrap().notes.iter().all(|n| !n.contains("x-pixels")));
}

#[test]
fn every_encoding() {
    let text = format!("# Height in µm, größte Höhe\n{}\n", rows("\t").join("\r\n"));
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let marked = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
    for bytes in [
        text.clone().into_bytes(),
        marked(b"\xef\xbb\xbf", text.as_bytes()),
        marked(b"\xff\xfe", &little),
        marked(b"\xfe\xff", &big),
        little.clone(),
        big,
        latin,
    ] {
        assert_upright(&open(bytes).unwrap(), 0.01);
    }
    // units survive in every encoding
    let micro = "# Width: 0.5 \u{b5}m\n# Value units: \u{c5}\n";
    let latin: Vec<u8> =
        format!("{micro}{}\n", rows(" ").join("\n")).chars().map(|c| c as u8).collect();
    let dir = folder();
    let reading = read(&bare(&put(&dir, "a.txt", &latin)), "probe").unwrap();
    assert_upright(&reading, 1e-6);
    assert!((reading.pitch_x_um - 0.1).abs() < 1e-12);
    assert_says(open(marked(b"\xff\xfe", &little[..21])), &["UTF-16", "damaged"]);
    let wide: Vec<u8> = text.chars().flat_map(|c| (c as u32).to_le_bytes()).collect();
    assert_says(open(marked(b"\xff\xfe\0\0", &wide)), &["UTF-32"]);
}

#[test]
fn decimal_commas() {
    let comma = |between: &str, end: &str| rows(between).join(end).replace('.', ",");
    for between in [" ", "\t", ";", " ; ", "; "] {
        assert_upright(&open(comma(between, "\n")).unwrap(), 0.01);
    }
    // one column: no whole number begins with a zero
    let column = open(comma("\n", "\n")).unwrap();
    assert_eq!((column.columns, column.rows), (1, 15));
    assert!((column.heights_um[1] - 0.1).abs() < 1e-12);
    // a header with a decimal comma
    let text = format!("# Width: 0,50 µm\n{}\n", comma(";", "\n"));
    let dir = folder();
    let reading = read(&bare(&put(&dir, "a.txt", text.as_bytes())), "probe").unwrap();
    assert!((reading.pitch_x_um - 0.1).abs() < 1e-12);
}

#[test]
fn commas_that_may_mean_two_things() {
    for text in ["1,2\n3,4\n", "1,5\n2,7\n4,1\n"] {
        assert_says(open(text), &["may be the number", "the numbers", "semicolons"]);
    }
    assert_says(open("0,12,0,13\n0,05,0,07\n"), &["may be the number"]);
    assert_says(open("1.2;3,4\n5.6;7,8\n"), &["decimal commas or as separators"]);
    // what decides: a sign, an exponent's point, a name for each column, more fields than a number has
    for text in ["1,-2\n3,4\n", "1.0,2\n3,4\n", "# a,b\n1,2\n3,4\n"] {
        let reading = open(text).unwrap();
        assert_eq!((reading.columns, reading.rows), (2, 2), "{text}");
    }
    assert_eq!(open("1,2,3\n4,6,5\n").unwrap().columns, 3);
}

#[test]
fn words_quotes_and_other_spellings_of_numbers() {
    let reading = open("0.1 Bad\n--- 0.4\n").unwrap();
    assert!(reading.heights_um[1].is_nan() && reading.heights_um[2].is_nan());
    assert!(reading.notes.iter().any(|n| n.contains("2 cells")), "{:?}", reading.notes);
    assert_eq!(
        open("\"0.1\",\"0.2\"\n\"0.3\",\"0.5\"\n").unwrap().heights_um,
        [0.1, 0.2, 0.3, 0.5]
    );
    assert_eq!(open("1.0D-1 2\u{2009}\n−3 4\n").unwrap().heights_um, [0.1, 2.0, -3.0, 4.0]);
    assert_eq!(open("0.1;0.2;\n0.3;0.5;\n").unwrap().columns, 2);
    // a damaged number in the first row is no heading
    assert_says(open("x1 0.2 0.3\n0.1 0.5 0.3\n"), &["line 1", "`x1`", "not a number"]);
    assert_says(open("0.1 0.2\nx 0.3\n"), &["line 2", "`x 0.3`", "not a number"]);
    assert_eq!(open("height of a scan\n0.1 0.2\n0.3 0.5\n").unwrap().rows, 2);
}
