"""The evidence of each hypothesis: how well the input agrees with what is known about cameras.

A hypothesis is a set of distances and of priors. With rows v_i clicked at distances d_i, the model is

    v_i = v0 - f t + f h (1 + t^2) / (d_i + o + h t) + r (u_i - u0),        t = tan(a)

with the reference offset o, the tangent r of the roll, and the camera's t, f and v0, all with Gaussian
priors. The evidence is the marginal density of the rows, by Laplace's approximation at the best fit (MacKay
1992, "Bayesian interpolation"). All hypotheses are fitted at once (Levenberg & Marquardt), so that a few
hundred take milliseconds.
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
"""A point is at least so far in front of the camera's plane, which keeps the fit finite."""
LOG_FOCAL_LIMITS = (3.0, 12.0)
STEEPEST_TANGENT = 3.0
GREATEST_DAMPING, SMALLEST_DAMPING = 1e8, 1e-7
STILL_SIGMAS, STILL_DAMPING = 1e-6, 100.0
"""A fit ends when an undamped step moves no unknown by more than this part of its prior sigma."""
PATIENCE, HOPELESS_COST = 10, 1000.0
"""After so many steps, a fit whose cost exceeds that of the best one by this is stopped. Its probability is
nil, and it would crawl along a limit of the unknowns for all `ITERATIONS`."""


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """What was clicked.

    Attributes:
        rows_px: (N,) rows.
        columns_px: (N,) columns from the middle of the picture; 0 if unknown.
        height_m: height of the camera.
        half_width_px: half of the picture's width.
    """

    rows_px: FloatArray
    columns_px: FloatArray
    height_m: float
    half_width_px: float


@dataclass(frozen=True, slots=True, eq=False)
class Beliefs:
    """The hypotheses of one judgement, one in each row.

    Attributes:
        distances_m: (H, N) distances, without the offset.
        row_sigmas_px: (H, N) standard deviations of the clicks.
        tape_m: (H, N) standard deviations of the distances.
        means: (H, 5) prior means of tan(a), horizontal field of view in radians, v0, offset and roll.
        sigmas: (H, 5) their standard deviations.
        horizon: mean and standard deviation of the horizon row, if one is stated.
    """

    distances_m: FloatArray
    row_sigmas_px: FloatArray
    tape_m: FloatArray
    means: FloatArray
    sigmas: FloatArray
    horizon: tuple[float, float] | None = None

    def of(self, which: NDArray[np.bool_]) -> "Beliefs":
        """The priors of some of the hypotheses."""
        return Beliefs(
            self.distances_m[which],
            self.row_sigmas_px[which],
            self.tape_m[which],
            self.means[which],
            self.sigmas[which],
            self.horizon,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """The best fit of each hypothesis.

    Attributes:
        log_evidence: (H,) logarithms of the evidence.
        unknowns: (H, 5) tan(a), log(f), v0, offset and roll.
        misfits: (H, N) misfits of the rows in sigmas.
    """

    log_evidence: FloatArray
    unknowns: FloatArray
    misfits: FloatArray


def fit(rows: Rows, beliefs: Beliefs) -> Fits:
    """Fit every hypothesis."""
    x = _fitted(rows, beliefs)
    residuals, jacobian, sigmas_px = _linearised(rows, beliefs, x)
    cost = np.sum(residuals**2, axis=1)
    normal = jacobian.mT @ jacobian
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


def _fitted(rows: Rows, beliefs: Beliefs) -> FloatArray:
    """(H, 5) unknowns that fit best; hypotheses whose fit no longer moves leave the iteration."""
    fitted = beliefs.means.copy()
    fitted[:, LOG_FOCAL] = np.log(rows.half_width_px / np.tan(beliefs.means[:, LOG_FOCAL] / 2))
    going, x, damping = np.arange(len(fitted)), fitted, np.full(len(fitted), 1e-2)
    least_cost = math.inf
    for step in range(ITERATIONS):
        residuals, jacobian, sigmas_px = _linearised(rows, beliefs, x)
        cost = np.sum(residuals**2, axis=1)
        tried = _stepped(x, residuals, jacobian, damping)
        # The weights stay the same while a step is judged, and are updated after it.
        new = _residuals(rows, beliefs, _modelled(rows, beliefs, tried), tried, sigmas_px)
        new_cost = np.sum(new**2, axis=1)
        better = new_cost <= cost
        moves = (np.abs(tried - x) > STILL_SIGMAS * beliefs.sigmas).any(axis=1) | (damping > STILL_DAMPING)
        least_cost = min(least_cost, float(new_cost.min()))
        moves &= (new_cost < least_cost + HOPELESS_COST) | (step < PATIENCE)
        x = np.where(better[:, None], tried, x)
        damping = np.clip(np.where(better, damping / 5, damping * 4), SMALLEST_DAMPING, GREATEST_DAMPING)
        fitted[going] = x
        if not moves.any():
            break
        if not moves.all():
            going, x, damping, beliefs = going[moves], x[moves], damping[moves], beliefs.of(moves)
    return fitted


def _stepped(x: FloatArray, residuals: FloatArray, jacobian: FloatArray, damping: FloatArray) -> FloatArray:
    """(H, 5) unknowns after the next step."""
    normal = jacobian.mT @ jacobian
    gradient = (jacobian.mT @ residuals[..., None])[..., 0]
    diagonal = np.einsum("hjj->hj", normal)
    damped = normal + np.eye(UNKNOWN_COUNT) * (damping[:, None] * diagonal)[:, None, :]
    tried = x - np.linalg.solve(damped, gradient[..., None])[..., 0]
    tried[:, LOG_FOCAL] = np.clip(tried[:, LOG_FOCAL], *LOG_FOCAL_LIMITS)
    tried[:, TANGENT] = np.clip(tried[:, TANGENT], -STEEPEST_TANGENT, STEEPEST_TANGENT)
    return tried


@dataclass(frozen=True, slots=True, eq=False)
class _Modelled:
    """The model for given unknowns: arrays are (H, N), or (H, 1) if they are the same for each row."""

    tangent: FloatArray
    focal_px: FloatArray
    horizon_px: FloatArray
    below_px: FloatArray
    slopes: FloatArray


def _modelled(rows: Rows, beliefs: Beliefs, x: FloatArray) -> _Modelled:
    tangent, axis, offset = (x[:, k, None] for k in (TANGENT, AXIS, OFFSET))
    focal = np.exp(x[:, LOG_FOCAL, None])
    depths_m = np.maximum(beliefs.distances_m + offset + rows.height_m * tangent, SMALLEST_DEPTH_M)
    below_px = focal * rows.height_m * (1 + tangent**2) / depths_m
    return _Modelled(tangent, focal, axis - focal * tangent, below_px, below_px / depths_m)


def _residuals(
    rows: Rows, beliefs: Beliefs, model: _Modelled, x: FloatArray, sigmas_px: FloatArray
) -> FloatArray:
    """(H, M) residuals in sigmas: the rows, the priors, and the horizon if one is stated."""
    modelled_px = model.horizon_px + model.below_px + x[:, ROLL, None] * rows.columns_px
    believed = x.copy()
    believed[:, LOG_FOCAL] = 2 * np.arctan2(rows.half_width_px, model.focal_px[:, 0])
    found = [(modelled_px - rows.rows_px) / sigmas_px, (believed - beliefs.means) / beliefs.sigmas]
    if beliefs.horizon is not None:
        mean, sigma = beliefs.horizon
        found.append((model.horizon_px - mean) / sigma)
    return np.concatenate(found, axis=1)


def _linearised(rows: Rows, beliefs: Beliefs, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Residuals (H, M) in sigmas, their Jacobian (H, M, 5), and the sigmas (H, N) of the rows."""
    model = _modelled(rows, beliefs, x)
    sigmas_px = np.hypot(beliefs.row_sigmas_px, beliefs.tape_m * model.slopes)
    tangent, focal, count = model.tangent, model.focal_px, len(rows.rows_px)
    residuals = _residuals(rows, beliefs, model, x, sigmas_px)
    jacobian = np.zeros((*residuals.shape, UNKNOWN_COUNT))
    by = jacobian[:, :count]
    by[..., TANGENT] = -focal + model.below_px * 2 * tangent / (1 + tangent**2) - model.slopes * rows.height_m
    by[..., LOG_FOCAL] = model.below_px - focal * tangent
    by[..., AXIS] = 1.0
    by[..., OFFSET] = -model.slopes
    by[..., ROLL] = rows.columns_px
    by /= sigmas_px[..., None]

    half, focal, tangent = rows.half_width_px, focal[:, 0], tangent[:, 0]
    unknowns = np.arange(UNKNOWN_COUNT)
    jacobian[:, count + unknowns, unknowns] = 1 / beliefs.sigmas
    jacobian[:, count + LOG_FOCAL, LOG_FOCAL] *= -2 * half * focal / (focal**2 + half**2)
    if beliefs.horizon is not None:
        by_horizon = np.stack((-focal, -focal * tangent, np.ones_like(focal)), axis=-1)
        jacobian[:, -1, [TANGENT, LOG_FOCAL, AXIS]] = by_horizon / beliefs.horizon[1]
    return residuals, jacobian, sigmas_px


def log_sum(values: FloatArray, axis: int = -1) -> NDArray[np.float64]:
    """Logarithm of the sum of exponentials."""
    top = values.max(axis=axis, keepdims=True)
    return np.log(np.exp(values - top).sum(axis=axis)) + np.squeeze(top, axis=axis)
