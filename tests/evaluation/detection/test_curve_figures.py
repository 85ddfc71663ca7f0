"""Average precision, rates and weights of the curve: by hand, by pycocotools, and what must always hold."""

import contextlib
import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from fcw.detection.matching import DetectionCurve, LabelledDetections, detection_curve, pool_matches


def curve(hits, vehicles, frames=1, scores=None, weights=None):
    scores = np.arange(len(hits), 0, -1.0) if scores is None else np.array(scores, float)
    return DetectionCurve(scores, np.array(hits, bool), vehicles, frames, weights)


def test_average_precision_by_hand():
    # Hit, false, hit of 2 vehicles: precision 1 up to recall 1/2 (51 of 101 recalls), then 2/3 (50 of 101).
    assert curve([1, 0, 1], 2).average_precision == pytest.approx((51 + 50 * 2 / 3) / 101)
    # A third vehicle that is never found: nothing above recall 2/3 (recalls 0 to .33, .34 to .66).
    assert curve([1, 0, 1], 3).average_precision == pytest.approx((34 + 33 * 2 / 3) / 101)


def test_average_precision_of_all_and_of_nothing():
    assert curve([1, 1], 2).average_precision == 1.0
    assert curve([], 2).average_precision == 0.0
    assert math.isnan(curve([0], 0).average_precision)


def test_equal_scores_count_alike_in_whatever_order_they_come():
    # No threshold parts the two: precision is 1/2 at every recall.
    for hits in ([1, 0], [0, 1]):
        assert curve(hits, 1, scores=[1, 1]).average_precision == pytest.approx(1 / 2)


@pytest.mark.parametrize("false", [7, 29, 57, 58])
def test_so_many_false_positives_in_a_hundred_pictures_are_allowed_where_they_are_asked_for(false):
    found = curve([0] * false + [1, 0], 1, frames=100)
    assert found.at_fppi(false / 100) == pytest.approx((2.0, 1.0, false / 100))


def test_the_highest_threshold_that_reaches_a_rate():
    found = curve([1, 0, 1], 3, frames=2)
    assert found.at_rate(1 / 3) == pytest.approx((3.0, 1 / 3, 0.0))
    assert found.at_rate(0.5) == pytest.approx((1.0, 2 / 3, 0.5))
    assert found.at_rate(0.7) is None


def test_weights_are_repetitions():
    weights = np.array([2.0, 0.0, 1.0, 3.0])
    weighted = curve([1, 1, 0, 1], 6, frames=4, weights=weights)
    repeated = curve([1, 1, 0, 1, 1, 1], 6, frames=4, scores=[4, 4, 2, 1, 1, 1])
    assert weighted.average_precision == pytest.approx(repeated.average_precision)
    for fppi in (0.0, 0.25, 1.0):
        assert weighted.at_fppi(fppi)[1:] == pytest.approx(repeated.at_fppi(fppi)[1:])


def random_frames(seed):
    """Pictures with vehicles, ignored ones, and detections near both and far from both."""
    random = np.random.default_rng(seed)
    frames = []
    for _ in range(12):
        labels = np.column_stack([random.uniform(0, 400, (5, 2)), random.uniform(20, 120, (5, 2))])
        near = np.repeat(labels, 3, axis=0) * random.normal(1, 0.12, (15, 4))
        far = np.column_stack([random.uniform(0, 400, (6, 2)), random.uniform(20, 120, (6, 2))])
        detections = np.concatenate([near, far])
        scores = np.asarray(random.permutation(len(detections)) + random.uniform(0, 0.5), np.float64)
        frames.append(LabelledDetections(detections, scores, labels, random.random(5) < 0.3))
    return frames


@pytest.mark.parametrize("seed", range(8))
def test_average_precision_is_that_of_pycocotools(seed):
    # COCO's crowds are our ignored boxes: a detection with half its area in one is neither hit nor false.
    frames = random_frames(seed)
    annotations, results = [], []
    for image, frame in enumerate(frames, start=1):
        for box, ignored in zip(frame.labels, frame.ignored, strict=True):
            number = len(annotations) + 1
            area, crowd = float(box[2] * box[3]), int(ignored)
            annotations.append(
                {"id": number, "image_id": image, "category_id": 1, "bbox": box.tolist(), "area": area}
                | {"iscrowd": crowd}
            )
        for box, score in zip(frame.detections, frame.scores, strict=True):
            results.append({"image_id": image, "category_id": 1, "bbox": box.tolist(), "score": float(score)})
    with contextlib.redirect_stdout(io.StringIO()):
        truth = COCO()
        truth.dataset = {  # pyright: ignore[reportAttributeAccessIssue] - COCO asks for less
            "info": {},
            "images": [{"id": image} for image in range(1, len(frames) + 1)],
            "annotations": annotations,
            "categories": [{"id": 1}],
        }
        truth.createIndex()
        found = truth.loadRes(results)  # pyright: ignore[reportArgumentType] - a list does, too
        evaluation = COCOeval(truth, found, "bbox")
        evaluation.params.iouThrs = np.array([0.5])
        evaluation.evaluate()
        evaluation.accumulate()
    precision = evaluation.eval["precision"][0, :, 0, 0, -1]
    assert detection_curve(frames).average_precision == pytest.approx(precision.mean(), abs=1e-9)


flags = st.lists(st.booleans(), max_size=20)


@given(hits=flags, missed=st.integers(0, 5), frames=st.integers(1, 5), data=st.data())
def test_the_curve_only_rises_and_at_fppi_is_its_best_point(hits, missed, frames, data):
    scores = sorted(data.draw(st.lists(st.integers(0, 9), min_size=len(hits), max_size=len(hits))))[::-1]
    found = curve(hits, sum(hits) + missed + 1, frames, scores)
    points = found.points()
    assert list(points) == sorted(points, key=lambda point: (point.detection_rate, point.fppi))
    assert [point.fppi for point in points] == sorted(point.fppi for point in points)
    for limit in (0.0, 0.3, 1.0, 10.0):
        allowed = [point.detection_rate for point in points if point.fppi <= limit]
        assert found.at_fppi(limit).detection_rate == max(allowed, default=0.0)
        assert found.at_fppi(limit).fppi <= limit


@given(hits=flags, at=st.integers(0, 20), missed=st.integers(0, 5))
def test_one_more_false_detection_never_helps_and_one_more_hit_never_hurts(hits, at, missed):
    at = min(at, len(hits))
    vehicles = sum(hits) + missed + 1
    before = curve(hits, vehicles)
    worse = curve([*hits[:at], False, *hits[at:]], vehicles)
    better = curve([*hits[:at], True, *hits[at:]], vehicles)
    assert worse.average_precision <= before.average_precision + 1e-12
    assert better.average_precision >= before.average_precision - 1e-12
    for fppi in (0.0, 1.0, 3.0):
        assert worse.at_fppi(fppi).detection_rate <= before.at_fppi(fppi).detection_rate
        assert better.at_fppi(fppi).detection_rate >= before.at_fppi(fppi).detection_rate


def test_pooled_matches_remember_picture_and_vehicle():
    car, van, nothing = (0, 0, 10, 10), (50, 0, 10, 10), (200, 200, 10, 10)
    none = np.zeros((0, 4))
    pooled = pool_matches(
        [
            LabelledDetections(none, np.zeros(0), np.array([car], float), np.array([False])),
            LabelledDetections(
                np.array([nothing, van, car], float),
                np.array([1.0, 3.0, 2.0]),
                np.array([car, van], float),
                np.array([True, False]),
            ),
        ]
    )
    assert pooled.vehicle_frame.tolist() == [0, 1]
    assert pooled.vehicle_label.tolist() == [0, 1]
    assert pooled.scores.tolist() == [3.0, 1.0]  # the one on the ignored car does not count
    assert pooled.vehicle.tolist() == [1, -1]
    assert pooled.boxes.tolist() == [list(van), list(nothing)]
    without_van = pooled.curve(np.array([1.0, 0.0]), np.array([1.0, 2.0]))
    assert (without_van.vehicles, without_van.frames) == (1, 3)
    assert without_van.at_threshold(0.0)[1:] == pytest.approx((0.0, 2 / 3))
