"""What tracking gives: vehicles with identity, distance and closing speed."""

from dataclasses import dataclass
from enum import StrEnum

from fcw.box import Box


class SeenBy(StrEnum):
    """What a track goes by at one frame."""

    DETECTOR = "detector"
    """It was found."""
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
        ttc_s: distance over closing speed; None when the gap is not closing.
        age_s: time since its first detection.
        seen_by: what saw it in this frame.
        in_path: whether it stands in the own path ahead.
        closing_acceleration_mps2: rate at which the closing speed grows: a lead that brakes, and, where the
            own speed is unknown, we who accelerate; 0 where it is not estimated.
        closing_acceleration_sigma_mps2: its standard deviation.
        lateral_speed_mps: rate at which it moves to the left as we see it, our own turning included; 0 where
            it is not estimated.
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

    @property
    def coasting(self) -> bool:
        """Whether nothing saw it in this frame."""
        return self.seen_by is SeenBy.COASTING
