"""How well the camera's parameters are known, and where one more click helps most."""

import math
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import FloatArray
from fcw.camera.prior_sigmas import MARK_ERROR_PART
from fcw.camera.solve import row_jacobian

CANDIDATE_COUNT = 60
TARGET_DISTANCES_M = (10.0, 20.0, 30.0, 40.0, 50.0)
"""Distances whose error is minimised when the next click is chosen: the range of a warning."""


@dataclass(frozen=True, slots=True)
class CameraSigmas:
    """Standard deviations of the camera's parameters, to first order.

    Pitch, focal length and principal row are strongly correlated. Each may be poorly known while every
    distance is known well.
    """

    pitch_rad: float
    focal_y_px: float
    principal_row_px: float
    horizon_row_px: float


@dataclass(frozen=True, slots=True)
class NextClick:
    """The distance at which one more clicked point improves the distances most.

    Attributes:
        distance_m: distance from the reference point.
        row_px: expected row of the point.
        error_before: present relative standard deviation of the distance, root mean square over
            `TARGET_DISTANCES_M`.
        error_after: the same after that click.
    """

    distance_m: float
    row_px: float
    error_before: float
    error_after: float


def camera_sigmas(calibration: Calibration) -> CameraSigmas:
    """Standard deviations of the camera's parameters, from the covariance of the support rows."""
    camera = calibration.camera
    tangent, focal_px = math.tan(camera.pitch_rad), camera.focal_y_px
    # Of pitch, f_y, v0 and B by tan(a), log(f_y) and B.
    by_parameters = np.array(
        [
            [1 / (1 + tangent**2), 0.0, 0.0],
            [0.0, focal_px, 0.0],
            [focal_px, focal_px * tangent, 1.0],
            [0.0, 0.0, 1.0],
        ]
    )
    support_m = np.array(calibration.support_distances_m) + calibration.reference_offset_m
    by_rows = by_parameters @ np.linalg.inv(row_jacobian(camera, support_m))
    variances = np.einsum("ij,jk,ik->i", by_rows, np.array(calibration.covariance), by_rows)
    return CameraSigmas(*(math.sqrt(max(float(variance), 0.0)) for variance in variances))


def best_next_click(
    calibration: Calibration, nearest_m: float = 3.0, farthest_m: float = 40.0
) -> NextClick | None:
    """Where one more click, as good as the others, shrinks the errors of the distances most.

    Args:
        calibration: the present calibration.
        nearest_m: nearest distance that can be marked, from the reference point.
        farthest_m: farthest distance that a tape measure or paced dashes can reach.

    Returns:
        None if no distance between the two is inside the picture, or if nothing is uncertain.
    """
    targets_m = np.array(TARGET_DISTANCES_M)
    before = relative_errors(calibration, targets_m)
    # The tape's error is common to all marks, so one more mark does not reduce it.
    support_m = np.array(calibration.support_distances_m)
    slopes = calibration.camera.row_slope_at(support_m + calibration.reference_offset_m)
    taped_px = calibration.tape_error * support_m * slopes
    covariance = np.array(calibration.covariance) - np.outer(taped_px, taped_px)
    candidates_m = np.geomspace(nearest_m, farthest_m, CANDIDATE_COUNT)
    rows_px = calibration.row_at(candidates_m)
    candidates_m = candidates_m[(rows_px >= -0.5) & (rows_px <= calibration.image_size.height - 0.5)]
    if not len(candidates_m) or not before.any():
        return None
    # One more measured row is a rank-one update of the covariance, as in a Kalman filter.
    gradients = calibration.row_gradients(candidates_m)
    spreads = covariance @ gradients.T
    laid_px = MARK_ERROR_PART * calibration.tape_error * candidates_m
    laid_px *= calibration.camera.row_slope_at(candidates_m + calibration.reference_offset_m)
    innovations = calibration.row_sigma_px**2 + laid_px**2 + np.einsum("ij,ji->i", gradients, spreads)
    shared = calibration.row_gradients(targets_m) @ spreads
    gains = (_relative_per_row(calibration, targets_m)[:, None] * shared) ** 2 / innovations
    errors = np.sqrt(np.mean(np.maximum(before[:, None] ** 2 - gains, 0.0), axis=0))
    best = int(np.argmin(errors))
    distance_m = float(candidates_m[best])
    return NextClick(
        distance_m,
        calibration.row_at(distance_m),
        math.sqrt(float(np.mean(before**2))),
        float(errors[best]),
    )


def row_sigmas(calibration: Calibration, distances_m: FloatArray) -> FloatArray:
    """(N,): standard deviations of the rows at N distances from the reference, in pixels."""
    gradients = calibration.row_gradients(distances_m)
    variances = np.einsum("ij,jk,ik->i", gradients, np.array(calibration.covariance), gradients)
    return np.sqrt(np.maximum(variances, 0.0))


def relative_errors(calibration: Calibration, distances_m: FloatArray) -> FloatArray:
    """(N,): standard deviations of N distances to first order, as parts of them."""
    return row_sigmas(calibration, distances_m) * _relative_per_row(calibration, distances_m)


def _relative_per_row(calibration: Calibration, distances_m: FloatArray) -> FloatArray:
    """(N,): relative change of the distance from one row to the next."""
    camera = calibration.camera
    depths_m = distances_m + calibration.reference_offset_m + camera.pole_m
    return depths_m**2 / camera.row_scale_m_px / distances_m
