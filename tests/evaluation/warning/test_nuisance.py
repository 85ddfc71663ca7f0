"""Nuisance by policy: what is asked earlier is said more often, and RSS warns of ordinary following."""

import pytest

from fcw.evaluation.warning.nuisance import Policy, all_policies, nuisance_following
from fcw.evaluation.warning.scenarios import BoxLevel
from fcw.evaluation.warning.sights import SIGHTS
from fcw.evaluation.warning.variants import half_in_the_way
from fcw.warning.types import WarningLevel


@pytest.mark.slow
def test_rss_warns_of_ordinary_following_and_the_default_does_not():
    policies = (Policy("timely-braking", "normal"), Policy("rss", "normal"))
    default, rss = nuisance_following(policies, BoxLevel(frame_rate_hz=10.0), 0.05, 0).values()
    assert default[WarningLevel.WARNING] == 0
    assert rss[WarningLevel.WARNING] > 0


def test_every_policy_is_there_with_every_timing():
    assert {(each.name, each.timing) for each in all_policies()} >= {
        ("timely-braking", "early"),
        ("timely-braking", "normal"),
        ("ttc", "late"),
    }


def test_the_variants_differ_in_what_the_danger_does():
    scenarios = dict(half_in_the_way())
    assert len(scenarios) == 12
    assert len({scenario.vehicles for scenario in scenarios.values()}) == 12
    assert len({sight.name for sight in SIGHTS}) == len(SIGHTS)
