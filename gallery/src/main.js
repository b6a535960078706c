import { openPackage } from "./package.js";
import { probePackage } from "./probe.js";
import * as webgl2 from "./webgl2.js";
import * as webgpu from "./webgpu.js";
(async () => { for (const [api, module] of Object.entries({ webgl2, webgpu })) {
  try {
    const files = await openPackage();
    const engine = await module.open(document.createElement("canvas"));
    const t = performance.now();
    const results = await probePackage(files, engine, module.target);
    console.log(api, engine.driver, Math.round(performance.now() - t), JSON.stringify(results));
  } catch (e) { console.log(api, e.stack); }
}
})();
