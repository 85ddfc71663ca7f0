"""Who comes towards us, while our own speed is not told for a moment."""

import numpy as np
import pytest

from fcw.evaluation.warning.scenarios import BoxLevel
from fcw.motion.ego import assumed_ego
from fcw.threat.of_tracker import threats_of

OWN_MPS, CLOSING_MPS = 14.0, 28.0
RATE_HZ = 30
TOLD_FRAMES, FRAMES = 60, 75


@pytest.mark.parametrize("seed", range(3))
def test_who_comes_towards_us_does_so_too_while_our_speed_is_not_told_for_a_moment(seed):
    view, rng = BoxLevel(), np.random.default_rng(seed)
    tracker, oncoming = view.tracker(rng), []
    for frame in range(FRAMES):
        told_mps = OWN_MPS if frame < TOLD_FRAMES else None
        found = view.see(90 - CLOSING_MPS * frame / RATE_HZ, 1.75, rng, lateral_m=3.5)
        ego = assumed_ego(told_mps)
        tracks = tracker.update(round(frame * 1e9 / RATE_HZ), found, ego)
        oncoming += [threat.is_oncoming for threat in threats_of(tracker, tracks, ego)]
    assert all(oncoming[TOLD_FRAMES - FRAMES - 1 :])
    assert tracker.lead_id is None
