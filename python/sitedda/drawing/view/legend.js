// What the colours, widths and signs of a view mean.

import {element, inUnit, mapped, share, short, variable, withUnit} from "./words.js";

export class Legend {
  constructor(view, root) {
    this.view = view;
    this.root = root;
    this.key = "";
  }

  draw() {
    const {view} = this, {meta, model, contacts} = view, {decoded} = model;
    const key = [view.color, contacts, decoded, view.scaleFrame(), Object.values(view.largest), view.usualForce,
      view.other?.state.decoded].join();
    if (this.key === key) return;
    this.key = key;
    this.root.replaceChildren();
    if (view.color === "material" || !decoded) {
      for (const [i, name] of meta.materials.entries()) {
        this.color(meta.stones[i % meta.stones.length], name);
      }
    } else {
      this.quantity(model.kind(view.color), view.range());
    }
    for (const [kind, most] of Object.entries(view.largest)) {
      const {color, words, unit} = meta.line_styles[kind];
      if (most === undefined) continue;
      this.color(color, most > 0 ? `${words}: ${withUnit(most, unit)}` : words.split(",")[0]);
    }
    if (!decoded || contacts === "none") return;
    if (contacts === "chain") {
      this.color(variable("--ink"), `chain of forces, the widest: ${withUnit(view.usualForce, "N/m")}`);
    } else if (contacts !== "force") {
      const kind = meta.movements.find((one) => one.name === contacts);
      const range = view.movementRange(contacts);
      if (range.high <= meta.floors.m) element("p", this.root, `no ${contacts} of joints`, "rests");
      else this.bar(kind.label, range, kind.unit, "joint");
    }
  }

  /** The scale of a quantity, or that it is no more than rounding. */
  quantity(kind, range) {
    const {meta} = this.view, floor = meta.floors[kind.unit];
    const label = this.view.difference ? `difference of ${kind.label}` : kind.label;
    if (Math.max(Math.abs(range.low), Math.abs(range.high)) <= floor) {
      const name = kind.label.split(",")[0];
      this.color(meta.resting, this.view.hasRun
        ? `at rest: ${name} below ${withUnit(floor, kind.unit)}` : `no ${name}: nothing has run yet`);
    } else {
      this.bar(label, range, kind.unit, this.view.map());
    }
  }

  color(color, words) {
    const row = element("div", this.root, "", "key");
    element("i", row).style.background = color;
    element("span", row, words);
  }

  bar(name, {low, high, usual}, unit, map) {
    const [scale, unitName] = inUnit(Math.max(Math.abs(low), Math.abs(high)), unit);
    const box = element("div", this.root, "", "scale");
    element("div", box, `${name} (${unitName})`, "scale-name");
    const bar = element("canvas", box);
    bar.width = 128;
    bar.height = 1;
    const c = bar.getContext("2d"), pixels = c.createImageData(128, 1), out = [0, 0, 0];
    for (let i = 0; i < 128; i++) {
      mapped(this.view.meta.maps[map], i / 127, out);
      pixels.data.set([...out, 255], 4 * i);
    }
    c.putImageData(pixels, 0, 0);
    const ends = element("div", box, "", "scale-ends");
    const most = Math.max(-low, high), inner = high > usual ? usual : 0.5 * (low + high);
    for (const at of most > usual && low < -usual ? [low, -usual, usual, high] : [low, inner, high]) {
      const left = `${100 * share({low, high, usual}, at)}%`;
      Object.assign(element("span", ends, short(at / scale, 3)).style,
        {left, transform: `translateX(-${left})`});
    }
  }
}
