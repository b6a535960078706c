"""Evaluates the probes of every variant of a package with plain OpenGL; prints JSON.

    python3 probe.py generated

`worst` is the greatest error over the tolerance of its probe; `controls` are the same for integrations that are wrong on
purpose, of the function that shows it least, and must be far above 1.
"""

import json
import sys
from pathlib import Path

import numpy as np

from draw import BLACK, draw, open_context

PROBE = """
{uniforms}
out vec4 seen;
void main() {{
    ivec2 at = ivec2(gl_FragCoord.xy);
    seen = vec4(at.y == 0 ? {tristimulus}({arguments}) : {function}({arguments}), 1.0);
}}
"""
# the sky of a probe: a constant, with a factor on the spread in w, and lobes: axis with its width in w, and radiance
LOBES = 2
SKY = """
uniform vec4 sky[{rows} * {count}];
vec3 environment_radiance(vec3 direction, float spread) {{
    int first = {rows} * int(gl_FragCoord.x);
    vec3 sum = sky[first].rgb;
    float blur = sky[first].w * spread * sky[first].w * spread;
    for (int i = first + 1; i < first + {rows}; i += 2) {{
        float own = sky[i].w * sky[i].w;
        float share = own / (own + blur) * exp((dot(direction, sky[i].xyz) - 1.0) / (own + blur));
        sum += share * sky[i + 1].rgb;
    }}
    return sum;
}}
"""
ARGUMENTS = {
    "diffraction": ("wi", "wr"),
    "diffraction_spread": ("wi", "wr", "spread"),
    "diffraction_disc": ("axis", "radius", "wr"),
    "diffraction_disc_coloured": ("axis", "radius", "colour", "wr"),
    "diffraction_rectangle": ("a", "b", "c", "d", "wr"),
    "diffraction_rectangle_coloured": ("a", "b", "c", "d", "colour", "wr"),
    "diffraction_environment": ("wr",),
}


def read(path):
    """Probes by functions: arguments, colours of XYZ and RGB, tolerances."""
    text = json.loads(path.read_text())
    found = {}
    for probe in text["probes"] + text.get("lights", []):
        if "corners" in probe:
            probe |= zip("abcd", probe["corners"])
        found.setdefault(probe.get("function", "diffraction"), []).append(probe)
    arrays = {}
    for function, probes in found.items():
        arguments = {name: np.array([p[name] for p in probes]) for name in ARGUMENTS[function]}
        if "sky" in probes[0]:
            arguments["sky"] = np.array([sky_rows(p["sky"]) for p in probes])
        expected = np.array([[p["expected"][kind] for p in probes] for kind in ("xyz", "rgb")])
        arrays[function] = arguments, expected, np.array([p["tolerance"] for p in probes])
    return arrays


def sky_rows(sky):
    """A sky as the shader reads it."""
    if len(sky["lobes"]) > LOBES:
        raise ValueError(f"a probe's sky has {len(sky['lobes'])} lobes, here it may have {LOBES}")
    dark = {"axis": [0, 0, 1], "sigma": 1, "radiance": [0, 0, 0]}
    rows = [[*sky["constant"], 1]]
    for lobe in sky["lobes"] + [dark] * (LOBES - len(sky["lobes"])):
        rows += [[*lobe["axis"], lobe["sigma"]], [*lobe["radiance"], 0]]
    return rows


def evaluate(context, folder, function, arguments):
    """XYZ and RGB of all probes of a function."""
    count = len(arguments["wr"])
    vectors = {name: values for name, values in arguments.items() if name != "sky"}
    surroundings = SKY.format(rows=1 + 2 * LOBES, count=count) if "sky" in arguments else BLACK
    types = {name: "float" if values.ndim == 1 else "vec3" for name, values in vectors.items()}
    main = PROBE.format(
        uniforms="\n".join(f"uniform {kind} {name}[{count}];" for name, kind in types.items()),
        function=function,
        tristimulus=function.replace("diffraction", "tristimulus"),
        arguments=", ".join(f"{name}[at.x]" for name in vectors),
    )
    return draw(context, folder, main, (count, 2), surroundings, **arguments)[..., :3]


def flipped(arguments):
    """Directions under a flipped bitangent."""
    flips = {1: lambda v: v, 2: lambda v: v * [1, -1, 1], 3: mirrored}
    return {name: v if name == "colour" else flips[v.ndim](v) for name, v in arguments.items()}


def mirrored(sky):
    """Skies whose lobes are on the other side."""
    sky = sky.copy()
    sky[:, 1::2, 1] *= -1
    return sky


def blurred(sky):
    """Skies that take the spread for degrees."""
    sky = sky.copy()
    sky[:, 0, 3] = 180 / np.pi
    return sky


def resized(arguments):
    """A disc of another radius, lobes of another spread, or a quadrilateral without its last corner."""
    sizes = [name for name in ("radius", "spread") if name in arguments]
    changed = {name: 1.5 * arguments[name] for name in sizes} or {"d": arguments["c"]}
    return arguments | changed


def worst(seen, expected, tolerances):
    """RGB may be wrong by 5.3 times as much: the greatest sum of moduli of a row of its matrix."""
    allowed = tolerances[None, :, None] * np.array([1, 5.3])[:, None, None]
    greatest = (np.abs(seen - expected) / allowed).max()
    return float(greatest) if np.isfinite(greatest) else sys.float_info.max


def judge(context, folder, function, arguments, *truth):
    """How far a function is off, and how far wrong integrations of it are."""
    seen = evaluate(context, folder, function, arguments)
    controls = {
        "swapped channels": worst(seen[..., ::-1], *truth),
        "flipped bitangent": worst(evaluate(context, folder, function, flipped(arguments)), *truth),
    }
    if "sky" in arguments:
        for name, wrong in [
            ("a spread taken for degrees", blurred),
            ("mirrored surroundings", mirrored),
        ]:
            fault = arguments | {"sky": wrong(arguments["sky"])}
            controls[name] = worst(evaluate(context, folder, function, fault), *truth)
    elif function != "diffraction":
        wrong = evaluate(context, folder, function, resized(arguments))
        controls["another size of the light"] = worst(wrong, *truth)
    return worst(seen, *truth), controls


def main(package):
    context = open_context()
    results = []
    for path in sorted(Path(package).glob("shaders/*/*/probe.json")):
        probes = read(path)
        judged = [judge(context, path.parent, function, *of) for function, of in probes.items()]
        controls = {}
        for _, found in judged:
            for name, value in found.items():
                controls[name] = min(value, controls.get(name, value))
        functions = {function: len(tolerances) for function, (*_, tolerances) in probes.items()}
        surface, variant = path.parts[-3:-1]
        results.append({"surface": surface, "variant": variant, "count": sum(functions.values())})
        worst_of_all = max(value for value, _ in judged)
        results[-1] |= {"functions": functions, "worst": worst_of_all, "controls": controls}
    print(json.dumps({"driver": context.info["GL_RENDERER"], "results": results}))


if __name__ == "__main__":
    main(*sys.argv[1:])
