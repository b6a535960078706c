// What a manifest says of a variant, for readers.

/** Pairs of names and texts. */
export function facts({ configuration, cost, error_bound: bound, requires, core }) {
  const { coherence, coherence_um, table } = configuration;
  const list = [["coherence", `${coherence ?? "—"}, ${coherence_um} µm`]];
  if (bound) {
    const parts = [bound.phase_function, bound.packing, bound.window_tail].filter(Number.isFinite);
    list.push(["error bound", `${short(Math.max(...parts))} of the peak`]);
    if (Number.isFinite(bound.phase_function)) list.push(["– series", short(bound.phase_function)]);
    if (Number.isFinite(bound.packing)) list.push([`– ${table} tables`, short(bound.packing)]);
    if (Number.isFinite(bound.window_tail)) list.push(["– window", short(bound.window_tail)]);
  } else {
    list.push(["error bound", "none is claimed"]);
  }
  const range = (mean, worst) => (mean === worst ? round(worst) : `${round(mean)} on average, at most ${round(worst)}`);
  list.push(["texels per pixel", range(cost.fetches_mean, cost.fetches)]);
  list.push(["evaluations", range(cost.evaluations_mean, cost.evaluations)]);
  list.push(["tables", `${round(cost.table_bytes / 1024)} KiB`]);
  list.push(["fits", requires.profiles.join(", ") || "no profile"]);
  if (core.diffuser_scale) list.push(["diffuser scale", round(core.diffuser_scale)]);
  return list;
}

/** Two digits. */
export function short(number) {
  return number === 0 ? "0" : Number(number.toPrecision(2)).toString();
}

function round(number) {
  return Number(number.toPrecision(number >= 100 ? 8 : 3)).toLocaleString("en", { maximumFractionDigits: number >= 100 ? 0 : 2 });
}
