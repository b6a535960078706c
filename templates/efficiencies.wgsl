//- Twin: src/variant/twin/efficiencies.rs.

// Efficiencies |c|² of the orders of the patch, from a table.

// One row for each order. Columns are equal steps of -w/λ. A column holds the efficiency and its slope, per column, at
// its left edge, then the same at its right edge.
@group(0) @binding(1) var efficiencies: texture_2d<f32>;

// Efficiency of an order at w/λ in 1/µm, cubic between the edges of a column. Zero for orders that cannot propagate.
fn efficiency(order: vec2i, turns: f32) -> f32 {
    let reach = vec2i(ORDER_REACH_X, ORDER_REACH_Y);
    if (any(abs(order) > reach)) {
        return 0.0;
    }
#ifdef PATTERN
    let share = clamp(-0.5 * PHASE_MIN_UM * pattern.w * turns, 0.0, 1.0);
    let place = share * f32(EFFICIENCY_COLUMNS);
#else
#ifdef COVER
    let share = clamp(-0.5 * PHASE_MIN_UM * turns, 0.0, 1.0);
    let place = share * f32(EFFICIENCY_COLUMNS);
#else
    let place = clamp(-0.5 * WAVELENGTH_MIN_UM * turns, 0.0, 1.0) * f32(EFFICIENCY_COLUMNS);
#endif
#endif
    let column = min(i32(place), EFFICIENCY_COLUMNS - 1);
    let row = (order.y + reach.y) * (2 * reach.x + 1) + order.x + reach.x;
    let edges = textureLoad(efficiencies, vec2i(column, row), 0);
    let part = place - f32(column);
    let rise = edges.z - edges.x;
    let bend = 3.0 * rise - 2.0 * edges.y - edges.w;
    return edges.x + part * (edges.y + part * (bend + part * (edges.y + edges.w - 2.0 * rise)));
}
