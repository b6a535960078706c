//! How much memory work on a variant takes, estimated before it begins.
//!
//! Estimates count what grows with pixels, bins and terms. Each is within 30 % of what was measured on scans of up to 8192²
//! pixels; `cli/tests/memory.rs` measures smaller ones.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::field::orders::OrderSum;
use crate::field::reference::{Reference, Span};
use crate::plan::Variant;
use crate::surface::HeightField;
use crate::tables::{TableSpec, strongest_period_bytes};
use crate::variant::{Form, Ground};

/// What a running program takes before it has read a surface: code, templates, buffers of threads.
const PROGRAM_BYTES: u64 = 48 << 20;
/// Texts of a variant in all languages, with its manifest.
const TEXT_BYTES: u64 = 1 << 20;

/// Memory of one variant on a surface, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// All tables of the variant, as they are on disk and on the device.
    pub table_bytes: u64,
    /// The largest of its tables.
    pub largest_table_bytes: u64,
    /// All tables as 64-bit numbers, as the twin reads them.
    pub texel_bytes: u64,
    /// What computing a table takes at most, beside the heights.
    pub tables_working_bytes: u64,
    /// What the exact colours of the probes take, beside the heights.
    pub probes_bytes: u64,
    /// What exact colours of any directions take, beside the heights.
    pub exact_bytes: u64,
    /// What the radiance under a white sky takes, beside the heights.
    pub sky_bytes: u64,
    /// What finding out how the variant computes takes, beside the heights.
    pub form_bytes: u64,
}

impl Memory {
    /// The memory of a variant on its heights. `threads`: how many work at a time.
    pub fn new(height: &HeightField, variant: &Variant, form: &Form, threads: usize) -> Memory {
        let specs = form.tables(Ground { surface: "", rotate_deg: 0.0 });
        let bytes = |spec: &TableSpec| spec.shape().byte_count() as u64;
        let is_order_sum = specs.iter().any(|spec| matches!(spec, TableSpec::Grating(_)));
        let matter = form.matter();
        let exact = |span| Reference::working_bytes(height, &variant.optics, matter, span);
        Memory {
            table_bytes: specs.iter().map(bytes).sum(),
            largest_table_bytes: specs.iter().map(bytes).max().unwrap_or(0),
            texel_bytes: specs.iter().map(TableSpec::texel_bytes).sum(),
            tables_working_bytes: specs
                .iter()
                .map(|spec| spec.working_bytes(height, threads))
                .max()
                .unwrap_or(0),
            probes_bytes: exact(Span::PROBES),
            exact_bytes: exact(Span::ANYWHERE),
            sky_bytes: if OrderSum::has_white_sky(height, matter) {
                OrderSum::working_bytes(height, matter)
            } else {
                0
            },
            form_bytes: if is_order_sum { strongest_period_bytes(height) } else { 0 },
        }
    }

    /// The most that the compiler takes for the variant beside what it holds anyway: its tables come one after the other, then
    /// exact colours, then the twin. `containers`: number of further files of each table.
    pub fn to_build(&self, containers: usize) -> u64 {
        // a container is encoded from the whole table, and stays until it is written
        let encoded = (containers as u64 + 2) * self.largest_table_bytes;
        let encoded = if containers == 0 { 0 } else { encoded };
        let Memory {
            tables_working_bytes, probes_bytes, texel_bytes, form_bytes, sky_bytes, ..
        } = *self;
        [tables_working_bytes, probes_bytes, texel_bytes, form_bytes, sky_bytes, encoded]
            .into_iter()
            .max()
            .unwrap_or(0)
    }

    /// The most that evaluating the variant takes: exactly and by its twin.
    pub fn to_evaluate(&self) -> u64 {
        self.exact_bytes.max(self.tables_working_bytes + self.texel_bytes).max(self.form_bytes)
    }

    /// The most that drawing the variant takes: its tables as numbers, as bytes, and on a driver that has no memory of its own.
    pub fn to_draw(&self) -> u64 {
        self.texel_bytes + self.tables_working_bytes.max(3 * self.table_bytes)
    }

    /// The most that drawing takes if some colours are first compared with the twin's.
    pub fn to_check_and_draw(&self) -> u64 {
        self.texel_bytes + self.to_draw().max(self.to_evaluate())
    }

    /// The most that comparing takes: the exact colours or a second twin beside the tables to draw.
    pub fn to_compare(&self) -> u64 {
        let twin = self.texel_bytes + self.tables_working_bytes;
        self.texel_bytes + self.exact_bytes.max(twin).max(self.to_draw())
    }
}

/// What a program takes beside work on one variant. `surfaces`: the sum of [`SurfaceInput::held_bytes`](crate::input::SurfaceInput::held_bytes); `variants`: how many variants'
/// texts are in memory.
pub fn around_bytes(surfaces: u64, variants: usize) -> u64 {
    PROGRAM_BYTES + surfaces + TEXT_BYTES * variants as u64
}

/// Refuses work that would take more than a budget, with the numbers and what to do. `needed`: bytes in all.
pub fn within_budget(subject: &str, needed: u64, budget: u64) -> Result<()> {
    if needed <= budget {
        return Ok(());
    }
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    let cause = format!(
        "needs about {:.2} GiB of memory, above the budget of {:.2} GiB",
        gib(needed),
        gib(budget)
    );
    Err(Error::new(subject, cause).remedy(
        "crop the scan or coarsen it with resample_um, use fewer terms or longer wavelengths, or give more with --memory-gib",
    ))
}
