// Runs in each tab, after `uuid` (of a hidden field of viser's): what happens on the page's own HTML goes to the
// server as words. Elements say what they mean by attributes:
//   data-fcw="event:4"                      a click on it is the message "event:4"
//   data-fcw-slide="seek:12.5:32.5"         a click or a drag along it is "seek:" and the number under the mouse,
//                                           12.5 at its left edge and 32.5 at its right one; it has an id
//   data-fcw-along="fcw-whole"              of such an element: the id of another one along which it is dragged
//   data-fcw-waits                          of the same: the message is sent when it is let go of, and only then
//   data-fcw-choice="reason"                of a select: the value that is chosen, "reason:OTHER"
//   data-fcw-enter="note"                   of a field: Enter is the message "note:" and what was typed, which stays
//                                           until the server has taken it, also when the field is drawn anew
//   data-fcw-key="t"                        of a field: that key puts the cursor in it
//   data-fcw-typed="search"                 of a field: what stands in it while it is typed, "search:ab"
//   data-fcw-scroll="list"                  drawn anew, it is scrolled to where it was
//   data-fcw-item="made"                    of a list: arrow keys lead from one to the next, Enter is a click on it;
//                                           drawn anew, the list has the focus where it was
//   data-fcw-seen                           drawn anew, it is scrolled into sight
//   data-fcw-size="strip"                   its size in CSS pixels, "size:strip 1040x315", now and when it changes
const SLIDE_MS = 40; // between the messages of one drag; the last position is always told
const TYPED_MS = 80; // after the last letter

const channel = (window.fcwChannel ??= { uuid: null, count: 0, sizes: {}, scrolled: {}, row: null, typed: {} });
channel.uuid = uuid;
channel.sizes = {};
// The number makes each message a new value: viser tells its server of changes only.
channel.tell = (words) =>
  window.__viserMutable.sendMessage({
    type: "GuiUpdateMessage",
    uuid: channel.uuid,
    updates: { value: `${++channel.count} ${words}` },
  });

const measure = () => {
  for (const element of document.querySelectorAll("[data-fcw-size]")) {
    const { width, height } = element.getBoundingClientRect();
    const [name, size] = [element.dataset.fcwSize, `${Math.round(width)}x${Math.round(height)}`];
    if (width > 0 && channel.sizes[name] !== size) {
      channel.sizes[name] = size;
      channel.tell(`size:${name} ${size}`);
    }
  }
};

if (!channel.listens) {
  channel.listens = true;
  let slid = null, moved = false, toldAt = 0, later = null;
  const waits = (element) => element.dataset.fcwWaits !== undefined;
  const slide = (event) => {
    const along = document.getElementById(slid.dataset.fcwAlong) ?? slid;
    const { left, width } = along.getBoundingClientRect();
    const parts = slid.dataset.fcwSlide.split(":"); // the name may have colons of its own
    const [to, from] = [parts.pop(), parts.pop()];
    const part = Math.min(Math.max((event.clientX - left) / width, 0), 1);
    return `${parts.join(":")}:${Number(from) + part * (Number(to) - Number(from))}`;
  };
  const tellSlide = (words) => {
    clearTimeout(later);
    const tell = () => {
      toldAt = performance.now();
      channel.tell(words);
    };
    const wait = toldAt + SLIDE_MS - performance.now();
    if (wait > 0) later = setTimeout(tell, wait);
    else tell();
  };
  document.addEventListener("click", (event) => {
    const element = event.target.closest?.("[data-fcw]");
    if (!element) return;
    channel.tell(element.dataset.fcw);
    element.blur?.(); // keys are the page's again
  });
  // What is pressed may be drawn anew before it is let go of: of that the browser makes no click.
  let pressed = null;
  const pressable = ({ target }) => target.closest?.("[data-fcw], [data-fcw-goto]") ?? null;
  document.addEventListener("pointerdown", (event) => (pressed = event.button === 0 ? pressable(event) : null));
  document.addEventListener("pointerup", (event) => {
    const released = pressed && !pressed.isConnected ? pressable(event) : null;
    const same = (name) => released.dataset[name] === pressed.dataset[name];
    // Marks are SVG, which has no `click()`.
    const click = new MouseEvent("click", { bubbles: true, cancelable: true });
    if (released && same("fcw") && same("fcwGoto")) released.dispatchEvent(click);
    pressed = null;
  });
  // Before the page takes the cursor out of the field. viser's own fields tell only the last of several changes
  // that come quickly, and forms may be handed in without their last letters.
  window.addEventListener("keydown", (event) => {
    const { fcwEnter } = event.target.dataset ?? {};
    if (event.key !== "Enter" || event.isComposing || fcwEnter === undefined) return;
    channel.tell(`${fcwEnter}:${event.target.value}`);
  }, { capture: true });
  // At once, and before viser hears the key: what is typed next is text, whenever the server hears of it.
  window.addEventListener("keydown", (event) => {
    const { key, target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    if (target.matches?.("input, textarea, select")) return;
    const field = document.querySelector(`[data-fcw-key="${CSS.escape(key.toLowerCase())}"]`);
    if (!field) return;
    event.preventDefault(); // the key itself is no text
    event.stopImmediatePropagation();
    field.focus();
  }, { capture: true });
  document.addEventListener("change", (event) => {
    const { fcwChoice } = event.target.dataset;
    if (fcwChoice === undefined) return;
    channel.tell(`${fcwChoice}:${event.target.value}`);
    event.target.blur();
  });
  document.addEventListener("pointerdown", (event) => {
    // A mark on a time line has its own meaning.
    const element = event.target.closest?.("[data-fcw], [data-fcw-slide]");
    if (event.button !== 0 || !element?.dataset.fcwSlide) return;
    slid = element;
    event.preventDefault(); // words are not selected while sliding
    if (!waits(slid)) tellSlide(slide(event));
  });
  document.addEventListener("pointermove", (event) => {
    if (!slid) return;
    // What was taken hold of may have been drawn anew since.
    if (!slid.isConnected) slid = document.getElementById(slid.id);
    if (!slid) return;
    if (!waits(slid)) return tellSlide(slide(event));
    // Only its end counts; until then it follows the mouse.
    const { left, width } = document.getElementById(slid.dataset.fcwAlong).getBoundingClientRect();
    slid.style.left = `${Math.min(Math.max(event.clientX - left, 0), width)}px`;
    moved = true;
  });
  document.addEventListener("pointerup", (event) => {
    if (slid && waits(slid) && moved) channel.tell(slide(event));
  });
  for (const end of ["pointerup", "pointercancel"])
    document.addEventListener(end, () => ([slid, moved] = [null, false]));
  let typed = null;
  document.addEventListener("input", ({ target }) => {
    if (target.dataset?.fcwTyped === undefined) return;
    clearTimeout(typed);
    typed = setTimeout(() => channel.tell(`${target.dataset.fcwTyped}:${target.value}`), TYPED_MS);
  });
  document.addEventListener("scroll", ({ target }) => {
    const name = target.dataset?.fcwScroll;
    if (name) channel.scrolled[name] = target.scrollTop;
  }, { capture: true });
  const scrollBack = () => {
    for (const element of document.querySelectorAll("[data-fcw-scroll]")) {
      if (element.fcwScrolled) continue;
      element.fcwScrolled = true;
      element.scrollTop = channel.scrolled[element.dataset.fcwScroll] ?? 0;
    }
  };
  // One goes through a list by its keys as by the mouse; the focus tells a screen reader, too, where one is.
  const rowsOf = () => [...document.querySelectorAll("[data-fcw-item]")];
  window.addEventListener("keydown", (event) => {
    const { key, target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    if (target.matches?.("input, textarea, select")) return;
    const rows = rowsOf();
    if (!rows.length) return;
    const at = rows.findIndex((row) => row.dataset.fcwItem === channel.row), end = rows.length - 1;
    const to = { ArrowDown: Math.min(at + 1, end), ArrowUp: Math.max(at - 1, 0), Home: 0, End: end }[key];
    if (to === undefined && (key !== "Enter" || target.dataset?.fcwItem === undefined)) return;
    event.preventDefault(); // nor does the list scroll
    event.stopImmediatePropagation();
    if (to === undefined) target.click();
    else rows[to].focus();
  }, { capture: true });
  document.addEventListener("focusin", ({ target }) => (channel.row = target.dataset?.fcwItem ?? channel.row));
  const focusRow = () => {
    const focused = document.activeElement;
    if (channel.row === null || (focused && focused !== document.body)) return;
    const row = rowsOf().find((one) => one.dataset.fcwItem === channel.row);
    row?.focus({ preventScroll: true }); // somebody may have turned the wheel since
  };
  // Words half typed stay when their field is drawn anew, and so does the cursor: else the next letter were a key of
  // the page. A field that is taken away loses the focus in the same moment.
  const FIELD = "[data-fcw-enter], [data-fcw-typed]";
  let left = {};
  document.addEventListener("input", ({ target }) => {
    if (target.matches?.(FIELD)) channel.typed[target.id] = target.value;
  });
  document.addEventListener("focusout", ({ target }) => {
    if (!target.matches?.(FIELD)) return;
    left = { id: target.id, at: target.selectionStart };
    setTimeout(() => (left = {}));
  });
  const typeOn = () => {
    for (const field of document.querySelectorAll(FIELD)) {
      if (field.fcwTypedOn) continue;
      field.fcwTypedOn = true;
      const words = channel.typed[field.id] ?? field.value;
      if (words.trim() === field.value.trim()) delete channel.typed[field.id]; // kept, by now
      else field.value = words;
      if (field.id !== left.id) continue;
      field.focus({ preventScroll: true });
      field.setSelectionRange(left.at, left.at);
    }
  };
  const showChosen = () => {
    for (const element of document.querySelectorAll("[data-fcw-seen]")) {
      if (!element.fcwSeen) element.scrollIntoView({ block: "nearest" });
      element.fcwSeen = true;
    }
  };
  // Panels are drawn by React in its own time, and sizes follow the window and the panels' edges.
  const sizes = new ResizeObserver(measure);
  new MutationObserver(() => {
    for (const element of document.querySelectorAll("[data-fcw-size]")) sizes.observe(element);
    measure();
    scrollBack();
    typeOn();
    focusRow();
    showChosen();
  }).observe(document.body, { childList: true, subtree: true });
}
measure();
// viser takes what stands after # out of the address, and leaves the rest.
const address = new URLSearchParams(location.search);
channel.tell(`asked:${address.get("asked") ?? ""}`);
channel.tell(`ready:${address.get("at") ?? ""}`);
