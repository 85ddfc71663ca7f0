"""A page of the program in a real Chromium, as tests use it."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from playwright.sync_api import ConsoleMessage, Error, Page

STILL_MS = 250  # for what the server has still to say
WHEEL_NOTCH = 100
PATIENCE_S = 180  # with software rendering on a busy machine
NOTIFICATION = ".mantine-Notification-root:not(#webgl-software-rendering)"
"""The program's; viser's own on software rendering is there, and hidden."""

# The picture's mesh: what viser's image node consists of in three.js.
_FIND_PICTURE = """
  const viewer = window.__viserMutable;
  let picture = null;
  viewer?.nodeRefFromName?.["/picture"]?.traverse((node) => {
    if (node.isMesh && node.material.map) picture = picture ?? node;
  });
"""
_IS_READY = f"""() => {{
  {_FIND_PICTURE}
  if (!viewer?.cameraControl?.dollyToCursor || !(picture?.material.map.image?.width > 1)) return false;
  // Seen squarely: three's z axes of the two are in line.
  const axis = (node) => node.matrixWorld.elements.slice(8, 11);
  const [eye, normal] = [axis(viewer.camera), axis(picture)];
  return Math.abs(eye[0] * normal[0] + eye[1] * normal[1] + eye[2] * normal[2]) > 1 - 1e-9;
}}"""
# From the texture to the screen, all by three.js: nothing here knows how the program places its picture.
_SCREEN_POSITION = f"""([column, row]) => {{
  {_FIND_PICTURE}
  const {{ width, height }} = picture.geometry.parameters;
  const image = picture.material.map.image;
  const point = viewer.camera.position.clone().set(
    ((column + 0.5) / image.width - 0.5) * width, (0.5 - (row + 0.5) / image.height) * height, 0);
  picture.updateWorldMatrix(true, false);
  viewer.camera.updateMatrixWorld();
  point.applyMatrix4(picture.matrixWorld).project(viewer.camera);
  const canvas = viewer.canvas.getBoundingClientRect();
  return [canvas.left + (point.x + 1) / 2 * canvas.width, canvas.top + (1 - point.y) / 2 * canvas.height];
}}"""
_DRAW = """async () => {
  window.__viserMutable.requestRender();
  for (let frame = 0; frame < 3; frame++) await new Promise(requestAnimationFrame);
}"""
_COUNT_WHEEL = """() => {
  if (window.wheelTurned === undefined)
    window.addEventListener("wheel", (event) => (window.wheelTurned += event.deltaY), { capture: true });
  window.wheelTurned = 0;
}"""
_CAMERA = """() => {
  const { position, quaternion } = window.__viserMutable.camera;
  return [...position.toArray(), ...quaternion.toArray()];
}"""


@dataclass
class BrowserPage:
    """One tab.

    Attributes:
        page: playwright's.
        exceptions: that scripts of the page raised; a test fails on any.
        console_errors: lines of the console at level error.
    """

    page: Page
    exceptions: list[str] = field(default_factory=list)
    console_errors: list[str] = field(default_factory=list)

    def listen(self) -> None:
        """Starts to note what goes wrong in the page."""
        self.page.on("pageerror", self._raised)
        self.page.on("console", self._logged)

    def _raised(self, error: Error) -> None:
        self.exceptions.append(str(error))

    def _logged(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.console_errors.append(message.text)

    def wait_until_ready(self) -> None:
        """Waits until the picture is there and can be clicked."""
        self.page.wait_for_function(_IS_READY)
        self.wait_until_still()

    def screen_position(self, column_px: float, row_px: float) -> tuple[float, float]:
        """Where the centre of an image pixel is on the screen: CSS pixels from the page's top-left corner."""
        x, y = self.page.evaluate(_SCREEN_POSITION, [column_px, row_px])
        return x, y

    def mouse_position(self, column_px: float, row_px: float) -> tuple[int, int]:
        """The mouse position nearest to an image pixel's centre: at (x, y) it points at (x, y) + 0.5."""
        x, y = self.screen_position(column_px, row_px)
        return round(x - 0.5), round(y - 0.5)

    def click(self, column_px: float, row_px: float) -> None:
        """Clicks on the picture, where a mouse can."""
        self.page.mouse.click(*self.mouse_position(column_px, row_px))

    def drag(self, start_px: tuple[float, float], end_px: tuple[float, float], steps: int = 5) -> None:
        """Presses on an image pixel, moves and lets go on another."""
        end = self.mouse_position(*end_px)
        self.page.mouse.move(*self.mouse_position(*start_px))
        self.page.mouse.down()
        self.page.mouse.move(*end, steps=steps)
        self.page.mouse.up()

    def touch(self, *fingers: Sequence[tuple[float, float]]) -> None:
        """Touches image pixels with fingers that come one by one and leave together.

        Args:
            fingers: where each comes down and goes on to; all to equally many places.
        """
        paths = [[self.screen_position(*place_px) for place_px in finger] for finger in fingers]
        session = self.page.context.new_cdp_session(self.page)

        def tell(kind: str, places: Iterable[tuple[float, float]]) -> None:
            points = [{"id": number, "x": x, "y": y} for number, (x, y) in enumerate(places)]
            session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        for count in range(1, len(paths) + 1):
            tell("touchStart", [path[0] for path in paths[:count]])
        for step in range(1, len(paths[0])):
            tell("touchMove", [path[step] for path in paths])
        tell("touchEnd", [])
        session.detach()

    def wheel(self, column_px: float, row_px: float, notches: int) -> None:
        """Turns the wheel over an image pixel, to zoom in (out, below 0), and waits until the view rests."""
        self.page.mouse.move(*self.mouse_position(column_px, row_px))
        self.page.evaluate(_COUNT_WHEEL)
        for _ in range(abs(notches)):
            self.page.mouse.wheel(0, math.copysign(WHEEL_NOTCH, -notches))
        # The wheel is the one input that playwright does not wait for, and Chromium may sum it up.
        arrived = f"Math.abs(window.wheelTurned) >= {abs(notches) * WHEEL_NOTCH}"
        self.page.wait_for_function(arrived)
        self.wait_until_still()

    def camera(self) -> list[float]:
        """Position and orientation (x, y, z, w) of the camera in three.js."""
        return self.page.evaluate(_CAMERA)

    def draw(self) -> None:
        """Has the view drawn as it is now."""
        self.page.evaluate(_DRAW)

    def seen(self) -> bytes:
        """The window as it is now, drawn anew: a PNG file."""
        self.page.evaluate("window.isSeen = true")
        self.draw()
        png = self.page.screenshot()
        self.page.evaluate("window.isSeen = false")
        return png

    def wait_until_still(self) -> None:
        """Waits until the view has stopped moving and is drawn."""
        before = None
        while before != (before := self.camera()):
            self.page.wait_for_timeout(STILL_MS)
            self.draw()
        self.page.wait_for_timeout(STILL_MS)  # where drawing is slow, frames come after their request
