// Runs in each tab: tells the styles how much of the window viser's docked panel takes, wherever somebody drags its
// edge, folds it or lets it float.
if (!window.fcwLayout) {
  window.fcwLayout = true;
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
  new MutationObserver(look).observe(document.body, { childList: true, subtree: true });
  look();
  measure();
}
