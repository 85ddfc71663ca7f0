"""Whether the period of lane dashes is the one that was said, and what it would change.

Dashes in a picture tell the distance of each in periods. What a period is in metres only the product of
focal length and height tells (`fcw.camera.ground_plane`), so without the lens's field of view 12 m and 18 m
fit as well: the country's rule decides, and countries have several. So each period in use, and dashes that
were passed over, are hypotheses beside what was said; what they would change goes into the interval.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, Priors, matrix3
from fcw.camera.verdicts.evidence import AXIS, LOG_FOCAL, TANGENT, fit, log_sum
from fcw.camera.verdicts.hypotheses import DASH_PERIODS_M, EVEN_PART, Fault, Hypothesis
from fcw.camera.verdicts.judgement import beliefs_of, rows_of

SAID_SHARE, PASSED_SHARE = 0.6, 0.1
"""How often a said period is the true one, and a dash was passed over; guesses about people, not counts."""
FIRST_M = Gaussian(10.0, 6.0)
"""From the camera to the first dash that is seen whole."""
FIRST_SLIP_M = 0.5
"""Of the first distance, where one was said."""
SAME_PERIOD_PART = 0.015
TAPED_M = 5.0
"""Nobody lays a tape to 6, 24 and 42 m; multiples of this are taped as often as paced by dashes."""
TOLD_SPREAD = 0.04
"""A period that leaves distances less uncertain than this is as good as known."""
WIDEST_SPREAD = 0.5
"""Beyond it no interval means anything."""
AT_M = 40.0


@dataclass(frozen=True, slots=True)
class PeriodDoubt:
    """Other periods that the dashes may have.

    Attributes:
        said_m: as it was said.
        other_m: the likeliest other one.
        scale: of distances at `AT_M`, where it is that one.
        sure: probability of what was said.
        spread: standard deviation of the logarithm of distances there, all possibilities together.
    """

    said_m: float
    other_m: float
    scale: float
    sure: float
    spread: float


def dash_period_m(distances_m: Sequence[float], paced: bool = False) -> float | None:
    """The period of evenly spaced distances that may be those of dashes; None of others.

    Args:
        distances_m: as they were said.
        paced: they are said to be dashes.
    """
    gaps_m = [far - near for near, far in pairwise(sorted(distances_m))]
    if len(gaps_m) < 2 or min(gaps_m) <= 0 or max(gaps_m) > (1 + EVEN_PART) * min(gaps_m):
        return None
    period_m = float(np.mean(gaps_m))
    in_use = any(abs(period_m / known_m - 1) < SAME_PERIOD_PART for known_m in DASH_PERIODS_M)
    taped = abs(period_m / TAPED_M - round(period_m / TAPED_M)) * TAPED_M < SAME_PERIOD_PART * period_m
    return period_m if paced or (in_use and not taped) else None


def period_doubt(
    calibration: Calibration, height_sigma_m: float = 0.0, paced: bool = False
) -> PeriodDoubt | None:
    """What else the period of a calibration's points may be; None where they are no dashes, or it is told.

    Args:
        calibration: of points whose distances follow each other evenly.
        height_sigma_m: of its camera's height: what the period follows from is lens and height together.
        paced: the points are said to be dashes, the first distance following from the rest.
    """
    period_m = dash_period_m([point.distance_m for point in calibration.points], paced)
    if period_m is None:
        return None
    straight = calibration.straight()
    points = tuple(sorted(straight.points, key=lambda point: point.distance_m))
    supposed = _hypotheses(points, period_m, calibration.reference_offset_m, paced)
    size, camera = calibration.image_size, straight.camera
    priors = _of_lens_and_height(calibration, height_sigma_m / camera.height_m)
    tapes = [calibration.tape_error]
    beliefs = beliefs_of(supposed, tapes, size, max(calibration.row_sigma_px, 0.1), priors)
    fits = fit(rows_of(points, size, camera.height_m), beliefs)
    log_posterior = fits.log_evidence + np.log([h.share for h in supposed])
    posterior = np.exp(log_posterior - log_sum(log_posterior))
    row_px = camera.row_at(AT_M)
    found_m = []
    for tangent, log_focal, axis_px in fits.unknowns[:, [TANGENT, LOG_FOCAL, AXIS]].tolist():
        focal_px = math.exp(log_focal)
        below_px = row_px - (axis_px - focal_px * tangent)
        scale = camera.height_m * focal_px * (1 + tangent**2)
        # A hypothesis that has the sky there has hardly any share; it counts as far away.
        far_m = scale / max(below_px, 1.0) - camera.height_m * tangent
        found_m.append(max(far_m, 1.0))
    logs = np.log(np.array(found_m) / found_m[0])
    spread = math.sqrt(float(posterior @ logs**2))
    if spread < TOLD_SPREAD:
        return None
    other = int(np.argmax(posterior * np.abs(logs)))
    return PeriodDoubt(
        period_m,
        supposed[other].period_m or period_m,
        math.exp(logs[other]),
        float(posterior[0]),
        min(spread, WIDEST_SPREAD),
    )


def widened(calibration: Calibration, doubt: PeriodDoubt | None) -> Calibration:
    """The calibration with the doubt in its intervals: an error of all distances together, as a tape's is."""
    if doubt is None:
        return calibration
    support_m = np.array(calibration.support_distances_m)
    slopes = calibration.camera.row_slope_at(support_m + calibration.reference_offset_m)
    moved_px = doubt.spread * support_m * slopes
    covariance = np.array(calibration.covariance) + np.outer(moved_px, moved_px)
    return replace(calibration, covariance=matrix3(covariance))


def _hypotheses(
    points: Sequence[GroundPoint], period_m: float, offset_m: float, paced: bool
) -> list[Hypothesis]:
    """As said first; then each other period, and each place where dashes may have been passed over."""
    said = [point.distance_m for point in points]
    first_m = said[0]
    start = (FIRST_M.value, FIRST_M.sigma) if paced else (first_m + offset_m, FIRST_SLIP_M)
    free = (FIRST_M.value, FIRST_M.sigma)
    steps = np.arange(len(said), dtype=float)

    def of(share: float, steps: np.ndarray, other_m: float, where: tuple[float, float]) -> Hypothesis:
        distances_m = tuple(float(step * other_m) for step in steps)
        return Hypothesis(Fault.DASHES, share, distances_m, offset_m=where, period_m=other_m)

    others = [m for m in DASH_PERIODS_M if abs(m / period_m - 1) > SAME_PERIOD_PART]
    left = 1 - SAID_SHARE - PASSED_SHARE
    all_of = [of(SAID_SHARE, steps, period_m, start)]
    all_of += [of(left / len(others), steps, other_m, free) for other_m in others]
    passed = [steps + (steps >= k) for k in range(1, len(said))] + [2 * steps]
    all_of += [of(PASSED_SHARE / len(passed), jumps, period_m, free) for jumps in passed]
    return all_of


def _of_lens_and_height(calibration: Calibration, height_part: float) -> Priors:
    """What is known of the lens, with the height's error in it: only their product tells."""
    stated, assumed = calibration.priors, calibration.assumed
    view = stated.field_of_view_rad or assumed.field_of_view_rad
    axis = stated.principal_row_px or assumed.principal_row_px
    if calibration.lens is not None:
        width = calibration.image_size.width
        view = Gaussian(2 * math.atan(width / 2 / calibration.lens.focal_x_px), 0.01)
        axis = Gaussian(calibration.lens.row_px, 3.0)
    if view is not None:
        view = Gaussian(view.value, math.hypot(view.sigma, math.sin(view.value) * height_part))
    return Priors(view, axis, stated.horizon_row_px)
