"""Pitch of our body on its springs: what is told of it, and how far off that may be."""

import math

from fcw.camera.calibration import Gaussian
from fcw.tracking.range.model import RangeModel


class BodyPitch:
    """Pitch of the body as the picture tells it; else level, and less surely so while we brake or speed up.

    Args:
        model: beliefs.

    Attributes:
        told_rad: how much lower the camera looks than its mount does; 0 where it is not told.
        sigma_rad: 1-sigma of that.
    """

    def __init__(self, model: RangeModel) -> None:
        self._model, self._own_mps2 = model, 0.0
        self.told_rad, self.sigma_rad = 0.0, model.fast_pitch_sigma_rad

    def update(self, dt_s: float, own_gain_mps: float, told_rad: Gaussian | None) -> float:
        """Move on by dt.

        Args:
            dt_s: since the frame before.
            own_gain_mps: by how much we became faster in that time.
            told_rad: see `told_rad`; None where no picture tells it.

        Returns:
            `told_rad` as it was before.
        """
        before_rad, model = self.told_rad, self._model
        if dt_s > 0:
            # Own speeds come in steps: over the time in which the body follows them.
            renewed = 1 - math.exp(-dt_s / model.fast_pitch_correlation_s)
            self._own_mps2 += renewed * (own_gain_mps / dt_s - self._own_mps2)
        if told_rad is None:
            self.told_rad = 0.0
            self.sigma_rad = math.hypot(model.fast_pitch_sigma_rad, model.dive_rad_per_mps2 * self._own_mps2)
        else:
            self.told_rad, self.sigma_rad = told_rad.value, told_rad.sigma
        return before_rad
