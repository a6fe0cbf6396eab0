// Bundles src/main.js with three.js into ../assets/viewer.js, and its licences beside it.
import { build } from "esbuild";
import { readFileSync, writeFileSync } from "node:fs";

await build({
  entryPoints: ["src/main.js"],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "ascii",
  legalComments: "none",
  outfile: "../assets/viewer.js",
});
const three = readFileSync("node_modules/three/LICENSE", "utf8").trim();
const { version } = JSON.parse(readFileSync("node_modules/three/package.json", "utf8"));
writeFileSync("../assets/viewer.js.LICENSE.txt", `three.js ${version}\n\n${three}\n`);
