"""What a person is told with a warning."""

from warning_leads import make_lead

from fcw.warning.describe import REASONS, describe
from fcw.warning.policies import POLICIES, make_policy
from fcw.warning.types import WarningLevel, WarningState


def test_description_gives_level_reason_vehicle_interval_and_figures():
    track = make_lead(18.0, 10.0, track_id=4, spread=0.05)
    policy = make_policy()
    policy.update(0, track, 20.0)
    state = policy.update(10**9, track, 20.0)
    assert describe(state, track) == (
        "warning: braking is due; vehicle 4 at 18.0 m (17.1 m to 18.9 m), closing at 36 km/h, "
        "collision in 1.8 s, needs 0.28 g, headway 0.9 s"
    )
    assert "59 ft (56 ft to 62 ft), closing at 22 mph" in describe(state, track, imperial=True)
    assert describe(state, None) == "warning: braking is due; vehicle 4 is no longer seen"
    assert describe(WarningState(WarningLevel.NONE), None) == "no warning"


def test_every_rule_has_words():
    assert {rule.name for entry in POLICIES.values() for rule in entry.rules()} == set(REASONS)
