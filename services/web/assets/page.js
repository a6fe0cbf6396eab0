// The page of a farm. It shows what /events sends and asks for nothing else but pictures. Names and
// texts come from other users: they are put in as text, never as HTML.
"use strict";

const byId = (id) => document.getElementById(id);
/// The state: the farm's clock and totals, runs by number, workers.
const farm = { clock: null, runs: new Map(), workers: [], leaving: false };
/// How far this browser's clock is behind the farm's [ms].
let behind = 0;
/// When something was last heard [ms].
let heard = 0;
/// Finished runs that are shown.
const STEP = 100;
let most = STEP;
/// Longest silence: the farm says something every 5 s [ms].
const SILENCE = 16_000;
/// Samples of a run's progress, to estimate what is left: [ms, share].
const paces = new Map();

const now = () => Date.now() + behind;

// ---- Words.

const number = (value) => Math.round(value).toLocaleString("en");

function span(ms) {
  const s = Math.max(0, ms) / 1000;
  if (s < 10) return `${s.toFixed(1)} s`;
  if (s < 100) return `${Math.round(s)} s`;
  const min = Math.floor(s / 60);
  if (min < 60) return `${min} min ${String(Math.round(s - 60 * min) % 60).padStart(2, "0")} s`;
  const h = Math.floor(min / 60);
  if (h < 48) return `${h} h ${String(min % 60).padStart(2, "0")} min`;
  return `${Math.floor(h / 24)} days ${h % 24} h`;
}

/// A span no finer than it is known.
function about(ms) {
  const s = ms / 1000;
  if (s < 10) return `about ${Math.ceil(s)} s`;
  if (s < 100) return `about ${5 * Math.ceil(s / 5)} s`;
  if (s < 6000) return `about ${Math.ceil(s / 60)} min`;
  return `about ${Math.ceil(s / 3600)} h`;
}

function ago(ms) {
  const passed = now() - ms;
  return passed < 60_000 ? `${Math.max(0, Math.round(passed / 1000))} s ago` : `${span(passed)} ago`;
}

function clockOf(ms) {
  const at = new Date(ms);
  const time = at.toLocaleTimeString("en-GB", { hour: "2-digit", minute: "2-digit" });
  return at.toDateString() === new Date().toDateString() ? time : `${at.toISOString().slice(0, 10)} ${time}`;
}

function bytes(count) {
  if (count === null || count === undefined) return "";
  if (count >= 1e12) return `${(count / 1e12).toFixed(1)} TB`;
  return count >= 1e9 ? `${(count / 1e9).toFixed(1)} GB` : `${Math.round(count / 1e6)} MB`;
}


/// Exit codes that a finished run may have, in words.
const CODES = {
  3: "it is done, and an expectation of the scene does not hold",
  4: "it is done, and a picture could not be drawn",
  5: "it was cancelled",
  6: "the pool gave up one of its jobs; cullet show names it, cullet retry tries again",
};

// ---- Elements.

function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

/// Changes a text only if it is another: a reader of the screen is not told the same again.
function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

function pairs(list, rows) {
  while (list.children.length > rows.length) list.lastElementChild.remove();
  rows.forEach(([name, value], k) => {
    let row = list.children[k];
    if (!row) {
      row = element("div");
      row.append(element("dt"), element("dd"));
      list.append(row);
    }
    say(row.firstElementChild, name);
    say(row.lastElementChild, value);
  });
}

/// The same in a list whose terms and values are its own children.
function figures(list, rows) {
  while (list.children.length > 2 * rows.length) list.lastElementChild.remove();
  rows.forEach(([name, value], k) => {
    if (!list.children[2 * k]) list.append(element("dt"), element("dd"));
    say(list.children[2 * k], name);
    say(list.children[2 * k + 1], value);
  });
}

/// Rows of a table that are there stay where they are, so that focus and selection do.
function fill(body, items, key, cells) {
  const labels = [...body.parentElement.querySelectorAll("th")].map((th) => th.textContent);
  const old = new Map([...body.children].map((row) => [row.dataset.key, row]));
  let before = null;
  for (const item of items) {
    const id = key(item);
    let row = old.get(id);
    old.delete(id);
    if (!row) {
      row = element("tr");
      row.dataset.key = id;
      labels.forEach((label) => {
        const cell = element("td");
        cell.dataset.label = label;
        row.append(cell);
      });
    }
    cells(item).forEach((content, k) => {
      const cell = row.children[k];
      const { text, className = "", parts } = typeof content === "string" ? { text: content } : content;
      if (cell.className !== className) cell.className = className;
      if (parts === undefined) {
        say(cell, text);
      } else if (cell.dataset.parts !== JSON.stringify(parts)) {
        cell.dataset.parts = JSON.stringify(parts);
        cell.replaceChildren(...parts.map(part));
      }
    });
    const place = before ? before.nextElementSibling : body.firstElementChild;
    if (place !== row) body.insertBefore(row, place);
    before = row;
  }
  old.forEach((row) => row.remove());
}

function part({ tag = "span", text, className, href, title }) {
  const made = element(tag, text, className);
  if (title) made.title = title;
  if (href) {
    made.href = href;
    made.target = "_blank";
    made.rel = "noopener";
  }
  return made;
}

// ---- The parts of the page.

function stateOf(run) {
  if (run.state === "done") return run.code === 0 ? ["done", "good"] : [`done, code ${run.code}`, "warn"];
  if (run.state === "failed" || run.state === "stalled") return [run.state, "bad"];
  if (run.state === "cancelled") return ["cancelled", "warn"];
  return [run.state, "idle"];
}

function why(run) {
  if (run.text) return run.text;
  return run.code && CODES[run.code] ? CODES[run.code] : "";
}

/// A run's scene, with what tells it from others of it.
function nameOf(run) {
  const more = [run.sweep && `sweep ${run.sweep}`, ...run.overrides].filter(Boolean).join(" · ");
  return { parts: [{ text: run.name }, ...(more ? [{ tag: "div", text: more, className: "why" }] : [])], className: "name" };
}

/// What is left of a run [ms], from how it got on in the last half of its time; null: unknown.
function left(run, share) {
  const all = paces.get(run.run) ?? [];
  const last = all[all.length - 1];
  const t = now();
  if (!last || t - last[0] > 500) all.push([t, share]);
  const since = Math.max(run.started_ms ?? t, t - Math.max(15_000, (t - (run.started_ms ?? t)) / 2));
  while (all.length > 2 && all[1][0] < since) all.shift();
  if (all.length > 400) all.splice(1, 200);
  paces.set(run.run, all);
  const elapsed = t - (run.started_ms ?? t);
  if (elapsed < 3000 || share < 0.05) return null;
  const mean = share / elapsed;
  const lately = all.length > 1 && t - all[0][0] > 4000 ? (share - all[0][1]) / (t - all[0][0]) : mean;
  // Where both tell very different things, nothing is known.
  if (!(lately > 0) || lately > 3 * mean || mean > 3 * lately) return null;
  return (1 - share) / Math.sqrt(mean * lately);
}

const cards = new Map();

function card(run) {
  let made = cards.get(run.run);
  if (!made) {
    made = byId("card").content.firstElementChild.cloneNode(true);
    made.querySelector(".shot").addEventListener("click", () => enlarge(run.run));
    cards.set(run.run, made);
  }
  const find = (selector) => made.querySelector(selector);
  made.setAttribute("aria-label", `Run ${run.run}, ${run.name}`);
  say(find(".number"), `${run.run}`);
  say(find(".name"), run.name);
  const who = [run.user, run.sweep && `sweep ${run.sweep}`, run.attempt > 1 && `attempt ${run.attempt}`];
  say(find(".who"), [...who.filter(Boolean), ...run.overrides].join(" · "));
  const at = run.position;
  // One that was somewhere and is nowhere has taken all its steps.
  if (at) made.dataset.begun = `${run.attempt}`;
  const ends = !at && made.dataset.begun === `${run.attempt}`;
  const share = at && at.end > 0 ? Math.min(1, at.time / at.end) : Number(ends);
  find("progress").value = share;
  find("progress").setAttribute("aria-label", `Progress of run ${run.run}`);
  say(find(".percent"), at || ends ? `${(100 * share).toFixed(share < 0.1 ? 1 : 0)} %` : "");
  const rows = [];
  if (ends) rows.push(["Step", "all are taken; its files are written"]);
  if (at) {
    if (at.steps) rows.push(["Step", `${number(at.step)} of ${number(at.steps)}`]);
    rows.push(["Simulated", `${at.time.toFixed(3)} of ${at.end.toFixed(3)} s`]);
    rows.push(["Bodies", number(at.bodies)], ["Fractures", number(at.fractures)]);
    const solving = at.permille ? ` (at work: ${Math.floor(at.permille / 10)} %)` : "";
    rows.push(["Jobs", at.jobs ? `${number(at.jobs)} to do${solving}` : "none to wait for"]);
  }
  if (run.started_ms) {
    const rest = left(run, share);
    const time = span(now() - run.started_ms);
    rows.push(["Time so far", rest === null ? time : `${time}, ${about(rest)} left`]);
  }
  figures(find(".figures"), rows);
  say(find(".line"), run.line);
  picture(find("img"), run);
  find(".noshot").hidden = !find("img").hidden;
  find(".shot").disabled = find("img").hidden;
  return made;
}

/// Shows the newest picture; the one before stays until it is there.
function picture(image, run) {
  if (!run.picture || image.dataset.picture === run.picture) return;
  image.dataset.picture = run.picture;
  const next = new Image();
  next.onload = () => {
    image.src = next.src;
    image.alt = `Run ${run.run} as it is now`;
    image.hidden = false;
    schedule();
  };
  next.src = `/runs/${run.run}/picture?${encodeURIComponent(run.picture)}`;
}

function enlarge(number) {
  const run = farm.runs.get(number);
  if (!run || !run.picture) return;
  say(byId("large-name"), `Run ${run.run}: ${run.name}`);
  byId("large-image").src = `/runs/${run.run}/picture?${encodeURIComponent(run.picture)}`;
  byId("large-image").alt = `Picture of run ${run.run}`;
  if (!byId("large").open) byId("large").showModal();
}

function running(runs) {
  const box = byId("running");
  const wanted = runs.map(card);
  for (const [number, made] of cards) {
    if (!wanted.includes(made)) {
      made.remove();
      cards.delete(number);
      paces.delete(number);
    }
  }
  wanted.forEach((made, k) => {
    if (box.children[k] !== made) box.insertBefore(made, box.children[k] ?? null);
  });
  byId("running-none").hidden = runs.length > 0;
}

function queue(runs) {
  fill(byId("queue").tBodies[0], runs, (run) => String(run.run), (run) => [
    { text: String(run.run), className: "num" },
    nameOf(run),
    run.user,
    { text: String(run.priority), className: "num" },
    { parts: [{ text: run.state, className: "state idle" }, ...(run.line ? [{ tag: "div", text: run.line, className: "why" }] : [])] },
    { text: clockOf(run.submitted_ms), className: "num" },
  ]);
  byId("queue").parentElement.hidden = runs.length === 0;
  byId("queue-none").hidden = runs.length > 0;
  say(byId("queue-count"), runs.length ? number(runs.length) : "");
}

function workers(all) {
  const state = (worker) => {
    if (!worker.up) return ["gone", "warn"];
    if (worker.drained) return [worker.jobs.length ? "finishes its job, then leaves" : "drained", "warn"];
    return worker.jobs.length ? ["solving", "good"] : ["idle", "idle"];
  };
  fill(byId("workers").tBodies[0], all, (worker) => worker.session, (worker) => {
    const [text, kind] = state(worker);
    const twin = worker.twin ? [{ tag: "div", text: "another worker has this name", className: "why" }] : [];
    return [
      { parts: [{ text: worker.name }, ...twin], className: "name" },
      { parts: [{ text, className: `state ${kind}` }] },
      { text: worker.jobs.map((job) => job.slice(0, 8)).join(" "), className: "mono" },
      { text: `${worker.threads} of ${worker.cores} cores`, className: "num" },
      { text: number(worker.done), className: "num" },
      { text: worker.gone_ms === null ? "now" : ago(worker.gone_ms), className: "short" },
    ];
  });
  const up = all.filter((worker) => worker.up).length;
  byId("workers").parentElement.hidden = all.length === 0;
  byId("workers-none").hidden = all.length > 0;
  say(byId("workers-count"), all.length ? `${up} of ${all.length} connected` : "");
}

function over(all) {
  const wish = byId("filter").value;
  const words = byId("search").value.trim().toLowerCase();
  const fits = (run) =>
    (wish === "all" || (wish === "done") === (run.state === "done")) &&
    `${run.name}\n${run.user}\n${run.sweep}`.toLowerCase().includes(words);
  const some = all.filter(fits);
  fill(byId("over").tBodies[0], some.slice(0, most), (run) => String(run.run), (run) => {
    const [text, kind] = stateOf(run);
    const reason = why(run);
    const known = run.figures && run.figures.digest ? run.figures : null;
    const took = run.started_ms && run.ended_ms ? span(run.ended_ms - run.started_ms) : "";
    const at = `/runs/${run.run}`;
    const links = [];
    if (run.picture) links.push({ tag: "a", text: "picture", href: `${at}/picture` });
    if (run.report) links.push({ tag: "a", text: "report", href: `${at}/report` });
    links.forEach((link) => { link.title = `${link.text} of run ${run.run}`; });
    return [
      { text: String(run.run), className: "num" },
      nameOf(run),
      run.user,
      { parts: [{ text, className: `state ${kind}` }, ...(reason ? [{ tag: "div", text: reason, className: "why" }] : [])] },
      { text: known ? number(known.fractures) : "", className: "num" },
      { text: known ? number(known.fragments) : "", className: "num" },
      { text: took, className: "num" },
      { text: run.ended_ms ? clockOf(run.ended_ms) : "", className: "short" },
      { parts: known ? [{ text: known.digest.slice(0, 10), className: "mono", title: known.digest }] : [], className: "short" },
      { parts: links },
    ];
  });
  byId("over").parentElement.hidden = some.length === 0;
  byId("over-none").hidden = some.length > 0;
  say(byId("over-none"), all.length ? "None of these." : "No run has ended.");
  say(byId("over-count"), all.length ? number(all.length) : "");
  byId("more").hidden = some.length <= most;
}

function header(runs) {
  const clock = farm.clock;
  const local = clock.name === "";
  const one = local && farm.runs.size === 1 ? [...farm.runs.values()][0].name : "Runs on this machine";
  say(byId("title"), local ? one : `Farm ${clock.name}`);
  const title = `${runs.running.length ? `${runs.running.length} running · ` : ""}${byId("title").textContent} · Cullet`;
  if (document.title !== title) document.title = title;
  say(byId("about"), `Cullet ${clock.version}, up ${span(Math.floor(clock.up_ms / 1000) * 1000)}`);
  const up = farm.workers.filter((worker) => worker.up);
  const busy = up.filter((worker) => worker.jobs.length > 0).length;
  pairs(byId("totals"), [
    ["running", local ? number(runs.running.length) : `${runs.running.length} of ${clock.runs_at_once}`],
    ["waiting", number(runs.waiting.length)],
    ["workers solving", `${busy} of ${up.length}`],
    ["jobs at workers", number(clock.jobs_running)],
    ["jobs waiting", number(clock.jobs_waiting)],
    ...(clock.free_bytes ? [["disk free", bytes(clock.free_bytes)]] : []),
  ]);
}

function draw() {
  if (!farm.clock) return;
  const all = [...farm.runs.values()].sort((a, b) => a.run - b.run);
  const runs = {
    running: all.filter((run) => run.state === "running"),
    waiting: all.filter((run) => run.state === "queued" || run.state === "paused"),
    over: all.filter((run) => ["done", "failed", "stalled", "cancelled"].includes(run.state)).reverse(),
  };
  // As the farm takes them: by priority, then by age.
  runs.waiting.sort((a, b) => b.priority - a.priority || a.run - b.run);
  header(runs);
  running(runs.running);
  queue(runs.waiting);
  workers(farm.workers);
  over(runs.over);
  document.documentElement.dataset.ready = "yes";
}

let planned = false;
function schedule() {
  if (planned) return;
  planned = true;
  requestAnimationFrame(() => {
    planned = false;
    draw();
  });
}

// ---- The connection.

let source = null;
let retry = 0;

function state(kind, text) {
  byId("link").dataset.state = kind;
  say(byId("link-text"), text);
}

function lost(text) {
  if (byId("link").dataset.state === "lost") return;
  state("lost", "connection lost");
  const since = new Date().toLocaleTimeString("en-GB");
  say(byId("lost"), `${text} What is shown is of ${since}; trying again.`);
  byId("lost").hidden = false;
  document.body.classList.add("stale");
}

function live() {
  heard = Date.now();
  state("live", "live");
  byId("lost").hidden = true;
  document.body.classList.remove("stale");
}

function take(event, whole) {
  const news = JSON.parse(event.data);
  if (!news) return;
  const { runs, gone = [], workers: crew, leaving, ...clock } = news;
  if (whole) farm.runs.clear();
  for (const run of runs) farm.runs.set(run.run, run);
  for (const run of gone) farm.runs.delete(run);
  if (crew) farm.workers = crew;
  farm.clock = clock;
  farm.leaving = leaving;
  if (clock.now_ms) behind = clock.now_ms - Date.now();
  live();
  if (leaving) {
    lost(clock.name === "" ? "The runs are over, and the program that showed them has ended." : "The coordinator has stopped.");
  }
  schedule();
}

function connect() {
  if (source) source.close();
  source = new EventSource("/events");
  source.addEventListener("farm", (event) => take(event, true));
  source.addEventListener("change", (event) => take(event, false));
  source.onerror = () => {
    if (!farm.leaving) lost("The connection to the farm is lost.");
    // The browser tries again by itself, unless it was refused.
    if (source.readyState === EventSource.CLOSED) again();
  };
}

function again() {
  clearTimeout(retry);
  retry = setTimeout(connect, 3000);
}

setInterval(() => {
  if (heard && Date.now() - heard > SILENCE) {
    lost("Nothing has been heard of the farm for a while.");
    heard = Date.now();
    connect();
  }
  // Times go on.
  if (byId("link").dataset.state === "live") schedule();
}, 1000);

byId("filter").addEventListener("change", () => { most = STEP; schedule(); });
byId("search").addEventListener("input", () => { most = STEP; schedule(); });
byId("more").addEventListener("click", () => { most += STEP; schedule(); });
byId("close").addEventListener("click", () => byId("large").close());
byId("running").addEventListener("keydown", (event) => {
  const made = event.target;
  if (event.key === "Enter" && made.classList.contains("card")) made.querySelector(".shot").click();
});
connect();
