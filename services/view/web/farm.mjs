// Opens the page of a farm in headless Chromium and uses it:
//   node farm.mjs http://127.0.0.1:PORT/ [SHOT.png [CHROMIUM]] [--name TEXT] [--report RUN]
// Exit code 0 if the page connects, shows what the farm says, asks for nothing beyond its own address, says nothing on
// the console, fits a telephone and can be used by keyboard. With `--name` a text that somebody gave stands in the page
// as text, whatever HTML it is. With `--report` the report of that run opens from its link and shows the run.
import { chromium } from "playwright-core";
import { parseArgs } from "node:util";

/// Longest wait for the page to be there [ms]: a report may have to be made first.
const WAIT = 60_000;

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { name: { type: "string" }, report: { type: "string" } },
});
const [address, shot, executablePath = "/usr/bin/chromium"] = positionals;
const origin = new URL(address).origin;

const browser = await chromium.launch({
  executablePath,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const faults = [];

/// Notes what a page asks for and says that it should not.
function mind(page, what) {
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !/GPU stall|GL Driver Message/.test(message.text())) {
      faults.push(`${what}: console: ${message.text()}`);
    }
  });
  page.on("pageerror", (error) => faults.push(`${what}: ${error.message}`));
  page.on("dialog", (dialog) => {
    faults.push(`${what}: a dialog opened: ${dialog.message()}`);
    dialog.dismiss();
  });
  page.on("request", (request) => {
    const url = request.url();
    if (!url.startsWith(`${origin}/`) && !/^(data|blob):/.test(url)) faults.push(`${what}: asks for ${url}`);
  });
}

try {
  for (const colorScheme of ["light", "dark"]) {
    const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, colorScheme });
    const page = await context.newPage();
    mind(page, colorScheme);
    await page.goto(address);
    await page.waitForSelector("html[data-ready=yes]", { timeout: WAIT });
    await page.waitForSelector("#link[data-state=live]", { timeout: WAIT });
    const told = await (await page.request.get(`${origin}/api/runs`)).json();
    const shown = await page.evaluate(() => {
      const keys = [...document.querySelectorAll("#queue tbody tr, #over tbody tr")].map((row) => row.dataset.key);
      return [...keys, ...[...document.querySelectorAll("#running .number")].map((node) => node.textContent)];
    });
    const missing = told.map((run) => String(run.run)).filter((run) => !shown.includes(run));
    if (missing.length > 0 && told.length <= 100) faults.push(`${colorScheme}: runs ${missing} are not shown`);
    const workers = await (await page.request.get(`${origin}/api/workers`)).json();
    const rows = await page.locator("#workers tbody tr").count();
    if (rows !== workers.length) faults.push(`${colorScheme}: ${rows} workers are shown of ${workers.length}`);
    if (options.name) {
      const text = await page.evaluate(() => document.body.innerText);
      if (!text.includes(options.name)) faults.push(`${colorScheme}: ${options.name} is not shown as it is`);
      const odd = await page.evaluate(() =>
        [...document.querySelectorAll("script:not([src='/page.js']), img[onerror], iframe, svg")].length);
      if (odd > 0) faults.push(`${colorScheme}: ${odd} elements are in the page that are none of it`);
    }
    // Pictures of runs that go on come within seconds.
    if (shot) await page.screenshot({ path: shot.replace(/\.png$/, `-${colorScheme}.png`) });
    await page.setViewportSize({ width: 390, height: 844 });
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    if (wide > 390) faults.push(`${colorScheme}: the page is ${wide} pixels wide on a screen of 390`);
    if (shot) await page.screenshot({ path: shot.replace(/\.png$/, `-${colorScheme}-phone.png`), fullPage: true });
    await page.setViewportSize({ width: 1400, height: 900 });
    // By keyboard: the first stop leads past the header, and all that can be used is reached.
    await page.keyboard.press("Tab");
    const first = await page.evaluate(() => document.activeElement.className);
    if (first !== "skip") faults.push(`${colorScheme}: the first stop of the keyboard is ${first || "nothing"}`);
    const stops = new Set();
    for (let k = 0; k < 400; k += 1) {
      await page.keyboard.press("Tab");
      const stop = await page.evaluate(() => document.activeElement.id || document.activeElement.textContent);
      if (stops.has(stop) && stop === "filter") break;
      stops.add(stop);
    }
    for (const wanted of ["filter", "search"]) {
      if (!stops.has(wanted)) faults.push(`${colorScheme}: the keyboard does not reach #${wanted}`);
    }
    console.log(JSON.stringify({ colorScheme, runs: told.length, workers: rows }));
    await context.close();
  }
  if (options.report) {
    const context = await browser.newContext({ viewport: { width: 1400, height: 900 } });
    const page = await context.newPage();
    mind(page, "page");
    await page.goto(address);
    const link = page.locator(`#over tr[data-key="${options.report}"] a`, { hasText: "report" });
    await link.waitFor({ timeout: WAIT });
    const opened = context.waitForEvent("page");
    await link.click();
    const report = await opened;
    mind(report, "report");
    await report.waitForSelector("html[data-ready=yes]", { timeout: WAIT });
    const kind = await report.evaluate(() => window.cullet.report.kind);
    if (kind !== "run") faults.push(`the report is of kind ${kind}`);
    // What is in a report can ask the farm for nothing.
    const reached = await report.evaluate(async (url) => {
      try {
        return (await fetch(url)).status;
      } catch {
        return null;
      }
    }, `${origin}/api/runs`).catch(() => null);
    if (reached !== null) faults.push(`the report reaches the farm: ${reached}`);
    const refused = /Content Security Policy|blocked by CORS|Refused to connect|Failed to fetch/;
    const mine = (fault) => fault.startsWith("report: console") && refused.test(fault);
    faults.splice(0, faults.length, ...faults.filter((fault) => !mine(fault)));
    if (shot) await report.screenshot({ path: shot.replace(/\.png$/, "-report.png") });
    console.log(JSON.stringify({ report: options.report }));
  }
} finally {
  await browser.close();
}
faults.forEach((fault) => console.error(fault));
process.exitCode = faults.length === 0 ? 0 : 1;
