// Panel that saves files in the working folder.

import {element} from "/view/words.js";
import {button, row, settle} from "./parts.js";

const WORDS = {
  namelist: "the input, with the stages that were added during the run",
  script: "Python script that repeats the run bit for bit, and its input",
  report: "model, check, verdict and view in one page",
  movie: "the blocks of the run",
  output: "all results, as netCDF",
};

export class SavePanel {
  constructor(root, ask) {
    this.root = root;
    this.ask = ask;
    this.fields = {};
  }

  build(endings) {
    this.root.replaceChildren();
    for (const [what, ending] of Object.entries(endings)) {
      const line = row(this.root, what, ending, WORDS[what] || "");
      const field = settle(line, element("input", null));
      field.spellcheck = false;
      const act = button(line.box, "Save", () => {
        this.ask("save", {what, name: field.value.trim()});
      }, `save the ${what}`);
      act.dataset.what = what;
      act.setAttribute("aria-label", `save the ${what}`);
      const words = element("small", line.box, "", "saved");
      words.setAttribute("role", "status");
      this.fields[what] = {field, act, words};
    }
  }

  show(file, run) {
    const stem = file.replace(/\.nml$/, "").replace(/_live$/, "");
    const over = ["done", "stopped", "failed"].includes(run?.status);
    for (const [what, {field, act}] of Object.entries(this.fields)) {
      if (!field.value) field.value = `${stem}_live`;
      act.disabled = !over && ["report", "movie", "output"].includes(what);
    }
  }

  /** Clear the file names before another model is shown. */
  forget() {
    for (const {field, words} of Object.values(this.fields)) {
      field.value = words.textContent = "";
    }
  }

  say(what, words, bad = false) {
    const found = this.fields[what];
    if (!found) return;
    found.words.textContent = words;
    found.words.classList.toggle("wrong", bad);
  }
}
