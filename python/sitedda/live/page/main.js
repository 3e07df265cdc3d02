// The page: it passes messages of the server to its parts, and actions of the user to the server.

import {element} from "/view/words.js";
import {Forms} from "./forms.js";
import {LiveView} from "./live_view.js";
import {button, say} from "./parts.js";
import {ChangePanel, RunBar, showCheck, showVerdict} from "./run.js";
import {SavePanel} from "./save.js";
import {Link} from "./socket.js";
import {StartPage} from "./start.js";
import {TextPanel} from "./text.js";

const node = (id) => document.getElementById(id);

class Page {
  constructor() {
    this.link = new Link((head, streams) => this.hear(head, streams), (state) => this.state(state));
    const ask = (command, fields) => this.link.ask(command, fields);
    this.ask = ask;
    this.start = new StartPage(node("start"), ask);
    this.view = new LiveView(node("blocks"));
    this.bar = new RunBar(node("run"), ask);
    this.buildTools();
    this.buildTabs();
    this.forms = new Forms(this.tabs.form.panel, ask);
    this.text = new TextPanel(this.tabs.text.panel, ask);
    this.changes = new ChangePanel(this.tabs.change.panel, ask,
      () => (this.view.picked >= 0 ? this.view.model.names[this.view.picked] : ""));
    this.saves = new SavePanel(this.tabs.save.panel, ask);
    node("token-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.link.enter(node("token").value.trim());
    });
    this.run = this.model = this.check = null;
    this.drawing = Promise.resolve();
    window.page = this;
    window.blockViews = [this.view];
    this.link.connect();
  }

  buildTools() {
    const root = node("tools");
    this.leave = button(root, "Start page", () => this.ask("leave"), "close this model");
    this.undo = button(root, "Undo", () => this.ask("undo"));
    this.redo = button(root, "Redo", () => this.ask("redo"));
    document.addEventListener("keydown", (event) => {
      const typing = /^(INPUT|TEXTAREA)$/.test(document.activeElement?.tagName || "");
      if (typing || !(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
      event.preventDefault();
      this.ask(event.shiftKey ? "redo" : "undo");
    });
  }

  buildTabs() {
    const root = node("panel"), list = element("div", root, "", "tabs");
    list.setAttribute("role", "tablist");
    list.setAttribute("aria-label", "Input");
    this.tabs = {};
    for (const [name, words] of [["form", "Form"], ["text", "Text"], ["change", "Change"],
      ["save", "Save"]]) {
      const tab = button(list, words, () => this.choose(name));
      const panel = element("div", root, "", `tab-panel ${name}-panel`);
      tab.id = `tab-${name}`;
      panel.id = `panel-${name}`;
      tab.setAttribute("role", "tab");
      tab.setAttribute("aria-controls", panel.id);
      panel.setAttribute("role", "tabpanel");
      panel.setAttribute("aria-labelledby", tab.id);
      panel.tabIndex = 0;
      this.tabs[name] = {tab, panel};
    }
    list.addEventListener("keydown", (event) => {
      const shown = Object.keys(this.tabs).filter((name) => !this.tabs[name].tab.hidden);
      const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
      if (!step) return;
      const next = shown[(shown.indexOf(this.tab) + step + shown.length) % shown.length];
      this.choose(next);
      this.tabs[next].tab.focus();
    });
    this.choose("form");
  }

  choose(name) {
    this.tab = name;
    for (const [one, {tab, panel}] of Object.entries(this.tabs)) {
      tab.setAttribute("aria-selected", String(one === name));
      tab.tabIndex = one === name ? 0 : -1;
      panel.hidden = one !== name;
    }
  }

  screen(name) {
    if (node(name).hidden) window.scrollTo(0, 0);
    for (const one of ["enter", "start", "work"]) node(one).hidden = one !== name;
    node("tools").hidden = name !== "work";
    if (name !== "work") node("file").textContent = "";
  }

  state(state) {
    if (state === "refused") {
      this.screen("enter");
      say("");
    } else {
      say("The server does not respond. If it has ended, start it again; it continues with this model.", true);
      this.lost = true;
    }
  }

  hear(head, streams) {
    const acts = {schema: this.hearSchema, start: this.hearStart, card: this.hearCard,
      model: this.hearModel, drawn: this.hearDrawn, good: this.hearGood,
      trouble: this.hearTrouble, check: this.hearCheck, run: this.hearRun, frame: this.hearFrame,
      saving: this.hearSaving, saved: this.hearSaved, refused: this.hearRefused};
    acts[head.kind]?.call(this, head, streams);
  }

  hearSchema({groups, changeable}) {
    if (this.lost) say("");
    this.lost = false;
    this.forms.schema = groups;
    this.changeable = changeable;
  }

  hearStart(head) {
    this.forms.records = head.records;
    this.saves.build(head.endings);
    this.screen(head.screen === "start" ? "start" : "work");
    if (head.screen === "start") this.start.show(head);
    else this.view.resize();
  }

  hearCard(head) {
    this.start.draw(head);
  }

  hearModel(head) {
    if (!head.running) {
      this.run = null;
      this.bar.show(null);
      this.verdict();
    }
    const other = this.model?.file !== head.file || this.model.opened !== head.opened;
    this.model = head;
    node("file").textContent = head.file;
    document.title = `${head.file} – sitedda live`;
    this.undo.disabled = !head.undo || head.running;
    this.redo.disabled = !head.redo || head.running;
    if (head.groups) {
      this.groups = head.groups;
      this.forms.show(head.groups);
    }
    this.text.show(head.text);
    this.tabs.form.tab.hidden = this.tabs.text.tab.hidden = head.running;
    this.tabs.change.tab.hidden = !head.running;
    if (head.running && ["form", "text"].includes(this.tab)) this.choose("change");
    if (!head.running && this.tab === "change") this.choose("form");
    if (other) {
      this.saves.forget();
      this.view.forget();
    }
    if (!head.running) this.trouble(null);
    this.saves.show(head.file, this.run);
    if (head.running) this.showChanges();
  }

  showChanges() {
    this.changes.show(this.groups || [], this.forms.kinds, this.changeable || {}, this.run);
  }

  hearDrawn(head, streams) {
    const begun = performance.now();
    this.drawing = this.drawing.then(() => this.view.load(head, streams)).then(() => {
      this.view.state.version = head.version;
      this.view.state.loadMs = performance.now() - begun;
      const notes = head.notes.slice(0, 6).join("; ");
      this.view.note.textContent = [this.view.note.textContent, notes].filter(Boolean).join(" ");
      node("blocks").classList.remove("stale");
    });
  }

  hearGood({version, seconds}) {
    this.trouble(null);
    this.view.state.good = version;
    this.view.state.seconds = seconds;
  }

  hearTrouble(head) {
    this.trouble(head);
    node("blocks").classList.add("stale");
  }

  trouble(head) {
    const atField = this.forms.wrong(head), root = node("trouble");
    root.replaceChildren();
    if (!head) return;
    if (head.line) this.text.reveal(head.line);
    element("p", root, head.message, "wrong");
    if (!atField || this.tab !== "form") return;
    element("p", root, "The picture shows the last valid model.", "note");
  }

  hearCheck(head) {
    this.check = head;
    this.verdict();
  }

  hearRun(head) {
    const before = this.run?.status;
    this.run = head;
    this.bar.show(head);
    this.showChanges();
    if (this.model) this.saves.show(this.model.file, head);
    const over = ["done", "stopped", "failed"].includes(head.status);
    if (!over || before === head.status) return;
    this.verdict();
    if (head.verdict?.failure) this.trouble({message: head.verdict.failure});
    this.drawing = this.drawing.then(() => this.conclude(head.verdict));
  }

  async conclude(found) {
    if (found?.charts?.length) {
      const bytes = Object.fromEntries(Object.entries(found.streams).map(([name, text]) =>
        [name, Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))]));
      await this.view.conclude(found, {deflated: (name) => bytes[name]});
    }
    if (found?.blocks?.length) this.view.pointAt(found.blocks);
  }

  verdict() {
    if (this.run) showVerdict(node("verdict"), this.run);
    else showCheck(node("verdict"), this.check?.version === this.model?.version ? this.check : null);
  }

  hearFrame(head, streams) {
    this.drawing = this.drawing.then(() => this.view.add(head, streams)).then(() => {
      // The last frame may arrive after the message of a failure.
      if (this.view.failing) this.view.pointAt(this.view.failing);
    });
  }

  hearSaving({what}) {
    this.saves.say(what, "The file is being written …");
  }

  hearSaved({what, files, folder}) {
    this.saves.say(what, `saved: ${files.join(", ")} in ${folder}`);
    say(`saved: ${files[0]}`);
  }

  hearRefused({message, what}) {
    if (what) this.saves.say(what, message, true);
    else this.changes.refused();
    say(message, true);
  }
}

new Page();
