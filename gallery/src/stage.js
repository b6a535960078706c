// One body, one light, one camera: draws when something changed, coarsely while things move and finely at rest.
import { DoubleSide, Mesh, OrthographicCamera, PerspectiveCamera, Scene, Vector3 } from "three";
import { BODIES } from "./bodies.js";

/** Longest picture while things move, and at rest, milliseconds. */
const MOVING_MS = 70;
const RESTING_MS = 1200;
/** Least ratio of drawn to CSS pixels. */
const COARSEST = 0.12;
/** Time without a change after which things are at rest, milliseconds. */
const REST_MS = 250;
/** What a slow driver does in a moving picture's time: texels fetched. The first picture of a variant trusts nothing else. */
const FETCHES = 2e7;

/**
 * The stage. `state` is `{ body, azimuth, elevation, distance, light, stops, ratio }`: angles in radians, `light` a unit vector
 * in world space, exposure in powers of two, the ratio of drawn to CSS pixels or 0 for what the time allows. `onFrame` gets
 * `{ ms, width, height }`.
 */
export function createStage(state, onFrame) {
  const scene = new Scene();
  const perspective = new PerspectiveCamera(32, 1, 0.1, 20);
  const flat = new OrthographicCamera(-1, 1, 1, -1, 0.1, 20);
  const geometries = {};
  let engine, made, mesh, canvas;
  let changed = 0, lastMs = 0, ratio = 0, isRunning = false, isDirty = false;
  let waiting = [];

  function camera() {
    const isMap = state.body === "map";
    const aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
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
    perspective.up.set(0, Math.cos(elevation) < 0 ? -1 : 1, 0);
    perspective.position.set(Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation), Math.cos(azimuth) * Math.cos(elevation));
    perspective.position.multiplyScalar(far);
    perspective.lookAt(0, 0, 0);
    perspective.updateProjectionMatrix();
    return perspective;
  }

  /** The finest ratio of drawn to CSS pixels within a time, by the last picture; the first one's is a guess by what a pixel costs. */
  function affordable(ms) {
    if (state.ratio) return state.ratio;
    const most = window.devicePixelRatio || 1;
    const pixels = Math.max(1, canvas.clientWidth * canvas.clientHeight);
    const wanted = lastMs ? ratio * Math.sqrt(ms / lastMs) : Math.sqrt(FETCHES / made.fetches / pixels);
    return Math.min(most, Math.max(COARSEST, wanted));
  }

  async function draw() {
    const { renderer } = engine;
    renderer.setPixelRatio(ratio);
    renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
    const name = state.body;
    mesh.geometry = geometries[name] ??= BODIES[name]();
    const view = camera();
    made.set({ eye: view.position, light: state.light, exposure: 2 ** state.stops, is_map: name === "map" });
    const begun = performance.now();
    await engine.draw(scene, view);
    // clocks of browsers are coarse
    const ms = Math.max(0.1, performance.now() - begun);
    const { width, height } = canvas;
    // the first picture contains the driver's compiler
    if (made.isWarm) lastMs = ms;
    made.isWarm = true;
    onFrame({ ms, width, height });
  }

  async function run() {
    if (isRunning || !made) return;
    isRunning = true;
    try {
      for (;;) {
        isDirty = false;
        const isResting = performance.now() - changed > REST_MS;
        const isMeasured = lastMs > 0;
        ratio = isResting && isMeasured ? Math.max(ratio, affordable(RESTING_MS)) : affordable(MOVING_MS);
        await draw();
        if (isDirty || (!isMeasured && !state.ratio)) continue;
        if (state.ratio) break;
        if (!isResting) await new Promise((done) => setTimeout(done, REST_MS));
        // some of the time does not depend on the pixels: so the finest is reached in steps
        else if (lastMs > RESTING_MS / 2 || ratio >= (window.devicePixelRatio || 1)) break;
      }
    } finally {
      isRunning = isDirty = false;
      // also after an error, which whoever called gets
      waiting.forEach((done) => done());
      waiting = [];
    }
  }

  return {
    /** Something in the state changed. */
    touch() {
      changed = performance.now();
      isDirty = true;
      return run();
    },
    /** Resolves when the picture is as fine as it gets. */
    idle: () => (isRunning || isDirty ? new Promise((done) => waiting.push(done)) : Promise.resolve()),
    /** Takes another engine with its canvas, or another variant on it. */
    async show(newEngine, newCanvas, variant) {
      // a picture on its way keeps what it draws with
      while (isRunning) await this.idle();
      made?.dispose();
      if (engine !== newEngine) {
        engine?.dispose();
        for (const geometry of Object.values(geometries)) geometry.dispose();
      }
      [engine, canvas] = [newEngine, newCanvas];
      made = engine.material(variant);
      // arithmetic counts, too
      made.fetches = 50 + variant.manifest.cost.fetches;
      made.material.side = DoubleSide;
      made.set({ diffuser: variant.manifest.core.diffuser_scale ?? 1 });
      lastMs = 0;
      scene.clear();
      mesh = new Mesh(geometries[state.body] ??= BODIES[state.body](), made.material);
      mesh.frustumCulled = false;
      scene.add(mesh);
      return this.touch();
    },
    /** From view space, x right, y up, z to the viewer, to world space; the map's camera stands still. */
    toWorld: (v) => v.clone().applyQuaternion(camera().quaternion),
    toView: (v) => v.clone().applyQuaternion(camera().quaternion.clone().invert()),
  };
}

/** A light that anyone sees something by. */
export const FIRST_LIGHT = new Vector3(-0.35, 0.45, 0.82).normalize();
