"""Where vehicles are looked for in each frame, following the estimated pitch of the camera.

If the windows are for a pitch that is 2 degrees off, up to a third of the vehicles is missed; at 3 and 4
degrees, most of them (`benchmarks/tracking/wrong_pitch.py`). The mount's orientation, as estimated from own
motion and from the vehicles found, corrects that.
"""

import math
from collections import deque
from contextlib import suppress

from fcw.detection.detector import Aim, AimedDetector, Detector
from fcw.errors import UserError
from fcw.motion.state import Mount

AIMED_ANEW_RAD = math.radians(1.0)
"""The aim changes if the estimated pitch surely differs by more than this. A smaller error costs one vehicle
in twenty."""
SURE_SIGMAS = 2.0
TOLERANCES_RAD = (
    (math.radians(0.75), math.radians(1.0)),
    (math.radians(1.5), math.radians(2.0)),
    (math.inf, math.radians(3.0)),
)
"""Pairs of the largest 1-sigma of the pitch and the tolerance to use for it. A larger tolerance takes longer
and gives more false detections."""


def aim_at(mount: Mount) -> Aim:
    """Where to look for vehicles, given the estimated mount."""
    sigma_rad = mount.pitch_sigma_rad
    tolerance_rad = next(tolerance for upto, tolerance in TOLERANCES_RAD if sigma_rad <= upto)
    return Aim(mount.pitch_rad, tolerance_rad)


def take_aim(detector: Detector, aim: Aim) -> None:
    """Aim a detector, if it uses a calibration.

    If the road would be outside the picture, the detector keeps its last aim.
    """
    if isinstance(detector, AimedDetector):
        with suppress(UserError):
            detector.aim(aim)


class Aims:
    """The aim of each frame of a drive.

    The number of frames in flight depends on the number of threads, but the results must not. So the aim of a
    frame is based on the estimate a fixed number of frames before.

    Args:
        mount: the mount before the first frame.
        lag: that number of frames: the largest number of frames in flight.

    Attributes:
        first: the aim of the first frames.
    """

    def __init__(self, mount: Mount, lag: int) -> None:
        self.first = self._latest = aim_at(mount)
        self._waiting = deque([self.first] * lag)

    def next(self) -> Aim:
        """The aim of the next frame that is searched."""
        return self._waiting.popleft()

    def believe(self, mount: Mount) -> None:
        """Add the estimate of the mount after the next frame."""
        aim = aim_at(mount)
        off_rad = abs(aim.pitch_rad - self._latest.pitch_rad)
        surely_off = off_rad > max(AIMED_ANEW_RAD, SURE_SIGMAS * mount.pitch_sigma_rad)
        if surely_off or aim.tolerance_rad != self._latest.tolerance_rad:
            self._latest = aim
        self._waiting.append(self._latest)
