// The bar under a view and the choices beside it.

import {saveData, savePicture} from "./save.js";
import {element} from "./words.js";

const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];
const FACTORS = [1, 2, 5, 10, 20, 50, 100, 1000];
export const KEYS = "space plays; arrows step, with shift they pan; + and − zoom, f shows all; "
  + "c and x change colours and contacts; [ and ] pick blocks, j and J joints; , and . zoom the time";

function button(parent, text, label, act) {
  const node = element("button", parent, text);
  node.type = "button";
  node.title = label;
  if (text.length < 2) node.setAttribute("aria-label", label);
  node.addEventListener("click", act);
  return node;
}

/** Play, step, scrub. */
export function buildBar(view, bar) {
  button(bar, "‹", "one frame back", () => view.show(view.frame - 1));
  view.playButton = button(bar, "▶", "play", () => view.play(!view.playing));
  view.playButton.classList.add("play");
  button(bar, "›", "one frame on", () => view.show(view.frame + 1));
  view.slider = element("input", bar, "", "time");
  view.slider.type = "range";
  view.slider.min = 0;
  view.slider.setAttribute("aria-label", "frame");
  view.slider.addEventListener("input", () => view.show(+view.slider.value));
  view.clock = element("output", bar, "", "clock");
  button(bar, "picture", "save the picture as PNG", () => savePicture(view)).classList.add("save");
  button(bar, "data", "save the histories as CSV", () => saveData(view));
  button(bar, "fit", "show the whole model: fit", () => view.fit()).classList.add("fit");
}

/** What is coloured, drawn and how. */
export class Choices {
  constructor(view, root) {
    this.view = view;
    this.root = root;
    this.color = this.select("color", (v) => view.setColor(v));
    this.contacts = this.select("contacts", (v) => view.setContacts(v),
      [["none", "none"], ["force", "forces"], ["chain", "chains"], ["slip", "slip"],
        ["opening", "opening"]]);
    this.scale = this.select("scale", (v) => {
      view.ownScale = v === "own";
      view.refresh();
    }, [["all", "all frames"], ["own", "this frame"]]);
    this.factor = this.select("deformation", (v) => {
      view.factor = +v;
      view.refresh();
    }, FACTORS.map((f) => [f, `× ${f}`]));
    this.speed = this.select("speed", (v) => { view.speed = +v; }, SPEEDS.map((s) => [s, `× ${s}`]));
    this.stage = this.select("stage", (v) => view.show(+v));
  }

  select(label, act, options = []) {
    const field = element("label", this.root, "", "field");
    element("span", field, label);
    const node = element("select", field);
    this.fill(node, options);
    node.addEventListener("change", () => act(node.value));
    return node;
  }

  fill(node, options) {
    node.replaceChildren();
    for (const [key, text] of options) element("option", node, text).value = key;
  }

  /** The next choice of a list that is offered. */
  next(name, step) {
    const node = this[name], there = [...node.options].filter((option) => !option.disabled);
    const at = there.findIndex((option) => option.value === node.value);
    node.value = there[(at + step + there.length) % there.length].value;
    node.dispatchEvent(new Event("change"));
  }

  /** Choices that depend on what is shown. */
  offer() {
    const {view} = this, {meta, model} = view, frames = model.frames;
    view.slider.max = frames - 1;
    view.slider.value = view.frame;
    const last = meta.time[frames - 1] - meta.time[0];
    view.speed = SPEEDS.reduce((a, b) => Math.abs(Math.log(last / b / 10))
      < Math.abs(Math.log(last / a / 10)) ? b : a);
    if (last > 4 && last < 40) view.speed = 1;
    this.speed.value = view.speed;
    const shown = meta.quantities.filter((one) => one.name !== "tension" || !meta.coarse);
    this.fill(this.color, [["material", "material"],
      ...shown.map((one) => [one.name, one.label.split(",")[0]])]);
    this.color.value = view.color;
    const force = meta.pairs > 0, faces = meta.faces > 0;
    const there = {none: true, force, chain: force, slip: faces, opening: faces};
    for (const option of this.contacts.options) this.allow(option, there[option.value]);
    this.fill(this.stage, (meta.stage_frames || []).map(([name, frame]) => [frame, name]));
    this.stage.parentElement.hidden = this.stage.options.length < 2;
    view.root.classList.toggle("still", frames === 1);
  }

  allow(option, may) {
    option.hidden = option.disabled = !may;
  }
}
