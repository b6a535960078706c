//! Several blocks of numbers in one text: one is chosen, none are joined.

use crate::support::heights::*;
use diffraction_shaders::error::Result;
use diffraction_shaders::input::read_heights as read;
use diffraction_shaders::plan::FileSource;
use diffraction_shaders::surface::read::Reading;

fn open(text: &str, channel: Option<&str>) -> Result<Reading> {
    let dir = folder();
    let path = put(&dir, "a.txt", text.as_bytes());
    read(&FileSource { channel: channel.map(str::to_owned), ..floats(&path) }, "probe")
}

fn block(name: &str, unit: &str, gap: &str) -> String {
    format!("# Channel: {name}\n# Value units: {unit}\n{}\n{gap}", rows(" ").join("\n"))
}

#[test]
fn the_first_block_is_used_if_it_is_called_height() {
    for gap in ["\n", ""] {
        let text =
            block("Height", "nm", gap) + &block("Phase", "deg", gap) + &block("Z 2", "pm", gap);
        let reading = open(&text, None).unwrap();
        assert_upright(&reading, 1e-5);
        assert!(
            reading.notes.iter().any(|n| n.contains("first of 3") && n.contains("Phase")),
            "{:?}",
            reading.notes
        );
        assert_upright(&open(&text, Some("1")).unwrap(), 1e-5);
        assert_upright(&open(&text, Some("z 2")).unwrap(), 1e-8);
        assert_upright(&open(&text, Some("3")).unwrap(), 1e-8);
        assert_says(open(&text, Some("Phase")), &["deg", "not a unit of length"]);
        assert_says(open(&text, Some("4")), &["channel = 4", "1: Height", "3: Z 2"]);
    }
    for name in ["Topography", "ZSensor", "height forward"] {
        assert!(open(&(block(name, "nm", "\n") + &block("b", "nm", "")), None).is_ok(), "{name}");
    }
}

#[test]
fn other_blocks_are_asked_about() {
    let text = block("Phase", "nm", "\n") + &block("Height", "pm", "");
    assert_says(
        open(&text, None),
        &["2 blocks", "1: Phase (line 3, 3 rows)", "2: Height", "channel"],
    );
    assert_upright(&open(&text, Some("height")).unwrap(), 1e-8);
    // blank lines alone, too
    let bare = format!("{0}\n\n{0}\n", rows(" ").join("\n"));
    assert_says(open(&bare, None), &["2 blocks", "no name", "blank lines"]);
    assert_upright(&open(&bare, Some("2")).unwrap(), 0.01);
    let uneven = format!("{}\n\n{}\n", rows(" ").join("\n"), rows(" ")[..2].join("\n"));
    assert_says(
        open(&uneven, None),
        &["1: no name (line 1, 3 rows)", "2: no name (line 5, 2 rows)"],
    );
}

#[test]
fn a_single_block_is_checked_too() {
    let text = block("Topo", "nm", "\n\n");
    assert_upright(&open(&text, None).unwrap(), 1e-5);
    assert_upright(&open(&text, Some("topo")).unwrap(), 1e-5);
    assert_says(open(&text, Some("Phase")), &["channel = Phase", "only Topo"]);
    // what stands after the numbers belongs to them
    let footer = format!("{}\n# Value units: nm\n", rows(" ").join("\n"));
    assert_upright(&open(&footer, None).unwrap(), 1e-5);
}
