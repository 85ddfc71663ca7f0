"""Which leads will be out of the way at contact."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from warning_leads import make_lead

from fcw.warning.course import CLEARANCE_M, will_miss


@given(st.floats(2, 80), st.floats(1, 30), st.floats(-1.7, 1.7), st.floats(0.5, 40), st.sampled_from([-1, 1]))
def test_what_keeps_its_bearing_hits_and_what_sweeps_across_misses(
    distance_m, closing_mps, lateral_m, sweep_m, side
):
    ttc_s = min(distance_m / closing_mps, 4.0)
    # On a collision course the lateral offset shrinks with the distance.
    constant = make_lead(distance_m, closing_mps, lateral_m=lateral_m, lateral_mps=-lateral_m / ttc_s)
    assert not will_miss(constant)
    sideways_mps = (side * (CLEARANCE_M + sweep_m) - lateral_m) / ttc_s
    assert will_miss(make_lead(distance_m, closing_mps, lateral_m=lateral_m, lateral_mps=sideways_mps))


@pytest.mark.parametrize(("lateral_mps", "misses"), [(0.44, False), (0.46, True)])
def test_sideways_motion_is_extrapolated_for_four_seconds(lateral_mps, misses):
    assert will_miss(make_lead(40, 1.0, lateral_mps=lateral_mps)) is misses


def test_a_gap_that_does_not_close_has_no_contact_to_miss():
    assert not will_miss(make_lead(10, 0.0, lateral_mps=9.0))
