"""What holds a level, and what raises a higher one."""

from dataclasses import replace

import pytest
from leads.warning_leads import make_lead, threats_of_lead

from fcw.threat.threat import Threat
from fcw.warning.policies import make_policy
from fcw.warning.types import BeginsAnew, WarningLevel


@pytest.mark.parametrize(("probability", "level"), [(0.3, WarningLevel.CAUTION), (0.6, WarningLevel.WARNING)])
def test_what_holds_a_level_does_not_raise_a_higher_one(probability, level):
    policy, far = make_policy(), threats_of_lead(make_lead(11.0, 5.0), is_lead=False)
    states = [policy.update(at_ns, far, None) for at_ns in (0, 6 * 10**8, 10**9)]
    assert states[-1].level == WarningLevel.CAUTION
    (near,) = threats_of_lead(make_lead(8.0, 5.0), is_lead=False)
    near = replace(near, overlap_m=-0.2, overlap_probability=probability, clear_s=None)
    assert policy.update(16 * 10**8, (near,), None).level == level


def lost_at(ttc_s: float, cut: bool = False) -> list[WarningLevel]:
    """Levels after a vehicle that is warned of, at 10 m/s, is followed no more: by tenths of a second."""
    policy = make_policy()
    assert isinstance(policy, BeginsAnew)

    def after(step: int) -> WarningLevel:
        vehicle = make_lead(10 * (ttc_s + (20 - step) / 10), 10.0)
        return policy.update(step * 10**8, threats_of_lead(vehicle, 20.0), 20.0).level

    assert [after(step) for step in range(21)][-1] == WarningLevel.WARNING
    if cut:
        policy.begin_anew()
    return [policy.update(step * 10**8, (), 20.0).level for step in range(21, 51)]


def test_a_warning_lasts_while_its_vehicle_is_lost_from_sight_just_before_it_is_hit():
    assert lost_at(1.5)[:9] == [WarningLevel.WARNING] * 9


def test_it_lasts_no_longer_than_until_the_vehicle_is_reached_and_never_longer_than_a_second():
    assert lost_at(0.5)[6:] == [WarningLevel.NONE] * 24
    assert lost_at(2.0)[10:] == [WarningLevel.NONE] * 20


def test_over_a_cut_no_warning_lasts():
    assert lost_at(1.5, cut=True) == [WarningLevel.NONE] * 30


def test_a_warning_of_an_oncoming_vehicle_lasts_while_it_may_be_hit():
    policy = make_policy()
    oncoming = make_lead(50, 30, 1.0)
    (threat,) = threats_of_lead(oncoming, 15.0, is_lead=False)
    assert threat.is_oncoming
    sure, less, hardly = (replace(threat, overlap_probability=p) for p in (0.9, 0.5, 0.1))
    times_ns = iter(range(0, 10**11, 10**8))

    def level_after(one: Threat, steps: int) -> WarningLevel:
        return [policy.update(next(times_ns), (one,), 15.0).level for _ in range(steps)][-1]

    assert level_after(less, 12) == WarningLevel.NONE
    assert level_after(sure, 12) == WarningLevel.WARNING
    assert level_after(less, 20) == WarningLevel.WARNING
    assert level_after(hardly, 20) == WarningLevel.NONE


@pytest.mark.parametrize("is_lead", [True, False])
def test_a_warning_lasts_while_its_vehicle_may_be_hit_whether_or_not_it_is_the_lead(is_lead):
    policy = make_policy()
    (sure,) = threats_of_lead(make_lead(11.0, 10.0), is_lead=is_lead)
    less, hardly = (replace(sure, overlap_m=-0.2, clear_s=None, overlap_probability=p) for p in (0.3, 0.1))
    levels = [
        policy.update(step * 10**8, ((sure, less, hardly)[step // 15],), None).level for step in range(45)
    ]
    assert levels[14] == levels[29] == WarningLevel.WARNING
    assert levels[44] == WarningLevel.NONE
