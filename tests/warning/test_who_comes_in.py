"""Who comes in from beside our path: how likely and for how long, before there is a warning."""

from dataclasses import replace

import pytest
from leads.warning_leads import make_lead, threats_of_lead

from fcw.threat.threat import Threat
from fcw.warning.describe import reason
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel

CLOSING_MPS = 10.0
FRAMES_PER_SECOND = 20


def coming_in(reach_s: float, probability: float, turn_known: bool, beside_m: float) -> Threat:
    """A vehicle that is surely on its way into our path, with so much room left between it and that."""
    (threat,) = threats_of_lead(make_lead(reach_s * CLOSING_MPS, CLOSING_MPS), is_lead=False)
    return replace(
        threat,
        comes_in=True,
        turn_known=turn_known,
        overlap_now_m=-beside_m,
        overlap_probability=probability,
        overlap_m=0.2,  # not so far that nothing else counted
    )


def warned_after_s(threat: Threat) -> float | None:
    """Time from when it is first seen on this course to `warning`; None where there is none in a second."""
    policy = make_policy()
    for frame in range(FRAMES_PER_SECOND + 1):
        time_s = frame / FRAMES_PER_SECOND
        if policy.update(round(time_s * 1e9), (threat,), None).level == WarningLevel.WARNING:
            return time_s
    return None


@pytest.mark.parametrize(
    ("reach_s", "probability", "after_s"), [(1.0, 0.95, 0.2), (1.0, 0.85, 0.3), (2.3, 0.95, 0.3)]
)
def test_who_surely_hits_us_soon_needs_a_fifth_of_a_second_of_evidence(reach_s, probability, after_s):
    for turn_known, beside_m in ((True, 1.0), (False, 0.0)):
        assert warned_after_s(coming_in(reach_s, probability, turn_known, beside_m)) == pytest.approx(after_s)


@pytest.mark.parametrize(
    ("reach_s", "probability", "turn_known", "warned"),
    [
        (1.0, 0.95, False, True),
        (1.0, 0.85, False, False),
        (2.3, 0.95, False, False),
        (2.3, 0.85, True, True),
        (1.0, 0.75, True, False),
    ],
)
def test_from_beside_our_path_our_turning_is_known_or_it_surely_hits_us_soon(
    reach_s, probability, turn_known, warned
):
    threat = coming_in(reach_s, probability, turn_known, beside_m=1.0)
    assert (warned_after_s(threat) is not None) == warned


@pytest.mark.parametrize(("lane_seen", "after_s"), [(True, 0.2), (False, 0.3)])
def test_who_comes_into_a_lane_whose_lines_are_seen_needs_less_evidence(lane_seen, after_s):
    threat = replace(coming_in(2.3, 0.85, turn_known=True, beside_m=0.1), lane_seen=lane_seen)
    assert warned_after_s(threat) == pytest.approx(after_s)


@pytest.mark.parametrize(
    ("lane_seen", "overlap_now_m", "warned"), [(True, 0.5, True), (True, 0.2, False), (False, 0.5, False)]
)
def test_what_stands_in_our_lane_is_warned_of_though_little_steering_would_pass_it(
    lane_seen, overlap_now_m, warned
):
    threat = replace(
        coming_in(2.3, 0.7, turn_known=True, beside_m=-overlap_now_m),
        comes_in=False,
        lane_seen=lane_seen,
        required_lateral_mps2=0.3,
    )
    assert (warned_after_s(threat) is not None) == warned


@pytest.mark.parametrize(
    ("drives", "overlap_now_m", "overlap_m", "bend_changes", "warned"),
    [
        (True, 0.5, 0.5, False, True),
        (True, 0.2, 0.5, False, False),
        (True, 0.5, 0.2, False, False),
        (True, 0.5, 0.5, True, False),
        (False, 0.5, 0.5, False, False),
    ],
)
def test_so_is_who_drives_half_in_our_way_where_no_lines_are_seen(
    drives, overlap_now_m, overlap_m, bend_changes, warned
):
    """What stands may be parked beside our lane, a bend that ends may pass it, and who moves out leaves."""
    threat = replace(
        coming_in(2.3, 0.9, turn_known=True, beside_m=-overlap_now_m),
        comes_in=False,
        overlap_m=overlap_m,
        bend_changes=bend_changes,
        drives=drives,
        required_lateral_mps2=0.3,
    )
    assert (warned_after_s(threat) is not None) == warned


UPON_US = [(1.7, 0.3, True), (1.8, 0.3, False), (1.7, 0.2, False)]
"""Time until it is reached, how far it is in our way then, and whether it is warned of."""


@pytest.mark.parametrize(("reach_s", "overlap_m", "warned"), UPON_US)
def test_a_lead_that_is_upon_us_is_warned_of_though_we_turn_the_wheel(reach_s, overlap_m, warned):
    """Where our path will be is not known then; but who turns it so late does so because of the lead."""
    (threat,) = threats_of_lead(make_lead(reach_s * CLOSING_MPS, CLOSING_MPS))
    threat = replace(threat, bend_changes=True, overlap_probability=0.6, overlap_m=overlap_m)
    assert threat.is_lead
    assert (warned_after_s(threat) is not None) == warned


@pytest.mark.parametrize(("reach_s", "overlap_m", "warned"), UPON_US)
def test_so_is_who_is_upon_us_from_beside_though_our_turning_is_not_known(reach_s, overlap_m, warned):
    threat = coming_in(reach_s, probability=0.6, turn_known=False, beside_m=1.0)
    assert (warned_after_s(replace(threat, overlap_m=overlap_m)) is not None) == warned


def test_what_is_upon_us_by_its_mean_alone_is_not():
    """Its closing speed may be half of what is believed."""
    threat = coming_in(1.5, probability=0.6, turn_known=False, beside_m=1.0)
    assert warned_after_s(replace(threat, overlap_m=0.5, reach_high_s=3.0)) is None


@pytest.mark.parametrize(
    ("reach_s", "clear_s", "overlap_now_m", "bend_changes", "warned"),
    [
        (1.7, 0.9, 0.4, False, True),
        (1.8, 0.9, 0.4, False, False),
        (1.7, 1.1, 0.4, False, False),
        (1.7, None, 0.4, False, False),
        (1.7, 0.9, 0.2, False, False),
        (1.7, 0.9, 0.4, True, False),
    ],
)
def test_what_is_in_our_way_and_would_leave_it_only_just_before_we_are_there_is_warned_of(
    reach_s, clear_s, overlap_now_m, bend_changes, warned
):
    """Nobody relies on it: who crosses in front of us may stop there."""
    (threat,) = threats_of_lead(make_lead(reach_s * CLOSING_MPS, CLOSING_MPS))
    threat = replace(
        threat,
        overlap_now_m=overlap_now_m,
        clear_s=clear_s,
        bend_changes=bend_changes,
        overlap_m=-0.5,
        overlap_probability=0.05,
    )
    assert (warned_after_s(threat) is not None) == warned


@pytest.mark.parametrize(("clear_s", "said"), [(0.9, True), (0.0, False)])
def test_the_reason_says_that_it_would_have_left(clear_s, said):
    (threat,) = threats_of_lead(make_lead(15.0, CLOSING_MPS))
    policy = make_policy()
    for time_ns in (0, 600_000_000):
        state = policy.update(time_ns, (replace(threat, clear_s=clear_s),), None)
    assert state.level == WarningLevel.WARNING
    assert ("0.40 g (if it stays in your way) you are" in reason(state)) == said
