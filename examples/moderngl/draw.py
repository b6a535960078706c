"""Draws the BRDF map of a package's variant with plain OpenGL, without a window: manifest, function form and tables are read.

    python3 draw.py generated/shaders/fingers/full-taylor-t19 map.png
"""

import json
import sys
from pathlib import Path

import moderngl
import numpy as np
from PIL import Image

SIZE = 256
VERTEX = """#version 450 core
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }
"""
MAP = """
uniform vec3 light;
uniform float size;
out vec4 colour;
void main() {
    vec2 place = 2.0 * gl_FragCoord.xy / size - 1.0;
    float inside = 1.0 - dot(place, place);
    colour = inside > 0.0 ? vec4(diffraction(light, vec3(place, sqrt(inside))), 1.0) : vec4(0.0);
}
"""


def open_context():
    return moderngl.create_context(standalone=True, backend="egl", require=450)


def program(context, folder, main):
    """The variant's function form before a `main`, its tables bound; returns it with a function that draws."""
    manifest = json.loads((folder / "manifest.json").read_text())
    form = next(file for file in manifest["targets"]["glsl450"] if file["functions"])
    text = "#version 450 core\n" + (folder / form["file"]).read_text() + main
    made = context.program(vertex_shader=VERTEX, fragment_shader=text)
    for unit, table in enumerate(manifest["tables"]):
        shape = json.loads((folder / table["description"]).read_text())
        size = (shape["width"], shape["height"])
        is_array = shape["dimension"] == "2d-array"
        create = context.texture_array if is_array else context.texture
        size += (shape["layers"],) if is_array else ()
        data = (folder / table["data"]).read_bytes()
        binding = next(b for b in manifest["bindings"] if b["name"] == table["binding"])
        if shape["format"] == "rgb9e5ufloat":
            texture = create(size, 3, shared_exponents(data), dtype="f4", alignment=1)
        else:
            dtype = "f2" if shape["format"].endswith("16float") else "f4"
            texture = create(size, len(shape["format"][:-7]), data, dtype=dtype, alignment=1)
        filter = moderngl.LINEAR if binding["sample_type"] == "float" else moderngl.NEAREST
        texture.filter = (filter, filter)
        texture.repeat_x = texture.repeat_y = False
        texture.use(unit)
        made[table["binding"]] = unit
    return made, len(manifest["tables"])


def shared_exponents(data):
    """Three numbers of nine bits with one exponent, as floats: moderngl has no such type."""
    bits = np.frombuffer(data, "<u4")
    mantissas = (bits[:, None] >> np.array([0, 9, 18])) & 511
    return np.ldexp(mantissas.astype("f4"), (bits >> 27).astype("i4")[:, None] - 24).astype("f4").tobytes()


def draw(context, made, width, height):
    """The picture as an array of f32 RGBA rows, the lowest first."""
    target = context.framebuffer([context.texture((width, height), 4, dtype="f4")])
    target.use()
    context.vertex_array(made, []).render(moderngl.TRIANGLES, vertices=3)
    return np.frombuffer(target.read(components=4, dtype="f4"), "f4").reshape(height, width, 4)


def main(folder, picture):
    context = open_context()
    made, _ = program(context, Path(folder), MAP)
    made["light"] = (np.sin(np.radians(20)), 0.0, np.cos(np.radians(20)))
    made["size"] = SIZE
    pixels = draw(context, made, SIZE, SIZE)[::-1]
    # the brightest tenth of a percent is white; square roots stand for the curve of sRGB
    white = np.quantile(pixels[..., 1], 0.999)
    pixels = np.sqrt(np.clip(pixels / [white, white, white, 1], 0, 1))
    Image.fromarray((255 * pixels).astype("u1")).save(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
