//- Twin: src/variant/twin/matter.rs.

// Reflectance and dispersion, from the lowest rows of the table of the spectrum. Columns are equal steps of the
// wavelength.

// Reflectance relative to its mean at normal incidence, with the dispersion of the cover's face. `facing`: cosine between
// half vector and viewer on the relief, and the share of s polarisation.
fn reflectance(lambda_um: f32, facing: vec2f) -> f32 {
    let first = reflectance_between(lambda_um, facing.x, 1);
#ifdef UNPOLARISED
    return mix(reflectance_between(lambda_um, facing.x, 1 + MATTER_CELLS), first, facing.y);
#else
    return first;
#endif
}

#ifdef DISPERSION
// Phase per height divided by the wave number in air, from that at 550 nm; both negative.
fn dispersed(w: f32, lambda_um: f32) -> f32 {
    return -sqrt(max(0.0, w * w + matter_texel(lambda_um, 0).x));
}

#endif
// Reflectance from the rows of one polarisation: a cubic over a cell of the cosine.
fn reflectance_between(lambda_um: f32, cos_half: f32, first: i32) -> f32 {
    let share = clamp((cos_half - MATTER_COSINE) / (1.0 - MATTER_COSINE), 0.0, 1.0);
    let place = share * f32(MATTER_CELLS);
    let cell = min(i32(place), MATTER_CELLS - 1);
    let part = place - f32(cell);
    let powers = matter_texel(lambda_um, first + cell);
    return powers.x + part * (powers.y + part * (powers.z + part * powers.w));
}

// A row between the two nearest wavelengths.
fn matter_texel(lambda_um: f32, row: i32) -> vec4f {
    let column = matter_column(lambda_um);
    let index = min(i32(column), max(MATTER_COLUMNS - 2, 0));
    let next = min(index + 1, MATTER_COLUMNS - 1);
    let before = textureLoad(spectrum, vec2i(index, MATTER_ROW + row), 0);
    let after = textureLoad(spectrum, vec2i(next, MATTER_ROW + row), 0);
    return mix(before, after, column - f32(index));
}

// Place of a wavelength in columns.
fn matter_column(lambda_um: f32) -> f32 {
    return clamp((lambda_um - MATTER_FROM_UM) * MATTER_PACE, 0.0, f32(MATTER_COLUMNS - 1));
}
