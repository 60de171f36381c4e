// Builds the pages: those of reports into seoro/report/static/, those of `seoro ui` into seoro/ui/static/ (`make ui`).
// The world in three dimensions is a file of its own, which both load on demand.
// `source.txt` is a hash of this folder, by which tests see without Node.js that the built files match the source.
import { createHash } from "node:crypto";
import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));
const target = process.argv[2] ?? join(here, "../seoro");
const PAGES = {
  report: { report: "src/report.tsx", world3d: "src/space/world3d.ts" },
  ui: { ui: "src/ui.tsx" },
};
const LIBRARIES = { report: ["preact", "three"], ui: ["preact"] };

function filesIn(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    if (entry.name === "node_modules") return [];
    const path = join(folder, entry.name);
    return entry.isDirectory() ? filesIn(path) : [path];
  });
}

function hashOfSource() {
  const hash = createHash("sha256");
  const paths = filesIn(here).map((path) => relative(here, path).replaceAll("\\", "/")).sort();
  for (const path of paths) hash.update(`${path}\0`).update(readFileSync(join(here, path))).update("\0");
  return hash.digest("hex");
}

function licence(name) {
  const folder = join(here, "node_modules", name);
  const { version } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  return `${name} ${version}\n\n${readFileSync(join(folder, "LICENSE"), "utf8").trim()}\n`;
}

for (const [name, entryPoints] of Object.entries(PAGES)) {
  const folder = join(target, name, "static");
  mkdirSync(folder, { recursive: true });
  await build({
    absWorkingDir: here,
    entryPoints,
    outdir: folder,
    bundle: true,
    minify: true,
    format: "iife",
    target: "es2022",
    charset: "utf8",
    legalComments: "none",
    jsx: "automatic",
    jsxImportSource: "preact",
    logLevel: "warning",
  });
  writeFileSync(join(folder, "LICENSES.txt"), LIBRARIES[name].map(licence).join("\n----\n\n"));
  writeFileSync(join(folder, "source.txt"), `${hashOfSource()}\n`);
}
