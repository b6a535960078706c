//! Time of `generate` and of writing for 10, 100 and 1000 variants of one surface in all languages:
//! `cargo run --release --example scaling`.

use std::error::Error;
use std::fs;
use std::time::Instant;

use diffraction_shaders::Compiler;
use diffraction_shaders::input;
use diffraction_shaders::package::{Package, Stamp, write};
use diffraction_shaders::plan::Target;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let out = folder.path().join("out");
    println!("variants  generate s  again s  write s  unchanged s      MiB");
    for count in [10, 100, 1000] {
        let path = folder.path().join("plan.toml");
        fs::write(&path, plan(count))?;
        let plan = input::read_plan(&path).map_err(|errors| format!("{errors:?}"))?;
        let cache = folder.path().join("cache");
        let targets = Target::all();
        let compiler = Compiler::new(&plan).targets(&targets).cache(&cache);
        let make = || -> Result<Package, Box<dyn Error>> { Ok(compiler.compile()?) };
        let (_, first_s) = timed(make)?;
        let (package, again_s) = timed(make)?;
        let (written, write_s) = timed(|| Ok(write(&package, &out)?))?;
        let stamp = Stamp::new(&package, String::new(), Vec::new())?;
        let (_, unchanged_s) = timed(|| Ok(stamp.holds(&out)))?;
        let mib = written.bytes as f64 / f64::from(1 << 20);
        println!(
            "{count:8}  {first_s:10.2}  {again_s:7.2}  {write_s:7.2}  {unchanged_s:11.2}  {mib:7.1}"
        );
    }
    Ok(())
}

fn timed<T>(run: impl FnOnce() -> Result<T, Box<dyn Error>>) -> Result<(T, f64), Box<dyn Error>> {
    let start = Instant::now();
    let value = run()?;
    Ok((value, start.elapsed().as_secs_f64()))
}

/// One table for ten variants, which differ in their wavelengths.
fn plan(count: usize) -> String {
    let terms: Vec<String> = (0..count / 10).map(|i| (i % 25 + 4).to_string()).collect();
    let (terms, more) = terms.split_at(terms.len().min(25));
    // beyond 25 numbers of terms: other optics, which need probes of their own
    let indices: Vec<String> =
        (0..=more.len() / 25).map(|i| format!("{:.2}", 1.5 + 0.05 * i as f64)).collect();
    let steps: Vec<String> = (0..10)
        .map(|i| {
            format!(
                "{{ min_nm = 380, max_nm = 780, step_nm = {} }}",
                [2.5, 4.0, 5.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 40.0][i]
            )
        })
        .collect();
    format!(
        "schema = 1\n[[surface]]\nname = \"blazed\"\ngrating = {{ kind = \"blazed\", period_um = 2.5, height_um = 0.3, pixels = 100 }}\n\
         [variants]\nmode = [\"full\"]\nterms = [{}]\nwavelengths = [{}]\nrefractive_index = [{}]\n",
        terms.join(", "),
        steps.join(", "),
        indices.join(", ")
    )
}
