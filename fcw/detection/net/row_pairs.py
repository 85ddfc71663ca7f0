"""Convolutions of two rows of outputs at once, with two thirds of the products.

Winograd's minimal filtering F(2, 3), as in Lavin & Gray, "Fast algorithms for convolutional neural networks"
(2016): of four rows d of inputs and a column g of three weights these are multiplied, one by one,

    d0 - d2, d1 + d2, d2 - d1, d1 - d3   and   2 g0, g0 + g1 + g2, g0 - g1 + g2, 2 g2

Of these products, m0 + m1 + m2 is twice the upper row's output, and m1 - m2 - m3 twice the lower row's. For
bytes, all factors are 16-bit integers, so nothing is rounded, and the sums are the same to the bit.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.inner import inner_kernel
from fcw.kernels.products import TILE_ROWS, WORD_BYTES, in_pairs

ROW_PAIRS_PAY = in_pairs()
"""True if the processor multiplies bytes as 16-bit numbers anyway; otherwise nothing is gained."""

FILTERS = 4
"""Number of filtered rows that are multiplied for two rows of outputs."""
FIRST_ROWS, SIGNS, SECOND_ROWS = (0, 1, 2, 1), (-1, 1, -1, -1), (2, 2, 1, 3)
"""For each filter, the two rows of inputs, and the sign, of its sum or difference."""
UPPER, LOWER = 0, 3
"""The filters whose sums `to_row_pairs` replaces by those of the upper and the lower row."""
PAIRS = WORD_BYTES // 2
"""Number of words of two 16-bit numbers for one word of bytes: of its bytes 0 and 2, and of 1 and 3."""
LOW_BYTES, LOW_SIGN = np.int32(0x00FF00FF), np.int32(0x8000)

WordArray = NDArray[np.int32]


def row_weights(steps: NDArray[np.int8]) -> WordArray:
    """Filtered weights as they are read: block of outputs, filter, word, pair, column, output.

    Args:
        steps: (outputs, inputs, 3, 3), padded to whole blocks of `TILE_ROWS` and whole words of `WORD_BYTES`.
    """
    outputs, inputs = steps.shape[:2]
    g = steps.astype(np.int16).transpose(2, 0, 1, 3)
    filtered = np.stack([2 * g[0], g[0] + g[1] + g[2], g[0] - g[1] + g[2], 2 * g[2]])
    parted = filtered.reshape(
        FILTERS, outputs // TILE_ROWS, TILE_ROWS, inputs // WORD_BYTES, WORD_BYTES // PAIRS, PAIRS, 3
    )
    return np.ascontiguousarray(parted.transpose(1, 0, 3, 5, 6, 2, 4)).reshape(-1).view(np.int32)


def row_offsets(words: int, pair_rows: int, pitch: int, step: int = 1) -> NDArray[np.int64]:
    """Offsets of the words of a filter's products from the first one's, in the order of `row_weights`.

    Args:
        words: number of words of bytes at each pixel.
        pair_rows: number of pairs of rows of outputs; an odd last row counts as a pair.
        pitch: words from one row to the next.
        step: words from one column to the next.
    """
    return (np.arange(words * PAIRS)[:, None] * pair_rows * pitch + np.arange(3) * step).reshape(-1)


@inner_kernel()
def filter_rows(words: WordArray, count: int, rows: int, pitch: int, to: int) -> None:
    """Compute the filtered rows of words of bytes, for kernels to call.

    Args:
        words: flat; begins with the bytes, word by word and row by row.
        count: number of words of bytes at each pixel.
        rows: number of rows, including padding.
        pitch: words from one row to the next.
        to: index in `words` where the result begins, in the order filter, word, pair, two rows, column.
    """
    pair_rows = (rows - 1) // 2
    for word in range(count):
        for pair in range(PAIRS):
            for i in range(pair_rows):
                place = ((word * PAIRS + pair) * pair_rows + i) * pitch
                for each in range(FILTERS):
                    # The last of an odd number of rows has no second row; the result of that row is not used.
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
        # If the lower number is negative, it has borrowed from the upper one.
        out[np.uint64(to + i)] = both + ((both & LOW_SIGN) << np.int32(1))


@inner_kernel()
def to_row_pairs(sums: WordArray, first: int, filter_pitch: int, count: int) -> None:
    """Replace the sums of the first and the last filter by those of two rows of outputs, for kernels to call.

    Args:
        sums: flat.
        first: index of the first filter's first sum.
        filter_pitch: number of sums from one filter's first to the next one's.
        count: number of sums of each filter.
    """
    for each in (LOWER, UPPER):
        sign = np.int32(1 if each == UPPER else -1)
        to, second = first + each * filter_pitch, first + filter_pitch
        for i in range(count):
            place = second + i
            outer = sums[np.uint64(place + filter_pitch)] + sums[np.uint64(to + i)]
            twice = np.int32(sums[np.uint64(place)] + sign * outer)  # numba adds 32-bit integers in 64 bits
            sums[np.uint64(to + i)] = twice >> np.int32(1)
