// Runs GLSL ES 3.00 on WebGL2. Pictures are returned bottom row first, as GL has them.
"use strict";

const webgl2 = (() => {
  const PARAMS_BYTES = 32;
  // Fills a picture's numbers before it is read. If it is still there afterwards, the driver has died without a report yet.
  const UNREAD = -12345.678;
  const programs = new Map();
  let gl = null;
  let target = null;

  // Opens a context, or replaces a lost one.
  async function open() {
    if (gl && !isLost(gl)) return driver(gl);
    const canvas = document.createElement("canvas");
    let reason = "";
    canvas.addEventListener("webglcontextcreationerror", (event) => {
      reason = `: ${event.statusMessage}`;
    });
    const opened = canvas.getContext("webgl2", { antialias: false, depth: false });
    if (!opened) throw new Error(`the browser has no WebGL2${reason}`);
    if (!opened.getExtension("EXT_color_buffer_float")) {
      const lack = "cannot render to 32-bit floats: it lacks EXT_color_buffer_float";
      throw new Error(`${driver(opened)} ${lack}`);
    }
    gl = opened;
    target = null;
    return driver(gl);
  }

  function driver(gl) {
    const names = gl.getExtension("WEBGL_debug_renderer_info");
    return gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  }

  function isLost(gl) {
    return gl.died || gl.isContextLost();
  }

  // Throws an error if GL recorded one since the last call.
  function check(gl, what) {
    const code = gl.getError();
    // further errors must be cleared, or the next call would be blamed for them
    while (code !== gl.NO_ERROR && !isLost(gl) && gl.getError() !== gl.NO_ERROR);
    if (code === gl.CONTEXT_LOST_WEBGL || isLost(gl)) {
      throw new Error("the WebGL2 context was lost");
    }
    if (code === gl.NO_ERROR) return;
    const names = ["INVALID_ENUM", "INVALID_VALUE", "INVALID_OPERATION", "OUT_OF_MEMORY",
      "INVALID_FRAMEBUFFER_OPERATION"];
    const name = names.find((name) => gl[name] === code) ?? code;
    throw new Error(`${what}: GL error ${name}`);
  }

  // Refuses a number above a limit of the driver. The error names the limit.
  function within(gl, what, value, limit) {
    const max = gl.getParameter(gl[limit]);
    if (!(value >= 1 && value <= max)) {
      throw new Error(`${what}: ${value} is not between 1 and ${limit} = ${max}`);
    }
  }

  async function compile(job, tables) {
    await open();
    const held = { gl, program: gl.createProgram(), textures: [], uniform: gl.createBuffer() };
    try {
      build(held, job, tables);
    } catch (error) {
      discard(held);
      throw error;
    }
    programs.set(job.id, held);
  }

  function build({ gl, program, textures, uniform }, job, tables) {
    const { vertex, fragment } = job;
    const shaders = [shader(gl, gl.VERTEX_SHADER, vertex), shader(gl, gl.FRAGMENT_SHADER, fragment)];
    shaders.forEach((shader) => gl.attachShader(program, shader));
    gl.linkProgram(program);
    const linked = gl.getProgramParameter(program, gl.LINK_STATUS);
    shaders.forEach((shader) => gl.deleteShader(shader));
    if (!linked) {
      const log = trimmed(gl.getProgramInfoLog(program));
      check(gl, "linking");
      throw new Error(`${vertex.file} and ${fragment.file}: do not link: ${log}`);
    }
    gl.useProgram(program);
    for (const { name, file, unit } of job.textures) {
      const place = gl.getUniformLocation(program, name);
      if (!place) throw new Error(`${file}: the driver does not know ${name}`);
      gl.uniform1i(place, unit);
    }
    for (const { name, file } of job.blocks) {
      const index = gl.getUniformBlockIndex(program, name);
      if (index === gl.INVALID_INDEX) throw new Error(`${file}: the driver does not know ${name}`);
      const bytes = gl.getActiveUniformBlockParameter(program, index, gl.UNIFORM_BLOCK_DATA_SIZE);
      if (bytes !== PARAMS_BYTES) {
        throw new Error(`${file}: ${name} has ${bytes} bytes instead of ${PARAMS_BYTES}`);
      }
      gl.uniformBlockBinding(program, index, 0);
    }
    gl.bindBuffer(gl.UNIFORM_BUFFER, uniform);
    gl.bufferData(gl.UNIFORM_BUFFER, PARAMS_BYTES, gl.DYNAMIC_DRAW);
    tables.forEach((table) => textures.push(upload(gl, table)));
    check(gl, "binding");
  }

  function shader(gl, kind, { file, text }) {
    const made = gl.createShader(kind);
    gl.shaderSource(made, text);
    gl.compileShader(made);
    if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) {
      const log = trimmed(gl.getShaderInfoLog(made));
      gl.deleteShader(made);
      check(gl, file);
      throw new Error(`${file}: does not compile: ${log}`);
    }
    return made;
  }

  function trimmed(log) {
    return (log ?? "").replaceAll("\0", "").trim();
  }

  // A texture, filtered or not. Its texels are in the stored format already, so that the driver does not round.
  function upload(gl, { binding, name, format, width, height, layers, filtered, data }) {
    const what = `table ${name}`;
    within(gl, `${what}: units`, binding + 1, "MAX_TEXTURE_IMAGE_UNITS");
    within(gl, `${what}: width`, width, "MAX_TEXTURE_SIZE");
    within(gl, `${what}: height`, height, "MAX_TEXTURE_SIZE");
    within(gl, `${what}: layers`, Math.max(layers, 1), "MAX_ARRAY_TEXTURE_LAYERS");
    const [internal, channels, type, numbers] = {
      rg16float: [gl.RG16F, gl.RG, gl.HALF_FLOAT, Uint16Array],
      rgba16float: [gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT, Uint16Array],
      rg32float: [gl.RG32F, gl.RG, gl.FLOAT, Float32Array],
      rgba32float: [gl.RGBA32F, gl.RGBA, gl.FLOAT, Float32Array],
      rgb9e5ufloat: [gl.RGB9_E5, gl.RGB, gl.UNSIGNED_INT_5_9_9_9_REV, Uint32Array],
    }[format];
    // copied, since typed arrays must begin at multiples of their element size
    const texels = new numbers(data.slice().buffer);
    const at = layers === 0 ? gl.TEXTURE_2D : gl.TEXTURE_2D_ARRAY;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + binding);
    gl.bindTexture(at, texture);
    const filter = filtered ? gl.LINEAR : gl.NEAREST;
    gl.texParameteri(at, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(at, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(at, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(at, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    if (layers === 0) {
      gl.texStorage2D(at, 1, internal, width, height);
      gl.texSubImage2D(at, 0, 0, 0, width, height, channels, type, texels);
    } else {
      gl.texStorage3D(at, 1, internal, width, height, layers);
      gl.texSubImage3D(at, 0, 0, 0, 0, width, height, layers, channels, type, texels);
    }
    check(gl, what);
    return { texture, at, unit: binding };
  }

  // Draws the rows from `top` up to, but not including, `bottom`, counted from the top.
  async function draw({ id, size: [width, height], params, top, bottom }) {
    const held = programs.get(id);
    if (!held) throw new Error("the page has no such program");
    const { gl, program, textures, uniform } = held;
    check(gl, "before drawing");
    aim(gl, width, height);
    gl.useProgram(program);
    textures.forEach(({ texture, at, unit }) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(at, texture);
    });
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, uniform);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, new Float32Array(params));
    gl.viewport(0, 0, width, height);
    gl.enable(gl.SCISSOR_TEST);
    const rows = bottom - top;
    gl.scissor(0, height - bottom, width, rows);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const pixels = new Float32Array(width * rows * 4).fill(UNREAD);
    gl.readPixels(0, height - bottom, width, rows, gl.RGBA, gl.FLOAT, pixels);
    gl.died ||= pixels[0] === Math.fround(UNREAD) && pixels.every((v) => v === pixels[0]);
    check(gl, "drawing");
    return pixels;
  }

  // Makes a picture of 32-bit floats the target of all further draws.
  function aim(gl, width, height) {
    if (target?.gl === gl && target.width === width && target.height === height) return;
    within(gl, "a picture's width", width, "MAX_RENDERBUFFER_SIZE");
    within(gl, "a picture's height", height, "MAX_RENDERBUFFER_SIZE");
    if (target?.gl === gl) {
      gl.deleteRenderbuffer(target.picture);
      gl.deleteFramebuffer(target.frame);
    }
    const picture = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, picture);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA32F, width, height);
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    const place = gl.COLOR_ATTACHMENT0;
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, picture);
    target = { gl, width, height, picture, frame };
    if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) !== gl.FRAMEBUFFER_COMPLETE) {
      target = null;
      check(gl, "picture");
      throw new Error("the driver cannot render to 32-bit floats");
    }
  }

  function discard({ gl, program, textures, uniform }) {
    gl.deleteProgram(program);
    gl.deleteBuffer(uniform);
    textures.forEach(({ texture }) => gl.deleteTexture(texture));
  }

  function free(id) {
    const held = programs.get(id);
    programs.delete(id);
    if (held) discard(held);
  }

  return { open, compile, draw, free };
})();
