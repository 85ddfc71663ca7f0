"""One measurement of a Kalman filter, taken robustly; a part of the state may be left as it is."""

import numpy as np

from fcw.camera.ground_plane import FloatArray

OUTLIER_SIGMAS = 3.0
"""A measurement farther off than this counts as if it were just this far off (Huber), so that one wild
box moves little and a persistent one still wins."""


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
