// Runs once in each tab: manners of viser's fields that it has no call for.
(() => {
  if (window.fcwFields) return;
  window.fcwFields = true;
  const inputOf = (uuid) => {
    let node = document.querySelector(`label[for="${uuid}"]`);
    while (node && !node.querySelector("input")) node = node.parentElement;
    return node?.querySelector("input") ?? null;
  };

  // The largest part of the page around the picture that holds no field.
  const onPicture = (target) => {
    let pane = window.__viserMutable?.canvas;
    while (pane?.parentElement && !pane.parentElement.querySelector("label[for]")) pane = pane.parentElement;
    return pane?.contains(target) ?? false;
  };

  // What is typed right after a click, or a key, that asks for a number waits for its field.
  const WAIT_MS = 6000;
  let waiting = null;
  const insert = (input, text) => {
    input.setRangeText(text, input.selectionStart, input.selectionEnd, "end");
    input.dispatchEvent(new Event("input", { bubbles: true }));
  };
  const stopWaiting = () => {
    const { keys } = waiting;
    clearTimeout(waiting.timer);
    waiting = null;
    return keys;
  };
  window.fcwExpectsTyping = { click: false, key: "" };
  // No field comes: the keys mean what they always mean.
  window.fcwNoField = () => {
    for (const key of waiting ? stopWaiting() : [])
      document.documentElement.dispatchEvent(
        new KeyboardEvent("keydown", { key, code: /\d/.test(key) ? `Digit${key}` : "", bubbles: true }));
  };
  const expectTyping = () => {
    if (waiting) stopWaiting();
    waiting = { keys: [], timer: setTimeout(window.fcwNoField, WAIT_MS) };
  };
  const CLICK_PX = 3; // of motion; more is a drag
  let pressed = null;
  document.addEventListener("pointerdown", (event) => (pressed = event), { capture: true });
  document.addEventListener("pointerup", (event) => {
    if (!window.fcwExpectsTyping.click || event.button !== 0 || !onPicture(event.target)) return;
    if (pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) > CLICK_PX) return;
    expectTyping();
  });
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.("input, textarea")) return;
    if (!event.shiftKey && event.key.toLowerCase() === window.fcwExpectsTyping.key) expectTyping();
    if (!waiting || !/^[\d.,]$/.test(event.key)) return;
    waiting.keys.push(event.key);
    event.preventDefault();
    event.stopImmediatePropagation();
  }, { capture: true });

  // The browser builds a new field a moment after it was told to, a slow one seconds after.
  let wanted = null;
  window.fcwFocus = (uuid, until = performance.now() + WAIT_MS) => {
    wanted = uuid;
    const input = inputOf(uuid);
    if (input) {
      input.focus();
      input.select(); // as with the Tab key: what is typed replaces what was said before
      const keys = waiting ? stopWaiting() : [];
      if (keys.length) insert(input, keys.join(""));
    } else if (performance.now() < until)
      setTimeout(() => { if (wanted === uuid) window.fcwFocus(uuid, until); }, 30);
  };

  // Saving is saving everywhere, also while a number is typed; never the browser's own "save page".
  const TYPED_MS = 150; // until the server has heard what was typed last
  window.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.key.toLowerCase() !== "s") return;
    event.preventDefault();
    if (!event.target.matches?.("input, textarea, select")) return;
    event.stopImmediatePropagation();
    event.target.blur();
    const { ctrlKey, metaKey, shiftKey } = event;
    setTimeout(() => document.documentElement.dispatchEvent(
      new KeyboardEvent("keydown", { key: "s", code: "KeyS", ctrlKey, metaKey, shiftKey, bubbles: true })), TYPED_MS);
  }, { capture: true });

  const findTab = (name) =>
    [...document.querySelectorAll("[role=tab]")].find((node) => node.textContent.trim() === name);
  const turnTo = (node) => {
    const { x = 0, y = 0 } = node?.getBoundingClientRect() ?? {};
    const at = { bubbles: true, button: 0, isPrimary: true, pointerId: 1, clientX: x + 5, clientY: y + 5 };
    // viser's docked tabs can be dragged: they hear pointers, and no clicks.
    for (const type of ["pointerdown", "pointerup"]) node?.dispatchEvent(new PointerEvent(type, at));
    node?.click();
  };
  // To a tool's tab while it is used, and back to where one was, unless one has gone elsewhere since.
  let before = null;
  const openTab = (name) =>
    findTab(name)?.closest("[role=tablist]")?.querySelector("[role=tab][aria-selected=true]")?.textContent.trim();
  window.fcwTurnTo = (name) => {
    before = openTab(name);
    turnTo(findTab(name));
  };
  window.fcwTurnBack = (name) => {
    if (before && openTab(name) === name) turnTo(findTab(before));
    before = null;
  };

  // A way to what a sentence names: in its tab, in sight, and marked for a moment.
  document.addEventListener("click", (event) => {
    const { fcwGoto } = event.target.closest?.("[data-fcw-goto]")?.dataset ?? {};
    if (fcwGoto === undefined) return;
    const [tab, place] = fcwGoto.split("/");
    turnTo(findTab(tab));
    setTimeout(() => {
      const target = document.querySelector(`[data-fcw-place="${place}"]`);
      target?.scrollIntoView({ block: "center", behavior: "smooth" });
      target?.animate([{ outline: "3px solid #d9480f" }, { outline: "3px solid transparent" }], 2000);
    }, 200);
  });

  // viser's labels and inputs do not know each other: a screen reader is told, as is what is wrong with a field.
  const describe = () => {
    for (const label of document.querySelectorAll("label[for]")) {
      const uuid = label.htmlFor;
      const wrong = document.querySelector(`[data-fcw-wrong="${uuid}"]`);
      if (wrong) wrong.id = `wrong-${uuid}`;
      // The row of the label; a group of buttons has a label and no input.
      let node = label;
      while (node && !node.querySelector("input, [role=slider]")) node = node.parentElement;
      if (!node || node.querySelectorAll("label[for]").length > 1) continue;
      for (const input of node?.querySelectorAll("input, [role=slider]") ?? []) {
        if (input.type === "hidden") continue;
        const words = label.textContent.trim();
        if (words && input.getAttribute("aria-label") !== words) input.setAttribute("aria-label", words);
        if (wrong) {
          input.setAttribute("aria-invalid", "true");
          input.setAttribute("aria-describedby", wrong.id);
        } else if (input.getAttribute("aria-describedby")?.startsWith("wrong-")) {
          input.removeAttribute("aria-invalid");
          input.removeAttribute("aria-describedby");
        }
      }
    }
    const commands = document.querySelector(".tabler-icon-list-search")?.closest("button");
    commands?.setAttribute("aria-label", "All commands (Ctrl K)");
    window.__viserMutable?.canvas?.setAttribute("aria-label", "The picture of the drive");
    window.__viserMutable?.canvas?.setAttribute("role", "img");
  };
  let planned = false;
  new MutationObserver(() => {
    if (planned) return;
    planned = true;
    setTimeout(() => { planned = false; describe(); }, 100);
  }).observe(document.body, { childList: true, subtree: true });
  describe();
})();
