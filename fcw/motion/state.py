"""What is believed of our own motion, of the camera's mount and of the path ahead, at one frame."""

from dataclasses import dataclass
from enum import StrEnum

GROWS_FOR_M = 40.0
"""As far as lane lines are looked for, the growth of a bend was seen; beyond, it is taken to bend evenly."""


class SpeedSource(StrEnum):
    """Where the own speed comes from."""

    UNKNOWN = ""
    GIVEN = "given"
    """From the user, or from the source's file."""
    PICTURE = "picture"


@dataclass(frozen=True, slots=True, kw_only=True)
class Mount:
    """How the camera looks against the road and the direction of travel, and how well that is known.

    Angles are those that turn the vehicle's axes (ISO 8855) into the camera's.

    Attributes:
        pitch_rad: of its axis below the direction of travel, which is level with the road.
        yaw_rad: of its axis to the left of the direction of travel.
        roll_rad: of the camera to the right about its axis: the left end of its rows is raised, so that the
            horizon falls from right to left in the picture. Against the road with its kerbs and verges.
        pitch_sigma_rad: 1-sigma.
        yaw_sigma_rad: 1-sigma.
        roll_sigma_rad: 1-sigma.
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
        speed_mps: the one that is used; None when unknown.
        speed_sigma_mps: 1-sigma; None when the speed is unknown, 0 when it was given.
        speed_source: where it comes from.
        yaw_rate_radps: how fast we turn, positive to the left; None when unknown.
        yaw_rate_sigma_radps: 1-sigma; None when the yaw rate is unknown, or was given without one.
        mount: of the camera; None where it is not learned.
        picture_speed_mps: by points of the picture alone, whatever was given, or told by the road as a whole,
            which is too rough to judge a scale by; None when unknown.
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
    """The middle of the way that we will take: its curvature grows steadily along it, as roads are laid out.

    In the coordinates of `Track.lateral_m`: from the camera's axis, positive to the left, over the distance
    along the ground from the camera. A mount that looks to the left by some angle has a path that heads as
    much to the right.

    Attributes:
        offset_m: lateral position at the camera; that of the lane's middle where its lines are seen.
        heading_rad: of the path at the camera against the camera's axis, positive to the left.
        curvature_per_m: at the camera, positive where it bends to the left.
        growth_per_m2: by how much that grows along it, for `GROWS_FOR_M`.
        offset_sigma_m: 1-sigma.
        heading_sigma_rad: 1-sigma.
        curvature_sigma_per_m: 1-sigma, with that of the growth on the way.
        lane_width_m: between the lines; None where there are none.
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
        # Products, as a power raises where a log states a distance that is out of range.
        grown_m3 = grows_m * grows_m * grows_m / 6 + grows_m * beyond_m * (grows_m + beyond_m) / 2
        bent_m = self.curvature_per_m * (distance_m * distance_m) / 2 + self.growth_per_m2 * grown_m3
        return self.offset_m + self.heading_rad * distance_m + bent_m

    def slope_at(self, distance_m: float) -> float:
        """Rate at which that changes with the distance."""
        grows_m = min(distance_m, GROWS_FOR_M)
        grown_m2 = grows_m * (distance_m - grows_m / 2)
        return self.heading_rad + self.curvature_per_m * distance_m + self.growth_per_m2 * grown_m2


STRAIGHT = OwnPath()
"""Along the camera's axis: what is taken where nothing is known."""
