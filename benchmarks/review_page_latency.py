"""How soon the review page shows what is asked for, in a real Chromium.

    python benchmarks/review_page_latency.py DRIVE.mcap [--hours 1] [--seeks 60]

The page serves a log of an hour, made by repeating a drive, in a process of its own. A seek's clock starts
when the browser gets the mouse event on the time line (its own time stamp) and stops at the end of the first
frame that shows another picture: when the graphics process has drawn it. The server's share is the processor
time of all its threads, and so no less than the time that it adds. For playback a drive is made whose
pictures carry their number: what is seen is compared with where the time line stands, and with the clock.
"""

import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import numpy as np
from chromium import WINDOW, chromium, option_parser
from lines import median_and_p95
from playwright.sync_api import Browser, Page

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import Frame, ImageSize
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.versions import machine
from fcw.warning.types import WarningLevel, WarningState

PORT = 8600
READY_MS = 90_000
REST_MS = 700
"""Between seeks: longer than the frames that follow every change by themselves."""
PLAYED = ImageSize(1280, 720)
PLAYED_RATE_HZ, PLAYED_S, WATCHED_S = 30, 40, 20
CODE_BITS, CODE_PX = 12, 24
ARRIVAL = """
  const started = setInterval(() => {
    const viewer = window.__viserMutable;
    window.readyAt ??= viewer?.cameraControl?.dollyToCursor ? performance.now() : undefined;
    let image = null;
    viewer?.nodeRefFromName?.["/picture"]?.traverse((node) => {
      if (node.isMesh && node.material.map) image = image ?? node.material.map.image;
    });
    if (!(image?.width > 1)) return;
    window.firstPictureAt = performance.now();
    clearInterval(started);
  }, 5);
"""
PROBE = """() => {
  const viewer = window.__viserMutable, before = viewer.scene.onAfterRender;
  let last = null, clickedAt = null, done = null;
  const texture = () => {
    let found = null;
    viewer.nodeRefFromName["/picture"].traverse((node) => {
      if (node.isMesh && node.material.map) found = found ?? node.material.map;
    });
    return found;
  };
  last = texture();
  window.addEventListener("pointerdown", (event) => (clickedAt = event.timeStamp), { capture: true });
  viewer.scene.onAfterRender = (renderer, ...rest) => {
    before(renderer, ...rest);
    const now = texture();
    if (now === last) return;
    last = now;
    window.__onPicture?.(now.image);
    if (!done || clickedAt === null) return;
    const gl = renderer.getContext(), fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const resolve = done, start = clickedAt;
    done = clickedAt = null;
    const look = () => {
      if (gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED) resolve(performance.now() - start);
      else setTimeout(look, 1);
    };
    look();
  };
  window.__arm = () => { clickedAt = null; window.__measured = new Promise((resolve) => (done = resolve)); };
}"""
WATCH = f"""() => {{
  const canvas = new OffscreenCanvas({CODE_BITS * CODE_PX}, {CODE_PX});
  const context = canvas.getContext("2d", {{ willReadFrequently: true }});
  window.__seen = [];
  window.__onPicture = (image) => {{
    const at = performance.now();
    context.drawImage(image, {CODE_BITS * CODE_PX} - image.width, {CODE_PX} - image.height);
    let number = 0;
    for (let bit = 0; bit < {CODE_BITS}; bit++) {{
      const [red] = context.getImageData(bit * {CODE_PX} + {CODE_PX // 2}, {CODE_PX // 2}, 1, 1).data;
      if (red > 128) number += 1 << bit;
    }}
    window.__seen.push([at, number, Number(document.querySelector(".fcw-clock").dataset.row)]);
  }};
}}"""


@dataclass(frozen=True, slots=True)
class Server:
    """`fcw review` in a process of its own."""

    url: str
    pid: int

    def processor_s(self) -> float:
        """Processor time of all its threads so far."""
        fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def largest_memory_mb(self) -> float:
        """The most memory it has had."""
        status = Path(f"/proc/{self.pid}/status").read_text()
        return next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")) / 1000


@contextmanager
def serving(log: Path) -> Iterator[Server]:
    """The page of a log, until the context ends."""
    command = [sys.executable, "-m", "fcw_viz.cli", "review", str(log), "--no-open", "--port", str(PORT)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        url = next(line.split(" at ")[1].split()[0] for line in process.stdout if "http://" in line)
        try:
            yield Server(url, process.pid)
        finally:
            process.terminate()


def repeat(drive: Path, out: Path, hours: float) -> DriveLog:
    """A log of that length, of the same drive in a loop."""
    log = DriveLog(drive)
    entries = list(log.entries())
    span_ns = entries[-1][0].time_ns - entries[0][0].time_ns + round(1e9 / log.header.frame_rate_hz)
    sink = McapSink(out)
    sink.open(log.header)
    for lap in range(int(np.ceil(hours * 3600e9 / span_ns))):
        for result, packets in entries:
            index, moved_ns = lap * len(entries) + result.index, lap * span_ns
            # Packets that only feed the decoder before the first frame would run into the lap before.
            own = packets if lap == 0 or packets[0].keyframe else packets[-1:]
            sink.write(
                replace(result, index=index, time_ns=result.time_ns + moved_ns),
                tuple(replace(packet, time_ns=packet.time_ns + moved_ns) for packet in own),
            )
    sink.close()
    return DriveLog(out)


def make_numbered(out: Path) -> None:
    """A drive whose pictures carry their number at the lower right, over a moving pattern."""
    camera = GroundPlaneCamera(0.03, 1000.0, 359.5, 1.3, 639.5)
    header = DriveHeader(
        "made", PLAYED, PLAYED_RATE_HZ, Calibration.from_camera(camera, PLAYED), False, "none", "", {}
    )
    sink, encoder = McapSink(out), VideoEncoder(PLAYED, PLAYED_RATE_HZ)
    sink.open(header)
    noise = np.random.default_rng(0).integers(60, 190, (90, 160, 3), np.uint8)
    ground = np.kron(noise, np.ones((8, 8, 1), np.uint8))
    for index in range(PLAYED_S * PLAYED_RATE_HZ):
        image = np.roll(ground, 3 * index, axis=1)
        for bit in range(CODE_BITS):
            left = PLAYED.width - (CODE_BITS - bit) * CODE_PX
            image[-CODE_PX:, left : left + CODE_PX] = 235 if index >> bit & 1 else 16
        time_ns = index * 1_000_000_000 // PLAYED_RATE_HZ
        result = FrameResult(index, time_ns, (), (), None, WarningState(WarningLevel.NONE), None)
        sink.write(result, encoder.encode(Frame(index, time_ns, image)))
    encoder.close()
    sink.close()


def open_page(browser: Browser, server: Server) -> Page:
    """A tab whose first picture is there."""
    page = browser.new_page(viewport=WINDOW)
    page.add_init_script(ARRIVAL)
    page.goto(f"{server.url}/?fixedDpr=1")
    page.wait_for_function("window.firstPictureAt", timeout=READY_MS)
    page.wait_for_selector("#fcw-whole")
    page.wait_for_timeout(2000)
    page.evaluate(PROBE)
    return page


def seek(page: Page, server: Server, count: int) -> tuple[list[float], list[float]]:
    """Time to the picture and the server's processor time of random seeks, in ms."""
    box = page.locator("#fcw-whole").bounding_box()
    assert box is not None
    chance = random.Random(0)
    shown_ms: list[float] = []
    server_ms: list[float] = []
    for _ in range(count):
        page.evaluate("() => window.__arm()")
        before_s = server.processor_s()
        page.mouse.click(box["x"] + chance.random() * box["width"], box["y"] + 10)
        shown_ms.append(page.evaluate("() => window.__measured"))
        page.wait_for_timeout(REST_MS)
        server_ms.append((server.processor_s() - before_s) * 1000)
    return shown_ms, server_ms


def watch(page: Page) -> np.ndarray:
    """What is seen while it plays: (N, 3) of time in ms, number of the picture, row of the time line."""
    page.evaluate(WATCH)
    page.keyboard.press("Space")
    page.wait_for_timeout(WATCHED_S * 1000)
    page.keyboard.press("Space")
    return np.array(page.evaluate("window.__seen"))


def main() -> None:
    """Measure, and print what was measured."""
    parser = option_parser(__doc__)
    parser.add_argument("drive", type=Path, help="log that is repeated")
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--seeks", type=int, default=60)
    options = parser.parse_args()
    say = sys.stdout.write
    say(f"{datetime.now(UTC):%Y-%m-%d}, {machine()}, viser {version('viser')}\n")
    say(f"Chromium with software rendering, {WINDOW['width']}x{WINDOW['height']}\n")
    with tempfile.TemporaryDirectory() as folder, chromium(options) as browser:
        long = Path(folder) / "drive.mcap"
        log = repeat(options.drive, long, options.hours)
        say(
            f"log of {log.series().duration_s / 3600:.2f} h, {len(log.series())} frames of "
            f"{log.header.image_size}, {long.stat().st_size / 1e6:.0f} MB\n"
        )
        started_s = time.monotonic()
        with serving(long) as server:
            say(f"command to address: {time.monotonic() - started_s:.1f} s\n")
            page = open_page(browser, server)
            ready_ms, first_ms = page.evaluate("[window.readyAt, window.firstPictureAt]")
            say(
                f"page ready to first picture: {first_ms - ready_ms:.0f} ms "
                f"({first_ms:.0f} ms after the address)\n"
            )
            shown_ms, server_ms = seek(page, server, options.seeks)
            say(f"random seek, mouse to picture: {median_and_p95(shown_ms)} of {options.seeks}\n")
            say(f"of it the server's processor time, plots and panel included: {median_and_p95(server_ms)}\n")
            say(f"server's memory at most: {server.largest_memory_mb():.0f} MB\n")
            page.close()
        long.unlink()
        make_numbered(long)
        with serving(long) as server:
            page = open_page(browser, server)
            seen = watch(page)
            page.close()
    apart_ms = np.abs(seen[:, 1] - seen[:, 2]) / PLAYED_RATE_HZ * 1000
    drive_ms = seen[:, 1] / PLAYED_RATE_HZ * 1000
    late_ms = (seen[:, 0] - seen[0, 0]) - (drive_ms - drive_ms[0])
    say(
        f"playback of {PLAYED} at {PLAYED_RATE_HZ}/s and 1x for {WATCHED_S} s: "
        f"{len(seen) / WATCHED_S:.1f} pictures a second\n"
        f"picture and time line apart: median {np.median(apart_ms):.0f} ms, at most {apart_ms.max():.0f} ms\n"
        f"behind the clock, beside the first picture: median {np.median(late_ms):.0f} ms, at most "
        f"{late_ms.max():.0f} ms; at the end {late_ms[-10:].mean():.0f} ms\n"
    )


if __name__ == "__main__":
    main()
