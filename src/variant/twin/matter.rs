//! Reflectance and dispersion from rows of the spectrum table in f64; see `templates/matter.wgsl`.

use crate::optics::Facing;
use crate::variant::Coat;

use super::Twin;

/// Reflectance relative to its mean at normal incidence, with the dispersion of the cover's face; 1 for a dielectric in
/// air, whose reflectance is part of the gain.
pub fn reflectance(twin: &Twin<'_>, coat: &Coat, lambda_um: f64, facing: Facing) -> f64 {
    let Some(rows) = &coat.rows else { return 1.0 };
    let first = reflectance_between(twin, coat, lambda_um, facing.cos_half, 1);
    if !coat.matter.is_mixed() {
        return first;
    }
    let second =
        reflectance_between(twin, coat, lambda_um, facing.cos_half, 1 + i64::from(rows.cells()));
    second + facing.s_share * (first - second)
}

/// Phase per height divided by the wave number in air, from that at 550 nm.
pub fn dispersed(twin: &Twin<'_>, coat: &Coat, w: f64, lambda_um: f64) -> f64 {
    match coat.matter.is_dispersive() {
        true => -(w * w + matter_texel(twin, coat, lambda_um, 0)[0]).max(0.0).sqrt(),
        false => w,
    }
}

/// Reflectance from the rows of one polarisation.
fn reflectance_between(
    twin: &Twin<'_>,
    coat: &Coat,
    lambda_um: f64,
    cos_half: f64,
    first: i64,
) -> f64 {
    let cells = coat.rows.as_ref().map_or(1, |rows| rows.cells());
    let least = coat.matter.least_cos_half();
    let place = ((cos_half - least) / (1.0 - least)).clamp(0.0, 1.0) * f64::from(cells);
    let cell = (place as i64).min(i64::from(cells) - 1);
    let part = place - cell as f64;
    let powers = matter_texel(twin, coat, lambda_um, first + cell);
    powers[0] + part * (powers[1] + part * (powers[2] + part * powers[3]))
}

/// A row between the two nearest wavelengths.
fn matter_texel(twin: &Twin<'_>, coat: &Coat, lambda_um: f64, row: i64) -> [f64; 4] {
    let Some(rows) = &coat.rows else { return [0.0; 4] };
    let first = (twin.spectrum.height - rows.rows()) as i64;
    let columns = twin.spectrum.width;
    let column = matter_column(twin, coat, lambda_um);
    let index = (column as i64).min((columns as i64 - 2).max(0));
    let before = twin.spectrum.load(index, first + row, 0);
    let after = twin.spectrum.load((index + 1).min(columns as i64 - 1), first + row, 0);
    let part = column - index as f64;
    std::array::from_fn(|c| before[c] + part * (after[c] - before[c]))
}

/// Place of a wavelength in columns.
fn matter_column(twin: &Twin<'_>, coat: &Coat, lambda_um: f64) -> f64 {
    let Some(rows) = &coat.rows else { return 0.0 };
    let last = (twin.spectrum.width - 1) as f64;
    let [from, to] = rows.range_nm();
    if last == 0.0 { 0.0 } else { ((lambda_um * 1e3 - from) / (to - from)).clamp(0.0, 1.0) * last }
}
