// What lies over the blocks: contact forces, chains, joints that have moved, bolts, water.

import {Lines} from "./painters.js";
import {limits, mapped, rgb, share, variable} from "./words.js";

const DASHES = 12;          // of each leg of a dashed line
const LONGEST = 0.09;       // of the model's size: the longest arrow, as `forces.py`
const LEAST_FORCE = 0.005;  // of the scale: below, a force is not drawn
const LEAST = 0.03;         // of the scale: below, a slip or opening is not drawn
const THIN = 1.2, WIDE = 6; // pixels of the least and the largest slip or opening
const SENSES = 24, LEAST_SENSE = 0.2;  // most pairs of half-arrows, from this share on

export class Marks {
  constructor(view) {
    this.view = view;
    this.lines = new Lines();
  }

  /** A pixel of the screen in the units of the model. */
  get pixel() {
    return (window.devicePixelRatio || 1) / this.view.camera.scale;
  }

  lay() {
    const {contacts, model} = this.view;
    this.lines.start(0);
    if (!model.decoded) return;
    if (contacts === "force" || contacts === "chain") this.layForces(contacts === "chain");
    else if (contacts !== "none") this.layMovement(contacts);
    for (const kind of Object.keys(this.view.meta.lines)) this.layLines(kind);
  }

  /** A line with a rim in the colour of the paper. */
  rimmed(x0, y0, x1, y1, width, color) {
    this.lines.add(x0, y0, x1, y1, width + 2 * this.pixel, rgb(variable("--paper")));
    this.lines.add(x0, y0, x1, y1, width, color);
  }

  /** Resultants between neighbours: push, sums of push × place, of forces, blocks, sign. */
  resultants() {
    const {model, frame} = this.view, p = model.places, sums = new Map();
    const owner = model.owner();
    const after = (i) => i + 1 < model.first[owner[i] + 1] ? i + 1 : model.first[owner[i]];
    for (const [v, e, place, push, drag] of model.contactForces(frame)) {
      const a = owner[v], b = owner[e];
      const w = after(e), u = after(v), share = place / 100;
      const dx = p[2 * w] - p[2 * e], dy = p[2 * w + 1] - p[2 * e + 1];
      const length = Math.hypot(dx, dy) || 1, tx = dx / length, ty = dy / length;
      const sign = a < b ? 1 : -1;
      const key = Math.min(a, b) * model.n + Math.max(a, b);
      let sum = sums.get(key);
      if (!sum) sums.set(key, sum = [0, 0, 0, 0, 0, Math.min(a, b), Math.max(a, b)]);
      sum[0] += push;
      sum[1] += push * (p[2 * v] + share * (p[2 * u] - p[2 * v]));
      sum[2] += push * (p[2 * v + 1] + share * (p[2 * u + 1] - p[2 * v + 1]));
      sum[3] += sign * (push * ty - drag * tx);
      sum[4] += sign * (-push * tx - drag * ty);
    }
    return [...sums.values()];
  }

  /** The length of an arrow as large as the scale, as `arrow_length` of `forces.py`. */
  get reach() {
    return Math.min(0.8 * this.view.side, LONGEST * this.view.meta.size);
  }

  layForces(chains) {
    const found = this.resultants(), {model, frame} = this.view, {pixel} = this;
    const sizes = Float64Array.from(found, (sum) => Math.hypot(sum[3], sum[4]));
    const most = this.view.forceScale(limits(sizes, sizes.map(() => 1)).usual);
    const color = rgb(variable("--force")), ink = rgb(variable("--ink"));
    const pose = new Float64Array(6);
    const centre = (b) => {
      model.pose(frame, b, pose);
      return [0, 1].map((k) =>
        model.magnified(pose[k], model.start[6 * b + k], frame, k, this.view.factor));
    };
    this.lines.room((chains ? 4 : 5) * found.length);
    found.forEach(([push, x, y, fx, fy, a, b], k) => {
      const share = Math.min(sizes[k] / most, 1);
      if (sizes[k] < LEAST_FORCE * most) return;
      const cx = x / push, cy = y / push;
      if (chains) {
        const width = Math.max(9 * share, 0.6) * pixel;
        for (const end of [centre(a), centre(b)]) this.rimmed(...end, cx, cy, width, ink);
        return;
      }
      for (const sign of [1, -1]) {
        const ux = sign * fx / sizes[k], uy = sign * fy / sizes[k], length = this.reach * share;
        const tip = Math.min(4.5 * pixel, 0.6 * length);
        this.rimmed(cx - length * ux, cy - length * uy, cx - 1.5 * tip * ux, cy - 1.5 * tip * uy,
          2 * pixel, color);
        this.lines.head(cx, cy, ux, uy, tip, color);
      }
    });
  }

  /** Joints that have slipped or opened, wider and stronger with it; the largest lie above. */
  layMovement(name) {
    const {model, frame, meta, factor} = this.view, n = meta.faces, which = name === "slip" ? 0 : 1;
    const range = this.view.movementRange(name);
    if (range.high <= meta.floors.m) return;
    const poses = model.poses(frame), {pixel} = this, found = [], color = [0, 0, 0];
    for (let k = 0; k < n; k++) {
      const out = model.joint(k, frame, poses, new Float64Array(7));
      if (share(range, out[which]) >= LEAST) found.push([k, out]);
    }
    found.sort((a, b) => a[1][which] - b[1][which]);
    this.lines.room(2 * n + 12 * SENSES);
    found.forEach(([k, out], i) => {
      const part = share(range, out[which]), e = model.faceEnds;
      const at = [2, 3, 4, 5].map((j) =>
        model.magnified(out[j], e[6 * k + j - 2], frame, j % 2, factor));
      mapped(meta.maps.joint, part, color);
      this.rimmed(...at, (THIN + (WIDE - THIN) * part) * pixel, color);
      const last = i >= found.length - SENSES;
      if (which === 0 && last && part > LEAST_SENSE) this.laySense(at, out[6]);
    });
  }

  /** Half-arrows on both sides of a joint, as its sides have slipped. */
  laySense([x0, y0, x1, y1], sense) {
    const length = Math.hypot(x1 - x0, y1 - y0), {pixel} = this;
    const reach = Math.min(0.3 * length, 0.03 * this.view.meta.size);
    if (reach < 6 * pixel) return;
    const ux = (x1 - x0) / length, uy = (y1 - y0) / length, ink = rgb(variable("--ink"));
    for (const side of [1, -1]) {
      const s = side * sense, off = side * Math.max(0.35 * reach, 5 * pixel);
      const x = 0.5 * (x0 + x1) + off * uy, y = 0.5 * (y0 + y1) - off * ux;
      const tip = [x + s * reach * ux, y + s * reach * uy];
      this.rimmed(x - s * reach * ux, y - s * reach * uy, ...tip, 1.2 * pixel, ink);
      this.rimmed(...tip, tip[0] - 0.4 * reach * (s * ux - 0.6 * side * uy),
        tip[1] - 0.4 * reach * (s * uy + 0.6 * side * ux), 1.2 * pixel, ink);
    }
  }

  /** Bolts and channels of water, thicker with force or pressure; broken and part-full in dashes. */
  layLines(kind) {
    const {view, pixel} = this, {dashed, color: name} = view.meta.line_styles[kind];
    const lines = view.model.lines(kind, view.frame, view.factor), color = rgb(name);
    const most = lines.reduce((largest, {size}) => Math.max(largest, size), 0);
    view.largest[kind] = lines.length ? most : undefined;
    for (const {points, state, size} of lines) {
      const width = (1.5 + 3.5 * (most ? size / most : 0)) * pixel;
      const dashes = state === dashed ? DASHES : 1, part = dashes > 1 ? 0.5 : 1;
      this.lines.room(2 * dashes * points.length);
      for (let i = 1; i < points.length; i++) {
        const [x, y] = points[i - 1], dx = points[i][0] - x, dy = points[i][1] - y;
        for (let k = 0; k < dashes; k++) {
          const from = k / dashes, to = (k + part) / dashes;
          this.rimmed(x + from * dx, y + from * dy, x + to * dx, y + to * dy, width, color);
        }
      }
    }
  }
}
