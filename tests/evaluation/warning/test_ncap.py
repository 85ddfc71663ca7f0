"""The scenarios' motion and their driver by closed forms, and what a warning in them is worth."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.evaluation.warning import scenarios as box_level
from fcw.evaluation.warning.ncap import SETTLE_S, Scenario, euro_ncap_scenarios, nhtsa_scenarios
from fcw.evaluation.warning.scenarios import BoxLevel, judge, run_scenarios, run_trial
from fcw.warning.driver import EXPECTED_DRIVER
from fcw.warning.policies import make_policy
from fcw.warning.types import WarningLevel, WarningState

SCENARIOS = {scenario.name: scenario for scenario in (*nhtsa_scenarios(), *euro_ncap_scenarios())}
REACTION_S, BRAKING_MPS2 = EXPECTED_DRIVER.reaction_s, EXPECTED_DRIVER.braking_mps2


def stopping_m(speed_mps):
    return speed_mps * REACTION_S + speed_mps**2 / (2 * BRAKING_MPS2)


def test_the_scenarios_are_those_of_the_standards():
    assert len(SCENARIOS) == 3 + 6 + 6 + 4 + 12
    # Half of our width of 1.8 m: the middles are 0.9 m apart.
    assert SCENARIOS["CCRs 50 km/h 50% right"].offset_m == pytest.approx(-0.9)
    assert SCENARIOS["CCRs 50 km/h 75% left"].offset_m == pytest.approx(0.45)
    assert SCENARIOS["CCRs 50 km/h"].offset_m == 0
    stopped, braking, slower = nhtsa_scenarios()
    assert [s.required_ttc_s for s in (stopped, braking, slower)] == [2.1, 2.4, 2.0]
    assert [s.own_mps for s in (stopped, braking, slower)] == pytest.approx([45 * 0.44704] * 3)
    assert (braking.gap_m, braking.braking_mps2) == (30, pytest.approx(0.3 * 9.80665))
    assert slower.lead_mps == pytest.approx(20 * 0.44704)
    not_asked = {name for name, scenario in SCENARIOS.items() if not scenario.preventable}
    assert not_asked == {"CCRs 80 km/h", "CCRb 12 m -6 m/s2"}


@pytest.mark.parametrize("name", [name for name in SCENARIOS if name.startswith(("CCRs", "CCRm"))])
def test_at_constant_closing_speed_the_warning_is_due_at_the_drivers_stopping_distance(name):
    scenario = SCENARIOS[name]
    assert scenario.required_gap_m == pytest.approx(
        stopping_m(scenario.own_mps - scenario.lead_mps), abs=0.05
    )


def test_behind_a_lead_that_stands_before_we_do_the_stopping_distances_tell():
    # 40 m, -6 m/s^2: the lead stands after v^2 / 12, we after v (t + 1.2 s) + v^2 / (2 * 0.4 g).
    scenario, speed_mps = SCENARIOS["CCRb 40 m -6 m/s2"], 50 / 3.6
    spare_s = (40 + speed_mps**2 / 12 - stopping_m(speed_mps)) / speed_mps
    assert scenario.latest_warning_s() == pytest.approx(SETTLE_S + spare_s, abs=0.005)
    assert spare_s == pytest.approx(1.07, abs=0.005)


def test_behind_a_lead_that_still_moves_the_gap_is_least_at_equal_speeds():
    # 12 m, -2 m/s^2: t after the onset the warning; closing 2 (t + 1.2) then; it ends at 1.92 m/s^2 more.
    scenario = SCENARIOS["CCRb 12 m -2 m/s2"]
    closing_mps = math.sqrt(2 * 12 / (1 / 2 + 1 / (BRAKING_MPS2 - 2)))
    latest_s = scenario.latest_warning_s()
    assert latest_s == pytest.approx(SETTLE_S + closing_mps / 2 - REACTION_S, abs=0.005)


def test_what_cannot_be_prevented_has_no_latest_warning():
    scenario = SCENARIOS["CCRb 12 m -6 m/s2"]
    assert scenario.latest_warning_s() is None
    assert scenario.required_gap_m is None
    assert scenario.impact_mps(SETTLE_S) > 0


@given(st.floats(1, 60))
def test_impact_on_a_standing_lead_follows_from_the_way_left(warned_at_m):
    scenario = Scenario(name="x", own_mps=15.0, lead_mps=0.0, gap_m=100.0)
    braking_m = max(warned_at_m - 15 * REACTION_S, 0.0)
    expected_mps = math.sqrt(max(15.0**2 - 2 * BRAKING_MPS2 * braking_m, 0.0))
    impact_mps = scenario.impact_mps((100 - warned_at_m) / 15)
    # In steps of a millisecond the way is known to 15 mm.
    assert impact_mps**2 == pytest.approx(expected_mps**2, abs=2 * BRAKING_MPS2 * 0.04)


@given(st.sampled_from(list(SCENARIOS.values())), st.floats(0, 1), st.floats(0, 1))
def test_a_later_warning_never_helps(scenario, first, second):
    early_s, late_s = (part * scenario.crash_s for part in sorted((first, second)))
    assert scenario.impact_mps(early_s) <= scenario.impact_mps(late_s) + 0.01
    assert scenario.impact_mps(late_s) <= scenario.impact_mps(None) + 0.01


def test_nobody_warned_hits_at_the_closing_speed():
    assert SCENARIOS["CCRm 60 km/h"].impact_mps(None) == pytest.approx(40 / 3.6)


@pytest.mark.parametrize(
    "scenario", [s for s in SCENARIOS.values() if s.required_ttc_s is None], ids=lambda s: s.name
)
def test_a_warning_is_in_time_up_to_the_latest_moment_and_not_after(scenario):
    latest_s = scenario.latest_warning_s()
    if latest_s is not None:
        assert judge(scenario, latest_s - 0.01).passed
        assert not judge(scenario, latest_s + 0.01).passed
    never = judge(scenario, None)
    assert (never.passed, never.needless, never.ttc_s) == (False, False, None)


def test_nhtsa_counts_the_ttc():
    scenario = SCENARIOS["NHTSA stopped lead"]
    for ttc_s, passed in ((2.2, True), (2.0, False)):
        trial = judge(scenario, scenario.crash_s - ttc_s)
        assert trial.passed is passed
        assert trial.ttc_s == pytest.approx(ttc_s, abs=0.01)


def test_a_warning_nobody_needs_yet_is_needless():
    scenario = SCENARIOS["CCRm 60 km/h"]
    # At 11.1 m/s the slowest driver needs 39.4 m, which is a TTC of 3.5 s; ISO needs none above 4 s.
    assert judge(scenario, scenario.crash_s - 4.1).needless
    assert not judge(scenario, scenario.crash_s - 3.9).needless
    assert judge(SCENARIOS["NHTSA braking lead"], SETTLE_S - 0.1).needless


class Fixed:
    """Warns from a time on, whatever it sees."""

    name = "fixed"

    def __init__(self, warned_s):
        self.warned_s = warned_s

    def update(self, time_ns, threats, ego_speed_mps):
        level = WarningLevel.WARNING if time_ns / 1e9 >= self.warned_s else WarningLevel.NONE
        return WarningState(level, 1 if level else None, "fixed" if level else "")


@pytest.mark.slow
def test_every_trial_is_judged_by_the_first_warning():
    scenario = SCENARIOS["CCRs 50 km/h"]
    required_s = scenario.latest_warning_s()
    assert required_s is not None
    in_time, late = (
        run_scenarios([scenario], lambda: Fixed(time_s), BoxLevel(), 0)[0]  # noqa: B023
        for time_s in (required_s - 0.1, required_s + 0.1)
    )
    assert (in_time.trials_passed, late.trials_passed) == (7, 0)
    assert [trial.impact_mps > 0 for trial in (*in_time.trials, *late.trials)] == [False] * 7 + [True] * 7
    assert in_time.median("gap_m") == pytest.approx(scenario.required_gap_m, abs=2.0)


@pytest.mark.slow
def test_a_trial_depends_on_its_seed_and_number_alone():
    scenario = SCENARIOS["CCRm 40 km/h"]
    first, again, other = (run_trial(scenario, make_policy, BoxLevel(), 0, number) for number in (3, 3, 4))
    assert first == again
    assert first != other


@given(st.floats(4, 100), st.floats(1.5, 2.5))
def test_boxes_without_noise_are_those_of_the_camera(gap_m, width_m):
    view, rng = BoxLevel(box_noise_px=0.0), np.random.default_rng(0)
    (found,) = view.see(gap_m, width_m, rng)
    depth_m = gap_m + box_level.REFERENCE_OFFSET_M
    assert found.box.w == pytest.approx(721.5 * width_m / depth_m)
    if found.box.bottom < box_level.IMAGE_SIZE.height - 1:
        assert found.box.bottom == pytest.approx(172.9 + 721.5 * 1.65 / depth_m)


def test_beyond_sight_there_is_no_box():
    view, rng = BoxLevel(sight_m=50.0), np.random.default_rng(0)
    assert view.see(50.0, 1.8, rng) == ()
    assert len(view.see(48.0, 1.8, rng)) == 1
