"""The edits that change a document.

A document is immutable, and an edit is a value. A document is the result of its edits on an empty one, so the
journal of edits is the whole state (`document.history`), and undo replays fewer edits.
"""

import math
from dataclasses import dataclass, replace

from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.besides.knowledge import Knowledge
from fcw_viz.calibrate_app.document.besides.plates import PlateEdit
from fcw_viz.calibrate_app.document.besides.rectangles import RectangleEdit
from fcw_viz.calibrate_app.document.document import Belief, Document, Line, Mark

EDGE_PX = 0.5
"""Pixel centres are at whole numbers, so the picture extends half a pixel beyond the first and the last."""


@dataclass(frozen=True, slots=True)
class AddMark:
    """A click on the picture; the mark gets the next planned distance, if there is one."""

    column_px: float
    row_px: float
    frame: int | None = None
    distance_m: float | None = None

    def apply(self, document: Document) -> Document:
        """The document with one more mark.

        Raises:
            UserError: the click is outside the picture, or the distance is not one.
        """
        _check_finite("place of the click", self.column_px, self.row_px)
        if (self.column_px, self.row_px) != _inside(document.image_size, self.column_px, self.row_px):
            raise UserError(
                f"a click at column {self.column_px:g}, row {self.row_px:g} is outside the picture of "
                f"{document.image_size}; click on the road in the picture"
            )
        if self.distance_m is not None:
            _check_positive("distance", self.distance_m, "metres along the road to the mark")
        distance_m = document.next_planned_m if self.distance_m is None else self.distance_m
        number = document.free_number
        mark = Mark(
            document.next_id, self.column_px, self.row_px, distance_m, frame=self.frame, number=number
        )
        return replace(document, marks=(*document.marks, mark), next_id=document.next_id + 1)


@dataclass(frozen=True, slots=True)
class MoveMark:
    """A mark dragged or nudged; it stays within the picture."""

    id: int
    column_px: float
    row_px: float

    def apply(self, document: Document) -> Document:
        """The document with the mark moved.

        Raises:
            UserError: the place is not finite.
        """
        _check_finite("place of the point", self.column_px, self.row_px)
        column_px, row_px = _inside(document.image_size, self.column_px, self.row_px)
        return document.with_mark(replace(document.mark(self.id), column_px=column_px, row_px=row_px))


@dataclass(frozen=True, slots=True)
class SetDistance:
    """The typed distance of a mark from the reference; None removes it."""

    id: int
    distance_m: float | None

    def apply(self, document: Document) -> Document:
        """The document with this distance.

        Raises:
            UserError: it is not a valid distance.
        """
        if self.distance_m is not None:
            _check_positive("distance", self.distance_m, "metres along the road to the mark")
        return document.with_mark(replace(document.mark(self.id), distance_m=self.distance_m))


@dataclass(frozen=True, slots=True)
class EnableMark:
    """A mark switched on or off."""

    id: int
    enabled: bool

    def apply(self, document: Document) -> Document:
        """The document with the mark switched."""
        return document.with_mark(replace(document.mark(self.id), enabled=self.enabled))


@dataclass(frozen=True, slots=True)
class DeleteMark:
    """A mark deleted."""

    id: int

    def apply(self, document: Document) -> Document:
        """The document without the mark."""
        gone = document.mark(self.id)
        return replace(document, marks=tuple(mark for mark in document.marks if mark is not gone))


@dataclass(frozen=True, slots=True)
class PlanDistances:
    """Distances for the next marks; marks without one get theirs at once, the nearest first."""

    planned_m: tuple[float, ...]

    def apply(self, document: Document) -> Document:
        """The document with the plan, and with its distances given to the marks without one.

        Raises:
            UserError: one of them is not a valid distance.
        """
        for distance_m in self.planned_m:
            _check_positive("distance", distance_m, "metres along the road to the mark")
        document = replace(document, planned_m=self.planned_m)
        for mark in sorted(document.marks, key=lambda mark: -mark.row_px):
            if mark.distance_m is None:
                document = document.with_mark(replace(mark, distance_m=document.next_planned_m))
        return document


@dataclass(frozen=True, slots=True)
class SetHeight:
    """The height of the camera above the road and, where it matters, its standard deviation."""

    height_m: float | None
    sigma_m: float | None = None

    def apply(self, document: Document) -> Document:
        """The document with this height.

        Raises:
            UserError: the height or its standard deviation is not valid.
        """
        if self.height_m is not None:
            _check_positive("camera height", self.height_m, "metres from the road up to the lens")
        if self.sigma_m is not None:
            _check_positive("error of the height", self.sigma_m, "metres, standard deviation")
        return replace(document, height_m=self.height_m, height_sigma_m=self.sigma_m)


@dataclass(frozen=True, slots=True)
class ChooseWay:
    """The chosen way to calibrate, by its key; empty goes back to the choice."""

    way: str

    def apply(self, document: Document) -> Document:
        """The document with this way."""
        return replace(document, way=self.way)


@dataclass(frozen=True, slots=True)
class SetReference:
    """Where distances were measured from."""

    from_bumper: bool
    bumper_offset_m: float | None = None

    def apply(self, document: Document) -> Document:
        """The document with this reference.

        Raises:
            UserError: the offset is not valid.
        """
        offset_m = self.bumper_offset_m
        if offset_m is not None and not (math.isfinite(offset_m) and offset_m >= 0):
            raise UserError(
                f"offset {offset_m:g} m: expected 0 or more, metres from the camera forward to the bumper"
            )
        return replace(document, from_bumper=self.from_bumper, bumper_offset_m=offset_m)


@dataclass(frozen=True, slots=True)
class SetRowSigma:
    """How precise the clicks are."""

    row_sigma_px: float

    def apply(self, document: Document) -> Document:
        """The document with this error of a click.

        Raises:
            UserError: it is not above 0.
        """
        _check_positive("click error", self.row_sigma_px, "pixels, standard deviation")
        return replace(document, row_sigma_px=self.row_sigma_px)


@dataclass(frozen=True, slots=True)
class SetFieldOfView:
    """The horizontal field of view in radians, from the data sheet of the lens."""

    belief: Belief | None

    def apply(self, document: Document) -> Document:
        """The document with this prior.

        Raises:
            UserError: its value or its standard deviation is not valid.
        """
        _check_belief("field of view", self.belief, math.pi)
        return replace(document, field_of_view=self.belief)


@dataclass(frozen=True, slots=True)
class SetPrincipalRow:
    """The row of the optical axis."""

    belief: Belief | None

    def apply(self, document: Document) -> Document:
        """The document with this prior.

        Raises:
            UserError: its value or its standard deviation is not valid.
        """
        _check_belief("lens axis", self.belief)
        return replace(document, principal_row=self.belief)


@dataclass(frozen=True, slots=True)
class SetHorizon:
    """The row to which the horizon was dragged."""

    belief: Belief | None

    def apply(self, document: Document) -> Document:
        """The document with this prior.

        Raises:
            UserError: its value or its standard deviation is not valid.
        """
        _check_belief("horizon", self.belief)
        return replace(document, horizon=self.belief)


@dataclass(frozen=True, slots=True)
class SetLaneLine:
    """One of the two lane lines (0 or 1) drawn or moved; None deletes it."""

    index: int
    line: Line | None

    def apply(self, document: Document) -> Document:
        """The document with this line.

        Raises:
            UserError: there is no lane line with this index, or its ends are equal or not finite.
        """
        if self.index not in (0, 1):
            raise UserError(f"lane line {self.index}: expected 0 or 1, the two markings of a lane")
        if self.line is not None:
            _check_finite("end of a lane line", *self.line.start_px, *self.line.end_px)
            if self.line.start_px == self.line.end_px:
                raise UserError("both ends of the lane line are at the same place; draw it along the marking")
        first, second = document.lane_lines
        return replace(document, lane_lines=(self.line, second) if self.index == 0 else (first, self.line))


@dataclass(frozen=True, slots=True)
class EnableLaneLines:
    """The crossing of the lane lines switched on or off as a prior of the horizon."""

    enabled: bool

    def apply(self, document: Document) -> Document:
        """The document with the lane lines switched."""
        return replace(document, lane_lines_enabled=self.enabled)


@dataclass(frozen=True, slots=True)
class SetUnits:
    """Feet or metres."""

    imperial: bool

    def apply(self, document: Document) -> Document:
        """The document with these units; stored values stay in metres."""
        return replace(document, imperial=self.imperial)


@dataclass(frozen=True, slots=True)
class Load:
    """Everything replaced, by the content of a file or by an empty document."""

    document: Document

    def apply(self, document: Document) -> Document:
        """The new document.

        Raises:
            UserError: it is for pictures of another size.
        """
        if self.document.image_size != document.image_size:
            raise UserError(
                f"these points were clicked in pictures of {self.document.image_size}, the pictures here are "
                f"{document.image_size}; open the drive that they were clicked in"
            )
        return self.document


Edit = (
    AddMark
    | MoveMark
    | SetDistance
    | EnableMark
    | DeleteMark
    | PlanDistances
    | ChooseWay
    | SetHeight
    | SetReference
    | SetRowSigma
    | SetFieldOfView
    | SetPrincipalRow
    | SetHorizon
    | SetLaneLine
    | EnableLaneLines
    | SetUnits
    | Load
    | Knowledge
    | RectangleEdit
    | PlateEdit
)


def _check_positive(name: str, value: float, meaning: str) -> None:
    if not (math.isfinite(value) and value > 0):
        raise UserError(f"{name} {value:g}: expected a number above 0, {meaning}")


def _check_finite(name: str, *values: float) -> None:
    if not all(map(math.isfinite, values)):
        raise UserError(f"{name} {', '.join(f'{value:g}' for value in values)}: expected finite numbers")


def _check_belief(name: str, belief: Belief | None, limit: float = math.inf) -> None:
    if belief is None:
        return
    _check_finite(name, belief.prior.value)
    _check_positive(f"uncertainty of the {name}", belief.prior.sigma, "its standard deviation")
    if limit < math.inf and not 0 < belief.prior.value < limit:
        raise UserError(
            f"{name} {math.degrees(belief.prior.value):g} degrees: expected more than 0 and less than "
            f"{math.degrees(limit):g}"
        )


def _inside(size: ImageSize, column_px: float, row_px: float) -> tuple[float, float]:
    """The place itself if it is inside the picture, else the nearest place on its edge."""
    column_px = min(max(column_px, -EDGE_PX), size.width - EDGE_PX)
    return column_px, min(max(row_px, -EDGE_PX), size.height - EDGE_PX)
