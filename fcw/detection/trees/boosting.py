"""Real AdaBoost of depth-2 trees over uint8 features.

Schapire and Singer, "Improved boosting algorithms using confidence-rated predictions" (1999), and for the
trees over a random part of the features Dollár et al., "Fast feature pyramids for object detection" (2014).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.detection.model import BoostedTrees
from fcw.kernels.jit import kernel

LARGEST_MARGIN = 600.0
"""Where every sample is told apart by more, weights are scaled up: exp(-745) is zero."""


@dataclass(frozen=True, slots=True)
class BoostingSettings:
    """How trees are grown.

    Attributes:
        feature_fraction: part of the features, drawn anew, that is tried at each node.
        leaf_limit: largest magnitude of a leaf, so that no single tree decides alone.
        trimmed: part of the weight that the search for splits leaves out: that of the many samples which are
            long since told apart (Friedman, Hastie & Tibshirani, "Additive logistic regression", 2000,
            section 9). Leaves are of all samples.
        seed: of the draws of features.
    """

    feature_fraction: float = 1 / 16
    leaf_limit: float = 4.0
    trimmed: float = 0.01
    seed: int = 0


def train_trees(
    positives: NDArray[np.uint8],
    negatives: NDArray[np.uint8],
    count: int,
    settings: BoostingSettings | None = None,
    on_tree: Callable[[], None] | None = None,
) -> BoostedTrees:
    """Boost `count` depth-2 trees that give vehicles a positive and everything else a negative score.

    Both classes start with half of the weight. Each split minimises Z = 2 sum sqrt(W+ W-) over its two sides
    and each leaf is 1/2 ln(W+/W-) (Schapire and Singer, section 4.1), smoothed by half of an average
    sample's weight, so the mean exponential loss never rises from one tree to the next.

    Args:
        positives: (P, F) uint8, one window a row.
        negatives: (N, F) uint8.
        count: number of trees.
        settings: how they are grown.
        on_tree: called after each tree, for a progress bar.

    Raises:
        ValueError: a class is empty or the classes have different numbers of features.
    """
    settings = settings or BoostingSettings()
    if not len(positives) or not len(negatives) or positives.shape[1] != negatives.shape[1]:
        raise ValueError(
            f"need two non-empty classes of equal feature count: {positives.shape}, {negatives.shape}"
        )
    features = np.ascontiguousarray(np.concatenate([positives, negatives]).T)
    feature_count, sample_count = features.shape
    positive = np.arange(sample_count) < len(positives)
    class_weight = np.where(positive, 0.5 / len(positives), 0.5 / len(negatives))
    sign = np.where(positive, 1.0, -1.0)
    smoothing = 0.5 / sample_count
    tried = max(1, round(feature_count * settings.feature_fraction))
    generator = np.random.default_rng(settings.seed)

    score = np.zeros(sample_count)
    feature = np.zeros((count, 3), np.uint16)
    threshold = np.zeros((count, 3), np.uint8)
    leaf = np.zeros((count, 4), np.float32)
    for tree in range(count):
        exponent = -sign * score
        exponent -= min(exponent.max() + LARGEST_MARGIN, 0.0)
        weights = class_weight * np.exp(exponent)
        weights /= weights.sum()
        rising = np.argsort(weights, kind="stable")
        matters = np.ones(sample_count, bool)
        matters[rising[: np.searchsorted(np.cumsum(weights[rising]), settings.trimmed)]] = False
        members = [np.arange(sample_count)]
        for node in range(3):
            candidates = generator.choice(feature_count, tried, replace=False)
            feature[tree, node], threshold[tree, node] = _best_split(
                features, positive, weights, members[node][matters[members[node]]], candidates
            )
            left = features[feature[tree, node], members[node]] <= threshold[tree, node]
            members += [members[node][left], members[node][~left]]
        for index, samples in enumerate(members[3:]):
            of_positives = weights[samples[samples < len(positives)]].sum()
            of_negatives = weights[samples].sum() - of_positives
            value = 0.5 * np.log((of_positives + smoothing) / (max(of_negatives, 0.0) + smoothing))
            leaf[tree, index] = np.clip(value, -settings.leaf_limit, settings.leaf_limit)
            score[samples] += leaf[tree, index]
        if on_tree:
            on_tree()
    return BoostedTrees(feature, threshold, leaf)


def running_scores(trees: BoostedTrees, features: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Score of each window after each tree: what a soft cascade compares with its threshold.

    Args:
        trees: T trees.
        features: (N, F) uint8, one window a row.

    Returns:
        (N, T) float32; the last column is the whole score.
    """
    responses = np.empty((len(features), len(trees)), np.float32)
    for tree, (feature, threshold, leaf) in enumerate(
        zip(trees.feature, trees.threshold, trees.leaf, strict=True)
    ):
        right = features[:, feature[0]] > threshold[0]
        right_again = np.where(
            right, features[:, feature[2]] > threshold[2], features[:, feature[1]] > threshold[1]
        )
        responses[:, tree] = leaf[2 * right + right_again]
    return np.cumsum(responses, axis=1, dtype=np.float32)


@kernel()
def _best_split(
    features: NDArray[np.uint8],
    positive: NDArray[np.bool_],
    weights: NDArray[np.float64],
    members: NDArray[np.int64],
    candidates: NDArray[np.int64],
) -> tuple[int, int]:
    """The candidate feature and threshold of least Z among `members`; `features` is (F, N)."""
    best_feature, best_threshold, best_bound = candidates[0], 255, 1.0
    histogram = np.empty((2, 256))
    for candidate in candidates:
        row = features[candidate]
        histogram[:] = 0.0
        for sample in members:
            histogram[int(positive[sample]), row[sample]] += weights[sample]
        right_negative, right_positive = histogram[0].sum(), histogram[1].sum()
        left_negative = left_positive = 0.0
        for value in range(256):
            left_negative += histogram[0, value]
            left_positive += histogram[1, value]
            right_negative = max(right_negative - histogram[0, value], 0.0)
            right_positive = max(right_positive - histogram[1, value], 0.0)
            bound = np.sqrt(left_negative * left_positive) + np.sqrt(right_negative * right_positive)
            if bound < best_bound:
                best_feature, best_threshold, best_bound = candidate, value, bound
    return best_feature, best_threshold
