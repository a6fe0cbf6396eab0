// Opens a page in headless Chromium and uses it:
//   node check.mjs REPORT.html [SHOT.png [CHROMIUM]] [--poses RUN_poses.csv [--model RUN.glb]]
// Exit code 0 if the page loads, moves when the slider does, shows what is clicked, asks for nothing beyond itself, and
// says nothing on the console. It prints how long loading took, in ms; LOAD_MS bounds that.
// With `--poses`, a table of `cullet export` at 24 frames a second, three.js must have in the page at 20 random frames
// the bodies of the table, each where the table says, as exactly as docs/report.md promises; with `--model` the same of
// an exported GLB, within 1e-5.
import { chromium } from "playwright-core";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { parseArgs } from "node:util";

/// Loading may take so long [ms]: on a machine that does other things, too, much longer than alone.
const LOAD = Number(process.env.LOAD_MS ?? 15_000);

/// Frames at which poses are compared.
const FRAMES = 20;
/// How far a body of an exported GLB may be from the table [m], and each number of its quaternion [1].
const MODEL = { place: 1e-5, share: 0, turn: 1e-5 };
/// The same of a page, which has fewer keys: a ten-thousandth of the body's diagonal, a thousandth of a radian (half of
/// that in the quaternion), and what single precision rounds.
const PAGE = { place: 1e-6, share: 1e-4, turn: 0.5e-3 + 1e-6 };

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { poses: { type: "string" }, model: { type: "string" } },
});
const [file, shot, executablePath = "/usr/bin/chromium"] = positionals;

/// Numbers from 0 to 1, the same in each run: mulberry32.
function* draws(seed) {
  for (let state = seed; ; ) {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    yield ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  }
}

/// Random frames of a table of poses, in order: the time, and where each body is, with y up as in glTF.
function readPoses(path) {
  const [head, ...lines] = readFileSync(path, "utf8").trim().split("\n");
  const column = Object.fromEntries(head.split(",").map((name, k) => [name, k]));
  const frames = new Map();
  for (const line of lines) {
    const row = line.split(",");
    const [x, y, z, qx, qy, qz, qw] = ["x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"].map((name) => +row[column[name]]);
    const frame = row[column.frame];
    if (!frames.has(frame)) frames.set(frame, { time: +row[column.time_s], bodies: {} });
    frames.get(frame).bodies[row[column.name]] = { place: [x, z, -y], turn: [qx, qz, -qy, qw] };
  }
  const left = [...frames.values()];
  const random = draws(7);
  const drawn = Array.from({ length: Math.min(FRAMES, left.length) }, () => {
    const [frame] = left.splice(Math.floor(random.next().value * left.length), 1);
    return frame;
  });
  return drawn.sort((a, b) => a.time - b.time);
}

/// In the page: where three.js has the bodies that are seen, at each of these times [s]. A body has a name and a place
/// in the world; it is seen where it and all above it are visible and its scale in the world is not zero.
function scenesOf(times) {
  const stage = window.checked ?? window.cullet.stage;
  // It need not be drawn.
  stage.shown = false;
  return times.map((time) => {
    stage.seek(time);
    stage.scene.updateMatrixWorld(true);
    const seen = {};
    stage.root.traverse((node) => {
      if (node.userData.id === undefined) return;
      for (let above = node; above; above = above.parent) if (!above.visible) return;
      const [place, turn, scale] = [node.position.clone(), node.quaternion.clone(), node.scale.clone()];
      node.matrixWorld.decompose(place, turn, scale);
      if (scale.length() < 1e-3) return;
      const box = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
      for (const mesh of [node, ...node.children]) {
        if (!mesh.isMesh) continue;
        if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
        const { min, max } = mesh.geometry.boundingBox;
        box[0] = box[0].map((low, k) => Math.min(low, min.getComponent(k)));
        box[1] = box[1].map((high, k) => Math.max(high, max.getComponent(k)));
      }
      const diagonal = Math.hypot(...box[1].map((high, k) => high - box[0][k]));
      seen[node.name] = { place: place.toArray(), turn: turn.toArray(), scale: scale.toArray(), diagonal };
    });
    return seen;
  });
}

/// What differs between a scene of three.js and the table; `what` names the scene. Prints the largest differences.
function compare(what, frames, scenes, bound) {
  const found = [];
  const worst = { place: 0, share: 0, turn: 0 };
  let poses = 0;
  frames.forEach(({ time, bodies }, k) => {
    const at = `${what} at ${time} s`;
    const [seen, recorded] = [Object.keys(scenes[k]), Object.keys(bodies)];
    const odd = [...seen.filter((name) => !bodies[name]), ...recorded.filter((name) => !scenes[k][name])];
    if (seen.length !== recorded.length || odd.length > 0) {
      found.push(`${at}: ${seen.length} bodies are seen, ${recorded.length} recorded: ${odd.slice(0, 5).join(", ")}`);
    }
    for (const name of recorded.filter((one) => scenes[k][one])) {
      const [is, should] = [scenes[k][name], bodies[name]];
      const place = Math.hypot(...is.place.map((x, axis) => x - should.place[axis]));
      const sign = Math.sign(is.turn.reduce((sum, x, axis) => sum + x * should.turn[axis], 0)) || 1;
      const turn = Math.hypot(...is.turn.map((x, axis) => x - sign * should.turn[axis]));
      const scale = Math.max(...is.scale.map((x) => Math.abs(x - 1)));
      poses += 1;
      worst.place = Math.max(worst.place, place);
      worst.share = Math.max(worst.share, place / is.diagonal);
      worst.turn = Math.max(worst.turn, turn);
      const most = bound.place + bound.share * is.diagonal;
      // Not `place > most`: what is not a number is a fault, too.
      if (!(place <= most && turn <= bound.turn && scale <= 1e-5)) {
        found.push(`${at}: ${name} is ${place} m and ${turn} in its quaternion from the table, scale ${is.scale}`);
      }
    }
  });
  const [place, share, turn] = [worst.place, worst.share, worst.turn].map((x) => x.toExponential(1));
  console.log(`${what}: ${poses} poses at ${frames.length} times within ${place} m (${share} of the body) and ${turn}`);
  if (poses === 0) found.push(`${what}: no pose was compared`);
  return found.slice(0, 20);
}
const browser = await chromium.launch({
  executablePath,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const faults = [];
try {
  const page = await browser.newPage({ viewport: { width: 1400, height: 860 } });
  page.on("console", (message) => {
    // The software renderer of a test machine says that reading pixels back is slow.
    if (["error", "warning"].includes(message.type()) && !/GPU stall|GL Driver Message/.test(message.text())) {
      faults.push(`console: ${message.text()}`);
    }
  });
  page.on("pageerror", (error) => faults.push(`page: ${error.message}`));
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) faults.push(`asks for ${request.url()}`);
  });
  const start = Date.now();
  await page.goto(`file://${resolve(file)}`);
  await page.waitForSelector("html[data-ready=yes]", { timeout: 20_000 });
  const took = Date.now() - start;
  const kind = await page.evaluate(() => window.cullet.report.kind);
  if (kind === "run") {
    const state = () => page.evaluate(() => ({
      time: window.cullet.stage.time,
      there: [...window.cullet.stage.pieces.values()].filter((piece) => piece.node.visible).length,
      places: [...window.cullet.stage.pieces.values()].map((piece) => piece.node.position.toArray()),
    }));
    const before = await state();
    await page.locator("#time").evaluate((slider) => {
      slider.value = slider.max;
      slider.dispatchEvent(new Event("input"));
    });
    const after = await state();
    const wrong = await page.evaluate(() => {
      const { stage, byId } = window.cullet;
      const there = ({ birth, end }) => birth <= stage.time && (end === null || end > stage.time);
      const differs = ([id, piece]) => there(byId.get(id)) !== piece.node.visible;
      return [...stage.pieces].filter(differs).map(([id]) => byId.get(id).name);
    });
    if (wrong.length > 0) faults.push(`seen or hidden against the recording at the end: ${wrong.join(", ")}`);
    if (!(after.time > before.time)) faults.push(`the slider moved nothing: ${before.time}, ${after.time} s`);
    if (JSON.stringify(before.places) === JSON.stringify(after.places)) faults.push("no body moved");
    // A place of the canvas where there is a piece, found by asking the page.
    const canvas = await page.locator("#canvas").boundingBox();
    const spot = await page.evaluate(([width, height]) => {
      for (let y = 0.2; y < 0.9; y += 0.02) {
        for (let x = 0.2; x < 0.8; x += 0.02) {
          const id = window.cullet.stage.pick(x * width, y * height);
          const body = window.cullet.byId.get(id);
          if (body && body.parent !== null) return [x * width, y * height, body.name];
        }
      }
      return null;
    }, [canvas.width, canvas.height]);
    if (!spot) {
      faults.push("no piece is seen at the end");
    } else {
      await page.mouse.click(canvas.x + spot[0], canvas.y + spot[1]);
      const shown = await page.locator("#facts h3").textContent();
      if (shown !== spot[2]) faults.push(`a click on ${spot[2]} shows ${shown}`);
    }
    for (const mode of ["share", "damage", "speed", "object"]) {
      await page.locator("#mode").selectOption(mode);
      if (shot) await page.screenshot({ path: shot.replace(/\.png$/, `-${mode}.png`) });
    }
    for (const tab of ["events", "ledger", "run"]) {
      await page.locator(`#tab-${tab}`).click();
      if (shot) await page.screenshot({ path: shot.replace(/\.png$/, `-${tab}.png`) });
    }
    console.log(JSON.stringify({ kind, load_ms: took, bodies: before.places.length, seen_at_end: after.there }));
    if (options.poses) {
      const frames = readPoses(options.poses);
      // As keys of glTF have times: a small piece may turn by 1e-5 rad in what single precision rounds.
      const times = frames.map(({ time }) => Math.fround(time));
      faults.push(...compare("page", frames, await page.evaluate(scenesOf, times), PAGE));
      if (options.model) {
        await page.evaluate(() => {
          const input = document.createElement("input");
          [input.type, input.id] = ["file", "model-file"];
          document.body.append(input);
        });
        await page.locator("#model-file").setInputFiles(options.model);
        // A second scene of the page's own code.
        await page.evaluate(async () => {
          const { report, stage } = window.cullet;
          const bytes = await document.getElementById("model-file").files[0].arrayBuffer();
          window.checked = new stage.constructor(document.createElement("canvas"), report);
          await window.checked.load(bytes);
        });
        faults.push(...compare("model", frames, await page.evaluate(scenesOf, times), MODEL));
      }
    }
  } else {
    const rows = await page.locator("#runs tbody tr").count();
    const pictures = await page.locator("#pictures figure").count();
    const wanted = await page.evaluate(() => {
      const { rows: all, pictures: some } = window.cullet.report;
      return [all.length, some.length];
    });
    if (rows === 0 || `${[rows, pictures]}` !== `${wanted}`) {
      faults.push(`${rows} rows and ${pictures} pictures, not ${wanted}`);
    }
    const blank = await page.evaluate(async () => {
      const images = [...document.querySelectorAll("#pictures img")];
      await Promise.allSettled(images.map((image) => image.decode()));
      return images.filter((image) => image.naturalWidth === 0).length;
    });
    if (blank > 0) faults.push(`${blank} pictures show nothing`);
    for (const figure of await page.locator("#pictures figure").all()) {
      const name = await figure.locator("figcaption").textContent();
      await figure.click();
      const shown = await page.locator("#large-name").textContent();
      const seen = await page.locator("#large").isVisible();
      if (!seen || shown !== name) faults.push(`a click on ${name} shows ${shown}`);
      await page.locator("#close").click();
    }
    await page.setViewportSize({ width: 420, height: 860 });
    if (shot) await page.screenshot({ path: shot.replace(/\.png$/, "-narrow.png") });
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    if (wide > 420) faults.push(`the page is ${wide} pixels wide on a screen of 420`);
    await page.setViewportSize({ width: 1400, height: 860 });
    console.log(JSON.stringify({ kind, load_ms: took, rows, pictures }));
  }
  if (shot) await page.screenshot({ path: shot });
  if (took > LOAD) faults.push(`loading took ${took} ms, ${LOAD} are allowed`);
} finally {
  await browser.close();
}
faults.forEach((fault) => console.error(fault));
process.exitCode = faults.length === 0 ? 0 : 1;
