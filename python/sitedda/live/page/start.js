// The start page: shipped examples with pictures, an empty model, the inputs of the folder.

import {element, variable} from "/view/words.js";
import {button, spoken} from "./parts.js";

const STONES = ["#c9b58f", "#8fa3ad", "#b98f73", "#9fae84", "#a99bb8", "#c2c2b8"];
const WIDTH = 280, HEIGHT = 150;

export class StartPage {
  constructor(root, ask) {
    this.root = root;
    this.ask = ask;
    this.cards = new Map();
  }

  show({folder, examples, files}) {
    this.root.replaceChildren();
    this.cards.clear();
    element("h2", this.root, "Begin");
    const first = element("div", this.root, "", "begin");
    button(first, "An empty model", () => this.ask("open", {source: "empty", name: ""}))
      .classList.add("main");
    element("p", this.root, `Files are saved in the working folder ${folder}.`, "note");
    if (files.length) {
      element("h3", this.root, "Inputs of the folder");
      const list = element("ul", this.root, "", "files");
      for (const name of files) {
        button(element("li", list), name, () => this.ask("open", {source: "file", name}));
      }
    }
    element("h3", this.root, "Examples");
    const grid = element("ul", this.root, "", "cards");
    for (const [name, words] of Object.entries(examples)) {
      const card = button(element("li", grid), "", () => this.ask("open", {source: "example", name}));
      card.className = "card";
      card.dataset.name = name;
      const canvas = element("canvas", card);
      canvas.setAttribute("aria-hidden", "true");
      element("strong", card, spoken(name));
      element("span", card, words);
      this.cards.set(name, canvas);
    }
  }

  /** Draw the picture of an example; its outlines are in thousandths of its size. */
  draw({name, box, blocks}) {
    const canvas = this.cards.get(name);
    if (!canvas) return;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = WIDTH * ratio;
    canvas.height = HEIGHT * ratio;
    const c = canvas.getContext("2d");
    const scale = 0.92 * ratio * Math.min(WIDTH / box[0], HEIGHT / box[1]);
    const x0 = (WIDTH * ratio - scale * box[0]) / 2, y0 = (HEIGHT * ratio + scale * box[1]) / 2;
    c.lineWidth = 0.7 * ratio;
    c.strokeStyle = variable("--ink");
    for (const [material, ...places] of blocks) {
      c.beginPath();
      for (let i = 0; i < places.length; i += 2) {
        c.lineTo(x0 + scale * places[i], y0 - scale * places[i + 1]);
      }
      c.closePath();
      c.fillStyle = STONES[material % STONES.length];
      c.fill();
      if (blocks.length < 1500) c.stroke();
    }
  }
}
