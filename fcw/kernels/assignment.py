"""The cheapest way to give rows their columns.

As `scipy.optimize.linear_sum_assignment`, whose package would take 26 MB of a run.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.kernels.jit import kernel

UNSEEN = 1e300
"""More than any sum of costs, and finite, as the kernels' arithmetic wants it."""


def assign(cost: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Pairs of a row and a column whose costs have the least sum, as many as there can be, by row.

    Args:
        cost: (rows, columns), finite.
    """
    if cost.shape[0] > cost.shape[1]:
        return sorted((row, column) for column, row in assign(cost.T))
    columns = np.empty(len(cost), np.int64)
    _assign(np.ascontiguousarray(cost, np.float64), columns)
    return list(enumerate(columns.tolist()))


@kernel()
def _assign(cost: NDArray[np.float64], column_of: NDArray[np.int64]) -> None:  # pragma: no cover - compiled
    """Take in row by row, each along the shortest augmenting path (Jonker & Volgenant 1987).

    Prices of rows and columns keep all reduced costs at 0 or more, so that Dijkstra's algorithm finds it. A
    column beyond the last stands for the row that comes in.
    """
    rows, columns = cost.shape
    row_prices, column_prices = np.zeros(rows), np.zeros(columns + 1)
    row_of, before = np.full(columns + 1, -1), np.zeros(columns + 1, np.int64)
    for row in range(rows):
        column = columns
        row_of[column] = row
        lengths, reached = np.full(columns, UNSEEN), np.zeros(columns + 1, np.bool_)
        while row_of[column] >= 0:
            reached[column] = True
            here, step, nearest = row_of[column], UNSEEN, -1
            for other in range(columns):
                if reached[other]:
                    continue
                length = cost[here, other] - row_prices[here] - column_prices[other]
                if length < lengths[other]:
                    lengths[other], before[other] = length, column
                if lengths[other] < step:
                    step, nearest = lengths[other], other
            for other in range(columns + 1):
                if reached[other]:
                    row_prices[row_of[other]] += step
                    column_prices[other] -= step
                elif other < columns:
                    lengths[other] -= step
            column = nearest
        while column != columns:
            row_of[column] = row_of[before[column]]
            column = before[column]
        row_of[columns] = -1
    for column in range(columns):
        if row_of[column] >= 0:
            column_of[row_of[column]] = column
