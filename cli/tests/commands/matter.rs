//! Metals, covers and films in plans: what is built, what is refused, and what is said.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn diffraction(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_diffraction"))
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// A plan with these keys of the optics, and a table of n and k.
fn folder(keys: &str, table: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let plan = format!(
        r#"schema = 1
[[surface]]
name = "a"
grating = {{ kind = "blazed", period_um = 2.5, height_um = 0.1, pixels = 50 }}
[optics]
{keys}
[[preset]]
name = "sum"
mode = "adaptive"
basis = "optimal"
terms = "auto"
[targets]
emit = ["wgsl"]
"#
    );
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    fs::write(folder.path().join("n.csv"), table).unwrap();
    let directions = "theta_i,phi_i,theta_r,phi_r\n20,0,20,180\n";
    fs::write(folder.path().join("directions.csv"), directions).unwrap();
    folder
}

const TABLE: &str = "wavelength_nm,n,k\n380,0.5,4\n780,2,7\n";

/// Every fault ends with exit code 2 and a sentence that has the place, the key, the cause and a remedy, and nothing is written.
#[test]
fn wrong_matter_is_refused_with_place_key_and_remedy() {
    let nk = "material = { nk = \"n.csv\" }";
    for (keys, table, parts) in [
        (
            "material = \"aluminum\"",
            TABLE,
            ["plan.toml:6", "optics.material", "did you mean \"aluminium\"?"],
        ),
        (
            "material = \"unobtainium\"",
            TABLE,
            ["plan.toml:6", "unknown material", "known: dielectric"],
        ),
        ("material = 1.5", TABLE, ["plan.toml:6", "optics.material = 1.5", "a string"]),
        (
            "material = { nk = \"m.csv\" }",
            TABLE,
            ["m.csv", "is not a file", "wavelength_nm, n and k"],
        ),
        ("material = { nk = \".\" }", TABLE, ["\".\"", "is not a file", "wavelength_nm, n and k"]),
        ("material = { file = \"n.csv\" }", TABLE, ["plan.toml:6", "optics.material.file", "nk"]),
        ("cover_index = 0.9", TABLE, ["plan.toml:6", "optics.cover_index = 0.9", "from 1 to 4"]),
        ("cover_index = 0", TABLE, ["plan.toml:6", "optics.cover_index = 0", "from 1 to 4"]),
        ("cover_index = nan", TABLE, ["plan.toml:6", "optics.cover_index = nan", "from 1 to 4"]),
        ("cover_index = \"glas\"", TABLE, ["plan.toml:6", "unknown medium", "polycarbonate"]),
        (
            "cover_index = 1.5",
            TABLE,
            ["surface a", "sum: optics.material", "another refractive index"],
        ),
        (
            "cover_index = { nk = \"n.csv\" }",
            TABLE,
            ["surface a", "sum: optics.cover_index = n.csv", "absorbs"],
        ),
        (
            "films = [{ index = 1.4, thickness_nm = 0 }]",
            TABLE,
            ["plan.toml:6", "films[1].thickness_nm = 0", "at most 10000"],
        ),
        (
            "films = [{ index = 1.4, thickness_nm = -5 }]",
            TABLE,
            ["plan.toml:6", "thickness_nm = -5", "above 0"],
        ),
        (
            "films = [{ index = 1.4, thickness_nm = nan }]",
            TABLE,
            ["plan.toml:6", "thickness_nm = nan", "above 0"],
        ),
        (
            "films = [{ index = 1.4, thickness_nm = 1e9 }]",
            TABLE,
            ["plan.toml:6", "thickness_nm = 1e9", "a cover"],
        ),
        (
            "films = [{ index = 0.5, thickness_nm = 5 }]",
            TABLE,
            ["plan.toml:6", "films[1].index = 0.5", "from 1 to 5"],
        ),
        (
            "films = [{ thickness_nm = 5 }]",
            TABLE,
            ["plan.toml:6", "films[1].index is missing", "refractive index"],
        ),
        (
            "material = \"gold\"\nfilms = [{ index = 1.4, thickness_nm = 10000 }]",
            TABLE,
            ["sum: optics.films", "too fast with the wavelength", "use thinner films"],
        ),
        (
            "material = \"gold\"\nfilms = [{ index = 2.4, thickness_nm = 10000 }]",
            TABLE,
            ["sum: optics.films", "too fast with the", "use thinner films"],
        ),
        ("films = 3", TABLE, ["plan.toml:6", "optics.films = 3", "array"]),
        ("obliquity = \"t\"", TABLE, ["plan.toml:6", "optics.obliquity", "did you mean \"te\"?"]),
        (nk, "wavelength_nm,n\n380,1\n780,1\n", ["nk = \"n.csv\"", "without k", "header"]),
        (nk, "wavelength_nm,n,k\n500,1,0\n400,1,0\n", ["nk = \"n.csv\"", "line 3", "ascending"]),
        (nk, "wavelength_nm,n,k\n400,1,0\n400,1,0\n", ["nk = \"n.csv\"", "line 3", "ascending"]),
        (
            nk,
            "wavelength_nm,n,k\n380,1,-2\n780,1,0\n",
            ["nk = \"n.csv\"", "line 2: k is -2", "at least 0"],
        ),
        (
            nk,
            "wavelength_nm,n,k\n380,0,2\n780,1,0\n",
            ["nk = \"n.csv\"", "line 2: n is 0", "above 0"],
        ),
        (
            nk,
            "wavelength_nm,n,k\n380,inf,2\n780,1,0\n",
            ["nk = \"n.csv\"", "line 2", "not a number"],
        ),
        (
            nk,
            "wavelength_nm,n,k\n500,1,2\n600,1,2\n",
            ["optics.material = n.csv", "500 to 600 nm", "extend the table"],
        ),
        (nk, "\u{0}\u{1}", ["nk = \"n.csv\"", "header", "ascending"]),
        (nk, "", ["nk = \"n.csv\"", "header", "ascending"]),
    ] {
        let folder = folder(keys, table);
        let done = diffraction(folder.path(), &["generate", "--out", "out"]);
        let text = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{keys}: {text}");
        for part in parts {
            assert!(text.contains(part), "{keys}, {table:?}: {part} is not in\n{text}");
        }
        assert!(!folder.path().join("out").exists(), "{keys}");
    }
}

/// A table of one's own: the package names it, its content is what counts, and light beyond it is a note.
#[test]
fn a_table_of_ones_own_counts_by_its_content() {
    let keys = "material = { nk = \"n.csv\" }\ncover_index = \"polycarbonate\"";
    let folder = folder(keys, TABLE);
    let exact = |folder: &Path| {
        let args =
            ["eval", "--surface", "a", "--runner", "exact", "--directions", "directions.csv"];
        let done = diffraction(folder, &args);
        let text = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(0), "{text}");
        assert!(text.contains("its table is from 400 to 830 nm"), "{text}");
        String::from_utf8(done.stdout).unwrap()
    };
    let first = exact(folder.path());
    let made = |out: &str| {
        let done = diffraction(folder.path(), &["generate", "--out", out]);
        assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
        let manifest = folder.path().join(out).join("shaders/a/sum/manifest.json");
        let text = fs::read_to_string(manifest).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()
    };
    let before = made("first");
    assert_eq!(before["configuration"]["material"]["nk"], "n.csv");
    assert_eq!(before["configuration"]["cover_index"], "polycarbonate");
    assert!(before["configuration"].get("refractive_index").is_none());
    fs::write(folder.path().join("n.csv"), TABLE.replace("0.5,4", "0.6,3")).unwrap();
    assert_ne!(exact(folder.path()), first);
    let after = made("second");
    assert_ne!(before["input_hash"], after["input_hash"]);
    assert_ne!(before["core"]["diffuser_scale"], after["core"]["diffuser_scale"]);
    // a package that was made from the table before is not up to date
    let check = diffraction(folder.path(), &["generate", "--out", "first", "--check"]);
    assert_eq!(check.status.code(), Some(1), "{}", String::from_utf8_lossy(&check.stderr));
}
