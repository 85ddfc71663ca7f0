"""The horizon from two straight lane markings: where they meet, and how well that is known."""

import math

from fcw.camera.calibration import Gaussian
from fcw.camera.interval import Vector3
from fcw.errors import UserError

PixelPoint = tuple[float, float]
"""Column and row."""
Segment = tuple[PixelPoint, PixelPoint]

PARALLEL_SIGMAS = 3.0
"""Lines whose angle is not this many times its error may be parallel, and meet anywhere."""


def vanishing_row(first: Segment, second: Segment, click_sigma_px: float) -> Gaussian:
    """Row of the point where two straight lane markings meet, with its standard deviation to first order.

    On a flat road that point lies on the horizon, whatever the camera's yaw; a roll of the camera is not
    modelled. Each of the four clicked ends has independent noise in column and row.

    Args:
        first: two points of one marking.
        second: two points of the other one.
        click_sigma_px: standard deviation of a clicked column or row.

    Raises:
        UserError: the lines are nearly parallel, or do not meet above all four points; nothing follows then.
    """
    if min(math.dist(*first), math.dist(*second)) <= click_sigma_px:
        raise UserError(
            "a lane line is shorter than the error of a click; draw it along the marking, as long as you can"
        )
    # Counting from the points' middle, in units of their spread, keeps the digits.
    points = (*first, *second)
    middle_column, middle_row = (sum(values) / len(points) for values in zip(*points, strict=True))
    spread = max(max(abs(c - middle_column), abs(r - middle_row)) for c, r in points)
    a, b, c, d = (
        ((column - middle_column) / spread, (row - middle_row) / spread, 1.0) for column, row in points
    )
    sigma = click_sigma_px / spread
    line_1, line_2 = _cross(a, b), _cross(c, d)
    _, row, scale = _cross(line_1, line_2)
    # The homogeneous crossing is linear in each end: one derivative for each end and coordinate.
    slopes = [
        slope
        for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        for slope in (
            _cross(_cross(axis, b), line_2),
            _cross(_cross(a, axis), line_2),
            _cross(line_1, _cross(axis, d)),
            _cross(line_1, _cross(c, axis)),
        )
    ]
    if abs(scale) <= PARALLEL_SIGMAS * sigma * math.hypot(*(slope[2] for slope in slopes)):
        raise UserError(
            "the two lane lines are nearly parallel in the picture, so they do not say where the horizon is; "
            "draw them along the left and the right marking of your lane where the road is straight"
        )
    meeting = row / scale
    meeting_row_px = middle_row + spread * meeting
    if meeting_row_px >= min(row_px for _, row_px in points):
        raise UserError(
            "the two lane lines do not meet ahead, above where they were drawn; "
            "draw one along the left and the other along the right marking of a straight lane"
        )
    by_ends = (slope[1] - meeting * slope[2] for slope in slopes)
    sigma_px = spread * sigma * math.hypot(*by_ends) / abs(scale)
    return Gaussian(meeting_row_px, sigma_px)


def combined(beliefs: list[Gaussian]) -> Gaussian | None:
    """Independent beliefs of one value as one, weighted by inverse variance; None of none."""
    if not beliefs:
        return None
    weights = [1 / belief.sigma**2 for belief in beliefs]
    total = sum(weights)
    value = sum(weight * belief.value for weight, belief in zip(weights, beliefs, strict=True)) / total
    return Gaussian(value, math.sqrt(1 / total))


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
