"""A robust measurement update of a Kalman filter that may leave a part of the state unchanged."""

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.tracking.box_measurement import CAMERA, Measurements

NOTHING = np.zeros((CAMERA, CAMERA))
"""`learns` for measurements that concern one vehicle only: the camera's state stays as it is."""

OUTLIER_SIGMAS = 3.0
"""The variance of a measurement that is farther off than this is raised until it is just this far off. So the
farther off a single box is, the less it changes (half as much if twice as far off), but a persistent
deviation still wins. Huber's weights, with which it would change as much as at this limit, are no better on
the distances of KITTI tracking."""


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
        x: (N,) state.
        p: (N, N) covariance of the state.
        rows: (M, N) Jacobian of the measurement.
        residuals: (M,) measured minus expected.
        variances: (M,) variances of the measurement's errors.
        learns: (F, F) matrix applied to the gain of the first F elements of the state. With zeros they stay
            as they are, and their error is considered in the others' (Schmidt 1966).
    """
    spread = p @ rows.T
    predicted = rows @ spread
    variances = np.maximum(variances, (residuals / OUTLIER_SIGMAS) ** 2 - predicted.diagonal())
    predicted.flat[:: len(residuals) + 1] += variances
    gain = np.linalg.solve(predicted, spread.T).T
    gain[: len(learns)] = learns @ gain[: len(learns)]
    # Joseph's form, which is valid for any gain.
    used = gain @ spread.T
    covariance = p - used - used.T + gain @ predicted @ gain.T
    return x + gain @ residuals, (covariance + covariance.T) / 2


def take_measurements(
    x: FloatArray, p: FloatArray, seen: Measurements, learns: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """State and covariance after the boxes of a frame. Those that do not update the camera are used last.

    Args:
        x: (N,) state for which the residuals were computed.
        p: (N, N) covariance of the state.
        seen: the measurements of the frame.
        learns: as in `kalman_update`, for measurements that update the camera.
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
