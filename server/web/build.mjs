// SPDX-License-Identifier: Apache-2.0
// node build.mjs [OUT]: builds the page from src/ into dist/ (or OUT). The same sources and lockfile
// give the same bytes.
import { createHash } from "node:crypto";
import { cpSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";

const home = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(home, "dist");

rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
await esbuild.build({
  absWorkingDir: home,
  entryPoints: ["src/main.tsx", "src/layout_worker.ts", "src/style.css"],
  outdir: out,
  bundle: true,
  splitting: true, // what a view needs is loaded with the view
  format: "esm",
  target: "es2022",
  minify: true,
  legalComments: "none", // the licences are in licences.txt
  chunkNames: "[name]-[hash]",
  jsx: "automatic",
  jsxImportSource: "preact",
  logLevel: "warning",
});
cpSync(join(home, "src/index.html"), join(out, "index.html"));
cpSync(join(home, "src/icon.svg"), join(out, "icon.svg"));
writeFileSync(join(out, "licences.txt"), licences());
writeFileSync(join(out, "sources.sha256"), checksums());

// The licences of what is bundled, as they ask.
function licences() {
  const { dependencies } = JSON.parse(readFileSync(join(home, "package.json")));
  const bundled = [...Object.keys(dependencies), "graphology-utils", "events"];
  return bundled.sort().map((name) => {
    const folder = join(home, "node_modules", name);
    const about = JSON.parse(readFileSync(join(folder, "package.json")));
    const file = readdirSync(folder).find((f) => /^(licen[cs]e|copying)/i.test(f));
    const text = file ? readFileSync(join(folder, file), "utf8").trim() : about.license;
    return `${name} ${about.version}\n\n${text}\n`;
  }).join("\n----------------------------------------\n\n");
}

// What dist/ was made of, as `sha256sum --check` takes it.
function checksums() {
  const client = "../../clients/js";
  const files = ["build.mjs", "package-lock.json", "package.json"];
  files.push(`${client}/waystone.d.ts`, `${client}/waystone.js`);
  files.push(...readdirSync(join(home, "src")).map((name) => `src/${name}`));
  return files.sort().map((file) => {
    const hash = createHash("sha256").update(readFileSync(join(home, file))).digest("hex");
    return `${hash}  ${file}\n`;
  }).join("");
}
