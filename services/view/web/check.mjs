// Opens a page in headless Chromium and uses it: node check.mjs REPORT.html [SHOT.png [CHROMIUM]]
// Exit code 0 if the page loads, moves when the slider does, shows what is clicked, asks for nothing beyond itself, and
// says nothing on the console. It prints how long loading took, in ms; LOAD_MS bounds that.
import { chromium } from "playwright-core";
import { resolve } from "node:path";

/// Loading may take so long [ms]: on a machine that does other things, too, much longer than alone.
const LOAD = Number(process.env.LOAD_MS ?? 15_000);

const [file, shot, executablePath = "/usr/bin/chromium"] = process.argv.slice(2);
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
