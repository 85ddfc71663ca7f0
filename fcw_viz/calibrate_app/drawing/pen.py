"""Lines, rings, bands and words over a picture, in its pixels.

What keeps its size on the screen (rings, dashes, words) is scaled by the window's pixels per screen pixel.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np

from fcw.camera.straight import Straightening
from fcw.frame import ImageSize
from fcw.logs.overlay import Rgb
from fcw_viz.page.picture.label_layout import (
    LABEL_HEIGHT_CSS_PX,
    Area,
    LabelWish,
    Point,
    Window,
    text_width_css_px,
)

CROSS_GAP_CSS_PX = 2.5
"""The pixel that is marked stays free."""
CIRCLE_CORNERS = 20
FOLDED_PX, INSIDE_PX = 2.0, 40.0
BENDS = 33
"""How many points make a line that the lens bends."""
DASH_CSS_PX = 7.0
MAXIMUM_DASHES = 120
"""Zoomed far in, a dashed line over the whole picture has longer dashes rather than thousands."""
LABEL_GAP_CSS_PX = 5.0


class FillKind(Enum):
    """What an area is; each kind has its colour and opacity."""

    ROW_BAND = "row_band"
    HORIZON_BAND = "horizon_band"
    CORRIDOR = "corridor"


@dataclass(frozen=True, slots=True)
class Fill:
    """A translucent area with four corners, in turn."""

    kind: FillKind
    corners_px: tuple[Point, Point, Point, Point]


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line through points; strong ones are thicker."""

    points_px: tuple[Point, ...]
    color: Rgb
    strong: bool = False


class Pen:
    """Collects what is drawn.

    Attributes:
        size: of the picture.
        seen: the part of the picture in the window.
        fills: areas drawn so far.
        strokes: lines drawn so far.
        wishes: words wished for so far, the more important first.
        obstacles: what no words may cover.
    """

    def __init__(self, size: ImageSize, window: Window, way: Straightening | None = None) -> None:
        """`way` leads from the straight picture to the one that is drawn on; None where they are the same."""
        self.size = size
        self._way = way
        self.seen = Window(
            max(window.left_px, -0.5),
            max(window.top_px, -0.5),
            min(window.right_px, size.width - 0.5),
            min(window.bottom_px, size.height - 0.5),
            window.pixels_per_screen_pixel,
        )
        self.fills: list[Fill] = []
        self.strokes: list[Stroke] = []
        self.wishes: list[LabelWish] = []
        self.obstacles: list[Area] = []

    def css(self, length_css_px: float) -> float:
        """A length on the screen in pixels of the picture."""
        return length_css_px * self.seen.pixels_per_screen_pixel

    @property
    def left_px(self) -> float:
        """The picture's left edge."""
        return -0.5

    @property
    def right_px(self) -> float:
        """The picture's right edge."""
        return self.size.width - 0.5

    @property
    def bottom_px(self) -> float:
        """The picture's lower edge."""
        return self.size.height - 0.5

    def line(self, color: Rgb, *points: Point, strong: bool = False) -> None:
        """A line through points."""
        self.strokes.append(Stroke(points, color, strong))

    def seen_at(self, *points: Point) -> list[Point]:
        """Points of the straight picture in the one that is drawn on, as many as are in front of the lens."""
        if self._way is None:
            return list(points)
        straight = np.array(points, float)
        places = self._way.to_picture(straight)
        # Far outside of its picture a lens model folds over: what does not lead back is not seen.
        seen = np.asarray(np.isfinite(places).all(axis=1), np.bool_)
        back = self._way.to_straight(np.where(seen[:, None], places, 0.0))
        seen &= np.abs(back - straight).max(axis=1) < FOLDED_PX
        inside = np.array((self.right_px, self.bottom_px)) + INSIDE_PX
        seen &= ((places > -INSIDE_PX) & (places < inside)).all(axis=1)
        return [(float(column), float(row)) for column, row in places[seen]]

    def along(self, start: Point, end: Point) -> list[Point]:
        """A straight line of the straight picture, bent as the lens bends it."""
        if self._way is None:
            return [start, end]
        parts = np.linspace(0.0, 1.0, BENDS)
        return self.seen_at(
            *(
                (start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1]))
                for part in parts
            )
        )

    def across(self, color: Rgb, row_px: float) -> None:
        """A row of the straight picture over the whole width."""
        points = tuple(self.along((self.left_px, row_px), (self.right_px, row_px)))
        if len(points) > 1:
            self.line(color, *points)

    def dashed(self, color: Rgb, start_px: Point, end_px: Point) -> None:
        """A dashed line."""
        self.strokes += [Stroke(dash, color) for dash in _dashes(start_px, end_px, self.css(DASH_CSS_PX))]

    def ring(
        self, color: Rgb, center: Point, radius_css_px: float, strong: bool = False, dashed: bool = False
    ) -> None:
        """A circle of a size on the screen, free of words."""
        radius_px = self.css(radius_css_px)
        corners = tuple(
            (center[0] + radius_px * cosine, center[1] + radius_px * sine) for cosine, sine in _CIRCLE
        )
        if dashed:
            dashes = [corners[k : k + 2] for k in range(0, CIRCLE_CORNERS, 2)]
            self.strokes += [Stroke(dash, color, strong) for dash in dashes]
        else:
            self.strokes.append(Stroke(corners, color, strong))
        self.keep_free(center, radius_css_px)

    def cross(self, color: Rgb, center: Point, radius_css_px: float, strong: bool = False) -> None:
        """Four lines that point at a pixel and leave it free."""
        gap_px, radius_px = self.css(CROSS_GAP_CSS_PX), self.css(radius_css_px)
        column_px, row_px = center
        for right, down in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            start = (column_px + right * gap_px, row_px + down * gap_px)
            end = (column_px + right * radius_px, row_px + down * radius_px)
            self.line(color, start, end, strong=strong)

    def band(self, kind: FillKind, left_px: float, right_px: float, top_px: float, bottom_px: float) -> None:
        """A band, as much of it as lies in the picture."""
        if self._way is not None:
            self._bent_band(kind, left_px, right_px, top_px, bottom_px)
            return
        top_px, bottom_px = max(top_px, -0.5), min(bottom_px, self.bottom_px)
        if bottom_px > top_px:
            corners = ((left_px, top_px), (right_px, top_px), (right_px, bottom_px), (left_px, bottom_px))
            self.fills.append(Fill(kind, corners))

    def _bent_band(
        self, kind: FillKind, left_px: float, right_px: float, top_px: float, bottom_px: float
    ) -> None:
        columns_px = np.linspace(left_px, right_px, BENDS)
        for left, right in pairwise(columns_px.tolist()):
            corners = self.seen_at((left, top_px), (right, top_px), (right, bottom_px), (left, bottom_px))
            corners = [(column, min(max(row, -0.5), self.bottom_px)) for column, row in corners]
            if len(corners) == 4:
                self.fills.append(Fill(kind, (corners[0], corners[1], corners[2], corners[3])))

    def keep_free(self, center: Point, radius_css_px: float) -> None:
        """Let no words cover a place."""
        self.obstacles.append(Area.around(center, self.css(radius_css_px)))

    def words_beside(self, text: str, center: Point, radius_css_px: float) -> None:
        """Words to the right of a ring, above or below it or, last of all, to its left."""
        width_px = self.css(text_width_css_px(text))
        gap_px = self.css(radius_css_px + LABEL_GAP_CSS_PX)
        above_px = gap_px + self.css(LABEL_HEIGHT_CSS_PX / 2)
        right_px, left_px, middle_px = gap_px, -gap_px - width_px, -width_px / 2
        shifts = (
            # The page's own panels lie over the left.
            (right_px, 0.0),
            (right_px, -above_px),
            (right_px, above_px),
            (middle_px, -above_px),
            (middle_px, above_px),
            (left_px, 0.0),
            (left_px, -above_px),
            (left_px, above_px),
        )
        places = tuple((center[0] + right, center[1] + down) for right, down in shifts)
        self.wishes.append(LabelWish(text, places))

    def words_left_of(self, text: str, row_px: float, columns_px: Sequence[float]) -> None:
        """Words on a row that end at one of the columns."""
        width_px = self.css(text_width_css_px(text) + LABEL_GAP_CSS_PX)
        places = tuple(self.seen_at(*((column_px - width_px, row_px) for column_px in columns_px)))
        self.wishes.append(LabelWish(text, places))

    def corners(self, text: str) -> tuple[Point, ...]:
        """Places in the four corners of what is seen; the upper left, where the page has a panel, is last."""
        inside_px = self.css(LABEL_HEIGHT_CSS_PX)
        left_px = self.seen.left_px + self.css(LABEL_GAP_CSS_PX)
        right_px = self.seen.right_px - self.css(text_width_css_px(text) + LABEL_GAP_CSS_PX)
        bottom_px, top_px = self.seen.bottom_px - inside_px, self.seen.top_px + inside_px
        return (left_px, bottom_px), (right_px, bottom_px), (right_px, top_px), (left_px, top_px)

    def words_at_right(self, text: str, row_px: float) -> None:
        """Words at the right edge of what is seen, on a row or next to it."""
        left_px = self.seen.right_px - self.css(text_width_css_px(text) + LABEL_GAP_CSS_PX)
        row_px = next((row for _, row in self.seen_at((left_px, row_px))), row_px)
        rise_px = self.css(LABEL_HEIGHT_CSS_PX)
        places = tuple((left_px, row_px + shift) for shift in (0.0, -rise_px, rise_px))
        self.wishes.append(LabelWish(text, places))


def _dashes(start_px: Point, end_px: Point, dash_px: float) -> Iterator[tuple[Point, Point]]:
    """The dashes of a line, with gaps as long as they are."""
    length_px = math.dist(start_px, end_px)
    count = min(max(1, round((length_px / dash_px + 1) / 2)), MAXIMUM_DASHES)
    step = 1 / (2 * count - 1)
    columns_px, rows_px = end_px[0] - start_px[0], end_px[1] - start_px[1]
    for index in range(count):
        first, last = 2 * index * step, (2 * index + 1) * step
        yield (
            (start_px[0] + columns_px * first, start_px[1] + rows_px * first),
            (start_px[0] + columns_px * last, start_px[1] + rows_px * last),
        )


_CIRCLE = tuple(
    (math.cos(2 * math.pi * corner / CIRCLE_CORNERS), math.sin(2 * math.pi * corner / CIRCLE_CORNERS))
    for corner in range(CIRCLE_CORNERS + 1)
)
