// Histories over time, with a cursor at the frame that is shown.

import {DARK, element, inUnit, short, ticks, variable} from "./words.js";

const ON_LIGHT = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b58900", "#7a58b0", "#4a90a4",
  "#a05a2c"];
const ON_DARK = ["#5ab4f0", "#ff9a4d", "#4fd1a5", "#f0a6cf", "#e6c34a", "#b79df0", "#7fd0e0",
  "#d9a07a"];
const lineColor = (i) => (DARK.matches ? ON_DARK : ON_LIGHT)[i % ON_LIGHT.length];

export class Chart {
  constructor(parent, title, unit, onTime) {
    const box = element("figure", parent, "", "chart");
    this.caption = element("figcaption", box);
    this.title = element("span", this.caption, title, "chart-title");
    this.keys = element("span", this.caption, "", "chart-keys");
    const field = element("div", box, "", "chart-field");
    this.canvas = element("canvas", field);
    this.mark = element("div", field, "", "chart-cursor");
    this.unit = unit;
    this.lines = [];
    this.time = 0;
    const scrub = (event) => {
      if (event.buttons & 1 || event.type === "pointerdown") onTime(this.timeAt(event));
    };
    this.canvas.addEventListener("pointerdown", scrub);
    this.canvas.addEventListener("pointermove", scrub);
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  set(lines) {
    this.lines = lines;
    this.keys.replaceChildren();
    for (const [i, line] of lines.entries()) {
      const key = element("span", this.keys, "", "key");
      line.color = lineColor(i);
      element("i", key).style.background = line.color;
      element("span", key, line.label);
      line.value = element("b", key);
    }
    let low = 0, high = 0, end = 0;
    for (const line of lines) {
      for (const value of line.y) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
      end = Math.max(end, line.x[line.x.length - 1]);
    }
    [this.scale, this.name] = inUnit(Math.max(Math.abs(low), Math.abs(high)), this.unit);
    this.low = low / this.scale;
    this.high = (high > low ? high : low + 1) / this.scale;
    this.end = end || 1;
    this.draw();
  }

  timeAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const share = (event.clientX - box.left - this.left) / (box.width - this.left - 8);
    return Math.min(Math.max(share, 0), 1) * this.end;
  }

  cursor(time) {
    this.time = time;
    for (const line of this.lines) {
      let low = 0, high = line.x.length - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (line.x[middle] <= time) low = middle; else high = middle;
      }
      line.value.textContent = `${short(line.y[low] / this.scale)} ${this.name}`;
    }
    this.point();
  }

  /** Every other stage of the run shaded, with its name. */
  shadeStages(c, X, bottom) {
    const stages = this.stages || [];
    c.textAlign = "left";
    c.textBaseline = "top";
    for (const [i, [name, begin]] of stages.entries()) {
      const end = i + 1 < stages.length ? stages[i + 1][1] : this.end;
      if (i % 2) {
        c.globalAlpha = 0.5;
        c.fillStyle = variable("--rule");
        c.fillRect(X(begin), 4, X(end) - X(begin), bottom - 4);
        c.globalAlpha = 1;
      }
      c.fillStyle = variable("--faint");
      if (end > begin) c.fillText(name, X(begin) + 3, 5, Math.max(X(end) - X(begin) - 6, 8));
    }
  }

  point() {
    const x = this.left + (this.canvas.clientWidth - this.left - 8) * this.time / this.end;
    this.mark.style.transform = `translateX(${x}px)`;
  }

  draw() {
    const ratio = window.devicePixelRatio || 1;
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height || !this.lines.length) return;
    if (this.canvas.width !== Math.round(width * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const c = this.canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    c.font = "11px system-ui, sans-serif";
    const marks = ticks(this.low, this.high, 4);
    this.left = 8 + Math.max(...marks.map((t) => c.measureText(short(t)).width));
    const bottom = height - 18, pad = 0.06 * (this.high - this.low);
    const X = (t) => this.left + (width - this.left - 8) * t / this.end;
    const Y = (v) => bottom - (bottom - 6) * (v - this.low + pad) / (this.high - this.low + 2 * pad);
    this.shadeStages(c, X, bottom);
    c.lineWidth = 1;
    c.strokeStyle = variable("--rule");
    c.fillStyle = variable("--faint");
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const t of marks) {
      c.beginPath();
      c.moveTo(this.left, Y(t));
      c.lineTo(width - 8, Y(t));
      c.stroke();
      c.fillText(short(t), this.left - 5, Y(t));
    }
    c.textAlign = "center";
    c.textBaseline = "top";
    for (const t of ticks(0, this.end, Math.max(2, width / 90))) {
      if (X(t) < width - 22) c.fillText(short(t), X(t), bottom + 4);
    }
    c.textAlign = "right";
    c.fillText("s", width - 4, bottom + 4);
    for (const line of this.lines) {
      c.strokeStyle = line.color;
      c.lineWidth = 1.3;
      c.beginPath();
      for (let i = 0; i < line.x.length; i++) c.lineTo(X(line.x[i]), Y(line.y[i] / this.scale));
      c.stroke();
    }
    this.point();
  }
}
