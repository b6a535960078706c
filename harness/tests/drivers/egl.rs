//! Emitted GLSL on a real GL driver, exactly as emitted, against the f64 twin.

use crate::support::tools;
use std::sync::atomic::{AtomicUsize, Ordering};

use diffraction_harness::drivers::egl::{Dialect, Egl};
use diffraction_harness::drivers::{Driver, DriverRunner, EglRunner, Prepared};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::optics::brdf_map::view_direction;
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{
    Auto, Basis, Grating, Optics, Packing, Reconstruction, Rough, Sampling, Variant,
};
use diffraction_shaders::random::SplitMix64;
use diffraction_shaders::runner::{Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::shader::emit::{EmittedFile, emit};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::tables::Table;
use glam::DVec3;

/// Greatest difference from the twin over the greatest value: arithmetic in 32 bits. 19 terms about the mid-range
/// height reach 5.0e-6, on the grating, towards the horizon.
const CENTRED: f64 = 1.5e-5;
/// The same for the preset `texts`. The terms of its series reach e^z, z = 12 on the deep surface at the shortest
/// wavelength, before they cancel: 12 times the error of the centred series there. That is 5.0e-6 of the greatest value
/// all the same, since colour has little weight at wavelengths so short.
const TEXTS: f64 = 1.5e-5;
/// Deliberate faults have to show by at least this.
const SEEN: f64 = 2e-2;

#[test]
fn both_dialects_agree_with_the_twin() {
    let (centred, texts) = (variant(), Variant::texts(&Optics::standard()));
    for (variant, bound) in [(&centred, CENTRED), (&texts, TEXTS)] {
        let references = surfaces().map(|height| {
            let placement = Placement { height: &height, rotate_deg: 25.0, variant };
            let expected = Results::of(&TwinRunner::new(placement, true).unwrap());
            (height, expected)
        });
        on_both(|egl| {
            let mut worst = 0.0_f64;
            for (height, expected) in &references {
                let placement = Placement { height, rotate_deg: 25.0, variant };
                let runner = EglRunner::new(placement, egl.dialect()).unwrap();
                assert_eq!(runner.route(), egl.dialect().route());
                let [map, probe] = Results::of(&runner).errors(expected);
                println!("{} {}: map {map:.2e}, probe {probe:.2e}", variant.name, egl.dialect());
                worst = worst.max(map).max(probe);
            }
            let name = &variant.name;
            assert!(worst <= bound, "{name}: {worst} is above {bound}");
            assert!(bound <= 4.0 * worst, "{name}: {bound} is too loose for {worst}");
        });
    }
}

#[test]
fn single_wavelengths_agree_with_the_twin() {
    let variant = variant();
    let [_, height, _] = surfaces();
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    // the mirror direction, whose response is near the peak, sets the scale of the tolerance
    let mirror = Directions { wi: DVec3::Z, wr: DVec3::Z };
    let directions = [pairs(), vec![mirror]].concat();
    let expected = TwinRunner::new(placement, true).unwrap().response(&directions, 532.0).unwrap();
    let most = expected.iter().fold(0.0_f64, |a, b| a.max(*b));
    assert!(most > 0.0);
    on_both(|egl| {
        let runner = EglRunner::new(placement, egl.dialect()).unwrap();
        let got = runner.response(&directions, 532.0).unwrap();
        for (got, expected) in got.iter().zip(&expected) {
            assert!((got - expected).abs() <= CENTRED * most, "{got} {expected}");
        }
    });
}

/// A deliberately wrong shader or table must show.
#[test]
fn what_is_wrong_is_seen() {
    type Spoil = fn(&mut Prepared<'_>);
    let spoils: [(&str, Spoil); 5] = [
        ("mirrored u", |prepared| {
            let text = prepared.sources.0.get_mut("gain").unwrap();
            assert!(text.contains("return path;"));
            *text = text.replace("return path;", "return path * vec3f(-1.0, 1.0, 1.0);");
        }),
        ("the weights of the next wavelength", |prepared| {
            let nodes = prepared.spectrum.width;
            for i in 0..nodes - 1 {
                let next = prepared.spectrum.texels[4 * i + 4..4 * i + 7].to_vec();
                prepared.spectrum.texels[4 * i..4 * i + 3].copy_from_slice(&next);
            }
        }),
        ("X for Z", |prepared| {
            prepared.spectrum.texels.chunks_mut(4).for_each(|texel| texel.swap(0, 2));
        }),
        ("the terms upside down", |prepared| {
            let Table { width, height, texels, .. } = &mut prepared.terms;
            let row = *width * 4;
            for layer in texels.chunks_mut(row * *height) {
                let turned: Vec<f64> = layer.chunks(row).rev().flatten().copied().collect();
                layer.copy_from_slice(&turned);
            }
        }),
        ("black", |prepared| prepared.terms.texels.fill(0.0)),
    ];
    let variant = variant();
    // unlike its mirror image on both axes
    let [_, height, _] = surfaces();
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let expected = Results::of(&TwinRunner::new(placement, true).unwrap());
    on_both(|egl| {
        for (what, spoil) in spoils {
            let mut prepared = Prepared::new(placement).unwrap();
            spoil(&mut prepared);
            let [map, probe] =
                Results::of(&DriverRunner::with(prepared, egl.clone())).errors(&expected);
            assert!(map > SEEN && probe > SEEN, "{what}: {map} {probe}");
        }
    });
}

/// Independent of any optics: each pixel says where it is, in several bands.
#[test]
fn row_zero_is_at_the_top() {
    let variant = variant();
    let [height, ..] = surfaces();
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let mut prepared = Prepared::new(placement).unwrap();
    let colour = prepared.sources.0.get_mut("colour").unwrap();
    assert!(colour.contains("return to_rgb(tristimulus(wi, wr));"));
    // what is added is lost in rounding, and keeps every binding alive
    *colour = colour.replace(
        "return to_rgb(tristimulus(wi, wr));",
        "return wr + 1e-30 * to_rgb(tristimulus(wi, wr));",
    );
    let nodes = prepared.sources.0.get_mut("nodes").unwrap();
    assert!(nodes.contains("return factor * xyz;"));
    *nodes = nodes.replace("return factor * xyz;", "return wr + 1e-30 * factor * xyz;");
    on_both(|egl| {
        let module = prepared.module(prepared.spectrum.width).unwrap();
        let tables = [(1, &prepared.terms), (2, &prepared.spectrum)];
        let pipeline = egl.pipeline(&module, "map", &tables).unwrap();
        // not a multiple of the bands, other sizes before and after
        for size in [5_u32, 37, 5] {
            let side = size as f32;
            let params = [0.0, 0.0, 1.0, 0.0, side, side, 0.0, 0.0];
            let done = AtomicUsize::new(0);
            let count = |n: usize| {
                done.fetch_add(n, Ordering::Relaxed);
            };
            let pixels = egl.draw(&pipeline, [size; 2], &params, &count).unwrap();
            assert_eq!(done.into_inner(), (size * size) as usize);
            for (i, pixel) in pixels.iter().enumerate() {
                let (column, row) = (i % size as usize, i / size as usize);
                let wanted = view_direction(column, row, size as usize);
                let wanted = wanted.map_or([0.0; 4], |v| {
                    let v = v.as_vec3();
                    [v.x, v.y, v.z, 1.0]
                });
                for (got, wanted) in pixel.iter().zip(wanted) {
                    assert!((got - wanted).abs() < 1e-5, "{size}: {column},{row}: {pixel:?}");
                }
            }
        }
        // more than one row of the probe's picture
        let runner = DriverRunner::with(prepared.clone(), egl.clone());
        let (wi, turn) = (direction(10.0, 0.0), |i| direction(f64::from(i) * 0.06, f64::from(i)));
        let all: Vec<_> = (0..1300).map(|i| Directions { wi, wr: turn(i) }).collect();
        let got = runner.tristimulus(&all).unwrap();
        assert_eq!(got.len(), all.len());
        for (got, pair) in got.iter().zip(&all) {
            assert!((DVec3::from(*got) - pair.wr).length() < 1e-6, "{got:?} {}", pair.wr);
        }
    });
}

#[test]
fn what_the_driver_refuses_is_an_error_that_names_it() {
    let variant = variant();
    let [height, ..] = surfaces();
    let prepared = Prepared::new(Placement { height: &height, rotate_deg: 0.0, variant: &variant });
    let prepared = prepared.unwrap();
    let module = prepared.module(prepared.spectrum.width).unwrap();
    let tables = [(1, &prepared.terms), (2, &prepared.spectrum)];
    on_both(|egl| {
        let files = emit(&module, egl.dialect().target()).unwrap();
        let map =
            |file: &EmittedFile| file.entry_points.first().is_some_and(|e| e.source_name == "map");
        let compile = |spoil: &dyn Fn(&mut EmittedFile), tables: &[(u32, &Table)]| {
            let mut files = files.clone();
            files.iter_mut().filter(|file| map(file)).for_each(spoil);
            egl.compile("v", &files, "map", tables)
        };
        let replace = |from: &'static str, to: &'static str| {
            move |file: &mut EmittedFile| {
                let text = String::from_utf8(file.bytes.clone()).unwrap();
                assert!(text.contains(from), "{from} in {text}");
                file.bytes = text.replace(from, to).into_bytes();
            }
        };
        let rename = |file: &mut EmittedFile| file.bindings[1].emitted_name += "x";
        let untouched = |_: &mut EmittedFile| ();
        let large = Table { layers: 1_000_000, texels: vec![], ..prepared.terms.clone() };
        let short = Table { texels: vec![1.0; 6], ..prepared.terms.clone() };
        // desktop GL matches by place, ES by name
        let lost = match egl.dialect() {
            Dialect::Glsl450 => {
                replace("layout(location = 0) smooth in", "layout(location = 7) smooth in")
            }
            Dialect::GlslEs300 => replace("_vs2fs_location0", "_vs2fs_location7"),
        };
        let with = |terms| [(1, terms), tables[1]];
        let fragment = files.iter().find(|file| map(file)).unwrap().name.as_str();
        for (spoiled, words) in [
            (compile(&replace("exp(", "expp("), &tables), [fragment, "expp", egl.driver()]),
            (compile(&lost, &tables), [fragment, "not link", "_vs2fs_"]),
            (compile(&rename, &tables), [fragment, "does not know", "x"]),
            (compile(&untouched, &tables[..1]), [fragment, "no table for", "2"]),
            (
                compile(&untouched, &with(&large)),
                ["terms", "1000000", "GL_MAX_ARRAY_TEXTURE_LAYERS"],
            ),
            (compile(&untouched, &with(&short)), ["terms", "6 numbers", "wrong number"]),
        ] {
            let error = spoiled.unwrap_err().to_string();
            assert!(error.starts_with("v: "), "{error}");
            assert!(words.iter().all(|word| error.contains(word)), "{error}: {words:?}");
        }
        let error = egl.compile("v", &files, "other", &tables).unwrap_err().to_string();
        assert!(error.contains("no emitted file has other"), "{error}");
        // and none of it harms what comes after
        let pipeline = compile(&untouched, &tables).unwrap();
        let params = [0.0, 0.0, 1.0, 0.0, 3.0, 3.0, 0.0, 0.0];
        for size in [[1 << 20, 1], [1, 0]] {
            let error = egl.draw(&pipeline, size, &params, &|_| ());
            match error {
                Ok(pixels) => assert_eq!((size, pixels.len()), ([1, 0], 0)),
                Err(e) => assert!(e.to_string().contains("GL_MAX_RENDERBUFFER_SIZE"), "{e}"),
            }
        }
        assert!(egl.draw(&pipeline, [3, 3], &params, &|_| ()).unwrap()[4][3] == 1.0);
    });
}

#[test]
fn runners_are_used_on_any_thread_and_within_each_other() {
    let variant = variant();
    let [height, ..] = surfaces();
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let pairs = &pairs()[..40];
    on_both(|egl| {
        let runner = EglRunner::new(placement, egl.dialect()).unwrap();
        let wanted = runner.tristimulus(pairs).unwrap();
        std::thread::scope(|scope| {
            for dialect in Dialect::ALL {
                let wanted = &wanted;
                scope.spawn(move || {
                    let runner = EglRunner::new(placement, dialect).unwrap();
                    let got = runner.tristimulus(pairs).unwrap();
                    let same = |(a, b): (&[f64; 3], &[f64; 3])| {
                        (DVec3::from(*a) - DVec3::from(*b)).length() < 1e-5
                    };
                    assert!(got.iter().zip(wanted).all(same));
                });
            }
        });
        // the callback of one runner runs another, of another dialect, on the same thread
        let light = direction(20.0, 0.0);
        let wanted = runner.brdf_map(light, 40).unwrap();
        let inner = |_: usize| {
            for dialect in Dialect::ALL {
                let runner = EglRunner::new(placement, dialect).unwrap();
                assert_eq!(runner.brdf_map(light, 40).unwrap().size, 40);
            }
        };
        assert_eq!(runner.brdf_map_with(light, 40, &inner).unwrap(), wanted);
    });
}

/// wgpu closes the display of Mesa that it opened; that must not be the one of a runner that is still in use.
#[test]
fn wgpu_in_the_same_process_does_no_harm() {
    use diffraction_harness::drivers::ShaderRunner;
    use diffraction_harness::drivers::gpu::{Backend, Gpu};
    let variant = variant();
    let [height, ..] = surfaces();
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let light = rounded(direction(20.0, 35.0));
    on_both(|egl| {
        let runner = EglRunner::new(placement, egl.dialect()).unwrap();
        let before = runner.brdf_map(light, 40).unwrap();
        match Gpu::open(Backend::Gl, None) {
            Ok(gpu) => {
                let shader = ShaderRunner::new(placement, gpu).unwrap();
                let wgpu = shader.brdf_map(light, 40).unwrap().disc();
                let most = before.disc().as_flattened().iter().fold(0.0_f64, |a, b| a.max(*b));
                for (a, b) in wgpu.as_flattened().iter().zip(before.disc().as_flattened()) {
                    assert!((a - b).abs() <= CENTRED * most, "{a} {b}");
                }
            }
            Err(e) => println!("NOT RUN: {e}"),
        }
        assert_eq!(runner.brdf_map(light, 40).unwrap(), before);
    });
}

#[test]
fn what_cannot_be_opened_says_what_to_install() {
    for dialect in Dialect::ALL {
        let error = Egl::open(dialect, Some("no such adapter")).unwrap_err().to_string();
        assert!(error.starts_with(dialect.route()) || error.starts_with("EGL"), "{error}");
        assert!(error.contains("libegl1 libgles2 libgl1-mesa-dri"), "{error}");
    }
}

/// Runs `test` in both dialects. A missing driver is a failure where the tools are required, else it is said.
fn on_both(test: impl Fn(&Egl)) {
    for dialect in Dialect::ALL {
        if let Some(egl) = tools::found(Egl::open(dialect, None)) {
            test(&egl);
        }
    }
}

/// 19 terms about the mid-range height, 3 × 3 bins, paired.
fn variant() -> Variant {
    Variant {
        name: "centred".to_owned(),
        basis: Basis::Taylor,
        terms: Auto::Value(19),
        packing: Packing::Paired,
        reconstruction: Reconstruction::Window,
        sampling: Sampling::Load,
        hoist: true,
        ..Variant::texts(&Optics::standard())
    }
}

/// A blazed grating, fingers of 0.1 µm, and fingers as high as the snakes'.
fn surfaces() -> [HeightField; 3] {
    let fingers = |height_um| {
        Grating::Fingers(Rough {
            size_um: 5.0,
            pixels: 64,
            pitch_um: 1.1,
            height_um,
            seed: 1,
            regularity: 0.7,
            length_um: Some(2.4),
        })
    };
    let blazed = Grating::Blazed { period_um: 2.5, height_um: 0.3, pixels: 100 };
    [blazed, fingers(0.1), fingers(0.375)]
        .map(|grating| synthesise(&grating, "surface").unwrap().field)
}

/// 500 pairs of directions, as a shader receives them; a few view along the horizon or below it.
fn pairs() -> Vec<Directions> {
    let mut random = SplitMix64::new(1);
    let mut next = || random.share();
    let mut pair = || Directions {
        wi: rounded(direction(80.0 * next(), 360.0 * next())),
        wr: rounded(direction(92.0 * next(), 360.0 * next())),
    };
    (0..500).map(|_| pair()).collect()
}

/// What is compared of a runner.
struct Results {
    map: Vec<[f64; 3]>,
    probe: Vec<[f64; 3]>,
}

impl Results {
    fn of(runner: &dyn Runner) -> Results {
        let light = rounded(direction(20.0, 35.0));
        Results {
            map: runner.brdf_map(light, 64).unwrap().disc(),
            probe: runner.tristimulus(&pairs()).unwrap(),
        }
    }

    /// Greatest differences over the greatest expected value, of the map and of the probe.
    fn errors(&self, expected: &Results) -> [f64; 2] {
        [(&self.map, &expected.map), (&self.probe, &expected.probe)].map(|(got, expected)| {
            assert_eq!(got.len(), expected.len());
            let (got, expected) = (got.as_flattened(), expected.as_flattened());
            let most = expected.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            assert!(most > 0.0);
            let differences = got.iter().zip(expected).map(|(a, b)| (a - b).abs() / most);
            // what is not a number is as wrong as can be
            differences.fold(0.0, |most, d| if d <= most { most } else { d })
        })
    }
}
