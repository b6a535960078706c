//! Emitted WGSL in a browser's WebGPU and emitted GLSL ES in its WebGL2, exactly as emitted, against the f64 twin.

use std::sync::atomic::{AtomicUsize, Ordering};

use diffraction_harness::drivers::browser::Api;
use diffraction_harness::drivers::{Driver, DriverRunner, Prepared};
use diffraction_shaders::field::reference::Directions;
use diffraction_shaders::optics::brdf_map::view_direction;
use diffraction_shaders::optics::direction;
use diffraction_shaders::plan::{
    Auto, Coherence, Mode, Optics, Packing, Sampling, TableFormat, Variant,
};
use diffraction_shaders::runner::{Placement, Runner, TwinRunner, rounded};
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::surface::synthetic::synthesise;
use diffraction_shaders::tables::basis;
use diffraction_shaders::tables::{Table, TexelFormat};
use diffraction_shaders::variant::{ACROSS, CENTRED};

use crate::support::browser::{blazed, browser, centred, params};

/// Deliberate faults have to show by at least this.
const SEEN: f64 = 100.0 * CENTRED;
const SIZE: usize = 48;

#[test]
fn every_mode_agrees_with_its_twin_and_both_routes_with_each_other() {
    let Some(browser) = browser() else { return };
    let height = blazed();
    let mut worst = [0.0_f64; 3];
    for variant in &variants() {
        let placement = Placement { height: &height, rotate_deg: 25.0, variant };
        let twin = map(&TwinRunner::new(placement, true).unwrap());
        let maps = Api::ALL.map(|api| {
            let web = browser.api(api).unwrap();
            let runner = DriverRunner::with(Prepared::new(placement).unwrap(), web);
            assert_eq!(runner.route(), api.route());
            map(&runner)
        });
        let [gpu, gl] = [&maps[0], &maps[1]].map(|map| difference(map, &twin));
        let apart = difference(&maps[0], &maps[1]);
        println!("{}: webgpu {gpu:.2e}, webgl2 {gl:.2e}, apart {apart:.2e}", variant.name);
        // the last bit of a direction is a small part of a column of the table
        let factor = if variant.mode == Mode::Baked { 5.0 } else { 1.0 };
        let most = factor * CENTRED;
        assert!(gpu <= most && gl <= most, "{}: {gpu} {gl}", variant.name);
        assert!(apart <= factor * ACROSS, "{}: {apart}", variant.name);
        worst.iter_mut().zip([gpu, gl, apart]).for_each(|(most, now)| *most = most.max(now));
    }
    println!("worst: {worst:?}");
}

#[test]
fn texts_agrees_within_its_own_bound() {
    let Some(browser) = browser() else { return };
    let height = blazed();
    let variant = Variant::texts(&Optics::standard());
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let twin = map(&TwinRunner::new(placement, true).unwrap());
    // terms of a series about the lowest height cancel from exp(z H) down to 1, each rounded to 24 bits
    let (low_um, high_um) = height.range_um();
    let z_max = basis::max_z(380.0);
    let bound = (z_max * (high_um - low_um)).exp() * 2.0_f64.powi(-24);
    for api in Api::ALL {
        let web = browser.api(api).unwrap();
        let got = map(&DriverRunner::with(Prepared::new(placement).unwrap(), web));
        let error = difference(&got, &twin);
        println!("texts {api}: {error:.2e} within {bound:.2e}");
        assert!(error <= bound, "{api}: {error} is above {bound}");
    }
}

#[test]
fn listed_directions_and_single_wavelengths_agree_too() {
    let Some(browser) = browser() else { return };
    let height = blazed();
    let variant = centred("centred");
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    // more than one row of the probe's picture
    let pair = |i: u32| Directions {
        wi: rounded(direction(30.0, 0.0)),
        wr: rounded(direction(0.1 * f64::from(i % 650), if i < 650 { 180.0 } else { 0.0 })),
    };
    let pairs: Vec<Directions> = (0..1000).map(pair).collect();
    let twin = TwinRunner::new(placement, true).unwrap();
    let colours = twin.tristimulus(&pairs).unwrap();
    let responses = twin.response(&pairs, 550.0).unwrap();
    assert!(responses.iter().any(|p2| *p2 > 0.1), "no order is met");
    for api in Api::ALL {
        let web = browser.api(api).unwrap();
        let runner = DriverRunner::with(Prepared::new(placement).unwrap(), web);
        let error = difference(&runner.tristimulus(&pairs).unwrap(), &colours);
        assert!(error <= CENTRED, "{api}: {error}");
        for (got, wanted) in runner.response(&pairs, 550.0).unwrap().iter().zip(&responses) {
            assert!((got - wanted).abs() <= CENTRED, "{api}: {got} against {wanted}");
        }
    }
}

/// A deliberately wrong shader, table or light must show.
#[test]
fn what_is_wrong_is_seen() {
    type Spoil = fn(&mut Prepared<'_>);
    let spoils: [(&str, TableFormat, Spoil); 5] = [
        ("black spectrum", TableFormat::F32, |prepared| {
            let nodes = prepared.spectrum.width * 4;
            let nodes = prepared.spectrum.texels[..nodes].chunks_mut(4);
            nodes.for_each(|texel| texel[..3].fill(0.0));
        }),
        ("largest term but the constant dropped", TableFormat::F32, |prepared| {
            drop_largest_term(&mut prepared.terms);
        }),
        ("f16 not scaled", TableFormat::F16, |prepared| {
            // powers of heights in µm, without the factor z^n/n! that terms have here, and without the scales of the format
            let (scale, z) = (prepared.form.series().unwrap().scale(), basis::max_z(380.0));
            let factor = |term: usize| (1..=term).fold(1.0, |f, n| f * z / n as f64);
            let layer = prepared.terms.width * prepared.terms.height * 4;
            for (i, v) in prepared.terms.texels.iter_mut().enumerate() {
                let term = term(i, layer);
                let unit = factor(term) / scale.of(term);
                *v = half::f16::from_f64(*v / unit).to_f64() * unit;
            }
            // as exact as that was: not rounded again
            prepared.terms.format = TexelFormat::Rgba32Float;
        }),
        ("top for bottom", TableFormat::F32, |prepared| {
            let Table { width, height, texels, .. } = &mut prepared.terms;
            let row = *width * 4;
            for layer in texels.chunks_mut(row * *height) {
                let turned: Vec<f64> = layer.chunks(row).rev().flatten().copied().collect();
                layer.copy_from_slice(&turned);
            }
        }),
        ("X for Z", TableFormat::F32, |prepared| {
            let nodes = prepared.spectrum.width * 4;
            prepared.spectrum.texels[..nodes].chunks_mut(4).for_each(|texel| texel.swap(0, 2));
        }),
    ];
    let Some(browser) = browser() else { return };
    // unlike its mirror image on both axes
    let height = fingers();
    for (what, table, spoil) in spoils {
        let variant = Variant { table, ..centred("wrong") };
        let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
        let twin = map(&TwinRunner::new(placement, true).unwrap());
        let mut prepared = Prepared::new(placement).unwrap();
        spoil(&mut prepared);
        for api in Api::ALL {
            let web = browser.api(api).unwrap();
            let error = difference(&map(&DriverRunner::with(prepared.clone(), web)), &twin);
            println!("{what}, {api}: {error:.2e}");
            assert!(error > SEEN, "{what}, {api}: {error}");
        }
    }
    let variant = centred("mirrored");
    let height = blazed();
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let twin = map(&TwinRunner::new(placement, true).unwrap());
    let light = rounded(direction(20.0, 190.0));
    for api in Api::ALL {
        let web = browser.api(api).unwrap();
        let runner = DriverRunner::with(Prepared::new(placement).unwrap(), web);
        let error = difference(&runner.brdf_map(light, SIZE).unwrap().disc(), &twin);
        assert!(error > SEEN, "mirrored u, {api}: {error}");
    }
}

/// Independent of any optics: each pixel says where it is, in several bands.
#[test]
fn row_zero_is_at_the_top() {
    let Some(browser) = browser() else { return };
    let (variant, height) = (centred("places"), blazed());
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let mut prepared = Prepared::new(placement).unwrap();
    let colour = prepared.sources.0.get_mut("colour").unwrap();
    let line = "return to_rgb(tristimulus(wi, wr));";
    assert!(colour.contains(line));
    // what is added is lost in rounding, and keeps every binding alive
    *colour = colour.replace(line, "return wr + 1e-30 * to_rgb(tristimulus(wi, wr));");
    let module = prepared.module(prepared.spectrum.width).unwrap();
    let tables = [(1, &prepared.terms), (2, &prepared.spectrum)];
    for api in Api::ALL {
        let web = browser.api(api).unwrap();
        let pipeline = web.pipeline(&module, "map", &tables).unwrap();
        // not a multiple of the bands, other sizes before and after
        for size in [5_u32, 37, 5] {
            let done = AtomicUsize::new(0);
            let count = |n: usize| {
                done.fetch_add(n, Ordering::Relaxed);
            };
            let pixels = web.draw(&pipeline, [size; 2], &params(size), &count).unwrap();
            assert_eq!(done.into_inner(), (size * size) as usize);
            for (i, pixel) in pixels.iter().enumerate() {
                let (column, row) = (i % size as usize, i / size as usize);
                let wanted = view_direction(column, row, size as usize);
                let wanted = wanted.map_or([0.0; 4], |v| {
                    let v = v.as_vec3();
                    [v.x, v.y, v.z, 1.0]
                });
                for (got, wanted) in pixel.iter().zip(wanted) {
                    assert!((got - wanted).abs() < 1e-5, "{api} {size}: {column},{row}: {pixel:?}");
                }
            }
        }
        assert!(web.draw(&pipeline, [1, 0], &params(1), &|_| ()).unwrap().is_empty());
    }
}

/// All modes, both formats and packings, both readings of coherence.
fn variants() -> Vec<Variant> {
    let ensemble = Optics { coherence: Coherence::Ensemble, ..Optics::standard() };
    let f16 = TableFormat::F16;
    let (single, shared) = (Packing::Single, TableFormat::Rgb9e5);
    vec![
        centred("full"),
        Variant { packing: single, ..centred("full single") },
        Variant { table: f16, ..centred("full f16") },
        Variant { optics: ensemble.clone(), ..centred("full ensemble") },
        Variant { mode: Mode::Pq, window_radius: Auto::Value(3), ..centred("pq") },
        Variant { mode: Mode::Pq, table: f16, packing: single, ..centred("pq f16 single") },
        Variant { mode: Mode::Adaptive, ..centred("adaptive") },
        Variant { mode: Mode::Adaptive, optics: ensemble, ..centred("adaptive ensemble") },
        Variant { mode: Mode::Adaptive, table: f16, packing: single, ..centred("adaptive f16") },
        Variant { mode: Mode::Gems, ..centred("gems") },
        Variant { mode: Mode::Baked, table: shared, bake_mib: 2.0, ..centred("baked") },
        Variant {
            mode: Mode::Baked,
            table: shared,
            bake_mib: 2.0,
            sampling: Sampling::Filter,
            ..centred("baked filtered")
        },
    ]
}

fn fingers() -> HeightField {
    let text = r#"{ "kind": "fingers", "size_um": 5, "pixels": 64, "pitch_um": 1.1, "height_um": 0.3, "seed": 3 }"#;
    synthesise(&serde_json::from_str(text).unwrap(), "fingers").unwrap().field
}

fn map(runner: &dyn Runner) -> Vec<[f64; 3]> {
    runner.brdf_map(rounded(direction(20.0, 10.0)), SIZE).unwrap().disc()
}

/// The term of a number in a table of two complex terms per texel; `layer` is the numbers of a layer.
fn term(number: usize, layer: usize) -> usize {
    2 * (number / layer) + number % 4 / 2
}

/// Sets the term to zero, but for the first, whose numbers are the largest as the shader sees them.
fn drop_largest_term(terms: &mut Table) {
    let layer = terms.width * terms.height * 4;
    let most = |wanted: usize| {
        let numbers = terms.texels.iter().enumerate().filter(|(i, _)| term(*i, layer) == wanted);
        numbers.fold(0.0_f64, |most, (_, v)| most.max(v.abs()))
    };
    let largest = (1..2 * terms.layers).max_by(|a, b| most(*a).total_cmp(&most(*b))).unwrap();
    for (i, v) in terms.texels.iter_mut().enumerate() {
        if term(i, layer) == largest {
            *v = 0.0;
        }
    }
}

/// Greatest difference over the greatest expected value.
fn difference(got: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    assert_eq!(got.len(), expected.len());
    let (got, expected) = (got.as_flattened(), expected.as_flattened());
    let most = expected.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    assert!(most > 0.0);
    let differences = got.iter().zip(expected).map(|(a, b)| (a - b).abs() / most);
    // what is not a number is as wrong as can be
    differences.fold(0.0, |most, d| if d <= most { most } else { d })
}
