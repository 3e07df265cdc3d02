// Controls of the run (check, rest, run, pause, step, stop), changes during it, and its verdict.

import {element, short} from "/view/words.js";
import {fits} from "./forms.js";
import {button, choice, plain, row, settle, spoken, table} from "./parts.js";

const OVER = ["done", "stopped", "failed"];
const WORDS = {opening: "opening", ready: "ready", resting: "computing equilibrium",
  running: "running", paused: "paused", done: "complete", stopped: "stopped", failed: "failed"};

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
    add("check", "Check", "check the model before its run", () => ask("check"));
    add("rest", "Rest", "compute the static equilibrium before the first dynamic step", () => ask("rest"));
    add("run", "Run", "run the model to its end", () => ask("run"));
    add("pause", "Pause", "pause after the present step", () => ask("pause"));
    add("step", "Step", "compute one step", () => ask("step", {steps: 1}));
    add("stop", "Stop", "end the run at the present time", () => ask("stop"));
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

/** Form for changes and stages during a run. */
export class ChangePanel {
  /** `ask` sends a command to the server; `picked` returns the name of the selected block. */
  constructor(root, ask, picked) {
    Object.assign(this, {root, ask, picked, shape: "", done: 0, fields: new Map()});
  }

  /** Show the fields with the values that the run uses. */
  show(groups, kinds, changeable, run) {
    const shape = JSON.stringify(groups.map(({name, number, values}) => [name, number, values]));
    if (shape !== this.shape) {
      this.shape = shape;
      this.build(groups, kinds, changeable);
    }
    const actions = run?.actions || [], over = OVER.includes(run?.status);
    this.done = actions.length;
    this.note.textContent = over ? "The run has ended. Edit the model to run it with other values."
      : "Changes act from the present time. “Save script” writes a script that repeats them.";
    this.form.disabled = over;
    const runs = Object.assign({}, ...actions.map((one) => one.changes || {}));
    for (const [path, one] of this.fields) {
      one.runs = runs[path] ?? one.drawn;
      if (one.sent === one.runs || over) this.settled(one);
      else if (one.sent === null && one.field !== document.activeElement) one.field.value = one.runs;
    }
  }

  settled(one) {
    one.sent = null;
    one.field.value = one.runs;
    one.line.trouble.textContent = "";
  }

  /** Reset the fields whose changes the server has rejected. */
  refused() {
    for (const one of this.fields.values()) if (one.sent !== null) this.settled(one);
  }

  send(path, one) {
    const text = one.field.value.trim();
    if (!text || text === one.runs) {
      this.settled(one);
      return;
    }
    one.sent = text;
    one.line.trouble.textContent = `not yet changed from ${one.runs || "the default"}`;
    this.ask("change", {values: {[path]: text}});
  }

  build(groups, kinds, changeable) {
    this.root.replaceChildren();
    this.fields.clear();
    this.note = element("p", this.root, "", "note");
    this.form = element("fieldset", this.root, "", "changes");
    element("legend", this.form, "Change the running model");
    this.stage(groups);
    for (const {name, number, values} of groups) {
      const names = changeable[name];
      if (!names || !kinds.has(name)) continue;
      const box = element("details", this.form, "", "group");
      box.open = name === "joint";
      const head = element("summary", box);
      element("strong", head, spoken(name));
      element("span", head, values.name || (name === "control" ? "" : String(number)));
      const path = name === "control" ? "control" : `${name}[${number}]`;
      const own = kinds.get(name).variables.filter((v) => names.includes(v.name) && fits(v, values));
      for (const one of own) {
        const value = values[one.name];
        if (value === null || (value === undefined && name !== "joint")) continue;
        const line = row(box, spoken(one.name), one.unit, one.meaning);
        const field = settle(line, element("input", null)), key = `${path}.${one.name}`;
        field.placeholder = plain(one.default);
        field.dataset.change = key;
        const entry = {field, line, drawn: value ?? "", runs: value ?? "", sent: null};
        this.fields.set(key, entry);
        field.addEventListener("change", () => this.send(key, entry));
      }
    }
  }

  stage(groups) {
    const box = element("fieldset", this.form, "", "stage-form");
    element("legend", box, "Begin a stage");
    const fields = {};
    const add = (name, unit, help) => {
      const line = row(box, spoken(name), unit, help);
      fields[name] = settle(line, element("input", null));
    };
    add("remove", "", "names of blocks to remove (excavation), such as one, two, all_*");
    button(box, "remove the selected block", () => { fields.remove.value = this.picked(); })
      .className = "quiet";
    add("release", "", "names of fixed points and boundaries that end");
    add("drop", "", "names of bolts, tractions and water that end");
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
    element("span", rest, "static stage: compute the equilibrium");
    button(box, "Begin", () => {
      const values = {name: `live ${this.done + 1}`};
      for (const [name, field] of Object.entries(fields)) {
        if (field.value.trim()) values[name] = field.value.trim();
      }
      if (ticked.checked) values.kind = "static";
      this.ask("stage", {values});
    }).classList.add("main");
  }

  /** Add fields that replace a joint or material by another one: 'old -> new'. */
  replacement(box, kind, names, fields) {
    const all = [["", "none"], ...names.map((one) => [one, one])];
    const ends = [`replace ${kind}`, `by ${kind}`].map((label) =>
      settle(row(box, label, "", "from this stage"), choice(null, all, "")));
    fields[`change_${kind}s`] = {
      get value() {
        const [old, other] = ends.map((field) => field.value);
        return old && other && old !== other ? `${old} -> ${other}` : "";
      },
    };
  }
}

/** Show the findings of a check. */
export function showCheck(root, found) {
  root.replaceChildren();
  if (!found) return;
  element("h2", root, "Check");
  if (found.state === "running") {
    element("p", root, "The model is being checked …", "note");
  } else if (found.error) {
    element("p", root, found.error, "wrong");
  } else {
    element("p", root, found.words, `judged ${found.verdict}`);
    table(root, ["verdict", "what", "found", "to do"], found.lines, "findings of the check");
  }
}

/** Show the verdict of a run, and its warnings. */
export function showVerdict(root, run) {
  root.replaceChildren();
  const found = run?.verdict;
  if (!found) return;
  element("h2", root, run.status === "failed" ? "A step failed" : "Verdict");
  for (const doubt of found.doubts || []) element("p", root, doubt, "wrong");
  if (run.ending) element("p", root, `Ended: ${run.ending}.`, "note");
  if (found.lines.length) table(root, ["what", "found"], found.lines, "verdict");
}
