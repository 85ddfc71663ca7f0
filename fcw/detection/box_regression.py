"""The last stage: how wide and high the vehicle in a window is, and where its middle.

Windows stand on a grid of cells and scales, and all in one row have one shape; a linear map from a window's
channels finds the vehicle's own (box regression, Felzenszwalb et al., "Object detection with discriminatively
trained part-based models", PAMI 2010, section 7.3). It is learnt from windows displaced farther than those
the trees learn from; ridge regression keeps 2,560 correlated inputs in check.

The bottom edge, on which the distance hangs, is not regressed: the mean of several windows finds it as well
in real pictures, while in rendered ones, which are like nothing learnt from, a regressed one lay 3 to 6 % of
the height too high. It gets one constant, which held-out pictures tell.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.jit import kernel
from fcw.detection.model import BoxRegressor

LARGEST_ENLARGEMENT = 0.5
"""No box is put out larger or smaller than its window by more than this logarithm."""


def fit_regressor(features: NDArray[np.uint8], offsets: NDArray[np.float64], ridge: float) -> BoxRegressor:
    """Least squares from channels to offsets, with a penalty.

    Args:
        features: (N, F) uint8.
        offsets: (N, 3) as `box_offsets` gives them.
        ridge: weight of the squared coefficients, as a part of the windows' number and of the mean variance
            of a feature.

    Returns:
        The regressor.
    """
    values = features.astype(np.float32)
    mean = values.mean(axis=0)
    values -= mean
    target_mean = offsets.mean(axis=0)
    gram = (values.T @ values).astype(np.float64)
    penalty = ridge * np.trace(gram) / len(gram)
    gram[np.diag_indices_from(gram)] += penalty
    weights = np.linalg.solve(gram, values.T.astype(np.float64) @ (offsets - target_mean))
    return BoxRegressor(
        weights.astype(np.float32),
        (target_mean - mean.astype(np.float64) @ weights).astype(np.float32),
        bottom=0.0,
    )


def box_offsets(
    boxes: NDArray[np.float64], middle: NDArray[np.float64], size: NDArray[np.float64]
) -> NDArray[np.float64]:
    """How vehicles stand relative to their windows.

    Args:
        boxes: (N, 4) x, y, w, h of the vehicles.
        middle: (N,) column where the window expects the vehicle's middle.
        size: (N,) the sqrt(w h) that it expects.

    Returns:
        (N, 3): of the middle, in sizes; of width and height, the logarithm to the size.
    """
    x, _, w, h = boxes.T
    return np.column_stack([(x + w / 2 - middle) / size, np.log(w / size), np.log(h / size)])


def regressed_boxes(
    regressor: BoxRegressor, features: NDArray[np.uint8], placements: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 4) boxes of the vehicles in windows.

    Args:
        regressor: as learnt.
        features: (N, F) uint8 of the windows.
        placements: (N, 3) middle, bottom and size that the windows expect.
    """
    offsets = np.empty((len(features), 3), np.float32)
    _offsets(np.ascontiguousarray(features), np.ascontiguousarray(regressor.weights.T), offsets)
    offsets += regressor.constant
    middle, bottom, size = placements.T
    middle = middle + offsets[:, 0] * size
    bottom = bottom + regressor.bottom * size
    w, h = (size * np.exp(np.clip(offsets[:, i], -LARGEST_ENLARGEMENT, LARGEST_ENLARGEMENT)) for i in (1, 2))
    return np.column_stack([middle - w / 2, bottom - h, w, h])


@kernel()
def _offsets(features: NDArray[np.uint8], weights: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """Products of (N, F) and (3, F) into (N, 3): a few windows, for which BLAS would wake its threads."""
    for index in range(len(features)):
        window = features[index]
        for k in range(len(weights)):
            row, total = weights[k], np.float32(0)
            for i in range(len(row)):
                total += row[i] * np.float32(window[i])
            out[index, k] = total
