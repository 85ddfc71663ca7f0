"""The figures of an evaluation by kind of vehicle; failures, bottom rows, seeds, wrong calibrations."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from labelled import CALIBRATION, annotated, evaluated, found

from fcw.evaluation.detection.bottom_rows import bottom_rows
from fcw.evaluation.detection.comparison import SeedMean, rate_at
from fcw.evaluation.detection.failures import FailureKind, count_kinds, false_positives, misses
from fcw.evaluation.detection.figures import evaluate
from fcw.evaluation.detection.perturbation import CALIBRATION_ERRORS, CalibrationError

# By CALIBRATION a box whose bottom is in row 510 stands at 10 m, in row 435 at 20 m, in row 400 at 37.5 m.
NEAR, MIDDLE, FAR = (100, 410, 120, 100), (400, 385, 60, 50), (700, 375, 30, 25)
NOWHERE = (1000, 405, 40, 30)


def test_strata_hold_the_vehicles_of_their_distance_height_and_clip():
    images = [annotated(NEAR, MIDDLE, FAR, image_id=1), annotated(NEAR, clip="other", image_id=2)]
    evaluation = evaluated(images, [found(NEAR, FAR, NOWHERE, scores=[3, 2, 1]), found()])
    by_distance = evaluation.by_distance()
    assert {
        name: (row.vehicles, row.detection_rate) for name, row in by_distance.items() if row.vehicles
    } == {
        "5-15": (2, 0.5),
        "15-30": (1, 0.0),
        "30-50": (1, 1.0),
    }
    assert by_distance["15-30"].fppi == 0.5  # NOWHERE, bottom in row 435
    by_height = evaluation.by_height()
    assert (by_height["100+"].detection_rate, by_height["40-60"].detection_rate) == (0.5, 0.0)
    by_clip = evaluation.by_clip()
    assert {name: (row.detection_rate, row.fppi) for name, row in by_clip.items()} == {
        "clip": (pytest.approx(2 / 3), 1.0),
        "other": (0.0, 0.0),
    }


def test_a_box_above_the_horizon_is_beyond_the_last_distance():
    evaluation = evaluated([annotated((0, 300, 40, 30))], [found()])
    assert evaluation.by_distance()["80+"].vehicles == 1


def test_a_vehicle_cut_by_the_bottom_edge_behind_the_bumper_s_distance_is_among_the_nearest():
    long_bonnet = replace(CALIBRATION, reference_offset_m=5.0)  # in row 720 the road is 1500 / 360 m away
    image, beside = annotated((400, 500, 300, 220)), (900, 500, 300, 220)
    evaluation = evaluate([image], lambda _: long_bonnet, [found(beside, scores=[1])], 0.0)
    nearest = evaluation.by_distance()["0-5"]
    assert (nearest.vehicles, nearest.fppi) == (1, 1.0)


def test_json_has_all_figures_and_no_nan():
    timed = [found(milliseconds=value, windows=10) for value in (1.0, 2.0, 9.0)]
    images = [annotated(NEAR, image_id=1), annotated(image_id=2), annotated(image_id=3)]
    detections = [found(NEAR, scores=[2]), found(NOWHERE, scores=[1]), found()]
    figures = json.loads(
        json.dumps(evaluated(images, detections, 1.5, timed).as_json([0.1, 1.0], 50), allow_nan=False)
    )
    assert (figures["frames"], figures["vehicles"], figures["distinct_vehicles"]) == (3, 1, 1)
    assert (figures["detection_rate"], figures["fppi"], figures["average_precision"]) == (1.0, 0.0, 1.0)
    assert (figures["ms_per_frame"], figures["windows_per_frame"]) == (2.0, 10.0)
    assert figures["detection_rate_at_fppi"] == 1.0
    assert [point["fppi"] for point in figures["at_fppi"]] == [0.1, 1.0]
    assert figures["by_distance"]["15-30"]["detection_rate"] is None
    assert figures["curve"] == [
        {"score_threshold": 2.0, "detection_rate": 1.0, "fppi": 0.0},
        {"score_threshold": 1.0, "detection_rate": 1.0, "fppi": pytest.approx(1 / 3)},
    ]


def shifted(box, dx=0.0, dy=0.0):
    return (box[0] + dx, box[1] + dy, box[2], box[3])


@pytest.mark.parametrize(
    ("detections", "scores", "kind"),
    [
        ([], [], FailureKind.NOT_FOUND),
        ([NEAR], [0.5], FailureKind.UNSURE),
        ([shifted(NEAR, dx=50)], [2.0], FailureKind.MISPLACED_MISS),
    ],
)
def test_a_miss_says_why(detections, scores, kind):
    (miss,) = misses(evaluated([annotated(NEAR)], [found(*detections, scores=scores)], threshold=1.0))
    assert (miss.kind, miss.distance_m, miss.label) == (kind, pytest.approx(10.0), 0)


def test_one_box_for_two_vehicles_misses_one_of_them():
    evaluation = evaluated([annotated(NEAR, shifted(NEAR, dx=20))], [found(NEAR, scores=[2.0])])
    assert [miss.kind for miss in misses(evaluation)] == [FailureKind.SHARED]


@pytest.mark.parametrize(
    ("detection", "kind"),
    [
        (shifted(NEAR, dx=10), FailureKind.DOUBLE),
        (shifted(NEAR, dx=60), FailureKind.MISPLACED),
        (shifted(FAR, dx=17), FailureKind.IGNORED_VEHICLE),
        (NOWHERE, FailureKind.BACKGROUND),
    ],
)
def test_a_false_positive_says_of_what(detection, kind):
    image = annotated(NEAR, FAR, ignored=[1])
    evaluation = evaluated([image], [found(NEAR, detection, scores=[5.0, 2.0])])
    (false,) = false_positives(evaluation)
    assert (false.kind, false.score) == (kind, 2.0)
    assert count_kinds([false]) == {kind: 1}


def test_bottom_rows_are_of_hits_of_the_right_height_and_source():
    source = [{"source": "human"}, {"source": "model"}, {"source": "human"}]
    images = [annotated(MIDDLE, FAR, NEAR, image_id=number, attributes=source) for number in range(5)]
    errors = [1.0, 1.5, 2.0, 2.5, 8.0]
    detections = [found(shifted(MIDDLE, dy=error), FAR, NEAR, scores=[3, 2, 1]) for error in errors]
    rows = bottom_rows(evaluated(images, detections), {"human"})
    assert rows is not None
    assert (rows.count, rows.vehicles) == (5, 5)
    assert (rows.bias_px, rows.median_px) == (pytest.approx(3.0), pytest.approx(2.0))
    assert rows.sigma_px == pytest.approx(math.sqrt(np.mean([4, 2.25, 1, 0.25, 25])))
    assert rows.robust_sigma_px == pytest.approx(1.4826 * 0.5)
    assert bottom_rows(evaluated(images, detections, threshold=9.0), {"human"}) is None


def test_seeds_are_averaged_and_compared_at_equal_rate():
    images = [annotated(NEAR, MIDDLE, image_id=number) for number in range(2)]
    good = [found(NEAR, MIDDLE, scores=[4, 3])] * 2
    one_false = [found(NEAR, MIDDLE, NOWHERE, scores=[4, 2, 3])] * 2
    half = [found(NEAR, scores=[4])] * 2
    better = SeedMean((evaluated(images, good), evaluated(images, half)))
    worse = SeedMean((evaluated(images, one_false), evaluated(images, half)))
    assert better.values(rate_at(0.1)) == (1.0, 0.5)
    assert (better.mean(rate_at(0.1)), worse.mean(rate_at(0.1))) == (0.75, 0.5)
    assert better.at_equal_rate(worse, 1.0) == pytest.approx((0.75, 0.0, 0.5))
    assert worse.at_equal_rate(better, 0.0) == pytest.approx((0.75, 0.5, 0.0))
    assert better.at_equal_rate(better, 0.0).fppi == 0.0
    never = SeedMean((evaluated(images, half), evaluated(images, half)))
    assert never.at_equal_rate(worse, 1.0).fppi is None
    low, high = better.difference_interval(worse, rate_at(0.1), resamples=50)
    assert 0 <= low <= 0.25 <= high


def test_a_wrong_pitch_moves_the_horizon_and_a_wrong_height_only_the_scale():
    camera = CALIBRATION.camera
    pitched = CalibrationError(pitch_rad=0.01).applied(CALIBRATION)
    assert pitched.horizon_row_px == pytest.approx(camera.horizon_row_px - 1000 * math.tan(0.01))
    higher = CalibrationError(height_factor=1.1).applied(CALIBRATION)
    assert higher.horizon_row_px == pytest.approx(camera.horizon_row_px)
    assert higher.distance_at(435.0) == pytest.approx(1.1 * 20.0)
    assert [str(error) for error in CALIBRATION_ERRORS] == [
        "pitch -1.0 degrees",
        "pitch -0.5 degrees",
        "pitch +0.5 degrees",
        "pitch +1.0 degrees",
        "height -10%",
        "height +10%",
    ]


def test_strata_by_view_kind_and_part_of_the_height_are_there_where_labels_have_them():
    # Pictures are 720 rows high: NEAR is 0.139 of it, MIDDLE 0.069.
    fields = [{"view": "rear", "kind": "van"}, {"view": "rear", "kind": None}]
    image = annotated(NEAR, MIDDLE, attributes=fields)
    figures = evaluated([image], [found(NEAR, NOWHERE, scores=[2, 1])]).as_json(resamples=5)
    by_part = {name: row["vehicles"] for name, row in figures["by_height_part"].items()}
    assert by_part == {"0-0.05": 0, "0.05-0.1": 1, "0.1-0.2": 1, "0.2-0.35": 0, "0.35+": 0}
    assert figures["by_height_part"]["0-0.05"]["fppi"] == 1.0
    assert {name: row["detection_rate"] for name, row in figures["by_view"].items()} == {"rear": 0.5}
    assert {name: row["detection_rate"] for name, row in figures["by_kind"].items()} == {"van": 1.0}
    assert figures["by_kind"]["van"]["fppi"] is None
    bare = evaluated([annotated(NEAR)], [found()]).as_json(resamples=5)
    assert (bare["by_view"], bare["by_kind"]) == ({}, {})


def test_a_miss_whose_rear_face_was_found_too_unsurely_says_so():
    rear = (100, 410, 40, 100)
    image = annotated(NEAR, attributes=[{"rear_box": rear}])
    (miss,) = misses(evaluated([image], [found(rear, scores=[0.5])], threshold=1.0))
    assert (miss.kind, miss.iou) == (FailureKind.UNSURE, 1.0)
    evaluation = evaluated([image], [found(NEAR, rear, scores=[5.0, 2.0])])
    (false,) = false_positives(evaluation)
    assert false.kind == FailureKind.DOUBLE
