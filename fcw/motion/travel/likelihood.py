"""Likelihood of the motion between two pictures, for each of several directions of travel.

A camera that drives towards the ray e and turns by w sees a point on the ray q = (x, y, 1) move by

    A(q) w + r (q - e),    r > 0

(Longuet-Higgins & Prazdny 1980). The second term points away from e, by an amount that depends on the
distance of the point; the first is the effect of the rotation. So without the rotation, the motion of a point
is away from e, and any motion across that direction is noise. For each e, the rotation that minimises this
noise is found, with Geman-McClure weights (1987).
"""

import math

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.kernels.jit import kernel

SCALES = (8.0, 4.0, 2.5)
"""Scales of the weights, in sigmas, one for each step."""
OUTLIERS = 0.3
"""Fraction of the points that are expected to be outliers: on vehicles, their shadows, or the windscreen."""
ASTRAY_PX = 40.0
"""Width over which outliers are spread."""
BACK_SIGMAS = 3.0
"""A point that moves towards e by more than this is an outlier."""


@kernel()
def _log_likelihoods(
    before: FloatArray,
    after: FloatArray,
    directions: FloatArray,
    turn_precision: FloatArray,
    place_sigma: float,
    astray: float,
    found: FloatArray,
) -> None:  # pragma: no cover - compiled
    """The compiled part of `log_likelihoods`; all lengths are in units of the rays, and points are (2, N).

    Sums are scalars, and the loop over points has no branches, so that LLVM vectorises it.
    """
    points = before.shape[1]
    across, is_on = np.empty(points), np.empty(points)
    p0, p1, p2 = turn_precision[0], turn_precision[1], turn_precision[2]
    for k in range(directions.shape[0]):
        column, row = directions[k, 0], directions[k, 1]
        w0 = w1 = w2 = 0.0
        for stage in range(len(SCALES) + 1):
            scale = SCALES[min(stage, len(SCALES) - 1)]
            h00, h11, h22, h01, h02, h12 = p0, p1, p2, 0.0, 0.0, 0.0
            g0, g1, g2 = -p0 * w0, -p1 * w1, -p2 * w2
            for i in range(points):
                x, y = before[0, i], before[1, i]
                away_x, away_y = x - column, y - row
                length = (math.sqrt(away_x * away_x + away_y * away_y) + 1e-9) * place_sigma
                out_x, out_y = away_x / length, away_y / length
                left_x = after[0, i] - x - x * y * w0 + (1 + x * x) * w1 - y * w2
                left_y = after[1, i] - y - (1 + y * y) * w0 + x * y * w1 + x * w2
                off = out_x * left_y - out_y * left_x
                on = 0.0 if out_x * left_x + out_y * left_y < -BACK_SIGMAS else 1.0
                across[i], is_on[i] = off, on
                s0 = out_x * (1 + y * y) - out_y * x * y
                s1 = -out_x * x * y + out_y * (1 + x * x)
                s2 = -out_x * x - out_y * y
                weight = 1 / (1 + off * off / (scale * scale))
                weight *= weight * on
                g0 += weight * s0 * off
                g1 += weight * s1 * off
                g2 += weight * s2 * off
                h00 += weight * s0 * s0
                h11 += weight * s1 * s1
                h22 += weight * s2 * s2
                h01 += weight * s0 * s1
                h02 += weight * s0 * s2
                h12 += weight * s1 * s2
            if stage < len(SCALES):
                # LDL' decomposition: the matrix is positive definite.
                l10, l20 = h01 / h00, h02 / h00
                d1 = h11 - l10 * h01
                l21 = (h12 - l20 * h01) / d1
                d2 = h22 - l20 * h02 - l21 * l21 * d1
                z1 = g1 - l10 * g0
                step2 = (g2 - l20 * g0 - l21 * z1) / d2
                step1 = z1 / d1 - l21 * step2
                w0 += g0 / h00 - l10 * step1 - l20 * step2
                w1 += step1
                w2 += step2
        log = 0.0
        for i in range(points):
            density = is_on[i] * math.exp(-across[i] * across[i] / 2) / math.sqrt(2 * math.pi)
            log += math.log((1 - OUTLIERS) * density + OUTLIERS * place_sigma / astray)
        found[k] = log - (p0 * w0 * w0 + p1 * w1 * w1 + p2 * w2 * w2) / 2


def log_likelihoods(
    before: FloatArray,
    after: FloatArray,
    directions: FloatArray,
    turn_sigmas_rad: FloatArray,
    place_sigma: float,
    focal_px: float,
) -> FloatArray:
    """(K,) log likelihoods up to a constant, each for the likeliest rotation between the pictures.

    Args:
        before: (N, 2) rays x / z and y / z of the points in the first picture.
        after: (N, 2) rays of the same points in the second picture.
        directions: (K, 2) rays of the directions of travel.
        turn_sigmas_rad: (3,) 1-sigma of the camera's rotation between them about x, y and z.
        place_sigma: 1-sigma of a point's motion across its direction, in pixels.
        focal_px: focal length.
    """
    found = np.empty(len(directions))
    _log_likelihoods(
        np.ascontiguousarray(before.T, float),
        np.ascontiguousarray(after.T, float),
        directions,
        turn_sigmas_rad**-2,
        place_sigma / focal_px,
        ASTRAY_PX / focal_px,
        found,
    )
    return found
