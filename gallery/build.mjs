// Builds the page and the package into one folder that needs no network:
//   node build.mjs [--package FOLDER] [--out FOLDER]
// `package.js` holds what the page reads as one script, since browsers fetch nothing from disk.
import { build } from "esbuild";
import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

const here = dirname(fileURLToPath(import.meta.url));
const { values } = parseArgs({
  options: {
    package: { type: "string", default: join(here, "package") },
    out: { type: "string", default: join(here, "dist") },
  },
});
const { package: source, out } = values;

let index;
try {
  index = JSON.parse(readFileSync(join(source, "manifest.json"), "utf8"));
} catch {
  console.error(`${source}: no package; run
  cargo xtask generate --plan plans/gallery.toml --out gallery/package`);
  process.exit(2);
}

const isRead = (path) =>
  /^surfaces\/.*\.(json|bin)$/.test(path) || /^shaders\/.*\/(manifest\.json|probe\.json|[^/]*\.fn\.(glsl|wgsl))$/.test(path);
const paths = ["manifest.json", ...Object.keys(index.files).filter(isRead)];

rmSync(out, { recursive: true, force: true });
mkdirSync(join(out, "package"), { recursive: true });
const inline = {};
for (const path of paths) {
  cpSync(join(source, path), join(out, "package", path));
  inline[path] = readFileSync(join(source, path)).toString(path.endsWith(".bin") ? "base64" : "utf8");
}
writeFileSync(join(out, "package.js"), `window.DIFFRACTION_PACKAGE = ${JSON.stringify(inline)};\n`);
for (const file of ["index.html", "style.css"]) cpSync(join(here, "src", file), join(out, file));
await build({
  entryPoints: [join(here, "src/main.js")],
  outfile: join(out, "gallery.js"),
  bundle: true,
  minify: true,
  // a classic script: modules are not loaded from disk
  format: "iife",
  target: "es2022",
  legalComments: "inline",
  logLevel: "warning",
});
