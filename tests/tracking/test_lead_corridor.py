"""The own path: who crosses it comes in once and leaves once."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from fcw.tracking.lead import Corridor

STEP_S = 1 / 30


@given(st.floats(0.2, 4.0), st.sampled_from([-1.0, 1.0]))
def test_a_crossing_vehicle_is_in_the_path_once_without_a_flicker(speed_mps, side):
    corridor, inside, seen = Corridor(), False, []
    steps = round(12.0 / speed_mps / STEP_S)
    for step in range(steps):
        lateral_m = side * (-6.0 + step * STEP_S * speed_mps)
        inside = corridor.holds(lateral_m, side * speed_mps, inside)
        seen.append((abs(lateral_m), inside))
    changes = sum(now != before for (_, before), (_, now) in pairwise(seen))
    assert changes == 2
    assert all(is_inside for distance_m, is_inside in seen if distance_m <= corridor.enter_m)
    assert not any(is_inside for distance_m, is_inside in seen if distance_m > 2.4)
