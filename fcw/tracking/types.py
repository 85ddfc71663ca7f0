"""The output of tracking: vehicles with identity, distance and closing speed."""

from dataclasses import dataclass
from enum import StrEnum

from fcw.box import Box

USUAL_WIDTH_M = 1.75
"""Width of a car's rear if it was not measured."""


class SeenBy(StrEnum):
    """What a track is based on at one frame."""

    DETECTOR = "detector"
    """The detector found it, if only faintly."""
    PICTURE = "picture"
    """The detector did not find it, but its image patch was followed to here."""
    COASTING = "coasting"
    """It was not seen. Its position is predicted."""


@dataclass(frozen=True, slots=True)
class Track:
    """One vehicle followed over time, as estimated at a frame.

    "Older logs" were written before a field existed.

    Attributes:
        track_id: positive, never reused within a drive.
        box: filtered box in the picture, in pixels.
        score: score of its latest detection.
        distance_m: distance along the ground from the calibration's reference point to its rear.
        distance_low_m: 16th percentile of the distance.
        distance_high_m: 84th percentile of the distance; inf when unbounded.
        lateral_m: lateral position of the middle of its rear from the camera's axis, positive to the left.
        closing_speed_mps: rate at which the distance shrinks; negative when the gap opens.
        closing_speed_sigma_mps: standard deviation of the closing speed.
        closing_speed_sigma_at_distance_mps: standard deviation of the closing speed given the distance. An
            error of the distance scales the closing speed alike, and leaves the TTC as it is. None in older
            logs.
        ttc_s: distance over closing speed; None when the gap does not close, or not surely: see
            `known_ttc_s`.
        age_s: time since its first detection.
        seen_by: what saw it in this frame or, if this frame was not searched, in the last one that was.
        in_path: whether it is in the own path.
        closing_acceleration_mps2: rate at which the closing speed grows, because the lead brakes or, if the
            own speed is unknown, because we accelerate; 0 if it is not estimated.
        closing_acceleration_sigma_mps2: standard deviation of the closing acceleration.
        lateral_speed_mps: rate at which it moves to the left as seen by the camera, including the effect of
            our own turning; 0 if it is not estimated.
        width_m: width of its rear.
        lateral_sigma_m: standard deviation of the lateral position, apart from the camera's direction.
        lateral_speed_sigma_mps: standard deviation of the lateral speed.
        lateral_slowing_mps2: lower bound (1 sigma) of the deceleration of its own motion across the road; 0
            if it does not slow down, or if our turning may be the cause.
        lateral_speed_by_bearing_mps: the lateral speed computed from the change of its bearing, given the
            TTC; None if our turning is unknown, and in older logs.
        lateral_speed_by_bearing_sigma_mps: standard deviation of that, given distance and TTC. An error of
            these changes the position as well, but not the place at contact.
        doubtful: whether it may be no vehicle, because it appeared from nothing near us or stands still in
            the picture. It is then neither the lead nor a threat.
        found_part: fraction of its frames in which the detector found it, of those in which it was not faint;
            1 in older logs.
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
        """1-sigma of the closing speed given the distance; in older logs, 1-sigma of the closing speed."""
        sigma_mps = self.closing_speed_sigma_at_distance_mps
        return self.closing_speed_sigma_mps if sigma_mps is None else sigma_mps

    @property
    def coasting(self) -> bool:
        """Whether nothing saw it in this frame."""
        return self.seen_by is SeenBy.COASTING


KNOWN_SIGMAS = 2.0


def known_ttc_s(distance_m: float, closing_mps: float, sigma_mps: float) -> float | None:
    """Time to collision, distance over closing speed; None while it is not known well enough.

    It is known once the closing speed exceeds two of its sigmas. Then the gap fails to close in one case of
    forty, and the TTC is known to a factor of two. Below that, it would mostly show the noise of the boxes.
    """
    return distance_m / closing_mps if closing_mps > max(KNOWN_SIGMAS * sigma_mps, 0.0) else None
