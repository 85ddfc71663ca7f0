"""What memory a review page keeps once its tabs are closed.

    python benchmarks/review/closed_tabs.py DRIVE.mcap [--tabs 40] [--rounds 5]

First one tab comes and goes: what it loads stays. Then, in each round, so many tabs come at once, each
shows the drive's picture and its road from above, and all go.
A tab is a web socket that takes what it is sent: no browser is needed to see what the server keeps.
"""

import argparse
import asyncio
import sys
import time
from pathlib import Path

import msgspec
import viser
import websockets

from fcw_viz.page.tidying import LATER_S, PAUSE_S
from fcw_viz.review_app.server import ReviewPage

PORT = 8640
SHOWN_S = 10.0
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.0, 0.0, -1.0],
    "fov": 0.5,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 600,
    "image_width": 1000,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, -1.0, 0.0],
}


def memory_mb() -> float:
    """What this process has of the machine's memory."""
    status = Path("/proc/self/status").read_text()
    return next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmRSS")) / 1000


def os_threads() -> int:
    """Of this process."""
    return len(list(Path("/proc/self/task").iterdir()))


async def one_tab(page: ReviewPage, closing: asyncio.Event) -> None:
    """A tab, until all are closed."""
    async with websockets.connect(
        page.url.replace("http", "ws"),
        subprotocols=[websockets.Subprotocol(f"viser-v{viser.__version__}")],
        origin=websockets.Origin(f"http://127.0.0.1:{page.port}"),
        max_size=None,
        open_timeout=None,
    ) as socket:
        await socket.send(msgspec.msgpack.encode(CAMERA))
        took = asyncio.create_task(_take(socket))
        await closing.wait()
        took.cancel()


async def _take(socket: websockets.ClientConnection) -> None:
    async for _ in socket:
        pass


async def come_and_go(page: ReviewPage, tabs: int) -> float:
    """A round; gives the memory while all tabs are open."""
    closing = asyncio.Event()
    people = [asyncio.create_task(one_tab(page, closing)) for _ in range(tabs)]
    while len(page.tabs) < tabs:
        await asyncio.sleep(0.1)
    for tab in page.tabs:
        tab.run(lambda desk=tab._desk: desk.open_at("drive@0"))  # pyright: ignore[reportAttributeAccessIssue]
        tab.run(lambda desk=tab._desk: desk.screen.switch_birds_eye())  # pyright: ignore[reportAttributeAccessIssue]
    await asyncio.sleep(SHOWN_S)
    largest_mb = memory_mb()
    closing.set()
    await asyncio.gather(*people)
    while page.tabs:
        await asyncio.sleep(0.1)
    return largest_mb


def main() -> None:
    """Read the command line and print the memory after each round."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else None)
    parser.add_argument("log", type=Path, metavar="DRIVE.mcap")
    parser.add_argument("--tabs", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    page = ReviewPage({"drive": options.log}, "benchmark", "anna", PORT)
    try:
        sys.stdout.write(f"before: {memory_mb():.0f} MB, {os_threads()} threads\n")
        come = 0
        for tabs in (1, *[options.tabs] * options.rounds):
            open_mb = asyncio.run(come_and_go(page, tabs))
            time.sleep(2 * (PAUSE_S + LATER_S))
            come += tabs
            held = f"{memory_mb():.0f} MB ({open_mb:.0f} while open), {os_threads()} threads"
            sys.stdout.write(f"after {come} tabs: {held}\n")
            sys.stdout.flush()
    finally:
        page.stop()


if __name__ == "__main__":
    main()
