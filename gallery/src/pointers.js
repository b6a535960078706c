// What hands do: orbit the camera, move the light. Mouse, touch and keyboard.
import { Vector3 } from "three";

const STEP = Math.PI / 36;

/** Dragging orbits, wheel and pinch come nearer, arrows and +/- do the same. */
export function orbit(element, state, onChange) {
  const touching = new Map();
  let spread = 0;
  const turn = (x, y) => {
    state.azimuth -= x;
    state.elevation = Math.min(1.5, Math.max(-1.5, state.elevation + y));
    onChange();
  };
  const near = (factor) => {
    state.distance = Math.min(12, Math.max(1.6, state.distance * factor));
    onChange();
  };
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    touching.set(event.pointerId, event);
    spread = 0;
  });
  element.addEventListener("pointermove", (event) => {
    const before = touching.get(event.pointerId);
    if (!before) return;
    touching.set(event.pointerId, event);
    if (touching.size === 1) {
      turn((event.clientX - before.clientX) * 0.008, (event.clientY - before.clientY) * 0.008);
    } else if (touching.size === 2) {
      const [a, b] = [...touching.values()];
      const now = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
      if (spread) near(spread / now);
      spread = now;
    }
  });
  for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, (event) => touching.delete(event.pointerId));
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    near(Math.exp(event.deltaY * 0.001));
  }, { passive: false });
  element.addEventListener("keydown", (event) => {
    const moves = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] };
    const factors = { "+": 0.9, "=": 0.9, "-": 1.1 };
    if (moves[event.key]) turn(...moves[event.key]);
    else if (factors[event.key]) near(factors[event.key]);
    else return;
    event.preventDefault();
  });
}

/**
 * A round pad that shows the half space before the camera; its dot is the light. `get` and `set` speak of unit vectors in view
 * space. Returns what draws the dot anew.
 */
export function lightPad(pad, dot, get, set) {
  const place = (x, y) => {
    const length = Math.hypot(x, y);
    const most = 0.995;
    const [cx, cy] = length > most ? [(x / length) * most, (y / length) * most] : [x, y];
    set(new Vector3(cx, cy, Math.sqrt(1 - cx * cx - cy * cy)));
  };
  const follow = (event) => {
    const box = pad.getBoundingClientRect();
    place((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
  };
  pad.addEventListener("pointerdown", (event) => {
    pad.setPointerCapture(event.pointerId);
    follow(event);
  });
  pad.addEventListener("pointermove", (event) => pad.hasPointerCapture(event.pointerId) && follow(event));
  pad.addEventListener("keydown", (event) => {
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (!moves[event.key]) return;
    const { x, y } = get();
    const [dx, dy] = moves[event.key];
    place(x + 0.05 * dx, y + 0.05 * dy);
    event.preventDefault();
  });
  return () => {
    const { x, y, z } = get();
    // behind the body, the dot lies on the rim and is faint
    const length = z < 0 ? Math.hypot(x, y) || 1 : 1;
    dot.style.left = `${50 + (50 * x) / length}%`;
    dot.style.top = `${50 - (50 * y) / length}%`;
    dot.classList.toggle("behind", z < 0);
    const degrees = (radians) => Math.round((radians * 180) / Math.PI);
    pad.setAttribute("aria-valuetext", `${degrees(Math.acos(z))}° from the view, ${degrees(Math.atan2(y, x))}° around it`);
  };
}
