"""A larger danger is warned of no later than a smaller one, and one that no rule knows not at all."""

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
