// The blocks of a view in any frame: where they are and what they carry.

import {channel, floats, inflate, integers, value} from "./streams.js";
import {limits} from "./words.js";

export class Model {
  constructor(meta, streams) {
    this.meta = meta;
    this.streams = streams;
    this.n = meta.blocks;
    this.frames = meta.time.length;
    this.decoded = false;
  }

  /** Shapes and names; the first frame can be drawn after it. */
  async readShapes() {
    const [start, offsets, counts, material, names] = await Promise.all([
      floats(this.streams, "start"), floats(this.streams, "offsets"), inflate(this.streams, "counts"),
      inflate(this.streams, "material"), inflate(this.streams, "names")]);
    this.start = start;
    this.offsets = offsets;
    this.counts = new Uint16Array(counts.buffer);
    this.material = this.n === material.length ? material : new Uint16Array(material.buffer);
    this.names = new TextDecoder().decode(names).split("\n");
    this.first = new Int32Array(this.n + 1);
    for (let b = 0; b < this.n; b++) this.first[b + 1] = this.first[b] + this.counts[b];
    this.vertices = this.first[this.n];
    this.places = new Float32Array(2 * this.vertices);
    this.rest = new Float32Array(2 * this.vertices);
    this.put(-1, 1);
    this.rest.set(this.places);
  }

  async readMotion() {
    const read = (list, things) => Promise.all(
      list.map((one) => channel(this.streams, one, this.frames, things)));
    const found = await read(this.meta.channels, this.n);
    this.channels = {};
    this.meta.channels.forEach((one, k) => { this.channels[one.name] = found[k]; });
    this.faceBlocks = await integers(this.streams, "face_blocks");
    this.faceEnds = await floats(this.streams, "face_ends");
    if (this.meta.pairs) {
      this.pairs = await integers(this.streams, "pairs");
      const force = await read(this.meta.force_channels, this.meta.pairs);
      this.force = {};
      this.meta.force_channels.forEach((one, k) => { this.force[one.name] = force[k]; });
    }
    this.lineValues = {};
    for (const [kind, lines] of Object.entries(this.meta.lines)) {
      const [size, state] = await read(this.meta[`${kind}_channels`], lines.length);
      this.lineValues[kind] = {size, state};
    }
    this.decoded = true;
  }

  /** Closed contacts of a frame: vertex, edge, hundredths of the vertex's edge, forces (N/m). */
  * contactForces(frame) {
    const n = this.meta.pairs, {normal, shear} = this.force || {};
    for (let k = 0; k < n; k++) {
      const push = value(normal, frame * n + k);
      if (push <= 0) continue;
      const [vertex, edge, place] = this.pairs.subarray(3 * k, 3 * k + 3);
      yield [vertex, edge, place, push, value(shear, frame * n + k)];
    }
  }

  /** Bolts or channels of water that are there in a frame: x, y of their points, size, state. */
  lines(kind, frame, factor) {
    const lines = this.meta.lines[kind] || [], n = lines.length, {size, state} = this.lineValues[kind] || {};
    const pose = new Float64Array(6), found = [];
    const place = (at, b, ox, oy) => {
      this.pose(at, b, pose);
      return [pose[0] + pose[2] * ox + pose[3] * oy, pose[1] + pose[4] * ox + pose[5] * oy];
    };
    for (const [k, {blocks, offsets}] of lines.entries()) {
      const now = value(state, frame * n + k);
      if (!now) continue;
      const points = blocks.map((b, i) => {
        const offset = offsets.slice(2 * i, 2 * i + 2);
        const first = place(-1, b, ...offset);
        return place(frame, b, ...offset).map((x, axis) => this.magnified(x, first[axis], frame, axis, factor));
      });
      found.push({points, state: now, size: Math.abs(value(size, frame * n + k))});
    }
    return found;
  }

  at(name, frame, block) {
    return value(this.channels[name], frame * this.n + block);
  }

  /** Coordinates of a block: x, y, rotation, three strains, and the 2 × 2 matrix R (I + ε). */
  pose(frame, b, out) {
    const s = this.start, o = 6 * b;
    let x = s[o], y = s[o + 1], turn = s[o + 2], ex = s[o + 3], ey = s[o + 4], g = s[o + 5];
    if (frame >= 0 && this.decoded) {
      const c = this.channels, i = frame * this.n + b;
      x += c.u.values[i] * c.u.quantum;
      y += c.v.values[i] * c.v.quantum;
      turn += c.turn.values[i] * c.turn.quantum;
      ex += c.ex.values[i] * c.ex.quantum;
      ey += c.ey.values[i] * c.ey.quantum;
      g += c.gxy.values[i] * c.gxy.quantum;
    }
    const cos = Math.cos(turn), sin = Math.sin(turn);
    out[0] = x;
    out[1] = y;
    out[2] = cos * (1 + ex) - sin * 0.5 * g;
    out[3] = cos * 0.5 * g - sin * (1 + ey);
    out[4] = sin * (1 + ex) + cos * 0.5 * g;
    out[5] = sin * 0.5 * g + cos * (1 + ey);
    return out;
  }

  /** All vertices of a frame, displacements times a factor. */
  put(frame, factor) {
    const pose = new Float64Array(6), {places, offsets, first, rest} = this;
    for (let b = 0; b < this.n; b++) {
      this.pose(frame, b, pose);
      for (let v = first[b]; v < first[b + 1]; v++) {
        const ox = offsets[2 * v], oy = offsets[2 * v + 1];
        places[2 * v] = pose[0] + pose[2] * ox + pose[3] * oy;
        places[2 * v + 1] = pose[1] + pose[4] * ox + pose[5] * oy;
      }
    }
    for (const [b, gone] of this.meta.removals || []) {
      if (frame < gone) continue;  // a removed block shrinks to nothing
      for (let v = first[b]; v < first[b + 1]; v++) {
        places[2 * v] = rest[2 * first[b]];
        places[2 * v + 1] = rest[2 * first[b] + 1];
      }
    }
    if (factor !== 1) {
      for (let i = 0; i < places.length; i++) {
        places[i] = this.magnified(places[i], rest[i], frame, i % 2, factor);
      }
    }
  }

  /** Two principal stresses, largest first; NaN and the compression where only that is known. */
  stresses(frame, b) {
    const c = this.channels;
    if (c.compression) return [NaN, -this.at("compression", frame, b)];
    const sx = this.at("sx", frame, b), sy = this.at("sy", frame, b);
    const t = this.at("txy", frame, b), mean = 0.5 * (sx + sy);
    const radius = Math.hypot(0.5 * (sx - sy), t);
    return [mean + radius, mean - radius];
  }

  /** Displacement of the base, m. */
  base(frame) {
    return (this.meta.base || [])[Math.round(frame)] || [0, 0];
  }

  /** A coordinate whose displacement relative to the base is multiplied by a factor. */
  magnified(now, rest, frame, axis, factor) {
    return now + (factor - 1) * (now - rest - this.base(frame)[axis]);
  }

  /** Displacement of a block along x and y relative to the base, m. */
  moved(frame, b) {
    const base = this.base(frame);
    return [this.at("u", frame, b) - base[0], this.at("v", frame, b) - base[1]];
  }

  quantity(name, frame, b) {
    if (!this.decoded) return 0;
    switch (name) {
      case "displacement": return Math.hypot(...this.moved(frame, b));
      case "displacement_x": return this.moved(frame, b)[0];
      case "displacement_y": return this.moved(frame, b)[1];
      case "velocity": return this.at("speed", frame, b);
      case "rotation": return this.at("turn", frame, b) * 180 / Math.PI;
      case "compression": return -this.stresses(frame, b)[1];
      case "tension": return this.stresses(frame, b)[0];
      case "stress_error": return this.at(name, frame, b);
      case "plastic_strain": case "damage": return 100 * this.at(name, frame, b);
      default: return 0;
    }
  }

  kind(name) {
    return this.meta.quantities.find((one) => one.name === name);
  }

  /** Limits of the colours of a quantity: of a frame, or, for −1, of all. */
  range(name, frame) {
    if (frame < 0) return this.meta.ranges[name] || {low: 0, high: 0, usual: 0};
    const found = Float64Array.from({length: this.n}, (_, b) => this.quantity(name, frame, b));
    for (const [b, gone] of this.meta.removals || []) if (frame >= gone) found[b] = NaN;
    return limits(found, this.areas(), this.kind(name).signed);
  }

  /** Areas of the blocks at the start, m². */
  areas() {
    if (!this.weights) {
      const now = this.places;
      this.places = this.rest;
      this.weights = Float64Array.from({length: this.n}, (_, b) => this.area(b));
      this.places = now;
    }
    return this.weights;
  }

  /** The block of each vertex. */
  owner() {
    if (!this.owners) {
      this.owners = new Int32Array(this.vertices);
      for (let b = 0; b < this.n; b++) this.owners.fill(b, this.first[b], this.first[b + 1]);
    }
    return this.owners;
  }

  area(b) {
    let sum = 0;
    const p = this.places, from = this.first[b], to = this.first[b + 1];
    for (let v = from; v < to; v++) {
      const w = v + 1 < to ? v + 1 : from;
      sum += (p[2 * v] - p[2 * from]) * (p[2 * w + 1] - p[2 * from + 1])
        - (p[2 * w] - p[2 * from]) * (p[2 * v + 1] - p[2 * from + 1]);
    }
    return 0.5 * sum;
  }

  /** The block that holds a point, or −1. */
  blockAt(x, y) {
    const p = this.places;
    for (let b = this.n - 1; b >= 0; b--) {
      const from = this.first[b], to = this.first[b + 1];
      let inside = false;
      for (let v = from, w = to - 1; v < to; w = v++) {
        const yv = p[2 * v + 1], yw = p[2 * w + 1];
        if ((yv > y) !== (yw > y)
          && x < (p[2 * w] - p[2 * v]) * (y - yv) / (yw - yv) + p[2 * v]) inside = !inside;
      }
      if (inside) return b;
    }
    return -1;
  }

  /** Triangles of all blocks, as indices of vertices. */
  triangles() {
    const list = [];
    for (let b = 0; b < this.n; b++) {
      const from = this.first[b], count = this.counts[b];
      const own = Array.from({length: count}, (_, i) => from + i);
      if (isConvex(this.offsets, own)) {
        for (let i = 1; i + 1 < count; i++) list.push(from, from + i, from + i + 1);
      } else {
        clipEars(this.offsets, own, list);
      }
    }
    return new Uint32Array(list);
  }

  /** Edges of all blocks, as pairs of vertices. */
  edges() {
    const list = new Uint32Array(2 * this.vertices);
    for (let b = 0; b < this.n; b++) {
      for (let v = this.first[b]; v < this.first[b + 1]; v++) {
        list[2 * v] = v;
        list[2 * v + 1] = v + 1 < this.first[b + 1] ? v + 1 : this.first[b];
      }
    }
    return list;
  }

  /** Slip and opening of interface k since the start, where its ends are (x, y, x, y), sense. */
  joint(k, frame, poses, out) {
    const a = this.faceBlocks[2 * k], b = this.faceBlocks[2 * k + 1], e = this.faceEnds;
    const turn = this.at("turn", frame, a), cos = Math.cos(turn), sin = Math.sin(turn);
    const nx = cos * e[6 * k + 4] - sin * e[6 * k + 5];
    const ny = sin * e[6 * k + 4] + cos * e[6 * k + 5];
    out[0] = out[1] = out[6] = 0;
    for (let end = 0; end < 2; end++) {
      const x = e[6 * k + 2 * end], y = e[6 * k + 2 * end + 1];
      const [ax, ay] = this.carried(a, x, y, poses), [bx, by] = this.carried(b, x, y, poses);
      const dx = bx - ax, dy = by - ay, along = nx * dy - ny * dx;
      if (Math.abs(along) > out[0]) {
        out[0] = Math.abs(along);
        out[6] = Math.sign(along);
      }
      out[1] = Math.max(out[1], nx * dx + ny * dy);
      out[2 + 2 * end] = ax;
      out[3 + 2 * end] = ay;
    }
    if (this.isGone(a, frame) || this.isGone(b, frame)) out[0] = out[1] = 0;
    return out;
  }

  isGone(block, frame) {
    return (this.meta.removals || []).some(([b, gone]) => b === block && frame >= gone);
  }

  /** Slip (0) or opening (1) of interface k in all frames, m. */
  jointHistory(k, which) {
    const poses = new Float64Array(6 * this.n), one = new Float64Array(6), out = new Float64Array(7);
    return Float64Array.from({length: this.frames}, (_, f) => {
      for (const b of this.faceBlocks.subarray(2 * k, 2 * k + 2)) poses.set(this.pose(f, b, one), 6 * b);
      return this.joint(k, f, poses, out)[which];
    });
  }

  /** Normal and shear force between the blocks of interface k, N/m. */
  jointForce(k, frame) {
    const [a, b] = this.faceBlocks.subarray(2 * k, 2 * k + 2), owner = this.owner();
    let normal = 0, shear = 0;
    for (const [v, e, , push, drag] of this.contactForces(frame)) {
      const from = owner[v], to = owner[e];
      if (!(from === a && to === b) && !(from === b && to === a)) continue;
      normal += push;
      shear += drag;
    }
    return [normal, shear];
  }

  /** Lengths of the interfaces at the start, m. */
  faceLengths() {
    const e = this.faceEnds;
    return this.lengths ||= Float64Array.from({length: this.meta.faces}, (_, k) =>
      Math.hypot(e[6 * k + 2] - e[6 * k], e[6 * k + 3] - e[6 * k + 1]));
  }

  /** Where a point of a block, given in the first frame, is now. */
  carried(b, x, y, poses) {
    const r = this.restPoses, o = 6 * b;
    const dx = x - r[o], dy = y - r[o + 1];
    const det = r[o + 2] * r[o + 5] - r[o + 3] * r[o + 4];
    const ox = (r[o + 5] * dx - r[o + 3] * dy) / det;
    const oy = (r[o + 2] * dy - r[o + 4] * dx) / det;
    return [poses[o] + poses[o + 2] * ox + poses[o + 3] * oy,
      poses[o + 1] + poses[o + 4] * ox + poses[o + 5] * oy];
  }

  poses(frame) {
    const all = new Float64Array(6 * this.n), one = new Float64Array(6);
    for (let b = 0; b < this.n; b++) all.set(this.pose(frame, b, one), 6 * b);
    return all;
  }
}

function turnOf(p, a, b, c) {
  return (p[2 * b] - p[2 * a]) * (p[2 * c + 1] - p[2 * a + 1])
    - (p[2 * b + 1] - p[2 * a + 1]) * (p[2 * c] - p[2 * a]);
}

function isConvex(p, own) {
  const n = own.length;
  if (n === 3) return true;
  for (let i = 0; i < n; i++) {
    if (turnOf(p, own[i], own[(i + 1) % n], own[(i + 2) % n]) < 0) return false;
  }
  return true;
}

/** Triangles of a simple polygon: an ear, a corner that holds no other one, at a time. */
function clipEars(p, own, list) {
  while (own.length > 3) {
    const n = own.length;
    let best = 0;
    for (let i = 0; i < n; i++) {
      const [a, b, c] = [own[(i + n - 1) % n], own[i], own[(i + 1) % n]];
      if (turnOf(p, a, b, c) <= 0) continue;
      const holds = own.some((v) => v !== a && v !== b && v !== c && turnOf(p, a, b, v) >= 0
        && turnOf(p, b, c, v) >= 0 && turnOf(p, c, a, v) >= 0);
      if (!holds) {
        best = i;
        break;
      }
    }
    list.push(own[(best + n - 1) % n], own[best], own[(best + 1) % n]);
    own.splice(best, 1);
  }
  list.push(...own);
}
