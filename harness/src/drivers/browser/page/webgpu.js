// Runs WGSL on WebGPU. Pictures are returned top row first.
"use strict";

const webgpu = (() => {
  const SCOPES = ["internal", "out-of-memory", "validation"];
  const PARAMS_BYTES = 32;
  const programs = new Map();
  let device = null;
  let target = null;

  // Opens a device with all features and limits of the adapter, or replaces a lost one.
  async function open() {
    if (device && !device.cause) return device.driver;
    if (!navigator.gpu) throw new Error("the browser has no WebGPU");
    const adapter = await navigator.gpu.requestAdapter();
    if (!adapter) throw new Error("WebGPU found no adapter");
    const requiredLimits = {};
    for (const name of ["maxTextureDimension2D", "maxTextureArrayLayers", "maxBufferSize"]) {
      requiredLimits[name] = adapter.limits[name];
    }
    device = await adapter.requestDevice({ requiredLimits });
    const opened = device;
    opened.gone = opened.lost.then((info) => {
      opened.cause = `the WebGPU device was lost: ${info.message || info.reason}`;
      throw new Error(opened.cause);
    });
    opened.gone.catch(() => {});
    const { vendor, architecture, device: name, description } = adapter.info;
    opened.driver = [vendor, architecture, name, description].filter((word) => word).join(" ");
    target = null;
    return opened.driver;
  }

  // Does work on the device. Throws the errors that the device reports.
  async function guarded(device, action) {
    if (device.cause) throw new Error(device.cause);
    SCOPES.forEach((scope) => device.pushErrorScope(scope));
    const [done] = await Promise.allSettled([Promise.race([action(), device.gone])]);
    const faults = await Promise.allSettled(SCOPES.map(() => device.popErrorScope()));
    if (device.cause) throw new Error(device.cause);
    const fault = faults.map((outcome) => outcome.value ?? outcome.reason).find((found) => found);
    // errors thrown by this file are clearer than the scopes' errors, which repeat them; errors thrown by the browser may only be
    // consequences of the scopes' errors
    const own = done.reason && !(done.reason instanceof DOMException);
    if (fault && !own) throw new Error(fault.message);
    if (done.status === "rejected") throw done.reason;
    return done.value;
  }

  async function compile(job, tables) {
    await open();
    const used = device;
    programs.set(job.id, await guarded(used, () => build(used, job, tables)));
  }

  async function build(device, { vertex, fragment, block, sampler }, tables) {
    const modules = new Map();
    for (const { file, text } of [vertex, fragment]) {
      if (!modules.has(file)) modules.set(file, await shader(device, file, text));
    }
    const visibility = GPUShaderStage.VERTEX | GPUShaderStage.FRAGMENT;
    const uniform = device.createBuffer({
      size: PARAMS_BYTES,
      usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST,
    });
    const layouts = [{ binding: block, visibility, buffer: { minBindingSize: PARAMS_BYTES } }];
    const entries = [{ binding: block, resource: { buffer: uniform } }];
    const textures = tables.map((table) => upload(device, table));
    if (sampler !== undefined) {
      const filter = { magFilter: "linear", minFilter: "linear" };
      layouts.push({ binding: sampler, visibility, sampler: { type: "filtering" } });
      entries.push({ binding: sampler, resource: device.createSampler(filter) });
    }
    tables.forEach(({ binding, layers, filtered }, i) => {
      const viewDimension = layers === 0 ? "2d" : "2d-array";
      const sampleType = filtered ? "float" : "unfilterable-float";
      const texture = { sampleType, viewDimension };
      layouts.push({ binding, visibility, texture });
      entries.push({ binding, resource: textures[i].createView({ dimension: viewDimension }) });
    });
    const layout = device.createBindGroupLayout({ entries: layouts });
    const pipeline = await device.createRenderPipelineAsync({
      layout: device.createPipelineLayout({ bindGroupLayouts: [layout] }),
      vertex: { module: modules.get(vertex.file), entryPoint: vertex.entry },
      fragment: {
        module: modules.get(fragment.file),
        entryPoint: fragment.entry,
        targets: [{ format: "rgba32float" }],
      },
    });
    const group = device.createBindGroup({ layout, entries });
    return { device, pipeline, group, uniform, textures };
  }

  async function shader(device, file, code) {
    const module = device.createShaderModule({ label: file, code });
    const { messages } = await module.getCompilationInfo();
    const errors = messages.filter((message) => message.type === "error");
    if (errors.length > 0) {
      const line = (m) => `${file}:${m.lineNum}:${m.linePos}: ${m.message}`;
      throw new Error(errors.map(line).join("; "));
    }
    return module;
  }

  function upload(device, { format, width, height, layers, data }) {
    const size = [width, height, Math.max(layers, 1)];
    const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
    const texture = device.createTexture({ size, format, usage });
    const bytesPerRow = data.length / (size[1] * size[2]);
    const layout = { bytesPerRow, rowsPerImage: height };
    device.queue.writeTexture({ texture }, data, layout, size);
    return texture;
  }

  // Draws the rows from `top` up to, but not including, `bottom`.
  async function draw({ id, size, params, top, bottom }) {
    const program = programs.get(id);
    if (!program) throw new Error("the page has no such program");
    try {
      return await guarded(program.device, () => rows(program, size, params, top, bottom - top));
    } catch (error) {
      target = null;
      throw error;
    }
  }

  async function rows({ device, pipeline, group, uniform }, [width, height], params, top, count) {
    if (target?.device !== device || target.width !== width || target.height !== height) {
      target?.texture.destroy();
      const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC;
      const format = "rgba32float";
      const texture = device.createTexture({ size: [width, height], format, usage });
      target = { device, width, height, texture };
    }
    const stride = Math.ceil((width * 16) / 256) * 256;
    const usage = GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ;
    const buffer = device.createBuffer({ size: stride * count, usage });
    device.queue.writeBuffer(uniform, 0, new Float32Array(params));
    const encoder = device.createCommandEncoder();
    const view = target.texture.createView();
    const attachment = { view, loadOp: "clear", storeOp: "store", clearValue: [0, 0, 0, 0] };
    const pass = encoder.beginRenderPass({ colorAttachments: [attachment] });
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, group);
    pass.setScissorRect(0, top, width, count);
    pass.draw(3);
    pass.end();
    encoder.copyTextureToBuffer(
      { texture: target.texture, origin: [0, top] },
      { buffer, bytesPerRow: stride },
      [width, count],
    );
    device.queue.submit([encoder.finish()]);
    await buffer.mapAsync(GPUMapMode.READ);
    const padded = new Uint8Array(buffer.getMappedRange());
    const pixels = new Uint8Array(width * 16 * count);
    for (let row = 0; row < count; row++) {
      pixels.set(padded.subarray(row * stride, row * stride + width * 16), row * width * 16);
    }
    buffer.destroy();
    return pixels;
  }

  function free(id) {
    const program = programs.get(id);
    programs.delete(id);
    program?.textures.forEach((texture) => texture.destroy());
    program?.uniform.destroy();
  }

  return { open, compile, draw, free };
})();
