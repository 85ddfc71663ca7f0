"""Lines with words over a tab's picture."""

import math
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, Protocol

import numpy as np
import viser

from fcw.box import Box
from fcw.logs.overlay import Rgb
from fcw_viz.page.picture.label_layout import (
    LABEL_HEIGHT_CSS_PX,
    Area,
    Label,
    LabelWish,
    Point,
    Window,
    lay_out_labels,
    text_width_css_px,
)

OUTLINE_COLOR: Rgb = (12, 14, 18)
"""Under every line, so that it reads on a bright road too."""
THICKNESS_CSS_PX = {False: 1.5, True: 2.75}
"""Of a line, by whether it is strong."""
OUTLINE_CSS_PX = 0.75
"""How far the outline shows on either side of its line."""
OUTLINE_LAYER, LINE_LAYER, LABEL_LAYER = 7, 8, 9
"""Above all that a page draws on its picture otherwise, below its handles."""
LABEL_GAP_CSS_PX = 3.0


class Surface(Protocol):
    """What the overlay needs of a `PictureView`."""

    def world(self, column_px: float, row_px: float, layer: int = 0) -> tuple[float, float, float]:
        """Scene position of a pixel; higher layers are nearer to the eye."""
        ...

    @property
    def window_px(self) -> tuple[float, float, float, float]:
        """The part of the image plane that is seen: left, top, right, bottom."""
        ...

    @property
    def pixels_per_screen_pixel(self) -> float:
        """Picture pixels that a CSS pixel covers now."""
        ...

    def on_view_change(self, callback: Callable[[], None]) -> None:
        """Call back after the window has changed."""
        ...


@dataclass(frozen=True, slots=True)
class LabelledLine:
    """A line through points, with its words.

    Attributes:
        points_px: (column, row) each, in pixels of the picture.
        color: of the line.
        text: the words; empty for none.
        places: where the words may stand, the best place first.
    """

    points_px: tuple[Point, ...]
    color: Rgb
    text: str = ""
    places: "tuple[Place, ...]" = ()


class Place(NamedTuple):
    """Where words stand beside a pixel, whatever their size is at the zoom of the moment.

    Attributes:
        column_px: of the pixel.
        row_px: of the pixel.
        left: by which part of their width they begin left of it.
        down: by how many lines their middle is below it.
    """

    column_px: float
    row_px: float
    left: float
    down: float


def box_line(box: Box, color: Rgb, text: str, handles: bool = False, above: bool = True) -> LabelledLine:
    """A box with its words: above it, else below, else beside it.

    Args:
        box: in image pixels.
        color: of the box.
        text: its words.
        handles: whether it has handles, which the words leave free.
        above: whether its words belong above it; else that is their last place.
    """
    corners = (
        (box.x, box.y),
        (box.right, box.y),
        (box.right, box.bottom),
        (box.x, box.bottom),
        (box.x, box.y),
    )
    middle = (box.y + box.bottom) / 2
    places = (
        Place(box.x, box.y, 0.0, -0.5),
        Place(box.x, box.bottom, 0.0, 0.5),
        Place(box.right, box.y, 1.0, -0.5),
        Place(box.right, middle, 0.0, 0.0),
        Place(box.x, middle, 1.0, 0.0),
        Place(box.x, box.y, 0.0, -1.5),
        Place(box.x, box.bottom, 0.0, 1.5),
    )
    if handles:
        places = (*places[-2:], *places[:-2])
    if not above:
        places = tuple(sorted(places, key=lambda place: place.row_px == box.y))
    return LabelledLine(corners, color, text, places)


class LineOverlay:
    """Lines with words over one tab's picture; the words find places anew when the view changes."""

    def __init__(
        self,
        view: Surface,
        client: viser.ClientHandle,
        name: str,
        covered: Callable[[], Iterable[Area]] = tuple,
    ) -> None:
        """Draw nothing yet.

        Args:
            view: of the tab.
            client: of the tab.
            name: tells the scene nodes of several such overlays apart.
            covered: what the words must not cover.
        """
        self._view = view
        self._covered = covered
        self._client = client
        self._name = f"/lines/{name}"
        self._lock = threading.RLock()
        self._lines: tuple[LabelledLine, ...] = ()
        self._nodes: dict[int, viser.LineSegmentsHandle] = {}
        self._labels: list[viser.LabelHandle] = []
        view.on_view_change(self._place_labels)

    def show(self, lines: Sequence[LabelledLine]) -> None:
        """Draw these instead of what was drawn."""
        with self._lock, self._client.atomic():
            if not lines and not self._lines:
                return
            self._lines = tuple(lines)
            self._draw_lines()
            self._place_labels()

    def _draw_lines(self) -> None:
        ends = [
            (point, line.color)
            for line in self._lines
            for pair in zip(line.points_px, line.points_px[1:], strict=False)
            for point in pair
        ]
        colors = np.array([linear_light(color) for _, color in ends], np.uint8).reshape(-1, 2, 3)
        for layer in (OUTLINE_LAYER, LINE_LAYER):
            node = self._nodes.get(layer)
            if not ends:
                if node is not None:
                    node.visible = False
                continue
            points = np.array([self._view.world(*point, layer) for point, _ in ends], np.float32)
            points = points.reshape(-1, 2, 3)
            outline = layer == OUTLINE_LAYER
            drawn = np.full_like(colors, OUTLINE_COLOR) if outline else colors
            if node is None:
                self._nodes[layer] = self._client.scene.add_line_segments(
                    f"{self._name}/lines_{layer}",
                    points,
                    drawn,
                    thickness=THICKNESS_CSS_PX[True] + (2 * OUTLINE_CSS_PX if outline else 0.0),
                    thickness_units="screen",
                )
                continue
            node.points, node.colors, node.visible = points, drawn, True

    def _place_labels(self) -> None:
        with self._lock, self._client.atomic():
            if not self._lines and not self._labels:
                return
            window = Window(*self._view.window_px, self._view.pixels_per_screen_pixel)
            labels = lay_out_labels(
                [_wish(line, window) for line in self._lines if line.text], window, self._covered()
            )
            for index, label in enumerate(labels):
                self._set_label(index, label)
            for handle in self._labels[len(labels) :]:
                handle.visible = False

    def _set_label(self, index: int, label: Label) -> None:
        position = self._view.world(label.left_px, label.row_px, LABEL_LAYER)
        if index == len(self._labels):
            self._labels.append(
                self._client.scene.add_label(
                    f"{self._name}/label_{index}", label.text, position=position, anchor="center-left"
                )
            )
            return
        handle = self._labels[index]
        handle.text, handle.position, handle.visible = label.text, position, True


def _wish(line: LabelledLine, window: Window) -> LabelWish:
    scale = window.pixels_per_screen_pixel
    width_px, height_px = text_width_css_px(line.text) * scale, LABEL_HEIGHT_CSS_PX * scale
    gap_px = LABEL_GAP_CSS_PX * scale
    places_px: list[Point] = []
    for place in line.places:
        left_px = place.column_px - place.left * width_px
        if place.down == 0:  # beside the pixel
            left_px += gap_px if place.left == 0 else -gap_px
        down_px = place.down * height_px + math.copysign(gap_px, place.down) * (place.down != 0)
        places_px.append((left_px, place.row_px + down_px))
    return LabelWish(line.text, tuple(places_px))


@cache
def linear_light(color: Rgb) -> Rgb:
    """A colour as viser wants it at the ends of lines: proportional to light, not encoded as sRGB."""
    red, green, blue = (
        round(255 * (value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4))
        for value in (channel / 255 for channel in color)
    )
    return red, green, blue
