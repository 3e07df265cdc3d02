"use strict";
// The interactive view of blocks: decodes the streams of a page, draws them with WebGL 2 (with
// Canvas 2D where that is refused) and lets the user play, scrub, zoom, pan and pick.
// Nothing is loaded: all data stand in the page.

(() => {
  const DARK = matchMedia("(prefers-color-scheme: dark)");
  const ON_LIGHT = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b58900", "#7a58b0", "#4a90a4",
    "#a05a2c"];
  const ON_DARK = ["#5ab4f0", "#ff9a4d", "#4fd1a5", "#f0a6cf", "#e6c34a", "#b79df0", "#7fd0e0",
    "#d9a07a"];
  const lineColor = (i) => (DARK.matches ? ON_DARK : ON_LIGHT)[i % ON_LIGHT.length];
  const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];
  const FALLBACK_BLOCKS = 8000;  // drawn without WebGL
  const SAMPLES = 200000;        // values that the limits of the colours are found from
  const SHOWN = 0.99;            // share of them that the colours tell apart
  const DASHES = 12;             // of each leg of a broken bolt
  const SMOOTH_BLOCKS = 300;     // up to which software rendering smooths edges

  // --- streams --------------------------------------------------------------------------------

  async function inflate(view, name) {
    const node = document.getElementById(`${view}-${name}`);
    const text = node.textContent.trim();
    node.remove();  // megabytes of text are not needed twice
    const bytes = Uint8Array.fromBase64 ? Uint8Array.fromBase64(text) : fromBase64(text);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  function fromBase64(text) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    return bytes;
  }

  const floats = async (view, name) => new Float32Array((await inflate(view, name)).buffer);
  const integers = async (view, name) => new Int32Array((await inflate(view, name)).buffer);

  /** Sums of zigzag differences: whole numbers of all frames, frame after frame. */
  function summed(bytes, width, wide, frames, things) {
    const values = wide ? new Int32Array(frames * things) : new Int16Array(frames * things);
    const sums = new Int32Array(things);
    for (let f = 0; f < frames; f++) {
      const at = f * things * width, to = f * things;
      for (let i = 0; i < things; i++) {
        let code = bytes[at + i];
        if (width > 1) code |= bytes[at + things + i] << 8;
        if (width > 2) code |= bytes[at + 2 * things + i] << 16;
        if (width > 3) code |= bytes[at + 3 * things + i] << 24;
        sums[i] += (code >>> 1) ^ -(code & 1);
        values[to + i] = sums[i];
      }
    }
    return values;
  }

  async function channel(view, described, frames, things) {
    const bytes = await inflate(view, described.name);
    const values = summed(bytes, described.bytes, described.wide, frames, things);
    return {values, quantum: described.quantum, root: described.root};
  }

  /** Value i of a channel; of some the roots are stored. */
  function value(channel, i) {
    const x = channel.values[i] * channel.quantum;
    return channel.root ? Math.sign(x) * x * x : x;
  }

  /** A value that only a small share of many are above. */
  function quantile(values, share) {
    const sorted = Float64Array.from(values).sort();
    return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] : 0;
  }

  // --- small helpers --------------------------------------------------------------------------

  function element(tag, parent, text = "", name = "") {
    const node = document.createElement(tag);
    if (text) node.textContent = text;
    if (name) node.className = name;
    if (parent) parent.append(node);
    return node;
  }

  const PREFIXES = {
    m: [[1, "m"], [1e-3, "mm"], [1e-6, "µm"], [1e-9, "nm"]],
    "m/s": [[1, "m/s"], [1e-3, "mm/s"], [1e-6, "µm/s"]],
    Pa: [[1e9, "GPa"], [1e6, "MPa"], [1e3, "kPa"], [1, "Pa"]],
    "N/m": [[1e9, "GN/m"], [1e6, "MN/m"], [1e3, "kN/m"], [1, "N/m"]],
    "J/m": [[1e9, "GJ/m"], [1e6, "MJ/m"], [1e3, "kJ/m"], [1, "J/m"]],
  };

  function inUnit(largest, unit) {
    const steps = PREFIXES[unit] || [[1, unit]];
    for (const step of steps) if (Math.abs(largest) >= step[0]) return step;
    return largest === 0 ? steps.find((step) => step[0] === 1) || steps[0] : steps[steps.length - 1];
  }

  function short(value) {
    if (!isFinite(value)) return "–";
    if (value === 0) return "0";
    const size = Math.abs(value);
    return size >= 1e5 || size < 1e-4 ? value.toExponential(2) : String(+value.toPrecision(4));
  }

  function withUnit(value, unit) {
    const [scale, name] = inUnit(value, unit);
    return `${short(value / scale)} ${name}`;
  }

  /** Round numbers for about so many ticks. */
  function ticks(low, high, count) {
    const raw = (high - low) / Math.max(1, count);
    if (!(raw > 0) || !isFinite(raw)) return [low];
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
    const found = [];
    for (let t = Math.ceil(low / step - 1e-9) * step; t <= high + 1e-9 * step; t += step) {
      found.push(Math.abs(t) < 1e-9 * step ? 0 : t);
    }
    return found;
  }

  function variable(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  }

  function rgb(text) {
    const value = parseInt(text.slice(1), 16);
    return [value >> 16, (value >> 8) & 255, value & 255];
  }

  function mapped(stops, share, out) {
    const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
    const i = Math.min(Math.floor(at), stops.length - 2), t = at - i;
    for (let k = 0; k < 3; k++) out[k] = stops[i][k] + t * (stops[i + 1][k] - stops[i][k]);
    return out;
  }

  // --- the model ------------------------------------------------------------------------------

  class Model {
    constructor(id, meta) {
      this.id = id;
      this.meta = meta;
      this.n = meta.blocks;
      this.frames = meta.time.length;
      this.decoded = false;
    }

    /** Shapes and names; the first frame can be drawn after it. */
    async readShapes() {
      const [start, offsets, counts, material, names] = await Promise.all([
        floats(this.id, "start"), floats(this.id, "offsets"), inflate(this.id, "counts"),
        inflate(this.id, "material"), inflate(this.id, "names")]);
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
        list.map((one) => channel(this.id, one, this.frames, things)));
      const found = await read(this.meta.channels, this.n);
      this.channels = {};
      this.meta.channels.forEach((one, k) => { this.channels[one.name] = found[k]; });
      this.decoded = true;
      this.faceBlocks = await integers(this.id, "face_blocks");
      this.faceEnds = await floats(this.id, "face_ends");
      if (this.meta.pairs) {
        this.pairs = await integers(this.id, "pairs");
        const force = await read(this.meta.force_channels, this.meta.pairs);
        this.force = {};
        this.meta.force_channels.forEach((one, k) => { this.force[one.name] = force[k]; });
      }
      if (this.meta.bolts.length) {
        [this.boltForce, this.boltState] = await read(this.meta.bolt_channels,
          this.meta.bolts.length);
      }
    }

    /** The bolts that are there in a frame: x, y of the points on their way, force, state. */
    bolts(frame, factor) {
      const n = this.meta.bolts.length, pose = new Float64Array(6), found = [];
      const place = (at, b, ox, oy) => {
        this.pose(at, b, pose);
        return [pose[0] + pose[2] * ox + pose[3] * oy, pose[1] + pose[4] * ox + pose[5] * oy];
      };
      for (const [k, {blocks, offsets}] of this.meta.bolts.entries()) {
        const state = value(this.boltState, frame * n + k);
        if (!state) continue;
        const points = blocks.map((b, i) => {
          const offset = offsets.slice(2 * i, 2 * i + 2);
          const first = place(-1, b, ...offset), now = place(frame, b, ...offset);
          return now.map((x, axis) => first[axis] + factor * (x - first[axis]));
        });
        found.push({points, state, force: Math.abs(value(this.boltForce, frame * n + k))});
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
          places[i] = rest[i] + factor * (places[i] - rest[i]);
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

    quantity(name, frame, b) {
      if (!this.decoded) return 0;
      switch (name) {
        case "displacement": return Math.hypot(this.at("u", frame, b), this.at("v", frame, b));
        case "velocity": return this.at("speed", frame, b);
        case "rotation": return this.at("turn", frame, b) * 180 / Math.PI;
        case "stress": return -this.stresses(frame, b)[1];
        default: return 0;
      }
    }

    /** Limits of the colours of a quantity: of a frame, or of all but the rarest values of all. */
    range(name, frame) {
      if (!this.decoded) return [0, 1];
      this.ranges ||= {};
      if (frame < 0 && this.ranges[name]) return this.ranges[name];
      const found = [];
      const step = frame < 0 ? Math.max(1, Math.floor(this.n * this.frames / SAMPLES)) : 1;
      const first = frame < 0 ? 0 : frame * this.n;
      const end = frame < 0 ? this.n * this.frames : first + this.n;
      for (let i = first; i < end; i += step) {
        found.push(this.quantity(name, Math.floor(i / this.n), i % this.n));
      }
      const share = frame < 0 ? SHOWN : 1;
      let low = Math.min(0, -quantile(found.map((v) => -v), share));
      let high = Math.max(0, quantile(found, share));
      if (name === "rotation") {
        high = Math.max(-low, high) || 1;
        low = -high;
      } else if (name !== "stress") {
        low = 0;
      }
      const limits = [low, high > low ? high : low + 1];
      if (frame < 0) this.ranges[name] = limits;
      return limits;
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

    /** Slip and opening of interface k since the start, and where its ends are: x, y, x, y. */
    joint(k, frame, poses, out) {
      const a = this.faceBlocks[2 * k], b = this.faceBlocks[2 * k + 1], e = this.faceEnds;
      const turn = this.at("turn", frame, a), cos = Math.cos(turn), sin = Math.sin(turn);
      const nx = cos * e[6 * k + 4] - sin * e[6 * k + 5];
      const ny = sin * e[6 * k + 4] + cos * e[6 * k + 5];
      out[0] = out[1] = 0;
      for (let end = 0; end < 2; end++) {
        const x = e[6 * k + 2 * end], y = e[6 * k + 2 * end + 1];
        const [ax, ay] = this.carried(a, x, y, poses), [bx, by] = this.carried(b, x, y, poses);
        const dx = bx - ax, dy = by - ay;
        out[0] = Math.max(out[0], Math.abs(nx * dy - ny * dx));
        out[1] = Math.max(out[1], nx * dx + ny * dy);
        out[2 + 2 * end] = ax;
        out[3 + 2 * end] = ay;
      }
      return out;
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

  // --- painters -------------------------------------------------------------------------------

  const VERTEX = `#version 300 es
    in vec2 place; in vec4 tint; out vec4 shade; uniform vec4 view; uniform float dark;
    void main() {
      gl_Position = vec4((place - view.xy) * view.zw, 0.0, 1.0);
      shade = vec4(mix(tint.rgb, vec3(0.09, 0.1, 0.12), dark), 1.0);
    }`;
  const FRAGMENT = `#version 300 es
    precision mediump float; in vec4 shade; out vec4 color; uniform float alpha;
    void main() { color = vec4(shade.rgb * alpha, alpha); }`;

  /** WebGL is computed by the processor: each sample of a pixel costs time. */
  function inSoftware() {
    const gl = document.createElement("canvas").getContext("webgl2");
    if (!gl) return true;
    const known = gl.getExtension("WEBGL_debug_renderer_info");
    const name = String(gl.getParameter(known ? known.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    gl.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|software|basic render/i.test(name);
  }

  class GlPainter {
    constructor(canvas, model) {
      const antialias = model.n <= SMOOTH_BLOCKS || !inSoftware();
      const gl = canvas.getContext("webgl2", {antialias, alpha: false, depth: false});
      if (!gl) throw new Error("no WebGL 2");
      this.gl = gl;
      this.kind = "WebGL 2";
      this.note = "";
      this.program = this.link();
      this.uniform = {};
      for (const name of ["view", "dark", "alpha"]) {
        this.uniform[name] = gl.getUniformLocation(this.program, name);
      }
      this.triangles = model.triangles();
      this.edges = model.edges();
      this.places = gl.createBuffer();
      this.tints = gl.createBuffer();
      this.faces = this.indices(this.triangles);
      this.lines = this.indices(this.edges);
      this.extra = gl.createBuffer();
      this.extraTints = gl.createBuffer();
    }

    link() {
      const gl = this.gl, program = gl.createProgram();
      for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
      }
      gl.bindAttribLocation(program, 0, "place");
      gl.bindAttribLocation(program, 1, "tint");
      gl.linkProgram(program);
      if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
        throw new Error(gl.getProgramInfoLog(program));
      }
      return program;
    }

    indices(values) {
      const gl = this.gl, buffer = gl.createBuffer();
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, values, gl.STATIC_DRAW);
      return buffer;
    }

    attribute(index, buffer, values, size, type, normal) {
      const gl = this.gl;
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, size, type, normal, 0, 0);
    }

    paint(model, camera, tints, edgeAlpha, extra) {
      const gl = this.gl;
      gl.viewport(0, 0, camera.width, camera.height);
      gl.clearColor(...rgb(variable("--card")).map((c) => c / 255), 1);
      gl.clear(gl.COLOR_BUFFER_BIT);
      gl.disable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      gl.useProgram(this.program);
      gl.uniform4f(this.uniform.view, camera.x, camera.y,
        2 * camera.scale / camera.width, 2 * camera.scale / camera.height);
      this.attribute(0, this.places, model.places, 2, gl.FLOAT, false);
      this.attribute(1, this.tints, tints, 4, gl.UNSIGNED_BYTE, true);
      gl.uniform1f(this.uniform.dark, 0);
      gl.uniform1f(this.uniform.alpha, 1);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.faces);
      gl.drawElements(gl.TRIANGLES, this.triangles.length, gl.UNSIGNED_INT, 0);
      if (edgeAlpha > 0) {
        gl.enable(gl.BLEND);
        gl.uniform1f(this.uniform.dark, 1);
        gl.uniform1f(this.uniform.alpha, edgeAlpha);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.lines);
        gl.drawElements(gl.LINES, this.edges.length, gl.UNSIGNED_INT, 0);
      }
      if (extra.count) {
        gl.uniform1f(this.uniform.dark, 0);
        gl.uniform1f(this.uniform.alpha, 1);
        this.attribute(0, this.extra, extra.places.subarray(0, 2 * extra.count), 2, gl.FLOAT, false);
        this.attribute(1, this.extraTints, extra.tints.subarray(0, 4 * extra.count), 4,
          gl.UNSIGNED_BYTE, true);
        gl.drawArrays(gl.TRIANGLES, 0, extra.count);
      }
    }
  }

  class FlatPainter {
    constructor(canvas, model) {
      this.context = canvas.getContext("2d");
      this.kind = "Canvas 2D";
      this.chosen = Array.from({length: model.n}, (_, b) => b);
      this.note = "This browser refuses WebGL 2, so Canvas 2D draws";
      if (model.n > FALLBACK_BLOCKS) {
        const area = this.chosen.map((b) => model.area(b));
        this.chosen.sort((a, b) => area[b] - area[a]);
        this.chosen.length = FALLBACK_BLOCKS;
        this.note += ` the ${FALLBACK_BLOCKS.toLocaleString("en")} largest of `
          + `${model.n.toLocaleString("en")} blocks`;
      }
      this.note += ".";
    }

    paint(model, camera, tints, edgeAlpha, extra) {
      const c = this.context, {first, places} = model;
      c.fillStyle = variable("--card");
      c.fillRect(0, 0, camera.width, camera.height);
      const s = camera.scale, x0 = camera.width / 2 - s * camera.x;
      const y0 = camera.height / 2 + s * camera.y;
      c.lineWidth = 1;
      c.strokeStyle = `rgba(23, 26, 31, ${edgeAlpha})`;
      for (const b of this.chosen) {
        c.beginPath();
        for (let v = first[b]; v < first[b + 1]; v++) {
          c.lineTo(x0 + s * places[2 * v], y0 - s * places[2 * v + 1]);
        }
        c.closePath();
        const t = 4 * first[b];
        c.fillStyle = `rgb(${tints[t]}, ${tints[t + 1]}, ${tints[t + 2]})`;
        c.fill();
        if (edgeAlpha > 0) c.stroke();
      }
      for (let i = 0; i < extra.count; i += 3) {
        c.beginPath();
        for (let k = i; k < i + 3; k++) {
          c.lineTo(x0 + s * extra.places[2 * k], y0 - s * extra.places[2 * k + 1]);
        }
        c.fillStyle = `rgb(${extra.tints[4 * i]}, ${extra.tints[4 * i + 1]}, ${extra.tints[4 * i + 2]})`;
        c.fill();
      }
    }
  }

  /** Thick lines as triangles. */
  class Lines {
    constructor() {
      this.count = 0;
      this.places = new Float32Array(0);
      this.tints = new Uint8Array(0);
    }

    start(most) {
      this.count = 0;
      this.room(most);
    }

    /** Place for so many more lines. */
    room(more) {
      const corners = this.count + 6 * more;
      if (this.places.length >= 2 * corners) return;
      const {places, tints} = this;
      this.places = new Float32Array(2 * corners);
      this.tints = new Uint8Array(4 * corners);
      this.places.set(places);
      this.tints.set(tints);
    }

    add(x0, y0, x1, y1, width, color) {
      const length = Math.hypot(x1 - x0, y1 - y0) || 1;
      const nx = -0.5 * width * (y1 - y0) / length, ny = 0.5 * width * (x1 - x0) / length;
      const corners = [x0 + nx, y0 + ny, x0 - nx, y0 - ny, x1 + nx, y1 + ny, x1 + nx, y1 + ny,
        x0 - nx, y0 - ny, x1 - nx, y1 - ny];
      this.places.set(corners, 2 * this.count);
      for (let k = 0; k < 6; k++) {
        const at = 4 * (this.count + k);
        this.tints[at] = color[0];
        this.tints[at + 1] = color[1];
        this.tints[at + 2] = color[2];
        this.tints[at + 3] = 255;
      }
      this.count += 6;
    }
  }

  // --- charts ---------------------------------------------------------------------------------

  class Chart {
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

  // --- the view -------------------------------------------------------------------------------

  class View {
    constructor(root) {
      this.root = root;
      this.id = root.id;
      this.meta = JSON.parse(document.getElementById(`${this.id}-meta`).textContent);
      this.model = new Model(this.id, this.meta);
      this.frame = 0;
      this.picked = -1;
      this.playing = false;
      this.factor = 1;
      this.color = this.meta.color;
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
      this.canvas.setAttribute("aria-label", "Blocks; arrow keys step, space plays");
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
      this.slider.max = this.model.frames - 1;
      this.slider.value = 0;
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
      const last = this.meta.time[this.meta.time.length - 1] - this.meta.time[0];
      this.speed = SPEEDS.reduce((a, b) => Math.abs(Math.log(last / b / 10))
        < Math.abs(Math.log(last / a / 10)) ? b : a);
      if (last > 4 && last < 40) this.speed = 1;
      select("speed", SPEEDS.map((s) => [s, `× ${s}`]), this.speed, (v) => { this.speed = +v; });
      this.colorSelect = select("color", [["material", "material"],
        ["displacement", "displacement"], ["velocity", "velocity"], ["rotation", "rotation"],
        ["stress", "compression"]], this.color, (v) => this.setColor(v));
      const kinds = [["none", "none"]];
      if (this.meta.faces) kinds.push(["slip", "slip"], ["open", "opening"]);
      if (this.meta.pairs) kinds.splice(1, 0, ["force", "forces"]);
      this.contactSelect = select("contacts", kinds, "none", (v) => this.setContacts(v));
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
      this.root.classList.toggle("still", this.model.frames === 1);
    }

    // Start

    async begin() {
      const begun = performance.now();
      await this.model.readShapes();
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
      this.tints = new Uint8Array(4 * this.model.vertices);
      this.side = Math.sqrt(this.model.area(0));
      const areas = Array.from({length: this.model.n}, (_, b) => this.model.area(b));
      areas.sort((a, b) => a - b);
      this.side = Math.sqrt(Math.max(areas[areas.length >> 1], 0));
      this.resize();
      this.fit();
      this.state.ready = true;
      this.state.firstFrameMs = performance.now() - begun;
      await new Promise((done) => setTimeout(done, 0));
      await this.model.readMotion();
      this.model.restPoses = this.model.poses(-1);
      await this.buildCharts();
      this.state.decoded = true;
      this.state.decodedMs = performance.now() - begun;
      this.tell();
      this.show(this.meta.frame ?? this.model.frames - 1);
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
      for (const chart of this.meta.charts) {
        const lines = [];
        for (const line of chart.lines) {
          const values = await floats(this.id, line.stream);
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
        End: () => this.show(this.model.frames - 1)};
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
      const {model, frame} = this, n = this.meta.pairs, p = model.places;
      const {normal, shear} = model.force, sums = new Map();
      const owner = this.owner ||= this.ownerOf();
      for (let k = 0; k < n; k++) {
        const push = value(normal, frame * n + k);
        if (push <= 0) continue;
        const drag = value(shear, frame * n + k);
        const [v, e, place] = model.pairs.subarray(3 * k, 3 * k + 3), a = owner[v], b = owner[e];
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
    }

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

  // --- start ----------------------------------------------------------------------------------

  window.blockViews = [];
  for (const root of document.querySelectorAll(".block-view")) {
    const view = new View(root);
    window.blockViews.push(view);
    view.begin().catch((trouble) => {
      element("p", root, `The view cannot be shown: ${trouble.message}`, "trouble");
      view.state.trouble = String(trouble);
    });
  }
})();
