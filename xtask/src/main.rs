//! Command line of diffraction-shaders.

fn main() -> anyhow::Result<()> {
    let _ = diffraction_shaders::plan::Optics::standard();
    Ok(())
}
