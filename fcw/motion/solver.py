"""Motion between two pictures from tracked points: rotation, travel and its direction, and the road's plane.

Everything is in level axes (x right, y down, z forward) of the calibrated camera. A point on a ray q with q_z
= 1 and the inverse depth rho is seen, after the camera moved by t and turned by w, along

    Z = exp(-[w]) (q - rho t)        t = s (a, -b, 1)

(Longuet-Higgins & Prazdny 1980). For the road, rho = n q / h with its normal n = (c, 1, p), so that the flow
of the road tells how far we moved, in units of the camera's height (Kitt, Geiger & Lategahn 2010; Song &
Chandraker 2014). The depth of all other points is a guess with a wide sigma. While we move, such a point only
tells the rotation and the direction, by its motion across its epipolar line; while we stand, its motion along
the line counts too.

The unknowns are w (3), the travel s, and the angles a (yaw of the camera), b (its pitch relative to the
direction of travel), p (its pitch relative to the road) and c (its roll relative to the road). They have a
prior. They are solved for by Gauss-Newton steps with Geman-McClure weights (1987), whose scale shrinks from
coarse to fine.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray
from fcw.kernels.inner import inner_kernel
from fcw.kernels.jit import kernel
from fcw.kernels.linear import eliminate

PITCH_TURN, YAW_TURN, ROLL_TURN, TRAVEL, YAW, PITCH, ROAD_PITCH, ROAD_ROLL = range(8)
"""Indices of the unknowns; the first three are the rotation about x, y and z."""
UNKNOWNS = 8
FAR = 0.005
"""Inverse depth of the far background, 1/m, and its 1-sigma: 200 m."""
OUTLIERS = 0.3
"""Fraction of the points that are expected to be outliers: on other vehicles, their shadows, or the
windscreen."""
ASTRAY = 0.02
"""Area over which outliers are spread, in units of the rays: 8 degrees square."""


class Solution(NamedTuple):
    """The motion between two pictures.

    Attributes:
        unknowns: (8,) most probable unknowns, given prior and points.
        information: (8, 8) information matrix of the points alone.
        inlying: (N,) weight of each point, 0 to 1.
        evidence: log likelihood ratio of the points under this motion and as outliers.
    """

    unknowns: FloatArray
    information: FloatArray
    inlying: FloatArray
    evidence: float


@inner_kernel()
def _accumulate(
    before: FloatArray,
    after: FloatArray,
    road: NDArray[np.bool_],
    inverse_depth: FloatArray,
    depth_sigma: FloatArray,
    place_precision: FloatArray,
    height_m: float,
    scale: float,
    unknowns: FloatArray,
    hessian: FloatArray,
    gradient: FloatArray,
    inlying: FloatArray,
) -> float:  # pragma: no cover - compiled
    """Sum up the weighted normal equations at `unknowns`; returns the evidence, see `Solution`."""
    wx, wy, wz, travel, yaw, pitch, road_pitch, road_roll = unknowns
    tx, ty, tz = travel * yaw, -travel * pitch, travel
    # exp(-[w]) by Rodrigues.
    angle = np.sqrt(wx * wx + wy * wy + wz * wz) + 1e-12
    sine, rest = np.sin(angle) / angle, (1 - np.cos(angle)) / (angle * angle)
    r00, r01, r02 = 1 - rest * (wy * wy + wz * wz), rest * wx * wy + sine * wz, rest * wx * wz - sine * wy
    r10, r11, r12 = rest * wx * wy - sine * wz, 1 - rest * (wx * wx + wz * wz), rest * wy * wz + sine * wx
    r20, r21, r22 = rest * wx * wz + sine * wy, rest * wy * wz - sine * wx, 1 - rest * (wx * wx + wy * wy)
    hessian[:, :] = 0.0
    gradient[:] = 0.0
    jx, jy = np.zeros(UNKNOWNS), np.zeros(UNKNOWNS)
    evidence = 0.0
    for i in range(before.shape[0]):
        qx, qy = before[i, 0], before[i, 1]
        rho = inverse_depth[i]
        if road[i]:
            rho = (road_roll * qx + qy + road_pitch) / height_m
        yx, yy, yz = qx - rho * tx, qy - rho * ty, 1 - rho * tz
        zx, zy, zz = (
            r00 * yx + r01 * yy + r02 * yz,
            r10 * yx + r11 * yy + r12 * yz,
            r20 * yx + r21 * yy + r22 * yz,
        )
        inlying[i] = 0.0
        if zz < 0.05 or (road[i] and rho <= 0):
            continue
        u, v = zx / zz, zy / zz
        # Derivatives by Z: du = (dZx - u dZz) / Zz; and dZ = Z x dw for a rotation.
        # Z x e_x = (0, Zz, -Zy); Z x e_y = (-Zz, 0, Zx); Z x e_z = (Zy, -Zx, 0).
        jx[0], jy[0] = u * zy / zz, 1.0 + v * zy / zz
        jx[1], jy[1] = -1.0 - u * zx / zz, -v * zx / zz
        jx[2], jy[2] = zy / zz, -zx / zz
        # Derivatives by t: dZ = -rho R dt.
        ax, ay = -rho * (r00 - u * r20) / zz, -rho * (r10 - v * r20) / zz
        bx, by = -rho * (r01 - u * r21) / zz, -rho * (r11 - v * r21) / zz
        cx, cy = -rho * (r02 - u * r22) / zz, -rho * (r12 - v * r22) / zz
        jx[3], jy[3] = ax * yaw - bx * pitch + cx, ay * yaw - by * pitch + cy
        jx[4], jy[4] = travel * ax, travel * ay
        jx[5], jy[5] = -travel * bx, -travel * by
        # Derivatives by rho: dZ = -R t drho.
        sx, sy, sz = (
            r00 * tx + r01 * ty + r02 * tz,
            r10 * tx + r11 * ty + r12 * tz,
            r20 * tx + r21 * ty + r22 * tz,
        )
        gx, gy = -(sx - u * sz) / zz, -(sy - v * sz) / zz
        if road[i]:
            jx[6], jy[6] = gx / height_m, gy / height_m
            jx[7], jy[7] = gx * qx / height_m, gy * qx / height_m
            spread = depth_sigma[i] * rho
        else:
            jx[6], jy[6], jx[7], jy[7] = 0.0, 0.0, 0.0, 0.0
            spread = depth_sigma[i]
        ex, ey = after[i, 0] - u, after[i, 1] - v
        # Inverse of the point's covariance plus spread^2 g g' (Sherman & Morrison 1950).
        pxx, pyy, pxy = place_precision[i, 0], place_precision[i, 1], place_precision[i, 2]
        hx, hy = pxx * gx + pxy * gy, pxy * gx + pyy * gy
        widened = 1 + spread * spread * (gx * hx + gy * hy)
        along = spread * spread / widened
        sxx, sxy, syy = pxx - along * hx * hx, pxy - along * hx * hy, pyy - along * hy * hy
        mahalanobis = sxx * ex * ex + 2 * sxy * ex * ey + syy * ey * ey
        weight = 1 / (1 + mahalanobis / (scale * scale))
        weight *= weight
        inlying[i] = weight
        density = np.sqrt((pxx * pyy - pxy * pxy) / widened) / (2 * np.pi) * np.exp(-mahalanobis / 2)
        if not road[i]:
            # Half of the background is assumed to be far away, where it hardly moves due to the travel.
            fx, fy = ex - gx * (FAR - rho), ey - gy * (FAR - rho)
            widened = 1 + FAR * FAR * (gx * hx + gy * hy)
            along = FAR * FAR / widened
            by_far = fx * hx + fy * hy
            mahalanobis = pxx * fx * fx + 2 * pxy * fx * fy + pyy * fy * fy - along * by_far * by_far
            density = density / 2 + np.sqrt((pxx * pyy - pxy * pxy) / widened) / (4 * np.pi) * np.exp(
                -mahalanobis / 2
            )
        evidence += np.log(1 + (1 - OUTLIERS) / OUTLIERS * ASTRAY * density)
        for m in range(UNKNOWNS):
            left_x = weight * (jx[m] * sxx + jy[m] * sxy)
            left_y = weight * (jx[m] * sxy + jy[m] * syy)
            gradient[m] += left_x * ex + left_y * ey
            for n in range(m + 1):
                hessian[m, n] += left_x * jx[n] + left_y * jy[n]
    for m in range(UNKNOWNS):
        for n in range(m):
            hessian[n, m] = hessian[m, n]
    return evidence


@kernel()
def _solve(
    before: FloatArray,
    after: FloatArray,
    road: NDArray[np.bool_],
    inverse_depth: FloatArray,
    depth_sigma: FloatArray,
    place_precision: FloatArray,
    height_m: float,
    prior: FloatArray,
    precision: FloatArray,
    scales: tuple[float, ...],
    unknowns: FloatArray,
    hessian: FloatArray,
    inlying: FloatArray,
) -> float:  # pragma: no cover - compiled
    """The compiled part of `solve`; `precision` is the inverse of the prior's covariance.

    `unknowns` holds the start and becomes the result. `hessian`, `inlying` and the returned evidence are
    those of the last step.
    """
    gradient, matrix = np.empty(UNKNOWNS), np.empty((UNKNOWNS, UNKNOWNS))
    evidence = 0.0
    for scale in scales:
        evidence = _accumulate(
            before,
            after,
            road,
            inverse_depth,
            depth_sigma,
            place_precision,
            height_m,
            scale,
            unknowns,
            hessian,
            gradient,
            inlying,
        )
        for m in range(UNKNOWNS):
            for n in range(UNKNOWNS):
                matrix[m, n] = hessian[m, n] + precision[m, n]
                gradient[m] -= precision[m, n] * (unknowns[n] - prior[n])
        eliminate(matrix, gradient)
        for m in range(UNKNOWNS):
            unknowns[m] += gradient[m]
    return evidence


def solve(
    before: FloatArray,
    after: FloatArray,
    road: NDArray[np.bool_],
    inverse_depth: FloatArray,
    depth_sigma: FloatArray,
    place_precision: FloatArray,
    height_m: float,
    prior: FloatArray,
    prior_covariance: FloatArray,
    scales: tuple[float, ...],
) -> Solution:
    """The motion that explains the points best.

    Args:
        before: (N, 2) rays x / z and y / z in the first picture.
        after: (N, 2) rays in the second picture.
        road: (N,) which points are on the road.
        inverse_depth: (N,) guessed inverse depth of the others, 1/m.
        depth_sigma: (N,) 1-sigma of the inverse depth; for points on the road, relative to it.
        place_precision: (N, 3) xx, yy and xy of the inverse covariance of `after`.
        height_m: height of the camera above the road.
        prior: (8,) mean of the unknowns.
        prior_covariance: (8, 8) covariance of the unknowns.
        scales: scales of the weights, in sigmas, one for each step.
    """
    unknowns, hessian, inlying = prior.copy(), np.empty((UNKNOWNS, UNKNOWNS)), np.empty(len(before))
    precision = np.linalg.inv(prior_covariance)
    points = before, after, road, inverse_depth, depth_sigma, place_precision
    evidence = _solve(*points, height_m, prior, precision, scales, unknowns, hessian, inlying)
    return Solution(unknowns, hessian, inlying, evidence)
