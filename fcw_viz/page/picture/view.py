"""The clicking surface: a picture in viser that is slid and zoomed but never tilts, with exact positions.

The picture is a plane of the scene and the camera looks at it squarely. A click's ray is met with that plane,
so a position does not depend on the window, the zoom or the screen's resolution. Columns and rows are the
project's pixels: the centre of the top-left one is (0, 0).
"""

import contextlib
import logging
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import viser
from numpy.typing import NDArray

from fcw.frame import ImageSize
from fcw_viz.page.picture.area import Area
from fcw_viz.page.picture.away import small_jpeg
from fcw_viz.page.picture.camera import PictureCamera
from fcw_viz.page.picture.handle import Handle, OnClick, OnDrag
from fcw_viz.page.picture.label_layout import Window
from fcw_viz.page.picture.magnifier import Magnifier
from fcw_viz.page.picture.plane import FACING_WXYZ, PicturePlane
from fcw_viz.page.script import run_script

_BROWSER_SIDE = "\n".join(
    Path(__file__).with_name(f"{topic}.js").read_text(encoding="utf-8")
    for topic in ("view", "away", "frames")
)
_TELL_DRAWN = Path(__file__).with_name("drawn.js").read_text(encoding="utf-8")
# From above and the right, so that the sides of a box differ where it is seen from above.
_LIGHT_FROM = (400.0, 0.0, 900.0)
_SHADE = (90, 90, 90)
_LEVEL_COSINE = 1 - 1e-12  # of half the angle between two orientations

_log = logging.getLogger(__name__)


class PictureView(PictureCamera):
    """One tab's picture, what happens on it and how it is looked at.

    Callbacks run one after the other in a thread of the view, in the order of what happened in the browser.
    """

    def __init__(self, client: viser.ClientHandle, image_size: ImageSize) -> None:
        super().__init__(client, image_size)
        self._on_click: list[Callable[[float, float], None]] = []
        self._on_view_change: list[Callable[[], None]] = []
        self._on_box: Callable[[float, float, float, float], None] | None = None
        self._draws_boxes = False
        self._handles: dict[str, Handle] = {}
        self._seen: tuple[float, ...] = ()
        self._view_change_waits = False
        self._image_bgr: NDArray[np.uint8] | None = None
        self._magnified: Handle | None = None
        self._in_order = ThreadPoolExecutor(max_workers=1, thread_name_prefix="picture")

        # Without a graphics card viser's own lights and surroundings cost seconds at the first mark.
        client.scene.configure_default_lights(False)
        client.scene.configure_environment_map(None)
        client.scene.add_light_hemisphere(
            "/light", ground_color=_SHADE, intensity=math.pi, position=_LIGHT_FROM
        )
        width, height = self.plane.extent
        self._picture = client.scene.add_image(
            "/picture",
            np.zeros((1, 1, 3), np.uint8),
            width,
            height,
            format="png",
            cast_shadow=False,
            receive_shadow=False,
            wxyz=FACING_WXYZ,
        )
        self._magnifier = Magnifier(client.scene)
        self.fit()
        run_script(client, f"{self._bounds_script()}\n{_BROWSER_SIDE}")
        client.camera.on_update(self._camera_moved)
        # viser awaits coroutines, which keeps the order; its types say None.
        client.scene.on_click()(self._clicked)  # pyright: ignore[reportArgumentType]
        client.scene.on_rect_select(modifier="shift")(self._box_drawn)  # pyright: ignore[reportArgumentType]

    def close(self) -> None:
        """Ends the view's thread; the tab is gone."""
        self._in_order.shutdown(wait=False, cancel_futures=True)

    def wait_closed(self) -> None:
        """Waits until the callback in which `close` found the view's thread has returned."""
        self._in_order.shutdown(wait=True)

    def set_size(self, image_size: ImageSize) -> None:
        """Pictures of another size from now on; shows the whole of it. Handles have to be moved anew."""
        if image_size == self.plane.size:
            return
        self.plane = PicturePlane(image_size)
        with self._client.atomic():
            self._picture.render_width, self._picture.render_height = self.plane.extent
            run_script(
                self._client,
                f"{self._bounds_script()}\nwindow.__viserMutable.setPictureBounds(halfWidth, halfHeight);",
            )
            self.fit()

    def tell_drawn(self) -> None:
        """From now on the page's channel is told `drawn` when a new picture is on the screen."""
        run_script(self._client, _TELL_DRAWN)

    def show(self, image_bgr: NDArray[np.uint8], quality: int | None = None) -> None:
        """Replaces the picture.

        Args:
            image_bgr: (height, width, 3) of the view's size.
            quality: of a JPEG, 0 to 100, for playback; None shows every pixel as it is.
        """
        if self.away:
            image_format, data = "jpeg", small_jpeg(image_bgr)
        elif quality is None:
            image_format, (_, encoded) = "png", cv2.imencode(".png", image_bgr)
            data = encoded.tobytes()
        else:
            image_format = "jpeg"
            _, encoded = cv2.imencode(".jpg", image_bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])
            data = encoded.tobytes()
        with self._client.atomic():
            self._picture._format = image_format
            self._picture._data = data
            self._image_bgr = image_bgr
            self._place_magnifier()

    @property
    def sent(self) -> bytes:
        """The picture as it was sent last; a small JPEG while the camera is away."""
        return self._picture._data

    def on_click(self, callback: Callable[[float, float], None]) -> None:
        """Calls back with (column_px, row_px) of each click inside the picture that met no handle."""
        self._on_click.append(callback)

    def on_box(self, callback: Callable[[float, float, float, float], None] | None) -> None:
        """Calls back with left, top, right and bottom of a box drawn with Shift; None zooms to it again."""
        self._on_box = callback

    def draw_boxes(self, always: bool) -> None:
        """From now on every drag draws a box, as a finger has no Shift, or again only one with Shift."""
        if always == self._draws_boxes:
            return
        self._draws_boxes = always
        if always:
            self._client.scene.on_rect_select()(self._box_drawn_bare)  # pyright: ignore[reportArgumentType]
        else:
            self._client.scene.remove_rect_select_callback(self._box_drawn_bare)

    def on_view_change(self, callback: Callable[[], None]) -> None:
        """Calls back after zooming, sliding and resizing; several changes in a row may come as one."""
        self._on_view_change.append(callback)

    def add_handle(
        self,
        name: str,
        column_px: float,
        row_px: float,
        colour: tuple[int, int, int],
        on_drag: OnDrag,
        on_click: OnClick,
    ) -> Handle:
        """A mark that can be dragged and clicked.

        Args:
            name: unique in this view.
            column_px: where it is.
            row_px: where it is.
            colour: RGB.
            on_drag: called with the phase and the mouse's position, which the mark has taken already.
            on_click: called for a click on it.
        """
        handle = Handle(self, self._client.scene, name, colour, on_drag, on_click)
        handle.move(column_px, row_px)
        self._handles[name] = handle
        return handle

    def add_area(self, name: str, on_drag: OnDrag) -> Area:
        """A box that can be dragged, nowhere yet.

        Args:
            name: unique in this view.
            on_drag: called with the phase and the mouse's position.
        """
        return Area(self, self._client.scene, name, on_drag)

    def forget_handle(self, handle: Handle) -> None:
        """Called by a handle that removes itself."""
        self._handles.pop(handle.name, None)
        if handle is self._magnified:
            self.magnify_handle(None)

    def magnify(self, name: str | None) -> None:
        """Holds the magnifier beside the handle of that name until the next click; None puts it away.

        A handle that is dragged or clicked has it without asking.
        """
        self.magnify_handle(None if name is None else self._handles.get(name))

    def magnify_handle(self, handle: Handle | None) -> None:
        """The same for a handle itself."""
        if handle is not self._magnified:
            self._magnified = handle
            self._place_magnifier()

    def handle_moved(self, handle: Handle) -> None:
        """Called by a handle that has moved: the magnifier goes with it."""
        if handle is self._magnified:
            self._place_magnifier()

    def run_in_order(self, work: Callable[..., None], *arguments: object) -> None:
        """Runs work in the view's thread after all that happened before."""

        def run() -> None:
            try:
                work(*arguments)
            except Exception:
                _log.exception("the picture's callback failed")

        # Events still arrive while a tab is closing.
        with contextlib.suppress(RuntimeError):
            self._in_order.submit(run)

    def _bounds_script(self) -> str:
        width, height = self.plane.extent
        return f"const halfWidth = {width / 2}, halfHeight = {height / 2};"

    def _place_magnifier(self) -> None:
        if self._magnified is None or self._image_bgr is None:
            self._magnifier.hide()
        else:
            window = Window(*self.window_px, self.pixels_per_screen_pixel)
            self._magnifier.show(self._image_bgr, self.plane, window, *self._magnified.position_px)

    async def _camera_moved(self, camera: viser.CameraHandle) -> None:
        seen = (*camera.position, camera.image_width, camera.image_height)
        if seen == self._seen:
            return
        resized, self._seen = seen[3:] != self._seen[3:], seen
        fitted = self.is_fitted(camera.position)
        if abs(np.dot(camera.wxyz, FACING_WXYZ)) < _LEVEL_COSINE:
            # Nothing on the picture tilts the view, but viser's own panel has buttons that do.
            camera.up_direction = (0.0, 0.0, 1.0)
            self.run_in_order(self.fit)
        elif resized and fitted:
            self.run_in_order(self.fit)
        if not self._view_change_waits:
            self._view_change_waits = True
            self.run_in_order(self._view_changed)

    def _view_changed(self) -> None:
        self._view_change_waits = False
        with self._client.atomic():
            for handle in list(self._handles.values()):
                handle.resize()
            self._place_magnifier()
        for callback in self._on_view_change:
            callback()

    async def _clicked(self, event: viser.SceneClickEvent) -> None:
        column_px, row_px = self.plane.pixel_under(np.array(event.ray_origin), np.array(event.ray_direction))
        on_glass = self._magnifier.covers(column_px, row_px)
        # What was done before may have removed the handle that is still there now.
        self.run_in_order(self._click, column_px, row_px, on_glass)

    def _click(self, column_px: float, row_px: float, on_glass: bool) -> None:
        reached = [
            (distance_px, handle)
            for handle in self._handles.values()
            if not handle.lets_click_through
            and (distance_px := handle.distance_px(column_px, row_px)) <= handle.reach_px
        ]
        if reached:
            _, clicked = min(reached, key=lambda near: near[0])
            self.magnify_handle(clicked)
            clicked.on_click()
            return
        self.magnify_handle(None)
        if self.plane.is_inside(column_px, row_px) and not on_glass:
            for callback in self._on_click:
                self.run_in_order(callback, column_px, row_px)

    async def _box_drawn(self, event: viser.SceneRectSelectEvent) -> None:
        left, top, right, bottom = self.window_px
        (x0, y0), (x1, y1) = event.screen_min, event.screen_max
        if self._on_box is not None:
            columns = sorted(left + x * (right - left) for x in (x0, x1))
            rows = sorted(top + y * (bottom - top) for y in (y0, y1))
            self.run_in_order(self._on_box, columns[0], rows[0], columns[1], rows[1])
            return
        across_px = max(x1 - x0, y1 - y0) * (right - left)
        column_px = left + (x0 + x1) / 2 * (right - left)
        row_px = top + (y0 + y1) / 2 * (bottom - top)
        self.run_in_order(self.zoom_to, column_px, row_px, across_px)

    async def _box_drawn_bare(self, event: viser.SceneRectSelectEvent) -> None:
        # viser knows its callbacks by themselves: this one is taken away, and that of Shift stays.
        await self._box_drawn(event)
