// The page: pickers, knobs, and the one engine that is open.
import { BODIES } from "./bodies.js";
import { facts, short } from "./facts.js";
import { drawnBy, LIGHTS, lightsOf } from "./lights.js";
import { listVariants, loadVariant, openPackage } from "./package.js";
import { lightPad, orbit } from "./pointers.js";
import { probePackage, probeStudio, probeVariant } from "./probe.js";
import { createStage, FIRST_LIGHT } from "./stage.js";
import * as webgl2 from "./webgl2.js";
import * as webgpu from "./webgpu.js";

const APIS = { webgl2, webgpu };
const BODY_NAMES = { snake: "snake", sphere: "sphere", disc: "disc (CD)", map: "BRDF map" };
const API_NAMES = { webgl2: "WebGL2", webgpu: "WebGPU" };
const LIGHT_NAMES = Object.fromEntries(Object.entries(LIGHTS).map(([name, { words }]) => [name, words]));

const $ = (id) => document.getElementById(id);
const asked = new URLSearchParams(location.search);
const state = {
  body: "snake", azimuth: radiansAsked("azimuth") ?? 0.1, elevation: radiansAsked("elevation") ?? 0.2, distance: 4, light: FIRST_LIGHT.clone(), stops: numberAsked("stops") ?? 0.5,
  ratio: numberAsked("ratio") ?? 0,
  sizes: { diameter: numberAsked("diameter") ?? 12, width: numberAsked("width") ?? 40, height: numberAsked("height") ?? 20 },
};
const stage = createStage(state, showFrame);
const drawDot = lightPad($("pad"), $("dot"), () => stage.toView(state.light), (v) => {
  state.light.copy(stage.toWorld(v));
  changed();
});
// an engine with its canvas for each interface: browsers allow few contexts, and free them late
const engines = {};
let files, places, engine, queue = Promise.resolve(), manifest, calls, firstPicture, doing = "starting";
// what the visitor would like, also where a variant does not have it
let wishedLight = asked.get("light");

/** For tests and the curious: what is under way, and the probes of all variants. */
window.gallery = {
  ready: start(),
  idle: () => queue.then(() => stage.idle()),
  probe: () => queue.then(() => probePackage(files, engine, APIS[$("api").value].target)),
  /** XYZ in the studio of the variant that is shown, towards unit vectors in a frame whose normal is up. */
  probeStudio: (viewers) => queue.then(() => probeStudio(files, engine, APIS[$("api").value].target, here(), viewers)),
  /** Milliseconds from the page's beginning to its first picture. */
  firstPicture: () => firstPicture,
  /** What it does, or did last. */
  doing: () => doing,
  driver: () => engine.driver,
  canvas: () => engine?.canvas,
};

async function start() {
  try {
    doing = "reading the package's manifests";
    files = await openPackage();
    places = await listVariants(files);
    fill($("surface"), unique(places.map((place) => place.surface)), asked.get("surface") ?? $("surface").dataset.first);
    await fillVariants(asked.get("variant"));
    fill($("body"), Object.keys(BODIES), asked.get("body"), BODY_NAMES);
    fill($("api"), Object.keys(APIS), asked.get("api"), API_NAMES);
    state.body = $("body").value;
    $("stops").value = state.stops;
    for (const size of Object.keys(state.sizes)) {
      $(size).value = state.sizes[size];
      // as the slider allows
      state.sizes[size] = Number($(size).value);
    }
    connect();
    await later(show);
  } catch (error) {
    fail(error);
  }
}

function connect() {
  $("panel").addEventListener("submit", (event) => event.preventDefault());
  $("surface").addEventListener("change", () => later(() => fillVariants($("variant").value).then(show)));
  $("variant").addEventListener("change", () => later(show));
  $("api").addEventListener("change", () => later(show));
  $("light").addEventListener("change", () => {
    wishedLight = $("light").value;
    later(show);
  });
  for (const size of Object.keys(state.sizes)) {
    $(size).addEventListener("input", () => {
      state.sizes[size] = Number($(size).value);
      changed();
    });
  }
  $("body").addEventListener("change", () => {
    state.body = $("body").value;
    changed();
  });
  $("stops").addEventListener("input", () => {
    state.stops = Number($("stops").value);
    changed();
  });
  $("check").addEventListener("click", () => later(check));
  new ResizeObserver(changed).observe($("view"));
}

function changed() {
  label();
  stage.touch().catch(fail);
}

function label() {
  const sign = state.stops > 0 ? "+" : state.stops < 0 ? "−" : "";
  $("stops-shown").textContent = `${sign}${Math.abs(state.stops)} ${Math.abs(state.stops) === 1 ? "stop" : "stops"}`;
  for (const [size, degrees] of Object.entries(state.sizes)) {
    const knob = $(size).closest("label");
    knob.querySelector("output").textContent = `${degrees}°`;
    knob.hidden = !LIGHTS[$("light").value]?.sizes.includes(size);
  }
  drawDot();
}

/** One after another: engines and variants are not changed while others are being made. */
function later(work) {
  queue = queue.then(work).catch(fail);
  return queue;
}

async function show() {
  say("");
  $("checked").textContent = "";
  doing = "opening the renderer";
  const next = await chosenEngine();
  doing = "reading the variant";
  const variant = await loadVariant(files, here(), APIS[next.api].target);
  doing = "ending the last picture";
  await stage.halt();
  doing = "drawing";
  fill($("light"), lightsOf(variant), wishedLight, LIGHT_NAMES);
  try {
    if ($("view").firstElementChild !== next.canvas) $("view").replaceChildren(next.canvas);
    stage.show(next, next.canvas, variant, $("light").value);
    [engine, manifest, calls] = [next, variant.manifest, drawnBy($("light").value, variant)];
  } finally {
    label();
    await stage.resume();
  }
}

/** The engine of the chosen interface, or of the other one, and why. */
async function chosenEngine() {
  const api = $("api").value;
  try {
    return await openEngine(api);
  } catch (error) {
    const other = Object.keys(APIS).find((name) => name !== api);
    const next = await openEngine(other).catch((second) => {
      throw new Error(`${API_NAMES[api]}: ${error.message}. ${API_NAMES[other]}: ${second.message}.`);
    });
    $("api").value = other;
    say(`${API_NAMES[api]} cannot be used here: ${error.message}. ${API_NAMES[other]} draws instead.`);
    return next;
  }
}

async function openEngine(api) {
  if (engines[api]) return engines[api];
  const canvas = document.createElement("canvas");
  canvas.tabIndex = 0;
  canvas.setAttribute("aria-label", "the body; arrow keys turn it, plus and minus come nearer and go away");
  canvas.setAttribute("role", "application");
  const lost = (words) => {
    delete engines[api];
    say(`${words}. Choose a variant or a renderer to begin anew.`);
  };
  engines[api] = { api, canvas, ...(await APIS[api].open(canvas, lost)) };
  orbit(canvas, state, changed);
  return engines[api];
}

async function fillVariants(wanted) {
  const own = places.filter((place) => place.surface === $("surface").value);
  const read = async (place) => {
    const { cost } = JSON.parse(await files.text(place.folder + "manifest.json"));
    return { name: place.variant, cost };
  };
  const costs = await Promise.all(own.map(read));
  // the cheapest first
  costs.sort(({ cost: a }, { cost: b }) => a.fetches - b.fetches || a.table_bytes - b.table_bytes);
  fill($("variant"), costs.map(({ name }) => name), wanted);
}

async function check() {
  $("checked").textContent = "…";
  const { count, worst } = await probeVariant(files, engine, APIS[$("api").value].target, here());
  const verdict = worst <= 1 ? "within tolerance" : "beyond tolerance";
  $("checked").textContent = `${count} probes ${verdict}: at worst ${short(100 * worst)} % of it`;
}

function here() {
  return places.find((place) => place.surface === $("surface").value && place.variant === $("variant").value);
}

function showFrame({ ms, width, height, samples }) {
  firstPicture ??= performance.now();
  const places = samples > 1 ? `, ${samples} places in each pixel` : "";
  const measured = [["frame", `${short(ms)} ms`], ["drawn", `${width} × ${height}${places}`], ["driver", engine.driver]];
  const groups = [{ title: "Here", rows: measured }, ...facts(manifest, calls)];
  $("facts").replaceChildren(...groups.flatMap(({ title, rows }) => [made("h2", title), list(rows)]));
}

function list(rows) {
  const dl = document.createElement("dl");
  dl.append(...rows.flatMap(([name, text]) => [made("dt", name), made("dd", text)]));
  return dl;
}

function made(tag, text) {
  const element = document.createElement(tag);
  element.textContent = text;
  return element;
}

function fill(select, values, wanted, names = {}) {
  select.replaceChildren(...values.map((value) => new Option(names[value] ?? value, value)));
  if (values.includes(wanted)) select.value = wanted;
}

function unique(values) {
  return [...new Set(values)];
}

/** A finite number of the address. */
function numberAsked(name) {
  const number = Number.parseFloat(asked.get(name));
  return Number.isFinite(number) ? number : null;
}

/** Degrees of the address in radians. */
function radiansAsked(name) {
  const degrees = numberAsked(name);
  return degrees === null ? null : (degrees * Math.PI) / 180;
}

function fail(error) {
  say(error.message);
}

function say(words) {
  $("message").textContent = words;
  $("message").hidden = words === "";
}
