// Runs in each tab: tells the styles how much of the window viser's docked panel takes, wherever somebody drags its
// edge, folds it or lets it float; and sees to it that the picture is drawn as large as its place is.
if (!window.fcwLayout) {
  window.fcwLayout = true;
  // Else a phone makes the page as wide as a list that reaches beyond the window while it opens, which closes it.
  document.querySelector("meta[name=viewport]").content += ", minimum-scale=1";
  const root = document.documentElement.style;
  let region = null, docked = false;
  const measure = () => {
    const width = region?.isConnected ? Math.round(region.getBoundingClientRect().width) : 0;
    root.setProperty("--fcw-docked", `${width}px`);
  };
  const sizes = new ResizeObserver(measure);
  const look = () => {
    const found = document.querySelector('[data-dock-region="right"]');
    if (found !== region) {
      sizes.disconnect();
      region = found;
      if (region) sizes.observe(region);
      measure();
      // In a narrow window there is no dock. viser makes another one after it, of its own width.
      if (region && docked) window.fcwChannel?.tell("docked:");
      docked ||= region !== null;
    }
  };
  // While React Three Fiber starts, it can miss a change of its canvas's place, and stay with the size before until
  // the next change. So there is one, that lasts until it is drawn. And viser can set an old size after it: where both
  // happen between two frames, no size changes for an observer of sizes, but the canvas is told.
  const SETTLED_MS = 250;
  let canvas = null, waiting = 0;
  const fill = () => {
    const place = canvas.parentElement;
    const isOff = (side) => Math.abs(canvas[side] - (place?.[side] ?? canvas[side])) > 1;
    if (!isOff("clientWidth") && !isOff("clientHeight")) return;
    place.style.height = "calc(100% - 1px)";
    setTimeout(() => (place.style.height = "100%"), SETTLED_MS);
  };
  const settle = () => {
    clearTimeout(waiting);
    waiting = setTimeout(fill, SETTLED_MS);
  };
  const drawn = new ResizeObserver(settle);
  const told = new MutationObserver(settle);
  const lookForCanvas = () => {
    const found = document.querySelector("canvas[data-engine]");
    if (!found || found === canvas) return;
    drawn.disconnect();
    told.disconnect();
    canvas = found;
    told.observe(canvas, { attributeFilter: ["width", "height"] });
    for (const sized of [canvas, canvas.parentElement]) drawn.observe(sized);
  };
  const lookAgain = () => {
    look();
    lookForCanvas();
  };
  new MutationObserver(lookAgain).observe(document.body, { childList: true, subtree: true });
  lookAgain();
  measure();
}
