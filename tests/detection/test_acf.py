"""The two detectors on pictures with vehicles drawn where they should be found."""

import math
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn_vehicles import (
    ASPECT,
    CALIBRATION,
    SIZE,
    STATISTICS,
    WINDOW,
    background,
    box_of,
    draw_vehicle,
    example,
    vehicle_at,
)
from numba.core.runtime import _nrt_python  # pyright: ignore[reportAttributeAccessIssue]
from numba.core.runtime.nrt import rtsys
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.acf import AcfDetector, AcfSettings, FullAcfDetector, FullAcfSettings
from fcw.detection.boxes.overlap import cut_to_picture, intersection_over_union
from fcw.detection.channels.aggregated import compute_channels
from fcw.detection.detector import Detection
from fcw.detection.model import BoostedTrees, BoxRegressor, Model, SecondStage
from fcw.detection.scanner import FIRST_CAPACITY
from fcw.detection.trees.boosting import train_trees
from fcw.errors import UserError


@pytest.fixture(scope="module")
def model() -> Model:
    rng = np.random.default_rng(1)
    positives = np.array([example(rng, True) for _ in range(250)])
    negatives = np.array([example(rng, False) for _ in range(1000)])
    return Model(WINDOW, train_trees(positives, negatives, 64), None, None, STATISTICS, -3.0, 3.0, 3.0)


@pytest.fixture(scope="module")
def open_model(model: Model) -> Model:
    """The same with few trees and no rejection: every window passes."""
    trees = BoostedTrees(model.trees.feature[:40], model.trees.threshold[:40], model.trees.leaf[:40])
    return Model(WINDOW, trees, None, None, STATISTICS, -1e6, -1e6, -1e6)


def overlap(detection: Detection, box: NDArray[np.float64]) -> float:
    found = detection.box
    return float(intersection_over_union(np.array([[found.x, found.y, found.w, found.h]]), box[None])[0, 0])


# Vehicles of 170 to 20 px: every octave, and both edges of the picture.
@pytest.mark.parametrize(
    ("distance_m", "lateral_m"), [(7, 0), (9, -3.3), (14, 3), (20, -1), (28, 5), (40, 0), (52, 4), (58, -6)]
)
def test_finds_the_vehicle_and_where_it_stands(model: Model, distance_m: float, lateral_m: float):
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(int(distance_m)))
    box = vehicle_at(distance_m, lateral_m)
    draw_vehicle(picture, box)
    detections = AcfDetector(model, CALIBRATION).detect(picture)
    assert detections
    assert overlap(detections[0], box) >= 0.65
    assert detections[0].box.bottom == pytest.approx(box[1] + box[3], abs=0.1 * math.sqrt(box[2] * box[3]))


@pytest.mark.parametrize("size_px", [41.0, 60.0, 95.0, 150.0])
def test_plain_acf_finds_a_vehicle_anywhere(model: Model, size_px: float):
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(int(size_px)))
    box = box_of(size_px, 200.0, 170.0)
    draw_vehicle(picture, box)
    detections = FullAcfDetector(model).detect(picture)
    assert detections
    assert overlap(detections[0], box) >= 0.65


def test_plain_acf_finds_small_vehicles_only_where_it_enlarges_the_picture(model: Model):
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(3))
    box = box_of(21.0, 200.0, 170.0)
    draw_vehicle(picture, box)
    enlarged = FullAcfDetector(model, FullAcfSettings(largest_scale=2.4)).detect(picture)
    assert overlap(enlarged[0], box) >= 0.65
    assert not any(overlap(found, box) >= 0.5 for found in FullAcfDetector(model).detect(picture))


def test_the_prior_does_not_look_where_no_vehicle_can_stand(model: Model):
    # As large as a vehicle at 10 m, with its wheels in the sky.
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(5))
    box = box_of(110.0, 320.0, 120.0)
    draw_vehicle(picture, box)
    assert any(overlap(found, box) > 0.5 for found in FullAcfDetector(model).detect(picture))
    assert not any(overlap(found, box) > 0.3 for found in AcfDetector(model, CALIBRATION).detect(picture))


def test_vehicles_at_the_edge_of_the_picture_are_found_and_their_boxes_cut(model: Model):
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(6))
    box = vehicle_at(12, 0)
    box[0] = -0.1 * box[2]
    draw_vehicle(picture, box)
    best = AcfDetector(model, CALIBRATION).detect(picture)[0]
    assert best.box.x >= -0.5
    assert overlap(best, box) >= 0.6


def test_detections_are_above_the_threshold_and_best_first(model: Model):
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(7))
    for lateral_m in (-3.0, 0.5, 4.0):
        draw_vehicle(picture, vehicle_at(18, lateral_m))
    for detector in (
        AcfDetector(model, CALIBRATION, AcfSettings(score_threshold=1.0)),
        FullAcfDetector(model, FullAcfSettings(score_threshold=1.0)),
    ):
        scores = [found.score for found in detector.detect(picture)]
        assert len(scores) >= 3
        assert scores == sorted(scores, reverse=True)
        assert scores[-1] >= 1.0


def test_the_models_threshold_is_the_default(model: Model):
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(8))
    draw_vehicle(picture, vehicle_at(18, 0))
    lower = AcfDetector(model, CALIBRATION, AcfSettings(score_threshold=-2.0)).detect(picture)
    default = AcfDetector(model, CALIBRATION).detect(picture)
    assert [found for found in lower if found.score >= model.score_threshold] == list(default)


def test_scanning_gives_the_features_that_the_trees_saw(open_model: Model):
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(9))
    proposals = AcfDetector(open_model, CALIBRATION).scan(picture, -1e5, with_features=True)
    features = proposals.features
    assert features is not None
    assert features.shape == (len(proposals.scores), WINDOW.feature_count)
    trees = open_model.trees
    score = np.zeros(len(features), np.float32)
    for feature, threshold, leaf in zip(trees.feature, trees.threshold, trees.leaf, strict=True):
        goes = features[:, feature] <= threshold
        score += leaf[np.where(goes[:, 0], 1 - goes[:, 1], 3 - goes[:, 2])]
    np.testing.assert_array_equal(score, proposals.scores)


@pytest.mark.parametrize("full", [True, False])
def test_windows_of_the_pictures_own_scale_have_the_channels_of_the_picture(open_model: Model, full: bool):
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(10))
    detector = FullAcfDetector(open_model) if full else AcfDetector(open_model, CALIBRATION)
    proposals = detector.scan(picture, -1e5, with_features=True)
    assert proposals.features is not None
    assert len(proposals.scores) == detector.windows_per_frame
    channels = compute_channels(picture)
    x, y, w, h = proposals.boxes.T
    columns, rows = (x + w / 2 + 0.5) / 4 - WINDOW.cells / 2, (y + h + 0.5) / 4 - WINDOW.vehicle_bottom_px / 4
    own_scale = np.isclose(np.sqrt(w * h), WINDOW.vehicle_size_px) & np.isclose(w / h, ASPECT)
    inside = own_scale & (columns > -0.5) & (rows > -0.5)
    inside &= (columns < channels.shape[2] - 15.5) & (rows < channels.shape[1] - 15.5)
    assert inside.sum() > 500
    for i in np.flatnonzero(inside)[::7]:
        row, column = round(rows[i]), round(columns[i])
        assert (row, column) == (pytest.approx(rows[i]), pytest.approx(columns[i]))
        window = channels[:, row : row + WINDOW.cells, column : column + WINDOW.cells]
        np.testing.assert_array_equal(proposals.features[i], window.reshape(-1))


def test_the_enlarged_octave_stands_for_an_enlarged_picture(open_model: Model):
    """Far windows have about the channels of the picture enlarged, which is what training sees."""
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(11))
    for distance_m in (35, 45):
        draw_vehicle(picture, vehicle_at(distance_m, 0))
    proposals = AcfDetector(open_model, CALIBRATION).scan(picture, -1e5, with_features=True)
    assert proposals.features is not None
    enlarged = cv2.resize(picture, (2 * SIZE.width, 2 * SIZE.height), interpolation=cv2.INTER_LINEAR)
    channels = compute_channels(np.asarray(enlarged, np.uint8))
    x, y, w, h = proposals.boxes.T
    columns, rows = (x + w / 2 + 0.5) / 2 - WINDOW.cells / 2, (y + h + 0.5) / 2 - WINDOW.vehicle_bottom_px / 4
    own_scale = np.isclose(np.sqrt(w * h), WINDOW.vehicle_size_px / 2) & np.isclose(w / h, ASPECT)
    inside = own_scale & (columns > 1) & (rows > 1) & (columns < channels.shape[2] - 18)
    assert inside.sum() > 500
    pairs = [
        (
            proposals.features[i].reshape(10, -1),
            channels[:, (r := round(rows[i])) : r + 16, (c := round(columns[i])) : c + 16].reshape(10, -1),
        )
        for i in np.flatnonzero(inside)[::11]
    ]
    far, expected = (np.concatenate(part, axis=1).astype(np.float64) for part in zip(*pairs, strict=True))
    for channel in range(10):
        assert np.corrcoef(far[channel], expected[channel])[0, 1] >= 0.95
    np.testing.assert_allclose(far.mean(axis=1), expected.mean(axis=1), rtol=0.05)


def test_detecting_again_gives_the_same_whatever_came_before(model: Model):
    rng = np.random.default_rng(12)
    first, second = background(SIZE.height, SIZE.width, rng), background(SIZE.height, SIZE.width, rng)
    draw_vehicle(first, vehicle_at(15, 0))
    draw_vehicle(second, vehicle_at(30, 2))
    for detector in (AcfDetector(model, CALIBRATION), FullAcfDetector(model)):
        before = detector.detect(first)
        assert detector.detect(second) != before
        assert detector.detect(first) == before


@pytest.fixture(scope="module")
def staged_model(model: Model) -> Model:
    """With a second stage and a regressor that do something, whatever."""
    rng = np.random.default_rng(15)
    trees = BoostedTrees(
        rng.integers(0, 10 * 4 * 12 * 12, (70, 3)).astype(np.uint16),
        rng.integers(0, 256, (70, 3)).astype(np.uint8),
        rng.normal(0, 0.05, (70, 4)).astype(np.float32),
    )
    filters = rng.integers(-30, 30, (10, 4, 5, 5)).astype(np.int8)
    second = SecondStage(filters, np.zeros((10, 4), np.int32), np.full((10, 4), 6, np.uint8), trees)
    weights = rng.normal(0, 1e-5, (WINDOW.feature_count, 3)).astype(np.float32)
    return replace(model, second=second, regressor=BoxRegressor(weights, np.zeros(3, np.float32), 0.01))


def scene(seed: int) -> NDArray[np.uint8]:
    picture = background(SIZE.height, SIZE.width, np.random.default_rng(seed))
    for distance_m, lateral_m in ((9, -3.3), (15, 3), (25, 0), (45, 2)):
        draw_vehicle(picture, vehicle_at(distance_m, lateral_m))
    return picture


def test_detecting_allocates_no_memory_but_for_the_detections(staged_model: Model):
    pictures = [scene(seed) for seed in range(3)]
    empty = np.full_like(pictures[0], 128)
    allocated = []
    for detector in (AcfDetector(staged_model, CALIBRATION), FullAcfDetector(staged_model)):
        for picture in (*pictures, empty):
            detector.detect(picture)
        tracemalloc.start()
        try:
            for picture in pictures:
                before, _ = tracemalloc.get_traced_memory()
                tracemalloc.reset_peak()
                found = detector.detect(picture)
                _, peak = tracemalloc.get_traced_memory()
                assert found
                # Views of arrays and numbers pass; a list of windows or a row of cells would not.
                assert peak - before < 6_000 + 500 * len(found)
        finally:
            tracemalloc.stop()
        # Compiled code allocates by itself: a wrapper for each array it is given, and nothing for windows.
        _nrt_python.memsys_enable_stats()
        for picture in (*pictures, empty):
            before = rtsys.get_allocation_stats()
            detector.detect(picture)
            after = rtsys.get_allocation_stats()
            allocated.append(after.alloc - before.alloc)
            assert after.alloc - before.alloc == after.free - before.free
        _nrt_python.memsys_disable_stats()
        assert len(set(allocated[-4:])) == 1


def test_more_windows_than_ever_before_are_found_all_the_same(open_model: Model):
    rng = np.random.default_rng(16)
    picture = background(SIZE.height, SIZE.width, rng)
    detector = AcfDetector(open_model, CALIBRATION)
    few = detector.scan(picture, 2.0, with_features=True)
    everything = detector.scan(picture, -1e6, with_features=True)
    assert len(few.scores) < FIRST_CAPACITY < len(everything.scores) == detector.windows_per_frame
    best = everything.scores >= 2.0
    assert few.features is not None
    assert everything.features is not None
    np.testing.assert_array_equal(few.boxes, everything.boxes[best])
    np.testing.assert_array_equal(few.features, everything.features[best])


def test_proposals_stay_what_they_are_when_another_picture_is_scanned(staged_model: Model):
    detector = AcfDetector(staged_model, CALIBRATION)
    first = detector.scan(scene(0), 0.0, with_features=True)
    copy = deepcopy(first)
    detector.scan(scene(1), 0.0, with_features=True)
    for name in ("boxes", "placements", "scores", "second_scores", "features"):
        np.testing.assert_array_equal(getattr(first, name), getattr(copy, name))


def test_windows_expect_their_vehicles_where_their_level_has_them(staged_model: Model):
    # The tables of rows and columns against the levels' own arithmetic, by boxes that no edge cuts.
    detector = AcfDetector(staged_model, CALIBRATION)
    proposals = detector.scan(scene(2), 0.0)
    expected = []
    for level in detector.levels:
        rows, columns = np.arange(level.first_window, level.end_window), np.arange(level.window_columns)
        middles, bottoms, size_px = level.vehicles(WINDOW, rows, columns)
        grid = np.meshgrid(middles, bottoms)
        expected += [(x, y, size_px) for x, y in zip(grid[0].ravel(), grid[1].ravel(), strict=True)]
    assert len(proposals.scores) > 10
    assert {tuple(placement) for placement in proposals.placements.tolist()} <= set(expected)
    middle, bottom, size_px = proposals.placements.T
    w, h = size_px * math.sqrt(ASPECT), size_px / math.sqrt(ASPECT)
    whole = np.column_stack([middle - w / 2, bottom - h, w, h])
    np.testing.assert_allclose(proposals.boxes, cut_to_picture(whole, SIZE), atol=1e-9)


def test_detectors_of_their_own_work_side_by_side_in_threads(model: Model):
    rng = np.random.default_rng(14)
    pictures = []
    for index in range(12):
        pictures.append(background(SIZE.height, SIZE.width, rng))
        draw_vehicle(pictures[-1], vehicle_at(8 + 4 * index, 0))
    alone = AcfDetector(model, CALIBRATION)
    expected = [alone.detect(picture) for picture in pictures]

    def detect_all(_: int) -> list[tuple[Detection, ...]]:
        detector = AcfDetector(model, CALIBRATION)
        return [detector.detect(picture) for picture in pictures]

    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(detect_all, range(3))) == [expected] * 3


def test_an_empty_picture_has_no_vehicles(model: Model):
    grey = np.full((SIZE.height, SIZE.width, 3), 128, np.uint8)
    assert AcfDetector(model, CALIBRATION).detect(grey) == ()
    proposals = AcfDetector(model, CALIBRATION).scan(grey, 3.0, with_features=True)
    assert proposals.boxes.shape == (0, 4)
    assert proposals.features is not None
    assert proposals.features.shape == (0, WINDOW.feature_count)


def test_names_are_those_of_the_command_line(model: Model):
    assert AcfDetector(model, CALIBRATION).name == "acf"
    assert FullAcfDetector(model).name == "acf-full"


def test_a_picture_of_another_size_than_the_calibrations_is_refused(model: Model):
    with pytest.raises(ValueError, match="641x363"):
        AcfDetector(model, CALIBRATION).detect(np.zeros((360, 640, 3), np.uint8))


def test_plain_acf_takes_pictures_of_any_size(model: Model):
    detector = FullAcfDetector(model)
    for height, width in ((363, 641), (200, 301), (40, 40)):
        picture = background(height, width, np.random.default_rng(13))
        assert all(isinstance(found.box, Box) for found in detector.detect(picture))
        assert (detector.windows_per_frame == 0) == (height < WINDOW.size_px)


def test_a_calibration_without_road_in_the_picture_is_the_users_mistake(model: Model):
    skywards = GroundPlaneCamera(-1.0, 560.0, 180.0, 1.3, 320.0)
    with pytest.raises(UserError, match=r"horizon in row 1052 .* calibrate again"):
        AcfDetector(model, Calibration.from_camera(skywards, SIZE))


@pytest.mark.parametrize("largest_scale", [0.5, 4.0])
def test_enlarging_by_less_than_nothing_or_by_two_octaves_is_refused(model: Model, largest_scale: float):
    with pytest.raises(ValueError, match="largest_scale"):
        AcfDetector(model, CALIBRATION, AcfSettings(largest_scale=largest_scale))
