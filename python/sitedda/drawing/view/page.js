// The views of a page, whose data all stand in it: nothing is loaded.

import {PageStreams} from "./streams.js";
import {View} from "./view.js";
import {element} from "./words.js";

window.blockViews = [];
const begun = [];
for (const root of document.querySelectorAll(".block-view")) {
  const meta = JSON.parse(document.getElementById(`${root.id}-meta`).textContent);
  const view = new View(root);
  window.blockViews.push(view);
  begun.push(view.begin(meta, new PageStreams(root.id)).catch((trouble) => {
    element("p", root, `The view cannot be shown: ${trouble.message}`, "trouble");
    view.state.trouble = String(trouble);
  }));
  keepState(view, root.id === "view1");
}
if (window.blockViews.length === 2) Promise.all(begun).then(() => pair(...window.blockViews));

/** Two views side by side, which show the same time. */
function pair(first, second) {
  const box = element("div", null, "", "pair");
  first.root.before(box);
  box.append(first.root, second.root);
  for (const [view, other] of [[first, second], [second, first]]) {
    view.root.prepend(element("h3", null, view.meta.name, "pair-name"));
    view.follower = (time) => {
      const frame = other.frameAt(time);
      if (frame !== other.frame) other.show(frame);
    };
  }
  if (first.meta.pair === "difference") {
    first.other = second;
    first.difference = true;
    first.refresh();
  }
}

/** The frame, colour, contacts and block of a view stand in its address, and are taken from it. */
function keepState(view, main) {
  if (!main) return;
  const words = new URLSearchParams(location.hash.slice(1));
  if (words.has("color")) view.color = words.get("color");
  view.onDecoded = () => {
    if (words.has("contacts")) view.setContacts(words.get("contacts"));
    if (words.has("t")) view.showTime(+words.get("t"));
    const block = view.model.names.indexOf(words.get("block"));
    if (block >= 0) view.pick(block);
    if (location.protocol === "about:") return;  // in a frame of a notebook
    view.root.addEventListener("state", () => {
      const now = new URLSearchParams({t: view.meta.time[view.frame], color: view.color,
        contacts: view.contacts});
      if (view.picked >= 0) now.set("block", view.model.names[view.picked]);
      clearTimeout(view.stateTimer);
      view.stateTimer = setTimeout(() => history.replaceState(null, "", `#${now}`), 300);
    });
  };
}
