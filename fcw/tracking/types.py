"""What tracking gives: vehicles with identity, distance and closing speed."""

from dataclasses import dataclass
from enum import StrEnum

from fcw.box import Box

USUAL_WIDTH_M = 1.75
"""Of a car's rear, where it was not measured."""


class SeenBy(StrEnum):
    """What a track goes by at one frame."""

    DETECTOR = "detector"
    """It was found, if only faintly."""
    PICTURE = "picture"
    """It was not found, but what looked like it before moved here."""
    COASTING = "coasting"
    """It was not seen: it is where it should be by now."""


@dataclass(frozen=True, slots=True)
class Track:
    """One vehicle followed over time, as believed at the time of a frame.

    Attributes:
        track_id: positive, never used again within a drive.
        box: filtered box in the picture, in pixels.
        score: score of the latest detection behind it.
        distance_m: along the ground from the calibration's reference to the rear of the vehicle.
        distance_low_m: 16th percentile of the distance.
        distance_high_m: 84th percentile of the distance; inf when unbounded.
        lateral_m: of the middle of its rear from the camera's axis, positive to the left.
        closing_speed_mps: rate at which the distance shrinks; negative when the gap opens.
        closing_speed_sigma_mps: its standard deviation.
        closing_speed_sigma_at_distance_mps: the same if the distance is right: what is wrong with it is as
            wrong with the closing speed, and not with the TTC. None in logs of before it was written.
        ttc_s: distance over closing speed; None when the gap is not closing, or not surely: see
            `known_ttc_s`.
        age_s: time since its first detection.
        seen_by: what saw it in this frame, or, where that was not searched, in the last one that was.
        in_path: whether it stands in the own path ahead.
        closing_acceleration_mps2: rate at which the closing speed grows: a lead that brakes, and, where the
            own speed is unknown, we who accelerate; 0 where it is not estimated.
        closing_acceleration_sigma_mps2: its standard deviation.
        lateral_speed_mps: rate at which it moves to the left as we see it, our own turning included; 0 where
            it is not estimated.
        width_m: of its rear.
        lateral_sigma_m: standard deviation of the lateral position, the camera's direction aside.
        lateral_speed_sigma_mps: standard deviation of the lateral speed.
        lateral_slowing_mps2: by how much its own motion across the road slows at least, by 1 sigma; 0 where
            it does not, or where our turning may be what changes it.
        lateral_speed_by_bearing_mps: the lateral speed by how its bearing changes, if the TTC is right; None
            where our turning is not known, and in logs of before it was written.
        lateral_speed_by_bearing_sigma_mps: its standard deviation, if distance and TTC are right: what is
            wrong with them is wrong with the place as well, and not with where it will be.
        doubtful: whether it may be none: it appeared from nothing near us, or stands still in the picture. It
            is neither the lead nor a threat.
        found_part: in how many of its frames the detector found it, of those in which it was not faint; 1 in
            logs of before it was written.
    """

    track_id: int
    box: Box
    score: float
    distance_m: float
    distance_low_m: float
    distance_high_m: float
    lateral_m: float
    closing_speed_mps: float
    closing_speed_sigma_mps: float
    ttc_s: float | None
    age_s: float
    seen_by: SeenBy
    in_path: bool
    closing_acceleration_mps2: float = 0.0
    closing_acceleration_sigma_mps2: float = 0.0
    lateral_speed_mps: float = 0.0
    width_m: float = USUAL_WIDTH_M
    lateral_sigma_m: float = 0.0
    lateral_speed_sigma_mps: float = 0.0
    doubtful: bool = False
    closing_speed_sigma_at_distance_mps: float | None = None
    found_part: float = 1.0
    lateral_slowing_mps2: float = 0.0
    lateral_speed_by_bearing_mps: float | None = None
    lateral_speed_by_bearing_sigma_mps: float = 0.0

    @property
    def approach_sigma_mps(self) -> float:
        """1-sigma of the closing speed for this distance, as far as it is known."""
        sigma_mps = self.closing_speed_sigma_at_distance_mps
        return self.closing_speed_sigma_mps if sigma_mps is None else sigma_mps

    @property
    def coasting(self) -> bool:
        """Whether nothing saw it in this frame."""
        return self.seen_by is SeenBy.COASTING


KNOWN_SIGMAS = 2.0


def known_ttc_s(distance_m: float, closing_mps: float, sigma_mps: float) -> float | None:
    """Time to collision, distance over closing speed, once it is known.

    It is where the closing speed is more than two of its sigmas: one time in forty it is not closing at all
    then, and else it is known to a factor of two. Before, a few boxes' noise would be shown as seconds.
    """
    return distance_m / closing_mps if closing_mps > max(KNOWN_SIGMAS * sigma_mps, 0.0) else None
