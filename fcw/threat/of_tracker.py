"""A tracker that is told all of our own motion, and the threats of what it follows."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fcw.detection.detector import Detection
from fcw.motion.bend.turn import Turn, turn_of
from fcw.motion.ego import Ego
from fcw.motion.flow.cuts import Follows
from fcw.motion.state import OwnPath
from fcw.threat.own_path import assumed_path
from fcw.threat.threat import Threat, assess
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track


def track_frame(
    tracker: Tracker,
    time_ns: int,
    detections: Sequence[Detection] | None,
    ego: Ego,
    image: NDArray[np.uint8] | None = None,
) -> tuple[Track, ...]:
    """The confirmed tracks after a frame, for which the tracker is told all that is believed of ourselves.

    After a cut no vehicle is the same. A picture that is unlike those before tells nothing of them.

    Args:
        tracker: takes the frame.
        time_ns: of the frame.
        detections: in it; None where it was not searched.
        ego: own motion and path at this frame.
        image: (height, width, 3) BGR; None where there are boxes alone.

    Raises:
        ValueError: as `Tracker.update`.
    """
    if ego.follows is Follows.AFTER_CUT:
        tracker.begin_anew()
    if ego.follows is Follows.UNLIKE:
        detections = image = None
    return tracker.update(
        time_ns,
        detections,
        ego.motion.speed_mps,
        image=image,
        path=ego.path,
        mount=ego.motion.mount,
        ego_speed_sigma_mps=ego.motion.speed_sigma_mps,
        turn=turn_of(ego.motion),
        body_pitch_rad=ego.body_pitch_rad,
    )


def judge_tracks(tracker: Tracker, tracks: Sequence[Track], ego: Ego) -> tuple[Threat, ...]:
    """The threats of what `track_frame` gave, the most urgent first, by all that is believed of ourselves."""
    return threats_of(
        tracker,
        tracks,
        ego.motion.speed_mps,
        path=ego.path,
        turn=turn_of(ego.motion),
        own_sigma_mps=ego.motion.speed_sigma_mps,
    )


def threats_of(
    tracker: Tracker,
    tracks: Sequence[Track],
    own_mps: float | None,
    path: OwnPath | None = None,
    turn: Turn | None = None,
    own_sigma_mps: float | None = None,
) -> tuple[Threat, ...]:
    """The threats of a frame's vehicles, the most urgent first.

    Args:
        tracker: after its update with that frame.
        tracks: what the update gave.
        own_mps: own speed; None when it was not told: then the tracker's tells who comes towards us.
        path: our own where it was measured; None for what the speed says of it.
        turn: our turning now where it was measured; None takes the path to bend as we turn.
        own_sigma_mps: 1-sigma of the own speed where it was measured; None or 0 where it was given.
    """
    path = path or assumed_path(own_mps)
    if own_mps is None and (held := tracker.own_speed) is not None:
        own_mps, own_sigma_mps = held.value, held.sigma
    return assess(tracks, tracker.lead_id, path, own_mps, tracker.reference_offset_m, turn, own_sigma_mps)
