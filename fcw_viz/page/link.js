// Runs in each tab: what the page does without its program. viser tries every second to connect again, only while the
// page has the focus, and each try ends the one before; after some failed ones Chromium holds each back for longer than
// that, so that none ever succeeds. Here the program is asked by plain requests, which nobody holds back, and the page
// is loaded anew when it answers: its address says where it was.
const ASK_MS = 1000;
const AWAY_WORDS = "The program is not responding. This page reconnects by itself when it does.";

const link = (window.fcwLink ??= { worker: null, notice: null, ended: null });
const ask = async () => {
  try {
    const answer = await fetch(location.href, { cache: "no-store" });
    answer.body?.cancel();
    if (answer.ok) location.reload();
  } catch {
    // Not there yet.
  }
};
const lose = (words) => {
  if (link.notice === null) {
    link.notice = document.createElement("div");
    link.notice.className = "fcw-gone";
    document.documentElement.dataset.fcwLink = "gone";
    document.body.append(link.notice);
    setInterval(ask, ASK_MS);
    for (const event of ["focus", "online"]) window.addEventListener(event, ask);
    window.dispatchEvent(new CustomEvent("fcw-gone"));
  }
  link.notice.textContent = words;
};
if (link.ended === null) {
  const post = Worker.prototype.postMessage;
  const know = (worker) => {
    if (link.worker === worker) return;
    link.worker = worker;
    worker.addEventListener("message", ({ data }) => data?.type === "closed" && lose(AWAY_WORDS));
  };
  Worker.prototype.postMessage = function (message, ...rest) {
    if (message?.type === "retry" || message?.type === "send") know(this);
    if (message?.type === "retry") lose(AWAY_WORDS);
    else post.call(this, message, ...rest);
  };
  // The program ends, and says so; that the connection is closed tells it that this is read.
  link.ended = (words) => {
    lose(words);
    post.call(link.worker, { type: "close" });
  };
}
