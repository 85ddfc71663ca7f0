"""What follows the cascade: scores add up, boxes go where the regressor says, and stand apart at the end."""

import math
from dataclasses import replace
from itertools import compress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.detection.boxes.overlap import cut_to_picture, intersection_over_union
from fcw.detection.boxes.regression import LARGEST_ENLARGEMENT
from fcw.detection.boxes.suppression import suppress
from fcw.detection.later_stages import AGREEING_IOU, LONE_WEIGHT, UNDECIDED_SCORE, LaterStages
from fcw.detection.model import BoostedTrees, BoxRegressor, Model, SecondStage, VehicleStatistics, Window
from fcw.detection.scanner import Proposals
from fcw.frame import ImageSize

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


def windows_at(boxes: list[list[float]], scores: list[float]) -> Proposals:
    """Windows that expect their vehicles in these boxes."""
    placed = np.array(boxes, np.float64).reshape(-1, 4)
    x, y, w, h = placed.T
    placements = np.column_stack([x + w / 2, y + h, np.sqrt(w * h)])
    features = np.random.default_rng(0).integers(0, 256, (len(placed), 2560), np.uint8)
    return Proposals(placed, placements, np.array(scores, np.float32), None, features)


def test_a_lone_box_stays_and_agreeing_ones_meet_at_their_weighted_mean():
    # Weights are squares of the scores: 3 to 1.
    found = windows_at([[20, 20, 10, 10], [22, 21, 10, 10], [50, 50, 8, 8]], [math.sqrt(3), 1, 0.5])
    vehicles = LaterStages(PLAIN).vehicles(found, 0.5, SIZE)
    np.testing.assert_allclose(vehicles.boxes, [[20.5, 20.25, 10, 10], [50, 50, 8, 8]], rtol=1e-6)


def test_a_window_that_is_no_vehicle_has_no_say_but_stands_for_itself():
    found = windows_at([[20, 20, 10, 10], [22, 21, 10, 10], [50, 50, 8, 8]], [1.0, -0.1, -2.0])
    vehicles = LaterStages(PLAIN).vehicles(found, 0.5, SIZE)
    np.testing.assert_allclose(vehicles.boxes, [[20, 20, 10, 10], [50, 50, 8, 8]])


def test_windows_agree_by_where_they_are_and_vote_for_where_the_regressor_puts_them():
    found = windows_at([[20, 20, 10, 10], [21, 20, 10, 10]], [1.0, 1.0])
    assert found.features is not None
    found.features[:] = 0
    found.features[1, 0] = 100
    weights = np.zeros((2560, 3), np.float32)
    weights[0, 0] = 0.02  # moves the second by twice its size, beyond any agreement
    regressor = BoxRegressor(weights, np.zeros(3, np.float32), 0.0)
    vehicles = LaterStages(replace(PLAIN, regressor=regressor)).vehicles(found, 0.5, SIZE)
    np.testing.assert_allclose(vehicles.boxes, [[30.5, 20, 10, 10]], rtol=1e-5)


def plain_vehicles(
    model: Model, found: Proposals, largest_overlap: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """The later stages in numpy: boxes, scores, windows."""
    scores = found.scores.astype(np.float64)
    if model.second is not None and found.second_scores is not None:
        scores = scores + found.second_scores
    kept = suppress(found.boxes, scores, largest_overlap)
    weights = np.maximum(scores - UNDECIDED_SCORE, 0.0) ** 2
    weights[kept] = np.maximum(weights[kept], LONE_WEIGHT)
    boxes = found.boxes
    if model.regressor is not None and found.features is not None:
        dx, log_w, log_h = (found.features @ model.regressor.weights + model.regressor.constant).T
        middle, bottom, size = found.placements.T
        w, h = (
            size * np.exp(np.clip(value, -LARGEST_ENLARGEMENT, LARGEST_ENLARGEMENT))
            for value in (log_w, log_h)
        )
        bottom = bottom + model.regressor.bottom * size
        boxes = np.column_stack([middle + dx * size - w / 2, bottom - h, w, h])
    iou = intersection_over_union(found.boxes[kept], found.boxes)
    agreeing = np.where(iou >= AGREEING_IOU, weights, 0.0)
    boxes = cut_to_picture(agreeing @ boxes / agreeing.sum(axis=1, keepdims=True), SIZE)
    scores = scores[kept]
    if model.regressor is not None:
        again = suppress(boxes, scores, largest_overlap)
        boxes, scores, kept = boxes[again], scores[again], kept[again]
    return boxes, scores, kept


@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.sampled_from([1, 2, 10, 60]),
    second=st.booleans(),
    regressor=st.booleans(),
)
def test_the_kernel_agrees_with_plain_numpy(seed: int, count: int, second: bool, regressor: bool):
    generator = np.random.default_rng(seed)
    sizes = generator.uniform(20, 80, (count, 2))
    corners = generator.uniform(0, 200, (count, 2))
    found = windows_at(np.hstack([corners, sizes]).tolist(), generator.normal(1, 3, count).tolist())
    second_scores = generator.normal(0, 3, count).astype(np.float32) if second else None
    weights = generator.normal(0, 0.1 / 128 / 50, (2560, 3)).astype(np.float32)
    constant = generator.normal(0, 0.1, 3).astype(np.float32)
    model = replace(
        PLAIN,
        second=SECOND if second else None,
        regressor=BoxRegressor(weights, constant, 0.02) if regressor else None,
    )
    found = replace(found, second_scores=second_scores)
    vehicles = LaterStages(model).vehicles(found, 0.5, SIZE)
    boxes, scores, kept = plain_vehicles(model, found, 0.5)
    assert vehicles.windows.tolist() == kept.tolist()
    np.testing.assert_allclose(vehicles.scores, scores, rtol=1e-6)
    np.testing.assert_allclose(vehicles.boxes, boxes, rtol=1e-4, atol=1e-3)


def test_proposals_that_lack_what_the_model_needs_are_refused():
    bare = replace(windows([100], [3.0]), features=None)
    with pytest.raises(ValueError, match="features"):
        LaterStages(replace(PLAIN, regressor=moving(0, 0, 0, 0))).vehicles(bare, 0.5, SIZE)
    with pytest.raises(ValueError, match="second stage"):
        LaterStages(replace(PLAIN, second=SECOND)).vehicles(bare, 0.5, SIZE)
    assert len(LaterStages(PLAIN).vehicles(bare, 0.5, SIZE).boxes) == 1


def test_no_windows_are_no_vehicles():
    stages = LaterStages(replace(PLAIN, regressor=moving(0, 0, 0, 0)))
    assert stages.vehicles(empty(), 0.5, SIZE).boxes.shape == (0, 4)
