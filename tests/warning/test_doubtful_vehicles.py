"""What may be no vehicle raises nothing, and its time counts once it is believed."""

from dataclasses import replace

from leads.warning_leads import make_lead, threats_of_lead

from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel


def test_what_may_be_no_vehicle_raises_nothing_and_is_warned_of_as_soon_as_it_is_believed():
    policy, vehicle = make_policy(), make_lead(15, 15)
    doubtful = threats_of_lead(replace(vehicle, doubtful=True), None, is_lead=False)
    states = [policy.update(at_ns, doubtful, None) for at_ns in (0, 6 * 10**8, 10**9)]
    assert [state.level for state in states] == [WarningLevel.NONE] * 3
    assert policy.update(10**9 + 1, threats_of_lead(vehicle, None), None).level == WarningLevel.WARNING
