// Runs before viser's script: what came with the page is seen until the page has drawn the same by itself. What
// somebody presses, types or chooses meanwhile is done then.
{
  const first = document.querySelector(".fcw-first");
  let wanted = null;
  first.addEventListener("click", ({ target }) => {
    const pressed = target.closest("[data-fcw]");
    if (!pressed || window.fcwChannel) return; // the channel hears it itself
    for (const before of first.querySelectorAll(".waits")) before.classList.remove("waits");
    pressed.classList.add("waits");
    wanted = pressed.dataset.fcw;
  });
  const outside = (selector) => [...document.querySelectorAll(selector)].find((one) => !first.contains(one));
  const take = (field) => {
    const { id, dataset } = field;
    const same = outside(id ? `#${CSS.escape(id)}` : `[data-fcw-choice="${CSS.escape(dataset.fcwChoice)}"]`);
    if (!same) return;
    if (document.activeElement === field) same.focus();
    if (same.value === field.value) return;
    same.value = field.value;
    same.dispatchEvent(new Event(id ? "input" : "change", { bubbles: true }));
  };
  const drawn = new MutationObserver(() => {
    const selector = first.dataset.fcwUntil, real = outside(selector);
    if (!real) return;
    drawn.disconnect();
    const { scrollTop } = first.querySelector(selector);
    for (const field of first.querySelectorAll("input, select")) take(field);
    first.remove();
    real.scrollTop = scrollTop;
    if (wanted !== null) window.fcwChannel.tell(wanted);
  });
  drawn.observe(document.body, { childList: true, subtree: true });
  // viser's script keeps the browser busy for a second: it starts when the first frame is drawn. A tab that nobody
  // looks at draws none.
  const start = () => {
    const text = document.querySelector("script[type='text/plain'][data-p]");
    if (!text) return;
    const script = document.createElement("script");
    Object.assign(script.dataset, text.dataset);
    script.textContent = text.textContent;
    text.replaceWith(script);
  };
  requestAnimationFrame(() => setTimeout(start));
  setTimeout(start, 1000);
}
