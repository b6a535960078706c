// The page: pickers, knobs, and the one engine that is open.
import { BODIES } from "./bodies.js";
import { facts, short } from "./facts.js";
import { listVariants, loadVariant, openPackage } from "./package.js";
import { lightPad, orbit } from "./pointers.js";
import { probePackage, probeVariant } from "./probe.js";
import { createStage, FIRST_LIGHT } from "./stage.js";
import * as webgl2 from "./webgl2.js";
import * as webgpu from "./webgpu.js";

const APIS = { webgl2, webgpu };
const BODY_NAMES = { snake: "snake", sphere: "sphere", disc: "disc (CD)", map: "BRDF map" };
const API_NAMES = { webgl2: "WebGL2", webgpu: "WebGPU" };

const $ = (id) => document.getElementById(id);
const asked = new URLSearchParams(location.search);
const state = {
  body: "snake", azimuth: 0.35, elevation: 0.45, distance: 4.4, light: FIRST_LIGHT.clone(), stops: -1,
  ratio: Number(asked.get("ratio")) || 0,
};
const stage = createStage(state, showFrame);
const drawDot = lightPad($("pad"), $("dot"), () => stage.toView(state.light), (v) => {
  state.light.copy(stage.toWorld(v));
  changed();
});
let files, places, engine, queue = Promise.resolve(), frame = {}, manifest, firstPicture;

/** For tests and the curious: what is under way, and the probes of all variants. */
window.gallery = {
  ready: start(),
  idle: () => queue.then(() => stage.idle()),
  probe: () => queue.then(() => probePackage(files, engine, APIS[$("api").value].target)),
  /** Milliseconds from the page's beginning to its first picture. */
  firstPicture: () => firstPicture,
  driver: () => engine.driver,
  canvas: () => $("view").firstElementChild,
};

async function start() {
  try {
    files = await openPackage();
    places = await listVariants(files);
    fill($("surface"), unique(places.map((place) => place.surface)), asked.get("surface"));
    await fillVariants(asked.get("variant"));
    fill($("body"), Object.keys(BODIES), asked.get("body"), BODY_NAMES);
    fill($("api"), Object.keys(APIS), asked.get("api"), API_NAMES);
    state.body = $("body").value;
    state.stops = Number(asked.get("stops") ?? state.stops);
    $("stops").value = state.stops;
    connect();
    await show();
  } catch (error) {
    fail(error);
  }
}

function connect() {
  $("panel").addEventListener("submit", (event) => event.preventDefault());
  $("surface").addEventListener("change", () => later(() => fillVariants($("variant").value).then(show)));
  $("variant").addEventListener("change", () => later(show));
  $("api").addEventListener("change", () => later(show));
  $("body").addEventListener("change", () => {
    state.body = $("body").value;
    changed();
  });
  $("stops").addEventListener("input", () => {
    state.stops = Number($("stops").value);
    changed();
  });
  $("check").addEventListener("click", () => later(check));
  new ResizeObserver(() => engine && changed()).observe($("view"));
}

function changed() {
  $("stops-shown").textContent = `${state.stops > 0 ? "+" : ""}${state.stops} stops`;
  drawDot();
  stage.touch().catch(fail);
}

/** One after another: engines and variants are not changed while others are being made. */
function later(work) {
  queue = queue.then(work).catch(fail);
  return queue;
}

async function show() {
  $("message").hidden = true;
  $("checked").textContent = "";
  const api = $("api").value;
  const place = here();
  const variant = await loadVariant(files, place, APIS[api].target);
  manifest = variant.manifest;
  let next = engine;
  let canvas = window.gallery.canvas();
  if (engine?.api !== api) {
    canvas = document.createElement("canvas");
    canvas.tabIndex = 0;
    canvas.setAttribute("aria-label", "the body; arrow keys turn it");
    canvas.setAttribute("role", "img");
    next = { api, ...(await APIS[api].open(canvas)) };
    $("view").replaceChildren(canvas);
    orbit(canvas, state, changed);
  }
  const shown = stage.show(next, canvas, variant);
  engine = next;
  changed();
  await shown;
}

async function fillVariants(wanted) {
  const own = places.filter((place) => place.surface === $("surface").value);
  const read = async (place) => {
    const { cost } = JSON.parse(await files.text(place.folder + "manifest.json"));
    return { name: place.variant, fetches: cost.fetches };
  };
  const costs = await Promise.all(own.map(read));
  // the cheapest first
  costs.sort((a, b) => a.fetches - b.fetches);
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

function showFrame({ ms, width, height }) {
  firstPicture ??= performance.now();
  frame = { ms, width, height };
  const { driver } = engine;
  const list = [...facts(manifest), ["frame", `${short(ms)} ms for ${width} × ${height}`], ["driver", driver]];
  const cells = list.flatMap(([name, text]) => [cell("dt", name), cell("dd", text)]);
  $("facts").replaceChildren(...cells);
}

function cell(tag, text) {
  const made = document.createElement(tag);
  made.textContent = text;
  return made;
}

function fill(select, values, wanted, names = {}) {
  select.replaceChildren(...values.map((value) => new Option(names[value] ?? value, value)));
  if (values.includes(wanted)) select.value = wanted;
}

function unique(values) {
  return [...new Set(values)];
}

function fail(error) {
  $("message").textContent = error.message;
  $("message").hidden = false;
}
