"""How soon the rows follow a point that is dragged on the calibration page, in a real Chromium.

    python benchmarks/calibrate_page_latency.py

The page serves a copy of the shipped drive. The clock starts with the mouse event in the browser and stops
with the first frame whose lines over the picture have moved. The server's own share is the processor time of
all its threads, and so no less than the time that it adds.
"""

import argparse
import shutil
import statistics
import sys
import tempfile
import time
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from playwright.sync_api import Page, ViewportSize, sync_playwright

from fcw.camera.file import default_path
from fcw.versions import machine
from fcw_viz.calibrate_app.edits import AddMark, SetHeight, SetReference
from fcw_viz.calibrate_app.server import CalibrationPage
from fcw_viz.calibrate_app.session import Person

DRIVE = Path(__file__).parents[1] / "recordings" / "demo" / "drive.mp4"
BROWSER_ARGUMENTS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
WINDOW = ViewportSize(width=1400, height=900)
MARKS = ((640.0, 500.2, 6.0), (640.0, 408.0, 15.0), (640.0, 371.1, 30.0))
READY_MS = 60_000
FRAMES = 20
PAUSE_MS = 250
"""Between two events: each is measured by itself."""
MEASURE = """async ([x, y]) => {
  const lines = () => {
    let seen = "";
    const nodes = window.__viserMutable.nodeRefFromName;
    for (const name in nodes) if (name.startsWith("/overlay/lines")) nodes[name]?.traverse(node => {
      const points = node.geometry?.attributes?.instanceStart?.data?.array;
      if (points) for (let i = 2; i < points.length; i += 6) seen += points[i].toFixed(5) + ",";
    });
    return seen;
  };
  const before = lines();
  let start = null;
  const moved = () => { start = performance.now(); };
  window.addEventListener("pointermove", moved, { capture: true, once: true });
  window.__measured = new Promise(resolve => {
    const look = () => {
      if (start !== null && lines() !== before) resolve(performance.now() - start);
      else requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
}"""
"""Lines are pairs of points, three numbers each."""
FRAME = """async () => {
  const next = () => new Promise(requestAnimationFrame);
  window.__viserMutable.requestRender();
  await next();
  const start = performance.now();
  window.__viserMutable.requestRender();
  await next();
  return performance.now() - start;
}"""


def main() -> None:
    """Measure, and print what was measured."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else None)
    parser.add_argument("--events", type=int, default=100, help="how many moves of the mouse")
    parser.add_argument("--browser", default=shutil.which("chromium"), help="the Chromium to use")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        source = Path(shutil.copy(DRIVE, folder))
        served = CalibrationPage(source, default_path(source))
        edits = [AddMark(column_px, row_px, 0, distance_m) for column_px, row_px, distance_m in MARKS]
        served.session.apply(Person("benchmark"), *edits, SetHeight(1.3), SetReference(True, 1.6))
        browser = playwright.chromium.launch(executable_path=options.browser, args=list(BROWSER_ARGUMENTS))
        page = browser.new_page(viewport=WINDOW)
        page.goto(f"{served.url}/?fixedDpr=1")
        page.wait_for_function("window.__viserMutable?.cameraControl?.dollyToCursor", timeout=READY_MS)
        page.wait_for_timeout(3000)
        latencies_ms, server_ms = drag(page, options.events)
        frame_ms = statistics.median(page.evaluate(FRAME) for _ in range(FRAMES))
        browser.close()
        served.stop()
    p95_ms = statistics.quantiles(latencies_ms, n=20)[-1]
    lines = (
        f"{datetime.now(UTC):%Y-%m-%d}, {machine()}, viser {version('viser')}",
        f"Chromium with software rendering, {WINDOW['width']}x{WINDOW['height']}, {options.events} events",
        f"mouse event to rows drawn: median {statistics.median(latencies_ms):.0f} ms, p95 {p95_ms:.0f} ms",
        f"of it one frame of software rendering: {frame_ms:.0f} ms; a graphics card takes a few",
        f"of it the server: mean {statistics.mean(server_ms):.1f} ms of processor time an event",
    )
    sys.stdout.write("\n".join(lines) + "\n")


def drag(page: Page, events: int) -> tuple[list[float], list[float]]:
    """Drag the middle point up and down; latency and processor time of each move, in ms."""
    canvas = max(
        (box for box in (one.bounding_box() for one in page.locator("canvas").all()) if box),
        key=lambda box: box["width"] * box["height"],
    )
    scale = min(canvas["width"] / 1280, canvas["height"] / 720) / 1.02
    x = canvas["x"] + canvas["width"] / 2
    y = canvas["y"] + canvas["height"] / 2 + (MARKS[1][1] - 359.5) * scale
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 5, steps=5)
    page.wait_for_timeout(PAUSE_MS)
    latencies_ms: list[float] = []
    server_ms: list[float] = []
    for event in range(events):
        page.evaluate(MEASURE, [x, y])
        before_s = server_time_s()
        page.mouse.move(x, y + (5 if event % 2 else 9))
        latencies_ms.append(page.evaluate("() => window.__measured"))
        page.wait_for_timeout(PAUSE_MS)
        server_ms.append((server_time_s() - before_s) * 1000)
    page.mouse.up()
    return latencies_ms, server_ms


def server_time_s() -> float:
    """Processor time of every thread but this one, which drives the browser."""
    return time.process_time() - time.thread_time()


if __name__ == "__main__":
    main()
