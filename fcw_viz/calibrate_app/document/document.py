"""The input of the calibration page so far; `fcw_viz.calibrate_app.document.edits` changes it."""

from dataclasses import dataclass, replace

from fcw.camera.calibration import Gaussian, GroundPoint, GroundRectangle, Places
from fcw.camera.joint.evidence import Ruler
from fcw.camera.joint.plates import PLACES, PLATE_SIGMA_M, PLATE_WIDTHS_M
from fcw.camera.joint.rectangle import CORNERS
from fcw.camera.lens.model import Lens
from fcw.camera.prior_sigmas import TAPE_ERROR
from fcw.errors import UserError
from fcw.frame import ImageSize

FEWEST_PLATES = 2
"""A near and a far plate show the horizon and the height; a single one shows only how the two are related."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A point on the road that was clicked in a picture.

    Attributes:
        id: its number in this document, counted from 1; ids of deleted marks are not used again.
        number: number of its letter, counted from 1; those of deleted marks are used again. 0 if it equals
            the id.
        column_px: its column.
        row_px: its row.
        distance_m: distance from the reference as typed; None until it is given.
        enabled: whether it is used.
        frame: index of the picture in which it was clicked; None if unknown (points of a loaded file).
    """

    id: int
    column_px: float
    row_px: float
    distance_m: float | None = None
    enabled: bool = True
    frame: int | None = None
    number: int = 0

    @property
    def name(self) -> str:
        """Its name on the page: A, B, ... Z, AA, ..."""
        letters, number = "", self.number or self.id
        while number > 0:
            number, letter = divmod(number - 1, 26)
            letters = chr(ord("A") + letter) + letters
        return letters

    @property
    def ground_point(self) -> GroundPoint | None:
        """The point for the calibration; None while it has no distance or is switched off."""
        if self.distance_m is None or not self.enabled:
            return None
        return GroundPoint(self.distance_m, self.row_px, self.column_px)


@dataclass(frozen=True, slots=True)
class Line:
    """A straight line in the picture, given by two of its points, (column, row) each, in pixels."""

    start_px: tuple[float, float]
    end_px: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Belief:
    """A prior about the camera, which can be switched off and on again."""

    prior: Gaussian
    enabled: bool = True


@dataclass(frozen=True, slots=True)
class Document:
    """All input of the user.

    Attributes:
        image_size: size of the pictures.
        marks: the marks in the order of their ids.
        next_id: id of the next mark.
        planned_m: distances of the next marks in the order of the clicks (a preset).
        way: key of the chosen way to calibrate (`ways.WAYS`); empty until one is chosen.
        height_m: height of the camera above the road; None until it is given.
        height_sigma_m: standard deviation of the height, where it matters; None if not given.
        from_bumper: whether distances were measured from the front bumper instead of the camera.
        bumper_offset_m: distance from the camera forward to the bumper; None until it is given.
        row_sigma_px: standard deviation of a click.
        field_of_view: horizontal field of view in radians.
        principal_row: row of the optical axis.
        horizon: the row to which the user dragged the horizon.
        lane_lines: two lines along straight lane markings, which meet on the horizon.
        lane_lines_enabled: whether they are used.
        imperial: whether distances are typed and shown in feet.
        tape_error: standard deviation of all distances together, as a part of them.
        paced: whether distances count from the first mark, whose own distance is unknown, as for dashes.
        lens: imported intrinsics and distortion.
        yaw: yaw of the camera to the left of the direction of travel, in radians.
        roll: roll of the camera to the right, in radians.
        lane_width: distance between the lane lines in metres.
        vehicles: vehicles of the drive, whose widths are about known.
        speed: mean speed over the measured part of the drive, in m/s.
        edges: columns and rows along lines that are straight in the world, for the lens.
        bent: whether an unknown distortion is fitted with the rest.
        rectangles: rectangles on the road; the last one may still lack corners.
        plates: two ends and a tyre of each number plate; the last one may still lack some.
        plate_width_m: width of all plates.
        scale_per_mps: focal length times height in px m for each m/s of the speed, measured in the drive.
    """

    image_size: ImageSize
    marks: tuple[Mark, ...] = ()
    next_id: int = 1
    planned_m: tuple[float, ...] = ()
    height_m: float | None = None
    from_bumper: bool = False
    bumper_offset_m: float | None = None
    row_sigma_px: float = 1.0
    field_of_view: Belief | None = None
    principal_row: Belief | None = None
    horizon: Belief | None = None
    lane_lines: tuple[Line | None, Line | None] = (None, None)
    lane_lines_enabled: bool = True
    imperial: bool = False
    way: str = ""
    height_sigma_m: float | None = None
    tape_error: float = TAPE_ERROR
    paced: bool = False
    lens: Lens | None = None
    yaw: Belief | None = None
    roll: Belief | None = None
    lane_width: Belief | None = None
    vehicles: tuple[Ruler, ...] = ()
    speed: Belief | None = None
    scale_per_mps: float | None = None
    edges: tuple[tuple[tuple[float, float], ...], ...] = ()
    bent: bool = False
    rectangles: tuple[GroundRectangle, ...] = ()
    plates: tuple[Places, ...] = ()
    plate_width_m: Gaussian = Gaussian(PLATE_WIDTHS_M["eu"], PLATE_SIGMA_M)  # noqa: RUF009 - immutable

    def mark(self, mark_id: int) -> Mark:
        """The mark with this id.

        Raises:
            UserError: there is none; it may have been deleted in another tab.
        """
        for mark in self.marks:
            if mark.id == mark_id:
                return mark
        raise UserError("that point is gone; it was deleted in the meantime")

    @property
    def free_number(self) -> int:
        """The number of the first letter that no mark has."""
        taken = {mark.number or mark.id for mark in self.marks}
        return next(number for number in range(1, len(taken) + 2) if number not in taken)

    @property
    def whole_rectangles(self) -> tuple[GroundRectangle, ...]:
        """The rectangles with all four corners."""
        return tuple(r for r in self.rectangles if len(r.corners_px) == CORNERS)

    @property
    def whole_plates(self) -> tuple[Places, ...]:
        """The plates with both ends and a tyre."""
        return tuple(places for places in self.plates if len(places) == PLACES)

    @property
    def has_size(self) -> bool:
        """Whether a rectangle or plates give the scale, so that no height is needed."""
        sized = any(rectangle.has_size for rectangle in self.whole_rectangles)
        return sized or len(self.whole_plates) >= FEWEST_PLATES

    @property
    def reference_offset_m(self) -> float | None:
        """Distance from the camera forward to the reference of distances; None while it is not given."""
        return self.bumper_offset_m if self.from_bumper else 0.0

    @property
    def next_planned_m(self) -> float | None:
        """The planned distance of the next mark."""
        taken = {mark.distance_m for mark in self.marks}
        return next((distance_m for distance_m in self.planned_m if distance_m not in taken), None)

    def with_mark(self, changed: Mark) -> "Document":
        """This document with the mark of the same id replaced."""
        return replace(self, marks=tuple(changed if mark.id == changed.id else mark for mark in self.marks))
