"""Greedy suppression by intersection over the smaller area."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.detection.overlap import intersection_areas
from fcw.detection.suppression import merge, suppress

side = st.integers(1, 60)
place = st.integers(0, 100)
boxes_and_scores = st.lists(st.tuples(place, place, side, side, st.integers(-5, 5)), max_size=40).map(
    lambda rows: (
        np.array([r[:4] for r in rows], np.float64).reshape(-1, 4),
        np.array([r[4] for r in rows], np.float32),
    )
)


def overlaps(boxes: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    smaller = np.minimum(np.prod(boxes[:, None, 2:], axis=2), np.prod(others[None, :, 2:], axis=2))
    return intersection_areas(boxes, others) / smaller


@settings(max_examples=200, deadline=None)
@given(boxes_and_scores)
def test_kept_boxes_stand_apart_and_every_other_yields_to_a_better_one(
    data: tuple[NDArray[np.float64], NDArray[np.float32]],
):
    boxes, scores = data
    kept = suppress(boxes, scores, 0.5)
    assert (np.diff(scores[kept]) <= 0).all()
    among_kept = overlaps(boxes[kept], boxes[kept])
    np.fill_diagonal(among_kept, 0)
    assert (among_kept <= 0.5).all()
    dropped = np.setdiff1d(np.arange(len(boxes)), kept)
    yields = (overlaps(boxes[dropped], boxes[kept]) > 0.5) & (scores[kept] >= scores[dropped][:, None])
    assert yields.any(axis=1).all()
    np.testing.assert_array_equal(suppress(boxes[kept], scores[kept], 0.5), np.arange(len(kept)))


def test_a_box_within_a_better_one_is_dropped_however_small():
    boxes = np.array([[0, 0, 100, 100], [10, 10, 20, 20], [200, 0, 10, 10]], np.float64)
    np.testing.assert_array_equal(suppress(boxes, np.array([1.0, 0.5, 2.0]), 0.5), [2, 0])


def test_half_of_the_smaller_area_is_still_allowed():
    boxes = np.array([[0, 0, 10, 10], [5, 0, 10, 10], [4, 20, 10, 10], [0, 20, 10, 10]], np.float64)
    np.testing.assert_array_equal(suppress(boxes, np.array([4.0, 3.0, 2.0, 1.0]), 0.5), [0, 1, 2])


def test_of_equal_scores_the_first_stays():
    boxes = np.array([[1, 0, 10, 10], [0, 0, 10, 10]], np.float64)
    np.testing.assert_array_equal(suppress(boxes, np.zeros(2), 0.5), [0])


def test_a_lone_box_stays_and_agreeing_ones_meet_at_their_weighted_mean():
    boxes = np.array([[0, 0, 10, 10], [2, 1, 10, 10], [50, 50, 8, 8]], np.float64)
    merged = merge(boxes, boxes, np.array([3.0, 1.0, 5.0]), np.array([0, 2]), smallest_iou=0.5)
    np.testing.assert_allclose(merged, [[0.5, 0.25, 10, 10], [50, 50, 8, 8]])


def test_windows_agree_by_where_they_are_and_vote_for_other_boxes():
    windows = np.array([[0, 0, 10, 10], [1, 0, 10, 10], [50, 50, 8, 8]], np.float64)
    votes = np.array([[4, 4, 12, 12], [4, 4, 8, 8], [60, 60, 8, 8]], np.float64)
    merged = merge(votes, windows, np.array([1.0, 1.0, 5.0]), np.array([0, 2]), smallest_iou=0.5)
    np.testing.assert_allclose(merged, [[4, 4, 10, 10], [60, 60, 8, 8]])


@given(boxes_and_scores)
def test_merged_edges_lie_within_those_of_the_windows(data: tuple[NDArray[np.float64], NDArray[np.float32]]):
    boxes, scores = data
    kept = suppress(boxes, scores, 0.5)
    merged = merge(boxes, boxes, np.exp(scores.astype(np.float64)), kept, smallest_iou=0.5)
    assert merged.shape == (len(kept), 4)
    if len(kept):
        assert (merged >= boxes.min(axis=0) - 1e-9).all()
        assert (merged <= boxes.max(axis=0) + 1e-9).all()
