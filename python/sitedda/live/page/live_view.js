// The view of an edited model and of its run, to which each new frame is added.

import {Chart} from "/view/chart.js";
import {Model} from "/view/model.js";
import {View} from "/view/view.js";
import {limits, variable} from "/view/words.js";

const NAMES = ["u", "v", "turn", "ex", "ey", "gxy", "speed", "sx", "sy", "txy"];
const BYTES = 400e6;     // largest size of the stored frames
const CHARTS = 250;      // ms between drawings of the histories
const DRAWN = {displacement: ["displacement of the measured points", "m"],
  energies: ["energies", "J/m"]};

/** A model with a growing number of frames; quantities are stored as received. */
class LiveModel extends Model {
  /** Return the index of the interface between two blocks, or −1. */
  jointBetween(a, b) {
    const f = this.faceBlocks;
    for (let k = 0; k < this.meta.faces; k++) {
      if (f[2 * k] + f[2 * k + 1] === a + b && [a, b].includes(f[2 * k])) return k;
    }
    return -1;
  }

  /** Return the vertex of block a that is nearest to an edge of block b, and the ends of the edge. */
  nearest(a, b) {
    const {first, places: p} = this;
    let least = Infinity, found = [];
    for (let v = first[a]; v < first[a + 1]; v++) {
      for (let e = first[b], d = first[b + 1] - 1; e < first[b + 1]; d = e++) {
        const [x, y] = p.subarray(2 * v), [x0, y0] = p.subarray(2 * d), [x1, y1] = p.subarray(2 * e);
        const dx = x1 - x0, dy = y1 - y0, along = (x - x0) * dx + (y - y0) * dy;
        const s = Math.min(Math.max(along / (dx * dx + dy * dy), 0), 1);
        const apart = Math.hypot(x - x0 - s * dx, y - y0 - s * dy);
        if (apart < least) [least, found] = [apart, [x, y, x0, y0, x1, y1]];
      }
    }
    return found;
  }

  async readMotion() {
    await super.readMotion();
    this.room = 1;
    const flat = (stored) => Float32Array.from(stored.values,
      (x) => (stored.root ? Math.sign(x) * (x * stored.quantum) ** 2 : x * stored.quantum));
    for (const name of NAMES) {
      this.channels[name] = {values: flat(this.channels[name]), quantum: 1, root: false};
    }
    for (const values of Object.values(this.lineValues)) {
      for (const name of ["size", "state"]) {
        values[name] = {values: flat(values[name]), quantum: 1, root: false};
      }
    }
    this.contacts = [[]];
    this.live = {};
    this.gone = new Set();
  }

  /** Yield each stored quantity, and its number of values per frame. */
  * stored() {
    for (const name of NAMES) yield [this.channels[name], this.n];
    for (const [kind, {size, state}] of Object.entries(this.lineValues)) {
      for (const one of [size, state]) yield [one, this.meta.lines[kind].length];
    }
  }

  get size() {
    return 4 * this.room * this.n * NAMES.length;
  }

  grow() {
    if (this.frames < this.room) return;
    if (2 * this.size > BYTES && this.frames > 8) this.thin();
    if (this.frames < this.room) return;
    this.room *= 2;
    for (const [stored, things] of this.stored()) {
      const values = new Float32Array(this.room * things);
      values.set(stored.values.subarray(0, this.frames * things));
      stored.values = values;
    }
  }

  /** Delete every second frame. */
  thin() {
    const keep = Math.ceil(this.frames / 2);
    for (const [stored, things] of this.stored()) {
      for (let f = 1; f < keep; f++) {
        stored.values.copyWithin(f * things, 2 * f * things, (2 * f + 1) * things);
      }
    }
    for (const name of ["time", "base"]) {
      this.meta[name] = this.meta[name].filter((_, f) => f % 2 === 0);
    }
    this.contacts = this.contacts.filter((_, f) => f % 2 === 0);
    this.frames = keep;
    for (const one of this.meta.removals) one[1] = Math.ceil(one[1] / 2);
  }

  add(head, streams) {
    this.grow();
    const f = this.frames, blocks = streams.floats("blocks");
    NAMES.forEach((name, k) => {
      this.channels[name].values.set(blocks.subarray(k * this.n, (k + 1) * this.n), f * this.n);
    });
    for (const [kind, {size, state}] of Object.entries(this.lineValues)) {
      const values = streams.floats(kind), n = this.meta.lines[kind].length;
      for (let k = 0; k < n; k++) {
        size.values[f * n + k] = values[2 * k];
        state.values[f * n + k] = values[2 * k + 1];
      }
    }
    this.contacts.push(streams.has("pairs")
      ? [streams.integers("pairs"), streams.floats("forces")] : []);
    for (const block of head.removed) {
      if (this.gone.has(block)) continue;
      this.gone.add(block);
      this.meta.removals.push([block, f]);
    }
    this.meta.time.push(head.time);
    this.meta.base.push(head.base);
    this.frames = f + 1;
    this.widen(f);
  }

  /** Extend the limits of the colours to the values of a frame. */
  widen(frame) {
    for (const {name} of this.meta.quantities) {
      const now = super.range(name, frame), {low, high, usual} = this.live[name] || now;
      this.live[name] = {low: Math.min(low, now.low), high: Math.max(high, now.high),
        usual: Math.max(usual, now.usual)};
    }
  }

  range(name, frame) {
    if (frame >= 0 || !this.live?.[name]) return super.range(name, Math.max(frame, 0));
    return this.live[name];
  }

  * contactForces(frame) {
    const [pairs, forces] = this.contacts[frame] || [];
    if (!pairs) return;
    for (let k = 0; 3 * k < pairs.length; k++) {
      yield [pairs[3 * k], pairs[3 * k + 1], pairs[3 * k + 2], forces[2 * k], forces[2 * k + 1]];
    }
  }
}

export class LiveView extends View {
  modelOf(meta, streams) {
    return new LiveModel(meta, streams);
  }

  /** Reset the choices of the user before another model is shown. */
  forget() {
    this.moved = false;
    this.picked = -1;
    this.color = "material";
  }

  /** Show a model with its supports, loads and water. */
  async load(head, streams) {
    this.loading = true;
    this.waiting = [];
    const kept = this.picked >= 0 ? this.model.names[this.picked] : "";
    this.symbols = head.marks;
    this.points = head.points;
    this.histories = {time: [], displacement: head.points.flatMap((p) => [`${p}, x`, `${p}, y`])
      .map((label) => ({label, y: []})), energies: []};
    this.picked = -1;
    this.failing = null;
    this.follows = true;
    if (this.blockBox) this.blockBox.remove();
    this.blockBox = this.blockChart = null;
    await this.begin({...head.meta, charts: []}, streams);
    this.choices.speed.value = this.speed = 1;  // the duration is not known yet
    if (head.run && this.color === "material") this.setColor("displacement");
    this.live = {};
    this.forceMost = 0;
    this.loading = false;
    if (kept) {
      const at = this.model.names.indexOf(kept);
      if (at >= 0) this.pick(at);
    }
    for (const [one, data] of this.waiting) this.add(one, data);
  }

  /** Add a frame of the run and show it, unless the user looks at an earlier one. */
  add(head, streams) {
    if (this.loading) {
      this.waiting.push([head, streams]);
      return;
    }
    this.model.add(head, streams);
    this.legend.key = "";  // the limits of the colours may be wider
    this.root.classList.remove("still");
    this.slider.max = this.model.frames - 1;
    for (const option of this.choices.contacts.options) {
      if (["force", "chain"].includes(option.value)) this.choices.allow(option, true);
    }
    this.record(head);
    this.state.frames = (this.state.frames || 0) + 1;
    if (this.follows) this.show(this.model.frames - 1, true);
  }

  /** Show a frame; new frames replace it only if it is the last one. */
  show(frame, follows = false) {
    super.show(frame);
    this.follows = follows || this.frame === this.model.frames - 1;
  }

  record(head) {
    const h = this.histories;
    h.time.push(head.time);
    h.displacement.forEach((line, i) => line.y.push(head.moved[i] - head.base[i % 2]));
    if (!h.energies.length) h.energies = Object.keys(head.energies).map((label) => ({label, y: []}));
    h.energies.forEach((line) => line.y.push(head.energies[line.label]));
    if (h.time.length < 2) this.plotBlock();
    const now = performance.now();
    if (now - (this.charted || 0) < CHARTS || h.time.length < 2) return;
    this.charted = now;
    this.plotHistories();
  }

  plotHistories() {
    this.plotBlock();
    const x = Float64Array.from(this.histories.time);
    this.live.charts ||= {};
    this.plots = [];
    for (const [name, [title, unit]] of Object.entries(DRAWN)) {
      const lines = this.histories[name].filter((line) => line.y.some((v) => v !== 0)).slice(0, 8);
      if (!lines.length) continue;
      this.live.charts[name] ||= new Chart(this.charts, title, unit, (t) => this.showTime(t));
      const chart = this.live.charts[name];
      chart.set(lines.map(({label, y}) => ({label, x, y: Float64Array.from(y)})));
      this.plots.push(chart);
    }
  }

  /** Replace the histories of the frames by all samples of the output. */
  async conclude(meta, streams) {
    this.meta.charts = meta.charts;
    this.streams = streams;
    this.live.charts = {};
    await this.buildCharts();
    this.plotBlock();
    this.refresh();
  }

  get hasForces() {
    return this.model.contacts.some((one) => one.length);
  }

  forceScale(largest) {
    if (this.ownScale) return super.forceScale(largest);
    this.forceMost = Math.max(this.forceMost || 0, largest);
    return this.usualForce = this.forceMost || 1;
  }

  /** Draw supports, boundaries, loads, measured points, water and slivers at their first position. */
  drawMarks(c, X, Y, ratio) {
    const marks = this.symbols;
    if (!marks) return;
    if (this.failing) this.drawFailing(c, X, Y, ratio);
    const ink = variable("--ink"), size = 7 * ratio;
    c.lineWidth = 1.5 * ratio;
    for (const {kind, moved, edges} of marks.boundaries) {
      c.strokeStyle = moved ? variable("--link") : ink;
      c.setLineDash(kind === "fixed" ? [] : [5 * ratio, 3 * ratio]);
      c.lineWidth = 3 * ratio;
      c.beginPath();
      for (let i = 0; i < edges.length; i += 4) {
        const [x0, y0, x1, y1] = edges.slice(i, i + 4);
        c.moveTo(X(x0 - this.meta.origin[0]), Y(y0 - this.meta.origin[1]));
        c.lineTo(X(x1 - this.meta.origin[0]), Y(y1 - this.meta.origin[1]));
      }
      c.stroke();
    }
    c.setLineDash([]);
    c.lineWidth = 1.5 * ratio;
    for (const {x, y, moved} of marks.supports) {
      c.fillStyle = moved ? variable("--link") : ink;
      c.beginPath();
      c.moveTo(X(x), Y(y));
      c.lineTo(X(x) - 0.7 * size, Y(y) + 1.2 * size);
      c.lineTo(X(x) + 0.7 * size, Y(y) + 1.2 * size);
      c.fill();
    }
    c.strokeStyle = variable("--link");
    for (const line of marks.water) {
      c.beginPath();
      for (let i = 0; i < line.length; i += 2) c.lineTo(X(line[i]), Y(line[i + 1]));
      c.stroke();
    }
    c.strokeStyle = c.fillStyle = variable("--force");
    for (const {x, y, fx, fy} of marks.loads) {
      const length = Math.hypot(fx, fy) || 1, dx = 30 * ratio * fx / length;
      const dy = -30 * ratio * fy / length;
      c.beginPath();
      c.moveTo(X(x) - dx, Y(y) - dy);
      c.lineTo(X(x), Y(y));
      c.stroke();
      c.beginPath();
      c.arc(X(x), Y(y), 3 * ratio, 0, 7);
      c.fill();
    }
    c.fillStyle = c.strokeStyle = variable("--pick");
    c.textBaseline = "middle";
    for (const {x, y} of marks.points) {
      c.beginPath();
      c.arc(X(x), Y(y), 3.5 * ratio, 0, 7);
      c.fill();
    }
    this.drawNames(c, marks.points.map(({x, y, name}) => [X(x), Y(y), name]), ratio);
    const {first, places} = this.model;
    for (const b of marks.slivers) {
      c.beginPath();
      c.arc(X(places[2 * first[b]]), Y(places[2 * first[b] + 1]), 9 * ratio, 0, 7);
      c.stroke();
    }
  }

  /** Draw the names of points beside them; omit names that would cover other names or points. */
  drawNames(c, points, ratio) {
    const away = 7 * ratio, half = 6 * ratio, {width, height} = this.camera;
    const taken = points.map(([x, y]) => [x - half, y - half, x + half, y + half]);
    for (const [own, [x, y, name]] of points.entries()) {
      const wide = c.measureText(name).width;
      const box = [[1, -1], [1, 1], [-1, -1], [-1, 1]].map(([right, down]) => {
        const left = right > 0 ? x + away : x - away - wide, middle = y + down * away;
        return [left, middle - half, left + wide, middle + half];
      }).find((one) => one[0] >= 0 && one[1] >= 0 && one[2] <= width && one[3] <= height
        && !taken.some((other, k) => k !== own && one[0] < other[2] && other[0] < one[2]
          && one[1] < other[3] && other[1] < one[3]));
      if (!box) continue;
      taken.push(box);
      this.write(c, name, box[0], box[1] + half, ratio);
    }
  }

  /** Write a text with an outline in the background colour, legible on all blocks. */
  write(c, text, x, y, ratio) {
    c.save();
    c.lineJoin = "round";
    c.lineWidth = 3 * ratio;
    c.strokeStyle = variable("--paper");
    c.strokeText(text, x, y);
    c.restore();
    c.fillText(text, x, y);
  }

  /** Zoom to the block that a message names, or to the contact between two blocks. */
  pointAt(blocks) {
    if (!blocks.length) return;
    const {model} = this, [a, b] = blocks;
    this.pick(a);
    const joint = b === undefined ? -1 : model.jointBetween(a, b);
    if (joint >= 0) this.pickJoint(joint);
    this.failing = blocks;
    const [x, y] = b === undefined ? model.places.subarray(2 * model.first[a]) : model.nearest(a, b);
    this.fit();
    const {scale} = this.camera;
    Object.assign(this.camera, {x, y});
    this.camera.scale = 3 * scale;
    this.moved = true;
    this.refresh();
  }

  /** Mark the contact that did not converge: its blocks, vertex and edge. */
  drawFailing(c, X, Y, ratio) {
    const [a, b] = this.failing, {first, places} = this.model;
    c.strokeStyle = variable("--pick");
    c.lineWidth = 2.5 * ratio;
    for (const block of this.failing) {
      c.beginPath();
      for (let v = first[block]; v < first[block + 1]; v++) {
        c.lineTo(X(places[2 * v]), Y(places[2 * v + 1]));
      }
      c.closePath();
      c.stroke();
    }
    if (b === undefined) return;
    const [x, y, ...edge] = this.model.nearest(a, b);
    c.strokeStyle = c.fillStyle = variable("--force");
    c.lineWidth = 4 * ratio;
    c.beginPath();
    c.moveTo(X(edge[0]), Y(edge[1]));
    c.lineTo(X(edge[2]), Y(edge[3]));
    c.stroke();
    c.beginPath();
    c.arc(X(x), Y(y), 7 * ratio, 0, 7);
    c.stroke();
    c.textBaseline = "bottom";
    this.write(c, "this contact did not converge", X(x) + 11 * ratio, Y(y) - 5 * ratio, ratio);
  }
}
