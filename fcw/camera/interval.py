"""Percentiles of the distance at a row, in closed form.

Four pairs (distance, row) lie on one projective map if the determinant of their rows [1, d, v, d v] is zero.
Take three support pairs, whose rows v_i have the calibration's uncertainty, and the pair (x, v). Their
determinant g is linear in x, and it is positive if the road at row v is farther away than x. It is
multilinear in the four rows, and therefore close to normal even if pitch, focal length and horizon are not.
So

    P(distance > x) = Phi(g(x) / sd(g(x)))

and the percentiles are the roots of a quadratic (Fieller's theorem for a ratio of normals). Unlike a
first-order sigma, they are skewed at far distances and unbounded beyond the horizon.
"""

import math
from dataclasses import dataclass

import numpy as np

from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera

Vector3 = tuple[float, float, float]
Vector4 = tuple[float, float, float, float]

PERCENTILE_84_SIGMAS = 0.994457883209753
"""The 84th percentile of the standard normal; its negative is the 16th."""
COFACTOR_SIGNS = np.array((-1.0, 1.0, -1.0, 1.0))
OTHER_COLUMNS = np.array(((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)))
"""The columns of a (3, 4) matrix that are left when each one in turn is taken out."""


@dataclass(frozen=True, slots=True, eq=False)
class UncertainRowMap:
    """The row map v = B + K / (d + C), and the derivatives of g for its uncertainty.

    Up to a constant factor, g = K - (v - B) (x + C).

    Attributes:
        horizon_row_px: B.
        row_scale_m_px: K.
        pole_m: C.
        gradient: (3, 4) derivatives of g by the support rows: coefficients of 1, x, w and x w, w = v - B.
        whitened: the gradient times a square root of the rows' covariance. They are plain floats because
            they are read for each detection of each frame.
    """

    horizon_row_px: float
    row_scale_m_px: float
    pole_m: float
    gradient: FloatArray
    whitened: tuple[Vector4, ...]

    @classmethod
    def of(
        cls,
        camera: GroundPlaneCamera,
        support_distances_m: FloatArray,
        covariance: FloatArray,
        clicked: bool = True,
    ) -> "UncertainRowMap":
        """Make the map from a camera, three distances, and the covariance of the rows there.

        Args:
            camera: the camera.
            support_distances_m: (3,) distances from the camera.
            covariance: (3, 3) covariance of the rows at these distances.
            clicked: whether rows were measured, so that they are normal. If nothing was clicked, the lens and
                the height are known instead, and g = K - (v - B) (x + C) is used, which is linear in B, K and
                C. The determinant would be biased if the focal length is known only to a third.
        """
        depths_m = support_distances_m + camera.pole_m
        below_px = camera.row_scale_m_px / depths_m
        if not clicked:
            by = np.column_stack((np.ones(3), 1 / depths_m, -below_px / depths_m))
            horizon, scale, pole = np.linalg.inv(by)
            none = np.zeros(3)
            linear = np.column_stack((scale + camera.pole_m * horizon, horizon, -pole, none))
            return cls._whitened(camera, linear, covariance)
        pairs = np.column_stack((np.ones(3), support_distances_m, below_px, support_distances_m * below_px))
        scale = _cofactors(pairs)[3]
        gradient = np.empty((3, 4))
        for index, distance_m in enumerate(support_distances_m):
            moved = pairs.copy()
            moved[index] = 0.0, 0.0, 1.0, distance_m
            gradient[index] = -_cofactors(moved) / scale
        return cls._whitened(camera, gradient, covariance)

    @classmethod
    def _whitened(
        cls, camera: GroundPlaneCamera, gradient: FloatArray, covariance: FloatArray
    ) -> "UncertainRowMap":
        values, vectors = np.linalg.eigh(covariance)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        whitened = tuple(
            (float(row[0]), float(row[1]), float(row[2]), float(row[3])) for row in root.T @ gradient
        )
        return cls(camera.horizon_row_px, camera.row_scale_m_px, camera.pole_m, gradient, whitened)


def distance_interval(row_map: UncertainRowMap, row_px: float, row_sigma_px: float) -> tuple[float, float]:
    """16th and 84th percentile of the distance from the camera at a row; inf if unbounded.

    Args:
        row_map: the uncertain map.
        row_px: the row.
        row_sigma_px: standard deviation of the independent noise of the row itself.
    """
    z2 = PERCENTILE_84_SIGMAS**2
    pole_m = row_map.pole_m
    below_px = row_px - row_map.horizon_row_px
    constant, slope = row_map.row_scale_m_px - pole_m * below_px, -below_px
    noise = row_sigma_px * row_sigma_px
    # var g(x) = variance_1 + 2 variance_x x + variance_xx x^2; dg/dv = -(x + C).
    variance_1, variance_x, variance_xx = noise * pole_m * pole_m, noise * pole_m, noise
    for g_1, g_x, g_w, g_xw in row_map.whitened:
        at_1, at_x = g_1 + g_w * below_px, g_x + g_xw * below_px
        variance_1 += at_1 * at_1
        variance_x += at_1 * at_x
        variance_xx += at_x * at_x
    # Solve g(x)^2 = z^2 var g(x), that is a x^2 + 2 b x + c = 0.
    a = slope * slope - z2 * variance_xx
    b = constant * slope - z2 * variance_x
    c = constant * constant - z2 * variance_1
    if a > 0:
        if below_px <= 0:
            return math.inf, math.inf
        root = math.sqrt(max(b * b - a * c, 0.0))
        return (c / (root - b) if b < 0 else (-b - root) / a), (root - b) / a
    if variance_xx == 0:
        return math.inf, math.inf
    # The noise reaches the horizon: there is no upper end, and no lower one either if nothing is known.
    if b * b > a * c:
        root = math.sqrt(b * b - a * c)
        low_m = c / (root - b) if b < 0 else (-b - root) / a
        if constant + slope * low_m > 0:
            return low_m, math.inf
    return -pole_m, math.inf


def row_gradients(row_map: UncertainRowMap, distances_m: FloatArray) -> FloatArray:
    """(N, 3) derivatives of the rows at N distances from the camera by the rows at the support distances."""
    depths_m = distances_m + row_map.pole_m
    below_px = row_map.row_scale_m_px / depths_m
    # Implicit differentiation of g = 0; g decreases by x + C for each row downwards.
    pairs = np.array([np.ones_like(depths_m), distances_m, below_px, distances_m * below_px])
    return (row_map.gradient @ pairs / depths_m).T


def _cofactors(pairs: FloatArray) -> FloatArray:
    """Cofactors of the fourth row of a (4, 4) matrix, from its first three rows (3, 4)."""
    return COFACTOR_SIGNS * np.linalg.det(pairs[:, OTHER_COLUMNS].transpose(1, 0, 2))
