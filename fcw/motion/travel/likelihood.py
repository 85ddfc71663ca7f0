"""How likely two pictures are, for every direction of travel that they may have been driven in.

A camera that drives towards the ray e and turns by w sees a point on the ray q = (x, y, 1) move by

    A(q) w + r (q - e),    r > 0

(Longuet-Higgins & Prazdny 1980): away from e, by an amount that hangs on how near the point is, and besides
by what the turn alone makes of its place. So what is left of a movement without the turn points away from e;
across that, it is noise. For each e the turn is found under which that noise is least, by weights of Geman &
McClure (1987).
"""

import math

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.kernels.jit import kernel

SCALES = (8.0, 4.0, 2.5)
"""Of the weights, in sigmas, one for each step."""
OUTLIERS = 0.3
"""This part of the points may be anywhere: on vehicles, their shadows, on the windscreen."""
ASTRAY_PX = 40.0
"""Anywhere in a width so large."""
BACK_SIGMAS = 3.0
"""What flows in by more flows out of no direction: it is astray."""


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
    """As `log_likelihoods`; all lengths are in units of the rays."""
    turn, step = np.zeros(3), np.zeros(3)
    slopes = np.zeros(3)
    hessian, gradient = np.zeros((3, 3)), np.zeros(3)
    by_turn = np.zeros((2, 3))
    for k in range(directions.shape[0]):
        turn[:] = 0.0
        found[k] = 0.0
        for stage in range(len(SCALES) + 1):
            hessian[:, :] = 0.0
            for m in range(3):
                hessian[m, m] = turn_precision[m]
                gradient[m] = -turn_precision[m] * turn[m]
            for i in range(before.shape[0]):
                x, y = before[i, 0], before[i, 1]
                by_turn[0, 0], by_turn[0, 1], by_turn[0, 2] = x * y, -(1 + x * x), y
                by_turn[1, 0], by_turn[1, 1], by_turn[1, 2] = 1 + y * y, -x * y, -x
                out_x, out_y = x - directions[k, 0], y - directions[k, 1]
                length = math.sqrt(out_x * out_x + out_y * out_y) + 1e-9
                out_x, out_y = out_x / length, out_y / length
                left_x, left_y = after[i, 0] - x, after[i, 1] - y
                for m in range(3):
                    left_x -= by_turn[0, m] * turn[m]
                    left_y -= by_turn[1, m] * turn[m]
                    slopes[m] = (out_x * by_turn[1, m] - out_y * by_turn[0, m]) / place_sigma
                across = (out_x * left_y - out_y * left_x) / place_sigma
                is_back = (out_x * left_x + out_y * left_y) / place_sigma < -BACK_SIGMAS
                if stage == len(SCALES):
                    density = 0.0 if is_back else math.exp(-across * across / 2) / math.sqrt(2 * math.pi)
                    found[k] += math.log((1 - OUTLIERS) * density + OUTLIERS * place_sigma / astray)
                elif not is_back:
                    weight = 1 / (1 + across * across / (SCALES[stage] * SCALES[stage]))
                    weight *= weight
                    for m in range(3):
                        gradient[m] += weight * slopes[m] * across
                        for n in range(3):
                            hessian[m, n] += weight * slopes[m] * slopes[n]
            if stage < len(SCALES):
                step[:] = np.linalg.solve(hessian, gradient)
                turn += step
        for m in range(3):
            found[k] -= turn_precision[m] * turn[m] * turn[m] / 2


def log_likelihoods(
    before: FloatArray,
    after: FloatArray,
    directions: FloatArray,
    turn_sigmas_rad: FloatArray,
    place_sigma: float,
    focal_px: float,
) -> FloatArray:
    """(K,) up to a constant, each with the likeliest turn between the pictures.

    Args:
        before: (N, 2) rays x / z and y / z of the points in the first picture.
        after: (N, 2) of the same points in the second.
        directions: (K, 2) rays.
        turn_sigmas_rad: (3,) how far the camera may have turned between them about x, y and z.
        place_sigma: 1-sigma of a point's movement across its way, in pixels.
        focal_px: focal length.
    """
    found = np.empty(len(directions))
    _log_likelihoods(
        before,
        after,
        directions,
        turn_sigmas_rad**-2,
        place_sigma / focal_px,
        ASTRAY_PX / focal_px,
        found,
    )
    return found
