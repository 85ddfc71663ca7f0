"""The measuring tool: where a clicked point of the road is, and how far two of them are apart."""

import math
import re
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import Calibration
from fcw_viz.calibrate_app.document.numbers_text import in_units, interval_text, unit_name

AHEAD_M = 0.05
"""Nearer to the camera's axis than this is straight ahead: nobody tapes better."""
SKY_WORDS = "above the horizon: sky"
INTERVAL_DECIMALS = re.compile(r"\d+\.(\d+)")
"""Finds those of the first number of an interval in words."""
ENDLESS_LENGTH_M = 1000.0
"""A length less certain than this is not known at all."""


@dataclass(frozen=True, slots=True)
class GroundMeasurement:
    """A point of the road seen at a pixel.

    Attributes:
        column_px: where it was clicked.
        row_px: where it was clicked.
        distance_m: from the calibration's reference; below 0 behind it.
        low_m: 16th percentile of the distance, from the click's noise and the calibration's.
        high_m: 84th percentile; inf where unbounded.
        lateral_m: from the camera's axis, positive to the left.
    """

    column_px: float
    row_px: float
    distance_m: float
    low_m: float
    high_m: float
    lateral_m: float


@dataclass(frozen=True, slots=True)
class GroundLength:
    """From one measured point to another.

    Attributes:
        along_m: along the road, positive where the second is farther away.
        along_sigma_m: standard deviation of it, to first order.
        across_m: across the road, positive to the left.
    """

    along_m: float
    along_sigma_m: float
    across_m: float

    @property
    def total_m(self) -> float:
        """In a straight line."""
        return math.hypot(self.along_m, self.across_m)


def measure_point(
    calibration: Calibration, column_px: float, row_px: float, row_sigma_px: float
) -> GroundMeasurement | None:
    """What is on the road at a pixel; None at and above the horizon.

    Args:
        calibration: of the picture.
        column_px: the click.
        row_px: the click.
        row_sigma_px: standard deviation of the click's row.
    """
    straight_column_px, straight_row_px = calibration.straight_place(column_px, row_px)
    distance_m = calibration.distance_at(straight_row_px)
    if not math.isfinite(distance_m):
        return None
    low_m, high_m = calibration.distance_interval(straight_row_px, row_sigma_px)
    lateral_m = calibration.lateral_at(straight_column_px, straight_row_px)
    return GroundMeasurement(column_px, row_px, distance_m, low_m, high_m, lateral_m)


def measure_length(
    calibration: Calibration, start: GroundMeasurement, end: GroundMeasurement, row_sigma_px: float
) -> GroundLength:
    """From one point to another; both clicks have a noise of their own, and share the calibration's."""
    camera = calibration.camera

    def metres_per_row(measurement: GroundMeasurement) -> float:
        depth_m = measurement.distance_m + calibration.reference_offset_m + camera.pole_m
        return -(depth_m**2) / camera.row_scale_m_px

    # A click's row is fixed, so that where the calibration moves the row of a distance by one pixel, the
    # distance seen at the click goes the other way.
    start_rate, end_rate = metres_per_row(start), metres_per_row(end)
    by_start, by_end = calibration.row_gradients(np.array([start.distance_m, end.distance_m]))
    by_support = start_rate * by_start - end_rate * by_end
    shared = float(by_support @ np.array(calibration.covariance) @ by_support)
    own = row_sigma_px**2 * (start_rate**2 + end_rate**2)
    return GroundLength(
        end.distance_m - start.distance_m, math.sqrt(max(shared, 0.0) + own), end.lateral_m - start.lateral_m
    )


def point_words(measurement: GroundMeasurement | None, imperial: bool = False) -> str:
    """`23.4 m (22.9 to 24.0), 1.2 m to the left`."""
    if measurement is None:
        return SKY_WORDS
    low_m, high_m = measurement.low_m, measurement.high_m
    if not math.isfinite(low_m) or low_m < 0 <= measurement.distance_m:
        low_m = 0.0
    interval = interval_text(low_m, high_m, imperial, dash=" to ")
    distance = distance_words(measurement.distance_m, interval, imperial)
    return f"{distance} ({interval}), {_sideways(measurement.lateral_m, imperial, 'straight ahead')}"


def distance_words(distance_m: float, interval: str, imperial: bool) -> str:
    """A distance with its unit, and as many decimals as its interval, `22.9 to 24.0`, is written with."""
    decimals = INTERVAL_DECIMALS.match(interval)
    count = len(decimals[1]) if decimals else 0
    return f"{in_units(distance_m, imperial):.{count}f} {unit_name(imperial)}"


def length_words(length: GroundLength, imperial: bool = False) -> str:
    """`9.0 ± 0.2 m along the road, 0.4 m to the left, 9.0 m in all`."""
    unit = unit_name(imperial)
    across = _sideways(length.across_m, imperial, "none across")
    if not length.along_sigma_m < ENDLESS_LENGTH_M:
        return f"too far away to say how far apart, {across}"
    along, sigma = in_units(abs(length.along_m), imperial), in_units(length.along_sigma_m, imperial)
    decimals = 0 if sigma >= 2 else 1 if sigma >= 0.1 else 2
    total = in_units(length.total_m, imperial)
    return (
        f"{along:.{decimals}f} ± {sigma:.{decimals}f} {unit} along the road, {across}, "
        f"{total:.{decimals}f} {unit} in all"
    )


def _sideways(lateral_m: float, imperial: bool, none: str) -> str:
    if abs(lateral_m) < AHEAD_M:
        return none
    side = "left" if lateral_m > 0 else "right"
    return f"{in_units(abs(lateral_m), imperial):.1f} {unit_name(imperial)} to the {side}"
