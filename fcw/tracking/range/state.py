"""The estimated distance and motion of one vehicle."""

import math
from dataclasses import dataclass

from fcw.camera.ground_plane import FloatArray
from fcw.camera.interval import PERCENTILE_84_SIGMAS
from fcw.tracking.range.model import RangeModel


@dataclass(frozen=True, slots=True)
class RangeState:
    """Estimate of one vehicle.

    Attributes:
        distance_m: median of the distance from the camera.
        log_distance_sigma: 1-sigma of the log distance.
        closing_speed_mps: rate at which the distance shrinks.
        closing_speed_sigma_mps: 1-sigma of the closing speed.
        closing_speed_sigma_at_distance_mps: 1-sigma of the closing speed given the distance. An error of the
            distance scales the closing speed alike, and leaves the TTC as it is.
        closing_acceleration_mps2: rate at which the closing speed grows, apart from our own known
            acceleration.
        closing_acceleration_sigma_mps2: 1-sigma of that.
        width_m: width of its rear, as the detector's boxes show it.
        length_m: length of its kind.
        log_across_sigma: 1-sigma of the logarithm of distance over focal length, which lateral positions are
            proportional to. An error of the focal length largely cancels here.
        across_rate_sigma_per_s: 1-sigma of the relative rate at which the lateral position shrinks at a
            constant bearing.
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
        """Make one from the filter's state.

        Args:
            x: (3,) log D, V / D and A / D.
            p: (4, 4) covariance of log K and these.
            width_m: width of its rear.
            length_m: length of its kind.
            overhang_m: how much farther away its tyres are than its rear.
            model: the filter's model.
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
        """(distance, 16th percentile, 84th percentile) from the calibration's reference point, at least 0.

        Args:
            reference_offset_m: how far the reference point is ahead of the camera.
        """
        spread = math.exp(PERCENTILE_84_SIGMAS * self.log_distance_sigma)
        median, low, high = (
            max(camera_m - reference_offset_m, 0.0)
            for camera_m in (self.distance_m, self.distance_m / spread, self.distance_m * spread)
        )
        return median, low, high


def _root(variance: float) -> float:
    return math.sqrt(max(variance, 0.0))
