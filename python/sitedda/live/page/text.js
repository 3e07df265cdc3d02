// The input as text, which the forms show as well.

import {element} from "/view/words.js";

const PAUSE = 350;  // ms after the last key until the text is sent

export class TextPanel {
  constructor(root, ask) {
    const label = element("label", root, "text of the input");
    this.field = element("textarea", root);
    this.field.id = "text";
    label.htmlFor = "text";
    this.field.spellcheck = false;
    this.field.wrap = "off";
    this.sent = [];  // texts that the server has not confirmed yet
    this.field.addEventListener("input", () => {
      clearTimeout(this.later);
      this.later = setTimeout(() => this.take(ask), PAUSE);
    });
    this.field.addEventListener("blur", () => {
      if (this.later) this.take(ask);
      this.sent = [];
      ask("settle");
    });
  }

  take(ask) {
    clearTimeout(this.later);
    this.later = 0;
    this.sent.push(this.field.value);
    ask("write", {text: this.field.value});
  }

  /** Show a text of the server, unless the user has typed a newer one. */
  show(text) {
    this.sent.splice(0, this.sent.lastIndexOf(text) + 1);
    if (this.later || this.sent.length || text === this.field.value) return;
    const at = this.field.selectionStart;
    this.field.value = text;
    this.field.setSelectionRange(at, at);
  }

  /** Select a line and scroll to it. */
  reveal(line) {
    const lines = this.field.value.split("\n");
    const start = lines.slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
    this.field.setSelectionRange(start, start + (lines[line - 1] || "").length);
    this.field.scrollTop = this.field.scrollHeight * (line - 4) / Math.max(lines.length, 1);
  }
}
