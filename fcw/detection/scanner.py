"""Scoring the windows of planned levels in a picture: what both ACF detectors do."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.detection.cascade import SLACK, Cascade, feature_offsets
from fcw.detection.channels import COARSE, CONTEXT_PX, FINE, ChannelComputer
from fcw.detection.decorrelation import SecondStageScorer
from fcw.detection.jit import kernel
from fcw.detection.model import CELL_PX, CHANNEL_COUNT, Model, Window
from fcw.detection.windows import PAD_CELLS, Level
from fcw.sources.frame import ImageSize

FIRST_CAPACITY = 4096
"""Windows of a level that the result buffers hold at first; they grow where more come through."""


@dataclass(frozen=True, slots=True, eq=False)
class Proposals:
    """Windows that passed the scoring stages, best score of the cascade first, before any suppression.

    Attributes:
        boxes: (N, 4) float64, x, y, w, h of the vehicles, cut to the picture.
        placements: (N, 3) float64, where each window expects its vehicle: middle, bottom, sqrt(w h).
        scores: (N,) float32, of the cascade.
        second_scores: (N,) float32, of the second stage; None where the model has none.
        features: (N, 2560) uint8, what the trees saw: channel, row, column; None unless asked for.
    """

    boxes: NDArray[np.float64]
    placements: NDArray[np.float64]
    scores: NDArray[np.float32]
    second_scores: NDArray[np.float32] | None
    features: NDArray[np.uint8] | None


class _Octave:
    """One octave's channels in the rows that its levels need, edges repeated beyond the picture."""

    def __init__(self, size: ImageSize, number: int, levels: list[Level]) -> None:
        """`size` is that of the picture the channels are computed of."""
        settings = FINE if number > 0 else COARSE
        first_cut = min(level.first_cut for level in levels)
        end_cut = max(level.first_cut + level.cut_rows for level in levels)
        self.first_row = first_cut
        first, end = max(first_cut, 0), min(end_cut, size.height // settings.cell_px)
        context = math.ceil(CONTEXT_PX / CELL_PX)
        first_cell, end_cell = max(first - context, 0), min(end + context, size.height // settings.cell_px)
        self.picture_rows = slice(first_cell * settings.cell_px, end_cell * settings.cell_px)
        """Rows of the picture that the channels depend on."""
        height = self.picture_rows.stop - self.picture_rows.start
        self._computer = ChannelComputer(ImageSize(size.width, height), settings)
        self._wanted = first - first_cell, end - first_cell
        self._inside = slice(first - first_cut, end - first_cut)
        rows, columns = end_cut - first_cut, self._computer.columns + 2 * PAD_CELLS
        self.memory = _memory(rows * columns)
        self.grid = _shaped(self.memory, rows, columns)

    def compute(self, picture_rows: NDArray[np.uint8]) -> None:
        """Fill the grid from the rows asked for."""
        grid, first, end = self.grid, self._inside.start, self._inside.stop
        self._computer.compute(picture_rows, *self._wanted, out=grid[:, first:end, PAD_CELLS:-PAD_CELLS])
        grid[:, :, :PAD_CELLS] = grid[:, :, PAD_CELLS : PAD_CELLS + 1]
        grid[:, :, -PAD_CELLS:] = grid[:, :, -PAD_CELLS - 1 : -PAD_CELLS]
        grid[:, :first] = grid[:, first : first + 1]
        grid[:, end:] = grid[:, end - 1 : end]


class _Halves:
    """The picture at 1/2, 1/4, ... of its size, each in the rows needed of it and of the next."""

    def __init__(self, size: ImageSize, octaves: dict[int, _Octave]) -> None:
        self._rows: dict[int, slice] = {0: slice(0, size.height)}
        self._reduced: dict[int, NDArray[np.uint8]] = {}
        needed = None
        for number in range(min(octaves, default=0), 0):
            wanted = [needed] if needed else []
            wanted += [octaves[number].picture_rows] if number in octaves else []
            rows = slice(min(r.start for r in wanted), max(r.stop for r in wanted))
            self._rows[number] = rows
            self._reduced[number] = np.empty((rows.stop - rows.start, size.width >> -number, 3), np.uint8)
            needed = slice(2 * rows.start, 2 * rows.stop)

    def compute(self, image: NDArray[np.uint8]) -> None:
        """Fill them from a picture."""
        source = image
        for number in sorted(self._reduced, reverse=True):
            reduced, first = self._reduced[number], self._rows[number + 1].start
            rows = slice(2 * self._rows[number].start - first, 2 * self._rows[number].stop - first)
            height, width = reduced.shape[:2]
            cv2.resize(source[rows, : 2 * width], (width, height), dst=reduced, interpolation=cv2.INTER_AREA)
            source = reduced

    def rows(self, image: NDArray[np.uint8], number: int, rows: slice) -> NDArray[np.uint8]:
        """Rows of the picture at an octave; above the picture's own scale, of the picture itself."""
        if number >= 0:
            return image[rows]
        first = self._rows[number].start
        return self._reduced[number][rows.start - first : rows.stop - first]


class _LevelGrid:
    """A level's channels: its octave's own, or those resized into memory that the levels share.

    Attributes:
        level: the level.
        channels: (10, rows, columns).
        rows: their rows.
        row_pitch: their columns.
        first_row: row of `channels` that is the level's first.
        window_rows: rows of `channels` where windows have their top.
        offsets: (T, 3) places of the trees' features.
        flat: `channels`, flat, and `SLACK` elements more.
    """

    def __init__(
        self,
        octave: _Octave,
        level: Level,
        model: Model,
        cut_memory: NDArray[np.uint8],
        level_memory: NDArray[np.uint8],
    ) -> None:
        self.level = level
        first = level.first_cut - octave.first_row
        if level.resized:
            self.channels = _shaped(level_memory, level.rows, level.columns)
            self.first_row = 0
            self._source = octave.grid[:, first : first + level.cut_rows]
            self._cut = _shaped(cut_memory, level.cut_rows, level.cut_columns)
        else:
            self.channels = octave.grid
            self.first_row = first
        _, self.rows, self.row_pitch = self.channels.shape
        self.flat = (level_memory if level.resized else octave.memory)[: self.channels.size + SLACK]
        self.offsets = feature_offsets(model.trees, model.window, self.rows * self.row_pitch, self.row_pitch)
        self.window_rows = range(self.first_row + level.first_window, self.first_row + level.end_window)

    def fill(self) -> None:
        """Resize the octave's channels, as they are now."""
        if not self.level.resized:
            return
        np.copyto(self._cut, self._source)
        # All channels in one call, one above the other; windows keep clear of rows where two of them mix.
        stacked = self.channels.reshape(-1, self.level.columns)
        cv2.resize(
            self._cut.reshape(-1, self.level.cut_columns),
            (stacked.shape[1], stacked.shape[0]),
            dst=stacked,
            interpolation=cv2.INTER_LINEAR,
        )

    def features(self, window: Window, places: NDArray[np.int64]) -> NDArray[np.uint8]:
        """(N, 2560) features of windows in these places."""
        out = np.empty((len(places), CHANNEL_COUNT, window.cells, window.cells), np.uint8)
        _gather(self.flat, self.rows, self.row_pitch, places, out)
        return out.reshape(len(places), window.feature_count)

    def vehicles(self, window: Window, places: NDArray[np.int64]) -> NDArray[np.float64]:
        """(N, 3) where vehicles in windows in these places stand: middle, bottom, sqrt(w h)."""
        rows, columns = np.divmod(places, self.row_pitch)
        return np.column_stack(self.level.vehicles(window, rows - self.first_row, columns))


class Scanner:
    """Scores the windows of given levels in pictures of one size, in memory it keeps."""

    def __init__(self, model: Model, size: ImageSize, levels: tuple[Level, ...]) -> None:
        self.size = size
        self.windows_per_frame = sum(level.window_count for level in levels)
        self._model = model
        self._octaves: dict[int, _Octave] = {}
        for number in sorted({level.octave for level in levels}, reverse=True):
            halved = ImageSize(size.width >> max(-number, 0), size.height >> max(-number, 0))
            members = [level for level in levels if level.octave == number]
            self._octaves[number] = _Octave(halved, number, members)
        self._halves = _Halves(size, self._octaves)
        cut_cells = max((level.cut_rows * level.cut_columns for level in levels), default=0)
        level_cells = max((level.rows * level.columns for level in levels), default=0)
        memory = _memory(cut_cells), _memory(level_cells)
        self._grids = [_LevelGrid(self._octaves[level.octave], level, model, *memory) for level in levels]
        self._cascade = Cascade(model.trees, model.rejection_threshold)
        self._second = SecondStageScorer(model.second, model.window) if model.second else None
        self._places = np.empty(FIRST_CAPACITY, np.int64)
        self._scores = np.empty(FIRST_CAPACITY, np.float32)

    def scan(
        self,
        image: NDArray[np.uint8],
        threshold: float,
        aspect_ratios: Callable[[NDArray[np.float64]], NDArray[np.float64]],
        with_features: bool,
    ) -> Proposals:
        """All windows that both scoring stages together give at least `threshold`.

        Aspect ratios are asked for by the bottom rows.
        """
        window = self._model.window
        self._compute_channels(image)
        placements, scores, second_scores = (
            [np.empty((0, 3))],
            [np.empty(0, np.float32)],
            [np.empty(0, np.float32)],
        )
        features = [np.empty((0, window.feature_count), np.uint8)]
        for grid in self._grids:
            grid.fill()
            count = self._run(grid, threshold if self._second is None else -np.inf)
            if not count:
                continue
            places, score = self._places[:count], self._scores[:count]
            if self._second:
                second = self._second.scores(grid.flat, grid.rows, grid.row_pitch, places)
                passed = np.flatnonzero(score.astype(np.float64) + second >= threshold)
                places, score = places[passed], score[passed]
                second_scores.append(second[passed])
            placements.append(grid.vehicles(window, places))
            scores.append(score.copy())
            if with_features:
                features.append(grid.features(window, places))
        score = np.concatenate(scores)
        order = np.argsort(-score, kind="stable")
        placement = np.concatenate(placements)[order]
        middle, bottom, size_px = placement.T
        root = np.sqrt(aspect_ratios(bottom))
        w, h = size_px * root, size_px / root
        return Proposals(
            cut_to_picture(np.column_stack([middle - w / 2, bottom - h, w, h]), self.size),
            placement,
            score[order],
            np.concatenate(second_scores)[order] if self._second else None,
            np.concatenate(features)[order] if with_features else None,
        )

    def _compute_channels(self, image: NDArray[np.uint8]) -> None:
        self._halves.compute(image)
        for number, octave in self._octaves.items():
            octave.compute(self._halves.rows(image, number, octave.picture_rows))

    def _run(self, grid: _LevelGrid, threshold: float) -> int:
        """Run the cascade; the windows' places in the grid and their scores are left in the buffers."""
        while True:
            count = self._cascade.run(
                grid.flat,
                grid.row_pitch,
                grid.window_rows,
                grid.level.window_columns,
                grid.offsets,
                threshold,
                self._places,
                self._scores,
            )
            if count <= len(self._scores):
                return count
            self._places = np.empty(2 * count, np.int64)
            self._scores = np.empty(2 * count, np.float32)


@kernel()
def _gather(
    grids: NDArray[np.uint8], rows: int, row_pitch: int, places: NDArray[np.int64], out: NDArray[np.uint8]
) -> None:
    cells = out.shape[3]
    for index in range(len(out)):
        for channel in range(out.shape[1]):
            for row in range(out.shape[2]):
                first = places[index] + (channel * rows + row) * row_pitch
                out[index, channel, row] = grids[first : first + cells]


def _memory(cells: int) -> NDArray[np.uint8]:
    """Room for ten channels of so many cells, and for what segments at their end may read."""
    return np.zeros(CHANNEL_COUNT * cells + SLACK, np.uint8)


def _shaped(memory: NDArray[np.uint8], rows: int, columns: int) -> NDArray[np.uint8]:
    """The first bytes of a buffer as channels (10, rows, columns)."""
    return memory[: CHANNEL_COUNT * rows * columns].reshape(CHANNEL_COUNT, rows, columns)


def cut_to_picture(boxes: NDArray[np.float64], size: ImageSize) -> NDArray[np.float64]:
    """The parts of boxes that lie in the picture, whose edges are half a pixel outside its outer pixels."""
    limit = np.array([size.width, size.height]) - 0.5
    near = np.maximum(boxes[:, :2], -0.5)
    far = np.minimum(boxes[:, :2] + boxes[:, 2:], limit)
    return np.column_stack([near, far - near])
