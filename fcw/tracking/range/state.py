"""What is believed of one vehicle's distance."""

import math
from dataclasses import dataclass

from fcw.camera.interval import PERCENTILE_84_SIGMAS


@dataclass(frozen=True, slots=True)
class RangeState:
    """What is believed of one vehicle.

    Attributes:
        distance_m: from the camera, the median.
        log_distance_sigma: 1-sigma of its logarithm.
        closing_speed_mps: rate at which it shrinks.
        closing_speed_sigma_mps: 1-sigma.
        closing_speed_sigma_at_distance_mps: 1-sigma if the distance is right: what is wrong with it is as
            wrong with the closing speed, and not with the TTC.
        closing_acceleration_mps2: rate at which that grows, what is known of the own speed aside.
        closing_acceleration_sigma_mps2: 1-sigma.
        width_m: of its rear, as the detector's boxes show it.
    """

    distance_m: float
    log_distance_sigma: float
    closing_speed_mps: float
    closing_speed_sigma_mps: float
    closing_speed_sigma_at_distance_mps: float
    closing_acceleration_mps2: float
    closing_acceleration_sigma_mps2: float
    width_m: float

    def distance_with_interval(self, reference_offset_m: float) -> tuple[float, float, float]:
        """(distance, 16th percentile, 84th percentile) from the calibration's reference, at least 0.

        Args:
            reference_offset_m: how far the reference is ahead of the camera.
        """
        spread = math.exp(PERCENTILE_84_SIGMAS * self.log_distance_sigma)
        median, low, high = (
            max(camera_m - reference_offset_m, 0.0)
            for camera_m in (self.distance_m, self.distance_m / spread, self.distance_m * spread)
        )
        return median, low, high
