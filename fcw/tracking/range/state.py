"""What is believed of one vehicle's distance."""

import math
from dataclasses import dataclass

from fcw.camera.ground_plane import FloatArray
from fcw.camera.interval import PERCENTILE_84_SIGMAS
from fcw.tracking.range.model import RangeModel


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
        length_m: of its kind.
        log_across_sigma: 1-sigma of the logarithm of what places across the road are multiplied by, distance
            over focal length: where the focal length is little known, it is little wrong with them.
        across_rate_sigma_per_s: 1-sigma of the rate at which what keeps its bearing comes nearer across the
            road, as a part of its place there.
    """

    distance_m: float
    log_distance_sigma: float
    closing_speed_mps: float
    closing_speed_sigma_mps: float
    closing_speed_sigma_at_distance_mps: float
    closing_acceleration_mps2: float
    closing_acceleration_sigma_mps2: float
    width_m: float
    length_m: float
    log_across_sigma: float
    across_rate_sigma_per_s: float

    @classmethod
    def of(
        cls,
        x: FloatArray,
        p: FloatArray,
        width_m: float,
        length_m: float,
        overhang_m: float,
        model: RangeModel,
    ) -> "RangeState":
        """As the filter has it.

        Args:
            x: (3,) log D, V / D and A / D.
            p: (4, 4) covariance of log K and these.
            width_m: of its rear.
            length_m: of its kind.
            overhang_m: by which its lower edge is believed to be farther away.
            model: beliefs.
        """
        log_distance, rate, growth = x.tolist()
        (kk, kl, kr, _), (_, ll, lr, lg), (_, _, rr, _), (_, _, _, gg) = p.tolist()
        distance_m = math.exp(log_distance)
        across, across_rate = kk - 2 * kl + ll, lr - kr
        return cls(
            distance_m=distance_m,
            log_distance_sigma=math.hypot(
                _root(ll), model.unmodelled_sigma, model.overhang_sigma * overhang_m / distance_m
            ),
            closing_speed_mps=rate * distance_m,
            closing_speed_sigma_mps=distance_m * _root(rr + 2 * rate * lr + rate * rate * ll),
            closing_speed_sigma_at_distance_mps=distance_m * _root(rr),
            closing_acceleration_mps2=growth * distance_m,
            closing_acceleration_sigma_mps2=distance_m * _root(gg + 2 * growth * lg + growth * growth * ll),
            width_m=width_m,
            length_m=length_m,
            log_across_sigma=math.hypot(_root(across), model.unmodelled_sigma),
            across_rate_sigma_per_s=_root(rr + 2 * rate * across_rate + rate * rate * across),
        )

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


def _root(variance: float) -> float:
    return math.sqrt(max(variance, 0.0))
