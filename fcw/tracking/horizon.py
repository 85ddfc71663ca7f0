"""The camera's own part of ranging: what is known of every lens, and whether the mount has moved."""

import math
from dataclasses import dataclass

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.solve import calibrate
from fcw.errors import UserError

CONTRADICTION_SIGMAS = 3.0
"""Clicks that contradict the lens's prior by more than this stand alone."""


def with_principal_row(calibration: Calibration, sigma: float) -> Calibration:
    """The calibration made again with what is known of every lens: its axis is near the picture's middle.

    Three free points let pitch, focal length and principal row trade off against each other, and say little
    of the horizon and of sizes; this weak prior halves the error of far distances (notes of
    `fcw.camera.solve`). A calibration that has such a prior, or has no points, stays as it is, and so does
    one whose points contradict the middle.

    Args:
        calibration: from clicked points.
        sigma: of the principal row, as a part of the picture's height.
    """
    if not calibration.points or calibration.priors.principal_row_px is not None:
        return calibration
    size, priors = calibration.image_size, calibration.priors
    middle = Gaussian((size.height - 1) / 2, sigma * size.height)
    try:
        again = calibrate(
            calibration.points,
            size,
            calibration.camera.height_m,
            calibration.reference_offset_m,
            calibration.row_sigma_px,
            priors.field_of_view_rad,
            middle,
            priors.horizon_row_px,
        )
    except UserError:
        return calibration
    off_px = abs(again.camera.principal_row_px - middle.value)
    contradicted = off_px > CONTRADICTION_SIGMAS * middle.sigma or any(
        abs(residual) > CONTRADICTION_SIGMAS * calibration.row_sigma_px for residual in again.residuals_px
    )
    return calibration if contradicted else again


@dataclass(frozen=True, slots=True, kw_only=True)
class MountWatchSettings:
    """When a moved mount is said.

    Attributes:
        memory_s: time constant of the mean of the estimated pitch. Slopes, load and the unknown sizes of
            vehicles leave 0.11 degrees in such a mean, with three vehicles in sight.
        said_rad: a mean deviation beyond this is said: nearly four times that.
        withdrawn_rad: and it is said until the mean comes back below this.
        calibration_sigmas: nor is anything said that may be the error of the calibration's own clicks.
    """

    memory_s: float = 60.0
    said_rad: float = math.radians(0.4)
    withdrawn_rad: float = math.radians(0.25)
    calibration_sigmas: float = 3.0


class MountWatch:
    """Tells whether the camera looks elsewhere than it did when it was calibrated.

    The pitch against the calibration, as the range filter estimates it from rows and sizes of all vehicles,
    is averaged over the time in which there are vehicles. Distances follow the estimated pitch; a deviation
    that stays is said, never corrected in silence.

    Args:
        calibration_sigma_rad: 1-sigma of the horizon by the calibration.
        settings: see `MountWatchSettings`.
    """

    def __init__(self, calibration_sigma_rad: float, settings: MountWatchSettings | None = None) -> None:
        self._settings = settings or MountWatchSettings()
        doubt_rad = self._settings.calibration_sigmas * calibration_sigma_rad
        self._said_rad = max(self._settings.said_rad, doubt_rad)
        self._withdrawn_rad = self._said_rad * self._settings.withdrawn_rad / self._settings.said_rad
        self._moved = False
        self.deviation_rad = 0.0

    @property
    def moved(self) -> bool:
        """Whether the camera looks elsewhere."""
        return self._moved

    def update(self, pitch_rad: float, dt_s: float) -> None:
        """Take the pitch estimated at a frame with vehicles.

        Args:
            pitch_rad: of the camera below where it was calibrated to look.
            dt_s: since the frame before.
        """
        # It starts from the calibration, not from the first estimate: one odd vehicle is no moved mount.
        gain = 1 - math.exp(-dt_s / self._settings.memory_s)
        self.deviation_rad += gain * (pitch_rad - self.deviation_rad)
        self._moved = abs(self.deviation_rad) > (self._withdrawn_rad if self._moved else self._said_rad)

    @property
    def note(self) -> str | None:
        """What to tell, or None."""
        if not self._moved:
            return None
        direction = "down" if self.deviation_rad > 0 else "up"
        return (
            f"the camera looks {math.degrees(abs(self.deviation_rad)):.1f} degrees farther {direction} than "
            "when it was calibrated: the mount has moved, or the calibration is wrong; calibrate again"
        )
