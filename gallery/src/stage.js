// One body, one light, one camera: draws when something changed, coarsely while things move and finely at rest.
import { BackSide, BoxGeometry, DoubleSide, FrontSide, Mesh, OrthographicCamera, PerspectiveCamera, Scene, Vector3 } from "three";
import { BODIES } from "./bodies.js";
import { drawnBy, SPREAD, uniformsOf } from "./lights.js";

/** Longest picture while things move, and at rest, milliseconds. */
const MOVING_MS = 70;
const RESTING_MS = 1200;
/** Most places that are evaluated in a pixel, then. */
const MOVING_SAMPLES = 4;
const RESTING_SAMPLES = 16;
/** Least ratio of drawn to CSS pixels. */
const COARSEST = 0.12;
/** Pixels of a picture below which bodies are coarse. */
const FEW_PIXELS = 40000;
/** Time without a change after which things are at rest, milliseconds. */
const REST_MS = 250;
/** What a slow driver does in a moving picture's time: texels fetched. The first picture of a variant trusts nothing else. */
const FETCHES = 2e7;

/**
 * The stage. `state` is `{ body, azimuth, elevation, distance, light, sizes, stops, ratio }`: angles in radians, `light` a unit
 * vector in world space, its `sizes` in degrees, exposure in powers of two, the ratio of drawn to CSS pixels or 0 for what the
 * time allows. `onFrame` gets `{ ms, width, height, samples }`.
 */
export function createStage(state, onFrame) {
  const scene = new Scene();
  const perspective = new PerspectiveCamera(32, 1, 0.1, 20);
  const flat = new OrthographicCamera(-1, 1, 1, -1, 0.1, 20);
  const geometries = {};
  // around the eye, at no distance
  const room = new BoxGeometry(2, 2, 2);
  let engine, made, mesh, behind, canvas;
  let changed = 0, lastMs = 0, ratio = 0, samples = 1;
  let isRunning = false, isDirty = false, isHalting = false;
  let waiting = [];

  function camera() {
    const isMap = state.body === "map";
    const aspect = Math.max(1, canvas?.clientWidth ?? 1) / Math.max(1, canvas?.clientHeight ?? 1);
    if (isMap) {
      const half = 1.05;
      const [x, y] = aspect > 1 ? [half * aspect, half] : [half, half / aspect];
      Object.assign(flat, { left: -x, right: x, top: y, bottom: -y });
      flat.position.set(0, 0, 5);
      flat.lookAt(0, 0, 0);
      flat.updateProjectionMatrix();
      return flat;
    }
    const { azimuth, elevation, distance } = state;
    // narrow views stand back
    const far = distance * Math.max(1, 1.1 / aspect);
    perspective.aspect = aspect;
    perspective.far = far + 4;
    perspective.up.set(0, Math.cos(elevation) < 0 ? -1 : 1, 0);
    perspective.position.set(Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation), Math.cos(azimuth) * Math.cos(elevation));
    perspective.position.multiplyScalar(far);
    perspective.lookAt(0, 0, 0);
    perspective.updateProjectionMatrix();
    return perspective;
  }

  /** Takes the finest picture within a time, by the last one; the first one's is a guess by what a pixel costs. */
  function plan(ms, mostSamples, least) {
    const finest = window.devicePixelRatio || 1;
    if (state.ratio) [ratio, samples] = [state.ratio, 1];
    else {
      const pixels = Math.max(1, canvas.clientWidth * canvas.clientHeight);
      // evaluations for a CSS pixel
      const wanted = lastMs ? (ratio * ratio * samples * ms) / lastMs : FETCHES / made.fetches / pixels;
      const density = Math.max(least, wanted);
      ratio = Math.min(finest, Math.max(COARSEST, Math.sqrt(density)));
      samples = Math.min(made.isCalm ? 1 : mostSamples, Math.max(1, Math.floor(density / ratio ** 2)));
    }
    return ratio >= finest && (made.isCalm || samples === mostSamples);
  }

  function geometry(name, isCoarse) {
    return (geometries[`${name} ${isCoarse}`] ??= BODIES[name](isCoarse));
  }

  async function draw() {
    const { renderer } = engine;
    renderer.setPixelRatio(ratio);
    renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
    const name = state.body;
    mesh.geometry = geometry(name, canvas.width * canvas.height < FEW_PIXELS);
    // of closed bodies nobody sees the inside
    made.material.side = ["snake", "sphere"].includes(name) ? FrontSide : DoubleSide;
    const view = camera();
    if (behind) {
      behind.position.copy(view.position);
      behind.visible = name !== "map";
    }
    const light = uniformsOf(made.lightName, state.light, state.sizes, made.diffuser, made.calls);
    made.set({ ...light, eye: view.position, exposure: 2 ** state.stops, is_map: name === "map", samples });
    const begun = performance.now();
    await engine.draw(scene, view);
    // clocks of browsers are coarse
    const ms = Math.max(0.1, performance.now() - begun);
    const { width, height } = canvas;
    // the first picture contains the driver's compiler
    if (made.isWarm) lastMs = ms;
    made.isWarm = true;
    onFrame({ ms, width, height, samples });
  }

  async function run() {
    if (isRunning || isHalting || !made) return;
    isRunning = true;
    try {
      // a hidden canvas has no size and no picture; whoever shows it says that something changed
      while (canvas.clientWidth > 0 && canvas.clientHeight > 0) {
        isDirty = false;
        const isResting = performance.now() - changed > REST_MS;
        const isMeasured = lastMs > 0;
        const isFinest = isResting && isMeasured
          ? plan(RESTING_MS, RESTING_SAMPLES, ratio * ratio * samples)
          : plan(MOVING_MS, MOVING_SAMPLES, 0);
        await draw();
        if (isHalting) break;
        if (isDirty || (!isMeasured && !state.ratio)) continue;
        if (state.ratio) break;
        if (!isResting) await new Promise((done) => setTimeout(done, REST_MS));
        // some of the time does not depend on the pixels: so the finest is reached in steps
        else if (lastMs > RESTING_MS / 2 || isFinest) break;
      }
    } finally {
      isRunning = false;
      // also after an error, which whoever called gets
      waiting.forEach((done) => done());
      waiting = [];
    }
  }

  /** Resolves when the picture is as fine as it gets, or cannot be drawn. */
  const idle = () => (isRunning ? new Promise((done) => waiting.push(done)) : Promise.resolve());

  /** No picture is on its way, and none begins before [`resume`]: what it draws with may be thrown away. */
  async function halt() {
    isHalting = true;
    while (isRunning) await idle();
  }

  function touch() {
    changed = performance.now();
    isDirty = true;
    return run();
  }

  return {
    /** Something in the state changed. */
    touch,
    idle,
    halt,
    /** After [`halt`], also where nothing new is shown. */
    resume() {
      isHalting = false;
      return touch();
    },
    /** Takes another engine with its canvas, or another variant or light on it; to be called between [`halt`] and [`resume`]. */
    show(newEngine, newCanvas, variant, lightName) {
      made?.dispose();
      made = null;
      [engine, canvas] = [newEngine, newCanvas];
      const calls = drawnBy(lightName, variant);
      const { core, cost, functions = [] } = variant.manifest;
      const next = engine.material(variant, calls);
      // arithmetic counts, too
      next.fetches = 50 + (functions.find(({ name }) => name === calls)?.cost ?? cost).fetches;
      next.lightName = lightName;
      // lobes are as wide as a pixel's footprint
      next.isCalm = calls === SPREAD;
      next.calls = calls;
      next.diffuser = core.diffuser_scale ?? 1;
      lastMs = 0;
      scene.clear();
      mesh = new Mesh(undefined, next.material);
      mesh.frustumCulled = false;
      scene.add(mesh);
      behind = null;
      if (next.behind) {
        Object.assign(next.behind, { side: BackSide, depthTest: false, depthWrite: false });
        behind = new Mesh(room, next.behind);
        behind.frustumCulled = false;
        behind.renderOrder = -1;
        scene.add(behind);
      }
      made = next;
    },
    /** From view space, x right, y up, z to the viewer, to world space; the map's camera stands still. */
    toWorld: (v) => v.clone().applyQuaternion(camera().quaternion),
    toView: (v) => v.clone().applyQuaternion(camera().quaternion.clone().invert()),
  };
}

/** A light that anyone sees something by. */
export const FIRST_LIGHT = new Vector3(-0.35, 0.45, 0.82).normalize();
