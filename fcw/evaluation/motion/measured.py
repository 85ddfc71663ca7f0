"""Own motion as the picture would tell it, where there are boxes and no pictures: the truth with its errors.

The errors are those of `fcw.motion` on `kitti-odometry-03` (`fcw evaluate motion`, 10 pictures a second): own
speed 3.0 % (1-sigma, about a bias of 0.5 %), yaw rate 0.14 degrees a second, the mount's yaw 0.3 degrees off
where it says 0.1, its pitch 0.1. Errors of speed and yaw rate last: their correlation is down to a third
after half a second. Lane lines are left out: there may be none.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from fcw.motion.ego import Ego
from fcw.motion.path import PathAhead
from fcw.motion.state import Mount, OwnMotion, SpeedSource


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionErrors:
    """How far own motion by the picture is off, each as 1-sigma.

    Attributes:
        speed_part: error of the speed, as a part of it.
        speed_floor_mps: least error of the speed.
        yaw_rate_radps: error of the yaw rate.
        lasts_s: correlation time of both.
        mount_rad: error of the angles of the mount, constant in a drive.
        speed_known: whether it tells the speed at all.
        said_speed_part: what own motion says of the error of its speed, as a part of it.
        said_yaw_rate_radps: what it says of that of its yaw rate.
        said_mount_rad: what it says of that of the mount.
    """

    speed_part: float = 0.03
    speed_floor_mps: float = 0.1
    yaw_rate_radps: float = math.radians(0.14)
    lasts_s: float = 0.5
    mount_rad: float = math.radians(0.3)
    speed_known: bool = True
    said_speed_part: float = 0.035
    said_yaw_rate_radps: float = math.radians(0.18)
    said_mount_rad: float = math.radians(0.1)


class MeasuredMotion:
    """Own motion and path of one drive with errors.

    Args:
        pitch_rad: of the camera, true.
        yaw_rad: of the camera's axis, as it was calibrated, to the left of the direction of travel, true.
        rng: of the errors.
        errors: see `MotionErrors`.
    """

    def __init__(
        self,
        pitch_rad: float,
        yaw_rad: float,
        rng: np.random.Generator,
        errors: MotionErrors | None = None,
    ) -> None:
        self._errors, self._rng = errors or MotionErrors(), rng
        off = self._errors.mount_rad * rng.standard_normal(2)
        said_rad = self._errors.said_mount_rad
        self._mount = Mount(
            # The picture tells the pitch better than the yaw: slip and bends push the latter to and fro.
            pitch_rad=pitch_rad + said_rad / max(self._errors.mount_rad, 1e-9) * float(off[0]),
            yaw_rad=yaw_rad + float(off[1]),
            pitch_sigma_rad=said_rad,
            yaw_sigma_rad=said_rad,
        )
        self._speed_error, self._yaw_error = rng.standard_normal(2).tolist()
        self._time_ns: int | None = None
        self._path = PathAhead()

    def at(self, time_ns: int, speed_mps: float, yaw_rate_radps: float) -> Ego:
        """What would be believed at a frame; times must not decrease."""
        errors = self._errors
        if self._time_ns is not None:
            lasting = math.exp(-(time_ns - self._time_ns) / 1e9 / errors.lasts_s)
            fresh = math.sqrt(1 - lasting**2) * self._rng.standard_normal(2)
            self._speed_error = lasting * self._speed_error + float(fresh[0])
            self._yaw_error = lasting * self._yaw_error + float(fresh[1])
        self._time_ns = time_ns
        off_mps = max(errors.speed_part * speed_mps, errors.speed_floor_mps) * self._speed_error
        motion = OwnMotion(
            speed_mps=max(speed_mps + off_mps, 0.0),
            speed_sigma_mps=max(errors.said_speed_part * speed_mps, errors.speed_floor_mps),
            speed_source=SpeedSource.PICTURE,
            yaw_rate_radps=yaw_rate_radps + errors.yaw_rate_radps * self._yaw_error,
            yaw_rate_sigma_radps=errors.said_yaw_rate_radps,
            mount=self._mount,
        )
        if not errors.speed_known:
            motion = replace(motion, speed_mps=None, speed_sigma_mps=None, speed_source=SpeedSource.UNKNOWN)
        return Ego(motion, self._path.update(time_ns, motion, None))
