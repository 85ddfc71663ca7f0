"""The second stage: filters that decorrelate, and a kernel that agrees with them to the bit."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from fcw.detection.channels.decorrelation import WEIGHT_STEPS, decorrelated, learn_filters
from fcw.detection.model import BoostedTrees, SecondStage, Window
from fcw.detection.trees.boosting import running_scores, train_trees
from fcw.detection.trees.loops import SLACK
from fcw.detection.trees.second_stage import prepare_second_stage, run_second_stage

WINDOW = Window()


def smooth_windows(count: int, seed: int = 0, blur: float = 1.0) -> NDArray[np.uint8]:
    """Windows whose neighbouring cells are alike, as real channels' are."""
    noise = np.random.default_rng(seed).normal(size=(count, 10, 16, 16))
    soft = ndimage.gaussian_filter(noise, (0, 0, blur, blur))
    return np.clip(128 + 60 * soft / soft.std(), 0, 255).astype(np.uint8).reshape(count, -1)


@pytest.fixture(scope="module")
def windows() -> NDArray[np.uint8]:
    return smooth_windows(300)


Filters = tuple[NDArray[np.int8], NDArray[np.int32], NDArray[np.uint8]]


@pytest.fixture(scope="module")
def filters(windows: NDArray[np.uint8]) -> Filters:
    return learn_filters(windows, WINDOW)


def random_stage(filters: Filters, count: int, seed: int) -> SecondStage:
    """Given filters, with trees of random nodes, every threshold from 0 to 255 among them."""
    generator = np.random.default_rng(seed)
    trees = BoostedTrees(
        generator.integers(0, 10 * 4 * 12 * 12, (count, 3)).astype(np.uint16),
        np.concatenate([np.arange(256), generator.integers(60, 200, 3 * count - 256)])
        .reshape(count, 3)
        .astype(np.uint8),
        generator.normal(size=(count, 4)).astype(np.float32),
    )
    return SecondStage(*filters, trees=trees)


def test_filters_are_orthonormal_and_explain_the_most_variance(windows: NDArray[np.uint8], filters: Filters):
    weights, _, _ = filters
    patches = np.lib.stride_tricks.sliding_window_view(windows.reshape(-1, 10, 16, 16), (5, 5), (2, 3))
    for channel in range(10):
        kernels = weights[channel].reshape(4, 25) / WEIGHT_STEPS
        np.testing.assert_allclose(kernels @ kernels.T, np.eye(4), atol=0.03)  # hundredths are rounded
        covariance = np.cov(patches[:, channel].reshape(-1, 25).T.astype(float))
        explained = np.trace(kernels @ covariance @ kernels.T)
        assert explained == pytest.approx(np.sort(np.linalg.eigvalsh(covariance))[-4:].sum(), rel=0.01)


def test_responses_of_one_place_are_uncorrelated_where_the_cells_were_not(
    windows: NDArray[np.uint8], filters: Filters
):
    responses = decorrelated(smooth_windows(300, seed=1), WINDOW, *filters).reshape(-1, 10, 4, 12, 12)
    cells = windows.reshape(-1, 10, 16, 16)
    neighbours = np.corrcoef(cells[:, 0, 4:12, 4:12].ravel(), cells[:, 0, 4:12, 5:13].ravel())[0, 1]
    assert neighbours > 0.6
    across = np.corrcoef(responses[:, 0].transpose(1, 0, 2, 3).reshape(4, -1))
    assert np.abs(across - np.eye(4)).max() < 0.1


def test_responses_are_those_of_a_float64_correlation_in_steps(windows: NDArray[np.uint8], filters: Filters):
    weights, means, shifts = filters
    steps = decorrelated(windows[:20], WINDOW, weights, means, shifts).reshape(20, 10, 4, 12, 12)
    for channel in range(10):
        for number in range(4):
            for i in range(0, 20, 10):
                cells = windows[i].reshape(10, 16, 16)[channel].astype(np.float64)
                filtered = ndimage.correlate(cells, weights[channel, number].astype(np.float64))[2:-2, 2:-2]
                expected = np.floor((filtered - means[channel, number]) / 2.0 ** shifts[channel, number])
                np.testing.assert_array_equal(steps[i, channel, number], np.clip(expected + 128, 0, 255))


def test_steps_are_used_well(windows: NDArray[np.uint8], filters: Filters):
    steps = decorrelated(windows, WINDOW, *filters).reshape(300, 40, -1)
    spread = steps.std(axis=(0, 2))
    assert (spread > 15).all()
    assert ((steps == 0) | (steps == 255)).mean() < 0.01


@pytest.mark.parametrize("size", [(16, 16), (17, 33), (30, 70)])
@pytest.mark.parametrize("share", [0.02, 0.3, 1.0])
def test_the_kernel_scores_as_the_trees_over_the_responses_do(
    filters: Filters, size: tuple[int, int], share: float
):
    stage = random_stage(filters, 200, seed=2)
    generator = np.random.default_rng(4)
    smooth = ndimage.gaussian_filter(generator.normal(size=(10, *size)), (0, 0.7, 0.7))
    grids = np.clip(128 + 90 * smooth / smooth.std(), 0, 255).astype(np.uint8)
    scorer = prepare_second_stage(stage, WINDOW, [size])
    for _ in range(2):  # what was computed before must not matter
        tops, lefts = np.nonzero(generator.uniform(size=(size[0] - 15, size[1] - 15)) < share)
        features = np.array(
            [grids[:, r : r + 16, c : c + 16].ravel() for r, c in zip(tops, lefts, strict=True)]
        )
        responses = decorrelated(features.reshape(-1, 2560), WINDOW, stage.weights, stage.means, stage.shifts)
        expected = running_scores(stage.trees, responses)[:, -1]
        flat = np.concatenate([grids.ravel(), generator.integers(0, 256, SLACK, np.uint8)])
        scores = np.empty(len(tops), np.float32)
        run_second_stage(flat, *size, scorer, tops * size[1] + lefts, scores)
        np.testing.assert_allclose(scores, expected, atol=1e-4)


def test_one_scorer_serves_levels_of_all_sizes(filters: Filters):
    stage = random_stage(filters, 100, seed=5)
    sizes = [(20, 30), (60, 300), (16, 40), (20, 30)]
    scorer = prepare_second_stage(stage, WINDOW, sizes)
    generator = np.random.default_rng(6)
    for rows, columns in sizes:
        flat = generator.integers(0, 256, 10 * rows * columns + SLACK, np.uint8)
        places = np.sort(generator.choice((rows - 15) * columns - 15, 5, replace=False))
        places = places[places % columns <= columns - 16]
        shared, alone = np.zeros((2, len(places)), np.float32)
        run_second_stage(flat, rows, columns, scorer, places, shared)
        own = prepare_second_stage(stage, WINDOW, [(rows, columns)])
        run_second_stage(flat, rows, columns, own, places, alone)
        assert alone.any()
        np.testing.assert_array_equal(shared, alone)


def test_trees_over_filters_tell_textures_apart_that_trees_over_cells_hardly_do(filters: Filters):
    # The same cells' values, but neighbours alike or not: no single cell says which.
    alike, unlike = smooth_windows(400, 6, blur=1.2), smooth_windows(400, 7, blur=0.3)
    responses = [decorrelated(side, WINDOW, *filters) for side in (alike, unlike)]

    def errors(sides: list[NDArray[np.uint8]]) -> float:
        trees = train_trees(sides[0][:200], sides[1][:200], 16)
        scores = [running_scores(trees, side[200:])[:, -1] for side in sides]
        return float(((scores[0] <= 0).mean() + (scores[1] > 0).mean()) / 2)

    assert errors(responses) < 0.1 < 0.25 < errors([alike, unlike])
