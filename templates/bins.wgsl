//- Twin: src/variant/twin/bins.rs.

#ifdef TABULATED
#ifdef HALF
// The complex amplitude of a bin, divided by the scale of the terms: the sum of coefficient times term. The
// coefficients are linear between the columns of their table.
#else
// The complex amplitude of a bin: the sum of coefficient times term. The coefficients are linear between the columns
// of their table.
#endif
fn bin_amplitude(bin: vec2i, place: f32) -> vec2f {
    let texel = bin + vec2i(CENTRE_COLUMN, CENTRE_ROW);
    let index = min(i32(place), COEFFICIENT_COUNT - 2);
    var sum = vec2f(0.0);
    for (var row = 0; row < COEFFICIENT_ROWS; row++) {
        let before = textureLoad(coefficients, vec2i(index, row), 0);
        let after = textureLoad(coefficients, vec2i(index + 1, row), 0);
        let four = mix(before, after, place - f32(index));
#ifdef PAIRED
        let first = textureLoad(terms, texel, 2 * row, 0);
        sum += four.x * first.xy + four.y * first.zw;
        if (2 * row + 1 < LAYER_COUNT) {
            let second = textureLoad(terms, texel, 2 * row + 1, 0);
            sum += four.z * second.xy + four.w * second.zw;
        }
#else
        sum += four.x * textureLoad(terms, texel, 4 * row, 0).xy;
        if (4 * row + 1 < LAYER_COUNT) {
            sum += four.y * textureLoad(terms, texel, 4 * row + 1, 0).xy;
        }
        if (4 * row + 2 < LAYER_COUNT) {
            sum += four.z * textureLoad(terms, texel, 4 * row + 2, 0).xy;
        }
        if (4 * row + 3 < LAYER_COUNT) {
            sum += four.w * textureLoad(terms, texel, 4 * row + 3, 0).xy;
        }
#endif
    }
    return sum;
}
#else
#ifdef HALF
// The complex amplitude of a bin, divided by the scale of the first term: the sum of τ^n times term n, by Horner's
// rule.
#else
// The complex amplitude of a bin: the sum of τ^n times term n, by Horner's rule.
#endif
fn bin_amplitude(bin: vec2i, tau: f32) -> vec2f {
    let texel = bin + vec2i(CENTRE_COLUMN, CENTRE_ROW);
#ifdef PAIRED
    // even and odd powers side by side
    let tau_squared = tau * tau;
    var sum = vec4f(0.0);
#ifdef LONG_LOOPS
    // four layers in a step, since some drivers limit the steps of all loops
    if (WHOLE_LAYERS + 2 < LAYER_COUNT) {
        sum = textureLoad(terms, texel, WHOLE_LAYERS + 2, 0);
    }
    if (WHOLE_LAYERS + 1 < LAYER_COUNT) {
        sum = sum * tau_squared + textureLoad(terms, texel, WHOLE_LAYERS + 1, 0);
    }
    if (WHOLE_LAYERS < LAYER_COUNT) {
        sum = sum * tau_squared + textureLoad(terms, texel, WHOLE_LAYERS, 0);
    }
    for (var layer = WHOLE_LAYERS - 4; layer >= 0; layer -= 4) {
        sum = sum * tau_squared + textureLoad(terms, texel, layer + 3, 0);
        sum = sum * tau_squared + textureLoad(terms, texel, layer + 2, 0);
        sum = sum * tau_squared + textureLoad(terms, texel, layer + 1, 0);
        sum = sum * tau_squared + textureLoad(terms, texel, layer, 0);
    }
#else
    for (var layer = LAYER_COUNT - 1; layer >= 0; layer--) {
        sum = sum * tau_squared + textureLoad(terms, texel, layer, 0);
    }
#endif
    return sum.xy + tau * sum.zw;
#else
    var sum = vec2f(0.0);
    for (var layer = LAYER_COUNT - 1; layer >= 0; layer--) {
        sum = sum * tau + textureLoad(terms, texel, layer, 0).xy;
    }
    return sum;
#endif
}
#endif
