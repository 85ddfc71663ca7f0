"""Repeated looks for the direction of travel, which show how the camera is mounted.

A look takes some seconds of driving, and needs no guess of the pitch.
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
"""Time of driving after which a look gives a first result, and its final one. A look takes 0.4 s of processor
time."""
PAUSES_S = (15.0, 60.0)
"""Pause after the first look, and after all others."""
LONGEST_LOOK_S = 60.0
"""A look that has not ended after this time, including standstill, starts anew."""
CONTRADICTED_SIGMAS = 2.5
"""A result that differs from the present estimate by more than this replaces it, because the camera was
turned or the estimate is wrong."""


class Told(NamedTuple):
    """The result of a look.

    Attributes:
        pitch_rad: pitch of the camera below the direction of travel.
        yaw_rad: yaw of the camera to the left of it; None if we turn all the time.
        is_whole: whether the look has ended. A first result is from a part of the same pictures. It is used
            only if it contradicts the present estimate, and not as one more measurement.
    """

    pitch_rad: Gaussian
    yaw_rad: Gaussian | None
    is_whole: bool


class TravelLooks:
    """Estimates the camera's orientation relative to the direction of travel.

    Args:
        calibration: its lens is used, but not its pitch.
    """

    def __init__(self, calibration: Calibration) -> None:
        self._camera, self._width_px = calibration.camera, calibration.image_size.width
        self._looks = 0
        self._begin(-math.inf)

    def update(self, time_s: float, image: NDArray[np.uint8], boxes: Sequence[Box]) -> Told | None:
        """Update with a picture.

        Args:
            time_s: time of the picture; must increase.
            image: (height, width, 3) BGR.
            boxes: boxes of vehicles in it.

        Returns:
            A result when a look has one; None most of the time.
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
            # If the camera looks to the left, the direction of travel is to the right in the picture.
            left_rad = _angle(camera.principal_column_px, column, camera.focal_y_px)
            yaw_rad = Gaussian(-left_rad.value, left_rad.sigma)
        return Told(_angle(camera.principal_row_px, row, camera.focal_y_px), yaw_rad, is_whole)

    def _begin(self, time_s: float) -> None:
        self._begin_s, self._due_s = time_s, FIRST_TOLD_S
        self._tracks = PointTracks(self._width_px, SPARSE_PX)
        self._travel = TravelDirection(self._camera, self._tracks.factor)


def _angle(axis_px: float, place: Gaussian, focal_px: float) -> Gaussian:
    """Angle of a column to the left of the axis, or of a row above it."""
    return Gaussian(math.atan((axis_px - place.value) / focal_px), place.sigma / focal_px)


def contradict(first: Gaussian, second: Gaussian) -> bool:
    """Whether two estimates of one angle contradict each other."""
    return abs(first.value - second.value) > CONTRADICTED_SIGMAS * math.hypot(first.sigma, second.sigma)
