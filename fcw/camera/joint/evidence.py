"""What is known about the road in a picture."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from fcw.camera.calibration import Gaussian, GroundPoint, GroundRectangle, NumberPlate, Places
from fcw.camera.vanishing import Segment

VEHICLE_WIDTH_M = Gaussian(1.8, 0.16)
"""Width of passenger cars, including vans, with the errors of their boxes."""
CAR_HEIGHT_M = Gaussian(1.5, 0.15)
"""Height of passenger cars, likewise."""
CAR_LENGTH_M = 4.2
"""Length of a passenger car, which tells how much of its side is visible."""
TALL_WIDTH_M = Gaussian(2.2, 0.45)
"""Width of vehicles that are taller than wide: vans, lorries, buses and three-wheelers."""


@dataclass(frozen=True, slots=True)
class Ruler:
    """A vehicle on the road ahead whose width is about known.

    Attributes:
        column_px: column of the middle of its lower edge.
        row_px: row of its lower edge.
        width_px: width of its rear in the picture.
        width_m: width of its rear in metres, as usual for its kind.
        row_sigma_px: standard deviation of the row of the lower edge.
        side_known: whether both widths are those of rear and side together.
    """

    column_px: float
    row_px: float
    width_px: float
    width_m: Gaussian
    row_sigma_px: float
    side_known: bool = False


@dataclass(frozen=True, slots=True)
class Evidence:
    """What is known besides the lens and the height.

    Attributes:
        points: marks at distances from the reference; with columns they show the roll.
        first_unknown: whether distances count from the first point, whose own distance is not known, as with
            dashes of a known period.
        lines: straight lines on the road along the direction of travel, each given by two of its points. If
            their lateral distance is known, they show the height.
        lane_width_m: lateral distance between the first two lines.
        horizon: two points of the horizon.
        travel_px: column and row that straight driving leads to.
        rulers: vehicles of about known width.
        yaw_rad: yaw of the camera to the left, if it is known from elsewhere.
        roll_rad: roll of the camera to the right, if it is known from elsewhere.
        scale_px_m: focal length times height, from a known speed and how fast the road flows by.
        focal_px: focal length from the turns of a clip.
        edges: columns and rows along lines that are straight in the world, at least three places of each.
        plates: number plates of vehicles ahead.
        rectangles: rectangles on the road, at any place and angle.
        period_sigma_m: standard deviation of the dashes' period if it was measured; None if it comes from a
            rule, which may be wrong.
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
        """The same with everything that was clicked moved to another picture of the same camera.

        Args:
            to: converts places (columns and rows) to those in the other picture.
            ahead_px: the column to use for points without one.
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
        """Whether lengths on the road are known, so that distances do not depend on lens and height alone."""
        return bool(self.points) or any(rectangle.has_size for rectangle in self.rectangles)
