"""Dragging on machines that draw slowly, and on those that do not: how long a frame takes is pretended."""

from pathlib import Path

import pytest
from browser_page import BrowserPage
from calibrate_helpers import DEMO_MARKS_PX, OpenPage, Serve, pictures_of_demo_drive

from fcw_viz.calibrate_app.document.edits import AddMark, SetHeight
from fcw_viz.calibrate_app.session import Person

SLOW_FRAME_MS, FAST_FRAME_MS = 70, 0
# The graphics card is asked with a fence whether it is done; and the clock is looked at when it is.
PRETEND = """(frame_ms) => {
  const gl = WebGL2RenderingContext.prototype, fence = gl.fenceSync, since = new WeakMap();
  const now = performance.now.bind(performance);
  let done_ms = null;
  window.drawn = window.drags = 0;
  performance.now = () => {
    const moment_ms = done_ms ?? now();
    done_ms = null;
    return moment_ms;
  };
  gl.fenceSync = function (...what) {
    const made = fence.apply(this, what);
    since.set(made, now());
    return made;
  };
  gl.getSyncParameter = function (asked) {
    const end_ms = (since.get(asked) ?? now() - frame_ms) + frame_ms;
    if (now() < end_ms) return this.UNSIGNALED;
    done_ms = end_ms;
    queueMicrotask(() => (done_ms = null));
    window.drawn += 1;
    return this.SIGNALED;
  };
  const viewer = window.__viserMutable, dragged = viewer.dragged;
  viewer.dragged = (phase) => {
    dragged(phase);
    window.drags += phase === "update";
  };
}"""
# More than the page remembers, each from rest: how long one takes is told by a frame that waits for no other.
DRAW_SOME = """async () => {
  for (let count = 0; count < 10; count++) {
    const before = window.drawn;
    window.__viserMutable.requestRender();
    for (let last = before, quiet = 0; last === before || quiet < 8; ) {
      await new Promise(requestAnimationFrame);
      quiet = window.drawn === last ? quiet + 1 : 0;
      last = window.drawn;
    }
  }
}"""
# Nothing is drawn and no message comes any more: not for so many frames of the browser, a second at least.
REST = """async () => {
  const queue = window.__viserMutable.messageQueue, push = queue.push;
  let quiet = 0, before = -1;
  queue.push = function (message) {
    quiet = 0;
    return push.call(this, message);
  };
  for (; quiet < 60; quiet++) {
    if (before !== (before = window.drawn)) quiet = 0;
    await new Promise(requestAnimationFrame);
  }
  queue.push = push;
}"""
# The clock stands still until the answer comes: where the server is slow, the page draws once more before it.
LISTEN = """() => {
  const viewer = window.__viserMutable, seen = (window.seen = []), queue = viewer.messageQueue;
  const lines = () => {
    let geometry = "";
    viewer.nodeRefFromName["/overlay/lines_5_0"].traverse(node => { geometry += node.geometry?.uuid ?? ""; });
    return geometry;
  };
  const before = lines(), push = queue.push, clock = performance.now, stopped_ms = clock();
  performance.now = () => (seen.includes("answer") ? clock() : stopped_ms);
  window.addEventListener("pointermove", () => seen.push("mouse"), { capture: true });
  queue.push = function (message) {
    if (message.name === "/overlay/lines_5_0" && seen.at(-1) !== "answer") seen.push("answer");
    return push.call(this, message);
  };
  viewer.scene.onAfterRender = () => seen.push(lines() === before ? "old rows" : "new rows");
}"""
WIDTH = "window.__viserMutable.canvas.width"


@pytest.fixture
def dragging(tmp_path: Path, serve: Serve, open_page: OpenPage) -> "Dragging":
    served = serve(pictures_of_demo_drive(tmp_path, count=1))
    marks = [
        AddMark(*at_px, 0, distance_m)
        for at_px, distance_m in zip(DEMO_MARKS_PX, (7.6, 16.6, 31.6), strict=True)
    ]
    served.session.apply(Person("test"), *marks, SetHeight(1.3))
    return Dragging(open_page(served.url, few_frames=False))


class Dragging:
    """Somebody who drags the middle one of three points."""

    def __init__(self, browser: BrowserPage) -> None:
        self.page = browser.page
        self._browser = browser

    def begin(self, frame_ms: float) -> None:
        """Take hold of it and move it, on a machine where a frame takes so long."""
        self.page.evaluate(PRETEND, frame_ms)
        self.page.evaluate(DRAW_SOME)
        x, y = self._browser.mouse_position(*DEMO_MARKS_PX[1])
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x, y + 8, steps=4)
        self.page.wait_for_function("window.drags > 0")

    def go_on(self) -> None:
        """Move it further, until that is drawn."""
        x, y = self._browser.mouse_position(*DEMO_MARKS_PX[1])
        self.page.mouse.move(x, y + 14)
        self.page.wait_for_function("window.seen.indexOf('new rows') > window.seen.indexOf('answer')")


def test_slow_frames_are_coarse_during_a_drag_and_sharp_after_it(dragging: Dragging) -> None:
    page = dragging.page
    sharp_px = page.evaluate(WIDTH)
    dragging.begin(SLOW_FRAME_MS)
    page.wait_for_function(f"{WIDTH} === {sharp_px // 2}")
    page.mouse.up()
    page.wait_for_function(f"{WIDTH} === {sharp_px}")


def test_fast_frames_stay_sharp_during_a_drag(dragging: Dragging) -> None:
    sharp_px = dragging.page.evaluate(WIDTH)
    dragging.begin(FAST_FRAME_MS)
    dragging.page.evaluate(DRAW_SOME)
    assert dragging.page.evaluate(WIDTH) == sharp_px


def test_where_frames_are_slow_none_is_drawn_before_the_answer_and_then_one_with_the_moved_rows(
    dragging: Dragging,
) -> None:
    dragging.begin(SLOW_FRAME_MS)
    dragging.page.evaluate(REST)
    dragging.page.evaluate(LISTEN)
    dragging.go_on()
    seen = dragging.page.evaluate("window.seen")
    first = seen.index("answer")
    assert set(seen[:first]) == {"mouse"}, "a frame in which nothing has moved keeps the next one waiting"
    assert seen[first + 1] == "new rows"
