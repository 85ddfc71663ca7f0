"""The label rules of DESIGN.md: what is a hit, a miss, a false positive, and what is neither."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fcw.detection.boxes.overlap import intersection_areas, intersection_over_union
from fcw.detection.matching import (
    FALSE_POSITIVE,
    NOT_COUNTED,
    LabelledDetections,
    detection_curve,
    match_detections,
    pool_matches,
)


def boxes(*rows):
    return np.array(rows, np.float64).reshape(-1, 4)


def matches(detections, scores, labels, ignored=None, rears=None):
    flags = np.zeros(len(labels), bool) if ignored is None else np.array(ignored, bool)
    rear_boxes = None if rears is None else boxes(*(rear or (math.nan,) * 4 for rear in rears))
    found, sure = boxes(*detections), np.array(scores, float)
    return match_detections(found, sure, boxes(*labels), flags, rear_boxes).tolist()


def test_overlaps_by_hand():
    a, b = boxes((0, 0, 4, 2)), boxes((2, 1, 4, 2), (10, 10, 1, 1), (0, 0, 4, 2))
    assert intersection_areas(a, b).tolist() == [[2, 0, 8]]
    assert intersection_over_union(a, b) == pytest.approx(np.array([[2 / 14, 0, 1]]))


@pytest.mark.parametrize(("shift", "expected"), [(3.3, 0), (3.4, FALSE_POSITIVE)])
def test_a_hit_needs_an_iou_of_one_half(shift, expected):
    # Two squares of side 10 shifted by s: IoU = (10 - s) / (10 + s), one half at s = 3.33.
    assert matches([(shift, 0, 10, 10)], [1], [(0, 0, 10, 10)]) == [expected]


def test_one_detection_a_vehicle_the_surest_first():
    assert matches([(1, 0, 10, 10), (0, 0, 10, 10)], [5, 4], [(0, 0, 10, 10)]) == [0, FALSE_POSITIVE]


def test_a_detection_takes_the_vehicle_it_overlaps_most():
    assert matches([(2, 0, 10, 10)], [1], [(0, 0, 10, 10), (3, 0, 10, 10)]) == [1]


@pytest.mark.parametrize(("x", "expected"), [(5, NOT_COUNTED), (5.1, FALSE_POSITIVE)])
def test_half_the_area_in_an_ignored_box_is_neither_hit_nor_false(x, expected):
    assert matches([(x, 0, 10, 10)], [1], [(0, 0, 10, 10)], [True]) == [expected]


def test_a_vehicle_that_counts_is_hit_even_inside_an_ignored_box():
    assert matches([(2, 2, 4, 4)], [1], [(0, 0, 20, 20), (2, 2, 4, 4)], [True, False]) == [1]


def test_a_vehicle_is_hit_by_its_rear_face_as_well_as_by_its_whole_body():
    body, rear, other = (0, 0, 30, 10), (20, 0, 10, 10), (100, 0, 10, 10)
    labels, rears = [body, other], [rear, None]
    # The rear face alone is a third of the body: no hit without `rear_box`.
    assert matches([rear], [1], labels) == [FALSE_POSITIVE]
    assert matches([rear], [1], labels, rears=rears) == [0]
    assert matches([body], [1], labels, rears=rears) == [0]
    assert matches([other], [1], labels, rears=rears) == [1]
    # Still one detection a vehicle: the second is false, whichever of the two boxes it is on.
    assert matches([rear, body], [2, 1], labels, rears=rears) == [0, FALSE_POSITIVE]
    assert matches([rear, body], [1, 2], labels, rears=rears) == [FALSE_POSITIVE, 0]


def test_the_rear_face_of_an_ignored_vehicle_is_no_hit():
    assert matches([(20, 0, 10, 10)], [1], [(0, 0, 30, 10)], [True], [(20, 0, 10, 10)]) == [NOT_COUNTED]


def test_where_not_every_vehicle_is_labelled_there_are_hits_and_misses_but_no_false_positives():
    car, missed, elsewhere = (0, 0, 10, 10), (50, 0, 10, 10), (100, 0, 10, 10)
    found = boxes(car, elsewhere), np.array([2.0, 3.0])
    labels = boxes(car, missed), np.array([False, False])
    part = LabelledDetections(*found, *labels, complete=False)
    whole = LabelledDetections(*found, *labels)
    assert part.matches().tolist() == [0, NOT_COUNTED]
    assert detection_curve([part]).at_threshold(0.0)[1:] == (0.5, pytest.approx(math.nan, nan_ok=True))
    # Two of four vehicles; one false positive in the one picture that is completely labelled.
    pooled = pool_matches([part, whole])
    assert pooled.curve().at_threshold(0.0)[1:] == (0.5, 1.0)
    # Drawn three times, the incomplete picture changes nothing in how often there are false ones.
    assert pooled.curve(frame_weights=np.array([3.0, 1.0])).at_threshold(0.0).fppi == 1.0


def test_two_ignored_boxes_do_not_add_up():
    labels = [(0, 0, 4, 10), (6, 0, 4, 10)]
    assert matches([(0, 0, 10, 10)], [1], labels, [True, True]) == [FALSE_POSITIVE]


def test_rate_and_fppi_by_hand():
    # Two pictures, three vehicles that count; hit 9, false 8, hit 7, false 6, not counted 5.
    car, van, truck = (0, 0, 10, 10), (50, 0, 10, 10), (0, 50, 20, 20)
    nothing = (200, 200, 10, 10)
    curve = detection_curve(
        [
            LabelledDetections(boxes(car, nothing), np.array([9.0, 8.0]), boxes(car), np.array([False])),
            LabelledDetections(
                boxes(van, nothing, (100, 100, 10, 10)),
                np.array([7.0, 6.0, 5.0]),
                boxes(van, truck, (95, 95, 20, 20)),
                np.array([False, False, True]),
            ),
        ]
    )
    assert (curve.vehicles, curve.frames) == (3, 2)
    assert curve.at_threshold(7.0)[1:] == pytest.approx((2 / 3, 0.5))
    assert curve.at_threshold(8.5)[1:] == pytest.approx((1 / 3, 0.0))
    assert curve.at_fppi(0.4) == pytest.approx((9.0, 1 / 3, 0.0))
    assert curve.at_fppi(0.5) == pytest.approx((7.0, 2 / 3, 0.5))
    assert curve.at_fppi(1.0) == pytest.approx((6.0, 2 / 3, 1.0))


def test_equal_scores_stand_or_fall_together():
    car, nothing = (0, 0, 10, 10), (50, 50, 10, 10)
    curve = detection_curve(
        [LabelledDetections(boxes(car, nothing), np.array([1.0, 1.0]), boxes(car), np.array([False]))]
    )
    assert curve.at_fppi(0.5) == (math.inf, 0.0, 0.0)
    assert curve.at_fppi(1.0) == (1.0, 1.0, 1.0)


def test_no_detection_misses_everything_and_no_vehicle_has_no_rate():
    none = boxes()
    missed = detection_curve([LabelledDetections(none, np.zeros(0), boxes((0, 0, 1, 1)), np.array([False]))])
    assert missed.at_fppi(1.0) == (math.inf, 0.0, 0.0)
    empty = detection_curve([LabelledDetections(boxes((0, 0, 1, 1)), np.ones(1), none, np.zeros(0, bool))])
    assert math.isnan(empty.at_threshold(0.0).detection_rate)
    assert empty.at_threshold(0.0).fppi == 1.0


def test_no_picture_is_an_error():
    with pytest.raises(ValueError, match="no picture"):
        detection_curve([])


coordinates = st.floats(0, 50, width=32)
sides = st.floats(1, 40, width=32)
some_boxes = st.lists(st.tuples(coordinates, coordinates, sides, sides), min_size=1, max_size=6)


@given(detections=some_boxes, labels=some_boxes, data=st.data())
def test_matches_above_a_threshold_do_not_depend_on_what_lies_below(detections, labels, data):
    scores = data.draw(arrays(np.float64, len(detections), elements=st.floats(0, 1), unique=True))
    ignored = data.draw(arrays(bool, len(labels)))
    every = match_detections(boxes(*detections), scores, boxes(*labels), ignored)
    upper = scores >= np.median(scores)
    assert every[upper].tolist() == (
        match_detections(boxes(*detections)[upper], scores[upper], boxes(*labels), ignored).tolist()
    )
    hits = every[every >= 0]
    assert len(set(hits.tolist())) == len(hits)
    assert not ignored[hits].any()
