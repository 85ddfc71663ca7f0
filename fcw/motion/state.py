"""Estimates of our own motion, of the camera's mount and of the path ahead, at one frame."""

from dataclasses import dataclass
from enum import StrEnum

GROWS_FOR_M = 40.0
"""The curvature is assumed to change up to this distance, where lane lines are looked for, and to be constant
beyond it."""


class SpeedSource(StrEnum):
    """Where the own speed comes from."""

    UNKNOWN = ""
    GIVEN = "given"
    """From the user, or from the source's file."""
    PICTURE = "picture"


@dataclass(frozen=True, slots=True, kw_only=True)
class Mount:
    """The camera's orientation relative to the road and the direction of travel.

    The angles turn the vehicle's axes (ISO 8855) into the camera's.

    Attributes:
        pitch_rad: angle of the optical axis below the direction of travel, which is parallel to the road.
        yaw_rad: angle of the optical axis to the left of the direction of travel.
        roll_rad: roll to the right about the optical axis, relative to the road with its kerbs and verges.
            The left end of the image rows is raised, so that the horizon falls from right to left in the
            picture.
        pitch_sigma_rad: 1-sigma of the pitch.
        yaw_sigma_rad: 1-sigma of the yaw.
        roll_sigma_rad: 1-sigma of the roll.
    """

    pitch_rad: float
    yaw_rad: float = 0.0
    roll_rad: float = 0.0
    pitch_sigma_rad: float = 0.0
    yaw_sigma_rad: float = 0.0
    roll_sigma_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnMotion:
    """Our own motion at one frame.

    Attributes:
        speed_mps: own speed, given or estimated; None when unknown.
        speed_sigma_mps: 1-sigma of the speed; None when it is unknown, 0 when it was given.
        speed_source: where the speed comes from.
        yaw_rate_radps: yaw rate, positive to the left; None when unknown.
        yaw_rate_sigma_radps: 1-sigma of the yaw rate; None when it is unknown, or was given without one.
        mount: orientation of the camera; None if it is not estimated.
        picture_speed_mps: own speed estimated from points in the picture, even if one was given; None when
            unknown. An estimate from the road as a whole does not count, as it is too rough to check the
            calibration's scale.
    """

    speed_mps: float | None = None
    speed_sigma_mps: float | None = None
    speed_source: SpeedSource = SpeedSource.UNKNOWN
    yaw_rate_radps: float | None = None
    yaw_rate_sigma_radps: float | None = None
    mount: Mount | None = None
    picture_speed_mps: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnPath:
    """The middle of the path that we will take: a clothoid, its curvature changing linearly as on real roads.

    Its coordinates are those of `Track.lateral_m`: metres from the camera's axis, positive to the left, as a
    function of the distance along the ground from the camera. If the camera looks to the left by some angle,
    the path heads to the right by the same angle.

    Attributes:
        offset_m: lateral position at the camera: the middle of the lane if its lines are seen.
        heading_rad: direction of the path at the camera, from the camera's axis, positive to the left.
        curvature_per_m: curvature at the camera, positive for a bend to the left.
        growth_per_m2: change of the curvature per metre, up to `GROWS_FOR_M`.
        offset_sigma_m: 1-sigma of the offset.
        heading_sigma_rad: 1-sigma of the heading.
        curvature_sigma_per_m: 1-sigma of the curvature, including the uncertainty of its change.
        lane_width_m: distance between the lane lines; None if none are seen.
    """

    offset_m: float = 0.0
    heading_rad: float = 0.0
    curvature_per_m: float = 0.0
    growth_per_m2: float = 0.0
    offset_sigma_m: float = 0.0
    heading_sigma_rad: float = 0.0
    curvature_sigma_per_m: float = 0.0
    lane_width_m: float | None = None

    def lateral_at(self, distance_m: float) -> float:
        """Lateral position of the path's middle at a distance from the camera, positive to the left."""
        grows_m = min(distance_m, GROWS_FOR_M)
        beyond_m = distance_m - grows_m
        # Products, because `**` raises an error if a log holds a distance that is out of range.
        grown_m3 = grows_m * grows_m * grows_m / 6 + grows_m * beyond_m * (grows_m + beyond_m) / 2
        bent_m = self.curvature_per_m * (distance_m * distance_m) / 2 + self.growth_per_m2 * grown_m3
        return self.offset_m + self.heading_rad * distance_m + bent_m

    def slope_at(self, distance_m: float) -> float:
        """Slope of `lateral_at`: its change per metre of distance."""
        grows_m = min(distance_m, GROWS_FOR_M)
        grown_m2 = grows_m * (distance_m - grows_m / 2)
        return self.heading_rad + self.curvature_per_m * distance_m + self.growth_per_m2 * grown_m2


STRAIGHT = OwnPath()
"""A path along the camera's axis, assumed if nothing is known."""
