//! Plans: what is refused and how it is reported, the order of the product, names that stay.

use std::collections::BTreeSet;
use std::path::Path;

use diffraction_shaders::input::read_plan;
use diffraction_shaders::plan::{Auto, Basis, Mode, Packing, Plan, SurfaceSource, Target, Variant};

const SURFACE: &str = r#"schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = 0.3, pixels = 100 }
"#;

fn parse(text: &str) -> Plan {
    Plan::parse(text, Path::new("plans/plan.toml")).unwrap()
}

/// A plan with a sound surface and more text; lines of the text begin at 5.
fn with(text: &str) -> Plan {
    parse(&format!("{SURFACE}{text}"))
}

fn errors(text: &str) -> String {
    let errors = Plan::parse_all(text, Path::new("plan.toml")).expect_err(text);
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn names(plan: &Plan) -> Vec<&str> {
    plan.variants.iter().map(|variant| variant.name.as_str()).collect()
}

#[test]
fn tables_are_raw_whatever_else_they_are() {
    use diffraction_shaders::plan::Container::{Exr, Ktx2};
    let containers = |text: &str| with(&format!("[targets]\n{text}")).containers;
    assert_eq!(with("").containers, []);
    assert_eq!(containers("tables = [\"bin\"]"), []);
    assert_eq!(containers("tables = [\"exr\", \"bin\", \"ktx2\", \"exr\"]"), [Ktx2, Exr]);
    assert_eq!(containers("tables = \"ktx2\""), [Ktx2]);
}

#[test]
fn faults_of_the_file_are_told() {
    for (text, expected) in [
        ("", vec!["plan.toml: is empty", "schema = 1"]),
        ("# nothing\n", vec!["is empty"]),
        ("schema = 1\n", vec!["has no surface", "[[surface]]"]),
        ("schema = = 1\n", vec!["plan.toml:1:", "not valid TOML"]),
        ("schema = 1\nschema = 1\n", vec!["plan.toml:2:", "duplicate key"]),
        ("[[surface]]\n", vec!["schema is missing", "surface[1].name is missing"]),
        ("schema = 2\n", vec!["plan.toml:1: schema = 2: must be 1"]),
        ("schema = \"1\"\n", vec!["schema = \"1\": must be 1"]),
        (
            "schema = 1\nsurfaces = []\n",
            vec!["plan.toml:2: unknown key surfaces (did you mean \"surface\"?)"],
        ),
        (
            r#"schema = 1
[surface]
name = "a"
"#,
            vec!["surface = {…}: is not an array of tables", "[[surface]]"],
        ),
    ] {
        let message = errors(text);
        for part in expected {
            assert!(message.contains(part), "{text:?} message {message:?}, not {part:?}");
        }
    }
}

#[test]
fn faults_of_a_surface_are_told() {
    let blazed = |keys: &str| format!("name = \"a\"\ngrating = {{ kind = \"blazed\", {keys} }}");
    for (text, expected) in [
        (
            blazed("period_um = 2.5, height_um = -0.3, pixels = 100"),
            "plan.toml:4: surface.a.grating.height_um = -0.3: must be positive and finite (a height in µm)",
        ),
        (blazed("period_um = nan, height_um = 0.3, pixels = 100"), "period_um = nan: must be positive and finite"),
        (blazed("period_um = inf, height_um = 0.3, pixels = 100"), "period_um = inf: must be positive and finite"),
        (blazed("period_um = 2.5, height_um = 0.3, pixels = 1.5"), "pixels = 1.5: is a float (expected a whole number"),
        (blazed("period_um = 2.5, height_um = 0.3, pixels = -4"), "pixels = -4: must be a whole number from 2"),
        (blazed("period_um = 2.5, height_um = 0.3, pixels = 20"), "pixels = 20: a pitch of 0.1250 µm is above a quarter of the shortest wavelength, 0.095 µm (use at least 27 pixels"),
        (blazed("period_um = 2.5, height_um = 0.3"), "surface.a.grating.pixels is missing"),
        (
            blazed("period_um = 2.5, hieght_um = 0.3, height_um = 0.3, pixels = 100"),
            "unknown key surface.a.grating.hieght_um (did you mean \"height_um\"?)",
        ),
        (blazed("period_um = \"2\", height_um = 0.3, pixels = 100"), "period_um = \"2\": is a string (expected a number"),
        ("name = \"a\"\ngrating = { kind = \"blased\" }".into(), "grating.kind = \"blased\": unknown value (did you mean \"blazed\"?)"),
        ("name = \"a\"\ngrating = { period_um = 1 }".into(), "surface.a.grating.kind is missing"),
        ("name = \"a\"\ngrating = 3".into(), "surface.a.grating = 3: is an integer"),
        ("name = \"a\"".into(), "surface.a has neither grating nor file"),
        ("name = \"a\"\nfile = \"x.png\"\ngrating = { kind = \"flat\" }".into(), "surface.a has both grating and file"),
        ("name = \"A\"\nfile = \"x.png\"".into(), "surface[1].name = \"A\": is not a valid name"),
        ("name = \"a/b\"\nfile = \"x.png\"".into(), "is not a valid name"),
        ("name = \"..\"\nfile = \"x.png\"".into(), "is not a valid name"),
        ("name = \"\"\nfile = \"x.png\"".into(), "is not a valid name"),
        ("name = 3\nfile = \"x.png\"".into(), "surface[1].name = 3: is an integer"),
        (r#"name = "a"
file = "x.png"
size_um = 3
pixel_um = 0.01"#.into(), "size_um and pixel_um both set the scale"),
        (r#"name = "a"
file = "x.png"
height_um = 3
z_unit_um = 1"#.into(), "height_um and z_unit_um both set the heights"),
        ("name = \"a\"\nfile = \"x.png\"\npixel_um = 0.2".into(), "pixel_um = 0.2: a pitch above a quarter of the shortest wavelength, 0.095 µm"),
        ("name = \"a\"\nfile = \"x.png\"\nlevel = \"plain\"".into(), "level = \"plain\": unknown value (did you mean \"plane\"?)"),
        ("name = \"a\"\nfile = \"x.png\"\nclip_percent = 50".into(), "clip_percent = 50: must be from 0 to below 50"),
        ("name = \"a\"\nfile = \"x.png\"\nclip_percent = -1".into(), "clip_percent = -1: must be"),
        ("name = \"a\"\nfile = \"x.png\"\nrotate_deg = nan".into(), "rotate_deg = nan: must be finite"),
        ("name = \"a\"\nfile = \"x.png\"\nheigth_um = 1".into(), "unknown key surface[1].heigth_um (did you mean \"height_um\"?)"),
        (
            "name = \"a\"\ngrating = { kind = \"crossed\", x = { kind = \"lamellar\", period_um = 1, height_um = 1, pixels = 20, duty = 1 }, y = { kind = \"flat\", period_um = 1, pixels = 20 } }".into(),
            "surface.a.grating.x.duty = 1: must be between 0 and 1",
        ),
        (
            "name = \"a\"\ngrating = { kind = \"crossed\", x = { kind = \"flat\", period_um = 1, pixels = 20 }, y = { kind = \"flat\", period_um = 1, pixels = 5 } }".into(),
            "surface.a.grating.y.pixels = 5: a pitch of 0.2000 µm",
        ),
    ] {
        let message = errors(&format!(r#"schema = 1
[[surface]]
{text}
"#));
        assert!(message.contains(expected), "{text}\n message {message}\n not {expected}");
    }
    let twice = errors(&format!(
        r#"{SURFACE}[[surface]]
name = "a"
file = "x.png"
"#
    ));
    assert!(
        twice.contains("plan.toml:6: surface[2].name = \"a\": is the name of another surface"),
        "{twice}"
    );
}

#[test]
fn faults_of_optics_variants_presets_and_targets_are_told() {
    for (text, expected) in [
        (
            "[optics]\ncoherence_um = 0",
            "plan.toml:6: optics.coherence_um = 0: must be from 0.1 to 10000",
        ),
        (
            "[optics]\nrefractive_index = 1",
            "refractive_index = 1: must be above 1 and at most 5 (the refractive index of the material",
        ),
        (
            "[optics]\nshadowing = \"yes\"",
            "optics.shadowing = \"yes\": is a string (expected true or false)",
        ),
        ("[optics]\nshadowing = [true]", "optics.shadowing = [true]: is an array"),
        ("[optics]\ncolor = \"srgb\"", "unknown key optics.color (did you mean \"colour\"?)"),
        ("[optics]\nilluminant = \"\"", "is not the name of an illuminant or a file"),
        ("[variants]\nterms = [0]", "variants.terms[1] = 0: must be a whole number from 1 to 200"),
        (
            "[variants]\nterms = [31, 201]",
            "variants.terms[2] = 201: must be a whole number from 1 to 200",
        ),
        ("[variants]\nterms = \"many\"", "variants.terms = \"many\": is a string"),
        ("[variants]\nterms = [31, 31]", "variants.terms[2] = 31: is listed twice"),
        ("[variants]\nterms = []", "variants.terms = []: has no values"),
        (
            "[variants]\nwindow_radius = 65",
            "window_radius = 65: must be a whole number from 0 to 64",
        ),
        (
            "[variants]\nmode = [\"ful\"]",
            "variants.mode[1] = \"ful\": unknown value (did you mean \"full\"?)",
        ),
        (
            "[variants]\nbasis = [1]",
            "variants.basis[1] = 1: is an integer (expected one of \"taylor\"",
        ),
        ("[variants]\nradius = 1", "unknown key variants.radius"),
        (
            "[variants]\nwavelengths = { min_nm = 359 }",
            "wavelengths.min_nm = 359: must be from 360 to 830",
        ),
        (
            "[variants]\nwavelengths = { max_nm = 831 }",
            "wavelengths.max_nm = 831: must be from 360 to 830",
        ),
        (
            "[variants]\nwavelengths = { min_nm = 700, max_nm = 600 }",
            "min_nm 700 is above max_nm 600",
        ),
        ("[variants]\nwavelengths = { step_nm = 0 }", "step_nm = 0: must be positive and finite"),
        (
            "[variants]\nwavelengths = { step_nm = 0.1 }",
            "step_nm = 0.1: gives more than 4000 samples (use a step of at least 0.101 nm)",
        ),
        (
            "[variants]\nwavelengths = { step_nm = 500 }",
            "wider than the range of 400 nm (use a smaller step",
        ),
        (
            "[variants]\nwavelengths = [5]",
            "variants.wavelengths[1] = 5: is an integer (expected a table",
        ),
        (
            "[variants]\nwavelengths = { setp_nm = 5 }",
            "unknown key variants.wavelengths.setp_nm (did you mean \"step_nm\"?)",
        ),
        (
            "[variants]\nmode = \"baked\"\nsampling = \"filter\"",
            "is rejected; the first is baked-filter: WebGPU and WebGL2 cannot filter tables of 32-bit floats",
        ),
        ("[variants]\nterm_error = 0", "term_error = 0: must be above 0"),
        ("[variants]\nperiods = [[1, 2, 3]]", "periods[1] = [1, 2, 3]: has 3 numbers, not two"),
        (
            r#"[[preset]]
name = "p"
mode = "baked"
bake_error = 0"#,
            "plan.toml:8: preset.p.bake_error = 0: ",
        ),
        (
            r#"[[preset]]
name = "p"
reconstruction = "prefiltered"
coherence = "ensemble""#,
            "coherence = \"ensemble\": a prefiltered table holds amplitudes",
        ),
        (
            r#"[[preset]]
name = "p"
reconstruction = "prefiltered"
coherence_scaling = "wavelength""#,
            "a prefiltered table contains one window",
        ),
        (
            r#"[[preset]]
name = "p"
reconstruction = "prefiltered"
mode = "pq""#,
            "pq has no coherence window",
        ),
        (
            r#"[[preset]]
name = "p"
reconstruction = "prefiltered"
hoist = false"#,
            "a prefiltered table is read without such a loop",
        ),
        (
            r#"[[preset]]
name = "p"
reconstruction = "prefiltered"
sampling = "filter""#,
            "cannot filter tables of 32-bit floats; use table = \"f16\"",
        ),
        (
            "[[preset]]\nname = \"p\"\nsampling = \"nearest\"",
            "sampling = \"nearest\": unknown value",
        ),
        ("[[preset]]\nname = \"p\"\nterms = [31]", "preset.p.terms = [31]: is an array"),
        ("[[preset]]\nname = \"texts\"", "is the name of a built-in preset"),
        (
            r#"[[preset]]
name = "p"
[[preset]]
name = "p""#,
            "plan.toml:8: preset.p.name = \"p\": is the name of another variant",
        ),
        ("[variants]\n[[preset]]\nname = \"full-taylor-t31\"", "is the name of another variant"),
        ("[[preset]]\nterms = 3", "preset[1].name is missing"),
        ("[targets]\nemit = [\"glsl\"]", "targets.emit[1] = \"glsl\": unknown value"),
        ("[targets]\nemit = []", "targets.emit = []: is empty"),
        ("[targets]\ntables = [\"dds\"]", "targets.tables[1] = \"dds\": unknown value"),
        ("[targets]\nemits = [\"wgsl\"]", "unknown key targets.emits (did you mean \"emit\"?)"),
        ("[optic]\n", "unknown key optic (did you mean \"optics\"?)"),
    ] {
        let message = errors(&format!("{SURFACE}{text}\n"));
        assert!(message.contains(expected), "{text}\n message {message}\n not {expected}");
    }
}

#[test]
fn all_faults_are_told_in_the_order_of_the_text() {
    let message = errors(
        r#"schema = 3
[optics]
coherence_um = -1
[[surface]]
name = "Ä"
"#,
    );
    let lines: Vec<&str> = message.lines().map(|line| line.split(": ").next().unwrap()).collect();
    assert_eq!(lines, ["plan.toml:1", "plan.toml:3", "plan.toml:5"]);
}

#[test]
fn files_that_are_no_plan_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let read = |path: &Path| read_plan(path).unwrap_err()[0].to_string();
    assert!(read(&folder.path().join("absent.toml")).contains("absent.toml: cannot be read"));
    assert!(read(folder.path()).contains("is a folder"));
    let bytes = folder.path().join("bytes.toml");
    std::fs::write(&bytes, b"schema = 1\n# caf\xe9\n").unwrap();
    assert!(read(&bytes).contains("bytes.toml:2: is not UTF-8 text"));
    let huge = folder.path().join("huge.toml");
    std::fs::File::create(&huge).unwrap().set_len(5 << 20).unwrap();
    assert!(read(&huge).contains("is larger than 4 MiB"));
}

#[test]
fn the_smallest_plan_has_one_variant_and_every_target() {
    let plan = with("");
    assert_eq!(names(&plan), ["full-taylor-t31"]);
    assert_eq!(plan.targets, Target::all());
    assert_eq!(plan.folder, Path::new("plans"));
    assert!(plan.notes.is_empty() && plan.rejected.is_empty());
    let variant = &plan.variants[0];
    assert_eq!(
        (variant.mode, variant.basis, variant.terms),
        (Mode::Full, Basis::Taylor, Auto::Value(31))
    );
    assert_eq!(variant.wavelengths.nodes_nm().len(), 81);
}

#[test]
fn paths_are_relative_to_the_plan_and_marks_of_other_systems_do_no_harm() {
    let text = "\u{feff}schema = 1\r\n[[surface]]\r\nname = \"a\"\r\nfile = \"scans/a.png\"\r\n";
    let plan = parse(text);
    let SurfaceSource::File(file) = &plan.surfaces[0].source else { panic!("no file") };
    assert_eq!(file.path, Path::new("plans/scans/a.png"));
}

#[test]
fn the_product_varies_its_first_axis_slowest_and_presets_follow() {
    let plan = with(concat!(
        r#"[[preset]]
name = "zz"
terms = 9
"#,
        r#"[variants]
hoist = [true, false]
terms = [5, 3]
basis = ["taylor-zero", "taylor"]
"#,
    ));
    let expected = [
        "full-taylor-zero-t5",
        "full-taylor-zero-t5-nohoist",
        "full-taylor-zero-t3",
        "full-taylor-zero-t3-nohoist",
        "full-taylor-t5",
        "full-taylor-t5-nohoist",
        "full-taylor-t3",
        "full-taylor-t3-nohoist",
        "zz",
    ];
    assert_eq!(names(&plan), expected);
}

#[test]
fn names_hold_what_was_configured_and_stay() {
    for (keys, expected) in [
        ("", "full-taylor-t31"),
        ("terms = \"auto\"", "full-taylor-tauto"),
        ("terms = \"auto\"\nterm_error = 2.5e-4", "full-taylor-tauto-e2p5e-4"),
        ("term_error = 2.5e-4", "full-taylor-t31"),
        ("window_radius = \"auto\"", "full-taylor-t31-rauto"),
        ("window_radius = 2", "full-taylor-t31-r2"),
        ("wavelengths = { step_nm = 2.5 }", "full-taylor-t31-380to780by2p5"),
        ("wavelengths = { min_nm = 550, max_nm = 550 }", "full-taylor-t31-550nm"),
        ("packing = \"single\"\nhoist = false", "full-taylor-t31-single-nohoist"),
        ("coherence_um = 30", "full-taylor-t31-lc30"),
        (
            "coherence = \"ensemble\"\ncoherence_scaling = \"wavelength\"",
            "full-taylor-t31-ensemble-lcwave",
        ),
        ("refractive_index = 1.56\nshadowing = false", "full-taylor-t31-n1p56-noshadow"),
        ("illuminant = \"A\"\ncolour = \"thesis\"", "full-taylor-t31-ill-a-thesis"),
        ("periods = [2, 2]", "full-taylor-t31"),
    ] {
        assert_eq!(names(&with(&format!("[variants]\n{keys}\n"))), [expected], "{keys}");
    }
    // What is configured under [optics] is in the names too, whoever else varies it.
    assert_eq!(names(&with("[optics]\ncoherence_um = 30\n")), ["full-taylor-t31-lc30"]);
    assert_eq!(
        names(&with(
            r#"[optics]
coherence_um = 30
[variants]
coherence_um = [30, 65]
"#
        )),
        ["full-taylor-t31-lc30", "full-taylor-t31"]
    );
    let files =
        with("[variants]\nilluminant = [\"a/lamp.csv\", \"b/lamp.csv\", \"d50\", \"D50\"]\n");
    assert_eq!(
        files.variants.len(),
        4,
        "different files have different names: {:?}",
        names(&files)
    );
    assert!(names(&files)[0].starts_with("full-taylor-t31-ill-lamp-"));
}

#[test]
fn names_and_hashes_tell_configurations_apart() {
    let plan = with(concat!(
        r#"[variants]
basis = ["taylor", "taylor-zero"]
terms = [1, 11, "auto"]
term_error = [1e-3, 1e-4]
"#,
        "window_radius = [1, 11, \"auto\"]\n",
        "wavelengths = [{}, { step_nm = 2 }, { min_nm = 400 }, { min_nm = 500, max_nm = 500, step_nm = 1 }, { min_nm = 500, max_nm = 500, step_nm = 2 }]\n",
        r#"packing = ["paired", "single"]
hoist = [true, false]
coherence_um = [65, 6.5]
refractive_index = [1.5, 1.6]
"#,
    ));
    let mut names: Vec<_> = plan.variants.iter().map(|variant| &variant.name).collect();
    let mut hashes: Vec<_> = plan.variants.iter().map(Variant::hash).collect();
    let count = names.len();
    names.sort();
    names.dedup();
    hashes.sort();
    hashes.dedup();
    assert_eq!((names.len(), hashes.len()), (count, count));
    // term_error is read for "auto" only, the step not for a single wavelength.
    assert_eq!(count, 2 * (1 + 1 + 2) * 3 * 4 * 16);
    assert!(plan.notes.iter().any(|note| {
        note.contains("combinations of [variants] differ only in keys that this mode does not read")
    }));
    let plain = |name: &&String| {
        name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
    };
    assert!(names.iter().all(plain));
}

#[test]
fn the_canonical_text_is_what_the_hash_is_of() {
    let canonical = with("").variants[0].canonical();
    assert_eq!(
        canonical,
        concat!(
            r#"{"basis":"taylor","coherence":"single","coherence_scaling":"fixed","coherence_um":65.0,"colour":"srgb","#,
            r#""hoist":true,"illuminant":"D65","max_nm":780.0,"min_nm":380.0,"mode":"full","packing":"paired","#,
            r#""refractive_index":1.5,"shadowing":true,"step_nm":5.0,"table":"f32","terms":31,"window_radius":1}"#
        )
    );
}

#[test]
fn modes_leave_out_what_they_do_not_read() {
    let plan = with(concat!(
        r#"[variants]
mode = ["full", "baked", "adaptive"]
reconstruction = ["window", "prefiltered"]
"#,
        "wavelengths = [{ step_nm = 5 }, { step_nm = 2.5 }]\nperiods = [\"auto\"]\n",
    ));
    assert_eq!(
        names(&plan),
        [
            "full-taylor-t31",
            "full-taylor-t31-380to780by2p5",
            "full-taylor-t31-prefiltered",
            "full-taylor-t31-prefiltered-380to780by2p5",
            "baked",
            "adaptive-taylor-t31",
            "adaptive-taylor-t31-prefiltered",
        ]
    );
    assert!(plan.rejected.is_empty() && plan.notes.len() == 3, "{:?}", plan.notes);
}

#[test]
fn sampling_counts_where_something_is_read_between_texels() {
    let plan = with(concat!(
        r#"[variants]
mode = ["full", "adaptive", "pq"]
table = ["f16"]
"#,
        "reconstruction = [\"window\", \"prefiltered\"]\nsampling = [\"load\", \"filter\"]\n",
        "window_radius = [1, 2]\n",
    ));
    let prefiltered: Vec<&Variant> = plan.variants.iter().filter(|v| v.reads_between()).collect();
    let names: Vec<&str> = prefiltered.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "full-taylor-t31-prefiltered-f16",
            "full-taylor-t31-prefiltered-f16-filter",
            "adaptive-taylor-t31-prefiltered-f16",
            "adaptive-taylor-t31-prefiltered-f16-filter",
        ],
        "neither a radius nor, without anything between texels, the sampling is read"
    );
    let hashes: BTreeSet<String> = plan.variants.iter().map(Variant::hash).collect();
    assert_eq!(hashes.len(), plan.variants.len());
    for variant in &plan.variants {
        let canonical = variant.canonical();
        assert_eq!(canonical.contains("sampling"), variant.reads_between(), "{canonical}");
        assert_eq!(canonical.contains("reconstruction"), variant.reads_between(), "{canonical}");
        assert_eq!(variant.filters(), variant.name.ends_with("filter"));
    }
}

#[test]
fn presets_take_defaults_and_optics_but_not_the_axes() {
    let plan = with(concat!(
        r#"[optics]
coherence_um = 30
[variants]
terms = [5]
"#,
        r#"[[preset]]
name = "p"
refractive_index = 1.6
[[preset]]
name = "same"
terms = 5
"#,
    ));
    let preset = plan.variant(Some("p")).unwrap();
    assert_eq!(preset.terms, Auto::Value(31));
    assert_eq!((preset.optics.coherence_um, preset.optics.refractive_index), (30.0, 1.6));
    assert_eq!(plan.notes, ["same: has the same configuration as full-taylor-t5-lc30"]);
    assert_eq!(
        names(&with("[[preset]]\nname = \"only\"\n")),
        ["only"],
        "presets alone replace the default variant"
    );
}

#[test]
fn samples_are_counted_as_they_are_taken() {
    for (keys, count) in [
        ("{}", 81),
        ("{ step_nm = 2.5 }", 161),
        ("{ step_nm = 30 }", 15),
        ("{ step_nm = 400 }", 2),
        ("{ min_nm = 380, max_nm = 380 }", 1),
        ("{ min_nm = 400, max_nm = 700, step_nm = 0.1 }", 3001),
    ] {
        let plan = with(&format!("[variants]\nwavelengths = {keys}\n"));
        let waves = plan.variants[0].wavelengths;
        assert_eq!(waves.nodes_nm().len(), count, "{keys}");
    }
}

#[test]
fn the_shortest_wavelength_of_the_variants_sets_the_pitch() {
    let text = |waves: &str| {
        format!(
            "{}[variants]\nwavelengths = {waves}\n",
            SURFACE.replace("pixels = 100", "pixels = 25")
        )
    };
    assert!(errors(&text("{}")).contains("a quarter of the shortest wavelength"));
    parse(&text("{ min_nm = 400 }"));
}

#[test]
fn the_built_in_preset_is_found_by_its_exact_name_only() {
    let plan = with(
        r#"[optics]
coherence_um = 30
[variants]
terms = [3, 5]
"#,
    );
    let texts = plan.variant(Some("texts")).unwrap();
    assert_eq!(
        (texts.basis, texts.terms, texts.packing),
        (Basis::TaylorZero, Auto::Value(31), Packing::Single)
    );
    assert!(
        !texts.hoist
            && texts.optics.coherence_um == 30.0
            && texts.wavelengths.nodes_nm().len() == 81
    );
    let select = |patterns: &[&str]| {
        let patterns: Vec<String> = patterns.iter().map(ToString::to_string).collect();
        plan.select(&patterns).map(|found| found.into_iter().map(|v| v.name).collect::<Vec<_>>())
    };
    assert_eq!(select(&[]).unwrap().len(), 2);
    assert_eq!(select(&["*"]).unwrap().len(), 2);
    assert_eq!(select(&["texts", "*t5*"]).unwrap(), ["full-taylor-t5-lc30", "texts"]);
    assert!(select(&["nothing*"]).unwrap_err().to_string().contains("is not in the plan"));
    assert!(plan.variant(None).unwrap_err().to_string().contains("the plan has 2"));
    assert!(
        plan.variant(Some("full-taylor-t6-lc30")).unwrap_err().to_string().contains("did you mean")
    );
}

#[test]
fn words_of_targets_are_read() {
    assert_eq!(Target::parse("glsl-es300").unwrap(), Target::GlslEs300);
    assert_eq!(Target::parse("hlsl").unwrap(), Target::Hlsl);
    assert_eq!(Target::parse("msl").unwrap(), Target::Msl);
    assert!(Target::parse("wgls").unwrap_err().to_string().contains("did you mean \"wgsl\"?"));
    assert!(Target::all().iter().all(|target| Target::parse(target.as_str()).unwrap() == *target));
}

/// `source_diameter_deg` is another way to write two keys, so that configuration and name are those of the two.
#[test]
fn a_source_diameter_is_a_coherence_length_that_follows_the_wavelength() {
    let parse = |text: &str| {
        let text = format!(
            r#"schema = 1
[[surface]]
name = "a"
grating = {{ kind = "blazed", period_um = 1.0, height_um = 0.02, pixels = 16 }}
{text}
"#
        );
        Plan::parse_all(&text, Path::new("plan.toml"))
    };
    let sun = parse("[optics]\nsource_diameter_deg = 0.53").unwrap();
    let same =
        parse("[optics]\ncoherence_um = 107.062\ncoherence_scaling = \"wavelength\"").unwrap();
    assert_eq!(sun.optics, same.optics);
    assert_eq!(sun.variants, same.variants);
    let axis = parse("[variants]\nsource_diameter_deg = [0.53, 5]").unwrap();
    assert_eq!(axis.variants[0].optics, sun.optics);
    assert!(axis.variants[1].name.contains("lc11p349-lcwave"), "{}", axis.variants[1].name);
    for text in [
        "[optics]\nsource_diameter_deg = 0.53\ncoherence_um = 20",
        "[variants]\nsource_diameter_deg = 0.53\ncoherence_scaling = \"fixed\"",
    ] {
        let errors = parse(text).expect_err("contradicts itself");
        assert!(errors[0].to_string().contains("keep one of the two keys"), "{errors:?}");
    }
    for bad in ["0", "-1", "nan", "200", "\"sun\""] {
        assert!(parse(&format!("[optics]\nsource_diameter_deg = {bad}")).is_err(), "{bad}");
    }
}
