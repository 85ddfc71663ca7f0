"""What a person is told with a warning."""

import pytest
from leads.warning_leads import make_lead, threats_of_lead

from fcw.warning.describe import REASONS, braking_text, describe
from fcw.warning.policies import POLICIES, make_policy
from fcw.warning.types import WarningLevel, WarningState


def shown(track, own_mps=20.0, policy="timely-braking"):
    warner = make_policy(policy)
    warner.update(0, threats_of_lead(track, own_mps), own_mps)
    return warner.update(10**9, threats_of_lead(track, own_mps), own_mps)


def test_description_gives_level_reason_vehicle_interval_and_figures():
    # At 10 m/s: 12 m of reaction and 100 / (2 * 3.92266) = 12.75 m of braking; of 18 m 6.7 are missing.
    state = shown(make_lead(18.0, 10.0, track_id=4, spread=0.05))
    assert describe(state) == (
        "warning: braking is due, because with 1.2 s to react and 0.40 g you are 6.7 m too close; vehicle "
        "4 at 18.0 m (17.1 m to 18.9 m), closing at 36 km/h, collision in 1.8 s, needs 0.28 g, headway 0.9 "
        "s"
    )
    assert "59 ft (56 ft to 62 ft), closing at 22 mph" in describe(state, imperial=True)
    assert describe(WarningState(WarningLevel.NONE)) == "no warning"


@pytest.mark.parametrize(
    ("deceleration_mps2", "text"), [(4.0, "0.41 g"), (25.0, "over 2 g"), (float("inf"), "over 2 g")]
)
def test_braking_that_no_car_can_do_is_not_told_by_its_figure(deceleration_mps2, text):
    assert braking_text(deceleration_mps2) == text


def test_what_is_left_behind_the_vehicle_is_said_where_there_is_some():
    # At 5 m/s 6 m of reaction and 3.19 m of braking; 10 % of 10 m is uncertain, 1.65 times that is 1.65 m.
    state = shown(make_lead(10.0, 5.0, spread=0.1))
    assert state.level == WarningLevel.WARNING
    assert "because with 1.2 s to react and 0.40 g you would stay only 0.8 m clear" in describe(state)


@pytest.mark.parametrize(
    ("policy", "track", "words"),
    [
        ("ttc", make_lead(24.0, 10.0), "short time to collision, less than 2.7 s"),
        ("headway", make_lead(9.0, 0.0), "following too closely, less than 0.6 s"),
        (
            "required-deceleration",
            make_lead(9.0, 10.0),
            "hard braking is required, more than 0.68 g after 0.75 s",
        ),
        (
            "rss",
            make_lead(19.0, 0.0),
            "closer than the safe distance of 20 m, for 1.0 s to react and 0.41 g if it",
        ),
    ],
)
def test_every_rule_says_its_threshold_and_what_it_assumes(policy, track, words):
    assert words in describe(shown(track, policy=policy))


def test_what_is_only_perhaps_so_or_was_so_is_not_said_to_be():
    # By the means; 1.65 sigma faster it is 3.0 s.
    uncertain = describe(shown(make_lead(36.0, 8.0, 2.5, spread=0.1), policy="ttc"))
    assert "short time to collision, perhaps less than 3.0 s; " in uncertain
    assert "collision in 4.5 s" in uncertain
    policy, own_mps = make_policy(), 25.0
    for at_ns, distance_m in ((0, 14.0), (10**9, 14.0), (3 * 10**9, 17.0)):
        state = policy.update(at_ns, threats_of_lead(make_lead(distance_m, 0.0), own_mps), own_mps)
    assert "following too closely, recently less than 0.6 s; " in describe(state)
    assert "headway 0.7 s" in describe(state)


def test_a_vehicle_that_is_lost_is_told_as_it_would_be_by_now():
    policy, track = make_policy(), make_lead(18.0, 10.0, track_id=4)
    policy.update(0, threats_of_lead(track, 20.0), 20.0)
    policy.update(10**9, threats_of_lead(track, 20.0), 20.0)
    state = policy.update(1_500_000_000, (), 20.0)
    # Half a second later, 5 m nearer: 100 / (2 * 13) m/s^2.
    assert "vehicle 4, not seen any more, at 13.0 m" in describe(state)
    assert "collision in 1.3 s, needs 0.39 g, headway 0.7 s" in describe(state)


def test_every_rule_has_words():
    rules = {rule.name for entry in POLICIES.values() for rule in entry.rules(0.0)}
    assert rules == set(REASONS)
