"""Checks of clicked points before any calculation, with messages that name the points and the remedy."""

import math
from collections.abc import Sequence
from enum import Enum
from itertools import pairwise

from fcw.bounded.pictures import LONGEST_SIDE_PX
from fcw.camera.calibration import GroundPoint, Priors
from fcw.errors import UserError
from fcw.frame import ImageSize

PARAMETER_COUNT = 3
"""Pitch, focal length and principal row. As many independent measurements are needed."""
LARGEST_TAPE_ERROR = 0.5
"""Limit of the relative error of a tape; beyond it, nothing is measured."""
LEAST_HEIGHT_M, MOST_M, LEAST_SIGMA_PX = 0.01, 10_000.0, 1e-6
"""Beyond these limits, precision is lost. A height that was typed in millimetres is within them."""
FARTHEST_POINT_M, MOST_POINTS = 500.0, 100
"""Nobody measures farther or clicks more points. Every three of them are compared."""
OUTSIDE_LIMIT = 1.0
"""How far outside the picture a point may be, in picture sizes. An extrapolated mark may be just below the
picture, but a row farther off belongs to another picture or is a typing error."""
REPEAT_SIGMAS = 6.0
"""Two clicks at one distance that differ by more than this many sigmas are not the same mark."""
COLLINEAR_TOLERANCE = 1e-6
"""Tolerance for rounding in the middle row's distance from a straight line, relative to the rows of the other
two."""
DISTANCE_RESOLUTION_M = 1e-4
"""Distances that differ by less are the same mark."""
ROW_RESOLUTION_PX = 1e-4
"""Rows that differ by less are the same row; no click is finer."""


class PointsFault(Enum):
    """What is wrong with points that determine no camera."""

    NOT_A_POINT = "not_a_point"
    TOO_FEW = "too_few"
    SAME_DISTANCE = "same_distance"
    SAME_ROW = "same_row"
    ORDER = "order"
    ROWS_TOGETHER = "rows_together"
    HORIZON_BELOW_ROAD = "horizon_below_road"


class PointsError(UserError):
    """Points that do not determine a camera, with a machine-readable cause.

    Attributes:
        fault: what is wrong.
        points: the points concerned, the nearest first.
    """

    def __init__(self, message: str, fault: PointsFault, points: Sequence[GroundPoint]) -> None:
        super().__init__(message)
        self.fault = fault
        self.points = tuple(points)

    def with_cause(self, text: str) -> "PointsError":
        """The same, with the likely cause in its message."""
        return PointsError(f"{self}; likely cause: {text}", self.fault, self.points)


def check_setup(
    image_size: ImageSize, height_m: float, reference_offset_m: float, row_sigma_px: float
) -> None:
    """Check the measurements of the set-up.

    Raises:
        UserError: a value is impossible.
    """
    if image_size.width < 1 or image_size.height < 1:
        raise UserError(f"image size {image_size}: expected a width and height of at least 1 pixel")
    if max(image_size.width, image_size.height) > LONGEST_SIDE_PX:
        raise UserError(f"image size {image_size!s:.60}: expected at most {LONGEST_SIDE_PX} pixels a side")
    if not LEAST_HEIGHT_M <= height_m <= MOST_M:
        raise UserError(
            f"camera height {height_m:g} m: expected a height above 0 ({LEAST_HEIGHT_M:g} to {MOST_M:g}); "
            "measure from the road up to the lens, in metres"
        )
    if not 0 <= reference_offset_m <= MOST_M:
        raise UserError(
            f"reference offset {reference_offset_m:g} m: expected 0 or more (to {MOST_M:g}), "
            "the metres from the camera forward to where the distances start (the front bumper)"
        )
    if not LEAST_SIGMA_PX <= row_sigma_px <= LONGEST_SIDE_PX:
        raise UserError(
            f"row sigma {row_sigma_px:g} px: expected a number above 0 ({LEAST_SIGMA_PX:g} to "
            f"{LONGEST_SIDE_PX}), the error of a click in pixels"
        )


def check_tape_error(tape_error: float) -> None:
    """Check the relative error of the tape.

    Raises:
        UserError: the value is impossible.
    """
    if not 0 <= tape_error < LARGEST_TAPE_ERROR:
        raise UserError(
            f"tape error {tape_error:g}: expected a part of the distance from 0 to "
            f"{LARGEST_TAPE_ERROR:g}, for example 0.01 for 1 %"
        )


def check_exact(points: Sequence[GroundPoint], priors: Priors) -> None:
    """Check that the exact solution is asked for three points and nothing else.

    Raises:
        UserError: it is not.
    """
    if len(points) != PARAMETER_COUNT or priors.count:
        besides = " and nothing else of the camera" if priors.count else f", not {len(points)}"
        raise UserError(
            f"the exact solution takes {PARAMETER_COUNT} points{besides}; leave exact out for the best fit "
            "of all that is known"
        )


def check_priors(priors: Priors) -> None:
    """Check the priors.

    Raises:
        UserError: a value or a sigma is impossible.
    """
    named = (
        ("field of view", priors.field_of_view_rad, 180 / math.pi, " degrees"),
        ("principal row", priors.principal_row_px, 1.0, ""),
        ("horizon row", priors.horizon_row_px, 1.0, ""),
    )
    for name, prior, unit, unit_name in named:
        if prior is None:
            continue
        if not (math.isfinite(prior.sigma) and prior.sigma > 0):
            raise UserError(
                f"{name}: sigma {prior.sigma * unit:g}{unit_name}, expected a number above 0: "
                "how uncertain the value is"
            )
        if not math.isfinite(prior.value):
            raise UserError(f"{name} {prior.value:g}: expected a finite number")
    field_of_view = priors.field_of_view_rad
    if field_of_view is not None and not 0 < field_of_view.value < math.pi:
        raise UserError(
            f"field of view {math.degrees(field_of_view.value):g} degrees: "
            "expected more than 0 and less than 180"
        )


def check_points(
    points: Sequence[GroundPoint], image_size: ImageSize, row_sigma_px: float, prior_count: int
) -> None:
    """Check that points can determine a camera.

    Raises:
        PointsError: they cannot; the message names them and the remedy.
        UserError: there are too many.
    """
    check_each(points, image_size)
    ordered = sorted(points, key=lambda point: point.distance_m)
    distinct = len(distinct_distances([point.distance_m for point in points]))
    enough = distinct + prior_count >= PARAMETER_COUNT
    check_repeats(points, row_sigma_px if enough else 0.0)
    if not enough:
        given = ", ".join(map(str, points)) or "none"
        missing = PARAMETER_COUNT - distinct - prior_count
        raise PointsError(
            f"{len(points)} point{'s' * (len(points) != 1)} given ({given}), "
            f"expected at least {PARAMETER_COUNT} at different distances; add {missing} more, best far away, "
            "or as many of the priors field of view, principal row and horizon row",
            PointsFault.TOO_FEW,
            ordered,
        )
    rows_px = [point.row_px for point in points]
    if prior_count == 0 and max(rows_px) - min(rows_px) < row_sigma_px:
        raise PointsError(
            f"the rows of all points ({', '.join(map(str, points))}) lie within "
            f"{max(rows_px) - min(rows_px):g} px, less than the error of a click, {row_sigma_px:g} px; "
            "mark points whose distances differ more, or state a smaller row sigma",
            PointsFault.ROWS_TOGETHER,
            ordered,
        )
    if distinct + prior_count == PARAMETER_COUNT:
        check_order(points)
    if len(points) == PARAMETER_COUNT and prior_count == 0:
        _check_convex(*ordered)


def check_each(points: Sequence[GroundPoint], image_size: ImageSize) -> None:
    """Check each point for itself, and their number.

    Raises:
        PointsError: a point is impossible.
        UserError: there are too many.
    """
    for point in points:
        _check_point(point, image_size)
    check_reach(points)


def check_reach(points: Sequence[GroundPoint]) -> None:
    """Check the number of points, and that none is farther away than anybody measures.

    Raises:
        PointsError: the farthest point is too far away.
        UserError: there are too many.
    """
    if len(points) > MOST_POINTS:
        raise UserError(f"{len(points)} points: expected at most {MOST_POINTS}; a few far apart say as much")
    farthest = max(points, key=lambda point: point.distance_m, default=None)
    if farthest is not None and not farthest.distance_m <= FARTHEST_POINT_M:
        raise PointsError(
            f"point {farthest}: distance {farthest.distance_m:g} m, expected at most {FARTHEST_POINT_M:g}: "
            "metres along the road from the reference forward to the mark",
            PointsFault.NOT_A_POINT,
            (farthest,),
        )


def distinct_distances(distances_m: Sequence[float]) -> list[float]:
    """The distances in ascending order, each mark once."""
    distinct: list[float] = []
    for distance_m in sorted(distances_m):
        if not distinct or distance_m - distinct[-1] > DISTANCE_RESOLUTION_M:
            distinct.append(distance_m)
    return distinct


def _check_point(point: GroundPoint, size: ImageSize) -> None:
    column_px = 0.0 if point.column_px is None else point.column_px
    if not all(map(math.isfinite, (point.distance_m, point.row_px, column_px))):
        raise PointsError(
            f"point {point}: expected finite numbers DISTANCE:ROW or DISTANCE:ROW:COLUMN",
            PointsFault.NOT_A_POINT,
            (point,),
        )
    if point.distance_m <= 0:
        raise PointsError(
            f"point {point}: distance {point.distance_m:g} m, expected more than 0: "
            "metres along the road from the reference forward to the mark",
            PointsFault.NOT_A_POINT,
            (point,),
        )
    for name, value, length in (("row", point.row_px, size.height), ("column", column_px, size.width)):
        if not -OUTSIDE_LIMIT * length <= value <= (1 + OUTSIDE_LIMIT) * length:
            raise PointsError(
                f"point {point}: {name} {value:g} lies far outside the picture of {size}; "
                "check the point, and that the image size is that of the picture it was clicked in",
                PointsFault.NOT_A_POINT,
                (point,),
            )


MOST_SLOPE = 0.1
"""Largest slope in the picture of a line across the road, for a camera mounted by eye: six degrees."""


def check_repeats(points: Sequence[GroundPoint], row_sigma_px: float) -> None:
    """Check that points at one distance have rows that agree within the error of a click.

    Args:
        points: in any order.
        row_sigma_px: the error of a click; 0 allows only one point at each distance.

    Raises:
        PointsError: two of them do not.
    """
    for near, far in pairwise(sorted(points, key=lambda point: point.distance_m)):
        same = far.distance_m - near.distance_m <= DISTANCE_RESOLUTION_M
        apart_px = REPEAT_SIGMAS * row_sigma_px
        if near.column_px is not None and far.column_px is not None:
            # If they are side by side, a tilted camera or lens distortion gives them different rows.
            apart_px += MOST_SLOPE * abs(near.column_px - far.column_px)
        contradictory = abs(near.row_px - far.row_px) > apart_px
        if same and (contradictory or row_sigma_px == 0):
            raise PointsError(
                f"points {near} and {far} have the same distance, {near.distance_m:g} m; "
                "mark points at different distances, or correct one of the two",
                PointsFault.SAME_DISTANCE,
                (near, far),
            )


def check_order(points: Sequence[GroundPoint]) -> None:
    """Check that farther points are higher in the picture.

    Raises:
        PointsError: two of them are not.
    """
    for near, far in pairwise(sorted(points, key=lambda point: point.distance_m)):
        if far.distance_m - near.distance_m <= DISTANCE_RESOLUTION_M:
            continue
        if near.row_px - far.row_px > ROW_RESOLUTION_PX:
            continue
        if near.row_px - far.row_px >= -ROW_RESOLUTION_PX:
            raise PointsError(
                f"points {near} and {far} have the same row, {near.row_px:g}, at different distances; "
                "a farther mark stands higher in the picture: click one of them again",
                PointsFault.SAME_ROW,
                (near, far),
            )
        raise PointsError(
            f"point {far} is farther than {near} but lower in the picture (rows count downwards); "
            "correct their distances or click them again",
            PointsFault.ORDER,
            (near, far),
        )


def _check_convex(near: GroundPoint, middle: GroundPoint, far: GroundPoint) -> None:
    """Check that rows crowd together towards the horizon; otherwise the horizon would be below the road."""
    near_gap_m, far_gap_m = middle.distance_m - near.distance_m, far.distance_m - middle.distance_m
    straight_px = (near.row_px * far_gap_m + far.row_px * near_gap_m) / (near_gap_m + far_gap_m)
    if straight_px - middle.row_px > COLLINEAR_TOLERANCE * (near.row_px - far.row_px):
        return
    raise horizon_below_road(
        (near, middle, far),
        f"the row at {middle.distance_m:g} m must be less than {straight_px:g} for the other two",
    )


def horizon_below_road(points: Sequence[GroundPoint], detail: str) -> PointsError:
    """The error for points whose rows do not crowd together towards the horizon."""
    return PointsError(
        f"points {', '.join(map(str, points))}: the horizon would come out below the road, because the rows "
        f"do not crowd together with distance ({detail}); check the distances and click the points again",
        PointsFault.HORIZON_BELOW_ROAD,
        points,
    )
