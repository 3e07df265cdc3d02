// The input as text: the same model as the forms.

import {element} from "/view/words.js";

const PAUSE = 350;  // ms without a key before the text is taken

export class TextPanel {
  constructor(root, ask) {
    const label = element("label", root, "the input, as it is saved");
    this.field = element("textarea", root);
    this.field.id = "text";
    label.htmlFor = "text";
    this.field.spellcheck = false;
    this.field.wrap = "off";
    this.sent = null;
    this.field.addEventListener("input", () => {
      clearTimeout(this.later);
      this.later = setTimeout(() => this.take(ask), PAUSE);
    });
    this.field.addEventListener("blur", () => {
      if (this.later) this.take(ask);
      ask("settle");
    });
  }

  take(ask) {
    clearTimeout(this.later);
    this.later = 0;
    this.sent = this.field.value;
    ask("write", {text: this.sent});
  }

  /** Show a text, unless it is what is being typed. */
  show(text) {
    if (this.later || text === this.field.value) return;
    if (document.activeElement === this.field && this.sent !== null && text !== this.sent
      && this.field.value === this.sent) {
      this.sent = null;
    }
    const at = this.field.selectionStart;
    this.field.value = text;
    this.field.setSelectionRange(at, at);
  }

  /** Go to a line. */
  reveal(line) {
    const lines = this.field.value.split("\n");
    const start = lines.slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
    this.field.setSelectionRange(start, start + (lines[line - 1] || "").length);
    this.field.scrollTop = this.field.scrollHeight * (line - 4) / Math.max(lines.length, 1);
  }
}
