// Histories over time, with a cursor at the frame that is shown.

import {element, inUnit, lastBefore, lineColor, short, ticks, variable} from "./words.js";

const RIGHT = 8, FOOT = 18;  // pixels beside and below the field
const UNSEEN = 1e-6;  // of the largest value of a chart: less is told as nothing

export class Chart {
  constructor(parent, title, unit, onTime) {
    const box = element("figure", parent, "", "chart");
    this.caption = element("figcaption", box);
    this.words = title;
    this.title = element("span", this.caption, title, "chart-title");
    this.keys = element("span", this.caption, "", "chart-keys");
    const field = element("div", box, "", "chart-field");
    this.canvas = element("canvas", field);
    this.mark = element("div", field, "", "chart-cursor");
    this.unit = unit;
    this.lines = [];
    this.time = 0;
    this.span = null;
    const scrub = (event) => {
      if (event.buttons & 1 || event.type === "pointerdown") onTime(this.timeAt(event));
    };
    this.canvas.addEventListener("pointerdown", scrub);
    this.canvas.addEventListener("pointermove", scrub);
    this.canvas.addEventListener("wheel", (event) => {
      if (!this.onZoom || !event.ctrlKey) return;
      event.preventDefault();
      this.onZoom(Math.exp(0.002 * event.deltaY), this.timeAt(event));
    }, {passive: false});
    this.canvas.addEventListener("dblclick", () => this.onZoom?.(Infinity, this.time));
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  setSpan(span) {
    this.span = span;
    this.draw();
  }

  get begin() {
    return this.span ? this.span[0] : 0;
  }

  get finish() {
    return this.span ? this.span[1] : this.end;
  }

  /** Lines over time; stacked: each above the sum of those before it. */
  set(lines, stacked = false) {
    this.lines = lines;
    this.stacked = stacked;
    let below = null;
    for (const line of lines) {
      line.top = stacked ? line.y.map((v, i) => v + (below ? below[i] : 0)) : line.y;
      if (stacked) below = line.top;
    }
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
      for (const value of line.top) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
      end = Math.max(end, line.x[line.x.length - 1]);
    }
    [this.scale, this.name] = inUnit(Math.max(Math.abs(low), Math.abs(high)), this.unit);
    this.title.textContent = `${this.words} (${this.name})`;
    this.low = low / this.scale;
    this.high = (high > low ? high : low + 1) / this.scale;
    this.end = end || 1;
    this.draw();
  }

  timeAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const share = (event.clientX - box.left - this.left) / (box.width - this.left - RIGHT);
    return this.begin + Math.min(Math.max(share, 0), 1) * (this.finish - this.begin);
  }

  cursor(time) {
    this.time = time;
    for (const line of this.lines) {
      const value = line.y[lastBefore(line.x, time)] / this.scale, most = Math.max(this.high, -this.low);
      line.value.textContent = `${short(Math.abs(value) < UNSEEN * most ? 0 : value)} ${this.name}`;
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
    const share = (this.time - this.begin) / (this.finish - this.begin);
    const x = this.left + (this.canvas.clientWidth - this.left - RIGHT) * share;
    this.mark.hidden = share < 0 || share > 1;
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
    const bottom = height - FOOT, pad = 0.06 * (this.high - this.low);
    const wide = width - this.left - RIGHT, long = this.finish - this.begin;
    const X = (t) => this.left + wide * (t - this.begin) / long;
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
      c.lineTo(width - RIGHT, Y(t));
      c.stroke();
      c.fillText(short(t), this.left - 5, Y(t));
    }
    c.textAlign = "center";
    c.textBaseline = "top";
    this.state = {ticks: marks.map((t) => short(t)), unit: this.name};
    const times = ticks(this.begin, this.finish, Math.max(3, width / 90));
    for (const [i, t] of times.entries()) {
      const text = short(t) + (i === times.length - 1 ? " s" : "");
      const half = c.measureText(text).width / 2;
      c.fillText(text, Math.min(X(t), width - half), bottom + 4);
    }
    c.save();
    c.beginPath();
    c.rect(this.left, 0, wide, height);
    c.clip();
    for (const [i, line] of this.lines.entries()) this.drawLine(c, line, this.lines[i - 1], X, Y);
    c.restore();
    this.point();
  }

  /** A line, or in a stack the area between it and the one below. */
  drawLine(c, line, below, X, Y) {
    c.strokeStyle = c.fillStyle = line.color;
    c.lineWidth = 1.3;
    c.beginPath();
    for (let i = 0; i < line.x.length; i++) c.lineTo(X(line.x[i]), Y(line.top[i] / this.scale));
    if (this.stacked) {
      for (let i = line.x.length - 1; i >= 0; i--) {
        c.lineTo(X(line.x[i]), Y(below ? below.top[i] / this.scale : 0));
      }
      c.globalAlpha = 0.75;
      c.fill();
      c.globalAlpha = 1;
    } else {
      c.stroke();
    }
  }
}
