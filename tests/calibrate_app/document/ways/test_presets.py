"""The presets give distances that the document can plan, and enough of them."""

import math

import pytest
from session_helpers import SIZE

from fcw.camera.points import PARAMETER_COUNT
from fcw.errors import UserError
from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.document.document import Document
from fcw_viz.calibrate_app.document.edits import PlanDistances
from fcw_viz.calibrate_app.document.ways.presets import DASH_PRESETS, RECTANGLE_PRESETS, TAPE_PRESETS

BY_PLACE = {preset.name: preset for preset in DASH_PRESETS}


def dashes(place):
    return next(preset for name, preset in BY_PLACE.items() if name.startswith(place))


def test_the_papers_tape_measure_comes_first():
    assert TAPE_PRESETS[0].distances_m == (4.0, 5.0, 7.0)


@pytest.mark.parametrize("preset", TAPE_PRESETS, ids=lambda preset: preset.name)
def test_known_distances_determine_a_camera_and_are_in_the_order_of_clicking(preset):
    assert len(preset.distances_m) >= PARAMETER_COUNT
    assert list(preset.distances_m) == sorted(set(preset.distances_m))
    assert "nearest first" in preset.instruction
    planned = PlanDistances(preset.distances_m).apply(Document(SIZE))
    assert planned.next_planned_m == preset.distances_m[0]


@pytest.mark.parametrize(
    ("place", "line_and_gap_m"),
    [
        ("USA", 10 / FEET_PER_METRE + 30 / FEET_PER_METRE),
        ("California", 12 / FEET_PER_METRE + 36 / FEET_PER_METRE),
        ("Germany", 6 + 12),
        ("Britain", 2 + 7),
    ],
)
def test_lane_dashes_repeat_after_a_line_and_a_gap(place, line_and_gap_m):
    preset = dashes(place).starting_at(6.5)
    steps = [far - near for near, far in zip(preset.distances_m, preset.distances_m[1:], strict=False)]
    assert preset.distances_m[0] == 6.5
    assert steps == pytest.approx([line_and_gap_m] * len(steps), abs=1e-3)
    assert len(preset.distances_m) >= PARAMETER_COUNT


def test_bays_are_of_the_size_that_their_country_says_and_stray_from_it():
    sizes = {preset.name: [side.value for side in preset.sides_m] for preset in RECTANGLE_PRESETS}
    assert sizes["Parking bay, Germany: 2.50 x 5.00 m"] == [2.5, 5.0]
    assert sizes["Parking bay, USA: 2.74 x 5.49 m"] == pytest.approx([9 * 0.3048, 18 * 0.3048], abs=0.01)
    assert all(0.03 < side.sigma / side.value < 0.1 for p in RECTANGLE_PRESETS for side in p.sides_m)


@pytest.mark.parametrize("first_m", [0.0, -3.0, math.nan, math.inf])
def test_a_first_distance_that_is_none_is_refused(first_m):
    with pytest.raises(UserError, match="distance of the first mark"):
        DASH_PRESETS[0].starting_at(first_m)
