//! A series that is not good enough on a surface is refused, with what would do.

use std::path::Path;

use diffraction_shaders::plan::{Basis, Grating, Plan, TableFormat, Variant};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::variant::{Form, MAX_PHASE_ERROR};
use diffraction_shaders::{Compiler, Error};

fn blazed(height_um: f64) -> HeightField {
    let grating = Grating::Blazed { period_um: 5.0, height_um, pixels: 100 };
    synthesise(&grating, "blazed").unwrap().field
}

/// A variant from the text of its preset.
fn variant(text: &str) -> Variant {
    let plan = format!(
        "schema = 1\n[[surface]]\nname = \"a\"\ngrating = {{ kind = \"flat\", period_um = 1.0, pixels = 16 }}\n\
         [[preset]]\nname = \"it\"\n{text}"
    );
    Plan::parse(&plan, Path::new("plan.toml")).unwrap().variants.remove(0)
}

fn refusal(text: &str, height: &HeightField) -> Option<Error> {
    Form::new(&variant(text), height).err()
}

/// The number behind a word in a message.
fn number_after(message: &str, word: &str) -> Option<u32> {
    let rest = message.split(word).nth(1)?;
    rest.split(|c: char| !c.is_ascii_digit()).find(|part| !part.is_empty())?.parse().ok()
}

/// From 0.2 to 1.5 µm: what is refused says a count that is accepted, and one less is refused again.
#[test]
fn the_advice_is_the_least_that_passes() {
    for height_um in [0.2, 0.4, 0.6, 0.8, 1.0, 1.5] {
        let height = blazed(height_um);
        for basis in ["taylor", "taylor-zero", "chebyshev", "optimal"] {
            let text = |terms: u32| format!("basis = \"{basis}\"\nterms = {terms}");
            let Some(error) = refusal(&text(2), &height) else {
                panic!("{height_um} {basis}: 2 terms pass");
            };
            let message = error.to_string();
            assert!(message.contains("accept_error"), "{message}");
            let own = number_after(&message, "use terms = ");
            let optimal = number_after(&message, "optimal\", where terms = ");
            match own {
                Some(terms) => {
                    assert!(
                        refusal(&text(terms), &height).is_none(),
                        "{height_um} {basis} {terms}"
                    );
                    assert!(
                        refusal(&text(terms - 1), &height).is_some(),
                        "{height_um} {basis} {terms}"
                    );
                }
                // a Taylor series whose terms cancel in 32 bits
                None => {
                    assert!(basis.starts_with("taylor"), "{message}");
                    let more = refusal(&text(150), &height).unwrap().to_string();
                    assert!(more.contains("cancel"), "{more}");
                }
            }
            if let Some(terms) = optimal {
                let text = format!("basis = \"optimal\"\nterms = {terms}");
                assert!(refusal(&text, &height).is_none(), "{height_um} {terms}");
            }
            assert!(own.is_some() || optimal.is_some(), "{message}");
        }
    }
}

/// What passes has a bound that holds: colours of the twin are near the exact ones in proportion.
#[test]
fn what_is_seen_is_at_most_the_error_of_the_shortest_wavelength() {
    for (height_um, basis, terms) in [
        (0.3, Basis::Taylor, 14),
        (0.3, Basis::Optimal, 4),
        (0.5, Basis::Optimal, 6),
        (0.5, Basis::Chebyshev, 11),
    ] {
        let text = format!("basis = \"{}\"\nterms = {terms}", basis.as_str());
        let form = Form::new(&variant(&text), &blazed(height_um)).unwrap();
        let bound = form.error_bound().unwrap();
        assert!(bound.phase_function_seen <= MAX_PHASE_ERROR, "{text}: {bound:?}");
        assert!(bound.phase_function_seen < bound.phase_function, "{text}: {bound:?}");
        assert!(!bound.accepted);
    }
}

#[test]
fn accepted_errors_are_marked_and_finite() {
    let height = blazed(1.5);
    let form = Form::new(&variant("terms = 19\naccept_error = true"), &height).unwrap();
    let bound = form.error_bound().unwrap();
    assert!(bound.accepted && bound.phase_function > 1e6 && bound.phase_function_seen.is_finite());
    // where nothing is wrong, nothing is marked
    let form = Form::new(&variant("terms = 19\naccept_error = true"), &blazed(0.2)).unwrap();
    assert!(!form.error_bound().unwrap().accepted);
}

#[test]
fn a_search_at_its_end_is_no_answer() {
    let height = blazed(40.0);
    let message = refusal("terms = \"auto\"", &height).unwrap().to_string();
    assert!(message.contains("search for terms ended"), "{message}");
}

#[test]
fn rounding_is_judged_too() {
    let half = format!("terms = 31\ntable = \"{}\"", TableFormat::F16.as_str());
    assert!(refusal(&half, &blazed(0.3)).is_none());
    let message = refusal(&half, &blazed(0.6)).unwrap().to_string();
    assert!(message.contains("cancel") && message.contains("f16"), "{message}");
}

#[test]
fn dust_is_named_with_what_clipping_would_do() {
    let grating = Grating::Sinusoidal { period_um: 1.6, height_um: 0.1, pixels: 32 };
    let line = synthesise(&grating, "sine").unwrap().field;
    let mut heights_um: Vec<f64> =
        line.heights_um().iter().copied().cycle().take(128 * 128).collect();
    for dust in 0..12 {
        heights_um[1000 + 1301 * dust] += 1.6;
    }
    let height = HeightField::new(128, 128, 0.05, 0.05, heights_um).unwrap();
    let message = refusal("terms = 19", &height).unwrap().to_string();
    for part in
        ["12 pixels (0.073 %) are dust or spikes", "clip_percent = 0.1", "which needs terms = 5"]
    {
        assert!(message.contains(part), "{message}");
    }
    // without dust the remedy does not speak of it
    let message = refusal("terms = 3", &blazed(0.3)).unwrap().to_string();
    assert!(!message.contains("dust"), "{message}");
}

/// Wavelengths so far apart that lobes are missed: the probes show it, and the other variant is built.
#[test]
fn colours_that_are_not_the_surfaces_are_a_gap() {
    let text = |more: &str| {
        format!(
            r#"schema = 1
[[surface]]
name = "a"
grating = {{ kind = "blazed", period_um = 2.5, height_um = 0.25, pixels = 60 }}
[variants]
terms = 19
[[preset]]
name = "coarse"
terms = 19
wavelengths = {{ step_nm = 100 }}
{more}
[targets]
emit = "wgsl"
"#
        )
    };
    let compile = |more: &str| {
        let plan = Plan::parse(&text(more), Path::new("plan.toml")).unwrap();
        Compiler::new(&plan).compile().unwrap()
    };
    let package = compile("");
    let [gap] = package.gaps() else { panic!("{:?}", package.gaps()) };
    assert_eq!(gap.variant, "coarse");
    assert!(gap.reason.contains("little to do with the exact ones"), "{}", gap.reason);
    let of = |package: &diffraction_shaders::Package, name: &str| {
        package.files().keys().filter(|path| path.contains(name)).count()
    };
    assert_eq!((of(&package, "/coarse/"), of(&package, "full-taylor-t19/") > 0), (0, true));
    let described = package.files().keys().filter(|path| path.starts_with("surfaces/")).count();
    let accepted = compile("accept_error = true");
    assert!(accepted.gaps().is_empty() && of(&accepted, "/coarse/") > 0);
    // the table of its own is not left behind
    let more = accepted.files().keys().filter(|path| path.starts_with("surfaces/")).count();
    assert!(described < more, "{described} {more}");
}

#[test]
fn a_light_that_nobody_sees_is_refused() {
    let dark = "schema = 1\n[[surface]]\nname = \"a\"\ngrating = { kind = \"flat\", period_um = 1.0, pixels = 16 }\n\
                [[preset]]\nname = \"it\"\nwavelengths = { min_nm = 781, max_nm = 830 }\n";
    let message = Plan::parse(dark, Path::new("plan.toml")).unwrap_err().to_string();
    assert!(message.contains("no visible light"), "{message}");
}
