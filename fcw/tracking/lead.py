"""Which vehicle is the lead: the nearest one in the own path that does not come towards us."""

from collections.abc import Iterable
from dataclasses import dataclass

from fcw.tracking.types import Track

ONCOMING_MARGIN_MPS = 3.0
"""Errors of the own speed and of a lead that rolls back stay below this."""
ONCOMING_SIGMAS = 1.0
"""How surely the closing speed must exceed the own speed before a vehicle counts as oncoming: a standing
vehicle closes exactly at the own speed, and must not be lost to noise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Corridor:
    """The own path: a straight strip on the ground along the vehicle's axis.

    The middle of a vehicle's rear decides. With lanes of 3.5 m a neighbour's middle is 3.5 m away.

    Attributes:
        enter_m: a vehicle this near the axis comes into the path.
        leave_m: a vehicle in the path leaves it beyond this: half a lane.
    """

    enter_m: float = 1.2
    leave_m: float = 1.8

    def holds(self, lateral_m: float, was_inside: bool) -> bool:
        """Whether a vehicle is in the path, given whether it was before."""
        return abs(lateral_m) <= (self.leave_m if was_inside else self.enter_m)


def is_oncoming(track: Track, ego_speed_mps: float | None) -> bool:
    """Whether the vehicle surely comes towards us: it closes faster than a standing one would.

    Unknown own speed: never.
    """
    if ego_speed_mps is None:
        return False
    surely_mps = track.closing_speed_mps - ONCOMING_SIGMAS * track.closing_speed_sigma_mps
    return surely_mps > ego_speed_mps + ONCOMING_MARGIN_MPS


def select_lead(tracks: Iterable[Track], ego_speed_mps: float | None) -> Track | None:
    """The nearest vehicle in the own path, oncoming ones aside; None when the path is free."""
    candidates = (track for track in tracks if track.in_path and not is_oncoming(track, ego_speed_mps))
    return min(candidates, key=lambda track: track.distance_m, default=None)
