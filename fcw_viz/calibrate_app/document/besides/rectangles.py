"""Edits of the rectangles on the road: their corners, clicked in turn, and their sides."""

import math
from dataclasses import dataclass, replace

from fcw.camera.calibration import Gaussian, GroundRectangle
from fcw.camera.joint.rectangle import CORNERS, LONGEST_SIDE_M, SHORTEST_SIDE_M, going_round
from fcw.errors import UserError
from fcw_viz.calibrate_app.document.document import Document


@dataclass(frozen=True, slots=True)
class AddCorner:
    """A corner clicked, of the rectangle that still lacks one, or of a new one."""

    column_px: float
    row_px: float

    def apply(self, document: Document) -> Document:
        """The document with it; the fourth corner puts them in turn, whatever the order of the clicks.

        Raises:
            UserError: it is no place in the picture.
        """
        place = place_in_picture(document, self.column_px, self.row_px)
        rectangles = document.rectangles
        if not rectangles or len(rectangles[-1].corners_px) == CORNERS:
            rectangles = (*rectangles, GroundRectangle(()))
        corners_px = (*rectangles[-1].corners_px, place)
        if place in corners_px[:-1]:
            raise UserError("that corner is clicked already; click the next one")
        if len(corners_px) == CORNERS:
            corners_px = going_round(corners_px)
        return replace(
            document, rectangles=(*rectangles[:-1], replace(rectangles[-1], corners_px=corners_px))
        )


@dataclass(frozen=True, slots=True)
class MoveCorner:
    """A corner dragged."""

    rectangle: int
    corner: int
    column_px: float
    row_px: float

    def apply(self, document: Document) -> Document:
        """The document with the corner elsewhere.

        Raises:
            UserError: there is no such corner any more, or it is no place in the picture.
        """
        found = _rectangle(document, self.rectangle)
        if not 0 <= self.corner < len(found.corners_px):
            raise UserError("that corner is gone; it was taken back in the meantime")
        corners_px = list(found.corners_px)
        corners_px[self.corner] = place_in_picture(document, self.column_px, self.row_px)
        return _with(document, self.rectangle, replace(found, corners_px=tuple(corners_px)))


@dataclass(frozen=True, slots=True)
class SetSides:
    """The sides, typed or by a standard: from the first corner to the second, and on to the third."""

    rectangle: int
    first_side_m: Gaussian | None
    second_side_m: Gaussian | None

    def apply(self, document: Document) -> Document:
        """The document with these sides.

        Raises:
            UserError: one of them is no side.
        """
        for side in (self.first_side_m, self.second_side_m):
            if side is None:
                continue
            if not (SHORTEST_SIDE_M <= side.value <= LONGEST_SIDE_M and 0 < side.sigma < math.inf):
                raise UserError(
                    f"side {side.value:g} ± {side.sigma:g} m: expected {SHORTEST_SIDE_M:g} to "
                    f"{LONGEST_SIDE_M:g} m, and an error above 0"
                )
        found = _rectangle(document, self.rectangle)
        sides = {"first_side_m": self.first_side_m, "second_side_m": self.second_side_m}
        return _with(document, self.rectangle, replace(found, **sides))


@dataclass(frozen=True, slots=True)
class SetAlong:
    """Whether the sides lie along and across the direction of travel."""

    rectangle: int
    along: bool

    def apply(self, document: Document) -> Document:
        """The document so."""
        found = _rectangle(document, self.rectangle)
        return _with(document, self.rectangle, replace(found, along=self.along))


@dataclass(frozen=True, slots=True)
class RemoveRectangle:
    """A rectangle taken away."""

    rectangle: int

    def apply(self, document: Document) -> Document:
        """The document without it."""
        _rectangle(document, self.rectangle)
        others = (r for k, r in enumerate(document.rectangles) if k != self.rectangle)
        return replace(document, rectangles=tuple(others))


RectangleEdit = AddCorner | MoveCorner | SetSides | SetAlong | RemoveRectangle


def _rectangle(document: Document, index: int) -> GroundRectangle:
    if not 0 <= index < len(document.rectangles):
        raise UserError("that rectangle is gone; it was removed in the meantime")
    return document.rectangles[index]


def _with(document: Document, index: int, changed: GroundRectangle) -> Document:
    rectangles = (changed if k == index else r for k, r in enumerate(document.rectangles))
    return replace(document, rectangles=tuple(rectangles))


def place_in_picture(document: Document, column_px: float, row_px: float) -> tuple[float, float]:
    """The place itself where it is inside the picture, else the nearest one at its edge."""
    if not (math.isfinite(column_px) and math.isfinite(row_px)):
        raise UserError(f"place of the corner {column_px:g}, {row_px:g}: expected finite numbers")
    size = document.image_size
    return min(max(column_px, -0.5), size.width - 0.5), min(max(row_px, -0.5), size.height - 0.5)
