// Runs in each tab, once the page's channel is open: what the strip does by itself.
//   data-fcw-readout="[...]"   of the plots: of each run its moments and curves; all values of the moment under the
//                              mouse are told beside it
//   data-fcw-utc="..."         of the same: milliseconds since 1970 of the axis's 0, where they are known
//   data-fcw-splitter          dragged, the strip grows or shrinks; a double click gives it its own height again
const LEAST_STRIP_PX = 150, LEAST_PICTURE_PX = 120, TALLER = 1.7;
const root = document.documentElement;
const strip = () => document.querySelector(".fcw-strip:not(.fcw-now)");
const share = () => Number(root.style.getPropertyValue("--fcw-share")) || 1;
const resize = (px) => {
  const { top, bottom } = strip().getBoundingClientRect(); // the picture is above it
  const picture = Math.max(LEAST_PICTURE_PX, bottom - Math.max(LEAST_STRIP_PX, px));
  root.style.setProperty("--fcw-share", (share() * picture) / top);
  dispatchEvent(new Event("resize"));
};
const resetHeight = () => {
  root.style.removeProperty("--fcw-share");
  dispatchEvent(new Event("resize"));
};
window.fcwTaller = () => (share() === 1 ? resize(strip().getBoundingClientRect().height * TALLER) : resetHeight());

if (!window.fcwStrip) {
  window.fcwStrip = true;
  let splits = false;
  document.addEventListener("pointerdown", (event) => {
    splits = event.button === 0 && !!event.target.closest?.("[data-fcw-splitter]");
    if (splits) event.preventDefault();
  });
  document.addEventListener("pointermove", (event) => {
    if (splits) resize(strip().getBoundingClientRect().bottom - event.clientY);
  });
  for (const end of ["pointerup", "pointercancel"]) document.addEventListener(end, () => (splits = false));
  document.addEventListener("dblclick", (event) => {
    if (event.target.closest?.("[data-fcw-splitter]")) resetHeight();
  });

  const tip = document.createElement("div"), hair = document.createElement("div");
  [tip.className, hair.className] = ["fcw-readout", "fcw-hair"];
  document.body.append(tip, hair);
  const show = (visible) => { for (const node of [tip, hair]) node.style.display = visible ? "block" : "none"; };
  show(false);
  const clock = (seconds) => {
    const hundredths = Math.round(100 * seconds), all = Math.floor(hundredths / 6000);
    const rest = ((hundredths % 6000) / 100).toFixed(2), [hours, minutes] = [Math.floor(all / 60), all % 60];
    if (!all) return `${rest} s`;
    const tail = `${minutes}:${rest.padStart(5, "0")}`;
    return hours ? `${hours}:${tail.padStart(8, "0")}` : tail; // as time_text of drive.py
  };
  const line = (color, name, value) => {
    const row = document.createElement("div");
    for (const text of [name, value]) row.append(Object.assign(document.createElement("span"), { textContent: text }));
    row.style.setProperty("--curve", color);
    return row;
  };
  const lastBefore = (times, time) => {
    let [low, high] = [0, times.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  };
  let text = "", runs = [];
  const move = (event) => {
    const plots = event.target.closest?.("[data-fcw-readout]");
    if (!plots) return show(false);
    if (plots.dataset.fcwReadout !== text) runs = JSON.parse((text = plots.dataset.fcwReadout));
    const { left, top, width, height } = plots.getBoundingClientRect();
    const [, from, to] = plots.dataset.fcwSlide.split(":").map(Number);
    const time = from + ((event.clientX - left) / width) * (to - from);
    const rows = [];
    for (const { times_s, curves } of runs) {
      const at = lastBefore(times_s, time);
      for (const { name, unit, color, values } of curves)
        rows.push(line(color, name, at < 0 || values[at] === "" ? "–" : `${values[at]} ${unit}`));
    }
    const { fcwUtc } = plots.dataset;
    if (fcwUtc !== undefined)
      rows.unshift(line("transparent", "UTC", new Date(Number(fcwUtc) + time * 1000).toISOString().slice(11, 23)));
    tip.replaceChildren(line("transparent", "at", clock(Math.max(time, 0))), ...rows);
    show(true);
    hair.style.cssText += `;left:${event.clientX}px;top:${top}px;height:${height}px`;
    const box = tip.getBoundingClientRect();
    const beside = event.clientX + 16 + box.width < left + width ? event.clientX + 16 : event.clientX - 16 - box.width;
    tip.style.left = `${Math.max(beside, 2)}px`;
    tip.style.top = `${Math.max(Math.min(event.clientY - box.height / 2, innerHeight - box.height - 4), 4)}px`;
  };
  document.addEventListener("pointermove", move);
  root.addEventListener("pointerleave", () => show(false));
  const chosen = localStorage.getItem("fcwPlots");
  if (chosen !== null) window.fcwChannel.tell(`plots:${chosen}`);
}
