"""The cascade kernel against a plain evaluation of the same trees, one window at a time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.detection.cascade import ROW_TREES, feature_offsets, score_windows
from fcw.detection.model import BoostedTrees, Window

WINDOW = Window()


def random_trees(count: int, seed: int) -> BoostedTrees:
    rng = np.random.default_rng(seed)
    return BoostedTrees(
        rng.integers(0, WINDOW.feature_count, (count, 3)).astype(np.uint16),
        rng.integers(0, 256, (count, 3)).astype(np.uint8),
        rng.normal(0, 0.3, (count, 4)).astype(np.float32),
    )


def plain_score(trees: BoostedTrees, features: NDArray[np.uint8], rejection: float) -> np.float32 | None:
    """Sum of the leaves in single precision, None once it has fallen below the rejection threshold."""
    score = np.float32(0)
    for feature, threshold, leaf in zip(trees.feature, trees.threshold, trees.leaf, strict=True):
        child = 1 if features[feature[0]] <= threshold[0] else 2
        left = features[feature[child]] <= threshold[child]
        score += leaf[2 * (child - 1) + (0 if left else 1)]
        if score < rejection:
            return None
    return score


def run(
    grids: NDArray[np.uint8],
    trees: BoostedTrees,
    rows: range,
    rejection: float,
    threshold: float,
    capacity: int = 4096,
) -> tuple[int, dict[tuple[int, int], np.float32]]:
    columns = grids.shape[2] - WINDOW.cells + 1
    places, scores = np.zeros((capacity, 2), np.int32), np.zeros(capacity, np.float32)
    count = score_windows(
        grids.reshape(-1),
        grids.shape[2],
        rows.start,
        rows.stop,
        columns,
        feature_offsets(trees, WINDOW, grids.shape[1] * grids.shape[2], grids.shape[2]),
        trees.threshold,
        trees.leaf,
        rejection,
        threshold,
        np.zeros((2, columns + 3), np.float32),
        places,
        scores,
    )
    kept = min(count, capacity)
    return count, {(int(r), int(c)): s for (r, c), s in zip(places[:kept], scores[:kept], strict=True)}


def expected(
    grids: NDArray[np.uint8], trees: BoostedTrees, rows: range, rejection: float, threshold: float
) -> dict[tuple[int, int], np.float32]:
    found = {}
    for row in rows:
        for column in range(grids.shape[2] - WINDOW.cells + 1):
            features = grids[:, row : row + WINDOW.cells, column : column + WINDOW.cells].reshape(-1)
            score = plain_score(trees, features, rejection)
            if score is not None and score >= threshold:
                found[row, column] = score
    return found


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    tree_count=st.sampled_from([1, 5, ROW_TREES, ROW_TREES + 1, ROW_TREES + 6]),
    rejection=st.sampled_from([-0.5, -1.0, -3.0, -1e6]),
    threshold=st.sampled_from([-2.0, 0.0, 1.0]),
)
def test_scores_equal_a_plain_evaluation_exactly(
    seed: int, tree_count: int, rejection: float, threshold: float
):
    grids = np.random.default_rng(seed).integers(0, 256, (10, 19, 37)).astype(np.uint8)
    trees = random_trees(tree_count, seed)
    count, found = run(grids, trees, range(1, 4), rejection, threshold)
    wanted = expected(grids, trees, range(1, 4), rejection, threshold)
    assert found == wanted
    assert count == len(wanted)


@pytest.mark.parametrize(("value", "score"), [(99, 1.0), (100, 1.0), (101, 2.0)])
def test_a_feature_equal_to_the_threshold_goes_left(value: int, score: float):
    trees = BoostedTrees(
        np.zeros((1, 3), np.uint16),
        np.array([[100, 255, 255]], np.uint8),
        np.array([[1, 8, 2, 8]], np.float32),
    )
    grids = np.full((10, 16, 16), value, np.uint8)
    assert run(grids, trees, range(1), -1.0, 0.0)[1] == {(0, 0): score}


def test_a_window_that_fell_below_the_rejection_threshold_once_is_gone_whatever_comes_later():
    leaves = np.array([[-2.0] * 4, [9.0] * 4], np.float32)
    trees = BoostedTrees(np.zeros((2, 3), np.uint16), np.zeros((2, 3), np.uint8), leaves)
    grids = np.zeros((10, 16, 16), np.uint8)
    assert run(grids, trees, range(1), -1.0, 0.0)[1] == {}
    assert run(grids, trees, range(1), -2.0, 0.0)[1] == {(0, 0): 7.0}


def test_more_windows_than_there_is_room_for_are_counted():
    grids = np.zeros((10, 17, 20), np.uint8)
    trees = random_trees(3, 0)
    count, found = run(grids, trees, range(2), -1e6, -100.0, capacity=3)
    assert count == 10
    assert set(found) == {(0, 0), (0, 1), (0, 2)}


def test_features_are_counted_channel_by_channel_row_by_row():
    features = np.array([[0, 17, 2559]], np.uint16)
    trees = BoostedTrees(features, np.zeros((1, 3), np.uint8), np.zeros((1, 4), np.float32))
    # Feature 17 is channel 0, row 1, column 1; 2559 is channel 9, row 15, column 15.
    np.testing.assert_array_equal(
        feature_offsets(trees, WINDOW, 5000, 100), [[0, 101, 9 * 5000 + 15 * 100 + 15]]
    )
