"""Where vehicles are looked for in each frame: it follows what is believed of the camera's pitch.

With windows for a pitch that is 2 degrees off up to a third of the vehicles is missed, at 3 and 4 degrees
most (`benchmarks/tracking/wrong_pitch.py`). What own motion and the vehicles found tell of the mount corrects
that.
"""

import math
from collections import deque
from contextlib import suppress

from fcw.detection.detector import Aim, AimedDetector, Detector
from fcw.errors import UserError
from fcw.motion.state import Mount

AIMED_ANEW_RAD = math.radians(1.0)
"""A belief that is farther off, and surely so, is followed: less costs one vehicle in twenty."""
SURE_SIGMAS = 2.0
TOLERANCES_RAD = (
    (math.radians(0.75), math.radians(1.0)),
    (math.radians(1.5), math.radians(2.0)),
    (math.inf, math.radians(3.0)),
)
"""Up to which 1-sigma of the pitch what tolerance serves. A wider one takes longer and finds more that is
none."""


def aim_at(mount: Mount) -> Aim:
    """Where to look for vehicles, by the believed mount of the camera."""
    sigma_rad = mount.pitch_sigma_rad
    tolerance_rad = next(tolerance for upto, tolerance in TOLERANCES_RAD if sigma_rad <= upto)
    return Aim(mount.pitch_rad, tolerance_rad)


def take_aim(detector: Detector, aim: Aim) -> None:
    """Aim a detector, if it goes by a calibration.

    Where the road would be out of the picture, the detector keeps its last aim.
    """
    if isinstance(detector, AimedDetector):
        with suppress(UserError):
            detector.aim(aim)


class Aims:
    """The aim of each frame of a drive.

    How many frames are in work at once depends on the number of threads, but the results must not. So the aim
    of a frame is what was believed a fixed number of frames before.

    Args:
        mount: as believed before the first frame.
        lag: in frames; at most so many are under way at once.

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
        """Take the mount as believed after the next frame that was followed."""
        aim = aim_at(mount)
        off_rad = abs(aim.pitch_rad - self._latest.pitch_rad)
        surely_off = off_rad > max(AIMED_ANEW_RAD, SURE_SIGMAS * mount.pitch_sigma_rad)
        if surely_off or aim.tolerance_rad != self._latest.tolerance_rad:
            self._latest = aim
        self._waiting.append(self._latest)
