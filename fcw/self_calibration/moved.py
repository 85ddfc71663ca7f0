"""Finds out whether the camera was moved during a clip, by a crash or by hand.

Then the signs of the horizon, which are vehicles and lanes, put it at one row before and at another one
after. Together they would give a camera that never existed.
"""

import math
from collections.abc import Sequence

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.motion.travel.direction import TravelDirection

LEAST_SHIFT_RAD = math.radians(5.0)
"""Hills, load and hard braking pitch the picture by less."""
FEWEST = 3
"""Least number of signs of the horizon before the move, and after it."""
WITHIN_PART = 1 / 3
"""A sign agrees with its side if it is within this part of the shift from the median of the side."""
LEAST_AGREEING = 0.75
"""Least part of the signs of each side that agree."""
SURE_SIGMAS = 2.0
"""Two rows are the same if their difference plus so many sigmas is less than the least shift."""


def moved_at(signs: Sequence[tuple[float, float]], focal_px: float) -> tuple[float, float] | None:
    """The times between which the camera was moved; None if nothing shows that it was.

    Args:
        signs: times in seconds, and the row of the horizon by something that was seen then, in any order.
        focal_px: focal length.
    """
    ordered = np.array(sorted(signs)).reshape(-1, 2)
    times_s, rows_px = ordered.T
    best: tuple[float, int] | None = None
    for split in range(FEWEST, len(rows_px) - FEWEST + 1):
        if times_s[split - 1] == times_s[split]:
            continue
        sides = rows_px[:split], rows_px[split:]
        shift_px = abs(float(np.median(sides[0]) - np.median(sides[1])))
        if shift_px < focal_px * math.tan(LEAST_SHIFT_RAD):
            continue
        agreeing = [_agreeing(side, WITHIN_PART * shift_px) for side in sides]
        if min(agreeing) >= LEAST_AGREEING and (best is None or sum(agreeing) > best[0]):
            best = sum(agreeing), split
    return None if best is None else (float(times_s[best[1] - 1]), float(times_s[best[1]]))


def leads_to_one_row(travel: TravelDirection, moved_s: tuple[float, float], focal_px: float) -> bool:
    """Whether the direction of travel points to the same row before and after, so that there was no move.

    Lane lines are sometimes found on other edges, and then their horizon jumps. The direction of travel does
    not depend on them.

    Args:
        travel: direction of travel over the whole clip.
        moved_s: the times between which the camera seems to have been moved.
        focal_px: focal length.
    """
    before, after = travel.between(-math.inf, moved_s[0]).told(), travel.between(moved_s[1], math.inf).told()
    if before is None or after is None:
        return False
    (_, before_px), (_, after_px) = before, after
    apart_px = abs(before_px.value - after_px.value)
    at_most_px = apart_px + SURE_SIGMAS * math.hypot(before_px.sigma, after_px.sigma)
    return at_most_px < focal_px * math.tan(LEAST_SHIFT_RAD)


def _agreeing(rows_px: FloatArray, within_px: float) -> float:
    return float(np.mean(np.abs(rows_px - np.median(rows_px)) <= within_px))
