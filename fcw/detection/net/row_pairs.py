"""Convolutions of two rows of outputs at once, with two thirds of the products.

Winograd's minimal filtering F(2, 3), as in Lavin & Gray, "Fast algorithms for convolutional neural networks"
(2016): of four rows d of inputs and a column g of three weights these are multiplied, one by one,

    d0 - d2, d1 + d2, d2 - d1, d1 - d3   and   2 g0, g0 + g1 + g2, g0 - g1 + g2, 2 g2

and of the products m0 + m1 + m2 is twice what the upper row gets, m1 - m2 - m3 twice what the lower one gets.
Of bytes all of these are whole numbers of 16 bits, and so nothing is rounded: sums are the same to the bit.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.inner import inner_kernel
from fcw.kernels.products import TILE_ROWS, WORD_BYTES, in_pairs

ROW_PAIRS_PAY = in_pairs()
"""Where bytes are multiplied as numbers of 16 bits anyway; elsewhere nothing was won."""

FILTERS = 4
"""Rows that are multiplied for two rows of outputs."""
FIRST_ROWS, SIGNS, SECOND_ROWS = (0, 1, 2, 1), (-1, 1, -1, -1), (2, 2, 1, 3)
"""Of each, the rows of inputs that it is the sum or the difference of."""
UPPER, LOWER = 0, 3
"""In place of which filter's sums `to_row_pairs` puts those of either row."""
PAIRS = WORD_BYTES // 2
"""Words of two numbers of 16 bits that a word of bytes becomes: of its bytes 0 and 2, and 1 and 3."""
LOW_BYTES, LOW_SIGN = np.int32(0x00FF00FF), np.int32(0x8000)

WordArray = NDArray[np.int32]


def row_weights(steps: NDArray[np.int8]) -> WordArray:
    """Weights in the order in which they are read: block of outputs, filter, word, pair, column, output.

    Args:
        steps: (outputs, inputs, 3, 3) of whole blocks of `TILE_ROWS` and whole words of `WORD_BYTES`.
    """
    outputs, inputs = steps.shape[:2]
    g = steps.astype(np.int16).transpose(2, 0, 1, 3)
    filtered = np.stack([2 * g[0], g[0] + g[1] + g[2], g[0] - g[1] + g[2], 2 * g[2]])
    parted = filtered.reshape(
        FILTERS, outputs // TILE_ROWS, TILE_ROWS, inputs // WORD_BYTES, WORD_BYTES // PAIRS, PAIRS, 3
    )
    return np.ascontiguousarray(parted.transpose(1, 0, 3, 5, 6, 2, 4)).reshape(-1).view(np.int32)


def row_offsets(words: int, pair_rows: int, pitch: int, step: int = 1) -> NDArray[np.int64]:
    """Where a filter's products find their words, from the first one's, in the order of `row_weights`.

    Args:
        words: of bytes that there were at each place.
        pair_rows: pairs of rows of outputs; an odd last row makes one, too.
        pitch: words from a row to the next.
        step: words from a column to the next.
    """
    return (np.arange(words * PAIRS)[:, None] * pair_rows * pitch + np.arange(3) * step).reshape(-1)


@inner_kernel()
def filter_rows(words: WordArray, count: int, rows: int, pitch: int, to: int) -> None:
    """What is multiplied of words of bytes, for kernels to call.

    Args:
        words: flat; the bytes begin it, word by word and row by row.
        count: words of bytes at each place.
        rows: of each, with the ring around the inputs.
        pitch: words from a row to the next.
        to: place in them where the result begins, in the order filter, word, pair, two rows, column.
    """
    pair_rows = (rows - 1) // 2
    for word in range(count):
        for pair in range(PAIRS):
            for i in range(pair_rows):
                place = ((word * PAIRS + pair) * pair_rows + i) * pitch
                for each in range(FILTERS):
                    # Of an odd number of rows the last one has no fellow: what it would get is of no use.
                    other = min(2 * i + SECOND_ROWS[each], rows - 1)
                    _filter_row(
                        words,
                        (word * rows + 2 * i + FIRST_ROWS[each]) * pitch,
                        (word * rows + other) * pitch,
                        np.int32(SIGNS[each]),
                        np.int32(8 * pair),
                        pitch,
                        words,
                        to + each * count * PAIRS * pair_rows * pitch + place,
                    )


@inner_kernel(no_alias=True)
def _filter_row(
    words: WordArray,
    first: int,
    second: int,
    sign: np.int32,
    bits: np.int32,
    count: int,
    out: WordArray,
    to: int,
) -> None:
    for i in range(count):
        one, other = words[np.uint64(first + i)], words[np.uint64(second + i)]
        both = (one >> bits & LOW_BYTES) + sign * (other >> bits & LOW_BYTES)
        # A lower number below zero has borrowed from the upper one.
        out[np.uint64(to + i)] = both + ((both & LOW_SIGN) << np.int32(1))


@inner_kernel()
def to_row_pairs(sums: WordArray, first: int, filter_pitch: int, count: int) -> None:
    """Sums of two rows of outputs in place of the first and the last filter's, for kernels to call.

    Args:
        sums: flat.
        first: place of the first filter's first sum.
        filter_pitch: from there to the next filter's.
        count: sums of each filter.
    """
    for each in (LOWER, UPPER):
        sign = np.int32(1 if each == UPPER else -1)
        to, second = first + each * filter_pitch, first + filter_pitch
        for i in range(count):
            place = second + i
            outer = sums[np.uint64(place + filter_pitch)] + sums[np.uint64(to + i)]
            twice = np.int32(sums[np.uint64(place)] + sign * outer)  # numba's sums of 32 bits have 64
            sums[np.uint64(to + i)] = twice >> np.int32(1)
