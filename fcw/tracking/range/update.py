"""One measurement of a Kalman filter, taken robustly; a part of the state may be left as it is."""

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.tracking.box_measurement import CAMERA, Measurements

NOTHING = np.zeros((CAMERA, CAMERA))
"""Is what the camera's state learns of what concerns one vehicle alone."""

OUTLIER_SIGMAS = 3.0
"""A measurement farther off than this is taken to be so noisy that it is just this far off: the wilder one
box, the less it moves (twice as far off half as much), and a persistent one still wins. Huber's weights, by
which it would move as much as at this limit, are no better on KITTI tracking's distances."""


def kalman_update(
    x: FloatArray,
    p: FloatArray,
    rows: FloatArray,
    residuals: FloatArray,
    variances: FloatArray,
    learns: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """State and covariance after a measurement.

    Args:
        x: (N,) the state.
        p: (N, N) its covariance.
        rows: (M, N) the measurement by the state.
        residuals: (M,) measured less expected.
        variances: (M,) of the measurement's errors.
        learns: (F, F) what the first F of the state make of the gain that would be theirs: with zeros they
            stay as they are, and their error is part of the others' (Schmidt 1966).
    """
    spread = p @ rows.T
    predicted = rows @ spread
    variances = np.maximum(variances, (residuals / OUTLIER_SIGMAS) ** 2 - predicted.diagonal())
    predicted.flat[:: len(residuals) + 1] += variances
    gain = np.linalg.solve(predicted, spread.T).T
    gain[: len(learns)] = learns @ gain[: len(learns)]
    # Joseph's form, which is right for any gain.
    used = gain @ spread.T
    covariance = p - used - used.T + gain @ predicted @ gain.T
    return x + gain @ residuals, (covariance + covariance.T) / 2


def take_measurements(
    x: FloatArray, p: FloatArray, seen: Measurements, learns: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """State and covariance after the boxes of a frame; those that tell of one vehicle alone come last.

    Args:
        x: (N,) the state against which they were measured.
        p: (N, N) its covariance.
        seen: of the frame.
        learns: what the camera's state makes of those that tell of it, see `kalman_update`.
    """
    rows, residuals, variances, common, _ = seen
    before = x
    if common.any():
        x, p = kalman_update(x, p, rows[common], residuals[common], variances[common], learns)
    if not common.all():
        aside = rows[~common]
        moved = residuals[~common] - aside @ (x - before)
        x, p = kalman_update(x, p, aside, moved, variances[~common], NOTHING)
    return x, p
