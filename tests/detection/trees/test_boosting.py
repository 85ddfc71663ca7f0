"""Boosting: what AdaBoost promises of its loss, and what the trees mean."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.detection.model import BoostedTrees
from fcw.detection.trees.boosting import BoostingSettings, running_scores, train_trees


def exponential_losses(trees, positives, negatives):
    """Mean exp(-y score), each class weighing half, after 0, 1, 2, ... trees."""
    of_positives = np.exp(-running_scores(trees, positives).astype(np.float64)).mean(axis=0)
    of_negatives = np.exp(running_scores(trees, negatives).astype(np.float64)).mean(axis=0)
    return np.concatenate([[1.0], (of_positives + of_negatives) / 2])


@given(seed=st.integers(0, 2**32 - 1), positives=st.integers(1, 60), negatives=st.integers(1, 60))
def test_no_tree_raises_the_exponential_loss_even_on_pure_noise(seed, positives, negatives):
    samples = np.random.default_rng(seed).integers(0, 256, (positives + negatives, 12), np.uint8)
    trees = train_trees(
        samples[:positives], samples[positives:], 8, BoostingSettings(feature_fraction=0.25, seed=seed)
    )
    losses = exponential_losses(trees, samples[:positives], samples[positives:])
    assert np.all(np.diff(losses) <= 1e-6)


def test_one_tree_separates_the_conjunction_that_no_single_threshold_can():
    # Positive where feature 3 > 100 and feature 7 <= 50: two levels are needed, and suffice.
    samples = np.random.default_rng(1).integers(0, 256, (2000, 10), np.uint8)
    positive = (samples[:, 3] > 100) & (samples[:, 7] <= 50)
    trees = train_trees(samples[positive], samples[~positive], 1, BoostingSettings(feature_fraction=1.0))
    score = running_scores(trees, samples)[:, -1]
    assert np.array_equal(score > 0, positive)
    assert {3, 7} <= set(trees.feature[0].tolist())


def test_boosting_separates_what_one_tree_cannot():
    # A vote of five features: no depth-2 tree sees more than two of them.
    samples = np.random.default_rng(2).integers(0, 256, (3000, 20), np.uint8)
    positive = (samples[:, :5] > 127).sum(axis=1) >= 3
    trees = train_trees(samples[positive], samples[~positive], 64, BoostingSettings(feature_fraction=0.5))
    wrong = ((running_scores(trees, samples) > 0) != positive[:, None]).mean(axis=0)
    assert wrong[0] > 0.2
    assert wrong[-1] < 0.02


def test_the_first_leaf_is_half_the_log_odds():
    # 3 of 4 positives but 1 of 4 negatives lie high: with equal classes the odds are 3 and 1/3.
    positives = np.array([[200]] * 30 + [[10]] * 10, np.uint8)
    negatives = np.array([[200]] * 10 + [[10]] * 30, np.uint8)
    score = running_scores(train_trees(positives, negatives, 1), np.array([[200], [10]], np.uint8))[:, 0]
    # Smoothing by half a sample's weight of 80 moves 3/1 to 30.5/10.5.
    assert score == pytest.approx([0.5 * np.log(30.5 / 10.5), -0.5 * np.log(30.5 / 10.5)], abs=1e-6)


def test_a_window_goes_left_where_its_feature_is_at_most_the_threshold():
    trees = BoostedTrees(
        feature=np.array([[0, 1, 2]], np.uint16),
        threshold=np.array([[10, 20, 30]], np.uint8),
        leaf=np.array([[1, 2, 3, 4]], np.float32),
    )
    windows = np.array([[10, 20, 99], [10, 21, 99], [11, 99, 30], [11, 99, 31]], np.uint8)
    assert running_scores(trees, windows)[:, 0].tolist() == [1, 2, 3, 4]


def test_running_scores_add_up_tree_by_tree():
    generator = np.random.default_rng(3)
    samples = generator.integers(0, 256, (50, 6), np.uint8)
    trees = train_trees(samples[:20], samples[20:], 5, BoostingSettings(feature_fraction=1.0))
    alone = [
        running_scores(BoostedTrees(feature[None], threshold[None], leaf[None]), samples)
        for feature, threshold, leaf in zip(trees.feature, trees.threshold, trees.leaf, strict=True)
    ]
    assert running_scores(trees, samples) == pytest.approx(np.cumsum(np.hstack(alone), axis=1), abs=1e-5)


def test_the_same_seed_grows_the_same_trees_and_another_seed_others():
    samples = np.random.default_rng(4).integers(0, 256, (200, 64), np.uint8)
    grown = [
        train_trees(samples[:80], samples[80:], 6, BoostingSettings(seed=seed)).feature for seed in (5, 5, 6)
    ]
    assert np.array_equal(grown[0], grown[1])
    assert not np.array_equal(grown[0], grown[2])


def test_boosting_goes_on_where_everything_is_long_since_told_apart():
    # 400 trees of leaves near 2 give margins of about 800, whose weights exp(-800) are no longer numbers.
    positives, negatives = np.full((40, 1), 200, np.uint8), np.full((40, 1), 10, np.uint8)
    with np.errstate(all="raise", under="ignore"):
        trees = train_trees(positives, negatives, 400)
    score = running_scores(trees, np.array([[200], [10]], np.uint8))
    assert np.all(np.isfinite(trees.leaf))
    assert np.all(np.diff(score[0]) > 0)
    assert np.all(np.diff(score[1]) < 0)
    assert score[0, -1] > 745


def test_an_empty_class_is_refused():
    samples = np.zeros((3, 4), np.uint8)
    with pytest.raises(ValueError, match="non-empty"):
        train_trees(samples, samples[:0], 1)
