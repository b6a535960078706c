//! How much memory a command may take.

use diffraction_shaders::plan::Variant;
use diffraction_shaders::surface::HeightField;
use diffraction_shaders::survey::memory::{Memory, around_bytes, within_budget};
use diffraction_shaders::variant::Form;
use sysinfo::System;

/// Share of the available memory that is taken unless the options say otherwise.
const SHARE: f64 = 0.75;

/// The option for memory.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct MemoryArgs {
    /// Refuse work that would take more than N GiB of memory (2³⁰ bytes), by an estimate made beforehand; above 0. Default: three
    /// quarters of the memory that is available, also within the limit of a container.
    #[arg(long, value_name = "N", value_parser = gib)]
    memory_gib: Option<f64>,
}

fn gib(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| *value > 0.0 && value.is_finite());
    value.ok_or_else(|| "expected a number of GiB above 0".to_owned())
}

impl MemoryArgs {
    /// The budget in bytes.
    pub fn budget(&self) -> u64 {
        match self.memory_gib {
            Some(gib) => (gib * f64::from(1 << 30)) as u64,
            None => (SHARE * available() as f64) as u64,
        }
    }

    /// Refuses work on a variant that takes too much. `surfaces`: bytes of all surfaces in memory; `needed`: what the command
    /// needs beside them.
    pub fn check(
        &self,
        surface: &str,
        variant: &str,
        surfaces: u64,
        needed: u64,
    ) -> diffraction_shaders::error::Result<()> {
        let subject = format!("surface {surface}: variant {variant}");
        within_budget(&subject, around_bytes(surfaces, 1) + needed, self.budget())
    }
}

/// The memory of a variant on its heights, on all cores.
pub fn of(height: &HeightField, variant: &Variant) -> diffraction_shaders::error::Result<Memory> {
    let form = Form::new(variant, height)?;
    Ok(Memory::new(height, variant, &form, rayon::current_num_threads()))
}

/// Memory that programs can still have, in bytes: that of the machine, or what is left of a container's.
fn available() -> u64 {
    // a system that does not say is taken to have enough
    let Ok(mut system) = System::new() else { return u64::MAX };
    system.refresh_memory();
    let machine = match system.available_memory() {
        0 => u64::MAX,
        bytes => bytes,
    };
    system.cgroup_limits().map_or(machine, |limits| machine.min(limits.free_memory))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_positive_and_the_default_is_a_share_of_this_machine() {
        assert_eq!(gib("1.5"), Ok(1.5));
        assert!(["0", "-1", "nan", "inf", "", "x"].iter().all(|text| gib(text).is_err()));
        assert_eq!(MemoryArgs { memory_gib: Some(0.5) }.budget(), 1 << 29);
        let mut system = System::new().expect("known");
        system.refresh_memory();
        let default = MemoryArgs::default().budget();
        assert!(default > 1 << 20 && default < system.total_memory(), "{default}");
    }
}
