"""What follows the cascade: scores add up, boxes go where the regressor says, and stand apart at the end."""

from dataclasses import replace
from itertools import compress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fcw.detection.later_stages import LaterStages
from fcw.detection.model import BoostedTrees, BoxRegressor, Model, SecondStage, VehicleStatistics, Window
from fcw.detection.scanner import Proposals
from fcw.sources.frame import ImageSize

SIZE = ImageSize(640, 360)
WINDOW = Window()
NO_TREES = BoostedTrees(np.zeros((0, 3), np.uint16), np.zeros((0, 3), np.uint8), np.zeros((0, 4), np.float32))
PLAIN = Model(WINDOW, NO_TREES, None, None, VehicleStatistics(1, 2, 4, (10.0,), (1.0,)), -3.0, 1.0, 1.0)


def windows(
    middles: list[float], scores: list[float], second_scores: list[float] | None = None, seed: int = 0
) -> Proposals:
    """Square windows of 40 px side by side on row 200, with random features."""
    count = len(middles)
    boxes = np.array([[middle - 20, 160, 40, 40] for middle in middles], np.float64)
    placements = np.array([[middle, 200, 40] for middle in middles], np.float64)
    features = np.random.default_rng(seed).integers(0, 256, (count, 2560), np.uint8)
    second = None if second_scores is None else np.array(second_scores, np.float32)
    return Proposals(boxes, placements, np.array(scores, np.float32), second, features)


def empty() -> Proposals:
    none = windows([], [])
    return replace(none, boxes=none.boxes.reshape(0, 4), placements=none.placements.reshape(0, 3))


def moving(dx: float, dy: float, log_w: float, log_h: float) -> BoxRegressor:
    """The same displacement whatever is seen."""
    return BoxRegressor(np.zeros((2560, 3), np.float32), np.array([dx, log_w, log_h], np.float32), dy)


SECOND = SecondStage(
    np.zeros((10, 4, 5, 5), np.int8), np.zeros((10, 4), np.int32), np.zeros((10, 4), np.uint8), NO_TREES
)


def test_the_score_is_the_sum_of_both_stages_and_orders_the_vehicles():
    found = windows([100, 300, 500], [3.0, 2.0, 1.0], [-1.0, 1.5, 0.5])
    vehicles = LaterStages(replace(PLAIN, second=SECOND)).vehicles(found, 0.5, SIZE)
    assert vehicles.windows.tolist() == [1, 0, 2]
    assert vehicles.scores.tolist() == [3.5, 2.0, 1.5]
    assert LaterStages(PLAIN).vehicles(found, 0.5, SIZE).windows.tolist() == [0, 1, 2]


@settings(max_examples=100, deadline=None)
@given(
    middles=st.lists(st.integers(20, 200), min_size=1, max_size=12),
    seed=st.integers(0, 1000),
    threshold=st.sampled_from([-2.0, 0.0, 1.5]),
)
def test_windows_below_the_gate_do_not_matter_for_vehicles_above_the_threshold(
    middles: list[int], seed: int, threshold: float
):
    scores = np.random.default_rng(seed).normal(0, 3, len(middles)).tolist()
    stages = LaterStages(replace(PLAIN, regressor=moving(0.1, 0.0, 0.1, 0.0)))
    passing = [score >= stages.gate(threshold) for score in scores]
    some = windows(list(compress(middles, passing)), list(compress(scores, passing)))
    if not any(passing):
        some = empty()
    everything, gated = (
        stages.vehicles(found, 0.5, SIZE) for found in (windows(list(middles), scores), some)
    )
    above = everything.scores >= threshold
    np.testing.assert_allclose(gated.boxes[gated.scores >= threshold], everything.boxes[above], atol=1e-6)


def test_boxes_go_where_the_regressor_puts_them():
    model = replace(PLAIN, regressor=moving(0.1, -0.05, 0.2, -0.1))
    box = LaterStages(model).vehicles(windows([100], [3.0]), 0.5, SIZE).boxes[0]
    w, h = 40 * np.exp(0.2), 40 * np.exp(-0.1)
    np.testing.assert_allclose(box, [104 - w / 2, 198 - h, w, h], atol=1e-4)


@pytest.mark.parametrize(("log_w", "kept"), [(0.0, 2), (0.65, 1)])
def test_boxes_that_the_regressor_moves_onto_each_other_are_one_vehicle(log_w: float, kept: int):
    model = replace(PLAIN, regressor=moving(0, 0, log_w, 0))
    # 32 px apart: a fifth of 40 px in common, but of 77 px more than half.
    vehicles = LaterStages(model).vehicles(windows([100, 132], [3.0, 2.0]), 0.5, SIZE)
    assert vehicles.windows.tolist() == [0, 1][:kept]
    assert len(vehicles.boxes) == len(vehicles.scores) == kept


def test_boxes_are_cut_to_the_picture():
    box = LaterStages(replace(PLAIN, regressor=moving(0, 0, 0.5, 0))).vehicles(
        windows([10], [1.0]), 0.5, SIZE
    )
    assert box.boxes[0, 0] == -0.5


def test_no_windows_are_no_vehicles():
    stages = LaterStages(replace(PLAIN, regressor=moving(0, 0, 0, 0)))
    assert stages.vehicles(empty(), 0.5, SIZE).boxes.shape == (0, 4)
