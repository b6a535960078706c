"""Draws the BRDF map of a package's variant with plain OpenGL, reading manifest, GLSL and tables.

    python3 draw.py generated/shaders/fingers/full-taylor-t19 map.png
"""

import json
import sys
from pathlib import Path

import moderngl
import numpy as np
from PIL import Image

# one triangle that covers the picture
VERTEX = """#version 450 core
out vec2 place;
void main() {
    place = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(place, 0.0, 1.0);
}
"""
# what viewers in all directions see, exposed for a white diffuser; square roots stand for the
# curve of sRGB
MAP = """
in vec2 place;
uniform vec3 light;
uniform float diffuser_scale;
out vec4 colour;
void main() {
    float squared = 1.0 - dot(place, place);
    vec3 rgb = diffraction(light, vec3(place, sqrt(max(0.0, squared))));
    colour = vec4(sqrt(diffuser_scale * max(vec3(0.0), rgb)), step(0.0, squared));
}
"""
# a function form may call this one, which is the host's; a map under one light does not need it
BLACK = "vec3 environment_radiance(vec3 direction, float spread) { return vec3(0.0); }\n"
FORMATS = {  # channels and type
    "rg16float": (2, "f2"),
    "rgba16float": (4, "f2"),
    "rg32float": (2, "f4"),
    "rgba32float": (4, "f4"),
    "rgb9e5ufloat": (3, "f4"),
}


def main(folder, picture):
    folder = Path(folder)
    core = json.loads((folder / "manifest.json").read_text())["core"]
    scale = core["diffuser_scale"] or 1  # gems has none
    light = np.sin(np.radians(20)), 0, np.cos(np.radians(20))
    pixels = draw(open_context(), folder, MAP, (256, 256), light=light, diffuser_scale=scale)
    pixels = (255 * np.clip(pixels[::-1], 0, 1)).round().astype("u1")
    Image.fromarray(pixels).save(picture)


def open_context():
    return moderngl.create_context(standalone=True, backend="egl", require=450)


def draw(context, folder, main, size, surroundings=BLACK, **uniforms):
    """Runs a `main` of ours behind the variant's functions; rows of f32 RGBA, the lowest first."""
    manifest = json.loads((folder / "manifest.json").read_text())
    form = next(file for file in manifest["targets"]["glsl450"] if file["functions"])
    text = "#version 450 core\n" + (folder / form["file"]).read_text() + surroundings + main
    program = context.program(vertex_shader=VERTEX, fragment_shader=text)
    for unit, table in enumerate(manifest["tables"]):
        upload(context, folder, table).use(unit)
        if table["binding"] in program:  # a function may read some of the tables only
            program[table["binding"]] = unit
    for name, value in uniforms.items():
        program[name].write(np.asarray(value, "f4").tobytes())
    target = context.framebuffer([context.texture(size, 4, dtype="f4")])
    target.use()
    context.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    return np.frombuffer(target.read(components=4, dtype="f4"), "f4").reshape(*size[::-1], 4)


def upload(context, folder, table):
    """A table as a texture. Linear and clamped suits variants that filter and those that fetch."""
    shape = json.loads((folder / table["description"]).read_text())
    texels = (folder / table["data"]).read_bytes()
    if shape["format"] == "rgb9e5ufloat":  # moderngl has no three numbers with one exponent
        bits = np.frombuffer(texels, "<u4").astype("i4")[:, None]
        mantissas = (bits >> [0, 9, 18] & 511).astype("f4")
        texels = np.ldexp(mantissas, (bits >> 27 & 31) - 24).tobytes()
    size, create = (shape["width"], shape["height"]), context.texture
    if shape["dimension"] == "2d-array":
        size, create = (*size, shape["layers"]), context.texture_array
    channels, dtype = FORMATS[shape["format"]]
    texture = create(size, channels, texels, dtype=dtype)
    texture.filter = moderngl.LINEAR, moderngl.LINEAR
    texture.repeat_x = texture.repeat_y = False
    return texture


if __name__ == "__main__":
    main(*sys.argv[1:])
