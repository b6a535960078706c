// Uses the gallery as a person would, in a frame, and posts what came of it to `result`. The address may hold `api`, `surface`,
// `variant`, and `pictures`: then what was drawn is posted, too.
const frame = document.querySelector("iframe");
const asked = new URLSearchParams(location.search);
/** Most that a step may take, and all of them, seconds. */
const STEP_S = Number(asked.get("step_s") ?? 100);
const ALL_S = Number(asked.get("all_s") ?? 200);
const RESULT = new URL("result", location.href).href;

// a worker has the clock: also where this page stands still within a call, it posts the step that it stands in
const WATCH = `
let step = "the beginning", doing = "", begun = Date.now(), isOver = false;
const first = begun;
onmessage = ({ data }) => {
  if (data === null) return close();
  if (data.step !== step) begun = Date.now();
  [step, doing] = [data.step, data.doing];
};
setInterval(() => {
  const now = Date.now();
  const late = now - begun > ${1000 * STEP_S} ? "step " + step + doing + " took longer than ${STEP_S} s"
    : now - first > ${1000 * ALL_S} ? "all took longer than ${ALL_S} s, the last step was " + step + doing : null;
  if (late === null || isOver) return;
  isOver = true;
  fetch(${JSON.stringify(RESULT)}, { method: "POST", body: JSON.stringify({ failed: late }) });
}, 250);`;
const watch = new Worker(URL.createObjectURL(new Blob([WATCH], { type: "text/javascript" })));

let current = "the beginning";

/** Says what is being done from now on. */
function step(name) {
  current = name;
  const { gallery } = frame.contentWindow;
  watch.postMessage({ step: current, doing: gallery ? ` (the page: ${gallery.doing()})` : "" });
}
const saying = setInterval(() => step(current), 250);

/** The page, when its first picture is there. */
async function open(query) {
  step("loading the page");
  await new Promise((done) => {
    frame.onload = done;
    frame.src = `index.html?${query}`;
  });
  const page = frame.contentWindow;
  const errors = [];
  page.addEventListener("error", (event) => errors.push(event.message));
  page.addEventListener("unhandledrejection", (event) => errors.push(String(event.reason)));
  const { gallery } = page;
  step("the first picture");
  await gallery.ready;
  // a page without an engine says why
  if (!gallery.canvas()) throw new Error(page.document.getElementById("message").textContent);
  step("the first picture at rest");
  await gallery.idle();
  return { page, gallery, errors, $: (id) => page.document.getElementById(id) };
}

/** What the canvas shows, 64 × 64 pixels over a grey ground, and its PNG where asked for. */
async function picture({ gallery }) {
  await gallery.idle();
  // a canvas of WebGPU can be read as a file, but not be drawn
  const png = gallery.canvas().toDataURL("image/png");
  // an `Image` decodes only while its page is being shown
  const bitmap = await createImageBitmap(await (await fetch(png)).blob());
  const small = new OffscreenCanvas(64, 64).getContext("2d");
  small.fillStyle = "#808080";
  small.fillRect(0, 0, 64, 64);
  small.drawImage(bitmap, 0, 0, 64, 64);
  bitmap.close();
  return { pixels: small.getImageData(0, 0, 64, 64).data, png: asked.has("pictures") ? png : null };
}

/** Mean absolute difference of two pictures, 0 to 255. */
function difference(a, b) {
  return a.pixels.reduce((sum, value, i) => sum + Math.abs(value - b.pixels[i]), 0) / a.pixels.length;
}

/** A value of a picker, or the one after the chosen one. */
function choose(at, id, value) {
  const select = at.$(id);
  select.value = value ?? select.options[(select.selectedIndex + 1) % select.options.length].value;
  select.dispatchEvent(new at.page.Event("change", { bubbles: true }));
}

/** A finger or mouse from one place of an element to another, in parts of its size. */
function drag(at, element, from, to) {
  const box = element.getBoundingClientRect();
  const send = (type, [x, y]) => {
    const [clientX, clientY] = [box.left + x * box.width, box.top + y * box.height];
    const options = { clientX, clientY, pointerId: 1, isPrimary: true, bubbles: true, pointerType: "touch" };
    element.dispatchEvent(new at.page.PointerEvent(type, options));
  };
  // no such pointer exists, so none can be captured
  element.setPointerCapture = () => {};
  element.hasPointerCapture = () => true;
  send("pointerdown", from);
  send("pointermove", to);
  send("pointerup", to);
}

const ACTS = {
  "same again": () => {},
  light: (at) => drag(at, at.$("pad"), [0.5, 0.5], [0.8, 0.35]),
  "light by keys": (at) => press(at, at.$("pad"), "ArrowLeft", 6),
  orbit: (at) => drag(at, at.gallery.canvas(), [0.4, 0.5], [0.6, 0.55]),
  "orbit by keys": (at) => press(at, at.gallery.canvas(), "ArrowLeft", 4),
  nearer: (at) => press(at, at.gallery.canvas(), "+", 3),
  exposure: (at) => slide(at, "stops", Number(at.$("stops").value) + 3),
  sphere: (at) => choose(at, "body", "sphere"),
  variant: (at) => choose(at, "variant"),
  "another variant": (at) => choose(at, "variant"),
  surface: (at) => choose(at, "surface"),
  disc: (at) => choose(at, "body", "disc"),
  map: (at) => choose(at, "body", "map"),
  "light on the map": (at) => drag(at, at.$("pad"), [0.5, 0.5], [0.4, 0.6]),
};

/** Acts on a variant that has functions of lights with a size. Each begins with the light `before`, of the sizes that come with it. */
const LIGHT_ACTS = {
  "lamp for a direction": { before: ["direction"], after: ["lamp", { diameter: 12 }] },
  "wider lamp": { before: ["lamp", { diameter: 12 }], after: ["lamp", { diameter: 24 }] },
  "softbox for a direction": { before: ["direction"], after: ["softbox", { width: 40, height: 20 }] },
  "wider softbox": { before: ["softbox", { width: 40, height: 20 }], after: ["softbox", { width: 70, height: 20 }] },
  "higher softbox": { before: ["softbox", { width: 70, height: 20 }], after: ["softbox", { width: 70, height: 50 }] },
  "same lamp again": { before: ["lamp", { diameter: 12 }], after: ["lamp", { diameter: 12 }] },
  "sizes of another light": { before: ["lamp", { width: 40, height: 20 }], after: ["lamp", { width: 70, height: 50 }] },
  "softbox as large as the lamp": { before: ["lamp", { diameter: 12.5 }], after: ["softbox", { width: 11, height: 11 }] },
  "lamp as small as the sun": { before: ["sun"], after: ["lamp", { diameter: 0.5 }] },
};

/** Unit vectors in a tangent frame, all over the hemisphere down to 75° from the normal. */
const VIEWERS = Array.from({ length: 64 }, (_, i) => {
  const [z, phi] = [1 - ((i + 0.5) / 64) * (1 - Math.cos((75 * Math.PI) / 180)), 2.399963 * i];
  return [Math.sqrt(1 - z * z) * Math.cos(phi), Math.sqrt(1 - z * z) * Math.sin(phi), z];
});

/** Chooses a light and its sizes. */
async function shine(at, [light, sizes = {}]) {
  choose(at, "light", light);
  for (const [id, degrees] of Object.entries(sizes)) slide(at, id, degrees);
  return picture(at);
}

function slide(at, id, value) {
  at.$(id).value = value;
  at.$(id).dispatchEvent(new at.page.Event("input", { bubbles: true }));
}

function lights(at) {
  return [...at.$("light").options].map(({ value }) => value);
}

function press(at, element, key, times) {
  for (let i = 0; i < times; i++) element.dispatchEvent(new at.page.KeyboardEvent("keydown", { key, bubbles: true }));
}

async function run() {
  const at = await open(`ratio=0.3&api=${asked.get("api")}&surface=${asked.get("surface") ?? ""}&variant=${asked.get("variant") ?? ""}`);
  const { gallery } = at;
  const changes = {};
  let before = await picture(at);
  const pictures = { first: before.png };
  const variants = [at.$("variant").value];
  for (const [name, act] of Object.entries(ACTS)) {
    step(name);
    act(at);
    const after = await picture(at);
    changes[name] = difference(before, after);
    pictures[name] = after.png;
    before = after;
    if (!variants.includes(at.$("variant").value)) variants.push(at.$("variant").value);
  }
  const chosen = { [at.$("variant").value]: lights(at) };
  step("a surface for lamps");
  choose(at, "surface", "crossed");
  choose(at, "body", "sphere");
  await picture(at);
  step("a variant for lamps");
  choose(at, "variant", "sun");
  await picture(at);
  chosen.sun = lights(at);
  const first = at.$("light").value;
  for (const [name, { before, after }] of Object.entries(LIGHT_ACTS)) {
    step(`${name}: before`);
    const from = await shine(at, before);
    step(name);
    const to = await shine(at, after);
    changes[name] = difference(from, to);
    pictures[name] = to.png;
  }
  // few pictures: a studio takes a software driver long
  step("studio for a lamp");
  const lamp = await shine(at, ["sun"]);
  const studio = await shine(at, ["studio"]);
  changes["studio for a lamp"] = difference(lamp, studio);
  step("another side of the studio");
  press(at, at.$("pad"), "ArrowLeft", 6);
  const turned = await picture(at);
  changes["another side of the studio"] = difference(studio, turned);
  pictures.studio = turned.png;
  step("sun for the studio");
  before = await shine(at, ["sun"]);
  changes["sun for the studio"] = difference(turned, before);
  pictures.sun = before.png;
  step("the studio towards some viewers");
  const colours = await gallery.probeStudio(VIEWERS);
  step("the probes of all variants");
  const probes = await gallery.probe();
  step("the button of the probes");
  at.$("check").click();
  await gallery.idle();
  const checked = at.$("checked").textContent;
  step("another renderer and back");
  for (const other of ["webgl2", "webgpu", asked.get("api")]) choose(at, "api", other);
  const last = await picture(at);
  changes["another renderer and back"] = difference(before, last);
  const message = at.$("message").hidden ? null : at.$("message").textContent;
  return {
    driver: gallery.driver(), first_picture_ms: gallery.firstPicture(), changes, variants, probes, lights: chosen, light: first,
    studio: { viewers: VIEWERS, xyz: colours }, message, errors: at.errors, checked, pictures,
  };
}

run()
  .catch((error) => ({ failed: error.stack }))
  .then((result) => {
    clearInterval(saying);
    watch.postMessage(null);
    return fetch(RESULT, { method: "POST", body: JSON.stringify(result) });
  });
