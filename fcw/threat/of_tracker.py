"""The threats of what a tracker follows."""

from collections.abc import Sequence

from fcw.motion.bend.turn import Turn
from fcw.motion.state import OwnPath
from fcw.threat.own_path import assumed_path
from fcw.threat.threat import Threat, assess
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track


def threats_of(
    tracker: Tracker,
    tracks: Sequence[Track],
    own_mps: float | None,
    yaw_rate_radps: float | None = None,
    path: OwnPath | None = None,
    turn: Turn | None = None,
    own_sigma_mps: float | None = None,
) -> tuple[Threat, ...]:
    """The threats of a frame's vehicles, the most urgent first.

    Args:
        tracker: after its update with that frame.
        tracks: what the update gave.
        own_mps: own speed; None when it was not told: then the tracker's tells who comes towards us.
        yaw_rate_radps: how fast we turn, positive to the left; None when unknown.
        path: our own where it was measured; None for what speed and yaw rate say of it.
        turn: our turning now where it was measured; None takes the path to bend as we turn.
        own_sigma_mps: 1-sigma of the own speed where it was measured; None or 0 where it was given.
    """
    path = path or assumed_path(own_mps, yaw_rate_radps)
    if own_mps is None and (held := tracker.own_speed) is not None:
        own_mps, own_sigma_mps = held.value, held.sigma
    return assess(tracks, tracker.lead_id, path, own_mps, tracker.reference_offset_m, turn, own_sigma_mps)
