"""The threats of the vehicles that a tracker follows."""

from collections.abc import Sequence

from fcw.motion.bend.turn import turn_of
from fcw.motion.ego import NOTHING_KNOWN, Ego
from fcw.threat.threat import Threat, assess
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track


def threats_of(tracker: Tracker, tracks: Sequence[Track], ego: Ego = NOTHING_KNOWN) -> tuple[Threat, ...]:
    """The threats of a frame's vehicles, the most urgent first.

    Args:
        tracker: the tracker, already updated with that frame.
        tracks: the tracks that this update returned.
        ego: the own motion and path that the update was given. If it has no own speed, the tracker's last
            known one is used.
    """
    own_mps, own_sigma_mps = ego.motion.speed_mps, ego.motion.speed_sigma_mps
    if own_mps is None and (held := tracker.own_speed) is not None:
        own_mps, own_sigma_mps = held.value, held.sigma
    turn = turn_of(ego.motion)
    return assess(tracks, tracker.lead_id, ego.path, own_mps, tracker.reference_offset_m, turn, own_sigma_mps)
