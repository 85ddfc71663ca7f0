"""Which corners of a picture are tracked: those on the road, and those beside and above it."""

import math

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray
from fcw.kernels.jit import kernel
from fcw.motion.flow.corners import Corners

BESIDE_M = 1.0
"""Width of a strip between the road and what is beside it that may be either, and is not used."""
NEITHER, ROAD, OTHER = range(3)
"""Kinds of corners: of no use, on the road, elsewhere."""


@kernel()
def kinds_of_corners(
    corners: Corners,
    least: tuple[float, float, float],
    trust: FloatArray,
    own_car: NDArray[np.bool_],
    boxes: FloatArray,
    rays: FloatArray,
    below: FloatArray,
    limits: tuple[float, float, float, float],
    kinds: NDArray[np.uint8],
) -> None:  # pragma: no cover - compiled
    """Determine the kind of each corner.

    `least` has the least score, trust and roundness. `boxes` has left, top, right and bottom of areas that
    are left out. `rays` are relative to the direction of travel. `limits` has the nearest and the farthest
    distance of the road, half of its width, and the inverse depth of the road below which a ray is above the
    horizon.
    """
    faintest, least_trust, least_roundness = least
    nearest_m, farthest_m, half_width_m, above = limits
    for i in range(len(kinds)):
        kinds[i] = NEITHER
        if corners.scores[i] <= faintest or trust[i] <= least_trust or own_car[i]:
            continue
        xx, yy, xy = corners.information[i, 0], corners.information[i, 1], corners.information[i, 2]
        both, apart = xx + yy, math.hypot(xx - yy, 2 * xy)
        if both - apart <= least_roundness * max(both + apart, 1e-9):
            continue
        x, y = corners.places[i, 0], corners.places[i, 1]
        hidden = False
        for k in range(len(boxes)):
            hidden |= boxes[k, 0] < x < boxes[k, 2] and boxes[k, 1] < y < boxes[k, 3]
        if hidden:
            continue
        depth_m = 1 / max(below[i], 1e-6)
        aside_m = abs(rays[i, 0]) * depth_m
        if nearest_m < depth_m < farthest_m and aside_m < half_width_m:
            kinds[i] = ROAD
        elif below[i] < above or (depth_m > nearest_m and aside_m > half_width_m + BESIDE_M):
            kinds[i] = OTHER
