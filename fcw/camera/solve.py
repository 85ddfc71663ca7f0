"""From clicked points to a calibration: least squares with priors, and the exact three-point solution.

With three points alone, pitch, focal length and principal row trade off against each other, so that one click
a pixel off gives an impossible camera. So what all dash cameras have in common (the axis near the middle of
the picture, a plausible field of view, about level) is used as weak priors, unless better ones are given.
"""

import math
from collections.abc import Sequence

import numpy as np

from fcw.camera.calibration import (
    DEFAULT_SUPPORT_M,
    Calibration,
    Gaussian,
    GroundPoint,
    Priors,
    matrix3,
)
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.interval import Vector3
from fcw.camera.lens.usual import usual_lens
from fcw.camera.points import (
    PARAMETER_COUNT,
    check_exact,
    check_order,
    check_points,
    check_priors,
    check_setup,
    check_tape_error,
    distinct_distances,
    horizon_below_road,
)
from fcw.camera.prior_sigmas import (
    MARK_ERROR_PART,
    ROLL_SIGMA_RAD,
    TAPE_ERROR,
    USUAL_TANGENT,
    USUAL_TANGENT_SIGMA,
    YAW_SIGMA_RAD,
)
from fcw.camera.straight import LEVEL, Orientation
from fcw.camera.verdicts.period import period_doubt, widened
from fcw.errors import UserError
from fcw.frame import ImageSize

LOG_FOCAL_LIMIT = 50.0
"""Keeps a fit that diverges within the range of floating point; no camera is near it."""
START_COUNT = 3
"""Number of the grid's local minima that are followed; two are real, a third may come from the grid."""
START_PITCHES_RAD = np.radians(np.arange(-60.0, 89.0, 1.0))
"""The grid of pitches at which the iteration may start."""
STEEPEST_PITCH_RAD = math.radians(89.0)
"""A fit that reaches this pitch tends to a straight line: its horizon is not above the road."""
MINIMUM_CONDITION = 1e-6
"""Least ratio of the smallest to the largest singular value of the scaled Jacobian; else rounding decides."""
OUTLIER_SIGMAS = 4.0
"""Up to this residual, a point out of order is noise; beyond it, a mistake."""


def calibrate(
    points: Sequence[GroundPoint],
    image_size: ImageSize,
    height_m: float,
    reference_offset_m: float = 0.0,
    row_sigma_px: float = 1.0,
    field_of_view: Gaussian | None = None,
    principal_row: Gaussian | None = None,
    horizon_row: Gaussian | None = None,
    *,
    tape_error: float = TAPE_ERROR,
    exact: bool = False,
) -> Calibration:
    """Calibrate from points on the road at known distances.

    The rows are fitted by least squares, and each prior counts as one more measurement, so that fewer points
    are enough if priors are given. Where none is given, that of usual lenses is assumed (`usual_lens`).

    Args:
        points: their distances from the reference, and their rows in a picture of `image_size`.
        image_size: size of the picture.
        height_m: height of the camera above the road.
        reference_offset_m: distance from the camera forward to the reference (the front bumper), at least 0.
        row_sigma_px: standard deviation of a clicked row.
        field_of_view: horizontal field of view of the whole picture in radians; pixels are square.
        principal_row: row of the optical axis.
        horizon_row: row of the horizon, which is a point at infinity.
        tape_error: standard deviation of all distances together, as a part of them. A tape that is too long,
            sags or lies askew affects every mark alike: it scales all distances, and no residual shows it.
        exact: use only the closed solution of three points (eq. 3 and 13).

    Raises:
        UserError: the input does not determine a camera; the message names the points and what to do.
    """
    points = tuple(
        GroundPoint(
            float(point.distance_m),
            float(point.row_px),
            None if point.column_px is None else float(point.column_px),
        )
        for point in points
    )
    priors = Priors(field_of_view, principal_row, horizon_row)
    check_setup(image_size, height_m, reference_offset_m, row_sigma_px)
    check_priors(priors)
    check_tape_error(tape_error)
    if exact:
        check_exact(points, priors)
    check_points(points, image_size, row_sigma_px, priors.count)

    reference_m = np.array([point.distance_m for point in points])
    distances_m = reference_m + reference_offset_m
    rows_px = np.array([point.row_px for point in points])
    support_m = support_distances(reference_m)
    assumed = Priors() if exact else usual_lens(image_size, priors)
    if exact:
        camera = exact_camera(distances_m, rows_px, height_m, (image_size.width - 1) / 2)
        covariance = row_sigma_px**2 * np.eye(3)
    else:
        believed = _together(priors, assumed)
        fit = _Fit(distances_m, rows_px, image_size, height_m, row_sigma_px, believed, level=True)
        camera = _check_road(fit.solve(), points)
        if tape_error:
            # Each mark also has an error of its own. Near the camera it is more rows than a click is off.
            laid_px = MARK_ERROR_PART * tape_error * reference_m * camera.row_slope_at(distances_m)
            sigmas_px = np.hypot(row_sigma_px, laid_px)
            fit = _Fit(distances_m, rows_px, image_size, height_m, sigmas_px, believed, level=True)
            camera = _check_road(fit.solve(near=camera), points)
        covariance = fit.covariance(camera, np.array(support_m) + reference_offset_m)
    support = np.array(support_m)
    taped_px = tape_error * support * camera.row_slope_at(support + reference_offset_m)
    covariance = covariance + np.outer(taped_px, taped_px)
    residuals = tuple(point.row_px - camera.row_at(point.distance_m + reference_offset_m) for point in points)
    calibration = Calibration(
        camera,
        image_size,
        points,
        float(row_sigma_px),
        support_m,
        matrix3(covariance),
        float(reference_offset_m),
        priors,
        residuals,
        assumed,
        float(tape_error),
        # Rows say nothing about yaw and roll: the camera is taken as level, with the usual uncertainty.
        LEVEL if exact else Orientation(0.0, 0.0, YAW_SIGMA_RAD, ROLL_SIGMA_RAD),
    )
    if any(abs(residual) > OUTLIER_SIGMAS * row_sigma_px for residual in residuals):
        check_order(points)
        if not priors.count and not exact:
            free = _Fit(distances_m, rows_px, image_size, height_m, row_sigma_px, priors).solve()
            _check_road(free, points)
    return calibration if exact else widened(calibration, period_doubt(calibration))


def _together(stated: Priors, assumed: Priors) -> Priors:
    return Priors(
        stated.field_of_view_rad or assumed.field_of_view_rad,
        stated.principal_row_px or assumed.principal_row_px,
        stated.horizon_row_px,
    )


def _check_road(camera: GroundPlaneCamera | None, points: Sequence[GroundPoint]) -> GroundPlaneCamera:
    """Return the camera if the points lie on a road below its horizon.

    Raises:
        PointsError: they do not.
    """
    if camera is None or camera.pitch_rad > STEEPEST_PITCH_RAD:
        check_order(points)
        raise horizon_below_road(points, "a straight line fits them better than a road")
    return camera


def exact_solution(calibration: Calibration) -> Calibration | None:
    """The closed solution for a calibration's points; None unless they are three points that have one."""
    if len(calibration.points) != PARAMETER_COUNT:
        return None
    try:
        return calibrate(
            calibration.points,
            calibration.image_size,
            calibration.camera.height_m,
            calibration.reference_offset_m,
            calibration.row_sigma_px,
            tape_error=calibration.tape_error,
            exact=True,
        )
    except UserError:  # with priors fewer distances are enough
        return None


def exact_camera(
    distances_m: FloatArray, rows_px: FloatArray, height_m: float, principal_column_px: float
) -> GroundPlaneCamera:
    """The camera through three points, in closed form.

    For the row map (A + B d) / (d + C), each point gives the linear equation A + B d - C v = v d.

    Args:
        distances_m: (3,) distances from the camera.
        rows_px: (3,) rows.
        height_m: height of the camera.
        principal_column_px: column of the optical axis.
    """
    # With rows and distances counted from the first point, A drops out and no digits are lost:
    # B' d' - C' v' = v' d' with C' = C + d_0 and B' = B - v_0.
    d, v = distances_m[1:] - distances_m[0], rows_px[1:] - rows_px[0]
    determinant = d[1] * v[0] - d[0] * v[1]
    horizon_px = v[0] * v[1] * (d[1] - d[0]) / determinant
    pole_m = d[0] * d[1] * (v[1] - v[0]) / determinant
    return GroundPlaneCamera.from_row_map(
        float(rows_px[0] + horizon_px),
        float(-horizon_px * pole_m),
        float(pole_m - distances_m[0]),
        float(height_m),
        float(principal_column_px),
    )


def row_jacobian(camera: GroundPlaneCamera, distances_m: FloatArray) -> FloatArray:
    """(N, 3) derivatives of the rows at N distances by tan(a), log(f_y) and the horizon row B."""
    tangent, height_m = math.tan(camera.pitch_rad), camera.height_m
    depths_m = distances_m + camera.pole_m
    below_px = camera.row_scale_m_px / depths_m
    by_tangent = below_px * (2 * tangent / (1 + tangent**2) - height_m / depths_m)
    return np.column_stack((by_tangent, below_px, np.ones_like(depths_m)))


def support_distances(distances_m: FloatArray) -> Vector3:
    """Of (N,) distances the nearest, the farthest, and the one whose row is most nearly between theirs."""
    distinct = np.array(distinct_distances(distances_m.tolist()))
    if len(distinct) >= PARAMETER_COUNT:
        inner = distinct[1:-1]
        middle = inner[np.argmin(np.abs(1 / inner - (1 / distinct[0] + 1 / distinct[-1]) / 2))]
        return float(distinct[0]), float(middle), float(distinct[-1])
    if not len(distinct):
        return DEFAULT_SUPPORT_M
    nearest_m = float(distinct[0])
    return nearest_m, 2 * nearest_m, 4 * nearest_m


class _Fit:
    """Least squares over tan(a), log(f_y) and the horizon row; the residuals are in sigmas."""

    def __init__(
        self,
        distances_m: FloatArray,
        rows_px: FloatArray,
        image_size: ImageSize,
        height_m: float,
        row_sigma_px: float | FloatArray,
        priors: Priors,
        level: bool = False,
    ) -> None:
        """`level` adds the prior that the camera looks about straight ahead."""
        self._level = level
        self._distances_m = distances_m
        self._rows_px = rows_px
        self._size = image_size
        self._height_m = float(height_m)
        self._row_sigma_px = np.broadcast_to(row_sigma_px, distances_m.shape)
        self._priors = priors

    def solve(self, near: GroundPlaneCamera | None = None) -> GroundPlaneCamera | None:
        """The camera of least squares; among equally good ones, the one that looks straightest ahead.

        Args:
            near: a camera near the solution; None searches everywhere.

        Returns:
            None if no camera with the points in front of it fits.
        """
        fits = [self._descend(start) for start in (self._starts() if near is None else [_unknowns(near)])]
        fits = [(x, cost) for x, cost in fits if np.all(self._distances_m + self._height_m * x[0] > 0)]
        if not fits:
            return None
        best = min(cost for _, cost in fits)
        # The cost is half of chi squared, so half a unit is one sigma.
        straightest = min((x for x, cost in fits if cost <= best + 0.5), key=lambda x: abs(x[0]))
        return self._camera(straightest)

    def _descend(self, start: FloatArray) -> tuple[FloatArray, float]:
        """The minimum reached from a start, and its cost. MINPACK itself is faster than `least_squares`."""
        from scipy.optimize import leastsq

        outcome = leastsq(
            self.residuals,
            start,
            Dfun=self.jacobian,
            full_output=True,
            ftol=1e-15,
            xtol=1e-15,
            gtol=1e-15,
            maxfev=300,
        )
        x, found = outcome[0], outcome[2]  # pyright: ignore[reportGeneralTypeIssues] - with full_output there are more
        residuals = found["fvec"]
        return x, float(residuals @ residuals) / 2

    def covariance(self, camera: GroundPlaneCamera, support_m: FloatArray) -> FloatArray:
        """(3, 3) covariance of the rows at the support distances, from the information matrix."""
        jacobian = self.jacobian(_unknowns(camera))
        scale = np.linalg.norm(jacobian, axis=0)
        _, singular, right = np.linalg.svd(jacobian / scale, full_matrices=False)
        if len(singular) < PARAMETER_COUNT or singular[-1] < MINIMUM_CONDITION * singular[0]:
            raise UserError(
                "the points and priors together leave the camera undetermined; "
                "add a point at another distance, best far away, or another prior"
            )
        root = row_jacobian(camera, support_m) / scale @ right.T / singular
        return root @ root.T

    def residuals(self, parameters: FloatArray) -> FloatArray:
        """Solution minus measurement in sigmas, first of the rows and then of the priors."""
        camera = self._camera(parameters)
        rows_px = camera.horizon_row_px + camera.row_scale_m_px / (self._distances_m + camera.pole_m)
        rows = (rows_px - self._rows_px) / self._row_sigma_px
        priors = self._priors
        beliefs = (
            (priors.field_of_view_rad, 2 * math.atan2(self._size.width, 2 * camera.focal_y_px)),
            (priors.principal_row_px, camera.principal_row_px),
            (priors.horizon_row_px, camera.horizon_row_px),
        )
        told = [(value - prior.value) / prior.sigma for prior, value in beliefs if prior]
        level = [(parameters[0] - USUAL_TANGENT) / USUAL_TANGENT_SIGMA] * self._level
        return np.concatenate((rows, told, level))

    def jacobian(self, parameters: FloatArray) -> FloatArray:
        """(N, 3) derivatives of the residuals."""
        camera = self._camera(parameters)
        tangent, focal_px = parameters[0], camera.focal_y_px
        half_width = self._size.width / 2
        rows = row_jacobian(camera, self._distances_m) / self._row_sigma_px[:, None]
        priors = self._priors
        gradients = (
            (
                priors.field_of_view_rad,
                (0.0, -2 * half_width * focal_px / (focal_px**2 + half_width**2), 0.0),
            ),
            (priors.principal_row_px, (focal_px, focal_px * tangent, 1.0)),
            (priors.horizon_row_px, (0.0, 0.0, 1.0)),
        )
        beliefs = [np.array(gradient) / prior.sigma for prior, gradient in gradients if prior]
        level = [np.array((1 / USUAL_TANGENT_SIGMA, 0.0, 0.0))] * self._level
        return np.vstack((rows, *beliefs, *level))

    def _camera(self, parameters: FloatArray) -> GroundPlaneCamera:
        tangent, log_focal, horizon_px = (float(value) for value in parameters)
        focal_px = math.exp(min(max(log_focal, -LOG_FOCAL_LIMIT), LOG_FOCAL_LIMIT))
        column_px = (self._size.width - 1) / 2
        return GroundPlaneCamera(
            math.atan(tangent), focal_px, horizon_px + focal_px * tangent, self._height_m, column_px
        )

    def _starts(self) -> list[FloatArray]:
        """The local minima over a grid of pitches; for a given pitch, the rest is linear least squares.

        If only a field of view is given, the sign of the pitch is open, and there are two minima.
        """
        d, priors = self._distances_m, self._priors
        half_width = self._size.width / 2
        tangents = np.tan(START_PITCHES_RAD)
        tangents = tangents[d.min(initial=math.inf) + self._height_m * tangents > 0]
        # The unknowns are f_y and B. For each pitch, each measurement is (coefficients, value) in sigmas.
        systems = np.empty((len(tangents), len(d) + priors.count, 3))
        systems[:, : len(d), 0] = (
            self._height_m * (1 + tangents**2)[:, None] / (d + self._height_m * tangents[:, None])
        )
        systems[:, : len(d), 1] = 1.0
        systems[:, : len(d), 2] = self._rows_px
        systems[:, : len(d)] /= self._row_sigma_px[:, None]
        row = len(d)
        if belief := priors.field_of_view_rad:
            focal_px = half_width / math.tan(belief.value / 2)
            sigma_px = belief.sigma * (focal_px**2 + half_width**2) / (2 * half_width)
            systems[:, row] = (1 / sigma_px, 0.0, focal_px / sigma_px)
            row += 1
        if belief := priors.horizon_row_px:
            systems[:, row] = (0.0, 1 / belief.sigma, belief.value / belief.sigma)
            row += 1
        if belief := priors.principal_row_px:
            systems[:, row, 0] = tangents / belief.sigma
            systems[:, row, 1:] = (1 / belief.sigma, belief.value / belief.sigma)
        coefficients, values = systems[..., :2], systems[..., 2]
        solutions = (np.linalg.pinv(coefficients) @ values[..., None])[..., 0]
        misfits = (coefficients @ solutions[..., None])[..., 0] - values
        ahead = solutions[:, 0] > 0
        costs = [math.inf, *np.sum(misfits[ahead] ** 2, axis=1).tolist(), math.inf]
        starts = np.column_stack((tangents[ahead], np.log(solutions[ahead, 0]), solutions[ahead, 1]))
        minima = [k for k in range(1, len(costs) - 1) if costs[k - 1] >= costs[k] <= costs[k + 1]]
        return [starts[k - 1] for k in sorted(minima, key=lambda k: costs[k])[:START_COUNT]]


def _unknowns(camera: GroundPlaneCamera) -> FloatArray:
    """(3,) unknowns of the fit for a camera."""
    return np.array([math.tan(camera.pitch_rad), math.log(camera.focal_y_px), camera.horizon_row_px])
