// The interactive view of blocks: draws them and lets the user play, scrub, zoom, pan and pick.

import {Chart} from "./chart.js";
import {Model, SAMPLES, SHOWN} from "./model.js";
import {FlatPainter, GlPainter, Lines} from "./painters.js";
import {floats, quantile, value} from "./streams.js";
import {DARK, element, inUnit, mapped, rgb, short, variable, withUnit} from "./words.js";

const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];
const DASHES = 12;  // of each leg of a broken bolt

export class View {
  constructor(root) {
    this.root = root;
    this.frame = 0;
    this.picked = -1;
    this.playing = false;
    this.factor = 1;
    this.contacts = "none";
    this.camera = {x: 0, y: 0, scale: 1, width: 1, height: 1};
    this.lines = new Lines();
    this.state = {ready: false, decoded: false, frame: 0, picked: "", renderer: "", draws: 0,
      drawMs: 0, firstFrameMs: 0, decodedMs: 0, note: ""};
    this.build();
  }

  // The elements of the page

  build() {
    const root = this.root;
    root.replaceChildren();
    this.stage = element("div", root, "", "stage");
    this.canvas = element("canvas", this.stage, "", "blocks");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Blocks; arrow keys step, space plays, + and - zoom, [ and ] pick");
    this.overlay = element("canvas", this.stage, "", "overlay");
    this.aside = element("div", root, "", "side");
    this.buildBar();
    this.legend = element("div", this.aside, "", "legend");
    this.info = element("div", this.aside, "", "info");
    this.note = element("p", this.aside, "", "note");
    this.charts = element("div", root, "", "charts");
    this.stage.addEventListener("wheel", (event) => this.wheel(event), {passive: false});
    this.pointers = new Map();
    for (const kind of ["pointerdown", "pointermove", "pointerup", "pointercancel"]) {
      this.stage.addEventListener(kind, (event) => this.pointer(event));
    }
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.resize()).observe(this.stage);
    DARK.addEventListener("change", () => {
      for (const plot of this.plots || []) plot.set(plot.lines);
      if (this.blockChart) this.blockChart.set(this.blockChart.lines);
      this.legendKey = "";
      this.refresh();
    });
  }

  buildBar() {
    const bar = element("div", this.root, "", "bar");
    const button = (text, label, act) => {
      const node = element("button", bar, text);
      node.type = "button";
      node.title = label;
      node.setAttribute("aria-label", label);
      node.addEventListener("click", act);
      return node;
    };
    button("‹", "one frame back", () => this.show(this.frame - 1));
    this.playButton = button("▶", "play", () => this.play(!this.playing));
    this.playButton.classList.add("play");
    button("›", "one frame on", () => this.show(this.frame + 1));
    this.slider = element("input", bar, "", "time");
    this.slider.type = "range";
    this.slider.min = 0;
    this.slider.setAttribute("aria-label", "frame");
    this.slider.addEventListener("input", () => this.show(+this.slider.value));
    this.clock = element("output", bar, "", "clock");
    const select = (label, options, value, act) => {
      const field = element("label", bar, "", "field");
      element("span", field, label);
      const node = element("select", field);
      for (const [key, text] of options) {
        const option = element("option", node, text);
        option.value = key;
      }
      node.value = value;
      node.addEventListener("change", () => act(node.value));
      return node;
    };
    this.speedSelect = select("speed", SPEEDS.map((s) => [s, `× ${s}`]), 1,
      (v) => { this.speed = +v; });
    this.colorSelect = select("color", [["material", "material"],
      ["displacement", "displacement"], ["velocity", "velocity"], ["rotation", "rotation"],
      ["stress", "compression"]], "material", (v) => this.setColor(v));
    this.contactSelect = select("contacts", [["none", "none"], ["force", "forces"],
      ["slip", "slip"], ["open", "opening"]], "none", (v) => this.setContacts(v));
    select("scale", [["all", "all frames"], ["own", "this frame"]], "all", (v) => {
      this.ownScale = v === "own";
      this.refresh();
    });
    const factors = [1, 2, 5, 10, 20, 50, 100, 1000];
    select("deformation", factors.map((f) => [f, `× ${f}`]), 1, (v) => {
      this.factor = +v;
      this.refresh();
    });
    button("fit", "show the whole model", () => this.fit()).classList.add("fit");
  }

  /** Choices that depend on what is shown. */
  offer() {
    const {meta} = this, frames = this.model.frames;
    this.slider.max = frames - 1;
    this.slider.value = this.frame;
    const last = meta.time[frames - 1] - meta.time[0];
    this.speed = SPEEDS.reduce((a, b) => Math.abs(Math.log(last / b / 10))
      < Math.abs(Math.log(last / a / 10)) ? b : a);
    if (last > 4 && last < 40) this.speed = 1;
    this.speedSelect.value = this.speed;
    const there = {none: true, force: meta.pairs > 0, slip: meta.faces > 0, open: meta.faces > 0};
    for (const option of this.contactSelect.options) {
      option.hidden = option.disabled = !there[option.value];
    }
    this.colorSelect.value = this.color;
    this.root.classList.toggle("still", frames === 1);
  }

  // Start

  /** The model that a view shows. */
  modelOf(meta, streams) {
    return new Model(meta, streams);
  }

  /** Show what is plain and the streams of the rest (`encode.py`), in place of what was shown. */
  async begin(meta, streams) {
    const begun = performance.now();
    const model = this.modelOf(meta, streams);
    await model.readShapes();
    Object.assign(this, {meta, streams, model, color: this.color || meta.color});
    this.legendKey = this.overlaid = "";
    this.owner = this.most = this.commonForce = this.boltForce = undefined;
    this.offer();
    this.prepare();
    this.state.ready = true;
    this.state.firstFrameMs = performance.now() - begun;
    await new Promise((done) => setTimeout(done, 0));
    await model.readMotion();
    model.restPoses = model.poses(-1);
    await this.buildCharts();
    this.state.decoded = true;
    this.state.decodedMs = performance.now() - begun;
    this.tell();
    this.show(meta.frame ?? model.frames - 1);
  }

  /** The painter with the shapes of the model, and the camera. */
  prepare() {
    if (this.painter) this.painter.load(this.model); else this.choosePainter();
    this.tints = new Uint8Array(4 * this.model.vertices);
    const areas = Array.from({length: this.model.n}, (_, b) => this.model.area(b));
    areas.sort((a, b) => a - b);
    this.side = Math.sqrt(Math.max(areas[areas.length >> 1], 0));
    this.resize();
    if (this.moved) this.refresh(); else this.fit();
  }

  choosePainter() {
    try {
      this.painter = new GlPainter(this.canvas, this.model);
    } catch {
      const fresh = this.canvas.cloneNode();
      this.canvas.replaceWith(fresh);
      this.canvas = fresh;
      this.canvas.addEventListener("keydown", (event) => this.key(event));
      this.painter = new FlatPainter(this.canvas, this.model);
    }
    this.state.renderer = this.painter.kind;
  }

  tell() {
    const m = this.meta, words = [this.painter.note];
    if (m.all_frames > this.model.frames) {
      words.push(`${this.model.frames.toLocaleString("en")} of `
        + `${m.all_frames.toLocaleString("en")} frames are in this file, to keep it small.`);
    }
    if (m.coarse) words.push("Velocities and stresses are coarse here, places are not.");
    if (m.no_forces) words.push(`Without ${m.no_forces}.`.replace("contact forces would",
      "contact forces: they would"));
    this.note.textContent = words.filter(Boolean).join(" ");
    this.state.note = this.note.textContent;
  }

  async buildCharts() {
    this.plots = [];
    this.charts.replaceChildren();
    for (const chart of this.meta.charts) {
      const lines = [];
      for (const line of chart.lines) {
        const values = await floats(this.streams, line.stream);
        lines.push({label: line.label, x: values.subarray(0, line.samples), y: values.subarray(line.samples)});
      }
      const plot = new Chart(this.charts, chart.title, chart.unit, (t) => this.showTime(t));
      plot.stages = this.meta.stages;
      plot.set(lines);
      this.plots.push(plot);
    }
  }

  // Camera

  resize() {
    const ratio = window.devicePixelRatio || 1;
    const width = Math.max(1, Math.round(this.stage.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.stage.clientHeight * ratio));
    if (width === this.camera.width && height === this.camera.height) return;
    const scale = Math.min(width / this.camera.width, height / this.camera.height);
    Object.assign(this.camera, {width, height, scale: this.camera.scale * scale});
    for (const canvas of [this.canvas, this.overlay]) {
      canvas.width = width;
      canvas.height = height;
    }
    if (this.painter) (this.moved ? this.refresh() : this.fit());
  }

  fit() {
    const [x0, y0, x1, y1] = this.meta.box, c = this.camera;
    c.x = 0.5 * (x0 + x1);
    c.y = 0.5 * (y0 + y1);
    c.scale = 0.9 * Math.min(c.width / Math.max(x1 - x0, 1e-9), c.height / Math.max(y1 - y0, 1e-9));
    this.moved = false;
    this.refresh();
  }

  world(event) {
    const box = this.stage.getBoundingClientRect(), c = this.camera;
    const ratio = c.width / box.width;
    return [c.x + ((event.clientX - box.left) * ratio - c.width / 2) / c.scale,
      c.y - ((event.clientY - box.top) * ratio - c.height / 2) / c.scale];
  }

  zoom(factor, x, y) {
    const c = this.camera;
    c.x = x + (c.x - x) / factor;
    c.y = y + (c.y - y) / factor;
    c.scale *= factor;
    this.moved = true;
    this.refresh();
  }

  wheel(event) {
    event.preventDefault();
    this.zoom(Math.exp(-0.0015 * event.deltaY), ...this.world(event));
  }

  pointer(event) {
    if (event.type === "pointerdown") {
      this.stage.setPointerCapture(event.pointerId);
      this.pressed = [event.clientX, event.clientY];
      this.pointers.set(event.pointerId, event);
      return;
    }
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    if (event.type === "pointermove") {
      const [x0, y0] = this.world(before), [x1, y1] = this.world(event);
      if (this.pointers.size === 1) {
        this.camera.x -= x1 - x0;
        this.camera.y -= y1 - y0;
        this.moved = true;
        this.refresh();
      } else {
        this.pinch(event, before);
      }
      this.pointers.set(event.pointerId, event);
      return;
    }
    this.pointers.delete(event.pointerId);
    const [x, y] = this.pressed;
    if (event.type === "pointerup" && Math.hypot(event.clientX - x, event.clientY - y) < 5) {
      this.pick(this.model.blockAt(...this.world(event)));
    }
  }

  pinch(event, before) {
    const other = [...this.pointers.values()].find((p) => p.pointerId !== event.pointerId);
    const was = Math.hypot(before.clientX - other.clientX, before.clientY - other.clientY);
    const is = Math.hypot(event.clientX - other.clientX, event.clientY - other.clientY);
    if (was > 0 && is > 0) this.zoom(is / was, ...this.world(other));
  }

  key(event) {
    const acts = {" ": () => this.play(!this.playing), ArrowLeft: () => this.show(this.frame - 1),
      ArrowRight: () => this.show(this.frame + 1), Home: () => this.show(0),
      End: () => this.show(this.model.frames - 1),
      "+": () => this.zoom(1.25, this.camera.x, this.camera.y),
      "-": () => this.zoom(0.8, this.camera.x, this.camera.y),
      "]": () => this.pick((this.picked + 1) % this.model.n),
      "[": () => this.pick((Math.max(this.picked, 0) + this.model.n - 1) % this.model.n)};
    if (!acts[event.key]) return;
    event.preventDefault();
    acts[event.key]();
  }

  // Time

  show(frame) {
    this.frame = Math.min(Math.max(frame, 0), this.model.frames - 1);
    this.refresh();
  }

  showTime(time) {
    this.show(this.frameAt(time));
  }

  frameAt(time) {
    const t = this.meta.time;
    let low = 0, high = t.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle; else high = middle;
    }
    return time - t[low] <= t[high] - time ? low : high;
  }

  play(on) {
    this.playing = on && this.model.decoded;
    this.playButton.textContent = this.playing ? "⏸" : "▶";
    this.playButton.setAttribute("aria-label", this.playing ? "pause" : "play");
    if (!this.playing) return;
    const t = this.meta.time;
    if (this.frame === this.model.frames - 1) this.frame = 0;
    let now = t[this.frame], last = performance.now();
    const tick = () => {
      if (!this.playing) return;
      const at = performance.now();
      now += (at - last) / 1000 * this.speed;
      last = at;
      const frame = this.frameAt(now);
      if (frame !== this.frame) this.show(frame);
      if (now >= t[t.length - 1]) this.play(false);
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  // Drawing

  refresh() {
    if (this.asked || !this.painter) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  draw() {
    const begun = performance.now(), model = this.model;
    model.put(model.decoded ? this.frame : -1, this.factor);
    this.tint();
    this.layContacts();
    this.layBolts();
    const pixels = this.side * this.camera.scale;
    const edges = pixels < 6 ? 0 : Math.min(0.85, (pixels - 4) / 12);
    this.painter.paint(model, this.camera, this.tints, edges, this.lines);
    this.drawOverlay();
    this.words();
    Object.assign(this.state, {frame: this.frame, draws: this.state.draws + 1,
      drawMs: performance.now() - begun});
  }

  /** The frame whose values the colours span, or −1 for all. */
  scaleFrame() {
    return this.ownScale ? this.frame : -1;
  }

  tint() {
    const {model, tints, color} = this, out = [0, 0, 0];
    const stones = this.meta.stones.map(rgb);
    const plain = color === "material" || !model.decoded;
    const [low, high] = plain ? [0, 1] : model.range(color, this.scaleFrame());
    const stops = this.meta.maps[color === "rotation" ? "signed" : "magnitude"];
    for (let b = 0; b < model.n; b++) {
      const c = plain ? stones[model.material[b] % stones.length]
        : mapped(stops, (model.quantity(color, this.frame, b) - low) / (high - low), out);
      for (let v = model.first[b]; v < model.first[b + 1]; v++) {
        tints[4 * v] = c[0];
        tints[4 * v + 1] = c[1];
        tints[4 * v + 2] = c[2];
        tints[4 * v + 3] = 255;
      }
    }
  }

  layContacts() {
    const kind = this.contacts;
    this.lines.start(0);
    if (kind === "none" || !this.model.decoded) return;
    if (kind === "force") this.layForces(); else this.layMovement(kind === "slip" ? 0 : 1);
  }

  /** Resultants between neighbours, longer and thicker with their size. */
  layForces() {
    const {model, frame} = this, p = model.places, sums = new Map();
    const owner = this.owner ||= this.ownerOf();
    for (const [v, e, place, push, drag] of model.contactForces(frame)) {
      const a = owner[v], b = owner[e];
      const after = (i) => i + 1 < model.first[owner[i] + 1] ? i + 1 : model.first[owner[i]];
      const w = after(e), u = after(v), share = place / 100;
      const dx = p[2 * w] - p[2 * e], dy = p[2 * w + 1] - p[2 * e + 1];
      const length = Math.hypot(dx, dy) || 1, tx = dx / length, ty = dy / length;
      const sign = a < b ? 1 : -1;
      const key = Math.min(a, b) * model.n + Math.max(a, b);
      let sum = sums.get(key);
      if (!sum) sums.set(key, sum = [0, 0, 0, 0, 0]);
      sum[0] += push;
      sum[1] += push * (p[2 * v] + share * (p[2 * u] - p[2 * v]));
      sum[2] += push * (p[2 * v + 1] + share * (p[2 * u + 1] - p[2 * v + 1]));
      sum[3] += sign * (push * ty - drag * tx);
      sum[4] += sign * (-push * tx - drag * ty);
    }
    const color = rgb(variable("--force"));
    const sizes = [...sums.values()].map((sum) => Math.hypot(sum[3], sum[4]));
    const most = this.forceScale(Math.max(0, ...sizes));
    this.lines.start(2 * sums.size);
    const pixel = 1 / this.camera.scale;
    for (const [push, x, y, fx, fy] of sums.values()) {
      const size = Math.hypot(fx, fy), share = Math.min(size / most, 1.5);
      if (share < 0.01) continue;
      const cx = x / push, cy = y / push, half = 0.45 * this.side * share / size;
      const width = Math.max(Math.min(0.1 * this.side, 7 * pixel) * share, 1.2 * pixel);
      const ends = [cx - half * fx, cy - half * fy, cx + half * fx, cy + half * fy];
      this.lines.add(...ends, width + 2 * pixel, [255, 255, 255]);
      this.lines.add(...ends, width, color);
    }
  }

  /** Bolts as lines, thicker with their force; broken ones in dashes. */
  layBolts() {
    const {model} = this, pixel = (window.devicePixelRatio || 1) / this.camera.scale;
    if (!model.decoded || !this.meta.bolts.length) return;
    const bolts = model.bolts(this.frame, this.factor), {broken} = this.meta.bolt;
    const color = rgb(this.meta.bolt.color);
    this.boltForce = Math.max(0, ...bolts.map((bolt) => bolt.force));
    for (const {points, state, force} of bolts) {
      const width = (1.5 + 3.5 * (this.boltForce ? force / this.boltForce : 0)) * pixel;
      const dashes = state === broken ? DASHES : 1, part = dashes > 1 ? 0.5 : 1;
      this.lines.room(2 * dashes * points.length);
      for (const [more, ink] of [[2 * pixel, [255, 255, 255]], [0, color]]) {
        for (let i = 1; i < points.length; i++) {
          const [x, y] = points[i - 1], dx = points[i][0] - x, dy = points[i][1] - y;
          for (let k = 0; k < dashes; k++) {
            const from = k / dashes, to = (k + part) / dashes;
            this.lines.add(x + from * dx, y + from * dy, x + to * dx, y + to * dy, width + more, ink);
          }
        }
      }
    }
  }

  /** The force of the longest line: of this frame, or of all but the rarest of all frames. */
  forceScale(largest) {
    if (this.ownScale) return this.usualForce = largest || 1;
    if (!this.commonForce) {
      const {normal} = this.model.force, step = Math.ceil(normal.values.length / SAMPLES);
      const found = [];
      for (let i = 0; i < normal.values.length; i += step) {
        if (normal.values[i] > 0) found.push(value(normal, i));
      }
      this.commonForce = 2 * quantile(found, SHOWN) || 1;  // two contacts make a joint
    }
    return this.usualForce = this.commonForce;
  }

  ownerOf() {
    const owner = new Int32Array(this.model.vertices);
    for (let b = 0; b < this.model.n; b++) owner.fill(b, this.model.first[b], this.model.first[b + 1]);
    return owner;
  }

  layMovement(which) {
    const {model, frame} = this, n = this.meta.faces, out = new Float64Array(6);
    const most = this.mostMovement(which), color = [0, 0, 0];
    const poses = model.poses(frame), width = Math.max(0.07 * this.side, 2.5 / this.camera.scale);
    this.lines.start(n);
    for (let k = 0; k < n; k++) {
      const e = model.faceEnds;
      model.joint(k, frame, poses, out);
      if (out[which] < 0.01 * most) continue;
      const at = [2, 3, 4, 5].map((i) => e[6 * k + i - 2]
        + this.factor * (out[i] - e[6 * k + i - 2]));
      mapped(this.meta.maps.joint, out[which] / most, color);
      this.lines.add(...at, width, color);
    }
  }

  /** The slip or opening of the darkest colour: of this frame, or of the last one. */
  mostMovement(which) {
    const frame = this.ownScale ? this.frame : this.model.frames - 1;
    this.most ||= {};
    const key = `${which} ${frame}`;
    if (this.most[key] === undefined) {
      const out = new Float64Array(6), poses = this.model.poses(frame), found = [];
      for (let k = 0; k < this.meta.faces; k++) {
        found.push(this.model.joint(k, frame, poses, out)[which]);
      }
      this.most[key] = quantile(found, this.ownScale ? 1 : SHOWN) || 1e-12;
    }
    return this.most[key];
  }

  /** The picked block and the scale bar, anew only when they change. */
  drawOverlay() {
    const seen = [this.camera.x, this.camera.y, this.camera.scale, this.camera.width,
      this.camera.height, DARK.matches, this.picked, this.picked < 0 ? 0 : this.frame,
      this.factor].join();
    if (seen === this.overlaid) return;
    this.overlaid = seen;
    const c = this.overlay.getContext("2d"), cam = this.camera;
    const ratio = window.devicePixelRatio || 1, ink = variable("--ink");
    const X = (x) => cam.width / 2 + cam.scale * (x - cam.x);
    const Y = (y) => cam.height / 2 - cam.scale * (y - cam.y);
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, cam.width, cam.height);
    if (this.picked >= 0) {
      const {places, first} = this.model;
      c.beginPath();
      for (let v = first[this.picked]; v < first[this.picked + 1]; v++) {
        c.lineTo(X(places[2 * v]), Y(places[2 * v + 1]));
      }
      c.closePath();
      c.lineJoin = "round";
      c.lineWidth = 5 * ratio;
      c.strokeStyle = variable("--paper");
      c.stroke();
      c.lineWidth = 2.5 * ratio;
      c.strokeStyle = variable("--pick");
      c.stroke();
    }
    c.font = `${11 * ratio}px system-ui, sans-serif`;
    const room = 0.28 * cam.width / cam.scale, power = 10 ** Math.floor(Math.log10(room));
    const length = power * [5, 2, 1].find((m) => m * power <= room);
    const x = 12 * ratio, y = cam.height - 12 * ratio, right = x + length * cam.scale;
    c.fillStyle = variable("--card");
    c.globalAlpha = 0.85;
    c.fillRect(x - 6 * ratio, y - 20 * ratio, right - x + 12 * ratio, 26 * ratio);
    c.globalAlpha = 1;
    c.strokeStyle = ink;
    c.lineWidth = 1.5 * ratio;
    c.beginPath();
    c.moveTo(x, y - 4 * ratio);
    c.lineTo(x, y);
    c.lineTo(right, y);
    c.lineTo(right, y - 4 * ratio);
    c.stroke();
    c.fillStyle = ink;
    c.textBaseline = "bottom";
    c.fillText(withUnit(length, "m"), x + 5 * ratio, y - 3 * ratio);
    this.drawMarks(c, X, Y, ratio);
  }

  /** What else stands over the blocks. */
  drawMarks() {}

  // Words

  words() {
    this.slider.value = this.frame;
    const time = this.meta.time[this.frame], last = this.meta.time[this.model.frames - 1];
    this.clock.textContent = `${time.toFixed(last < 10 ? 3 : 2)} s`;
    this.drawLegend();
    this.describe();
    for (const plot of this.plots || []) plot.cursor(time);
    if (this.blockChart && this.picked >= 0) this.blockChart.cursor(time);
  }

  drawLegend() {
    const decoded = this.model.decoded;
    const key = `${this.color} ${this.contacts} ${decoded} ${this.scaleFrame()} ${this.boltForce}`;
    if (this.legendKey === key) return;
    this.legendKey = key;
    this.legend.replaceChildren();
    if (this.color === "material" || !decoded) {
      for (const [i, name] of this.meta.materials.entries()) {
        this.colorKey(this.meta.stones[i % this.meta.stones.length], name);
      }
    } else {
      const units = {displacement: "m", velocity: "m/s", rotation: "°", stress: "Pa"};
      const names = {displacement: "displacement", velocity: "velocity", rotation: "rotation",
        stress: "largest compression"};
      const map = this.color === "rotation" ? "signed" : "magnitude";
      this.scaleBar(names[this.color], this.model.range(this.color, this.scaleFrame()),
        units[this.color], map);
    }
    if (this.boltForce !== undefined) {
      this.colorKey(this.meta.bolt.color, `bolt, largest force: ${withUnit(this.boltForce, "N/m")}`);
    }
    if (!decoded || this.contacts === "none") return;
    if (this.contacts === "force") {
      this.colorKey(variable("--force"),
        `contact force, as long as a block: ${withUnit(this.usualForce, "N/m")}`);
    } else {
      const slip = this.contacts === "slip";
      const most = this.mostMovement(slip ? 0 : 1);
      this.scaleBar(slip ? "slip of joints" : "opening of joints", [0, most], "m", "joint");
    }
  }

  colorKey(color, words) {
    const row = element("div", this.legend, "", "key");
    element("i", row).style.background = color;
    element("span", row, words);
  }

  scaleBar(name, [low, high], unit, map) {
    const [scale, short_name] = inUnit(Math.max(Math.abs(low), Math.abs(high)), unit);
    const box = element("div", this.legend, "", "scale");
    element("div", box, `${name} (${short_name})`, "scale-name");
    const bar = element("canvas", box);
    bar.width = 128;
    bar.height = 1;
    const c = bar.getContext("2d"), pixels = c.createImageData(128, 1), out = [0, 0, 0];
    for (let i = 0; i < 128; i++) {
      mapped(this.meta.maps[map], i / 127, out);
      pixels.data.set([...out, 255], 4 * i);
    }
    c.putImageData(pixels, 0, 0);
    const ends = element("div", box, "", "scale-ends");
    for (const at of [low, 0.5 * (low + high), high]) {
      const more = at === high && !this.ownScale ? "≥ " : "";  // rare values are beyond
      element("span", ends, more + short(+(at / scale).toPrecision(3)));
    }
  }

  setColor(color) {
    this.color = color;
    this.colorSelect.value = color;
    if (this.picked >= 0) this.plotBlock();
    this.refresh();
  }

  setContacts(kind) {
    this.contacts = kind;
    this.contactSelect.value = kind;
    this.refresh();
  }

  pick(block) {
    this.picked = block;
    this.state.picked = block >= 0 ? this.model.names[block] : "";
    this.plotBlock();
    this.refresh();
  }

  describe() {
    const b = this.picked, {model, frame} = this;
    if (b < 0 && this.info.querySelector(".hint")) return;
    this.info.replaceChildren();
    if (b < 0) {
      element("p", this.info, "Click a block to read its values.", "hint");
      return;
    }
    element("h4", this.info, model.names[b]);
    const table = element("table", this.info);
    const row = (name, value) => {
      const line = element("tr", table);
      element("th", line, name);
      element("td", line, value);
    };
    row("material", this.meta.materials[model.material[b]] || "");
    const pose = model.pose(model.decoded ? frame : -1, b, new Float64Array(6));
    const [ox, oy] = this.meta.origin;
    row("centroid", `${short(pose[0] + ox)}, ${short(pose[1] + oy)} m`);
    row("area", `${short(this.factor === 1 ? model.area(b) : NaN)} m²`);
    if (!model.decoded) return;
    row("displacement", withUnit(model.quantity("displacement", frame, b), "m"));
    row("along x, y", `${withUnit(model.at("u", frame, b), "m")}, `
      + withUnit(model.at("v", frame, b), "m"));
    row("rotation", `${short(model.quantity("rotation", frame, b))}°`);
    row("velocity", withUnit(model.at("speed", frame, b), "m/s"));
    const [most, least] = model.stresses(frame, b);
    row("compression", withUnit(-least, "Pa"));
    if (isFinite(most)) row("tension", withUnit(most, "Pa"));
    this.state.area = model.area(b);
  }

  plotBlock() {
    const b = this.picked;
    if (!this.model.decoded || b < 0) {
      if (this.blockBox) this.blockBox.remove();
      this.blockBox = this.blockChart = null;
      return;
    }
    const color = this.color === "material" ? "displacement" : this.color;
    const units = {displacement: "m", velocity: "m/s", rotation: "°", stress: "Pa"};
    if (this.blockBox) this.blockBox.remove();
    this.blockBox = element("div", null, "", "block-chart");
    this.charts.prepend(this.blockBox);
    const name = color === "stress" ? "largest compression" : color;
    this.blockChart = new Chart(this.blockBox, `${name} of ${this.model.names[b]}`, units[color],
      (t) => this.showTime(t));
    const y = Float64Array.from(this.meta.time, (_, f) => this.model.quantity(color, f, b));
    this.blockChart.stages = this.meta.stages;
    this.blockChart.set([{label: this.model.names[b], x: Float64Array.from(this.meta.time), y}]);
  }
}
