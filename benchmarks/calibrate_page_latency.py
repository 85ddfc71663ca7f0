"""How soon the rows follow a point that is dragged on the calibration page, in a real Chromium.

    python benchmarks/calibrate_page_latency.py

The page serves a copy of the shipped drive. The clock starts when the browser gets the mouse event (its own
time stamp, not when the page hears of it) and stops at the end of the first frame that shows the rows moved:
when the graphics process has drawn it and the browser begins the next one. Measured for a mouse that was at
rest before, and for one that moves without a pause. The server's own share is the processor time of all its
threads, and so no less than the time that it adds.
"""

import random
import shutil
import statistics
import sys
import tempfile
import time
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from chromium import WINDOW, chromium, option_parser
from lines import median_and_p95
from playwright.sync_api import Page

from fcw.camera.file import default_path
from fcw.versions import machine
from fcw_viz.calibrate_app.document.edits import AddMark, SetHeight, SetReference
from fcw_viz.calibrate_app.server import CalibrationPage
from fcw_viz.calibrate_app.session import Person

DRIVE = Path(__file__).parents[1] / "recordings" / "demo" / "drive.mp4"
MARKS = ((640.0, 500.2, 6.0), (640.0, 408.0, 15.0), (640.0, 371.1, 30.0))
READY_MS = 60_000
JUMP_PX = 8
"""Of the mouse; a row moves by more than half of it, and by less for the trembling of one pixel between."""
REST_MS = 600
"""Longer than the frames that follow every change by themselves."""
MOTION_MS = 400
"""Of trembling before a jump, and up to as much again so that jumps come at any time of a frame."""
PROBE = """() => {
  const viewer = window.__viserMutable;
  const rows = () => {
    const heights = [];
    for (const name in viewer.nodeRefFromName) {
      if (!name.startsWith("/overlay/") || !viewer.nodeRefFromName[name]?.visible) continue;
      for (const child of viewer.nodeRefFromName[name].children) child.traverse(node => {
        const ends = node.geometry?.attributes?.instanceStart?.data?.array;
        if (!ends) return;
        for (let i = 0; i < ends.length; i += 6)
          if (ends[i + 2] === ends[i + 5] && Math.abs(ends[i + 3] - ends[i]) > 9.9) {
            const [x, y, z] = ends.slice(i, i + 3), m = node.matrixWorld.elements;
            heights.push(m[1] * x + m[5] * y + m[9] * z + m[13]);
          }
      });
    }
    return heights.sort((a, b) => a - b);
  };
  const pixel = 2 * viewer.cameraControl.distance * Math.tan(viewer.camera.fov * Math.PI / 360)
    / viewer.canvas.clientHeight;
  let base = [], jumpedAt = null, done = null, last = null, intervals = [], drawings = [];
  window.addEventListener("pointermove", event => {
    if (done && jumpedAt === null && event.clientY === window.__jumpTo) jumpedAt = event.timeStamp;
  }, { capture: true });
  viewer.scene.onAfterRender = renderer => {
    const now = performance.now();
    if (last !== null && now - last < 400) intervals.push(now - last);
    last = now;
    if (jumpedAt === null || !done) return;
    const present = rows();
    const moved = Math.max(0, ...present.map(
      row => Math.min(...base.map(other => Math.abs(row - other)))));
    if (moved < window.__enough * pixel) return;
    const gl = renderer.getContext(), fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const resolve = done, start = jumpedAt;
    done = jumpedAt = null;
    const drawn = new Promise(finish => {
      const look = () => {
        if (gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED) finish();
        else setTimeout(look, 1);
      };
      look();
    });
    const next = new Promise(requestAnimationFrame);
    Promise.all([drawn, next]).then(() => resolve(performance.now() - start));
  };
  window.__arm = (jumpTo, enough) => {
    base = rows();
    window.__jumpTo = jumpTo;
    window.__enough = enough;
    window.__measured = new Promise(resolve => { done = resolve; });
  };
  window.__frames = () => { const seen = intervals; intervals = []; return seen; };
}"""
"""Lines are pairs of points, three numbers each; a row is one over the whole picture, 10 units long."""
MEASURED = "() => Promise.race([window.__measured, new Promise(resolve => setTimeout(resolve, 5000, null))])"
"""Null where rows that lagged behind were taken for those before the jump, on a slow machine."""


def main() -> None:
    """Measure, and print what was measured."""
    parser = option_parser(__doc__)
    parser.add_argument("--events", type=int, default=40, help="how many jumps of the mouse in each case")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, chromium(options) as browser:
        source = Path(shutil.copy(DRIVE, folder))
        served = CalibrationPage(source, default_path(source))
        edits = [AddMark(column_px, row_px, 0, distance_m) for column_px, row_px, distance_m in MARKS]
        served.session.apply(Person("benchmark"), *edits, SetHeight(1.3), SetReference(True, 1.6))
        page = browser.new_page(viewport=WINDOW)
        page.goto(f"{served.url}/?fixedDpr=1")
        page.wait_for_function("window.__viserMutable?.cameraControl?.dollyToCursor", timeout=READY_MS)
        page.wait_for_timeout(3000)
        page.evaluate(PROBE)
        x, y = take_hold(page)
        rest_ms, server_ms = jump_from_rest(page, x, y, options.events)
        page.evaluate("window.__frames()")
        motion_ms = jump_in_motion(page, x, y, options.events)
        frames_ms = page.evaluate("window.__frames()")
        page.mouse.up()
        served.stop()
    lines = (
        f"{datetime.now(UTC):%Y-%m-%d}, {machine()}, viser {version('viser')}",
        f"Chromium with software rendering, {WINDOW['width']}x{WINDOW['height']}, {options.events} events",
        f"mouse event to the end of the frame with the moved rows: {median_and_p95(rest_ms)} from rest, "
        f"{len(rest_ms)} measured",
        f"the same in motion: {median_and_p95(motion_ms)}, {len(motion_ms)} measured",
        f"of it a frame of software rendering: {median_and_p95(frames_ms)}; a graphics card takes a few",
        f"of it the server: median {statistics.median(server_ms):.1f} ms, mean "
        f"{statistics.mean(server_ms):.1f} ms of processor time an event",
    )
    sys.stdout.write("\n".join(lines) + "\n")


def take_hold(page: Page) -> tuple[float, float]:
    """Begin to drag the middle point; where the mouse is then."""
    canvas = max(
        (box for box in (one.bounding_box() for one in page.locator("canvas").all()) if box),
        key=lambda box: box["width"] * box["height"],
    )
    scale = min(canvas["width"] / 1280, canvas["height"] / 720) / 1.02
    x = round(canvas["x"] + canvas["width"] / 2)
    y = round(canvas["y"] + canvas["height"] / 2 + (MARKS[1][1] - 359.5) * scale)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 5, steps=5)
    page.wait_for_timeout(REST_MS)
    return x, y


def jump_from_rest(page: Page, x: float, y: float, events: int) -> tuple[list[float], list[float]]:
    """Latency and the server's processor time of each jump, in ms."""
    latencies_ms: list[float | None] = []
    server_ms: list[float] = []
    for event in range(events):
        there = y + (event % 2) * JUMP_PX
        page.mouse.move(x, there + (-JUMP_PX if event % 2 else JUMP_PX))
        page.wait_for_timeout(REST_MS)
        page.evaluate("([y, enough]) => window.__arm(y, enough)", [there, JUMP_PX / 2])
        before_s = server_time_s()
        page.mouse.move(x, there)
        latencies_ms.append(page.evaluate(MEASURED))
        page.wait_for_timeout(REST_MS / 2)
        server_ms.append((server_time_s() - before_s) * 1000)
    return [latency_ms for latency_ms in latencies_ms if latency_ms is not None], server_ms


def jump_in_motion(page: Page, x: float, y: float, events: int) -> list[float]:
    """Latency of each jump of a mouse that trembles by a pixel all the time, in ms."""
    latencies_ms: list[float | None] = []
    phase = random.Random(0)
    here, there = y, y + JUMP_PX
    for _ in range(events):
        tremble(page, x, here, MOTION_MS * (1 + phase.random()))
        page.evaluate("([y, enough]) => window.__arm(y, enough)", [there, JUMP_PX / 2])
        page.mouse.move(x, there)
        tremble(page, x, there, MOTION_MS)
        latencies_ms.append(page.evaluate(MEASURED))
        here, there = there, here
    return [latency_ms for latency_ms in latencies_ms if latency_ms is not None]


def tremble(page: Page, x: float, y: float, duration_ms: float) -> None:
    """Move the mouse sideways by a pixel and back."""
    end_s = time.monotonic() + duration_ms / 1000
    step = 0
    while time.monotonic() < end_s:
        step += 1
        page.mouse.move(x + step % 2, y)


def server_time_s() -> float:
    """Processor time of every thread but this one, which drives the browser."""
    return time.process_time() - time.thread_time()


if __name__ == "__main__":
    main()
