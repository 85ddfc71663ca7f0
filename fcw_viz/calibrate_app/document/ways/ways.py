"""The ways to calibrate that the first screen offers: each one is an entry of `WAYS`.

A way says what it needs, what choosing it does to the document, and which parts of the page it uses. How good
it gets is not written down: it is what the calibration itself says of a typical camera (`Way.example`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

from fcw.camera.calibration import Gaussian, GroundRectangle
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import VEHICLE_WIDTH_M, Ruler
from fcw.camera.joint.plates import OVERHANG_M, PLATE_WIDTHS_M
from fcw.camera.lens.usual import across_picture
from fcw.camera.prior_sigmas import (
    CAR_CAMERA_HEIGHT_M,
    HORIZON_ROW_SIGMA_PX,
    PRINCIPAL_ROW_SIGMA_HEIGHTS,
    UNKNOWN_FIELD_OF_VIEW_DEG,
    UNKNOWN_FIELD_OF_VIEW_SIGMA_DEG,
)
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Belief, Document, Line, Mark
from fcw_viz.calibrate_app.document.edits import ChooseWay, Edit, PlanDistances, SetPrincipalRow
from fcw_viz.calibrate_app.document.ways.height import MEASURED_SIGMA_M
from fcw_viz.calibrate_app.document.ways.presets import (
    DASH_PRESETS,
    RECTANGLE_PRESETS,
    TAPE_PRESETS,
    Preset,
    SpacedPreset,
)

TYPICAL_VIEW_RAD, TYPICAL_PITCH_RAD = math.radians(65.0), math.radians(2.0)
"""The camera of the examples."""


class Part(Enum):
    """A part of the page that a way may need."""

    POINTS = "points"
    LENS = "lens and horizon"
    RECTANGLE = "rectangle"
    PLATES = "plates"


@dataclass(frozen=True, slots=True)
class TypicalLens:
    """What a kind of camera sees along the longer side of its picture, for those who have no data sheet.

    Attributes:
        name: of the kind.
        view_rad: that field of view.
        sigma_rad: standard deviation over cameras of the kind.
    """

    name: str
    view_rad: float
    sigma_rad: float

    def across(self, size: ImageSize) -> Gaussian:
        """Its horizontal field of view in pictures of a size, which may be upright."""
        return across_picture(Gaussian(self.view_rad, self.sigma_rad), size)


TYPICAL_LENSES = (
    TypicalLens("Phone, main camera", math.radians(63), math.radians(6)),
    TypicalLens("Dash camera", math.radians(85), math.radians(15)),
    TypicalLens(
        "I do not know",
        math.radians(UNKNOWN_FIELD_OF_VIEW_DEG),
        math.radians(UNKNOWN_FIELD_OF_VIEW_SIGMA_DEG),
    ),
)
"""Beliefs: phones' main cameras are near 26 mm of 35 mm film, 69 degrees, of which video crops some."""


@dataclass(frozen=True, slots=True)
class Way:
    """A way to calibrate.

    Attributes:
        key: in the journal; never changed.
        name: what a person has.
        needs: what it takes, in one sentence.
        recorded: whether it can be done with an earlier clip.
        parts: of the page that it needs, the first one being where its work is done.
        presets: distances that come with it.
        example: what somebody with a typical camera would have said at the end.
    """

    key: str
    name: str
    needs: str
    recorded: bool
    parts: tuple[Part, ...]
    example: Callable[[ImageSize], Document]
    presets: tuple[Preset | SpacedPreset, ...] = ()

    def start(self, document: Document) -> tuple[Edit, ...]:
        """The edits that choosing it does."""
        edits: list[Edit] = [ChooseWay(self.key)]
        if document.planned_m:
            edits.append(PlanDistances(()))
        if Part.LENS in self.parts and document.principal_row is None:
            edits.append(SetPrincipalRow(middle_row(document.image_size)))
        return tuple(edits)


def middle_row(size: ImageSize) -> Belief:
    """The optical axis near the picture's middle, as in every lens of a picture that was not cropped."""
    return Belief(Gaussian((size.height - 1) / 2, PRINCIPAL_ROW_SIGMA_HEIGHTS * size.height))


def chosen_way(document: Document) -> Way | None:
    """The way of a document; one with points and none chosen is that of the taped points."""
    key = document.way or (TAPE if document.marks else "")
    return next((way for way in WAYS if way.key == key), None)


def clicks_plates(document: Document) -> bool:
    """Whether a click on the picture is of a number plate: their way is chosen."""
    way = chosen_way(document)
    return way is not None and Part.PLATES in way.parts


def clicks_corners(document: Document) -> bool:
    """Whether a click on the picture is a corner of the rectangle: its way is chosen and it lacks one."""
    way = chosen_way(document)
    whole = document.rectangles == document.whole_rectangles != ()
    return way is not None and Part.RECTANGLE in way.parts and not whole


def _typical(size: ImageSize) -> GroundPlaneCamera:
    focal_px = max(size.width, size.height) / 2 / math.tan(TYPICAL_VIEW_RAD / 2)
    return GroundPlaneCamera(
        TYPICAL_PITCH_RAD, focal_px, (size.height - 1) / 2, CAR_CAMERA_HEIGHT_M, (size.width - 1) / 2
    )


def _with_marks(*distances_m: float) -> Callable[[ImageSize], Document]:
    def example(size: ImageSize) -> Document:
        camera = _typical(size)
        marks = tuple(
            Mark(number, camera.principal_column_px, camera.row_at(distance_m), distance_m)
            for number, distance_m in enumerate(distances_m, 1)
        )
        return Document(size, marks, len(marks) + 1, height_m=CAR_CAMERA_HEIGHT_M)

    return example


def _without_marks(size: ImageSize) -> Document:
    camera = _typical(size)
    lens = TYPICAL_LENSES[0]
    return Document(
        size,
        height_m=CAR_CAMERA_HEIGHT_M,
        height_sigma_m=MEASURED_SIGMA_M,
        field_of_view=Belief(replace(lens, view_rad=TYPICAL_VIEW_RAD).across(size)),
        principal_row=middle_row(size),
        horizon=Belief(Gaussian(camera.horizon_row_px, HORIZON_ROW_SIGMA_PX)),
    )


def _of_dashes(size: ImageSize) -> Document:
    taped = _with_marks(9.0, 21.0, 33.0, 45.0)(size)
    marks = tuple(replace(mark, distance_m=12.0 * mark.id) for mark in taped.marks)
    return replace(taped, marks=marks, paced=True, height_sigma_m=MEASURED_SIGMA_M)


def _of_lane(size: ImageSize) -> Document:
    camera = _typical(size)

    def line(lateral_m: float) -> Line:
        near, far = ((camera.column_at(lateral_m, d), camera.row_at(d)) for d in (7.0, 40.0))
        return Line(near, far)

    width = Belief(Gaussian(3.5, 0.1))
    return replace(_without_marks(size), horizon=None, lane_lines=(line(1.75), line(-1.75)), lane_width=width)


def _of_rectangle(size: ImageSize) -> Document:
    """A bay by a country's rule, seen askew, and no height."""
    camera, turn = _typical(size), math.radians(25.0)
    sides_m = RECTANGLE_PRESETS[0].sides_m
    corners_px = []
    for along, across in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        x, y = along * sides_m[0].value / 2, across * sides_m[1].value / 2
        ahead_m = 9.0 + x * math.cos(turn) - y * math.sin(turn)
        left_m = x * math.sin(turn) + y * math.cos(turn)
        corners_px.append((camera.column_at(left_m, ahead_m), camera.row_at(ahead_m)))
    return Document(size, rectangles=(GroundRectangle(tuple(corners_px), *sides_m),))


def _of_speed(size: ImageSize) -> Document:
    camera, mean_mps = _typical(size), 25.0
    return replace(
        _without_marks(size),
        field_of_view=Belief(TYPICAL_LENSES[-1].across(size)),
        height_sigma_m=0.1,
        speed=Belief(Gaussian(mean_mps, 0.5)),
        scale_per_mps=camera.focal_y_px * camera.height_m / mean_mps,
    )


def _of_vehicles(size: ImageSize) -> Document:
    camera = _typical(size)
    vehicles = tuple(
        Ruler(
            camera.principal_column_px,
            camera.row_at(distance_m),
            camera.focal_y_px * VEHICLE_WIDTH_M.value / distance_m,
            VEHICLE_WIDTH_M,
            1.0,
        )
        for distance_m in (10.0, 14.0, 18.0, 22.0, 26.0, 30.0, 36.0, 42.0, 50.0, 60.0)
    )
    return replace(_without_marks(size), horizon=None, vehicles=vehicles)


def _of_plates(size: ImageSize) -> Document:
    """Three plates a hand above the bumper of cars at 8, 13 and 20 m."""
    camera, plates = _typical(size), []
    for rear_m in (8.0, 13.0, 20.0):
        plate = camera.ground_box(rear_m, 0.0, PLATE_WIDTHS_M["eu"], 0.8)
        tyre_m = rear_m + OVERHANG_M.value
        tyre = (camera.column_at(0.7, tyre_m), camera.row_at(tyre_m))
        plates.append(((plate.x, plate.y), (plate.x + plate.w, plate.y), tyre))
    return replace(
        _without_marks(size), horizon=None, height_m=None, height_sigma_m=None, plates=tuple(plates)
    )


TAPE, CLIP, DASHES, RECTANGLE, LANE = "tape", "clip", "dashes", "bay", "lane"
SPEED, VEHICLES, PLATES = "speed", "vehicles", "plates"
WAYS = (
    Way(
        CLIP,
        "A recorded clip, no tape measure",
        "The height and the kind of camera, and a stretch of straight road in the clip.",
        True,
        (Part.LENS,),
        _without_marks,
    ),
    Way(
        TAPE,
        "Points at measured distances",
        "Parked on a level street: three marks on the road ahead, one of them far away.",
        False,
        (Part.POINTS,),
        _with_marks(5.0, 10.0, 20.0),
        TAPE_PRESETS,
    ),
    Way(
        DASHES,
        "Lane dashes",
        "Three or more dashes in one picture, their spacing by the national rule, and the camera height.",
        True,
        (Part.POINTS,),
        _of_dashes,
        DASH_PRESETS,
    ),
    Way(
        LANE,
        "A lane of known width",
        "A picture of a straight road with both lane lines, the lane width, and the height and kind of "
        "camera.",
        True,
        (Part.LENS,),
        _of_lane,
    ),
    Way(
        SPEED,
        "A known speed",
        "The mean speed over a stretch of driving, from GPS, a speedometer or figures in the picture, and "
        "roughly the camera height.",
        True,
        (Part.LENS,),
        _of_speed,
    ),
    Way(
        VEHICLES,
        "Vehicles ahead",
        "A clip with five or more cars ahead, and the height and kind of camera. Cars are about 1.8 m wide.",
        True,
        (Part.LENS,),
        _of_vehicles,
    ),
    Way(
        PLATES,
        "Number plates ahead",
        "Two or more vehicles seen from behind, near and far, their country, and the kind of camera.",
        True,
        (Part.PLATES, Part.LENS),
        _of_plates,
    ),
    Way(
        RECTANGLE,
        "A rectangle of known size",
        "An empty parking bay or another painted rectangle, fully visible: its four corners and the "
        "length of a side.",
        True,
        (Part.RECTANGLE,),
        _of_rectangle,
    ),
)
"""In the order of the first screen."""
