"""Marks on the picture that can be dragged: a ring with a cross-hair that leaves its pixel free."""

import math
from collections.abc import Callable
from typing import Literal, Protocol

import numpy as np
import viser

from fcw_viz.page.picture.plane import PicturePlane, layer_offset

Phase = Literal["start", "update", "end"]
OnDrag = Callable[[Phase, float, float], None]
OnClick = Callable[[], None]

HANDLE_LAYER = 12
"""Layer that handles are drawn in, above all that is drawn on the picture."""

# Lengths in CSS pixels.
_REACH = 14.0  # comfortable for a mouse, enough for a finger
_RING_RADIUS = 9.0
_TICKS = (4.0, 14.0)
_COLOUR_THICKNESS = 2.0
_HALO_THICKNESS = 4.5
_HALO = (20, 20, 20)  # seen on a bright road where the colour is not


def _ring(radius: float, count: int = 40) -> np.ndarray:
    angles = np.linspace(0, 2 * math.pi, count + 1)
    return radius * np.stack([np.cos(angles), np.zeros_like(angles), np.sin(angles)], axis=1)


def _shape(hollow: bool) -> np.ndarray:
    ring = _ring(_RING_RADIUS)
    circle = np.stack([ring[:-1], ring[1:]], axis=1)
    directions = np.array([[1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, -1]], float)
    ticks = np.stack([directions * _TICKS[0], directions * _TICKS[1]], axis=1)
    return (circle if hollow else np.concatenate([circle, ticks])).astype(np.float32)


_SHAPES = {hollow: _shape(hollow) for hollow in (False, True)}


class HandleSurface(Protocol):
    """What a handle needs of the view that it stands on.

    Attributes:
        plane: where pixels are in the scene.
    """

    plane: PicturePlane

    @property
    def pixels_per_screen_pixel(self) -> float:
        """Image pixels that a CSS pixel covers now."""
        ...

    def run_in_order(self, work: Callable[..., None], *arguments: object) -> None:
        """Run work in the view's thread."""
        ...

    def handle_moved(self, handle: "Handle") -> None:
        """Hear that a handle is elsewhere."""
        ...

    def magnify_handle(self, handle: "Handle | None") -> None:
        """Hold the magnifier beside a handle; None puts it away."""
        ...

    def forget_handle(self, handle: "Handle") -> None:
        """Hear that a handle is gone."""
        ...


class Handle:
    """A mark that can be dragged; made by `PictureView.add_handle`.

    Attributes:
        name: unique in its view.
        on_click: called for a click on it.
        lets_click_through: whether a click on it is one on the picture instead.
    """

    def __init__(
        self,
        view: HandleSurface,
        scene: viser.SceneApi,
        name: str,
        colour: tuple[int, int, int],
        on_drag: OnDrag,
        on_click: OnClick,
    ) -> None:
        self.name = name
        self.on_click = on_click
        self.lets_click_through = False
        self._view = view
        self._on_drag = on_drag
        self._column_px = self._row_px = 0.0
        self._dragged_to: tuple[float, float] | None = None
        self._hollow = False
        rim = _ring(_REACH, 16)[:-1]
        corners = np.arange(len(rim))
        # Behind the picture it is hit all the same, and hides nothing drawn on it.
        self._target = scene.add_mesh_simple(
            f"/handles/{name}",
            np.concatenate([rim, np.zeros((1, 3))]),
            np.stack([corners, np.roll(corners, -1), np.full_like(corners, len(rim))], axis=1),
            opacity=0.0,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

        def lines(
            part: str, colour: tuple[int, int, int], thickness: float, layer: int
        ) -> viser.LineSegmentsHandle:
            return scene.add_line_segments(
                f"/handles/{name}/{part}",
                _SHAPES[False],
                colour,
                thickness=thickness,
                thickness_units="screen",
                position=layer_offset(layer),
            )

        self._halo = lines("halo", _HALO, _HALO_THICKNESS, HANDLE_LAYER + 1)
        self._lines = lines("lines", colour, _COLOUR_THICKNESS, HANDLE_LAYER + 2)
        self._target.on_drag("left")(self._dragged)
        self.resize()

    @property
    def position_px(self) -> tuple[float, float]:
        """Where it is: column, row."""
        return self._column_px, self._row_px

    @property
    def reach_px(self) -> float:
        """How near a click must be to be meant for it, in image pixels at the present zoom."""
        return _REACH * self._view.pixels_per_screen_pixel

    def distance_px(self, column_px: float, row_px: float) -> float:
        """How far it is from a pixel."""
        return math.hypot(column_px - self._column_px, row_px - self._row_px)

    def move(self, column_px: float, row_px: float) -> None:
        """Puts it elsewhere."""
        self._column_px, self._row_px = column_px, row_px
        self._target.position = self._view.plane.world(column_px, row_px, layer=-1)
        self._view.handle_moved(self)

    def set_colour(self, colour: tuple[int, int, int]) -> None:
        """Draws it in another RGB colour."""
        self._lines.colors = np.array(colour, np.uint8)

    def set_hollow(self, hollow: bool) -> None:
        """Draws it as a ring without its cross-hair: it is there, and does not count."""
        if hollow != self._hollow:
            self._hollow = hollow
            self._halo.points = self._lines.points = _SHAPES[hollow]

    def resize(self) -> None:
        """Keeps its size on the screen after a change of zoom; the view calls it."""
        scale = self._view.pixels_per_screen_pixel * self._view.plane.scale
        self._target.scale = self._halo.scale = self._lines.scale = scale

    def remove(self) -> None:
        """Takes it off the picture."""
        self._view.forget_handle(self)
        self._target.remove()

    async def _dragged(self, event: viser.SceneNodeDragEvent[viser.MeshHandle]) -> None:
        if event.phase == "start":
            # Nothing has moved yet, and viser's start lies half a screen pixel beside the mouse.
            self._view.run_in_order(self._on_drag, "start", *self.position_px)
            return
        eye = event.client.camera.position
        at_px = self._view.plane.pixel_under(eye, np.array(event.end_position) - eye)
        if event.phase == "end":
            self._dragged_to = None
            self._view.run_in_order(self._follow, "end", *at_px)
            return
        # Where the callbacks are slower than the mouse, only its last position counts.
        waits = self._dragged_to is not None
        self._dragged_to = at_px
        if not waits:
            self._view.run_in_order(self._catch_up)

    def _catch_up(self) -> None:
        at_px, self._dragged_to = self._dragged_to, None
        # The browser tells one move of the mouse more than once.
        if at_px is not None and at_px != self.position_px:
            self._follow("update", *at_px)

    def _follow(self, phase: Phase, column_px: float, row_px: float) -> None:
        self.move(column_px, row_px)
        self._view.magnify_handle(None if phase == "end" else self)
        self._on_drag(phase, column_px, row_px)
