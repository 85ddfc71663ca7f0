"""The own path on a simulated bend, from pictures."""

import pytest

from fcw.evaluation.motion.bends import bend_scenario, evaluate_bends


def test_a_bend_is_driven_no_faster_than_people_do():
    for radius_m in (150.0, -800.0):
        speed_mps = bend_scenario(radius_m).ego.speed_kmh / 3.6
        assert speed_mps**2 / abs(radius_m) <= 1.2 + 1e-9


@pytest.mark.slow
def test_the_path_is_met_within_half_a_metre_at_thirty_metres():
    (bend,) = evaluate_bends([150.0])
    assert bend.median_m <= 0.5
    assert bend.without_lines_median_m <= 0.5
