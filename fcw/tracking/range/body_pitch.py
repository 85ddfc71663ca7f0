"""Pitch of our body on its springs: the measured value and its uncertainty."""

import math

from fcw.camera.calibration import Gaussian
from fcw.tracking.range.model import RangeModel


class BodyPitch:
    """Pitch of the body as measured in the picture. If it is not measured, it is taken as level.

    Its uncertainty is then larger while we brake or accelerate.

    Args:
        model: the filter's model.

    Attributes:
        told_rad: measured pitch of the body, positive nose down; 0 if it is not measured.
        sigma_rad: 1-sigma of that.
    """

    def __init__(self, model: RangeModel) -> None:
        self._model, self._own_mps2 = model, 0.0
        self.told_rad, self.sigma_rad = 0.0, model.fast_pitch_sigma_rad

    def update(self, dt_s: float, own_gain_mps: float, told_rad: Gaussian | None) -> float:
        """Update with a frame.

        Args:
            dt_s: time since the previous frame.
            own_gain_mps: change of our speed in that time.
            told_rad: the measured pitch of the body; None if it is not measured.

        Returns:
            `told_rad` of the previous frame.
        """
        before_rad, model = self.told_rad, self._model
        if dt_s > 0:
            # Given speeds change in steps, so the acceleration is smoothed over the body's response time.
            renewed = 1 - math.exp(-dt_s / model.fast_pitch_correlation_s)
            self._own_mps2 += renewed * (own_gain_mps / dt_s - self._own_mps2)
        if told_rad is None:
            self.told_rad = 0.0
            self.sigma_rad = math.hypot(model.fast_pitch_sigma_rad, model.dive_rad_per_mps2 * self._own_mps2)
        else:
            self.told_rad, self.sigma_rad = told_rad.value, told_rad.sigma
        return before_rad
