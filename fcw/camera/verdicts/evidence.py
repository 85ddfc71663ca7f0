"""How well what was said of a camera agrees with what is known of cameras: the evidence of each hypothesis.

A hypothesis is a set of distances and of beliefs. With rows v_i clicked at distances d_i the model is

    v_i = v0 - f t + f h (1 + t^2) / (d_i + o + h t) + r (u_i - u0),        t = tan(a)

with the reference offset o and the roll's tangent r beside the camera's own t, f and v0, all of them with
Gaussian beliefs. The evidence, the density of the rows before any of them is known, is Laplace's
approximation at the best fit (MacKay 1992, "Bayesian interpolation"). All hypotheses are fitted at once
(Levenberg & Marquardt), so that a few hundred take milliseconds.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray

TANGENT, LOG_FOCAL, AXIS, OFFSET, ROLL = range(5)
"""Places in the unknowns of a fit."""
UNKNOWN_COUNT = 5
ITERATIONS = 40
SMALLEST_DEPTH_M = 0.2
"""A point is this far in front of the camera's plane at least; keeps the fit finite."""
LOG_FOCAL_LIMITS = (3.0, 12.0)
STEEPEST_TANGENT = 3.0
GREATEST_DAMPING, SMALLEST_DAMPING = 1e8, 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """What was clicked.

    Attributes:
        rows_px: (N,).
        columns_px: (N,) from the picture's middle; 0 where unknown.
        height_m: of the camera.
        half_width_px: of the picture.
    """

    rows_px: FloatArray
    columns_px: FloatArray
    height_m: float
    half_width_px: float


@dataclass(frozen=True, slots=True, eq=False)
class Beliefs:
    """The hypotheses of one judgement, a row each.

    Attributes:
        distances_m: (H, N), without the offset.
        row_sigmas_px: (H, N) of the clicks.
        tape_m: (H, N) of the distances.
        means: (H, 5) of tan(a), horizontal field of view in radians, v0, offset and roll.
        sigmas: (H, 5) of them.
        horizon: mean and standard deviation of the horizon's row, where one is stated.
    """

    distances_m: FloatArray
    row_sigmas_px: FloatArray
    tape_m: FloatArray
    means: FloatArray
    sigmas: FloatArray
    horizon: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """The best fit of each hypothesis.

    Attributes:
        log_evidence: (H,).
        unknowns: (H, 5): tan(a), log(f), v0, offset, roll.
        misfits: (H, N) of the rows, in sigmas.
    """

    log_evidence: FloatArray
    unknowns: FloatArray
    misfits: FloatArray


def fit(rows: Rows, beliefs: Beliefs) -> Fits:
    """Fit every hypothesis."""
    x = beliefs.means.copy()
    x[:, LOG_FOCAL] = np.log(rows.half_width_px / np.tan(beliefs.means[:, LOG_FOCAL] / 2))
    damping = np.full(len(x), 1e-2)
    residuals, jacobian, sigmas_px = _linearised(rows, beliefs, x)
    cost = np.sum(residuals**2, axis=1)
    for _ in range(ITERATIONS):
        tried = _stepped(x, residuals, jacobian, damping)
        # The weights stay while a step is judged; those of the place it leads to come after it.
        new = _linearised(rows, beliefs, tried, sigmas_px)[0]
        better = np.sum(new**2, axis=1) <= cost
        x = np.where(better[:, None], tried, x)
        damping = np.clip(np.where(better, damping / 5, damping * 4), SMALLEST_DAMPING, GREATEST_DAMPING)
        residuals, jacobian, sigmas_px = _linearised(rows, beliefs, x)
        cost = np.sum(residuals**2, axis=1)
    normal = np.einsum("hij,hik->hjk", jacobian, jacobian)
    _, log_determinant = np.linalg.slogdet(normal)
    focal_px = np.exp(x[:, LOG_FOCAL])
    by_log_focal = 2 * rows.half_width_px * focal_px / (focal_px**2 + rows.half_width_px**2)
    measured = jacobian.shape[1] - UNKNOWN_COUNT
    log_evidence = (
        -cost / 2
        - np.log(sigmas_px).sum(axis=1)
        - np.log(beliefs.sigmas).sum(axis=1)
        + np.log(by_log_focal)
        - log_determinant / 2
        - measured / 2 * math.log(2 * math.pi)
    )
    return Fits(log_evidence, x, residuals[:, : len(rows.rows_px)])


def _stepped(x: FloatArray, residuals: FloatArray, jacobian: FloatArray, damping: FloatArray) -> FloatArray:
    """Where the next step leads: (H, 5)."""
    normal = np.einsum("hij,hik->hjk", jacobian, jacobian)
    gradient = np.einsum("hij,hi->hj", jacobian, residuals)
    diagonal = np.einsum("hjj->hj", normal)
    damped = normal + np.eye(UNKNOWN_COUNT) * (damping[:, None] * diagonal)[:, None, :]
    tried = x - np.linalg.solve(damped, gradient[..., None])[..., 0]
    tried[:, LOG_FOCAL] = np.clip(tried[:, LOG_FOCAL], *LOG_FOCAL_LIMITS)
    tried[:, TANGENT] = np.clip(tried[:, TANGENT], -STEEPEST_TANGENT, STEEPEST_TANGENT)
    return tried


def _linearised(
    rows: Rows, beliefs: Beliefs, x: FloatArray, sigmas_px: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Residuals (H, M) in sigmas, their Jacobian (H, M, 5), and the sigmas (H, N) of the rows."""
    tangent, axis, offset, roll = (x[:, k, None] for k in (TANGENT, AXIS, OFFSET, ROLL))
    focal = np.exp(x[:, LOG_FOCAL, None])
    reached = beliefs.distances_m + offset + rows.height_m * tangent
    depths_m = np.maximum(reached, SMALLEST_DEPTH_M)
    below_px = focal * rows.height_m * (1 + tangent**2) / depths_m
    slopes = below_px / depths_m
    if sigmas_px is None:
        sigmas_px = np.hypot(beliefs.row_sigmas_px, beliefs.tape_m * slopes)
    horizon_px = axis - focal * tangent
    modelled = horizon_px + below_px + roll * rows.columns_px
    by = np.empty((*modelled.shape, UNKNOWN_COUNT))
    by[..., TANGENT] = -focal + below_px * 2 * tangent / (1 + tangent**2) - slopes * rows.height_m
    by[..., LOG_FOCAL] = below_px - focal * tangent
    by[..., AXIS] = 1.0
    by[..., OFFSET] = -slopes
    by[..., ROLL] = rows.columns_px
    residuals = [(modelled - rows.rows_px) / sigmas_px]
    jacobians = [by / sigmas_px[..., None]]

    half = rows.half_width_px
    believed = x.copy()
    believed[:, LOG_FOCAL] = 2 * np.arctan2(half, focal[:, 0])
    residuals.append((believed - beliefs.means) / beliefs.sigmas)
    slope = np.ones_like(x)
    slope[:, LOG_FOCAL] = -2 * half * focal[:, 0] / (focal[:, 0] ** 2 + half**2)
    jacobians.append(np.eye(UNKNOWN_COUNT) * (slope / beliefs.sigmas)[:, None, :])
    if beliefs.horizon is not None:
        mean, sigma = beliefs.horizon
        residuals.append((horizon_px - mean) / sigma)
        by_horizon = np.zeros((len(x), 1, UNKNOWN_COUNT))
        by_horizon[:, 0, TANGENT] = -focal[:, 0]
        by_horizon[:, 0, LOG_FOCAL] = -(focal * tangent)[:, 0]
        by_horizon[:, 0, AXIS] = 1.0
        jacobians.append(by_horizon / sigma)
    return np.concatenate(residuals, axis=1), np.concatenate(jacobians, axis=1), sigmas_px


def log_sum(values: FloatArray, axis: int = -1) -> NDArray[np.float64]:
    """Logarithm of the sum of exponentials."""
    top = values.max(axis=axis, keepdims=True)
    return np.log(np.exp(values - top).sum(axis=axis)) + np.squeeze(top, axis=axis)
