"""Greedy suppression by intersection over the smaller area, and what it is made of."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from searching import examples

from fcw.detection.boxes.overlap import cut_to_picture, intersection_areas
from fcw.detection.boxes.suppression import sort_best_first, suppress
from fcw.frame import ImageSize

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


@examples(200)
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


def plain_suppress(
    boxes: NDArray[np.float64], scores: NDArray[np.float32], largest_overlap: float
) -> list[int]:
    """Greedy suppression as its definition reads."""
    overlap = overlaps(boxes, boxes)
    kept: list[int] = []
    for i in np.argsort(-scores, kind="stable"):
        if all(overlap[i, k] <= largest_overlap for k in kept):
            kept.append(int(i))
    return kept


@given(boxes_and_scores, st.sampled_from([0.0, 0.3, 1.0]))
def test_the_kernel_agrees_with_plain_numpy(
    data: tuple[NDArray[np.float64], NDArray[np.float32]], largest_overlap: float
):
    boxes, scores = data
    assert suppress(boxes, scores, largest_overlap).tolist() == plain_suppress(boxes, scores, largest_overlap)


@given(st.lists(st.integers(-3, 3), max_size=70))
def test_sorting_is_that_of_the_library_and_stable(values: list[int]):
    scores = np.array(values, np.float64)
    order = np.arange(len(scores))
    sort_best_first(scores, order, np.empty_like(order))
    assert order.tolist() == np.argsort(-scores, kind="stable").tolist()


def test_boxes_are_cut_half_a_pixel_outside_the_outer_pixels():
    boxes = np.array([[-3, -2, 10, 10], [95, 40, 10, 20], [10, 10, 5, 5]], np.float64)
    cut = [[-0.5, -0.5, 7.5, 8.5], [95, 40, 4.5, 9.5], [10, 10, 5, 5]]
    np.testing.assert_allclose(cut_to_picture(boxes, ImageSize(100, 50)), cut)
