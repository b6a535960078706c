// Reads a generated package through its manifests; no name of a surface, variant or table is known here.

/** What a server may take for a file, milliseconds. */
const PATIENCE_MS = 60000;

/** Whatever answers `text(path)` and `bytes(path)` for paths inside the package. */
export async function openPackage(address = "package/") {
  if (location.protocol === "file:") {
    await loadScript("package.js");
    return fromScript(window.DIFFRACTION_PACKAGE);
  }
  const get = async (path) => {
    const answer = await fetch(address + path, { signal: AbortSignal.timeout(PATIENCE_MS) }).catch((error) => {
      throw new Error(`${address}${path}: ${error.message}`);
    });
    if (!answer.ok) throw new Error(`${address}${path}: ${answer.status} ${answer.statusText}`);
    return answer;
  };
  return {
    text: async (path) => (await get(path)).text(),
    bytes: async (path) => (await get(path)).arrayBuffer(),
  };
}

/** Folders of variants: `{ surface, variant, folder }`, in the order of the index. */
export async function listVariants(files) {
  const index = JSON.parse(await files.text("manifest.json"));
  const folders = Object.keys(index.files).map((path) => path.match(/^(shaders\/([^/]+)\/([^/]+)\/)manifest\.json$/));
  return folders.filter(Boolean).map(([, folder, surface, variant]) => ({ surface, variant, folder }));
}

/**
 * A variant: `{ manifest, text, signature, tables }`. `text` is the function form for `target`, `signature` that of a
 * function in it, if it is there; a table is `{ name, isArray, isFiltered, format, width, height, layers, bytes }`.
 */
export async function loadVariant(files, { folder }, target) {
  const manifest = JSON.parse(await files.text(folder + "manifest.json"));
  const form = manifest.targets[target]?.find((file) => file.functions.length > 0);
  if (!form) throw new Error(`${folder}: no function form for ${target}`);
  const read = async (table) => {
    const shape = JSON.parse(await files.text(resolve(folder, table.description)));
    const { format, width, height, layers } = shape;
    const bytes = await files.bytes(resolve(folder, table.data));
    if (bytes.byteLength !== shape.bytes) throw new Error(`${table.data}: ${bytes.byteLength} bytes for ${shape.bytes}`);
    const { sample_type } = manifest.bindings.find((binding) => binding.name === table.binding);
    const [isArray, isFiltered] = [shape.dimension === "2d-array", sample_type === "float"];
    return { name: table.binding, isArray, isFiltered, format, width, height, layers, bytes };
  };
  const [text, ...tables] = await Promise.all([files.text(folder + form.file), ...manifest.tables.map(read)]);
  const signature = (name) => form.functions.find((f) => f.name === name)?.signature;
  return { manifest, text, signature, tables };
}

/**
 * The probes of a variant, those of lights with a size at the end: `{ calls, vectors, radius, colour, sky, wr, expected, tolerance }`. `calls`
 * is a function, `vectors` are the direction, the axis or the corners, none under a sky; `radius` may be a spread.
 */
export async function loadProbes(files, { folder }) {
  const { probes, lights = [] } = JSON.parse(await files.text(folder + "probe.json"));
  const single = probes.map(({ wi, ...rest }) => ({ calls: "diffraction", vectors: [wi], ...rest }));
  const sized = lights.map(({ wi, axis, corners, spread, ...rest }) => ({ calls: rest.function, vectors: corners ?? [wi ?? axis].filter(Boolean), radius: spread, ...rest }));
  return [...single, ...sized];
}

function resolve(folder, relative) {
  return new URL(relative, "file:///" + folder).pathname.slice(1);
}

function fromScript(inline) {
  const get = (path) => inline[path] ?? Promise.reject(new Error(`${path}: not in package.js`));
  const bytes = async (path) => Uint8Array.from(atob(await get(path)), (c) => c.charCodeAt(0)).buffer;
  return { text: async (path) => get(path), bytes };
}

function loadScript(address) {
  return new Promise((done, failed) => {
    const script = document.createElement("script");
    script.src = address;
    script.onload = done;
    script.onerror = () => failed(new Error(`${address} cannot be loaded`));
    document.head.append(script);
  });
}
