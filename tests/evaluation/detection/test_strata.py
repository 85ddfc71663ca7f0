"""Rates by kind of vehicle: which vehicles are in which row, and one threshold for all."""

import json
import math

import numpy as np
import pytest
from labelled import annotated, found

from fcw.evaluation.detection.strata import STRATA, LabelledVehicle, stratified_rates

# Pictures are 1280x720: a fifth of the height are 144 rows.
SMALL, MIDDLE, LARGE = (100, 400, 40, 30), (300, 350, 120, 100), (600, 300, 300, 252)
NOWHERE, ELSEWHERE = (1000, 405, 40, 30), (1100, 405, 40, 30)
NONE = {"view": "rear", "kind": "car", "occluded": 0, "truncated": False}


def names_of(box, camera="tusimple", clip="clip", **fields):
    image = annotated(box, clip=clip, camera=camera, attributes=[NONE | fields])
    vehicle = LabelledVehicle.of(image, 0)
    return {name for name, condition in STRATA.items() if condition(vehicle)}


@pytest.mark.parametrize(
    ("height", "name"),
    [
        (35.9, "height under 5%"),
        (36.0, "height 5% to 10%"),
        (72.0, "height 10% to 20%"),
        (144.0, "height 20% to 35%"),
        (252.0, "height from 35%"),
    ],
)
def test_height_is_a_part_of_the_picture_s(height, name):
    names = names_of((100, 100, 100, height))
    assert {each for each in names if each.startswith("height")} == {name}
    assert ("near" in names) == (height >= 144)


def test_clear_is_unhidden_and_at_least_24_px_wide():
    assert "clear" in names_of((0, 0, 24, 30))
    assert "clear" not in names_of((0, 0, 23.9, 30))
    assert "clear" not in names_of(MIDDLE, occluded=1)


def test_kinds_views_and_light_are_rows_of_their_own():
    assert {"cars, SUVs", "clear, rear"} <= names_of(MIDDLE, kind="suv")
    assert {"vans, lorries, buses", "clear, rear-quarter"} <= names_of(
        MIDDLE, kind="bus", view="rear-quarter"
    )
    assert {"half-hidden", "truncated"} <= names_of(MIDDLE, occluded=1, truncated=1)
    assert {"near", "near, truncated", "near, not hidden"} <= names_of(LARGE, truncated=True)
    assert {"fog", "fog, dusk"} <= names_of(MIDDLE, camera="dawn")
    assert {"dusk", "fog, dusk"} <= names_of(MIDDLE, camera="camvid", clip="camvid_0001TP")
    assert "fog, dusk" not in names_of(MIDDLE, camera="camvid", clip="camvid_0006R0")


def test_a_vehicle_whose_kind_is_not_labelled_is_of_no_kind():
    names = names_of(MIDDLE, kind=None, view=None)
    assert {"all", "clear"} <= names
    assert not names & {"cars, SUVs", "vans, lorries, buses", "clear, rear", "clear, rear-quarter"}


def drive():
    """Two cameras, ten pictures each; a van is never found, and one camera has all false positives."""
    images, detections = [], []
    for number in range(10):
        fields = [NONE, NONE | {"kind": "van"}]
        images.append(annotated(SMALL, LARGE, clip="a", image_id=number, attributes=fields))
        detections.append(found(SMALL, scores=[5.0 - 0.1 * number]))
        images.append(annotated(MIDDLE, clip="b", image_id=number, attributes=[NONE]))
        detections.append(found(MIDDLE, NOWHERE, scores=[3.0, 4.05 - 0.1 * number]))
    return images, detections


def test_all_kinds_and_cameras_are_judged_at_one_threshold():
    images, detections = drive()
    result = stratified_rates(images, detections, (0.0, 0.05, 1.0), resamples=20)
    # Of the false ones, 4.05, 3.95 and so on, one in 20 pictures is allowed at 0.05, and all at 1.
    assert result.pictures == 20
    assert result.thresholds == pytest.approx((4.1, 4.05, 3.0))
    assert result.strata["cars, SUVs"].rates == (0.5, 0.5, 1.0)
    assert result.strata["vans, lorries, buses"].rates == (0.0, 0.0, 0.0)
    assert result.strata["vans, lorries, buses"].any_score == 0.0
    assert result.strata["all"].rates[-1] == pytest.approx(2 / 3)
    assert (result.strata["all"].boxes, result.strata["all"].vehicles) == (30, 30)
    assert (result.cameras["a"].fppi, result.cameras["b"].fppi) == ((0, 0, 0), (0, 0.1, 1.0))
    assert math.isnan(result.strata["fog"].rates[0])


def test_vehicles_of_incomplete_pictures_are_in_their_camera_s_row_alone():
    images, detections = drive()
    images.append(annotated(MIDDLE, clip="c", attributes=[NONE], complete=False))
    detections.append(found(MIDDLE, ELSEWHERE, scores=[9.0, 9.5]))
    result = stratified_rates(images, detections, (0.05,), resamples=20)
    assert (result.pictures, result.strata["all"].boxes) == (20, 30)
    assert result.thresholds == (4.05,)
    assert result.cameras["c"].clear.rates == (1.0,)
    assert math.isnan(result.cameras["c"].fppi[0])


def test_intervals_hold_the_rate_and_draw_the_threshold_anew():
    images, detections = drive()
    row = stratified_rates(images, detections, (0.05,), resamples=200).strata["cars, SUVs"]
    for low, high in (row.intervals[0], row.intervals_same_clips[0]):
        assert low < row.rates[0] < high
    # Of both clips always ten vehicles each; with clips drawn, sometimes one alone: all or nothing.
    assert row.intervals[0].low == 0.0
    assert row.intervals_same_clips[0].low > 0.0


def test_a_hit_by_the_rear_face_counts():
    fields = [NONE | {"view": "rear-quarter", "rear_box": [300, 350, 50, 100]}]
    images = [annotated(MIDDLE, attributes=fields)]
    result = stratified_rates(images, [found((300, 350, 50, 100), scores=[1.0])], (0.1,), resamples=5)
    assert result.strata["clear, rear-quarter"].rates == (1.0,)


def test_json_names_every_row_and_has_no_nan():
    images, detections = drive()
    result = stratified_rates(images, detections, (0.05,), resamples=5).as_json()
    read = json.loads(json.dumps(result, allow_nan=False))
    assert list(read["strata"]) == list(STRATA)
    assert read["strata"]["fog"]["rates"] == [None]
    assert set(read["cameras"]["a"]) == {"pictures", "clear", "fppi"}
    assert np.array(read["strata"]["all"]["intervals"]).shape == (1, 2)
