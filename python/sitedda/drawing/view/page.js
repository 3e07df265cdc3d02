// The views of a page, whose data all stand in it: nothing is loaded.

import {PageStreams} from "./streams.js";
import {View} from "./view.js";
import {element} from "./words.js";

window.blockViews = [];
for (const root of document.querySelectorAll(".block-view")) {
  const meta = JSON.parse(document.getElementById(`${root.id}-meta`).textContent);
  const view = new View(root);
  window.blockViews.push(view);
  view.begin(meta, new PageStreams(root.id)).catch((trouble) => {
    element("p", root, `The view cannot be shown: ${trouble.message}`, "trouble");
    view.state.trouble = String(trouble);
  });
}
