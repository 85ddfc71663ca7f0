"""Own motion and own path of one drive, frame by frame, from what was given and from the picture."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration, Gaussian
from fcw.motion.estimator import MotionEstimator
from fcw.motion.flow.cuts import CutWatch, Follows
from fcw.motion.flow.sight import SightWatch
from fcw.motion.lanes import Lane, LaneTracker
from fcw.motion.path import PathAhead, assumed_path, path_curvature_per_m
from fcw.motion.settings import MotionSettings
from fcw.motion.state import OwnMotion, OwnPath, SpeedSource

SHORTEST_LANE_STEP_S = 0.09
"""Lanes change slowly: ten times a second is enough."""


class Ego(NamedTuple):
    """Own motion and own path at one frame.

    Attributes:
        motion: own motion; its speed and yaw rate are the given ones, if any.
        path: own path.
        body_pitch_rad: momentary pitch of the car's body, positive nose down, in addition to the mount's;
            None when unknown.
        follows: how the picture follows the previous one.
        poor_sight: a sentence if the pictures show too little (`fcw.motion.flow.sight`); else empty.
    """

    motion: OwnMotion
    path: OwnPath
    body_pitch_rad: Gaussian | None = None
    follows: Follows = Follows.SAME_VIEW
    poor_sight: str = ""


def assumed_ego(speed_mps: float | None) -> Ego:
    """Own motion and path if at most the speed is known: straight ahead."""
    return Ego(OwnMotion(speed_mps=speed_mps), assumed_path(speed_mps))


NOTHING_KNOWN = assumed_ego(None)


class EgoEstimator:
    """Estimates own motion and own path.

    Args:
        calibration: calibration for the image size; None estimates nothing from the picture.
        settings: settings of the estimation from the picture.
    """

    def __init__(
        self, calibration: Calibration | None = None, settings: MotionSettings | None = None
    ) -> None:
        self._estimator = None if calibration is None else MotionEstimator(calibration, settings)
        self._cuts = CutWatch()
        self._focal_part = (
            None if calibration is None else calibration.camera.focal_y_px / calibration.image_size.width
        )
        self._sight = SightWatch(self._focal_part)
        self._lanes = LaneTracker()
        self._path = PathAhead()
        self._time_ns: int | None = None

    def update(
        self,
        time_ns: int,
        image: NDArray[np.uint8],
        boxes: Sequence[Box] = (),
        given_mps: float | None = None,
        given_yaw_radps: float | None = None,
    ) -> Ego:
        """Update with a frame.

        A picture that is unlike those before it is ignored. After a cut, all but the mount starts anew.

        Args:
            time_ns: time of the frame; must not decrease.
            image: (height, width, 3) BGR.
            boxes: boxes of other vehicles in it.
            given_mps: given own speed, which takes precedence over the estimate; None if there is none.
            given_yaw_radps: given yaw rate, positive to the left, which takes precedence over the estimate;
                None if there is none.
        """
        motion, lane, body_pitch_rad = OwnMotion(), None, None
        follows = self._cuts.see(time_ns, image)
        if follows is Follows.AFTER_CUT:
            self._begin_anew()
        poor_sight = self._sight.see(time_ns, image)
        if self._estimator is not None:
            is_seen = follows is not Follows.UNLIKE
            motion = self._estimator.update(time_ns, image, boxes) if is_seen else self._estimator.state
            body_pitch_rad = self._estimator.body_pitch(time_ns)
        if given_mps is not None:
            motion = replace(motion, speed_mps=given_mps, speed_sigma_mps=0.0, speed_source=SpeedSource.GIVEN)
        if given_yaw_radps is not None:
            motion = replace(motion, yaw_rate_radps=given_yaw_radps, yaw_rate_sigma_radps=None)
        if self._estimator is not None:
            lane = self._see_lane(self._estimator, motion)
        path = self._path.update(time_ns, motion, lane)
        return Ego(motion, path, body_pitch_rad, follows, poor_sight)

    def _begin_anew(self) -> None:
        if self._estimator is not None:
            self._estimator = self._estimator.after_cut()
        self._lanes, self._path, self._time_ns = LaneTracker(), PathAhead(), None
        self._sight = SightWatch(self._focal_part)

    def _see_lane(self, estimator: MotionEstimator, motion: OwnMotion) -> Lane | None:
        """The lane in the latest picture that the motion estimator used."""
        picture = estimator.picture
        if picture is None:
            return self._lanes.lane
        before = self._time_ns
        if before is not None and (picture.time_ns - before) / 1e9 < SHORTEST_LANE_STEP_S:
            return self._lanes.lane
        self._time_ns = picture.time_ns
        heading_rad = 0.0 if motion.mount is None else -motion.mount.yaw_rad
        speed_mps = motion.speed_mps
        bend_per_m = path_curvature_per_m(speed_mps, motion.yaw_rate_radps)
        dt_s = math.inf if before is None else (picture.time_ns - before) / 1e9
        return self._lanes.update(picture.grey, estimator.view, heading_rad, bend_per_m, speed_mps, dt_s)
