// Small line charts on canvases, with the moment that is shown as a line.

const INK = "#30343a";
const GRID = "#d9dde3";

function nice(span, count) {
  const raw = span / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= raw);
  return step * power;
}

function label(value) {
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e4 || size < 1e-2)) return value.toExponential(0);
  return String(Number(value.toPrecision(3)));
}

export class Chart {
  /// `lines`: [{ name, colour, values }], values over `times` [s].
  constructor(parent, { title, unit, times, lines }) {
    Object.assign(this, { title, unit, times, lines });
    this.canvas = document.createElement("canvas");
    this.canvas.className = "chart";
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${title} [${unit}] over time [s]`);
    parent.append(this.canvas);
    this.time = 0;
  }

  draw(time = this.time) {
    this.time = time;
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width) return;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    const ink = this.canvas.getContext("2d");
    ink.scale(ratio, ratio);
    ink.font = "11px system-ui, sans-serif";
    const [left, right, top, bottom] = [46, width - 10, 24, height - 20];
    const end = this.times.at(-1) || 1;
    const most = Math.max(...this.lines.map((line) => Math.max(...line.values, 0)), 1e-12);
    const x = (t) => left + (t / end) * (right - left);
    const y = (v) => bottom - (v / (1.05 * most)) * (bottom - top);
    ink.strokeStyle = GRID;
    ink.fillStyle = INK;
    ink.textAlign = "right";
    for (let v = 0, step = nice(most, 4); v <= 1.05 * most; v += step) {
      ink.beginPath(); ink.moveTo(left, y(v)); ink.lineTo(right, y(v)); ink.stroke();
      ink.fillText(label(v), left - 5, y(v) + 4);
    }
    ink.textAlign = "center";
    for (let t = 0, step = nice(end, 6); t <= end; t += step) ink.fillText(label(t), x(t), height - 6);
    ink.textAlign = "left";
    ink.fillText(`${this.title} [${this.unit}]`, left, 14);
    for (const line of this.lines) {
      ink.strokeStyle = line.colour;
      ink.lineWidth = 1.6;
      ink.beginPath();
      line.values.forEach((v, k) => {
        const at = [x(this.times[k]), y(v)];
        if (k === 0) ink.moveTo(...at); else ink.lineTo(...at);
      });
      ink.stroke();
    }
    if (this.lines.length > 1) {
      let at = right;
      ink.textAlign = "right";
      for (const line of [...this.lines].reverse()) {
        ink.fillStyle = line.colour;
        ink.fillText(line.name, at, 14);
        at -= ink.measureText(line.name).width + 12;
      }
    }
    ink.strokeStyle = "#c2410c";
    ink.lineWidth = 1;
    ink.beginPath(); ink.moveTo(x(time), top); ink.lineTo(x(time), bottom); ink.stroke();
  }
}
