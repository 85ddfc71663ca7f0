"""What the detector found for a moment, and the picture carries for long, raises nothing."""

import pytest
from leads.warning_leads import make_lead, threats_of_lead

from fcw.tracking.types import SeenBy
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel

STEP_NS = 33_333_333


def levels(found_s, carried_s, safe_s, own_mps=15.0):
    """By frame: a vehicle far away for `safe_s`, near and closing afterwards; found, then carried."""
    policy, shown = make_policy(), []
    for frame in range(round((found_s + carried_s) * 1e9 / STEP_NS)):
        time_s = frame * STEP_NS / 1e9
        seen_by = SeenBy.DETECTOR if time_s < found_s else SeenBy.PICTURE
        lead = make_lead(200.0, 0.1, seen_by=seen_by, age_s=1.0 + time_s)
        if time_s >= safe_s:
            lead = make_lead(15.0, 10.0, 0.5, seen_by=seen_by, age_s=1.0 + time_s)
        shown.append(policy.update(frame * STEP_NS, threats_of_lead(lead, own_mps), own_mps).level)
    return shown


@pytest.mark.parametrize("found_s", [0.1, 0.3, 0.9])
def test_what_is_carried_for_longer_than_it_was_found_raises_nothing(found_s):
    assert set(levels(found_s, 4.0, safe_s=2.1 * found_s)) == {WarningLevel.NONE}


@pytest.mark.parametrize(
    ("seen_by", "level"),
    [(SeenBy.DETECTOR, WarningLevel.WARNING), (SeenBy.PICTURE, WarningLevel.NONE)],
)
def test_what_was_just_found_near_raises_a_warning_by_the_detectors_word_alone(seen_by, level):
    policy, shown = make_policy(), []
    for frame in range(16):
        now = SeenBy.DETECTOR if frame < 10 else seen_by
        # Too far away to be imminent until the detector's word counts.
        lead = make_lead(15.0 if frame >= 10 else 40.0, 10.0, 0.5, seen_by=now, age_s=0.1 + 0.033 * frame)
        shown.append(policy.update(frame * STEP_NS, threats_of_lead(lead, 15.0), 15.0).level)
    assert shown[-1] == level


def test_a_lead_that_was_found_for_longer_than_it_is_carried_is_warned_of():
    assert levels(3.0, 2.0, safe_s=4.0)[-1] == WarningLevel.WARNING


def test_a_warning_that_is_shown_goes_on_while_the_lead_is_carried():
    shown = levels(1.5, 4.0, safe_s=1.0)
    assert shown[round(1.45e9 / STEP_NS)] == WarningLevel.WARNING
    assert shown[-1] == WarningLevel.WARNING
