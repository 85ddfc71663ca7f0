"""Scores the windows of planned levels in a picture, for both ACF detectors."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.boxes.overlap import cut
from fcw.detection.boxes.suppression import sort_best_first
from fcw.detection.channels.level_grids import AspectRatios, LevelGrids, LevelTable, gather_features
from fcw.detection.channels.octaves import Halves, Octave
from fcw.detection.model import Model
from fcw.detection.trees.cascade import Cascade, feature_offsets, prepare_cascade, run_cascade
from fcw.detection.trees.second_stage import (
    SecondStageScorer,
    prepare_second_stage,
    run_second_stage,
)
from fcw.detection.windows.plan import Level
from fcw.frame import ImageSize
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel

FIRST_CAPACITY = 1024
"""Initial capacity for windows: more than pass in a usual picture."""
LOWEST_SCORE = -1e30
"""Lower than any score, as compiled code must not use infinity."""


@dataclass(frozen=True, slots=True, eq=False)
class Proposals:
    """Windows that passed the scoring stages, best score of the cascade first, before any suppression.

    Attributes:
        boxes: (N, 4) float64, x, y, w, h of the vehicles, cut to the picture.
        placements: (N, 3) float64, where each window expects its vehicle: middle, bottom, sqrt(w h).
        scores: (N,) float32, scores of the cascade.
        second_scores: (N,) float32, scores of the second stage; None if the model has none.
        features: (N, 2560) uint8, the trees' input: channel, row, column; None unless asked for.
    """

    boxes: NDArray[np.float64]
    placements: NDArray[np.float64]
    scores: NDArray[np.float32]
    second_scores: NDArray[np.float32] | None
    features: NDArray[np.uint8] | None


class WindowFeatures(NamedTuple):
    """Where kernels find the features of windows: in rows of an array, or in the levels' memory.

    Attributes:
        rows: (N, F) features; empty if they are in the levels' memory.
        cells: memory of the levels.
        firsts: (N,) index in `cells` of each window's first cell.
        channel_pitches: (N,) elements from one channel to the next.
        row_pitches: (N,) elements from one row of cells to the next.
    """

    rows: NDArray[np.uint8]
    cells: NDArray[np.uint8]
    firsts: NDArray[np.int64]
    channel_pitches: NDArray[np.int64]
    row_pitches: NDArray[np.int64]


class FoundWindows(NamedTuple):
    """Proposals in the form that kernels read; second scores are 0 if the model has no second stage."""

    boxes: NDArray[np.float64]
    placements: NDArray[np.float64]
    scores: NDArray[np.float32]
    second_scores: NDArray[np.float32]
    features: WindowFeatures


class _Passed(NamedTuple):
    """Windows of one level that pass the cascade; has room for all windows of a level."""

    places: NDArray[np.int64]
    scores: NDArray[np.float32]
    second_scores: NDArray[np.float32]


class _Found(NamedTuple):
    """Windows of all levels above the threshold, as they are found, and the order of the output."""

    levels: NDArray[np.int64]
    places: NDArray[np.int64]
    scores: NDArray[np.float64]
    second_scores: NDArray[np.float32]
    order: NDArray[np.int64]
    spare: NDArray[np.int64]


class Scanner:
    """Scores the windows of given levels in pictures of one size, in memory that it reuses.

    The memory grows when more windows pass than ever before.
    """

    def __init__(
        self, model: Model, size: ImageSize, levels: tuple[Level, ...], aspect_ratios: AspectRatios
    ) -> None:
        """`aspect_ratios` returns the aspect ratios for the vehicles' bottom rows."""
        self.size = size
        self.windows_per_frame = sum(level.window_count for level in levels)
        self._window, self._two_scores = model.window, model.second is not None
        self._octaves: dict[int, Octave] = {}
        for number in sorted({level.octave for level in levels}, reverse=True):
            halved = ImageSize(size.width >> max(-number, 0), size.height >> max(-number, 0))
            members = [level for level in levels if level.octave == number]
            self._octaves[number] = Octave(halved, number, members)
        self._halves = Halves(size, self._octaves)
        self._grids = LevelGrids(self._octaves, levels, model.window, aspect_ratios)
        table = self._grids.table
        grids = [(int(rows), int(columns)) for rows, columns in zip(table.rows, table.row_pitch, strict=True)]
        places = (table.end_row - table.first_row - 1) * table.row_pitch + table.columns
        self._cascade = prepare_cascade(model.trees, model.rejection_threshold, int(places.max(initial=0)))
        self._cascade_offsets = _stacked(
            [feature_offsets(model.trees, model.window, rows * pitch, pitch) for rows, pitch in grids]
        )
        self._second = prepare_second_stage(model.second, model.window, grids)
        most = max((level.window_count for level in levels), default=0)
        self._passed = _Passed(
            np.empty(most, np.int64), np.empty(most, np.float32), np.zeros(most, np.float32)
        )
        self._make_room(FIRST_CAPACITY)

    def find(self, image: NDArray[np.uint8], threshold: float) -> FoundWindows:
        """All windows with a sum of both scores of at least `threshold`, best score of the cascade first.

        They are in memory that the next call overwrites.
        """
        self._halves.compute(image)
        for number, octave in self._octaves.items():
            octave.compute(self._halves.rows(image, number, octave.picture_rows))
        self._grids.fill()
        while (count := self._score(max(threshold, LOWEST_SCORE))) > len(self._found.levels):
            self._make_room(2 * count)
        out, features = self._out, self._out.features
        return FoundWindows(
            out.boxes[:count],
            out.placements[:count],
            out.scores[:count],
            out.second_scores[:count],
            WindowFeatures(
                features.rows,
                features.cells,
                features.firsts[:count],
                features.channel_pitches[:count],
                features.row_pitches[:count],
            ),
        )

    def scan(self, image: NDArray[np.uint8], threshold: float, with_features: bool) -> Proposals:
        """The windows of `find`, in new memory."""
        found = self.find(image, threshold)
        features = None
        if with_features:
            features = np.empty((len(found.scores), self._window.feature_count), np.uint8)
            _gather_all(found.features, self._window.cells, features)
        return Proposals(
            found.boxes.copy(),
            found.placements.copy(),
            found.scores.copy(),
            found.second_scores.copy() if self._two_scores else None,
            features,
        )

    def _make_room(self, count: int) -> None:
        indices, numbers = np.empty((7, count), np.int64), np.empty((3, count), np.float32)
        self._found = _Found(indices[0], indices[1], np.empty(count), numbers[0], indices[2], indices[3])
        self._out = FoundWindows(
            np.empty((count, 4)),
            np.empty((count, 3)),
            numbers[1],
            numbers[2],
            WindowFeatures(np.empty((0, 0), np.uint8), self._grids.cells, indices[4], indices[5], indices[6]),
        )

    def _score(self, threshold: float) -> int:
        return _score_levels(
            self._grids.cells,
            self._grids.table,
            self._cascade,
            self._cascade_offsets,
            self._second,
            threshold,
            self.size.width - 0.5,
            self.size.height - 0.5,
            self._passed,
            self._found,
            self._out,
        )


def _stacked(offsets: Sequence[NDArray[np.int32]]) -> NDArray[np.int32]:
    """(L, T, 3), also of no levels."""
    return np.stack(offsets) if offsets else np.empty((0, 0, 3), np.int32)


@kernel()
def _score_levels(
    cells: NDArray[np.uint8],
    table: LevelTable,
    cascade: Cascade,
    cascade_offsets: NDArray[np.int32],
    second: SecondStageScorer,
    threshold: float,
    right: float,
    bottom: float,
    passed: _Passed,
    found: _Found,
    out: FoundWindows,
) -> int:
    """Windows of all levels above the threshold, in order into `out`.

    Returns:
        How many there are; where that is more than there is room for, nothing was put out.
    """
    count = np.int64(0)  # a literal 0 would have the next kernel compiled twice
    for level in range(len(table.rows)):
        grids, row_pitch = cells[table.first_cell[level] :], table.row_pitch[level]
        passed_count = run_cascade(
            grids,
            row_pitch,
            table.first_row[level],
            table.end_row[level],
            table.columns[level],
            cascade_offsets[level],
            cascade,
            passed.places,
            passed.scores,
        )
        if passed_count > 0 and len(second.thresholds) > 0:
            run_second_stage(
                grids,
                table.rows[level],
                row_pitch,
                second,
                passed.places[:passed_count],
                passed.second_scores,
            )
        for i in range(passed_count):
            score = np.float64(passed.scores[i])
            if score + np.float64(passed.second_scores[i]) < threshold:
                continue
            if count < len(found.levels):
                found.levels[count], found.places[count] = level, passed.places[i]
                found.scores[count], found.second_scores[count] = score, passed.second_scores[i]
            count += 1
    if count <= len(found.levels):
        _put_out(table, found, count, right, bottom, out)
    return int(count)


@inner_kernel()
def _put_out(
    table: LevelTable, found: _Found, count: int, right: float, bottom: float, out: FoundWindows
) -> None:
    """Windows in order, with the places of their vehicles, and of their features."""
    order = found.order[:count]
    for i in range(count):
        order[i] = i
    sort_best_first(found.scores, order, found.spare)
    for to in range(count):
        i = order[to]
        level, place = found.levels[i], found.places[i]
        row_pitch = table.row_pitch[level]
        row, column = place // row_pitch - table.first_row[level], place % row_pitch
        by_row = table.by_row[table.first_in_rows[level] + row]
        middle = table.middles[table.first_in_columns[level] + column]
        vehicle_bottom, size, width, height = by_row[0], by_row[1], by_row[2], by_row[3]
        placement, box = out.placements[to], out.boxes[to]
        placement[0], placement[1], placement[2] = middle, vehicle_bottom, size
        box[0], box[1], box[2], box[3] = middle - width / 2, vehicle_bottom - height, width, height
        cut(box, right, bottom)
        out.scores[to], out.second_scores[to] = np.float32(found.scores[i]), found.second_scores[i]
        out.features.firsts[to] = table.first_cell[level] + place
        out.features.channel_pitches[to] = table.rows[level] * row_pitch
        out.features.row_pitches[to] = row_pitch


@kernel()
def _gather_all(source: WindowFeatures, window_cells: int, features: NDArray[np.uint8]) -> None:
    """The features of all windows in the levels' memory."""
    for i in range(len(features)):
        gather_features(
            source.cells,
            source.firsts[i],
            source.channel_pitches[i],
            source.row_pitches[i],
            window_cells,
            features[i],
        )
