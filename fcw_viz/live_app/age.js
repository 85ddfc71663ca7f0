// Runs in each tab of the live page: how old the picture on the screen is. The notice that it is old is an animation
// whose own time is that age: the browser's compositor lets it come in time even while every script of the page is
// held up. The server tells with each picture when it was captured, on this browser's clock.
const AT_MOST_MS = 900; // older than that the notice stands
const LONGEST_MS = 1e8; // of a drive, for the animation
const WORDS_MS = 100;
const OLD_WORDS = "This picture is old: no new one has arrived for a while";

const age = (window.fcwAge ??= {
  coming: null, captured: null, animation: null, notice: null, words: OLD_WORDS, listens: false });
const element = () => {
  if (age.notice === null) {
    age.notice = document.createElement("div");
    age.notice.className = "fcw-late";
    age.notice.textContent = age.words;
    document.body.append(age.notice);
  }
  return age.notice;
};
const animated = () => {
  const part = AT_MOST_MS / LONGEST_MS;
  const [unseen, seen] = [{ opacity: 0 }, { opacity: 1 }];
  const steps = [unseen, { ...unseen, offset: part }, { ...seen, offset: part }, seen];
  return element().animate(steps, { duration: LONGEST_MS, fill: "forwards" });
};
// Of a picture that follows; one that was not drawn yet keeps its time, so that no age is too small.
age.comes = (captured) => (age.coming ??= captured ?? performance.now());
// What the notice says; nothing for what it says by itself. While there is a reason nothing is live.
age.says = (words) => {
  document.documentElement.dataset.fcwLive = words ? "lost" : "";
  age.words = words || OLD_WORDS;
  element().textContent = age.words;
};
// No picture will come any more: what the page says of the present moment is hidden. Words of a loss stay.
age.end = (lost) => {
  if (lost) age.says(lost);
  document.documentElement.dataset.fcwLive = "ended";
  element().classList.toggle("lost", Boolean(lost));
  age.animation?.cancel();
  age.coming = age.captured = null;
};
if (!age.listens) {
  age.listens = true;
  window.addEventListener("fcw-drawn", () => {
    if (age.coming === null) return;
    [age.captured, age.coming] = [age.coming, null];
    age.animation ??= animated();
    if (age.animation.playState !== "running") age.animation.play();
    age.animation.currentTime = performance.now() - age.captured;
  });
  window.addEventListener("fcw-gone", () => age.end("")); // other words stand there
  setInterval(() => {
    const words = document.querySelector("[data-fcw-age]");
    if (age.captured === null) return;
    const old_ms = performance.now() - age.captured;
    document.documentElement.dataset.fcwPicture = old_ms > AT_MOST_MS ? "old" : "new"; // no warning, as far as is known
    if (words) words.textContent = `${(old_ms / 1000).toFixed(1)} s`;
  }, WORDS_MS);
}
