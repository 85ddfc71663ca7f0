"""Where a drive leads to, looked for again and again: how the camera is mounted.

A look takes some seconds of driving and needs no guess of the pitch.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration, Gaussian
from fcw.motion.travel.direction import TravelDirection
from fcw.motion.travel.tracks import SPARSE_PX, PointTracks

FIRST_TOLD_S, LOOK_S = 1.8, 5.0
"""Of driving: a look tells first what little it has seen, then all, and ends. It takes 0.4 s of a
processor."""
PAUSES_S = (15.0, 60.0)
"""After the first look, and after all others."""
LONGEST_LOOK_S = 60.0
"""Of driving and standing: a look that has not ended by then begins anew."""
CONTRADICTED_SIGMAS = 2.5
"""What is so far from what was believed takes its place: the camera was turned, or the belief is wrong."""


class Told(NamedTuple):
    """What a look tells of the camera.

    Attributes:
        pitch_rad: downwards, against the direction of travel.
        yaw_rad: to the left; None where we turn all the time.
        is_whole: whether the look has ended. What it tells before is of a part of the same pictures: it
            counts where it contradicts what is believed, and not as one more measurement.
    """

    pitch_rad: Gaussian
    yaw_rad: Gaussian | None
    is_whole: bool


class TravelLooks:
    """Tells how the camera looks against the direction of travel.

    Args:
        calibration: its lens is taken for granted, its pitch is not.
    """

    def __init__(self, calibration: Calibration) -> None:
        self._camera, self._width_px = calibration.camera, calibration.image_size.width
        self._looks = 0
        self._begin(-math.inf)

    def update(self, time_s: float, image: NDArray[np.uint8], boxes: Sequence[Box]) -> Told | None:
        """Take a picture.

        Args:
            time_s: of it; rises.
            image: (height, width, 3) BGR.
            boxes: of vehicles in it.

        Returns:
            What pictures told by now; None most of the time.
        """
        if time_s < self._begin_s:
            return None
        if time_s > self._begin_s + LONGEST_LOOK_S:
            self._begin(time_s)
        if not self._tracks.update(time_s, image):
            return None
        self._travel.update(self._tracks.pictures[-1], boxes)
        del self._tracks.pictures[:-1]
        driven_s = self._travel.driven_s
        if driven_s < self._due_s:
            return None
        places, is_whole = self._travel.told(), driven_s >= LOOK_S
        self._due_s = LOOK_S
        if is_whole:
            self._begin(time_s + PAUSES_S[min(self._looks, len(PAUSES_S) - 1)])
            self._looks += 1
        if places is None:
            return None
        column, row = places
        camera, yaw_rad = self._camera, None
        if column is not None:
            # A camera that looks to the left sees where it drives to on the right.
            left_rad = _angle(camera.principal_column_px, column, camera.focal_y_px)
            yaw_rad = Gaussian(-left_rad.value, left_rad.sigma)
        return Told(_angle(camera.principal_row_px, row, camera.focal_y_px), yaw_rad, is_whole)

    def _begin(self, time_s: float) -> None:
        self._begin_s, self._due_s = time_s, FIRST_TOLD_S
        self._tracks = PointTracks(self._width_px, SPARSE_PX)
        self._travel = TravelDirection(self._camera, self._tracks.factor)


def _angle(axis_px: float, place: Gaussian, focal_px: float) -> Gaussian:
    """How far above the axis, or to the left of it, a place is."""
    return Gaussian(math.atan((axis_px - place.value) / focal_px), place.sigma / focal_px)


def contradict(first: Gaussian, second: Gaussian) -> bool:
    """Whether two beliefs in one angle are too far apart."""
    return abs(first.value - second.value) > CONTRADICTED_SIGMAS * math.hypot(first.sigma, second.sigma)
