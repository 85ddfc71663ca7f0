"""From the windows that pass the scoring stages to vehicles: non-maximum suppression, and boxes."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.overlap import cut
from fcw.detection.boxes.regression import place_box
from fcw.detection.boxes.suppression import agree, keep_apart, sort_best_first
from fcw.detection.channels.level_grids import gather_features
from fcw.detection.model import Model
from fcw.detection.scanner import LOWEST_SCORE, FoundWindows, Proposals, WindowFeatures
from fcw.frame import ImageSize
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel

UNDECIDED_SCORE = 0.0
"""Score at which vehicle and background are equally likely. Only windows above it are averaged to the box."""
LONE_WEIGHT = 1e-9
"""Weight of a kept window that is not above it, which then is its own box."""
AGREEING_IOU = 0.5
"""IoU from which a window agrees with the best one."""


@dataclass(frozen=True, slots=True, eq=False)
class Vehicles:
    """The vehicles in a picture, best score first.

    Attributes:
        boxes: (N, 4) float64, x, y, w, h, cut to the picture.
        scores: (N,) float64, sums of the scores of all stages.
        windows: (N,) indices of their proposals.
    """

    boxes: NDArray[np.float64]
    scores: NDArray[np.float64]
    windows: NDArray[np.int64]


class _Regressor(NamedTuple):
    """A regressor in the form that the kernel reads: weights (3, F), with F = 0 if the model has none."""

    weights: NDArray[np.float32]
    constant: NDArray[np.float32]
    bottom: float
    window_cells: int


class _Memory(NamedTuple):
    """Working memory of the kernel and, the last three, its output; each has room for N windows."""

    totals: NDArray[np.float64]
    order: NDArray[np.int64]
    spare: NDArray[np.int64]
    kept: NDArray[np.int64]
    weights: NDArray[np.float64]
    merged: NDArray[np.float64]
    features: NDArray[np.uint8]
    vote: NDArray[np.float64]
    boxes: NDArray[np.float64]
    scores: NDArray[np.float64]
    windows: NDArray[np.int64]


def _memory(count: int, feature_count: int) -> _Memory:
    numbers, indices, boxes = np.empty((3, count)), np.empty((4, count), np.int64), np.empty((2, count, 4))
    return _Memory(
        totals=numbers[0],
        order=indices[0],
        spare=indices[1],
        kept=indices[2],
        weights=numbers[1],
        merged=boxes[0],
        features=np.empty(feature_count, np.uint8),
        vote=np.empty(4),
        boxes=boxes[1],
        scores=numbers[2],
        windows=indices[3],
    )


class LaterStages:
    """A model's stages after the scores; without a regressor, only suppression and box voting.

    An instance owns working memory, so each thread needs its own. The memory grows when there are more
    windows than ever before.
    """

    def __init__(self, model: Model) -> None:
        regressor = model.regressor
        self._regressor = _Regressor(
            np.array(regressor.weights.T if regressor else np.empty((3, 0)), np.float32, order="C"),
            np.array(regressor.constant if regressor else np.zeros(3), np.float32),
            float(regressor.bottom) if regressor else 0.0,
            model.window.cells,
        )
        self._two_scores = model.second is not None
        self._memory = _memory(0, model.window.feature_count)

    def gate(self, score_threshold: float) -> float:
        """Least score of the windows that matter for vehicles with at least a final score.

        Windows with a lower score do not change boxes, and only suppress windows with a still lower score.
        """
        return min(score_threshold, UNDECIDED_SCORE)

    def vehicles(self, proposals: Proposals, largest_overlap: float, size: ImageSize) -> Vehicles:
        """Keep the best of overlapping windows, and compute their boxes.

        A box is the mean of the windows that agree with the best one (box voting, Gidaris & Komodakis 2015),
        each corrected by the regressor. Windows are on a grid of positions and scales, and the mean of
        several finds edges between its steps. Boxes that then overlap too much are suppressed once more.

        Raises:
            ValueError: the model has a regressor or a second stage, and the proposals lack features or
                second scores.
        """
        features, second_scores = proposals.features, proposals.second_scores
        if features is None:
            if self._regressor.weights.size:
                raise ValueError("the model's regressor needs proposals with features")
            features = np.empty((0, 0), np.uint8)
        if second_scores is None:
            if self._two_scores:
                raise ValueError("the model's second stage needs proposals with its scores")
            second_scores = np.zeros_like(proposals.scores)
        none = np.empty(0, np.int64)
        found = FoundWindows(
            proposals.boxes,
            proposals.placements,
            proposals.scores,
            second_scores,
            WindowFeatures(features, np.empty(0, np.uint8), none, none, none),
        )
        result = self.find(found, largest_overlap, size, LOWEST_SCORE)
        return Vehicles(result.boxes.copy(), result.scores.copy(), result.windows.copy())

    def find(
        self, found: FoundWindows, largest_overlap: float, size: ImageSize, score_threshold: float
    ) -> Vehicles:
        """Like `vehicles`, with at least a score, in memory that the next call overwrites."""
        if len(found.scores) > len(self._memory.totals):
            self._memory = _memory(2 * len(found.scores), len(self._memory.features))
        memory = self._memory
        count = _find(
            found,
            self._regressor,
            self._two_scores,
            largest_overlap,
            score_threshold,
            size.width - 0.5,
            size.height - 0.5,
            memory,
        )
        return Vehicles(memory.boxes[:count], memory.scores[:count], memory.windows[:count])


@kernel()
def _find(
    found: FoundWindows,
    regressor: _Regressor,
    two_scores: bool,
    largest_overlap: float,
    score_threshold: float,
    right: float,
    bottom: float,
    memory: _Memory,
) -> int:
    """The compiled part of `LaterStages.vehicles`; returns the number of vehicles."""
    count = len(found.scores)
    order, kept = memory.order[:count], memory.kept
    for i in range(count):
        second_score = found.second_scores[i] if two_scores else np.float32(0)
        memory.totals[i] = np.float64(found.scores[i]) + np.float64(second_score)
        order[i] = i
    sort_best_first(memory.totals, order, memory.spare)
    kept_count = keep_apart(found.boxes, order, largest_overlap, kept)
    while kept_count > 0 and memory.totals[kept[kept_count - 1]] < score_threshold:
        kept_count -= 1
    _merge(found, regressor, kept[:kept_count], memory)
    for k in range(kept_count):
        cut(memory.merged[k], right, bottom)
        order[k] = k
    if regressor.weights.size > 0:
        kept_count = keep_apart(memory.merged, order[:kept_count], largest_overlap, memory.spare)
    else:
        for k in range(kept_count):
            memory.spare[k] = k
    for to in range(kept_count):
        k = memory.spare[to]
        for side in range(4):
            memory.boxes[to, side] = memory.merged[k, side]
        memory.windows[to] = kept[k]
        memory.scores[to] = memory.totals[kept[k]]
    return kept_count


@inner_kernel()
def _merge(found: FoundWindows, regressor: _Regressor, kept: NDArray[np.int64], memory: _Memory) -> None:
    """Boxes of the kept windows: weighted means of the boxes that agreeing windows vote for."""
    merged, weights, vote = memory.merged, memory.weights, memory.vote
    for k in range(len(kept)):
        weights[k] = 0.0
        for side in range(4):
            merged[k, side] = 0.0
    for i in range(len(found.scores)):
        has_voted = False
        surplus = max(memory.totals[i] - UNDECIDED_SCORE, 0.0)
        for k in range(len(kept)):
            weight = surplus * surplus  # squared, because the windows with the best scores are placed best
            if kept[k] == i:
                weight = max(weight, LONE_WEIGHT)
            if weight <= 0.0 or not agree(found.boxes, i, kept[k], AGREEING_IOU):
                continue
            if not has_voted:
                _vote(found, regressor, i, memory)
                has_voted = True
            # A mean of x, y, w, h is the box of the mean edges: right and bottom are sums of them.
            for side in range(4):
                merged[k, side] += weight * vote[side]
            weights[k] += weight
    for k in range(len(kept)):
        for side in range(4):
            merged[k, side] /= weights[k]


@inner_kernel()
def _vote(found: FoundWindows, regressor: _Regressor, i: int, memory: _Memory) -> None:
    """The box that a window votes for: its own, or the regressor's."""
    if regressor.weights.size == 0:
        for side in range(4):
            memory.vote[side] = found.boxes[i, side]
        return
    source, features = found.features, memory.features
    if source.rows.size > 0:
        features = source.rows[i]
    else:
        gather_features(
            source.cells,
            source.firsts[i],
            source.channel_pitches[i],
            source.row_pitches[i],
            regressor.window_cells,
            features,
        )
    place_box(
        regressor.weights, regressor.constant, regressor.bottom, features, found.placements[i], memory.vote
    )
