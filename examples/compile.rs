//! Compiles a package in memory, with the library alone: `cargo run --example compile`.

use std::error::Error;
use std::path::Path;

use diffraction_shaders::{Compiler, Plan};

const PLAN: &str = r#"
schema = 1
[[surface]]
name = "cd"
grating = { kind = "lamellar", period_um = 1.6, height_um = 0.12, duty = 0.5, pixels = 64 }
[variants]
mode = ["full", "adaptive"]
[targets]
emit = ["wgsl", "glsl-es300"]
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let plan = Plan::parse(PLAN, Path::new("plan.toml"))?;
    let package = Compiler::new(&plan).compile()?;
    for (path, file) in package.files() {
        println!("{:9} bytes  {path}", file.content.byte_count()?);
    }
    Ok(())
}
