// The interactive view of blocks: draws them and lets the user play, scrub, zoom, pan and pick.

import {Chart} from "./chart.js";
import {buildBar, Choices, KEYS} from "./controls.js";
import {Legend} from "./legend.js";
import {Marks} from "./marks.js";
import {Model} from "./model.js";
import {FlatPainter, GlPainter} from "./painters.js";
import {floats} from "./streams.js";
import {DARK, element, lastBefore, limits, mapped, rgb, roundBelow, share, short, variable, withUnit} from "./words.js";

const RULER = 32;  // pixels of the scale bar, its words and the space below it

export class View {
  constructor(root) {
    this.root = root;
    this.frame = 0;
    this.picked = -1;
    this.playing = false;
    this.factor = 1;
    this.contacts = "none";
    this.camera = {x: 0, y: 0, scale: 1, width: 1, height: 1};
    this.marks = new Marks(this);
    this.span = null;
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
    this.canvas.setAttribute("aria-label", `Blocks. Keys: ${KEYS}`);
    this.overlay = element("canvas", this.stage, "", "overlay");
    this.legend = new Legend(this, element("div", root, "", "legend"));
    this.bar = element("div", root, "", "bar");
    buildBar(this, this.bar);
    this.aside = element("div", root, "", "side");
    this.choices = new Choices(this, element("div", this.aside, "", "choices"));
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
      for (const plot of this.plots || []) plot.set(plot.lines, plot.stacked);
      if (this.blockChart) this.blockChart.set(this.blockChart.lines);
      this.legend.key = "";
      this.refresh();
    });
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
    Object.assign(this, {meta, streams, model, frame: 0, color: this.color || meta.color});
    this.legend.key = this.overlaid = "";
    this.most = this.commonForce = undefined;
    this.largest = {};
    this.pickedJoint = -1;
    this.choices.offer();
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
    this.onDecoded?.();
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
    if (m.loops) words.push("Amplitudes of modes are arbitrary.");
    if (m.coarse) words.push("Velocities and stresses are coarse here, positions are exact.");
    if (m.no_forces) words.push(m.no_forces);
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
      this.link(plot);
      plot.set(lines, chart.stacked);
      this.plots.push(plot);
    }
  }

  /** Whether there is a state after the first one: a model that has not run has no results. */
  get hasRun() {
    return this.model.decoded && this.model.frames > 1;
  }

  // Camera

  resize() {
    const ratio = window.devicePixelRatio || 1;
    const width = Math.max(1, Math.round(this.stage.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.stage.clientHeight * ratio));
    if (width === this.camera.width && height === this.camera.height) return;
    const before = this.fitting;
    Object.assign(this.camera, {width, height});
    this.camera.scale *= this.fitting / before;
    for (const canvas of [this.canvas, this.overlay]) {
      canvas.width = width;
      canvas.height = height;
    }
    if (this.painter) (this.moved ? this.refresh() : this.fit());
  }

  /** Pixels below the model, where the scale bar is drawn. */
  get foot() {
    return Math.min(RULER * (window.devicePixelRatio || 1), 0.2 * this.camera.height);
  }

  /** Pixels of a metre with which the whole model is seen, above the scale bar. */
  get fitting() {
    const [x0, y0, x1, y1] = this.meta?.box || [0, 0, 1, 1], {width, height} = this.camera;
    return Math.min(0.9 * width / Math.max(x1 - x0, 1e-9),
      0.95 * (height - this.foot) / Math.max(y1 - y0, 1e-9));
  }

  fit() {
    const [x0, y0, x1, y1] = this.meta.box, c = this.camera;
    c.x = 0.5 * (x0 + x1);
    c.scale = this.fitting;
    c.y = 0.5 * (y0 + y1 - this.foot / c.scale);
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
        this.pan(x0 - x1, y0 - y1);
      } else {
        this.pinch(event, before);
      }
      this.pointers.set(event.pointerId, event);
      return;
    }
    this.pointers.delete(event.pointerId);
    const [x, y] = this.pressed;
    if (event.type === "pointerup" && Math.hypot(event.clientX - x, event.clientY - y) < 5) {
      const joint = this.jointAt(...this.world(event));
      if (joint >= 0) this.pickJoint(joint); else this.pick(this.model.blockAt(...this.world(event)));
    }
  }

  pinch(event, before) {
    const other = [...this.pointers.values()].find((p) => p.pointerId !== event.pointerId);
    const was = Math.hypot(before.clientX - other.clientX, before.clientY - other.clientY);
    const is = Math.hypot(event.clientX - other.clientX, event.clientY - other.clientY);
    if (was > 0 && is > 0) this.zoom(is / was, ...this.world(other));
  }

  key(event) {
    const {camera} = this, step = 60 * (window.devicePixelRatio || 1) / camera.scale;
    const move = (x, y) => this.pan(x * step, y * step);
    const acts = {" ": () => this.play(!this.playing), ArrowLeft: () => this.show(this.frame - 1),
      ArrowRight: () => this.show(this.frame + 1), Home: () => this.show(0),
      End: () => this.show(this.model.frames - 1), f: () => this.fit(),
      "+": () => this.zoom(1.25, camera.x, camera.y),
      "-": () => this.zoom(0.8, camera.x, camera.y),
      c: () => this.choices.next("color", 1), C: () => this.choices.next("color", -1),
      x: () => this.choices.next("contacts", 1), X: () => this.choices.next("contacts", -1),
      ".": () => this.zoomTime(0.5), ",": () => this.zoomTime(2), Escape: () => this.pick(-1),
      j: () => this.pickJoint((this.pickedJoint + 1) % this.meta.faces),
      J: () => this.pickJoint((Math.max(this.pickedJoint, 0) + this.meta.faces - 1)
        % this.meta.faces),
      "]": () => this.pick((this.picked + 1) % this.model.n),
      "[": () => this.pick((Math.max(this.picked, 0) + this.model.n - 1) % this.model.n)};
    const pans = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
    const act = event.shiftKey && pans[event.key] ? () => move(...pans[event.key]) : acts[event.key];
    if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    act();
  }

  pan(x, y) {
    this.camera.x += x;
    this.camera.y += y;
    this.moved = true;
    this.refresh();
  }

  // Time

  show(frame) {
    this.frame = Math.min(Math.max(frame, 0), this.model.frames - 1);
    if (this.follower) this.follower(this.meta.time[this.frame]);
    this.refresh();
  }

  /** Charts show this part of the time (s, s); null: all of it. */
  setSpan(span) {
    this.span = span;
    for (const plot of [...this.plots || [], this.blockChart]) plot?.setSpan(span);
  }

  /** A part of the time about the cursor, so many times as long. */
  zoomTime(factor, at = this.meta.time[this.frame]) {
    const t = this.meta.time, first = t[0], last = t[t.length - 1];
    const [a, b] = this.span || [first, last];
    const begin = Math.max(first, at - factor * (at - a)), end = Math.min(last, at + factor * (b - at));
    this.setSpan(end - begin >= last - first || !(end > begin) ? null : [begin, end]);
  }

  /** A chart that goes with the others. */
  link(plot) {
    plot.stages = this.meta.stages;
    plot.span = this.span;
    plot.onZoom = (factor, at) => this.zoomTime(factor, at);
  }

  showTime(time) {
    this.show(this.frameAt(time));
  }

  frameAt(time) {
    const t = this.meta.time;
    const low = lastBefore(t, time), high = Math.min(low + 1, t.length - 1);
    return time - t[low] <= t[high] - time ? low : high;
  }

  play(on) {
    this.playing = on && this.model.decoded;
    this.playButton.textContent = this.playing ? "⏸" : "▶";
    this.playButton.setAttribute("aria-label", this.playing ? "pause" : "play");
    if (!this.playing) return;
    const t = this.meta.time;
    if (this.frame === this.loopEnd()[1]) this.frame = this.loopEnd()[0];
    let now = t[this.frame], last = performance.now();
    const tick = () => {
      if (!this.playing) return;
      const at = performance.now();
      now += (at - last) / 1000 * this.speed;
      last = at;
      const loop = this.loopEnd();
      if (now >= t[loop[1]] && loop[0] > 0) now = t[loop[0]];
      const frame = this.frameAt(now);
      if (frame !== this.frame) this.show(frame);
      if (now >= t[t.length - 1]) this.play(false);
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** First and last frame of the mode that is played again and again; else of the run. */
  loopEnd() {
    const stages = this.meta.loops ? this.meta.stage_frames : [];
    const k = stages.findIndex(([, last]) => this.frame <= last);
    return k < 0 ? [0, this.model.frames - 1] : [k ? stages[k - 1][1] + 1 : 1, stages[k][1]];
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
    this.marks.lay();
    const pixels = this.side * this.camera.scale;
    const edges = pixels < 6 ? 0 : Math.min(0.85, (pixels - 4) / 12);
    this.painter.paint(model, this.camera, this.tints, edges, this.marks.lines);
    this.drawOverlay();
    this.words();
    Object.assign(this.state, {frame: this.frame, draws: this.state.draws + 1,
      drawMs: performance.now() - begun});
  }

  /** The frame whose values the colours span, or −1 for all. */
  scaleFrame() {
    return this.ownScale ? this.frame : -1;
  }

  /** The limits of the colours. */
  range() {
    if (this.difference) return this.differenceRange();
    return this.model.range(this.color, this.scaleFrame());
  }

  /** Which colour map the quantity has. */
  map() {
    return this.difference || this.model.kind(this.color).signed ? "signed" : "magnitude";
  }

  value(b) {
    const value = this.model.quantity(this.color, this.frame, b);
    if (!this.difference) return value;
    return value - this.other.model.quantity(this.color, this.other.frame, b);
  }

  differenceRange() {
    const {n} = this.model, key = `${this.color} ${this.frame} ${this.other.frame}`;
    if (this.differenceKey !== key) {
      this.differenceKey = key;
      this.differenceLimits = limits(Float64Array.from({length: n}, (_, b) => this.value(b)),
        this.model.areas(), true);
    }
    return this.differenceLimits;
  }

  tint() {
    const {model, tints, color, meta} = this, out = [0, 0, 0];
    const stones = meta.stones.map(rgb);
    const plain = color === "material" || !model.decoded;
    const range = plain ? {low: 0, high: 1, usual: 1} : this.range();
    const kind = plain ? null : model.kind(color), resting = rgb(meta.resting);
    const rests = kind && Math.max(-range.low, range.high) <= meta.floors[kind.unit];
    const stops = plain ? null : meta.maps[this.map()];
    for (let b = 0; b < model.n; b++) {
      const c = plain ? stones[model.material[b] % stones.length] : rests ? resting
        : mapped(stops, share(range, this.value(b)), out);
      for (let v = model.first[b]; v < model.first[b + 1]; v++) {
        tints[4 * v] = c[0];
        tints[4 * v + 1] = c[1];
        tints[4 * v + 2] = c[2];
        tints[4 * v + 3] = 255;
      }
    }
  }

  /** The force of the longest arrow: of this frame, or of all but the rarest of all. */
  forceScale(largest) {
    this.usualForce = (this.ownScale ? largest : this.meta.force) || 1;
    return this.usualForce;
  }

  /** Limits of slip or opening: of this frame, or of all. */
  movementRange(name) {
    const {model, meta} = this;
    if (!this.ownScale && meta.ranges[name]) return meta.ranges[name];
    const key = `${name} ${this.frame}`;
    if (this.most?.key !== key) {
      const poses = model.poses(this.frame), out = new Float64Array(7), which = name === "slip" ? 0 : 1;
      const found = Float64Array.from({length: meta.faces}, (_, k) =>
        Math.max(0, model.joint(k, this.frame, poses, out)[which]));
      this.most = {key, ...limits(found, model.faceLengths(), false)};
    }
    return this.most;
  }

  /** The picked block and the scale bar, anew only when they change. */
  drawOverlay() {
    const still = this.picked < 0 && this.pickedJoint < 0;
    const seen = [this.camera.x, this.camera.y, this.camera.scale, this.camera.width,
      this.camera.height, DARK.matches, this.picked, this.pickedJoint, still ? 0 : this.frame,
      this.factor, this.contacts, this.usualForce].join();
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
    if (this.pickedJoint >= 0) this.drawJoint(c, X, Y, ratio);
    c.font = `${11 * ratio}px system-ui, sans-serif`;
    const length = roundBelow(0.28 * cam.width / cam.scale);
    const left = this.drawRuler(c, length, withUnit(length, "m"), 12 * ratio, ink, ratio);
    if (this.contacts === "force" && this.usualForce) {
      const force = roundBelow(this.usualForce);
      const long = this.marks.reach * force / this.usualForce;
      this.drawRuler(c, long, `contact force: ${withUnit(force, "N/m")}`,
        left + 24 * ratio, variable("--force"), ratio);
    }
    this.drawMarks(c, X, Y, ratio);
  }

  /** Draw a length of the model with its meaning from `x` on; return where they end. */
  drawRuler(c, length, words, x, color, ratio) {
    const y = this.camera.height - 12 * ratio, right = x + length * this.camera.scale;
    const wide = Math.max(right - x, c.measureText(words).width + 6 * ratio);
    c.fillStyle = variable("--card");
    c.globalAlpha = 0.85;
    c.fillRect(x - 6 * ratio, y - 20 * ratio, wide + 12 * ratio, 26 * ratio);
    c.globalAlpha = 1;
    c.strokeStyle = color;
    c.lineWidth = 1.5 * ratio;
    c.beginPath();
    c.moveTo(x, y - 4 * ratio);
    c.lineTo(x, y);
    c.lineTo(right, y);
    c.lineTo(right, y - 4 * ratio);
    c.stroke();
    c.fillStyle = variable("--ink");
    c.textBaseline = "bottom";
    c.textAlign = "left";
    c.fillText(words, x + 5 * ratio, y - 3 * ratio);
    return x + wide;
  }

  drawJoint(c, X, Y, ratio) {
    const {model, frame} = this, k = this.pickedJoint, e = model.faceEnds;
    const out = model.joint(k, frame, model.poses(frame), new Float64Array(7));
    const at = [2, 3, 4, 5].map((j) =>
      model.magnified(out[j], e[6 * k + j - 2], frame, j % 2, this.factor));
    c.strokeStyle = variable("--pick");
    c.lineWidth = 2.5 * ratio;
    c.beginPath();
    c.ellipse(0.5 * (X(at[0]) + X(at[2])), 0.5 * (Y(at[1]) + Y(at[3])), 9 * ratio
      + 0.5 * Math.hypot(X(at[2]) - X(at[0]), Y(at[3]) - Y(at[1])), 9 * ratio,
      Math.atan2(Y(at[3]) - Y(at[1]), X(at[2]) - X(at[0])), 0, 2 * Math.PI);
    c.stroke();
  }

  /** What else stands over the blocks. */
  drawMarks() {}

  // Words

  words() {
    this.slider.value = this.frame;
    const time = this.meta.time[this.frame], last = this.meta.time[this.model.frames - 1];
    this.clock.textContent = `${time.toFixed(last < 10 ? 3 : 2)} s`;
    const stage = (this.meta.stage_frames || []).find(([, end]) => this.frame <= end);
    if (stage) this.choices.stage.value = stage[1];
    this.legend.draw();
    this.root.dispatchEvent(new Event("state", {bubbles: true}));
    this.describe();
    for (const plot of this.plots || []) plot.cursor(time);
    if (this.blockChart) this.blockChart.cursor(time);
  }

  setColor(color) {
    this.color = color;
    this.choices.color.value = color;
    if (this.picked >= 0) this.plotBlock();
    this.refresh();
  }

  setContacts(kind) {
    this.contacts = kind;
    this.choices.contacts.value = kind;
    this.refresh();
  }

  pick(block) {
    this.picked = block;
    this.pickedJoint = -1;
    this.state.picked = block >= 0 ? this.model.names[block] : "";
    this.plotBlock();
    this.refresh();
  }

  /** The joint within a few pixels of a place, or −1; where joints are coloured, it is easier to hit. */
  jointAt(x, y) {
    const {model} = this, coloured = ["slip", "opening"].includes(this.contacts);
    const near = Math.min((coloured ? 7 : 3) * this.marks.pixel, (coloured ? 1 : 0.1) * this.side);
    if (!model.decoded) return -1;
    const poses = model.poses(this.frame), out = new Float64Array(7);
    let best = -1, least = near;
    for (let k = 0; k < this.meta.faces; k++) {
      model.joint(k, this.frame, poses, out);
      const dx = out[4] - out[2], dy = out[5] - out[3];
      const s = Math.min(Math.max(((x - out[2]) * dx + (y - out[3]) * dy) / (dx * dx + dy * dy), 0), 1);
      const apart = Math.hypot(x - out[2] - s * dx, y - out[3] - s * dy);
      if (apart < least) [best, least] = [k, apart];
    }
    return best;
  }

  pickJoint(joint) {
    if (!(joint >= 0)) return;  // of a model without joints there is no next one
    this.picked = -1;
    this.pickedJoint = joint;
    this.state.picked = this.jointName(joint);
    this.plotBlock();
    this.refresh();
  }

  /** Contact forces are known. */
  get hasForces() {
    return this.meta.pairs > 0;
  }

  jointName(k) {
    const {faceBlocks, names} = this.model;
    return `${names[faceBlocks[2 * k]]} – ${names[faceBlocks[2 * k + 1]]}`;
  }

  describe() {
    const b = this.picked, {model, frame} = this;
    if (b < 0 && this.pickedJoint < 0 && this.info.querySelector(".hint")) return;
    this.info.replaceChildren();
    if (b < 0 && this.pickedJoint < 0) {
      element("p", this.info, "Click a block or a joint to read its values.", "hint");
      return;
    }
    element("h3", this.info, this.state.picked);
    const table = element("table", this.info);
    const row = (name, value) => {
      const line = element("tr", table);
      element("th", line, name);
      element("td", line, value);
    };
    if (b < 0) {
      if (!this.hasRun) return;
      const out = model.joint(this.pickedJoint, frame, model.poses(frame), new Float64Array(7));
      row("slip", withUnit(out[0], "m"));
      row("opening", withUnit(Math.max(out[1], 0), "m"));
      if (!this.hasForces) return;
      const [normal, shear] = model.jointForce(this.pickedJoint, frame);
      row("normal force", withUnit(normal, "N/m"));
      row("shear force", withUnit(Math.abs(shear), "N/m"));
      return;
    }
    row("material", this.meta.materials[model.material[b]] || "");
    const pose = model.pose(model.decoded ? frame : -1, b, new Float64Array(6));
    const [ox, oy] = this.meta.origin;
    row("centroid", `${short(pose[0] + ox)}, ${short(pose[1] + oy)} m`);
    row("area", `${short(this.factor === 1 ? model.area(b) : NaN)} m²`);
    this.state.area = model.area(b);
    if (!this.hasRun) return;
    row("displacement", withUnit(model.quantity("displacement", frame, b), "m"));
    row("along x, y", model.moved(frame, b).map((one) => withUnit(one, "m")).join(", "));
    row("rotation, anticlockwise positive", withUnit(model.quantity("rotation", frame, b), "°"));
    row("velocity", withUnit(model.at("speed", frame, b), "m/s"));
    const [most, least] = model.stresses(frame, b);
    row("largest compressive stress", withUnit(-least, "Pa"));
    if (isFinite(most)) row("largest tensile stress", withUnit(most, "Pa"));
  }

  /** Histories of the picked block or joint. */
  plotBlock() {
    const b = this.picked, k = this.pickedJoint, {model} = this;
    if (this.blockBox) this.blockBox.remove();
    this.blockBox = this.blockChart = null;
    if (!this.hasRun || (b < 0 && k < 0)) return;
    const over = (y, label) => ({label, x: Float64Array.from(this.meta.time), y});
    const of = (name) => Float64Array.from(this.meta.time, (_, f) => model.quantity(name, f, b));
    let name = "slip and opening", unit = "m", lines;
    if (b < 0) {
      lines = ["slip", "opening"].map((one, which) => over(model.jointHistory(k, which), one));
    } else {
      const kind = model.kind(this.color === "material" ? "displacement" : this.color);
      [name, unit] = [kind.label, kind.unit];
      lines = kind.name.startsWith("displacement")
        ? [["displacement", "size"], ["displacement_x", "along x"], ["displacement_y", "along y"]]
          .map(([one, label]) => over(of(one), label))
        : [over(of(kind.name), kind.label)];
      if (kind.name.startsWith("displacement")) name = "displacement";
    }
    this.blockBox = element("div", null, "", "block-chart");
    this.charts.prepend(this.blockBox);
    this.blockChart = new Chart(this.blockBox, `${name} of ${this.state.picked}`, unit,
      (t) => this.showTime(t));
    this.link(this.blockChart);
    this.blockChart.set(lines);
  }
}
