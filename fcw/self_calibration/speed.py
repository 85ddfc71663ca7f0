"""How fast the road of a clip goes by: with a known speed it tells the height of the camera."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian
from fcw.frame import Frame
from fcw.motion.estimator import MotionEstimator
from fcw.motion.settings import MotionSettings

SPEED_SIGMA = 0.04
"""Of the speed by the picture, over a clip: on KITTI odometry 03 it is off by 3 % a second."""
FEWEST_SPEEDS = 10
SLOWEST_MEAN_MPS = 1.0
"""Who is slower over a clip stood in most of it: what is seen of the speed tells no scale then."""


@dataclass(frozen=True, slots=True)
class MeanSpeed:
    """The mean speed over a clip, measured in its pictures.

    Attributes:
        heights_per_s: speed in camera heights per second.
        focal_px: focal length that was assumed; with another one, the speed is different too.
        times_ns: times of the pictures over which the mean was taken.
    """

    heights_per_s: float
    focal_px: float
    times_ns: tuple[int, ...]

    @property
    def scale_per_mps(self) -> float:
        """Focal length times height of the camera, in px m, for each m/s of the true mean.

        It hardly depends on the focal length that was assumed.
        """
        return self.focal_px / self.heights_per_s

    def scale_px_m(self, speed_mps: float) -> Gaussian:
        """Focal length times height of the camera.

        Args:
            speed_mps: the true mean.
        """
        scale_px_m = speed_mps * self.scale_per_mps
        return Gaussian(scale_px_m, SPEED_SIGMA * scale_px_m)


def mean_speed(
    frames: Iterable[Frame],
    calibration: Calibration,
    on_frame: Callable[[], None] = lambda: None,
    enough_s: float = math.inf,
) -> MeanSpeed | None:
    """The mean speed over a clip; None where it is hardly known, or the car stood for most of the time.

    Args:
        frames: straight pictures.
        calibration: of them; its height is the unit.
        on_frame: called after each picture.
        enough_s: a speed that is known for so long is enough.
    """
    height_m, known_s, last_ns = calibration.camera.height_m, 0.0, None
    times_ns: list[int] = []
    speeds_mps: list[float] = []
    for time_ns, speed_mps in speeds_seen(frames, calibration):
        if speed_mps is not None:
            times_ns.append(time_ns)
            speeds_mps.append(speed_mps)
            known_s += 0.0 if last_ns is None else (time_ns - last_ns) / 1e9
        last_ns = time_ns
        on_frame()
        if known_s >= enough_s:
            break
    if len(speeds_mps) < FEWEST_SPEEDS or np.mean(speeds_mps) < SLOWEST_MEAN_MPS:
        return None
    return MeanSpeed(float(np.mean(speeds_mps)) / height_m, calibration.camera.focal_y_px, tuple(times_ns))


def speeds_seen(frames: Iterable[Frame], calibration: Calibration) -> Iterator[tuple[int, float | None]]:
    """Time and own speed in m/s of each picture; None where it is unknown.

    What the road as a whole tells of the speed is too rough for a scale, and is not asked.

    Args:
        frames: straight pictures.
        calibration: of them.
    """
    estimator = MotionEstimator(calibration, MotionSettings(asks_direction=False, asks_road=False))
    for frame in frames:
        yield frame.time_ns, estimator.update(frame.time_ns, frame.image).speed_mps
