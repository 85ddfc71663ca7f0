"""What follows the cascade: scores add up, boxes go where the regressor says, and stand apart at the end."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from fcw.detection.decorrelation import SecondStageScorer, learn_filters
from fcw.detection.later_stages import LaterStages
from fcw.detection.model import BoostedTrees, BoxRegressor, Model, SecondStage, VehicleStatistics, Window
from fcw.detection.scanner import Proposals
from fcw.sources.frame import ImageSize

SIZE = ImageSize(640, 360)
WINDOW = Window()
NO_TREES = BoostedTrees(np.zeros((0, 3), np.uint16), np.zeros((0, 3), np.uint8), np.zeros((0, 4), np.float32))
PLAIN = Model(WINDOW, NO_TREES, None, None, VehicleStatistics(1, 2, 4, (10.0,), (1.0,)), -3.0, 1.0, 1.0)


def windows(middles: list[float], scores: list[float], seed: int = 0) -> Proposals:
    """Square windows of 40 px side by side on row 200, with random features."""
    count = len(middles)
    boxes = np.array([[middle - 20, 160, 40, 40] for middle in middles], np.float64)
    placements = np.array([[middle, 200, 40] for middle in middles], np.float64)
    features = np.random.default_rng(seed).integers(0, 256, (count, 2560), np.uint8)
    return Proposals(boxes, placements, np.array(scores, np.float32), features)


def moving(dx: float, dy: float, log_w: float, log_h: float) -> BoxRegressor:
    """The same displacement whatever is seen."""
    return BoxRegressor(np.zeros((2560, 3), np.float32), np.array([dx, log_w, log_h], np.float32), dy)


def second_stage(features: NDArray[np.uint8]) -> SecondStage:
    generator = np.random.default_rng(1)
    trees = BoostedTrees(
        generator.integers(0, 5760, (30, 3)).astype(np.uint16),
        generator.integers(100, 150, (30, 3)).astype(np.uint8),
        generator.normal(size=(30, 4)).astype(np.float32),
    )
    return SecondStage(*learn_filters(features, WINDOW), trees=trees)


def test_the_score_is_the_sum_of_both_stages_and_orders_the_vehicles():
    found = windows([100, 300, 500], [3.0, 2.0, 1.0])
    assert found.features is not None
    stage = second_stage(found.features)
    vehicles = LaterStages(replace(PLAIN, second=stage)).vehicles(found, 0.5, SIZE)
    total = found.scores + SecondStageScorer(stage, WINDOW).scores(found.features)
    assert vehicles.windows.tolist() == np.argsort(-total).tolist() != [0, 1, 2]
    np.testing.assert_allclose(vehicles.scores, total[vehicles.windows], atol=1e-6)


def test_every_window_that_passes_the_cascade_matters_to_a_second_stage():
    found = windows([100], [3.0])
    assert found.features is not None
    assert LaterStages(replace(PLAIN, second=second_stage(found.features))).gate(5.0) == -np.inf
    assert LaterStages(PLAIN).gate(5.0) == 0.0  # those above 0 have a say in the box
    assert LaterStages(PLAIN).gate(-2.0) == -2.0


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
    empty = windows([], [])
    nothing = Proposals(
        empty.boxes.reshape(0, 4), empty.placements.reshape(0, 3), empty.scores, empty.features
    )
    stages = LaterStages(replace(PLAIN, regressor=moving(0, 0, 0, 0)))
    assert stages.vehicles(nothing, 0.5, SIZE).boxes.shape == (0, 4)
