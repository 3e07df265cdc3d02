// Blocks and lines on a canvas, by WebGL 2 or, where that is refused, by Canvas 2D.

import {rgb, variable} from "./words.js";

const FALLBACK_BLOCKS = 8000;  // drawn without WebGL
const SMOOTH_BLOCKS = 300;     // up to which software rendering smooths edges

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

export class GlPainter {
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
    this.places = gl.createBuffer();
    this.tints = gl.createBuffer();
    this.faces = gl.createBuffer();
    this.lines = gl.createBuffer();
    this.extra = gl.createBuffer();
    this.extraTints = gl.createBuffer();
    this.load(model);
  }

  /** Take the shapes of a model, in place of those of another one. */
  load(model) {
    this.triangles = model.triangles();
    this.edges = model.edges();
    this.indices(this.faces, this.triangles);
    this.indices(this.lines, this.edges);
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

  indices(buffer, values) {
    const gl = this.gl;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, values, gl.STATIC_DRAW);
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

export class FlatPainter {
  constructor(canvas, model) {
    this.context = canvas.getContext("2d");
    this.kind = "Canvas 2D";
    this.load(model);
  }

  /** Take the shapes of a model, in place of those of another one. */
  load(model) {
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
export class Lines {
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

  /** A triangle whose tip is at x, y, pointing along ux, uy. */
  head(x, y, ux, uy, size, color) {
    const bx = x - 1.7 * size * ux, by = y - 1.7 * size * uy;
    this.places.set([x, y, bx - 0.8 * size * uy, by + 0.8 * size * ux, bx + 0.8 * size * uy,
      by - 0.8 * size * ux], 2 * this.count);
    for (let k = 0; k < 3; k++) this.tints.set([...color, 255], 4 * (this.count + k));
    this.count += 3;
  }
}
