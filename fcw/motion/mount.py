"""The note that the camera looks elsewhere than when it was calibrated, and what that does to distances."""

import math
from dataclasses import replace

from fcw.camera.calibration import Calibration
from fcw.motion.state import Mount

SAID_RAD, WITHDRAWN_RAD = math.radians(0.4), math.radians(0.2)
"""The note appears above the first difference of pitch, and disappears below the second. At a camera height
of 1.4 m, 0.4 degrees change a distance of 30 m by 15 %."""
SURE_SIGMAS = 3.0
"""The difference must also exceed this many sigmas of the estimated pitch."""
EXPECTED_SIGMAS = 2.0
"""It must also exceed this many sigmas of the calibration: a difference is expected if that is rough."""
SAID_AFTER_S = 10.0
"""The difference must have lasted for this long, because the first few vehicles may all be wide."""
SHOWN_AT_M = 30.0


class MountNote:
    """Tells when the estimated pitch of the camera differs from the calibration's.

    Args:
        calibration: calibration for the image size.
        calibration_sigma_rad: 1-sigma of the horizon by the calibration.
    """

    def __init__(self, calibration: Calibration, calibration_sigma_rad: float) -> None:
        self._camera = calibration.camera
        self._expected_rad = EXPECTED_SIGMAS * calibration_sigma_rad
        self._moved = False
        self._off_s = 0.0
        self._mount = Mount(pitch_rad=calibration.camera.pitch_rad)

    def update(self, mount: Mount, dt_s: float) -> None:
        """Update with the current estimate of the mount, `dt_s` after the last one."""
        self._mount = mount
        limit_rad = WITHDRAWN_RAD if self._moved else SAID_RAD
        off_rad = abs(mount.pitch_rad - self._camera.pitch_rad)
        sure_rad = max(SURE_SIGMAS * mount.pitch_sigma_rad, self._expected_rad)
        is_off = off_rad > limit_rad and (self._moved or off_rad > sure_rad)
        self._off_s = self._off_s + dt_s if is_off else 0.0
        self._moved = is_off and (self._moved or self._off_s >= SAID_AFTER_S)

    @property
    def text(self) -> str | None:
        """The note, or None if there is nothing to tell."""
        if not self._moved:
            return None
        off_rad = self._mount.pitch_rad - self._camera.pitch_rad
        direction = "down" if off_rad > 0 else "up"
        believed = replace(self._camera, pitch_rad=self._mount.pitch_rad)
        read_m = self._camera.distance_at(believed.row_at(SHOWN_AT_M))
        without = (
            f"else {SHOWN_AT_M:.0f} m would read {read_m:.0f} m"
            if read_m < 1000
            else "else far ones would have no value"
        )
        return (
            f"the camera looks {math.degrees(abs(off_rad)):.1f} degrees farther {direction} than when it "
            "was calibrated: the mount has moved, or the calibration is wrong; distances are computed for "
            f"where it looks now ({without}); `fcw calibrate --from-drive DRIVE --save FILE` saves that as "
            "the calibration"
        )
