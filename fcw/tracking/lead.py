"""Which vehicle is the lead: the nearest one in the own path that is not oncoming."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from fcw.motion.state import OwnPath
from fcw.tracking.types import Track

ONCOMING_MARGIN_MPS = 3.0
"""The error of the own speed, and the speed of a lead that rolls back, stay below this."""
ONCOMING_SIGMAS = 1.0
"""By how many sigmas the closing speed must exceed the own speed before a vehicle counts as oncoming. A
standing vehicle closes exactly at the own speed, and noise must not turn it into an oncoming one."""
RIVAL_AHEAD_S = 1.5
"""How far ahead in time rivals are predicted: half the duration of a lane change."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Corridor:
    """The own path: a strip on the ground, straight or curved.

    A vehicle is judged by where the middle of its rear will be in a moment. A vehicle that cuts in belongs to
    the path before it is there, and one that leaves is released early. With lanes of 3.5 m, the middle of a
    vehicle in the next lane is 3.5 m away.

    Attributes:
        enter_m: a vehicle enters the path when it is this near to its middle.
        leave_m: a vehicle leaves the path beyond this: half a lane.
        ahead_s: how far ahead in time the lateral position is predicted; a lane change takes 3 to 5 s.
        fastest_mps: lateral speeds are limited to this, as faster ones are noise. It is the peak of a lane
            change of 3.5 m in 3 s.
    """

    enter_m: float = 1.2
    leave_m: float = 1.8
    ahead_s: float = 0.5
    fastest_mps: float = 2.0

    def holds(self, lateral_m: float, lateral_mps: float, was_inside: bool) -> bool:
        """Whether a vehicle is in the path.

        Args:
            lateral_m: position of its middle from the middle of the path.
            lateral_mps: rate of `lateral_m`.
            was_inside: whether it was in the path before.
        """
        speed_mps = min(max(lateral_mps, -self.fastest_mps), self.fastest_mps)
        soon_m = lateral_m + speed_mps * self.ahead_s
        # It enters if it is inside, or near and moving in.
        comes = abs(lateral_m) <= self.enter_m or (
            abs(lateral_m) <= self.leave_m + self.enter_m / 2
            and abs(soon_m) <= self.enter_m
            and abs(soon_m) < abs(lateral_m)
        )
        # It stays until it is outside or soon will be well outside.
        stays = abs(lateral_m) <= self.leave_m and abs(soon_m) <= self.leave_m + self.enter_m / 2
        return comes or (was_inside and stays)


def is_oncoming(track: Track, ego_speed_mps: float | None, ego_speed_sigma_mps: float | None = None) -> bool:
    """Whether the vehicle surely comes towards us, because it closes faster than a standing one would.

    False if the own speed is unknown.
    """
    if ego_speed_mps is None:
        return False
    sigma_mps = math.hypot(track.closing_speed_sigma_mps, ego_speed_sigma_mps or 0.0)
    surely_mps = track.closing_speed_mps - ONCOMING_SIGMAS * sigma_mps
    return surely_mps > ego_speed_mps + ONCOMING_MARGIN_MPS


def drives_along(track: Track, ego_speed_mps: float | None, ego_speed_sigma_mps: float | None = None) -> bool:
    """Whether the vehicle surely drives in our direction, and neither stands nor comes towards us.

    False if the own speed is unknown.
    """
    if ego_speed_mps is None:
        return False
    sigma_mps = math.hypot(track.closing_speed_sigma_mps, ego_speed_sigma_mps or 0.0)
    return track.closing_speed_mps + ONCOMING_SIGMAS * sigma_mps < ego_speed_mps - ONCOMING_MARGIN_MPS


def may_come_towards_us(track: Track, ego_speed_mps: float | None) -> bool:
    """Whether the vehicle closes faster than a standing one would, by 1 sigma and without a margin.

    True if the own speed is unknown.
    """
    if ego_speed_mps is None:
        return True
    return track.closing_speed_mps - ONCOMING_SIGMAS * track.closing_speed_sigma_mps > ego_speed_mps


def select_lead(
    tracks: Iterable[Track], ego_speed_mps: float | None, ego_speed_sigma_mps: float | None = None
) -> Track | None:
    """The nearest vehicle in the own path that is neither doubtful nor oncoming; None if the path is free."""
    candidates = (
        track
        for track in tracks
        if track.in_path and not track.doubtful and not is_oncoming(track, ego_speed_mps, ego_speed_sigma_mps)
    )
    return min(candidates, key=lambda track: track.distance_m, default=None)


def rivals(
    tracks: Iterable[Track], lead: Track | None, ego_speed_mps: float | None, path: OwnPath | None = None
) -> tuple[Track, ...]:
    """Vehicles that may become the lead in a moment, the nearest first.

    A rival is seen, is no farther away than the lead, is not oncoming, and is in the own path or will be
    within `RIVAL_AHEAD_S` at its present lateral speed. A path of None is straight.
    """
    corridor, farthest_m = Corridor(), math.inf if lead is None else lead.distance_m
    near = [
        track
        for track in tracks
        if track is not lead
        and not track.coasting
        and track.distance_m <= farthest_m
        and not is_oncoming(track, ego_speed_mps)
        and _nearest_m(track, path or OwnPath(), corridor.fastest_mps) <= corridor.leave_m
    ]
    return tuple(sorted(near, key=lambda track: track.distance_m))


def _nearest_m(track: Track, path: OwnPath, fastest_mps: float) -> float:
    """How near the vehicle comes to the middle of the path within `RIVAL_AHEAD_S`."""
    if track.in_path:
        return 0.0
    aside_m = track.lateral_m - path.lateral_at(track.distance_m)
    speed_mps = min(max(track.lateral_speed_mps, -fastest_mps), fastest_mps)
    soon_m = aside_m + speed_mps * RIVAL_AHEAD_S
    return 0.0 if soon_m * aside_m < 0 else min(abs(aside_m), abs(soon_m))
