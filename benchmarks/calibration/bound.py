"""How near calibration comes to what no estimator can beat: the median error at 40 m.

    python benchmarks/calibration/bound.py [--trials 1000]

The same random cameras, marks, clicks and tape as in `verdicts.py`. The bound knows how they were drawn: the
median of the posterior of what the row at 40 m reads, by importance sampling about the fit, with the
population's own distributions of fields of view, pitches and axes as prior. No estimate errs by less in the
mean. Calibration knows weak beliefs that were fitted to neither population.
"""

import argparse
import math
import sys
from collections.abc import Callable

import numpy as np
from random_cameras import CHOSEN_ON, OTHER, SIZE, Mistakes, Population, clicked

from fcw.camera.calibration import GroundPoint
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.prior_sigmas import PRINCIPAL_ROW_SIGMA_HEIGHTS, TAPE_ERROR
from fcw.camera.solve import calibrate

AT_M = 40.0
SAMPLES = 4000
FREEDOM, WIDENED = 5, 1.3
"""Of the t distribution that is sampled, and how much wider than the fit's own it is."""
MIDDLE_PX = (SIZE.height - 1) / 2
STEPS = (1e-6, 1e-6, 1e-3, 1e-6)
USUAL = ((0.07, 0.12), (6.6, 0.6), (MIDDLE_PX, PRINCIPAL_ROW_SIGMA_HEIGHTS * SIZE.height), (1.0, TAPE_ERROR))
"""Of tan(a), log(f), v0 and the tape's scale, where the samples are centred; the weights undo it."""


def main() -> None:
    """Print a line for each set of marks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=1000)
    trials = parser.parse_args().trials
    for population in (CHOSEN_ON, OTHER):
        for name, distances_m in population.marks_m.items():
            rng, sampling = np.random.default_rng(1), np.random.default_rng(2)
            ours, best = [], []
            for _ in range(trials):
                camera = population.seeing(rng, min(distances_m))
                points = clicked(rng, camera, distances_m, Mistakes(TAPE_ERROR))
                found = calibrate(points, SIZE, camera.height_m)
                ours.append(abs(found.distance_at(camera.row_at(AT_M)) / AT_M - 1))
                best.append(abs(_best_m(population, camera, points, sampling) / AT_M - 1))
            sys.stdout.write(
                f"{population.name:10} {name:14} median error at {AT_M:g} m {np.median(ours):5.1%}, "
                f"of the bound {np.median(best):5.1%}\n"
            )
            sys.stdout.flush()


def _best_m(
    population: Population,
    camera: GroundPlaneCamera,
    points: tuple[GroundPoint, ...],
    rng: np.random.Generator,
) -> float:
    """The posterior's median of the distance that the row at `AT_M` shows."""
    height_m = camera.height_m
    distances_m = np.array([point.distance_m for point in points])
    rows_px = np.array([point.row_px for point in points])
    means, sigmas = np.transpose(USUAL)

    def residuals(x: FloatArray) -> FloatArray:
        return np.concatenate((_rows(x, distances_m, height_m) - rows_px, (x - means) / sigmas))

    x = np.array([math.tan(camera.pitch_rad), math.log(camera.focal_y_px), camera.principal_row_px, 1.0])
    for _ in range(20):
        jacobian = _jacobian(residuals, x)
        step = np.asarray(np.linalg.solve(jacobian.T @ jacobian, jacobian.T @ residuals(x)), np.float64)
        while np.sum(residuals(x - step) ** 2) > np.sum(residuals(x) ** 2) + 1e-9:
            step = step / 2
        x = np.asarray(x - step, np.float64)
    jacobian = _jacobian(residuals, x)
    root = WIDENED * np.linalg.cholesky(np.linalg.inv(jacobian.T @ jacobian))
    drawn = rng.standard_normal((SAMPLES, 4)) / np.sqrt(rng.chisquare(FREEDOM, SAMPLES) / FREEDOM)[:, None]
    samples = x + drawn @ root.T
    log_drawn = -(FREEDOM + 4) / 2 * np.log1p(np.sum(drawn**2, axis=1) / FREEDOM)
    misfits = _rows(samples, distances_m, height_m) - rows_px
    log_weights = _log_prior(population, samples, height_m, min(distances_m)) - log_drawn
    log_weights -= np.sum(misfits**2, axis=1) / 2
    tangents, focal_px = samples[:, 0], np.exp(samples[:, 1])
    below_px = camera.row_at(AT_M) - (samples[:, 2] - focal_px * tangents)
    seen_m = np.full(SAMPLES, math.inf)
    scale = focal_px * height_m * (1 + tangents**2)
    np.divide(scale, below_px, out=seen_m, where=below_px > 0)
    seen_m -= height_m * tangents
    order = np.argsort(seen_m)
    shares = np.cumsum(np.exp(log_weights - log_weights.max())[order])
    return float(seen_m[order][np.searchsorted(shares, shares[-1] / 2)])


def _rows(x: FloatArray, distances_m: FloatArray, height_m: float) -> FloatArray:
    """(..., N) rows of N distances by (..., 4) tan(a), log(f), v0 and the tape's scale."""
    tangent, log_focal, axis_px, scale = (x[..., k, None] for k in range(4))
    focal_px, depths_m = np.exp(log_focal), distances_m * scale + height_m * tangent
    return axis_px - focal_px * tangent + focal_px * height_m * (1 + tangent**2) / np.maximum(depths_m, 0.1)


def _jacobian(residuals: Callable[[FloatArray], FloatArray], x: FloatArray) -> FloatArray:
    steps = np.diag(STEPS)
    return np.column_stack([(residuals(x + step) - residuals(x - step)) / (2 * step.sum()) for step in steps])


def _log_prior(population: Population, x: FloatArray, height_m: float, nearest_m: float) -> FloatArray:
    """(S,) of the population's own draws (`random_cameras`), by tan(a), log(f), v0 and the tape's scale."""
    tangents, axes_px, focal_px = x[:, 0], x[:, 2], np.exp(x[:, 1])
    half_px = SIZE.width / 2
    views_deg, pitches_deg = 2 * np.degrees(np.arctan(half_px / focal_px)), np.degrees(np.arctan(tangents))
    log_density = -(((x[:, 3] - 1) / TAPE_ERROR) ** 2) / 2
    log_density += np.log(focal_px / (focal_px**2 + half_px**2)) - np.log1p(tangents**2)
    off = (axes_px - MIDDLE_PX) / SIZE.height
    if population is CHOSEN_ON:
        log_density -= (off / 0.03) ** 2 / 2
        drawn = (views_deg >= 45) & (views_deg <= 110) & (pitches_deg >= -2) & (pitches_deg <= 10)
    else:
        log_density -= 2.5 * np.log1p((off / 0.02) ** 2 / 4) + ((pitches_deg - 2.5) / 4) ** 2 / 2
        log_density -= np.log(views_deg)
        drawn = (views_deg >= 40) & (views_deg <= 115)
    nearest = np.column_stack((x[:, :3], np.ones(len(x))))
    drawn &= _rows(nearest, np.array([nearest_m]), height_m)[:, 0] <= SIZE.height - 0.5
    drawn &= axes_px > focal_px * tangents
    return np.where(drawn, log_density, -math.inf)


if __name__ == "__main__":
    main()
