// The run beside the model: check, rest, run, pause, step, stop; what can be changed; the verdict.

import {element, short} from "/view/words.js";
import {fits} from "./forms.js";
import {button, choice, row, settle, table} from "./parts.js";

const OVER = ["done", "stopped", "failed"];
const WORDS = {opening: "is opened", ready: "as drawn", resting: "comes to rest", running: "runs",
  paused: "paused", done: "complete", stopped: "stopped", failed: "failed"};

export class RunBar {
  constructor(root, ask) {
    this.root = root;
    this.ask = ask;
    this.bar = element("div", root, "", "run-bar");
    this.bar.setAttribute("role", "toolbar");
    this.bar.setAttribute("aria-label", "Run");
    const add = (name, text, title, act) => {
      this[name] = button(this.bar, text, act, title);
    };
    add("check", "Check", "what a run will meet", () => ask("check"));
    add("rest", "Rest", "bring the model to rest, as its first stages say", () => ask("rest"));
    add("run", "Run", "run it to its end", () => ask("run"));
    add("pause", "Pause", "wait between two steps", () => ask("pause"));
    add("step", "Step", "take one step", () => ask("step", {steps: 1}));
    add("stop", "Stop", "end the run here", () => ask("stop"));
    add("back", "Edit the model", "leave the run", () => ask("back"));
    this.run.classList.add("main");
    this.progress = element("progress", root);
    this.progress.setAttribute("aria-label", "time of the run");
    this.words = element("p", root, "", "run-words");
    this.show(null);
  }

  show(run) {
    this.state = run?.status || "none";
    this.root.dataset.status = this.state;
    const over = OVER.includes(this.state), none = !run;
    this.check.hidden = !none;
    this.rest.disabled = !(none || this.state === "ready");
    this.run.disabled = !(none || ["ready", "paused"].includes(this.state));
    this.pause.disabled = this.state !== "running";
    this.step.disabled = !(none || ["ready", "paused"].includes(this.state));
    this.stop.disabled = none || over || ["ready", "opening"].includes(this.state);
    this.back.hidden = none;
    this.progress.hidden = none;
    if (none) {
      this.words.textContent = "";
      return;
    }
    this.progress.max = run.duration || 1;
    this.progress.value = run.time || 0;
    const parts = [WORDS[this.state] || this.state];
    if (run.step !== undefined) {
      parts.push(`${short(run.time)} of ${short(run.duration)} s`,
        `step ${run.step.toLocaleString("en")}`,
        `${run.iterations} iteration${run.iterations === 1 ? "" : "s"}`);
    }
    if (run.left && this.state === "running") parts.push(`${duration(run.left)} left`);
    this.words.textContent = parts.join(" · ");
  }
}

function duration(seconds) {
  if (seconds < 90) return `${Math.ceil(seconds)} s`;
  return seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

/** What a running model lets change, and stages that are begun by hand. */
export class ChangePanel {
  constructor(root, ask) {
    this.root = root;
    this.ask = ask;
    this.shape = "";
    this.done = 0;  // changes and stages so far
  }

  show(groups, kinds, changeable, picked) {
    const shape = JSON.stringify([groups.map((group) => [group.name, group.number]), picked]);
    if (shape === this.shape) return;
    this.shape = shape;
    this.root.replaceChildren();
    element("p", this.root, "From now on. The same changes at the same steps give the same bits; "
      + "the script has them.", "note");
    this.stage(groups, picked);
    for (const {name, number, values} of groups) {
      const names = changeable[name];
      if (!names || !kinds.has(name)) continue;
      const box = element("details", this.root, "", "group");
      box.open = name === "joint";
      const head = element("summary", box);
      element("strong", head, name.replaceAll("_", " "));
      element("span", head, values.name || (name === "control" ? "" : String(number)));
      const path = name === "control" ? "control" : `${name}[${number}]`;
      const own = kinds.get(name).variables.filter((v) => names.includes(v.name) && fits(v, values));
      for (const one of own) {
        const value = values[one.name];
        if (value === null || (value === undefined && name !== "joint")) continue;
        const line = row(box, one.name.replaceAll("_", " "), one.unit, one.meaning);
        const field = settle(line, element("input", null));
        field.value = value ?? "";
        field.placeholder = one.default;
        field.addEventListener("change", () => {
          if (field.value.trim()) {
            this.ask("change", {values: {[`${path}.${one.name}`]: field.value.trim()}});
          }
        });
      }
    }
  }

  stage(groups, picked) {
    const box = element("fieldset", this.root, "", "stage-form");
    element("legend", box, "Begin a stage");
    const fields = {};
    const add = (name, unit, help, value = "") => {
      const line = row(box, name.replaceAll("_", " "), unit, help);
      fields[name] = settle(line, element("input", null));
      fields[name].value = value;
    };
    add("remove", "", "blocks that are taken out: excavation; names: one, two, all_*", picked || "");
    add("release", "", "fixed points and edges that let go; names");
    add("drop", "", "bolts, tractions and water that end; names");
    const supports = groups.filter((group) => ["fixed_point", "boundary", "bolt"].includes(group.name)
      && group.values.name);
    for (const {name, values} of supports) {
      const target = name === "bolt" ? "drop" : "release";
      button(box, `${target} ${values.name}`, () => { fields[target].value = values.name; })
        .className = "quiet";
    }
    for (const kind of ["joint", "material"]) {
      const names = groups.filter(({name, values}) => name === kind && values.name)
        .map(({values}) => values.name);
      if (names.length > 1) this.replacement(box, kind, names, fields);
    }
    const rest = element("label", box, "", "tick");
    const ticked = element("input", rest);
    ticked.type = "checkbox";
    element("span", rest, "come to rest first");
    button(box, "Begin", () => {
      const values = {name: `live ${this.done + 1}`};
      for (const [name, field] of Object.entries(fields)) {
        if (field.value.trim()) values[name] = field.value.trim();
      }
      if (ticked.checked) values.kind = "static";
      this.ask("stage", {values});
    }).classList.add("main");
  }

  /** Another joint or material of the input in place of one: 'old -> new'. */
  replacement(box, kind, names, fields) {
    const all = [["", "none"], ...names.map((one) => [one, one])];
    const ends = [kind, `${kind} in its place`].map((label) =>
      settle(row(box, label, "", "of the input; from the stage on"), choice(null, all, "")));
    fields[`change_${kind}s`] = {
      get value() {
        const [old, other] = ends.map((field) => field.value);
        return old && other && old !== other ? `${old} -> ${other}` : "";
      },
    };
  }
}

/** The check of a model. */
export function showCheck(root, found) {
  root.replaceChildren();
  if (!found) return;
  element("h2", root, "Check");
  if (found.state === "running") {
    element("p", root, "The model is checked …", "note");
  } else if (found.error) {
    element("p", root, found.error, "wrong");
  } else {
    element("p", root, found.words, `judged ${found.verdict}`);
    table(root, ["verdict", "what", "found", "to do"], found.lines, "findings of the check");
  }
}

/** What happened, and what may be wrong with it. */
export function showVerdict(root, run) {
  root.replaceChildren();
  const found = run?.verdict;
  if (!found) return;
  element("h2", root, run.status === "failed" ? "A step failed" : "Verdict");
  if (found.failure) element("p", root, found.failure, "wrong");
  for (const doubt of found.doubts || []) element("p", root, doubt, "wrong");
  if (run.ending) element("p", root, `Ended: ${run.ending}.`, "note");
  if (found.lines.length) table(root, ["what", "found"], found.lines, "verdict");
}
