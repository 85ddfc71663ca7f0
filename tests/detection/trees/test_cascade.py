"""The cascade kernel against a plain evaluation of the same trees, one window at a time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from searching import examples

from fcw.detection.model import BoostedTrees, Window
from fcw.detection.trees.cascade import FIRST_TREES, feature_offsets, prepare_cascade, run_cascade
from fcw.detection.trees.loops import DROPPED, SEGMENT, SLACK, add_trees

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


def with_slack(grids: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Flat, and after them what must not matter."""
    return np.concatenate([grids.reshape(-1), np.random.default_rng(1).integers(0, 256, SLACK, np.uint8)])


def run(
    grids: NDArray[np.uint8], trees: BoostedTrees, rows: range, rejection: float
) -> dict[tuple[int, int], np.float32]:
    pitch = grids.shape[2]
    columns = pitch - WINDOW.cells + 1
    places, scores = np.zeros(len(rows) * columns, np.int64), np.zeros(len(rows) * columns, np.float32)
    count = run_cascade(
        with_slack(grids),
        pitch,
        rows.start,
        rows.stop,
        columns,
        feature_offsets(trees, WINDOW, grids.shape[1] * pitch, pitch),
        prepare_cascade(trees, rejection, len(rows) * pitch),
        places,
        scores,
    )
    assert (np.diff(places[:count]) > 0).all()
    return {divmod(int(p), pitch): s for p, s in zip(places[:count], scores[:count], strict=True)}


def expected(
    grids: NDArray[np.uint8], trees: BoostedTrees, rows: range, rejection: float
) -> dict[tuple[int, int], np.float32]:
    found = {}
    for row in rows:
        for column in range(grids.shape[2] - WINDOW.cells + 1):
            features = grids[:, row : row + WINDOW.cells, column : column + WINDOW.cells].reshape(-1)
            score = plain_score(trees, features, rejection)
            if score is not None:
                found[row, column] = score
    return found


@examples(25)
@given(
    seed=st.integers(0, 2**32 - 1),
    tree_count=st.sampled_from([1, 5, FIRST_TREES, FIRST_TREES + 1, FIRST_TREES + 70]),
    rejection=st.sampled_from([-0.5, -1.0, -3.0, -1e6]),
)
def test_scores_equal_a_plain_evaluation_exactly(seed: int, tree_count: int, rejection: float):
    grids = np.random.default_rng(seed).integers(0, 256, (10, 19, 37)).astype(np.uint8)
    trees = random_trees(tree_count, seed)
    assert run(grids, trees, range(1, 4), rejection) == expected(grids, trees, range(1, 4), rejection)


@pytest.mark.parametrize(("value", "score"), [(99, 1.0), (100, 1.0), (101, 2.0)])
def test_a_feature_equal_to_the_threshold_goes_left(value: int, score: float):
    trees = BoostedTrees(
        np.zeros((1, 3), np.uint16),
        np.array([[100, 255, 255]], np.uint8),
        np.array([[1, 8, 2, 8]], np.float32),
    )
    grids = np.full((10, 16, 16), value, np.uint8)
    assert run(grids, trees, range(1), -1.0) == {(0, 0): score}


def test_a_window_that_fell_below_the_rejection_threshold_once_is_gone_whatever_comes_later():
    leaves = np.array([[-2.0] * 4, [9.0] * 4], np.float32)
    trees = BoostedTrees(np.zeros((2, 3), np.uint16), np.zeros((2, 3), np.uint8), leaves)
    grids = np.zeros((10, 16, 16), np.uint8)
    assert run(grids, trees, range(1), -1.0) == {}
    assert run(grids, trees, range(1), -2.0) == {(0, 0): 7.0}


def test_features_are_counted_channel_by_channel_row_by_row():
    features = np.array([[0, 17, 2559]], np.uint16)
    trees = BoostedTrees(features, np.zeros((1, 3), np.uint8), np.zeros((1, 4), np.float32))
    # Feature 17 is channel 0, row 1, column 1; 2559 is channel 9, row 15, column 15.
    np.testing.assert_array_equal(
        feature_offsets(trees, WINDOW, 5000, 100), [[0, 101, 9 * 5000 + 15 * 100 + 15]]
    )


@pytest.mark.parametrize("size", [(16, 16), (17, 40), (16, 2000), (60, 300)])
def test_every_window_is_scored_once_whatever_the_size_of_the_level(size: tuple[int, int]):
    # Levels of one window, of rows longer than a segment or a chunk, and of many chunks.
    grids = np.random.default_rng(2).integers(0, 256, (10, *size)).astype(np.uint8)
    trees = random_trees(3, 4)
    rows = range(size[0] - WINDOW.cells + 1)
    found = run(grids, trees, rows, -1e6)
    assert len(found) == len(rows) * (size[1] - WINDOW.cells + 1)
    assert found == expected(grids, trees, rows, -1e6)


@examples(50)
@given(
    seed=st.integers(0, 2**32 - 1),
    largest_leaf=st.sampled_from([1e-4, 0.3, 4.0]),
    rejection=st.floats(-6.0, 1.0),
)
def test_the_coarse_steps_never_drop_what_single_precision_keeps(
    seed: int, largest_leaf: float, rejection: float
):
    generator = np.random.default_rng(seed)
    trees = random_trees(FIRST_TREES, seed)
    leaves = generator.uniform(-largest_leaf, largest_leaf, trees.leaf.shape).astype(np.float32)
    trees = BoostedTrees(trees.feature, trees.threshold, leaves)
    grids = generator.integers(0, 256, (10, 16, 80)).astype(np.uint8)
    assert run(grids, trees, range(1), rejection) == expected(grids, trees, range(1), rejection)


def test_segments_hold_the_running_scores_of_their_places():
    flat = np.random.default_rng(5).integers(0, 256, 5000).astype(np.uint8)
    trees = random_trees(7, 6)
    offsets = np.random.default_rng(7).integers(0, 900, (7, 3)).astype(np.int32)
    starts, running_scores = np.array([0, 11, 4000]), np.zeros((3, SEGMENT), np.float32)
    rejection = np.float32(-0.4)
    add_trees(flat, starts, offsets, trees.threshold, trees.leaf, rejection, DROPPED, running_scores)
    places = starts[:, None] + np.arange(SEGMENT)
    running, dropped = np.zeros(places.shape, np.float32), np.zeros(places.shape, bool)
    for offset, threshold, leaf in zip(offsets, trees.threshold, trees.leaf, strict=True):
        goes_right = flat[places[..., None] + offset] > threshold
        running += leaf[np.where(goes_right[..., 0], 2 + goes_right[..., 2], goes_right[..., 1])]
        dropped |= running < rejection
    assert 0 < dropped.sum() < dropped.size
    np.testing.assert_array_equal(running_scores, np.where(dropped, DROPPED, running))
