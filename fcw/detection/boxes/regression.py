"""The last stage: width, height and middle of the vehicle in a window.

Windows are on a grid of cells and scales, and all in one row have the same aspect ratio. A linear map from a
window's channels finds the vehicle's own box (box regression, Felzenszwalb et al., "Object detection with
discriminatively trained part-based models", PAMI 2010, section 7.3). It is trained on windows with larger
displacements than those for the trees. Ridge regression keeps 2,560 correlated inputs in check.

The bottom edge, which determines the distance, is not regressed. In real pictures, the mean of several
windows finds it as well. In rendered ones, which are unlike the training data, a regressed edge was 3 to 6 %
of the height too high. It gets one constant offset, which is measured on held-out pictures.
"""

import numpy as np
from numpy.typing import NDArray

from fcw.detection.model import BoxRegressor
from fcw.kernels.inner import inner_kernel

LARGEST_ENLARGEMENT = 0.5
"""Largest logarithm of the ratio between the size of a box and that of its window."""


def fit_regressor(features: NDArray[np.uint8], offsets: NDArray[np.float64], ridge: float) -> BoxRegressor:
    """Fit a regressor from channels to offsets by ridge regression.

    Args:
        features: (N, F) uint8.
        offsets: (N, 3) from `box_offsets`.
        ridge: weight of the squared coefficients, relative to the number of windows times the mean variance
            of a feature.
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
    """Offsets of vehicles relative to their windows.

    Args:
        boxes: (N, 4) x, y, w, h of the vehicles.
        middle: (N,) column where the window expects the vehicle's middle.
        size: (N,) sqrt(w h) that the window expects.

    Returns:
        (N, 3): shift of the middle, in sizes, and logarithms of width and height over the size.
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
    """Compute the box of the vehicle in a window.

    Args:
        weights: (3, F) weights of a regressor, transposed.
        constant: (3,) its constants.
        lower: its `bottom`.
        features: (F,) features of the window.
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
