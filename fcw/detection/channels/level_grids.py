"""The channels of all levels in one piece of memory, and tables that say where everything lies in it.

Planned once for a picture size. A place is the index of a cell of channel 0, counted from its grid's first
cell; the other channels follow, each `rows * row_pitch` elements on.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.channels.octaves import Octave, repeat_edges
from fcw.detection.channels.resizing import Resizing, plan_resizings, resize_all
from fcw.detection.model import CHANNEL_COUNT, Window
from fcw.detection.trees.loops import SLACK
from fcw.detection.windows.plan import PAD_CELLS, Level
from fcw.kernels.inner import inner_kernel

AspectRatios = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Width over height of vehicles by their bottom rows, px."""


_1, _2, _3, _4, _5, _6, _7, _8 = (np.uint64(i) for i in range(1, 9))
"""Indices in inner loops are unsigned: signed ones are checked for being negative."""


class LevelTable(NamedTuple):
    """Where each level's cells and windows are, as the kernels read it.

    All windows in a row have their vehicle's bottom, size and shape in common, all in a column its middle:
    these are looked up.

    Attributes:
        first_cell: (L,) element of the memory that is the grid's first.
        rows: (L,) rows of the grid.
        row_pitch: (L,) its columns.
        first_row: (L,) row of the grid where the first windows have their top.
        end_row: (L,) one past the last such row.
        columns: (L,) windows in a row.
        first_in_rows: (L,) index into `by_row` of the level's first row of windows.
        first_in_columns: (L,) index into `middles` of its first column.
        by_row: (R, 4) bottom, sqrt(w h), w and h of vehicles, px.
        middles: (C,) column of vehicles' middles, px.
    """

    first_cell: NDArray[np.int64]
    rows: NDArray[np.int64]
    row_pitch: NDArray[np.int64]
    first_row: NDArray[np.int64]
    end_row: NDArray[np.int64]
    columns: NDArray[np.int64]
    first_in_rows: NDArray[np.int64]
    first_in_columns: NDArray[np.int64]
    by_row: NDArray[np.float64]
    middles: NDArray[np.float64]


class LevelGrids:
    """Channels of octaves and levels.

    Attributes:
        cells: the memory: grids (10, rows, columns) of the octaves, then of the levels that are resized, and
            `SLACK` elements more.
        table: where the levels are in it.
    """

    def __init__(
        self,
        octaves: dict[int, Octave],
        levels: Sequence[Level],
        window: Window,
        aspect_ratios: AspectRatios,
    ) -> None:
        resized = [level for level in levels if level.resized]
        counts = [each.rows * each.columns for each in (*octaves.values(), *resized)]
        starts = CHANNEL_COUNT * np.cumsum([0, *counts])
        self.cells = np.zeros(int(starts[-1]) + SLACK, np.uint8)
        owned = [
            self.cells[start : start + CHANNEL_COUNT * count]
            for start, count in zip(starts, counts, strict=False)
        ]
        for octave, memory in zip(octaves.values(), owned, strict=False):
            octave.use(memory)
        first_cells: dict[int | Level, int] = dict(zip((*octaves, *resized), map(int, starts), strict=False))
        self._edges = np.array(
            [
                (first_cells[number], each.rows, each.columns, each.first_inside, each.end_inside)
                for number, each in octaves.items()
            ],
            np.int64,
        ).reshape(-1, 5)
        self._resizings = plan_resizings(
            [_resizing(octaves[level.octave], level, first_cells, window) for level in resized]
        )
        self.table = _table(octaves, levels, first_cells, window, aspect_ratios)

    def fill(self) -> None:
        """Fill the octaves' edges and the levels, once the octaves' channels are computed."""
        repeat_edges(self.cells, self._edges, PAD_CELLS)
        resize_all(self.cells, self._resizings)


def _resizing(octave: Octave, level: Level, first_cells: dict[int | Level, int], window: Window) -> Resizing:
    return Resizing(
        source=first_cells[level.octave] + (level.first_cut - octave.first_row) * octave.columns,
        source_channel_pitch=octave.rows * octave.columns,
        source_rows=level.cut_rows,
        source_columns=level.cut_columns,
        target=first_cells[level],
        rows=level.rows,
        columns=level.columns,
        wanted=range(level.first_window, level.end_window + window.cells - 1),
    )


def _table(
    octaves: dict[int, Octave],
    levels: Sequence[Level],
    first_cells: dict[int | Level, int],
    window: Window,
    aspect_ratios: AspectRatios,
) -> LevelTable:
    integers, by_row, all_middles = [], [np.empty((0, 4))], [np.empty(0)]
    row_count = column_count = 0
    for level in levels:
        octave = octaves[level.octave]
        if level.resized:
            grid = first_cells[level], level.rows, level.columns
            first_row = 0
        else:
            grid = first_cells[level.octave], octave.rows, octave.columns
            first_row = level.first_cut - octave.first_row
        rows = first_row + level.first_window, first_row + level.end_window
        integers.append((*grid, *rows, level.window_columns, row_count, column_count))
        middles, bottoms, size_px = level.vehicles(
            window, np.arange(level.first_window, level.end_window), np.arange(level.window_columns)
        )
        root = np.sqrt(aspect_ratios(bottoms))
        by_row.append(
            np.column_stack([bottoms, np.full(len(bottoms), size_px), size_px * root, size_px / root])
        )
        all_middles.append(middles)
        row_count += len(bottoms)
        column_count += len(middles)
    columns = np.ascontiguousarray(np.array(integers, np.int64).reshape(-1, 8).T)
    return LevelTable(
        first_cell=columns[0],
        rows=columns[1],
        row_pitch=columns[2],
        first_row=columns[3],
        end_row=columns[4],
        columns=columns[5],
        first_in_rows=columns[6],
        first_in_columns=columns[7],
        by_row=np.concatenate(by_row),
        middles=np.concatenate(all_middles),
    )


@inner_kernel()
def gather_features(
    grids: NDArray[np.uint8],
    first: int,
    channel_pitch: int,
    row_pitch: int,
    window_cells: int,
    features: NDArray[np.uint8],
) -> None:
    """A window's features in the order channel, row, column.

    Args:
        grids: the levels' memory.
        first: element that is the window's first cell.
        channel_pitch: elements from a channel to the next.
        row_pitch: elements from a row to the next.
        window_cells: cells along one side.
        features: (10 * cells * cells,) receives them.
    """
    to = np.uint64(0)
    for channel in range(CHANNEL_COUNT):
        for row in range(window_cells):
            start = np.uint64(first + channel * channel_pitch + row * row_pitch)
            done = 0
            while done + 8 <= window_cells:
                # All read before any is written: the compiler makes one load and one store of them.
                a, b, c, d = grids[start], grids[start + _1], grids[start + _2], grids[start + _3]
                e, f, g, h = grids[start + _4], grids[start + _5], grids[start + _6], grids[start + _7]
                features[to], features[to + _1], features[to + _2], features[to + _3] = a, b, c, d
                features[to + _4], features[to + _5], features[to + _6], features[to + _7] = e, f, g, h
                start, to, done = start + _8, to + _8, done + 8
            while done < window_cells:
                features[to] = grids[start]
                start, to, done = start + _1, to + _1, done + 1
