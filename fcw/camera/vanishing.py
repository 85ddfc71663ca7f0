"""The horizon from two straight lane markings: where they meet, and how well that is known."""

import math

import numpy as np

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray
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
    # Counting from the points' middle, in units of their spread, keeps the digits.
    points = np.array((*first, *second), np.float64)
    middle = points.mean(axis=0)
    spread = float(np.abs(points - middle).max())
    if min(math.dist(*first), math.dist(*second)) <= click_sigma_px:
        raise UserError(
            "a lane line is shorter than the error of a click; draw it along the marking, as long as you can"
        )
    ends = np.column_stack(((points - middle) / spread, np.ones(4)))
    sigma = click_sigma_px / spread
    lines = np.cross(ends[0], ends[1]), np.cross(ends[2], ends[3])
    _, row, scale = (float(value) for value in np.cross(*lines))
    # The homogeneous crossing is linear in each end: one derivative for each end and coordinate.
    slopes = np.array([_crossing_slope(ends, lines, end, axis) for end in range(4) for axis in range(2)])
    if abs(scale) <= PARALLEL_SIGMAS * sigma * float(np.linalg.norm(slopes[:, 2])):
        raise UserError(
            "the two lane lines are nearly parallel in the picture, so they do not say where the horizon is; "
            "draw them along the left and the right marking of your lane where the road is straight"
        )
    meeting = row / scale
    if meeting >= float(ends[:, 1].min()):
        raise UserError(
            "the two lane lines do not meet ahead, above where they were drawn; "
            "draw one along the left and the other along the right marking of a straight lane"
        )
    by_ends = (slopes[:, 1] - meeting * slopes[:, 2]) / scale
    sigma_px = spread * sigma * float(np.linalg.norm(by_ends))
    return Gaussian(float(middle[1]) + spread * meeting, sigma_px)


def combined(beliefs: list[Gaussian]) -> Gaussian | None:
    """Independent beliefs of one value as one, weighted by inverse variance; None of none."""
    if not beliefs:
        return None
    weights = [1 / belief.sigma**2 for belief in beliefs]
    total = sum(weights)
    value = sum(weight * belief.value for weight, belief in zip(weights, beliefs, strict=True)) / total
    return Gaussian(value, math.sqrt(1 / total))


def _crossing_slope(
    ends: FloatArray, lines: tuple[FloatArray, FloatArray], end: int, axis: int
) -> FloatArray:
    """(3,): derivative of the homogeneous crossing by one coordinate of one end."""
    moved = np.zeros(3)
    moved[axis] = 1.0
    first = np.cross(moved, ends[end + 1]) if end % 2 == 0 else np.cross(ends[end - 1], moved)
    return np.asarray(np.cross(first, lines[1]) if end < 2 else np.cross(lines[0], first), np.float64)
