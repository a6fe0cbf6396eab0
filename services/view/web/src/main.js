// The page of a report: a run with its model, or a sweep with its pictures.
import { viridisCss } from "./colours.js";
import { Chart } from "./charts.js";
import { Stage } from "./stage.js";

const $ = (id) => document.getElementById(id);

function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

function number(value, digits = 4) {
  if (value === null || value === undefined) return "–";
  if (typeof value !== "number") return String(value);
  if (Number.isInteger(value) && Math.abs(value) < 1e6) return String(value);
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(digits - 1);
  return String(Number(value.toPrecision(digits)));
}

/// A table whose rows are arrays of strings or numbers; `pick` is called with a row's index.
function table(head, rows, pick) {
  const made = element("table");
  const top = made.createTHead().insertRow();
  const isNumber = (column) => rows.some((row) => typeof row[column] === "number");
  head.forEach((text, column) => top.append(element("th", text, isNumber(column) ? "number" : undefined)));
  const body = made.createTBody();
  rows.forEach((row, k) => {
    const line = body.insertRow();
    row.forEach((cell) => {
      const kind = typeof cell === "number" ? "number" : undefined;
      line.append(element("td", typeof cell === "number" ? number(cell) : cell || "–", kind));
    });
    if (pick) {
      line.className = "pick";
      line.tabIndex = 0;
      line.addEventListener("click", () => pick(k));
      line.addEventListener("keydown", (event) => { if (event.key === "Enter") pick(k); });
    }
  });
  return made;
}

/// The bytes of a text of base64 that was compressed. It runs in a worker, too: it names nothing from outside.
async function unpack(text) {
  const letters = atob(text.trim());
  const packed = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k += 1) packed[k] = letters.charCodeAt(k);
  const plain = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(plain).arrayBuffer();
}

/// The same beside what else the page does; where there are no workers, here.
function unpackBeside(text) {
  const answer = "(made) => postMessage(made, [made]), () => postMessage(null)";
  const code = `onmessage = ({ data }) => (${unpack})(data).then(${answer});`;
  return new Promise((resolve) => {
    const here = () => resolve(unpack(text));
    try {
      const url = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
      const worker = new Worker(url);
      worker.addEventListener("message", ({ data }) => {
        worker.terminate();
        // What cannot be unpacked is tried here once more, so that the page says why.
        if (data) resolve(data); else here();
      });
      worker.addEventListener("error", here);
      worker.postMessage(text);
    } catch {
      here();
    }
  });
}

function tabs() {
  const buttons = [...document.querySelectorAll("[role=tab]")];
  const show = (button) => {
    for (const other of buttons) {
      other.setAttribute("aria-selected", String(other === button));
      $(other.getAttribute("aria-controls")).hidden = other !== button;
    }
    window.dispatchEvent(new Event("resize"));
  };
  buttons.forEach((button) => button.addEventListener("click", () => show(button)));
  if (buttons.length) show(buttons[0]);
}

function legend(mode, report) {
  const box = $("legend");
  box.replaceChildren();
  const entry = (colour, text) => {
    const mark = element("span", undefined, "mark");
    mark.style.background = colour;
    box.append(mark, element("span", text));
  };
  const scale = (low, high) => {
    const bar = element("span", undefined, "scale");
    bar.style.background = viridisCss();
    box.append(element("span", low), bar, element("span", high));
  };
  if (mode === "share") {
    entry("#3b7dd8", "solved");
    entry("#e08a2c", "sampled");
    if (report.fractures.some((fracture) => fracture.directed)) entry("#8a5cc9", "directed");
    entry("#8f959d", "did not break off");
  } else if (mode === "damage") {
    scale(`${number(report.damage[0] * 1e6)} µs after the hit`, `${number(report.damage[1] * 1e6)} µs`);
  } else if (mode === "speed") {
    scale("0 m/s", `${number(report.fastest)} m/s, square root`);
  }
}

class RunPage {
  constructor(report) {
    this.report = report;
    this.byId = new Map(report.bodies.map((body) => [body.id, body]));
    this.playing = false;
  }

  async start() {
    // The model is unpacked while the graphics process starts.
    const model = unpackBeside($("model").textContent);
    this.stage = new Stage($("canvas"), this.report);
    this.fill();
    await this.stage.load(await model);
    $("time").max = String(this.stage.duration);
    $("time").step = String(Math.max(this.stage.duration / 2000, 1e-4));
    this.wire();
    this.seek(this.report.first ?? 0);
    this.stage.show();
    document.documentElement.dataset.ready = "yes";
  }

  seek(time) {
    this.stage.seek(time);
    const now = this.stage.time;
    $("time").value = String(now);
    $("now").textContent = `${now.toFixed(3)} s`;
    const there = this.report.bodies.filter((b) => b.birth <= now && (b.end === null || b.end > now)).length;
    $("count").textContent = `${there} bodies`;
    this.charts.forEach((chart) => chart.draw(now));
  }

  play(on) {
    this.playing = on;
    $("play").textContent = on ? "❚❚" : "▶";
    $("play").setAttribute("aria-label", on ? "pause" : "play");
    if (!on) return;
    if (this.stage.time >= this.stage.duration - 1e-9) this.seek(0);
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      const next = this.stage.time + ((now - last) / 1000) * Number($("rate").value);
      last = now;
      this.seek(next);
      if (next >= this.stage.duration) this.play(false); else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  select(id) {
    this.stage.select(id);
    const box = $("facts");
    box.replaceChildren();
    const body = this.byId.get(id);
    if (!body) {
      box.append(element("p", "Click a piece to see what it is.", "hint"));
      return;
    }
    box.append(element("h3", body.name));
    const link = (other) => {
      const made = element("button", this.byId.get(other)?.name ?? String(other), "link");
      made.addEventListener("click", () => this.select(other));
      return made;
    };
    const list = element("dl");
    const add = (name, value) => {
      const cell = element("dd");
      cell.append(value instanceof Node ? value : String(value));
      list.append(element("dt", name), cell);
    };
    add("id", body.id);
    add("object", body.object);
    if (body.parent !== undefined && body.parent !== null) add("broke from", link(body.parent));
    add("material", body.material);
    add("mass", `${number(body.mass)} kg`);
    add("volume", `${number(body.volume)} m³`);
    add("born", `${number(body.birth)} s`);
    if (body.end !== null) add("ended", `${number(body.end)} s`);
    if (body.origin) add("by", body.origin);
    add("size class", body.tier);
    if (body.damage) {
      add("cracked", `${number(body.damage[0] * 1e6)}–${number(body.damage[1] * 1e6)} µs after the hit`);
    }
    const pieces = this.report.bodies.filter((other) => other.parent === id);
    if (pieces.length) add("pieces", pieces.length);
    box.append(list);
    $("tab-facts").click();
  }

  fill() {
    const { report } = this;
    $("title").textContent = report.title;
    $("what").textContent = report.about;
    document.title = `${report.title} – Cullet`;
    const marks = $("marks");
    for (const event of report.events.filter((e) => e.kind === "fractured" || e.kind === "deformed")) {
      const mark = element("span");
      mark.style.left = `${(100 * event.time) / report.duration}%`;
      mark.title = event.text;
      marks.append(mark);
    }
    // Tables that are not seen at first are made when they are.
    const later = (id, make) => {
      $(`tab-${id}`).addEventListener("click", () => $(id).append(make()), { once: true });
    };
    later("events", () => table(["time [s]", "event"], report.events.map((e) => [e.time, e.text]), (k) => {
      const event = report.events[k];
      this.play(false);
      this.seek(event.time);
      if (event.body !== null) this.select(event.body);
    }));
    const { fractures } = report;
    later("ledger", () => table(
      ["time [s]", "body", "by", "fragments", "sampled", "directed", "mass error", "momentum error",
        "energy before [J]", "after [J]", "crack [J]", "points", "spacing [m]"],
      fractures.map((f) => [f.time, f.name, f.solver, f.fragments, f.sampled, f.directed, f.mass_error,
        f.momentum_error, f.energy_before, f.energy_after, f.fracture_energy, f.points, f.spacing]),
      (k) => { this.seek(fractures[k].time); this.select(fractures[k].body); },
    ));
    $("facts-run").append(table(["figure", "value"], report.figures));
    const { times } = report.series;
    this.charts = report.series.charts.map((chart) => new Chart($("charts"), { times, ...chart }));
    legend("object", report);
    this.select(null);
  }

  wire() {
    $("time").addEventListener("input", () => { this.play(false); this.seek(Number($("time").value)); });
    $("play").addEventListener("click", () => this.play(!this.playing));
    $("mode").addEventListener("change", () => {
      this.stage.setMode($("mode").value);
      legend($("mode").value, this.report);
    });
    const canvas = $("canvas");
    let down = null;
    canvas.addEventListener("pointerdown", (event) => { down = [event.offsetX, event.offsetY]; });
    canvas.addEventListener("pointerup", (event) => {
      const moved = down ? Math.hypot(event.offsetX - down[0], event.offsetY - down[1]) : Infinity;
      if (moved < 4) this.select(this.stage.pick(event.offsetX, event.offsetY));
    });
    $("home").addEventListener("click", () => this.stage.look());
    window.addEventListener("resize", () => { this.stage.resize(); this.charts.forEach((c) => c.draw()); });
    window.addEventListener("keydown", (event) => {
      if (event.target.closest("input, select, button, [tabindex]") && event.key !== "Escape") return;
      const frame = this.report.frame;
      if (event.key === " ") this.play(!this.playing);
      else if (event.key === "ArrowRight") this.seek(this.stage.time + frame);
      else if (event.key === "ArrowLeft") this.seek(this.stage.time - frame);
      else if (event.key === "Escape") this.select(null);
      else return;
      event.preventDefault();
    });
  }
}

class SweepPage {
  constructor(report) { this.report = report; }

  start() {
    const { report } = this;
    $("title").textContent = report.title;
    $("what").textContent = report.about;
    document.title = `${report.title} – Cullet`;
    $("runs").append(table(report.columns, report.rows, (k) => this.show(k)));
    const grid = $("pictures");
    report.pictures.forEach((picture) => {
      const figure = element("figure");
      const image = element("img");
      image.src = `data:image/png;base64,${picture.png}`;
      image.alt = picture.name;
      figure.append(image, element("figcaption", picture.name));
      figure.addEventListener("click", () => this.show(picture.row));
      grid.append(figure);
    });
    $("close").addEventListener("click", () => { $("large").close(); });
    document.documentElement.dataset.ready = "yes";
  }

  show(k) {
    const picture = this.report.pictures.find((p) => p.row === k);
    if (!picture) return;
    $("large-image").src = `data:image/png;base64,${picture.png}`;
    $("large-name").textContent = picture.name;
    $("large").showModal();
  }
}

async function start() {
  const report = JSON.parse($("report").textContent);
  tabs();
  const page = report.kind === "sweep" ? new SweepPage(report) : new RunPage(report);
  window.cullet = page;
  await page.start();
}

start().catch((error) => {
  console.error(error);
  const box = $("fault");
  box.hidden = false;
  box.textContent = `This page could not be shown: ${error.message ?? error}`;
});
