//! A generated package in renderers that are not ours: plain wgpu, OpenGL from Python, three.js in a browser. Each evaluates
//! the package's probes by its own code and must be within their tolerances; each is then wrong on purpose, and must not be.

use crate::support::tools::missing;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use diffraction_harness::drivers::browser::{check_page, drive_page};
use diffraction_shaders::Compiler;
use diffraction_shaders::input;
use diffraction_shaders::light::{Environment, Light, Studio};
use diffraction_shaders::optics::colour_difference::colour_difference;
use diffraction_shaders::package::write;
use diffraction_shaders::runner::{Exact, Placement, Runner};
use glam::DVec3;
use serde_json::{Value, json};

#[path = "../../../examples/wgpu_probe.rs"]
#[allow(dead_code, reason = "an example has a main function")]
mod example;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
/// A wrong integration must be so far beyond tolerance.
const CAUGHT: f64 = 5.0;
/// The variant of the plan that has functions of lights with a size.
const LAMPS: &str = "sun";
/// A change that everybody sees, of a picture's mean, 0 to 255.
const SEEN: f64 = 0.2;

#[test]
fn wgpu_passes_the_probes() {
    let gpu = match example::draw::connect() {
        Ok(gpu) => gpu,
        Err(e) => return missing(format!("wgpu: {e}")),
    };
    let evaluate = |folder: PathBuf| example::run(&gpu, &folder).unwrap();
    let results: Vec<Value> = variants().into_iter().map(evaluate).collect();
    let driver = results[0]["driver"].as_str().unwrap().to_owned();
    assert!(driver.starts_with("vulkan"), "{driver}");
    check("wgpu", &json!(results));
}

#[test]
fn opengl_from_python_passes_the_probes() {
    let python = Path::new(ROOT).join("target/python/bin/python");
    if !python.exists() {
        return missing("target/python with examples/moderngl/requirements.txt");
    }
    let script = Path::new(ROOT).join("examples/moderngl/probe.py");
    let run = Command::new(&python).arg("-B").arg(script).arg(package()).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let found: Value = serde_json::from_slice(&run.stdout).unwrap();
    check(found["driver"].as_str().unwrap(), &found["results"]);
}

#[test]
fn examples_draw_maps() {
    let gpu = match example::draw::connect() {
        Ok(gpu) => gpu,
        Err(e) => return missing(format!("wgpu: {e}")),
    };
    let python = Path::new(ROOT).join("target/python/bin/python");
    if !python.exists() {
        return missing("target/python with examples/moderngl/requirements.txt");
    }
    // all ways to read tables; only `sun` has a table that the map does not read
    let folders = variants()
        .into_iter()
        .filter(|folder| folder.parent().unwrap().ends_with("fingers") || folder.ends_with("sun"));
    let place = tempfile::tempdir().unwrap();
    let script = Path::new(ROOT).join("examples/moderngl/draw.py");
    for folder in folders {
        let name = folder.display();
        let pixels =
            example::draw::run(&gpu, &folder, example::draw::MAP, 256, &[0; 4 * 256 * 256]);
        let by_wgpu = image::RgbaImage::from_raw(256, 256, pixels.unwrap()).unwrap();
        let picture = place.path().join("map.png");
        let run = Command::new(&python).arg("-B").arg(&script).arg(&folder).arg(&picture).output();
        let run = run.unwrap();
        assert!(run.status.success(), "{name}: {}", String::from_utf8_lossy(&run.stderr));
        let by_python = image::open(&picture).unwrap().to_rgba8();
        // the same to a few shades, and not the same upside down
        let differ = |flip: bool| {
            let row = |y: u32| if flip { 255 - y } else { y };
            let pairs =
                by_wgpu.enumerate_pixels().map(|(x, y, p)| (p, by_python.get_pixel(x, row(y))));
            pairs.filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 8)).count()
        };
        println!("{name}: {} pixels differ, {} upside down", differ(false), differ(true));
        // the rim may take part or not
        assert!(differ(false) < 100, "{name}: {} pixels differ", differ(false));
        let asymmetric = folder.parent().unwrap().ends_with("fingers");
        let turned = differ(true);
        assert!(turned > 3000 || !asymmetric, "{name}: {turned} pixels differ upside down");
    }
}

#[test]
fn the_gallery_passes_the_probes_and_reacts() {
    let Some(page) = gallery() else { return };
    for api in ["webgl2", "webgpu"] {
        let address = format!("driver.html?api={api}&surface=fingers");
        let driven = match drive_page(page, &address, Duration::from_secs(240)) {
            Ok(driven) => driven,
            Err(e) => return missing(e),
        };
        let found = driven.posted;
        assert_eq!(found["failed"], Value::Null, "{api}: {}", found["failed"]);
        println!("{api}: {} first picture after {} ms", found["driver"], found["first_picture_ms"]);
        // from the cheapest on, which has a table of colours
        let shown = found["variants"].as_array().unwrap();
        assert!(shown[0].as_str().unwrap().starts_with("baked") && shown.len() >= 3, "{shown:?}");
        assert_eq!(driven.console, Vec::<String>::new(), "{api}");
        assert_eq!((&found["message"], &found["errors"]), (&Value::Null, &json!([])), "{api}");
        assert!(
            found["checked"].as_str().unwrap().contains("144 probes within tolerance"),
            "{found}"
        );
        check(api, &found["probes"]);
        check_studio(api, &found["studio"]);
        // a variant is under what it has functions for, and first under the sun
        for (variant, lights) in found["lights"].as_object().unwrap() {
            let wanted = match variant.as_str() {
                LAMPS => json!(["sun", "lamp", "softbox", "studio", "direction"]),
                "baked" => json!(["sun", "lamp", "direction"]),
                _ => json!(["direction"]),
            };
            assert_eq!(*lights, wanted, "{api}: {variant}");
        }
        assert_eq!(
            (found["lights"].as_object().unwrap().len(), &found["light"]),
            (2, &json!("sun"))
        );
        let changes = found["changes"].as_object().unwrap();
        assert!(changes.len() >= 26, "{api}: {changes:?}");
        for (what, change) in changes {
            let change = change.as_f64().unwrap();
            match what.as_str() {
                "same again"
                | "another renderer and back"
                | "same lamp again"
                | "sizes of another light"
                | "lamp as small as the sun" => {
                    assert!(change < SEEN, "{api}: {what}: {change}");
                }
                // the same light, summed instead of read from a table
                "another variant" => {
                    assert!(change > 0.0 && change < 5.0 * SEEN, "{api}: {what}: {change}");
                }
                // the same irradiance from the same solid angle
                "softbox as large as the lamp" => {
                    assert!(change > SEEN && change < 10.0 * SEEN, "{api}: {what}: {change}");
                }
                _ => assert!(change > SEEN, "{api}: {what} changes the picture by {change} only"),
            }
        }
    }
}

#[test]
fn the_gallery_opens_from_disk_and_fits_a_phone() {
    let Some(page) = gallery() else { return };
    for width in [390, 1280] {
        let picture = page.join(format!("{width}.png"));
        let found = match check_page(&page.join("index.html"), [width, 844], Some(&picture)) {
            Ok(found) => found,
            Err(e) => return missing(e),
        };
        assert_eq!((found.width, found.scroll_width), (width, width));
        assert_eq!(found.console, Vec::<String>::new());
        // the body is there: more than one colour, where only the canvas is
        let picture = image::open(&picture).unwrap().to_rgb8();
        let colours: BTreeSet<[u8; 3]> = picture
            .enumerate_pixels()
            .filter(|(x, y, _)| *x < 300 && *y < 400)
            .map(|(.., p)| p.0)
            .collect();
        assert!(colours.len() > 50, "{width}: {} colours", colours.len());
    }
}

/// Results of all variants are there, within tolerance, and wrong ones are caught.
fn check(who: &str, results: &Value) {
    let results = results.as_array().unwrap();
    let of = |key: &str| -> BTreeSet<&str> {
        results.iter().map(|r| r[key].as_str().unwrap()).collect()
    };
    let (surfaces, names) = (of("surface"), of("variant"));
    assert!(surfaces.len() >= 3 && names.len() >= 3, "{who}: {surfaces:?}, {names:?}");
    assert_eq!(results.len(), variants().len(), "{who}");
    let (mut most, mut lamps) = (0.0_f64, 0);
    for result in results {
        let name = format!("{who}: {} {}", result["surface"], result["variant"]);
        let (mut count, mut functions) = (64, json!({ "diffraction": 64 }));
        let mut controls = BTreeSet::from(["swapped channels", "flipped bitangent"]);
        if result["variant"] == "baked" {
            count += 16;
            functions["diffraction_spread"] = 16.into();
            controls.insert("another size of the light");
        }
        if result["variant"] == LAMPS {
            lamps += 1;
            for shape in ["disc", "disc_coloured", "rectangle", "rectangle_coloured"] {
                count += 16;
                functions[format!("diffraction_{shape}")] = 16.into();
            }
            controls.insert("another size of the light");
            // the example takes the whole shader, whose surroundings are a texture
            if who != "wgpu" {
                count += 16;
                functions["diffraction_environment"] = 16.into();
                controls.extend(["a spread taken for degrees", "mirrored surroundings"]);
            }
        }
        assert_eq!((&result["count"], &result["functions"]), (&json!(count), &functions), "{name}");
        let worst = result["worst"].as_f64().unwrap();
        assert!(worst <= 1.0, "{name}: {worst} times its tolerance");
        most = most.max(worst);
        let found = result["controls"].as_object().unwrap();
        assert_eq!(found.keys().map(String::as_str).collect::<BTreeSet<_>>(), controls, "{name}");
        for (what, beyond) in found {
            // grooves along y are their own mirror image
            if what == "flipped bitangent" && result["surface"] == "blazed" {
                continue;
            }
            let beyond = beyond.as_f64().unwrap();
            assert!(beyond > CAUGHT, "{name}: {what} passes with {beyond} times its tolerance");
        }
    }
    assert!(lamps >= 2, "{who}: {lamps} variants with functions of lights with a size");
    println!("{who}: {} variants, at worst {most:.2e} of the tolerance", results.len());
}

/// The page's studio is the compiler's, seen in the right frame: colours by the engine's own prefiltered map are near the exact
/// ones, and not in a mirror image.
fn check_studio(who: &str, found: &Value) {
    let plan = input::read_plan(&Path::new(ROOT).join("plans/gallery.toml")).unwrap();
    let surface = plan.surfaces.iter().find(|surface| surface.name == "crossed").unwrap();
    let variant = plan.variants.iter().find(|variant| variant.name == LAMPS).unwrap();
    let height = input::load_surface(surface).unwrap().field;
    let panorama = Arc::new(Studio::Softboxes.panorama(512));
    let light = Light::Environment(Environment { panorama, scale: 1.0, rotate_deg: 0.0 });
    let three =
        |key: &str| -> Vec<[f64; 3]> { serde_json::from_value(found[key].clone()).unwrap() };
    let (viewers, seen) = (three("viewers"), three("xyz"));
    let off = |flip: f64| {
        let views: Vec<DVec3> =
            viewers.iter().map(|[x, y, z]| DVec3::new(*x, flip * y, *z)).collect();
        let exact = Exact(Placement { height: &height, rotate_deg: 0.0, variant });
        let exact = exact.under(&light, &views, &|_| ()).unwrap();
        colour_difference("the studio", &exact, &seen, None).unwrap().de2000
    };
    let (right, mirrored) = (off(1.0), off(-1.0));
    println!("{who}: the studio: {right:?}, mirrored {mirrored:?}");
    assert!(right.p95 < 6.0 && mirrored.p95 > 30.0, "{who}: {right:?}, mirrored {mirrored:?}");
}

/// The gallery's package, made once.
fn package() -> &'static Path {
    static PACKAGE: OnceLock<PathBuf> = OnceLock::new();
    PACKAGE.get_or_init(|| {
        let plan = input::read_plan(&Path::new(ROOT).join("plans/gallery.toml")).unwrap();
        // no cache: another build's numbers prove nothing
        let package = Compiler::new(&plan).compile().unwrap_or_else(|e| panic!("{e}"));
        let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gallery-package");
        write(&package, &out).unwrap();
        out
    })
}

fn variants() -> Vec<PathBuf> {
    let below = |folder: &Path| -> Vec<PathBuf> {
        let mut all: Vec<PathBuf> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        all.sort();
        all
    };
    below(&package().join("shaders")).iter().flat_map(|surface| below(surface)).collect()
}

/// The gallery with that package, built once, with the page that drives it; none where node or its modules are missing.
fn gallery() -> Option<&'static Path> {
    static GALLERY: OnceLock<Option<PathBuf>> = OnceLock::new();
    let built = GALLERY.get_or_init(|| {
        let source = Path::new(ROOT).join("gallery");
        if !source.join("node_modules/three").is_dir() {
            missing("gallery/node_modules: npm ci");
            return None;
        }
        let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gallery-page");
        let mut build = Command::new("node");
        build.arg(source.join("build.mjs")).arg("--package").arg(package()).arg("--out").arg(&out);
        let run = build.output().unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        for file in ["driver.html", "driver.js"] {
            fs::copy(source.join("test").join(file), out.join(file)).unwrap();
        }
        Some(out)
    });
    built.as_deref()
}
