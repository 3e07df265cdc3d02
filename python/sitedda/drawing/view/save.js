// The picture and the data of a view as files.

import {element, variable} from "./words.js";

const LINE = 20;  // pixels of a line of the legend

/** The blocks as they are seen, with what the colours mean below. */
export function savePicture(view) {
  const {width, height} = view.camera, ratio = window.devicePixelRatio || 1;
  const words = [document.title, view.clock.textContent,
    ...[...view.legend.root.children].map((one) => one.innerText.replace(/\n+/g, "  "))];
  const sheet = document.createElement("canvas");
  sheet.width = width;
  sheet.height = height + (words.length + 1) * LINE * ratio;
  const c = sheet.getContext("2d");
  c.fillStyle = variable("--card");
  c.fillRect(0, 0, sheet.width, sheet.height);
  view.draw();  // what is drawn by WebGL is there until the next frame
  c.drawImage(view.canvas, 0, 0);
  c.drawImage(view.overlay, 0, 0);
  c.fillStyle = variable("--ink");
  c.font = `${13 * ratio}px system-ui, sans-serif`;
  words.forEach((line, i) => c.fillText(line, 12 * ratio, height + (i + 1) * LINE * ratio));
  sheet.toBlob((data) => give(data, "png"));
}

/** All histories that are shown, a line for each value. */
export function saveData(view) {
  const quoted = (text) => `"${text.replaceAll('"', '""')}"`, rows = ["chart,line,time (s),value"];
  for (const chart of [...view.plots, view.blockChart].filter(Boolean)) {
    for (const line of chart.lines) {
      const head = `${quoted(`${chart.words} (${chart.unit})`)},${quoted(line.label)}`;
      line.y.forEach((y, i) => rows.push(`${head},${line.x[i]},${y}`));
    }
  }
  give(new Blob([rows.join("\n"), "\n"], {type: "text/csv"}), "csv");
}

function give(data, ending) {
  const link = element("a", null);
  link.href = URL.createObjectURL(data);
  link.download = `${document.title.replace(/[^\w-]+/g, "_").slice(0, 60) || "blocks"}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
