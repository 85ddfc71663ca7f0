"""Resizing the channels of an octave into those of its levels, bilinearly, in the rows that windows look at.

The arithmetic is that of OpenCV's `resize` of 8 bit pictures (INTER_LINEAR), to the bit: along a row in
1/2048 parts, of which 4 bits are dropped; then down the columns in such parts, of which 18 bits are dropped.
All ten channels are resized as if they stood one above the other; windows keep clear of rows in which two of
them mix. Four rows are packed into 32 bit words, of which each column then needs two: what takes time is to
fetch from places that are not side by side.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.detection.model import CHANNEL_COUNT
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel

_PARTS = 2048
_ROWS_AT_ONCE = 4
_byte, _word, _part = np.uint32(255), np.uint32, np.int32


@dataclass(frozen=True, slots=True)
class Resizing:
    """One level's: from the rows of an octave's grid that it is made of, to the rows that are wanted.

    Attributes:
        source: element of the memory that is the first cell it is made of.
        source_channel_pitch: elements from a channel of the octave to the next.
        source_rows: rows it is made of.
        source_columns: the octave's columns.
        target: element that is the level's first cell.
        rows: the level's rows.
        columns: the level's columns.
        wanted: rows that are filled.
    """

    source: int
    source_channel_pitch: int
    source_rows: int
    source_columns: int
    target: int
    rows: int
    columns: int
    wanted: range


class Resizings(NamedTuple):
    """All levels', as the kernel reads them, and memory for its work.

    Attributes:
        levels: (L, 12) int64: source, its channel pitch, columns, first row and number of rows looked at;
            target, its channel pitch, columns, first row; number of rows wanted in all channels;
            first index into the columns' arrays, and into the rows'.
        lefts: (C,) int32, left one of the two columns that a column is made of.
        column_parts: (2, C) int32, how much of either, in 1/2048.
        aboves: (R,) int32, upper one of the two rows that a row is made of, from the first looked at.
        row_parts: (2, R) int32, how much of either.
        words: memory for four rows packed.
        sums: memory for rows of the right width.
    """

    levels: NDArray[np.int64]
    lefts: NDArray[np.int32]
    column_parts: NDArray[np.int32]
    aboves: NDArray[np.int32]
    row_parts: NDArray[np.int32]
    words: NDArray[np.uint32]
    sums: NDArray[np.int16]


def plan_resizings(resizings: Sequence[Resizing]) -> Resizings:
    """What the kernel needs to know of them."""
    levels, columns, rows = [], [np.empty((3, 0))], [np.empty((3, 0))]
    column_count = row_count = 0
    for each in resizings:
        columns.append(_linear(each.source_columns, each.columns))
        stacked = _linear(each.source_rows * CHANNEL_COUNT, each.rows * CHANNEL_COUNT)
        wanted = stacked.reshape(3, CHANNEL_COUNT, each.rows)[:, :, each.wanted.start : each.wanted.stop]
        above = wanted[0] - np.arange(CHANNEL_COUNT)[:, None] * each.source_rows
        above = np.clip(above, 0, max(each.source_rows - 2, 0))
        first, end = int(above.min()), int(above.max()) + 2
        rows.append(np.stack([above - first, wanted[1], wanted[2]]).reshape(3, -1))
        source = each.source, each.source_channel_pitch, each.source_columns, first, end - first
        target = each.target, each.rows * each.columns, each.columns, each.wanted.start, len(each.wanted)
        levels.append((*source, *target, column_count, row_count))
        column_count, row_count = column_count + each.columns, row_count + above.size
    by_column, by_row = (np.concatenate(values, axis=1).astype(np.int32) for values in (columns, rows))
    most_rows = max((each.source_rows for each in resizings), default=0) + _ROWS_AT_ONCE
    return Resizings(
        np.array(levels, np.int64).reshape(-1, 12),
        by_column[0],
        by_column[1:],
        by_row[0],
        by_row[1:],
        np.zeros(max((each.source_columns for each in resizings), default=0) + 1, np.uint32),
        np.zeros((most_rows, max((each.columns for each in resizings), default=0)), np.int16),
    )


def _linear(source: int, target: int) -> NDArray[np.float64]:
    """(3, target): the first of the two elements that each is made of, and how much of either in 1/2048."""
    # In single precision, as OpenCV has it.
    at = ((np.arange(target) + 0.5) * (source / target) - 0.5).astype(np.float32)
    first = np.floor(at)
    part = np.where((first < 0) | (first >= source - 1), np.float32(0), at - first)
    parts = np.rint((np.float32(1) - part) * np.float32(_PARTS)), np.rint(part * np.float32(_PARTS))
    return np.stack([np.clip(first, 0, source - 1), *parts]).astype(np.float64)


@kernel()
def resize_all(cells: NDArray[np.uint8], resizings: Resizings) -> None:
    """Fill the levels' grids from those of their octaves.

    Args:
        cells: memory of all of them.
        resizings: from `plan_resizings`.
    """
    sums, words = resizings.sums, resizings.words
    for number in range(len(resizings.levels)):
        level = resizings.levels[number]
        source_columns, source_rows, columns, rows = level[2], level[4], level[7], level[9]
        in_columns = slice(level[10], level[10] + columns)
        lefts = resizings.lefts[in_columns]
        left_parts, right_parts = resizings.column_parts[0, in_columns], resizings.column_parts[1, in_columns]
        for channel in range(CHANNEL_COUNT):
            source = level[0] + channel * level[1] + level[3] * source_columns
            for row in range(0, source_rows, _ROWS_AT_ONCE):
                _pack(cells, source, source_columns, row, source_rows, words)
                _along_rows(
                    words,
                    lefts,
                    left_parts,
                    right_parts,
                    sums[row],
                    sums[row + 1],
                    sums[row + 2],
                    sums[row + 3],
                )
            target = level[5] + channel * level[6] + level[8] * columns
            for row in range(rows):
                i = level[11] + channel * rows + row
                above = resizings.aboves[i]
                to = target + row * columns
                _down_columns(
                    sums[above],
                    sums[above + 1],
                    resizings.row_parts[0, i],
                    resizings.row_parts[1, i],
                    cells[to : to + columns],
                )


@inner_kernel(no_alias=True)
def _pack(
    cells: NDArray[np.uint8], source: int, columns: int, row: int, rows: int, words: NDArray[np.uint32]
) -> None:
    """Four rows, one in each byte of the words; the last row in place of those beyond it."""
    at0, at1 = source + row * columns, source + min(row + 1, rows - 1) * columns
    at2, at3 = source + min(row + 2, rows - 1) * columns, source + min(row + 3, rows - 1) * columns
    a, b = cells[at0 : at0 + columns], cells[at1 : at1 + columns]
    c, d = cells[at2 : at2 + columns], cells[at3 : at3 + columns]
    for x in range(columns):
        low, high = _word(a[x]) | (_word(b[x]) << _word(8)), _word(c[x]) | (_word(d[x]) << _word(8))
        words[x] = low | (high << _word(16))


@inner_kernel(no_alias=True)
def _along_rows(
    words: NDArray[np.uint32],
    lefts: NDArray[np.int32],
    left_parts: NDArray[np.int32],
    right_parts: NDArray[np.int32],
    row0: NDArray[np.int16],
    row1: NDArray[np.int16],
    row2: NDArray[np.int16],
    row3: NDArray[np.int16],
) -> None:
    """Four rows of the right width, in 1/128 of a count."""
    for x in range(len(lefts)):
        i = np.uint64(lefts[x])
        left, right, p, q = words[i], words[i + np.uint64(1)], left_parts[x], right_parts[x]
        sum0 = _part(left & _byte) * p + _part(right & _byte) * q
        sum1 = _part((left >> _word(8)) & _byte) * p + _part((right >> _word(8)) & _byte) * q
        sum2 = _part((left >> _word(16)) & _byte) * p + _part((right >> _word(16)) & _byte) * q
        sum3 = _part(left >> _word(24)) * p + _part(right >> _word(24)) * q
        row0[x], row1[x] = np.int16(sum0 >> _part(4)), np.int16(sum1 >> _part(4))
        row2[x], row3[x] = np.int16(sum2 >> _part(4)), np.int16(sum3 >> _part(4))


@inner_kernel(no_alias=True)
def _down_columns(
    above: NDArray[np.int16],
    below: NDArray[np.int16],
    above_part: np.int32,
    below_part: np.int32,
    out: NDArray[np.uint8],
) -> None:
    """One row of two, rounded as OpenCV does."""
    for x in range(len(out)):
        upper, lower = (
            (_part(above[x]) * above_part) >> _part(16),
            (_part(below[x]) * below_part) >> _part(16),
        )
        out[x] = np.uint8((upper + lower + _part(2)) >> _part(2))
