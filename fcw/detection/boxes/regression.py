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

from fcw.detection.model import BoxRegressor
from fcw.kernels.inner import inner_kernel

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


@inner_kernel(from_python=True)
def place_box(
    weights: NDArray[np.float32],
    constant: NDArray[np.float32],
    lower: float,
    features: NDArray[np.uint8],
    placement: NDArray[np.float64],
    box: NDArray[np.float64],
) -> None:
    """The box of the vehicle in a window.

    Args:
        weights: (3, F), a regressor's, transposed.
        constant: (3,).
        lower: the regressor's `bottom`.
        features: (F,) of the window.
        placement: (3,) middle, bottom and size that the window expects.
        box: (4,) receives x, y, w, h.
    """
    to_middle, to_width, to_height = weights[0], weights[1], weights[2]
    middle_sum = width_sum = height_sum = np.float32(0)
    for i in range(len(features)):
        value = np.float32(features[i])
        middle_sum += to_middle[i] * value
        width_sum += to_width[i] * value
        height_sum += to_height[i] * value
    size = placement[2]
    middle = placement[0] + np.float64(middle_sum + constant[0]) * size
    bottom = placement[1] + lower * size
    log_width, log_height = np.float64(width_sum + constant[1]), np.float64(height_sum + constant[2])
    width = size * np.exp(min(max(log_width, -LARGEST_ENLARGEMENT), LARGEST_ENLARGEMENT))
    height = size * np.exp(min(max(log_height, -LARGEST_ENLARGEMENT), LARGEST_ENLARGEMENT))
    box[0], box[1], box[2], box[3] = middle - width / 2, bottom - height, width, height
