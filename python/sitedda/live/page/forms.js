// Forms of the input, made from the schema: units, ranges, defaults, help; sliders for numbers.

import {element, short, withUnit} from "/view/words.js";
import {button, choice, plain, row, settle, spoken} from "./parts.js";

const NUMBERS = ["real", "integer"];
const WIDEST = 1000;  // width of the largest range that a slider covers completely

/** Return the lowest and highest value of a range such as "0 to 89", "above 0" or "any". */
export function limits(values) {
  const both = values.match(/^(\S+) to (\S+)$/);
  if (both) return [Number(both[1]), Number(both[2])];
  if (values === "above 0" || /^at least/.test(values)) return [0, Infinity];
  return [-Infinity, Infinity];
}

/** Return whether another variable has a value that a variable requires, as in law = 'one'. */
export function fits({when}, values) {
  if (!when) return true;
  const [variable, allowed] = when.split("=");
  const value = values[variable.trim()] ?? "coulomb";
  return words(allowed || "").includes(value);
}

/** Return the lowest and highest value of the slider of a variable. */
function span(variable, value) {
  const [low, high] = limits(variable.values);
  if (variable.unit === "degrees") {
    return [Math.max(low, -180), Math.min(high, 180)];
  }
  if (high - low <= WIDEST) return [low, high];
  const size = Math.abs(value) || 1;
  return [Math.max(low, value < 0 ? -4 * size : size / 5), Math.min(high, 4 * size)];
}

function words(values) {
  return [...values.matchAll(/'([^']*)'/g)].map((found) => found[1]);
}

export class Forms {
  constructor(root, ask) {
    this.root = root;
    this.ask = ask;
    this.fields = new Map();
    this.open = new Set(["control 1"]);
    this.shape = "";
    this.records = [];
  }

  set schema(groups) {
    this.kinds = new Map(groups.map((group) => [group.name, group]));
    this.shape = "";
  }

  /** Show groups; if only values have changed, retain the fields. */
  show(groups) {
    this.groups = groups;
    this.names = new Map();
    for (const {name, values} of groups) {
      if (!values.name) continue;
      if (!this.names.has(name)) this.names.set(name, []);
      this.names.get(name).push(values.name);
    }
    const shape = JSON.stringify(groups.map(({name, number, more, values}) =>
      [name, number, more, Object.keys(values), values.name, values.kind, values.law]));
    if (shape === this.shape) {
      for (const group of groups) this.update(group);
      return;
    }
    this.shape = shape;
    const focused = document.activeElement?.dataset?.key;
    this.build();
    if (focused) this.fields.get(focused)?.field.focus();
  }

  update({name, number, values}) {
    for (const {name: variable} of this.kinds.get(name)?.variables || []) {
      const line = this.fields.get(`${name} ${number} ${variable}`);
      const value = values[variable] ?? "";
      if (!line?.field || values[variable] === null) continue;
      if (line.field !== document.activeElement) line.field.value = value;
      if (value && line.slider && line.slider !== document.activeElement) line.slider.value = value;
    }
  }

  /** Remember which groups are open; events of `toggle` come too late if the form is rebuilt. */
  remember() {
    for (const box of this.root.querySelectorAll("details")) {
      this.open[box.open ? "add" : "delete"](box.dataset.key);
    }
  }

  build() {
    this.remember();
    this.root.replaceChildren();
    this.fields.clear();
    this.adder();
    for (const group of this.groups) {
      if (group.more) {
        element("p", this.root, `${group.more} more groups &${group.name}: see the text`, "note");
      } else {
        this.group(group);
      }
    }
  }

  adder() {
    const box = element("div", this.root, "", "adder");
    const label = element("label", box, "add");
    const there = new Set(this.groups.map((group) => group.name));
    const free = [...this.kinds.values()].filter((kind) => kind.repeats || !there.has(kind.name));
    const list = choice(box, free.map((kind) => [kind.name, `${spoken(kind.name)}: ${kind.meaning}`]),
      free.some((kind) => kind.name === this.added) ? this.added : "joint_set");
    list.id = "add-kind";
    label.htmlFor = list.id;
    list.addEventListener("change", () => { this.added = list.value; });
    button(box, "Add", () => {
      const count = this.groups.filter((group) => group.name === list.value).length;
      this.open.add(`${list.value} ${count + 1}`);
      this.ask("add", {group: list.value});
    });
  }

  group({name, number, values}) {
    const kind = this.kinds.get(name), key = `${name} ${number}`;
    const box = element("details", this.root, "", "group");
    box.dataset.group = key;
    box.dataset.key = key;
    box.open = this.open.has(key);
    const head = element("summary", box);
    element("strong", head, spoken(name));
    element("span", head, this.title(values, kind));
    if (!kind) {
      element("p", box, "There is no such group.", "wrong");
      return;
    }
    element("p", box, kind.meaning, "note");
    const given = kind.variables.filter((one) => one.name in values);
    const others = kind.variables.filter((one) => !(one.name in values) && fits(one, values));
    for (const one of given) this.variable(box, name, number, one, values[one.name]);
    if (name === "motion" && this.records.length) this.record(box, number);
    if (others.length) {
      const more = element("details", box, "", "more");
      more.dataset.key = `${key} more`;
      more.open = this.open.has(more.dataset.key);
      element("summary", more, `${others.length} more variables with default values`);
      const fill = () => {
        if (!more.open || more.childElementCount > 1) return;
        for (const one of others) this.variable(more, name, number, one, undefined);
      };
      more.addEventListener("toggle", fill);
      fill();
    }
    button(box, "Remove", () => this.ask("take_out", {group: name, number}),
      `remove this &${name}`).className = "quiet";
  }

  title(values, kind) {
    if (values.name) return values.name;
    const [name, value] = Object.entries(values).find(([, value]) => value) || ["", ""];
    const one = kind?.variables.find((variable) => variable.name === name);
    const text = this.inWords(value, one);
    return `${spoken(name)} ${text.length > 36 ? "…" : text}`.trim();
  }

  /** Return a value for display: four digits and unit, or a word without the syntax of Fortran. */
  inWords(value, one) {
    if (["word", "logical"].includes(one?.kind)) return plain(value);
    const numbers = value.split(",").map(Number), unit = one?.unit || "";
    if (one?.kind !== "real" || !numbers.every(isFinite)) return `${value} ${unit}`;
    if (numbers.length === 1) return withUnit(numbers[0], unit);
    return `${numbers.map((number) => short(number)).join(", ")} ${unit}`;
  }

  variable(box, group, number, one, value) {
    const key = `${group} ${number} ${one.name}`;
    const range = one.values && one.kind !== "word" && one.values !== "any" ? `; ${one.values}` : "";
    const line = row(box, spoken(one.name), one.unit,
      `${one.meaning}${range} (default: ${plain(one.default)})`);
    this.fields.set(key, line);
    if (value === null) {
      element("span", line.place, "a long list: see the text");
      return;
    }
    const send = (text) => this.ask("set",
      {group, number, variable: one.name, value: text.trim() === "" ? null : text});
    const field = settle(line, this.field(one, value));
    field.dataset.key = key;
    field.addEventListener("change", () => { send(field.value); this.ask("settle"); });
    if (NUMBERS.includes(one.kind) && !one.size && value !== undefined) {
      this.slider(line, one, Number(value), send);
    }
  }

  field(one, value) {
    const refers = one.values.match(/^the name of a &(\w+)/);
    let options = null;
    if (one.kind === "word") options = words(one.values);
    if (one.kind === "logical") options = [".true.", ".false."];
    if (refers) options = this.names.get(refers[1]) || [];
    if (options && one.size === 0) {
      if (value && !options.includes(value)) options = [...options, value];
      const listed = options.map((text) => [text, (refers ? text : plain(text)) || "blank"]);
      return choice(null, [["", `default: ${plain(one.default)}`], ...listed], value ?? "");
    }
    const field = element("input", null);
    field.type = "text";
    field.spellcheck = false;
    field.autocomplete = "off";
    if (NUMBERS.includes(one.kind) && !one.size) field.inputMode = "decimal";
    field.placeholder = one.default === "required" ? "" : plain(one.default);
    field.value = value ?? "";
    return field;
  }

  slider(line, one, value, send) {
    const [low, high] = span(one, value);
    if (!isFinite(value) || !isFinite(low) || !isFinite(high) || !(high > low)) return;
    const slider = element("input", line.box, "", "slider");
    slider.type = "range";
    slider.min = low;
    slider.max = high;
    slider.step = one.kind === "integer" ? 1 : (high - low) / 500;
    slider.value = value;
    slider.setAttribute("aria-label", `${spoken(one.name)}, slider`);
    slider.addEventListener("input", () => {
      const text = String(+Number(slider.value).toPrecision(4));
      line.field.value = text;
      send(text);
    });
    slider.addEventListener("change", () => this.ask("settle"));
    line.slider = slider;
  }

  record(box, number) {
    const line = row(box, "shipped record", "", "record that this motion uses; it is copied into the folder of the model");
    const field = settle(line, choice(null,
      [["", "choose …"], ...this.records.map((name) => [name, name])], ""));
    field.addEventListener("change", () => {
      if (field.value) this.ask("record", {number, name: field.value});
    });
  }

  /** Mark the field to which a message refers; return whether this field exists. */
  wrong(trouble) {
    for (const line of this.fields.values()) {
      line.trouble.textContent = "";
      line.field?.removeAttribute("aria-invalid");
    }
    if (!trouble?.group) return false;
    const box = this.root.querySelector(`[data-group="${trouble.group} ${trouble.number}"]`);
    if (box) box.open = true;
    const line = this.fields.get(`${trouble.group} ${trouble.number} ${trouble.variable}`);
    if (!line) return false;
    line.trouble.textContent = trouble.message.replace(/^.*?\(line \d+\): /, "");
    line.field?.setAttribute("aria-invalid", "true");
    return true;
  }
}
