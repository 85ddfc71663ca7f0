"""A larger danger is warned of no later than a smaller one, and one that no rule knows not at all."""

from dataclasses import replace

import pytest
from leads.warning_leads import make_lead, threats_of_lead

from fcw.tracking.types import Track
from fcw.warning.policies import POLICIES, make_policy
from fcw.warning.types import WarningLevel


def level_of(track: Track, own_mps: float | None, policy: str = "timely-braking") -> WarningLevel:
    """The level after this has been seen for a second."""
    warner, threats = make_policy(policy), threats_of_lead(track, own_mps)
    return [warner.update(step * 10**8, threats, own_mps).level for step in range(11)][-1]


@pytest.mark.parametrize("policy", POLICIES)
def test_where_no_rule_applies_even_a_gap_of_nothing_raises_no_level(policy: str):
    """As in a queue, where the bumper seems to touch the car ahead."""
    assert level_of(make_lead(0.0, 0.0), None, policy) == WarningLevel.NONE
    assert policy == "rss" or level_of(make_lead(0.0, 0.0), 3.0, policy) == WarningLevel.NONE


@pytest.mark.parametrize("policy", ["ttc", "timely-braking"])
@pytest.mark.parametrize("spread", [0.05, 0.2])
@pytest.mark.parametrize("distance_m", [14.0, 17.0, 20.0, 24.0])
def test_who_closes_faster_is_warned_of_no_less(policy: str, spread: float, distance_m: float):
    levels = [
        level_of(make_lead(distance_m, tenths / 10, 0.5, spread=spread), 30.0, policy)
        for tenths in range(15, 80)
    ]
    assert levels == sorted(levels)


def test_an_approach_too_slow_for_a_time_to_collision_has_none_however_uncertain_it_is():
    # At 4.1 +- 0.5 m/s and 20 m collision is 4.9 s away.
    assert level_of(make_lead(20.0, 4.1, 0.5, spread=0.05), 20.0, "ttc") == WarningLevel.NONE


@pytest.mark.parametrize(
    ("distance_m", "closing_mps", "sigma_mps"), [(109.5, 20.5, 5.8), (69.8, 15.3, 4.5), (86.0, 20.0, 1.0)]
)
def test_a_lead_that_brakes_is_warned_of_no_less_than_one_that_does_not(
    distance_m: float, closing_mps: float, sigma_mps: float
):
    steady = make_lead(distance_m, closing_mps, sigma_mps, growth_sigma_mps2=0.5, spread=0.1)
    for own_mps in (30.0, None):
        brakes = [
            level_of(replace(steady, closing_acceleration_mps2=growth_mps2), own_mps)
            for growth_mps2 in (0.99, 1.01, 1.3, 2.0, 3.0, 5.0)
        ]
        assert brakes == sorted(brakes)
    assert brakes[-1] == WarningLevel.WARNING
