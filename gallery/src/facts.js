// What a manifest says of a variant, in words, for readers.

const PROFILES = { webgl2: "WebGL2", webgpu: "WebGPU", vulkan: "Vulkan" };

/** Groups of `{ title, rows }` about one function of a variant; a row is a pair of texts, what and how much. */
export function facts(manifest, name) {
  const lamp = manifest.functions?.find((entry) => entry.name === name);
  return [
    { title: "Stated error", rows: lamp ? lampErrors(lamp) : errors(manifest) },
    { title: "Stated cost of a pixel", rows: lamp ? lampCosts(lamp) : costs(manifest) },
    { title: "Light and table", rows: [["function", signature(lamp?.function ?? manifest.core.function)], ...others(manifest, lamp)] },
  ];
}

/** Name and arguments of a function in WGSL, without types. */
function signature(text) {
  return text.replace(/^fn /, "").replace(/: \w+/g, "").replace(/ -> .*/, "");
}

/** Errors of a function of lights with a size, by what it is under. */
function lampErrors({ errors }) {
  return errors.map(({ under, de2000_p95 }) => [under, `ΔE ${round(de2000_p95)} (CIEDE2000) or less in 95\u00a0% of directions`]);
}

function lampCosts({ cost }) {
  return [
    ["texels read", range(cost.fetches_mean, cost.fetches)],
    ["shares of orders", range(cost.evaluations_mean, cost.evaluations)],
  ];
}

/** Bounds that hold for every direction; where there are none, what the tables were made for. */
function errors({ configuration, error_bound: bound }) {
  if (!bound) {
    const aim = configuration.bake_error;
    if (aim === undefined) return [["bound", "none is stated"]];
    return [
      ["aimed at", `ΔE ${round(aim)} (CIEDE2000) or less in 95\u00a0% of directions`],
      ["bound", "none is stated"],
    ];
  }
  const rows = [
    [`series, ${bound.terms} terms`, bound.phase_function, "of the phase factor"],
    [`rounding to ${configuration.table}`, bound.packing, "of an amplitude"],
    configuration.mode === "pq"
      ? ["between replicas", bound.window_tail, "of the light"]
      : ["cut-off window", bound.window_tail, "of its energy"],
    ["between texels", bound.interpolation, "of an amplitude, rms"],
    ["wavelength nodes", bound.node_alias, "taken for others"],
  ];
  return rows.filter(([, value]) => Number.isFinite(value)).map(([name, value, of]) => [name, `${atMost(value)} ${of}`]);
}

function costs({ cost, lobes, configuration }) {
  const evaluations = range(cost.evaluations_mean, cost.evaluations);
  const rows = [
    ["texels read", range(cost.fetches_mean, cost.fetches)],
    ["amplitudes", configuration.mode === "baked" ? "none, the table holds colours" : evaluations],
  ];
  if (lobes) {
    rows.push(["loops end after", `${round(lobes.candidates)} bins`]);
    const limit = lobes.overlap_limit === null ? "" : ` of at most ${round(lobes.overlap_limit)}`;
    rows.push(["overlap of lobes", `${short(lobes.overlap)}${limit}`]);
  }
  return rows;
}

function others({ configuration, cost, requires, core }, lamp) {
  const { coherence, coherence_um, table } = configuration;
  const kinds = { single: "one coherent patch", ensemble: "mean of many patches" };
  const patches = `${round(coherence_um)} µm, ${kinds[coherence] ?? "replicas of the patch"}`;
  const rows = [["coherence", lamp ? "plays no part: the light itself has a size" : patches]];
  rows.push(["tables", `${round(cost.table_bytes / 2 ** 20)} MiB${table ? `, ${table}` : ""}`]);
  rows.push(["fits", requires.profiles.map((name) => PROFILES[name] ?? name).join(", ") || "no profile"]);
  if (core.diffuser_scale && !lamp) rows.push(["diffuser scale", round(core.diffuser_scale)]);
  return rows;
}

/** Two digits. */
export function short(number) {
  return number === 0 ? "0" : Number(number.toPrecision(2)).toString();
}

/** A share in per cent, or as a power of ten where that has too many zeros. */
function atMost(share) {
  if (share === 0) return "none";
  if (share >= 1e-4) return `≤\u00a0${short(100 * share)}\u00a0%`;
  const [digits, power] = share.toExponential(1).split("e");
  return `≤\u00a0${digits}·10${[...power.replace("+", "")].map((c) => SUPERSCRIPTS[c]).join("")}`;
}

const SUPERSCRIPTS = Object.fromEntries([..."-0123456789"].map((c, i) => [c, "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"[i]]));

function range(mean, worst) {
  if (mean === worst) return round(worst);
  const most = `at most ${round(worst)}`;
  // a light may be too small to be met by the views of the mean
  return round(mean) === "0" ? most : `${round(mean)} on average, ${most}`;
}

function round(number) {
  const maximumFractionDigits = number >= 100 ? 0 : number >= 10 ? 1 : 2;
  return number.toLocaleString("en", { maximumFractionDigits });
}
