// The view in a notebook: its page in a frame, whose picked block and time are values of Python.

export default {
  render({model, el}) {
    const frame = document.createElement("iframe");
    frame.style.cssText = "width: 100%; height: 720px; border: 0";
    frame.srcdoc = model.get("page");
    frame.addEventListener("load", () => join(model, frame.contentWindow.blockViews[0]));
    el.append(frame);
  },
};

function join(model, view) {
  let timer;
  view.root.addEventListener("state", () => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      model.set("picked", view.state.picked);
      model.set("time", view.meta.time[view.frame]);
      model.save_changes();
    }, 50);
  });
  model.on("change:picked", () => {
    const name = model.get("picked");
    if (name !== view.state.picked) view.pick(view.model.names.indexOf(name));
  });
  model.on("change:time", () => {
    if (model.get("time") !== view.meta.time[view.frame]) view.showTime(model.get("time"));
  });
}
