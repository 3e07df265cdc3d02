// Parts of the page: buttons, fields with label, unit and help, tables.

import {element} from "/view/words.js";

let count = 0;

/** Return a unique name for an element. */
export const fresh = (stem) => `${stem}-${++count}`;

/** Return the name of a group or variable in words. */
export const spoken = (name) => name.replaceAll("_", " ");

/** Return a value or default of the schema in words, and .true. without its points. */
export const plain = (text) => spoken(text).replace(/^\.(\w+)\.$/, "$1");

export function button(parent, text, act, title = "") {
  const node = element("button", parent, text);
  node.type = "button";
  if (title) node.title = title;
  node.addEventListener("click", act);
  return node;
}

/** Create a select from options [value, words]. */
export function choice(parent, options, value) {
  const node = element("select", parent);
  for (const [key, words] of options) element("option", node, words).value = key;
  node.value = value;
  return node;
}

/** Create a row for a field: label, unit, help (shown if the field has the focus), message. */
export function row(parent, label, unit, help) {
  const box = element("div", parent, "", "row"), id = fresh("field");
  const name = element("label", box, label);
  name.htmlFor = id;
  const place = element("span", box, "", "place");
  if (unit) element("span", box, unit, "unit");
  const words = element("small", box, help, "help");
  words.id = `${id}-help`;
  const trouble = element("small", box, "", "wrong");
  trouble.id = `${id}-wrong`;
  return {box, place, id, trouble};
}

/** Insert a field into a row. */
export function settle(line, field) {
  field.id = line.id;
  field.setAttribute("aria-describedby", `${line.id}-help ${line.id}-wrong`);
  line.place.append(field);
  line.field = field;
  return field;
}

export function say(words, bad = false) {
  const node = document.getElementById("said");
  node.textContent = words;
  node.classList.toggle("bad", bad);
}

/** Create a table from rows of texts. */
export function table(parent, heads, rows, title) {
  const box = element("div", parent, "", "wide");
  box.tabIndex = 0;
  box.setAttribute("role", "region");
  box.setAttribute("aria-label", title);
  const node = element("table", box), head = element("tr", element("thead", node));
  for (const text of heads) element("th", head, text).scope = "col";
  const body = element("tbody", node);
  for (const cells of rows) {
    const line = element("tr", body);
    for (const text of cells) {
      const kind = {ok: "good", warn: "middle", fail: "bad"}[text] || "";
      element("td", line, String(text), kind);
    }
  }
  return node;
}
