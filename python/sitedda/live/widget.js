// The page of `sitedda live` in a frame, at the address that Python sends.

export default {
  render({model, el}) {
    const frame = document.createElement("iframe");
    frame.style.cssText = "width: 100%; height: 900px; border: 0";
    const enter = ({address}) => { frame.src = address; };
    model.on("msg:custom", enter);
    model.send({});
    el.append(frame);
    return () => model.off("msg:custom", enter);
  },
};
