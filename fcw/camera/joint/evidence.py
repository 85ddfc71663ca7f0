"""What is known of the road in a picture."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from fcw.camera.calibration import Gaussian, GroundPoint, GroundRectangle, NumberPlate, Places
from fcw.camera.vanishing import Segment

VEHICLE_WIDTH_M = Gaussian(1.8, 0.16)
"""Of passenger cars, vans among them, with what a box adds and takes."""
CAR_HEIGHT_M = Gaussian(1.5, 0.15)
"""Of passenger cars, likewise."""
CAR_LENGTH_M = 4.2
"""Likewise, for how much of its side one shows."""
TALL_WIDTH_M = Gaussian(2.2, 0.45)
"""Of what is taller than wide: vans, lorries and buses, three-wheelers."""


@dataclass(frozen=True, slots=True)
class Ruler:
    """A vehicle on the road ahead, whose width is about known.

    Attributes:
        column_px: of the middle of its lower edge.
        row_px: of its lower edge.
        width_px: of its rear.
        width_m: of its rear, as its kind has it.
        row_sigma_px: error of the lower edge.
        side_known: whether the width, in the picture and in metres, is that of rear and side together.
    """

    column_px: float
    row_px: float
    width_px: float
    width_m: Gaussian
    row_sigma_px: float
    side_known: bool = False


@dataclass(frozen=True, slots=True)
class Evidence:
    """What is known, besides the lens and the height.

    Attributes:
        points: marks at distances from the reference; with a column they tell of the roll.
        first_unknown: whether the points' distances count from the first of them, whose own is not known:
            dashes of a known period.
        lines: straight lines of the road along the direction of travel, each by two of its points; a known
            lateral distance apart they tell of the height.
        lane_width_m: between the first two lines.
        horizon: two points of it.
        travel_px: column and row that straight driving leads to.
        rulers: vehicles.
        yaw_rad: of the camera to the left, where it is known besides.
        roll_rad: of the camera to the right, likewise.
        scale_px_m: focal length times height: what a known speed tells, by how fast the road flows by.
        focal_px: focal length, as the turns of a clip tell it.
        edges: columns and rows along what is straight in the world, three places or more of each.
        plates: number plates of vehicles ahead.
        rectangles: on the road, wherever they lie and however they are turned.
        period_sigma_m: of dashes whose period was measured; None of one that a rule says, which may err.
    """

    points: tuple[GroundPoint, ...] = ()
    first_unknown: bool = False
    lines: tuple[Segment, ...] = ()
    lane_width_m: Gaussian | None = None
    horizon: Segment | None = None
    travel_px: tuple[Gaussian, Gaussian] | None = None
    rulers: tuple[Ruler, ...] = ()
    period_sigma_m: float | None = None
    yaw_rad: Gaussian | None = None
    roll_rad: Gaussian | None = None
    scale_px_m: Gaussian | None = None
    focal_px: Gaussian | None = None
    edges: tuple[tuple[tuple[float, float], ...], ...] = ()
    rectangles: tuple[GroundRectangle, ...] = ()
    plates: tuple[NumberPlate, ...] = ()

    def moved(self, to: Callable[[Places], Places], ahead_px: float) -> "Evidence":
        """What somebody clicked, as it lies in another picture of the same camera; all else stays.

        Args:
            to: gives the places, columns and rows, in the other picture.
            ahead_px: the column of points without one.
        """

        def segment(ends: Segment) -> Segment:
            first, last = to(ends)
            return first, last

        def point(mark: GroundPoint) -> GroundPoint:
            if mark.column_px is None:
                return replace(mark, row_px=to(((ahead_px, mark.row_px),))[0][1])
            ((column_px, row_px),) = to(((mark.column_px, mark.row_px),))
            return replace(mark, row_px=row_px, column_px=column_px)

        return replace(
            self,
            points=tuple(map(point, self.points)),
            lines=tuple(map(segment, self.lines)),
            horizon=self.horizon and segment(self.horizon),
            edges=tuple(map(to, self.edges)),
            rectangles=tuple(replace(r, corners_px=to(r.corners_px)) for r in self.rectangles),
            plates=tuple(replace(plate, places_px=to(plate.places_px)) for plate in self.plates),
        )

    @property
    def has_distances(self) -> bool:
        """Whether lengths on the road are known, so that distances do not rest on the lens and the height."""
        return bool(self.points) or any(rectangle.has_size for rectangle in self.rectangles)
