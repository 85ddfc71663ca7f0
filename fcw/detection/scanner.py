"""Scoring the windows of planned levels in a picture: what both ACF detectors do."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.detection.cascade import SLACK, Cascade, feature_offsets
from fcw.detection.channels import COARSE, CONTEXT_PX, FINE, ChannelComputer
from fcw.detection.jit import kernel
from fcw.detection.model import CELL_PX, CHANNEL_COUNT, Model
from fcw.detection.second_stage import SecondStageScorer
from fcw.detection.windows import PAD_CELLS, Level, vehicles_in_levels
from fcw.sources.frame import ImageSize

FIRST_CAPACITY = 1024
"""Windows that there is room for at first: more than pass in any usual picture."""


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
            # All channels one above the other; windows keep clear of rows where two of them mix.
            self._stacked_cut = self._cut.reshape(-1, level.cut_columns)
            self._stacked = self.channels.reshape(-1, level.columns)
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
        height, width = self._stacked.shape
        cv2.resize(self._stacked_cut, (width, height), dst=self._stacked, interpolation=cv2.INTER_LINEAR)


class _Found:
    """Windows that passed in the levels so far, in memory that grows when more pass than ever before.

    Attributes:
        count: how many there are.
        places: (N,) int64, of which the first `count` are filled, as of the others.
        scores: (N,) float32, of the cascade.
        second_scores: (N,) float32.
        features: (N, 2560) uint8.
    """

    def __init__(self, feature_count: int) -> None:
        self.count = 0
        self.places = np.empty(FIRST_CAPACITY, np.int64)
        self.scores = np.empty(FIRST_CAPACITY, np.float32)
        self.second_scores = np.zeros(FIRST_CAPACITY, np.float32)
        self.features = np.empty((FIRST_CAPACITY, feature_count), np.uint8)

    def make_room(self, count: int) -> None:
        """Room for so many, twice over."""
        for name in ("places", "scores", "second_scores", "features"):
            before = getattr(self, name)
            after = np.zeros((2 * count, *before.shape[1:]), before.dtype)
            after[: self.count] = before[: self.count]
            setattr(self, name, after)


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
        self._row_pitches = np.array([grid.row_pitch for grid in self._grids], np.int64)
        self._first_rows = np.array([grid.first_row for grid in self._grids], np.int64)
        self._cascade = Cascade(model.trees, model.rejection_threshold)
        self._second = SecondStageScorer(model.second, model.window) if model.second else None
        self._levels = levels
        self._found = _Found(model.window.feature_count)

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
        self._compute_channels(image)
        found, counts = self._found, np.zeros(len(self._grids), np.int64)
        found.count = 0
        for number, grid in enumerate(self._grids):
            grid.fill()
            counts[number] = self._run(grid, threshold, with_features)
        order = np.argsort(-found.scores[: found.count], kind="stable")
        level = np.repeat(np.arange(len(counts)), counts)[order]
        rows, columns = np.divmod(found.places[order], self._row_pitches[level])
        middle, bottom, size_px = vehicles_in_levels(
            self._levels, level, self._model.window, rows - self._first_rows[level], columns
        )
        root = np.sqrt(aspect_ratios(bottom))
        w, h = size_px * root, size_px / root
        return Proposals(
            cut_to_picture(np.column_stack([middle - w / 2, bottom - h, w, h]), self.size),
            np.column_stack([middle, bottom, size_px]),
            found.scores[order],
            found.second_scores[order] if self._second else None,
            found.features[order] if with_features else None,
        )

    def _compute_channels(self, image: NDArray[np.uint8]) -> None:
        self._halves.compute(image)
        for number, octave in self._octaves.items():
            octave.compute(self._halves.rows(image, number, octave.picture_rows))

    def _run(self, grid: _LevelGrid, threshold: float, with_features: bool) -> int:
        """Run the scoring stages over a level, and add the windows that pass to those found; how many."""
        found = self._found
        while True:
            count = self._cascade.run(
                grid.flat,
                grid.row_pitch,
                grid.window_rows,
                grid.level.window_columns,
                grid.offsets,
                -np.inf if self._second else threshold,
                found.places[found.count :],
                found.scores[found.count :],
            )
            if found.count + count <= len(found.places):
                break
            found.make_room(found.count + count)
        if not count:
            return 0
        new = slice(found.count, found.count + count)
        if self._second:
            self._second.score(
                grid.flat, grid.rows, grid.row_pitch, found.places[new], found.second_scores[new]
            )
        kept = _keep(
            found.places[new],
            found.scores[new],
            found.second_scores[new],
            threshold,
            grid.flat,
            grid.rows * grid.row_pitch,
            grid.row_pitch,
            self._model.window.cells,
            found.features[new],
            with_features,
        )
        found.count += kept
        return kept


@kernel()
def _keep(
    places: NDArray[np.int64],
    scores: NDArray[np.float32],
    second_scores: NDArray[np.float32],
    threshold: float,
    grids: NDArray[np.uint8],
    channel_pitch: int,
    row_pitch: int,
    window_cells: int,
    features: NDArray[np.uint8],
    with_features: bool,
) -> int:
    """Close the ranks over windows below the threshold, and take the features of the others; how many."""
    kept = 0
    for i in range(len(places)):
        if np.float64(scores[i]) + np.float64(second_scores[i]) < threshold:
            continue
        places[kept], scores[kept], second_scores[kept] = places[i], scores[i], second_scores[i]
        if with_features:
            to = np.uint64(0)
            for channel in range(CHANNEL_COUNT):
                for row in range(window_cells):
                    first = np.uint64(places[kept] + channel * channel_pitch + row * row_pitch)
                    for column in range(window_cells):
                        features[kept, to] = grids[first + np.uint64(column)]
                        to += np.uint64(1)
        kept += 1
    return kept


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
