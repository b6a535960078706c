"""Evaluates the probes of every variant of a package with plain OpenGL; prints JSON.

    python3 probe.py generated

`worst` is the greatest error over the tolerance of its direction; `controls` are the same for integrations that are wrong on
purpose, and must be far above 1.
"""

import json
import sys
from pathlib import Path

import numpy as np

from draw import draw, open_context

PROBE = """
uniform vec3 wi[64];
uniform vec3 wr[64];
out vec4 colour;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    colour = vec4(at.y == 0 ? tristimulus(wi[at.x], wr[at.x]) : diffraction(wi[at.x], wr[at.x]), 1.0);
}
"""


def evaluate(context, folder, wi, wr):
    """XYZ and RGB of 64 pairs of directions."""
    return draw(context, folder, PROBE, (64, 2), wi=wi, wr=wr)[..., :3]


def worst(seen, probes):
    """RGB may be wrong by 5.3 times as much: the greatest sum of moduli of a row of its matrix."""
    expected = np.array([[p["expected"][kind] for p in probes] for kind in ("xyz", "rgb")])
    allowed = np.array([p["tolerance"] for p in probes])[None, :, None] * np.array([1, 5.3])[:, None, None]
    greatest = (np.abs(seen - expected) / allowed).max()
    return float(greatest) if np.isfinite(greatest) else sys.float_info.max


def main(package):
    context = open_context()
    results = []
    for path in sorted(Path(package).glob("shaders/*/*/probe.json")):
        probes = json.loads(path.read_text())["probes"]
        wi, wr = np.array([p["wi"] for p in probes]), np.array([p["wr"] for p in probes])
        seen = evaluate(context, path.parent, wi, wr)
        flipped = evaluate(context, path.parent, wi * [1, -1, 1], wr * [1, -1, 1])
        controls = {"swapped channels": worst(seen[..., ::-1], probes), "flipped bitangent": worst(flipped, probes)}
        surface, variant = path.parts[-3:-1]
        results.append({"surface": surface, "variant": variant, "count": len(probes)})
        results[-1] |= {"worst": worst(seen, probes), "controls": controls}
    print(json.dumps({"driver": context.info["GL_RENDERER"], "results": results}))


if __name__ == "__main__":
    main(*sys.argv[1:])
