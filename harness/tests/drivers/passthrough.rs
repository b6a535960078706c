//! Emitted SPIR-V and HLSL on Vulkan's drivers, untranslated, against the f64 twin and against the other routes.

use crate::support::again::{again, with};
use crate::support::passthrough::{Results, blazed, centred, fingers, texts_bound, variants};
use crate::support::tools::missing;
use diffraction_harness::drivers::egl::{Dialect, Egl};
use diffraction_harness::drivers::gpu::{Backend, Gpu};
use diffraction_harness::drivers::passthrough::{Language, Passthrough};
use diffraction_harness::drivers::{Driver, DriverRunner, Prepared, ShaderRunner};
use diffraction_harness::process::on_path;
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{Basis, Mode, TableFormat, Variant};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner};
use diffraction_shaders::shader::emit::{EmittedFile, emit};
use diffraction_shaders::shader::module;
use diffraction_shaders::tables::{Table, TermScale};
use diffraction_shaders::variant::{ACROSS, CENTRED};

/// Deliberate faults have to show by at least this, in the map and in listed directions: ten times what is let pass.
const SEEN: f64 = 10.0 * CENTRED;

#[test]
fn every_mode_and_form_agrees_with_its_twin() {
    if again("passthrough::every_mode_and_form_agrees_with_its_twin") {
        return;
    }
    let surfaces = [fingers(0.25), blazed()];
    let drivers = drivers();
    let mut wrong = Vec::new();
    for variant in &variants() {
        // the modes and the preset on both, the other forms on the one that fills the map
        let both = ["full", "pq", "gems", "texts"].contains(&variant.name.as_str());
        for (height, rotate_deg) in surfaces.iter().zip([25.0, 0.0]).take(1 + usize::from(both)) {
            let placement = Placement { height, rotate_deg, variant };
            let twin = Results::of(&TwinRunner::new(placement, true).unwrap());
            let bound = match (variant.basis, variant.mode) {
                // the last bit of a direction is a small part of a column of the table
                (_, Mode::Baked) => 5.0 * CENTRED,
                (Basis::TaylorZero, _) => texts_bound(height),
                _ => CENTRED,
            };
            for driver in &drivers {
                let runner = DriverRunner::with(Prepared::new(placement).unwrap(), driver.clone());
                let errors = Results::of(&runner).errors(&twin);
                let what = format!("{} by {}", variant.name, runner.route());
                println!("{what}: map {:.1e}, probe {:.1e} of {bound:.1e}", errors[0], errors[1]);
                if !errors.iter().all(|error| *error <= bound) {
                    wrong.push(format!("{what}: {errors:?}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn all_routes_agree_with_each_other() {
    if again("passthrough::all_routes_agree_with_each_other") {
        return;
    }
    let height = fingers(0.25);
    let mut wrong = Vec::new();
    let compared = ["full", "full-f16-single", "full-ensemble", "pq", "adaptive", "gems"];
    for variant in variants().iter().filter(|v| compared.contains(&v.name.as_str())) {
        let placement = Placement { height: &height, rotate_deg: 25.0, variant };
        let prepared = Prepared::new(placement).unwrap();
        let mut runners: Vec<Box<dyn Runner + '_>> = Vec::new();
        for driver in drivers() {
            if driver.language() == Language::Spirv {
                runners.push(Box::new(DriverRunner::with(prepared.clone(), driver.gpu().clone())));
            }
            runners.push(Box::new(DriverRunner::with(prepared.clone(), driver)));
        }
        match Gpu::open(Backend::Gl, None) {
            Ok(gpu) => runners.push(Box::new(ShaderRunner::new(placement, gpu).unwrap())),
            Err(e) => missing(e),
        }
        for dialect in Dialect::ALL {
            match Egl::open(dialect, None) {
                Ok(egl) => runners.push(Box::new(DriverRunner::with(prepared.clone(), egl))),
                Err(e) => missing(e),
            }
        }
        let results: Vec<_> =
            runners.iter().map(|r| (r.route(), Results::of(r.as_ref()))).collect();
        for (i, (first, expected)) in results.iter().enumerate() {
            for (second, got) in &results[i + 1..] {
                let errors = got.errors(expected);
                let what = format!("{}: {first} and {second}: {errors:?}", variant.name);
                if !errors.iter().all(|error| *error <= ACROSS) {
                    wrong.push(what);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A deliberately wrong shader or table must show by every route.
#[test]
fn what_is_wrong_is_seen() {
    type Spoil = fn(&mut Prepared<'_>);
    if again("passthrough::what_is_wrong_is_seen") {
        return;
    }
    let spoils: [(&str, TableFormat, Spoil); 4] = [
        ("black", TableFormat::F32, |prepared| {
            // the wavelengths stay, which are divided by
            let weights = prepared.spectrum.texels.chunks_mut(4).take(prepared.spectrum.width);
            weights.for_each(|texel| texel[..3].fill(0.0));
        }),
        ("mirrored u", TableFormat::F32, |prepared| {
            let text = prepared.sources.0.get_mut("gain").unwrap();
            assert!(text.contains("return path;"));
            *text = text.replace("return path;", "return path * vec3f(-1.0, 1.0, 1.0);");
        }),
        ("the largest term but the constant dropped", TableFormat::F32, |prepared| {
            let square = |term: usize| -> f64 {
                numbers(&mut prepared.terms.clone(), term).map(|v| *v * *v).sum()
            };
            let terms = 2 * prepared.terms.layers;
            let largest = (1..terms).max_by(|a, b| square(*a).total_cmp(&square(*b))).unwrap();
            assert!(square(largest) > 0.0);
            numbers(&mut prepared.terms, largest).for_each(|v| *v = 0.0);
        }),
        ("f16 unscaled", TableFormat::F16, |prepared| {
            let scale = prepared.form.series().unwrap().scale();
            assert_ne!(scale, TermScale::NONE);
            for term in 0..2 * prepared.terms.layers {
                numbers(&mut prepared.terms, term).for_each(|v| *v *= scale.of(term));
            }
            let second_row = 4 * prepared.spectrum.width;
            prepared.spectrum.texels[second_row + 2..second_row + 4].fill(1.0);
        }),
    ];
    // deep enough to need terms whose scales are far apart
    let height = fingers(0.4);
    for (what, table, spoil) in spoils {
        let variant = Variant { table, ..centred("centred") };
        let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
        let twin = Results::of(&TwinRunner::new(placement, true).unwrap());
        for driver in drivers() {
            let mut prepared = Prepared::new(placement).unwrap();
            spoil(&mut prepared);
            let wrong = DriverRunner::with(prepared, driver);
            let errors = Results::of(&wrong).errors(&twin);
            println!("{what} by {}: {errors:?}", wrong.route());
            assert!(errors.iter().all(|error| *error > SEEN), "{what}: {errors:?}");
        }
    }
}

#[test]
fn wrong_files_are_errors_and_harm_nothing() {
    if again("passthrough::wrong_files_are_errors_and_harm_nothing") {
        return;
    }
    let height = blazed();
    let variant = centred("v");
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let prepared = Prepared::new(placement).unwrap();
    let module = prepared.module(prepared.spectrum.width).unwrap();
    let tables = [(1, &prepared.terms), (2, &prepared.spectrum)];
    for driver in drivers() {
        let files = emit(&module, driver.language().target()).unwrap();
        let compile = |spoil: &dyn Fn(&mut EmittedFile)| {
            let mut files = files.clone();
            files.iter_mut().for_each(spoil);
            driver.compile("v", &files, "map", &tables)
        };
        let refused = |what: &str, spoil: &dyn Fn(&mut EmittedFile), words: &str| {
            let error = compile(spoil).map(|_| ()).expect_err(what).to_string();
            assert!(error.starts_with("v: ") && error.contains(words), "{what}: {error}");
        };
        // the words of these are those of the tool that is installed, or ours
        refused("empty", &|file| file.bytes.clear(), "");
        refused("cut off", &|file| file.bytes.truncate(file.bytes.len() / 8 * 4), "");
        match driver.language() {
            Language::Hlsl => {
                let misspelt = |file: &mut EmittedFile| {
                    let text = String::from_utf8(file.bytes.clone()).unwrap();
                    assert!(text.contains("exp("));
                    file.bytes = text.replace("exp(", "expp(").into_bytes();
                };
                refused("misspelt", &misspelt, "expp");
            }
            Language::Spirv => {
                refused("odd", &|file| file.bytes.truncate(21), "21 bytes");
                refused("noise", &|file| file.bytes[20..].fill(0xa5), "");
                refused("a file for another machine", &|file| file.bytes[..4].reverse(), "");
            }
        }
        let rename = |file: &mut EmittedFile| {
            let fragment = file.entry_points.iter_mut();
            fragment
                .filter(|e| e.stage == module::Stage::Fragment)
                .for_each(|e| e.emitted_name += "x");
        };
        refused("another name", &rename, "mapx");
        // a table that the shader reads and nobody brings
        let error = driver.compile("v", &files, "map", &tables[..1]).unwrap_err().to_string();
        assert!(error.contains("binding 2 of descriptor set 0"), "{error}");
        let short = Table { texels: vec![1.0; 6], ..prepared.terms.clone() };
        let error = driver.compile("v", &files, "map", &[(1, &short), tables[1]]).unwrap_err();
        assert!(error.to_string().contains("texels of"), "{error}");
        let error = driver.compile("v", &files, "other", &tables).unwrap_err().to_string();
        assert!(error.contains("no emitted file has other"), "{error}");
        // and the device is none the worse
        let pipeline = compile(&|_| ()).unwrap();
        let params = [0.0, 0.0, 1.0, 0.0, 3.0, 3.0, 0.0, 0.0];
        assert!(driver.draw(&pipeline, [3, 3], &params, &|_| ()).unwrap()[4][3] == 1.0);
        let error = driver.draw(&pipeline, [1 << 20, 1], &params, &|_| ()).unwrap_err();
        assert!(error.to_string().contains("max_texture_dimension_2d"), "{error}");
    }
}

/// Drivers trust what they get: without `spirv-val` before them, some of these end the process.
#[test]
fn flipped_bits_do_not_bring_the_process_down() {
    if on_path("spirv-val").is_none() {
        return missing("spirv-val; apt-get install spirv-tools");
    }
    if again("passthrough::flipped_bits_do_not_bring_the_process_down") {
        return;
    }
    let (height, variant) = (blazed(), centred("v"));
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let prepared = Prepared::new(placement).unwrap();
    let module = prepared.module(prepared.spectrum.width).unwrap();
    let tables = [(1, &prepared.terms), (2, &prepared.spectrum)];
    for driver in drivers().iter().filter(|driver| driver.language() == Language::Spirv) {
        let mut refused = 0;
        for i in 0..80 {
            let mut files = emit(&module, driver.language().target()).unwrap();
            for file in files.iter_mut().filter(|file| file.name.ends_with(".frag.spv")) {
                let at = (i * 7919) % file.bytes.len();
                file.bytes[at] ^= 1 << (i % 8);
            }
            if let Err(error) = driver.compile("v", &files, "map", &tables) {
                assert!(error.to_string().starts_with("v: "), "{error}");
                refused += 1;
            }
        }
        // the others hit names or numbers
        assert!(refused > 40, "{refused}");
    }
}

#[test]
fn what_cannot_be_opened_says_what_is_missing() {
    for language in Language::ALL {
        let error = Passthrough::open(language, Some("no such adapter")).unwrap_err().to_string();
        let words = ["no adapter whose name contains 'no such adapter'", "glslang-tools"];
        assert!(words.iter().any(|word| error.contains(word)), "{error}");
    }
    // OpenGL takes no SPIR-V by this way
    match Gpu::open(Backend::Gl, None) {
        Ok(gpu) => {
            let (height, variant) = (blazed(), centred("v"));
            let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
            let driver = Passthrough::with(Language::Spirv, gpu).unwrap();
            let runner = DriverRunner::with(Prepared::new(placement).unwrap(), driver);
            let error = runner.brdf_map(direction(20.0, 0.0), 8).unwrap_err().to_string();
            assert!(error.contains("does not take SPIR-V"), "{error}");
        }
        Err(e) => missing(e),
    }
}

#[test]
fn a_missing_compiler_is_named() {
    const NAME: &str = "passthrough::a_missing_compiler_is_named";
    if std::env::var_os("PATH").is_some_and(|path| !path.is_empty()) {
        return with(NAME, "PATH", "");
    }
    let error = Passthrough::open(Language::Hlsl, None).unwrap_err().to_string();
    for word in ["hlsl: ", "glslangValidator is not installed", "glslang-tools"] {
        assert!(error.contains(word), "{error}");
    }
}

/// Every adapter of Vulkan in both languages; lavapipe and SwiftShader must be among them where the tools are required.
fn drivers() -> Vec<Passthrough> {
    let names = Gpu::adapters().into_iter().filter(|info| info.backend == Backend::Vulkan);
    let names: Vec<String> = names.map(|info| info.name).collect();
    for (name, package) in [("llvmpipe", "mesa-vulkan-drivers"), ("SwiftShader", "chromium")] {
        if !names.iter().any(|found| found.contains(name)) {
            missing(format!("no {name}; apt-get install {package} libvulkan1"));
        }
    }
    let mut drivers = Vec::new();
    for name in names {
        let gpu = Gpu::open(Backend::Vulkan, Some(&name)).unwrap();
        for language in Language::ALL {
            match Passthrough::with(language, gpu.clone()) {
                Ok(driver) => drivers.push(driver),
                Err(e) => missing(e),
            }
        }
    }
    drivers
}

/// The numbers of a term in a paired table.
fn numbers(terms: &mut Table, term: usize) -> impl Iterator<Item = &mut f64> {
    let layer = terms.width * terms.height * 4;
    let texels = terms.texels[layer * (term / 2)..].chunks_mut(4).take(layer / 4);
    texels.flat_map(move |texel| &mut texel[2 * (term % 2)..2 * (term % 2) + 2])
}
