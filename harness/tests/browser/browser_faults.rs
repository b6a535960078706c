//! What a browser refuses, how it ends, and how it opens a page.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use diffraction_harness::drivers::browser::{Api, Browser, Web, check_page};
use diffraction_harness::drivers::{Driver, DriverRunner, Prepared};
use diffraction_shaders::optics::direction;
use diffraction_shaders::runner::{Placement, Runner};
use diffraction_shaders::shader::emit::emit;
use diffraction_shaders::tables::Table;

use crate::support::browser::{blazed, browser, centred, params};

#[test]
fn what_the_browser_refuses_is_an_error_and_the_next_job_works() {
    let Some(browser) = browser() else { return };
    let (variant, height) = (centred("v"), blazed());
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let prepared = Prepared::new(placement).unwrap();
    let module = prepared.module(prepared.spectrum.width).unwrap();
    let tables = [(1, &prepared.terms), (2, &prepared.spectrum)];
    let wide = Table { width: 100_000, height: 1, layers: 1, ..prepared.terms.clone() };
    let wide = Table { texels: vec![0.0; 100_000 * 4], ..wide };
    let short = Table { texels: vec![1.0; 6], ..prepared.terms.clone() };
    for api in Api::ALL {
        let web = browser.api(api).unwrap();
        let files = emit(&module, api.target()).unwrap();
        let compile = |from: &str, to: &str, tables: &[(u32, &Table)]| {
            let mut files = files.clone();
            for file in files.iter_mut().filter(|file| file.functions.is_empty()) {
                let text = String::from_utf8(file.bytes.clone()).unwrap();
                file.bytes = text.replace(from, to).into_bytes();
            }
            web.compile("v", &files, "map", tables)
        };
        let (syntax, table, side) = match api {
            Api::WebGpu => ("diffraction.wgsl:", "2", "8192"),
            Api::WebGl2 => ("diffraction.es300.frag", "no table for", "MAX_TEXTURE_SIZE"),
        };
        for (spoiled, words) in [
            (compile("sqrt(", "sqrrt(", &tables), [syntax, "sqrrt"]),
            (compile("x", "x", &tables[..1]), [table, "2"]),
            (compile("x", "x", &[(1, &wide), tables[1]]), ["100000", side]),
            (compile("x", "x", &[(1, &short), tables[1]]), ["6 numbers", "wrong number"]),
        ] {
            let error = spoiled.unwrap_err().to_string();
            println!("{api}: {error}");
            assert!(error.starts_with("v: "), "{error}");
            assert!(words.iter().all(|word| error.contains(word)), "{error}: {words:?}");
        }
        let error = web.compile("v", &files, "other", &tables).unwrap_err().to_string();
        assert!(error.contains("no emitted file has other"), "{error}");
        let pipeline = compile("x", "x", &tables).unwrap();
        let error = web.draw(&pipeline, [1 << 20, 1], &params(1), &|_| ()).unwrap_err();
        println!("{api}: {error}");
        assert!(error.to_string().contains("1048576"), "{error}");
        assert_eq!(web.draw(&pipeline, [3, 3], &params(3), &|_| ()).unwrap()[4][3], 1.0);
    }
}

#[test]
fn a_browser_that_dies_is_an_error_and_leaves_nothing() {
    let Some(browser) = browser() else { return };
    let (variant, height) = (centred("v"), blazed());
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let runner =
        DriverRunner::with(Prepared::new(placement).unwrap(), browser.api(Api::WebGl2).unwrap());
    let light = direction(20.0, 0.0);
    runner.brdf_map(light, 8).unwrap();
    let (process, profile) = (browser.process(), browser.profile());
    assert!(profile.join("stderr.log").is_file());
    let killed = Command::new("kill").args(["-9", &process.to_string()]).status();
    assert!(killed.unwrap().success());
    let begun = Instant::now();
    let errors = [0, 1].map(|_| runner.brdf_map(light, 8).unwrap_err().to_string());
    assert!(begun.elapsed() < Duration::from_secs(20), "it took {:?}", begun.elapsed());
    for error in errors {
        assert!(error.starts_with("chromium: ended with signal: 9"), "{error}");
    }
    drop((runner, browser));
    assert!(!profile.exists(), "{} is left", profile.display());
}

/// The browser draws in a process of its own, and starts another when that one ends.
#[cfg(target_os = "linux")]
#[test]
fn a_lost_device_is_an_error_and_the_next_program_gets_another() {
    let Some(browser) = browser() else { return };
    let (variant, height) = (centred("v"), blazed());
    let placement = Placement { height: &height, rotate_deg: 0.0, variant: &variant };
    let prepared = Prepared::new(placement).unwrap();
    let module = prepared.module(prepared.spectrum.width).unwrap();
    let tables = [(1, &prepared.terms), (2, &prepared.spectrum)];
    for api in Api::ALL {
        let web = browser.api(api).unwrap();
        let pipeline = web.pipeline(&module, "map", &tables).unwrap();
        let before = web.draw(&pipeline, [9; 2], &params(9), &|_| ()).unwrap();
        kill_gpu_process(&browser.profile());
        let lost = || web.draw(&pipeline, [9; 2], &params(9), &|_| ()).unwrap_err().to_string();
        for error in [lost(), lost()] {
            println!("{api}: {error}");
            assert!(error.starts_with("v: ") && error.contains("was lost"), "{error}");
        }
        // the browser takes its time
        let begun = Instant::now();
        let pipeline = loop {
            match web.pipeline(&module, "map", &tables) {
                Ok(pipeline) => break pipeline,
                Err(e) if begun.elapsed() > Duration::from_secs(30) => panic!("{e}"),
                Err(_) => std::thread::sleep(Duration::from_millis(200)),
            }
        };
        let after = web.draw(&pipeline, [9; 2], &params(9), &|_| ()).unwrap();
        assert_eq!(before, after, "{api}");
    }
}

/// Ends the process that draws for the browser with that profile, and no other.
#[cfg(target_os = "linux")]
fn kill_gpu_process(profile: &Path) {
    let profile = profile.to_str().unwrap();
    let processes = std::fs::read_dir("/proc").unwrap().flatten().filter(|entry| {
        let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line);
        line.contains("--type=gpu-process") && line.contains(profile)
    });
    let found: Vec<String> =
        processes.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    assert_eq!(found.len(), 1, "{found:?}");
    let killed = Command::new("kill").args(["-9", &found[0]]).status();
    assert!(killed.unwrap().success());
}

#[test]
fn what_cannot_be_started_says_what_to_install() {
    let missing = Path::new("no-such-browser");
    let error = Browser::open_program(missing).unwrap_err().to_string();
    assert!(error.contains("no-such-browser does not exist"), "{error}");
    assert!(error.contains("apt-get install chromium"), "{error}");
    if cfg!(unix) {
        let error = Browser::open_program(Path::new("false")).unwrap_err().to_string();
        assert!(error.contains("ended with exit status: 1"), "{error}");
    }
    let Some(_) = browser() else { return };
    let error = Web::open(Api::WebGl2, Some("no such adapter")).unwrap_err().to_string();
    assert!(error.contains("the browser chose"), "{error}");
}

#[test]
fn a_page_is_measured_listened_to_and_seen() {
    if browser().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // an address has to quote this name
    let page = folder.path().join("a page #1.html");
    let body = "<body style='margin: 0; background: #f00'><div style='width: 700px'>wide</div>";
    std::fs::write(&page, format!("<!doctype html>{body}<script>noSuchName()</script>")).unwrap();
    let picture = folder.path().join("picture.png");
    let found = check_page(&page, [390, 300], Some(&picture)).unwrap();
    assert_eq!((found.width, found.scroll_width, found.scroll_height), (390, 700, 300));
    assert_eq!(found.console, ["Uncaught ReferenceError: noSuchName is not defined"]);
    let image = image::open(&picture).unwrap().to_rgb8();
    assert!(image.width() >= 390 && image.height() >= 200, "{:?}", image.dimensions());
    assert_eq!(image.get_pixel(389, 150).0, [255, 0, 0]);

    std::fs::write(&page, "<!doctype html><p>narrow").unwrap();
    let found = check_page(&page, [1280, 720], None).unwrap();
    assert_eq!((found.width, found.scroll_width), (1280, 1280));
    assert!(found.console.is_empty(), "{:?}", found.console);

    let error = check_page(&folder.path().join("none.html"), [390, 300], None).unwrap_err();
    assert!(error.to_string().contains("none.html: cannot be opened"), "{error}");
}
