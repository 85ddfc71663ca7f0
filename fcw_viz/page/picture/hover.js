// Runs in each tab, once the page's channel is open: tells it "hover:<x> <y>", where the mouse rests or moves over
// the picture as parts of the canvas's width and height from its upper left, and "hover:" where it has left it.
const HOVER_MS = 60; // between two messages; the last place is always told
const { canvas } = window.__viserMutable;
let place = "", told = "", later = null;
const tell = () => {
  later = null;
  if (place !== told) window.fcwChannel.tell(`hover:${(told = place)}`);
};
const move = (event) => {
  const { left, top, width, height } = canvas.getBoundingClientRect();
  const [x, y] = [(event.clientX - left) / width, (event.clientY - top) / height];
  // While it drags, the picture moves below it; over a panel it is not on the picture.
  const on = event.buttons === 0 && event.target === canvas && x >= 0 && x <= 1 && y >= 0 && y <= 1;
  place = on ? `${x.toFixed(4)} ${y.toFixed(4)}` : "";
  later ??= setTimeout(tell, HOVER_MS);
};
document.addEventListener("pointermove", move);
document.documentElement.addEventListener("pointerleave", move);
