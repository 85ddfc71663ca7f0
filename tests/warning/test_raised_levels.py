"""What holds a level, and what raises a higher one."""

from dataclasses import replace

import pytest
from leads.warning_leads import make_lead, threats_of_lead

from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel


@pytest.mark.parametrize(("probability", "level"), [(0.3, WarningLevel.CAUTION), (0.6, WarningLevel.WARNING)])
def test_what_holds_a_level_does_not_raise_a_higher_one(probability, level):
    policy, far = make_policy(), threats_of_lead(make_lead(11.0, 5.0), is_lead=False)
    states = [policy.update(at_ns, far, None) for at_ns in (0, 6 * 10**8, 10**9)]
    assert states[-1].level == WarningLevel.CAUTION
    (near,) = threats_of_lead(make_lead(8.0, 5.0), is_lead=False)
    near = replace(near, overlap_m=-0.2, overlap_probability=probability)
    assert policy.update(16 * 10**8, (near,), None).level == level
