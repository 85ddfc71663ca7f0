"""What is said of marks with columns, as the page has them, before level and tilted cameras.

    python benchmarks/calibration/tilted.py [--trials 200]

Random plausible cameras of two populations (`random_cameras`), marks to the sides of the middle, clicks good
to 1 px, a tape to 1 %. Accused is who is told that something is wrong, asked who is asked whether it is; a
tilt that is told of and taken into account is neither. A tilt can be told where the points' likelihood with a
roll is twenty times that without.
"""

import argparse
import math
import sys
from collections import Counter
from dataclasses import replace

import numpy as np
from random_cameras import CHOSEN_ON, OTHER, SIZE, Mistakes, Population, clicked_beside

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, Priors
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.plausibility import FindingKind, plausibility
from fcw.camera.points import PointsError
from fcw.camera.prior_sigmas import ROLL_SIGMA_RAD, TAPE_ERROR
from fcw.camera.solve import calibrate
from fcw.camera.verdicts.evidence import ROLL, fit, log_sum
from fcw.camera.verdicts.hypotheses import Fault, hypotheses
from fcw.camera.verdicts.judgement import CAREFUL, TAPE_SCALES, beliefs_of, rows_of
from fcw.camera.verdicts.tilt import tilted_instead
from fcw.errors import UserError

Points = tuple[GroundPoint, ...]
HEIGHT_SIGMA = 0.02
TELLING_RATIO = 20.0
PLACES_M = (10.0, 20.0, 40.0)
LEVEL_SIGMA = 1e-6


def main() -> None:
    """Print a line for each set of marks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=200)
    options = parser.parse_args()
    for population in (CHOSEN_ON, OTHER):
        sys.stdout.write(f"{population.name.upper()}, {options.trials} each\n")
        for name in population.marks_m:
            for side_m, roll_deg in ((0.1, None), (1.0, None), (1.0, 2.0), (1.0, -4.0)):
                _report(population, name, side_m, roll_deg, options.trials)


def _report(population: Population, name: str, side_m: float, roll_deg: float | None, trials: int) -> None:
    rng, counts, misses, inside = np.random.default_rng(1), Counter[str](), [], np.zeros(len(PLACES_M))
    distances_m = population.marks_m[name]
    for _ in range(trials):
        camera = population.seeing(rng, min(distances_m))
        roll_rad = ROLL_SIGMA_RAD * rng.standard_normal() if roll_deg is None else math.radians(roll_deg)
        points = clicked_beside(rng, camera, distances_m, Mistakes(TAPE_ERROR), roll_rad, side_m)
        while not all(map(_is_seen, points)):
            camera = population.seeing(rng, min(distances_m))
            points = clicked_beside(rng, camera, distances_m, Mistakes(TAPE_ERROR), roll_rad, side_m)
        telling = roll_deg is not None and _tilt_is_told(points, camera.height_m)
        counts["can be told"] += telling
        try:
            calibration = _calibrated(points, camera.height_m)
        except UserError:
            counts["refused"] += 1
            misses.append(math.inf)
            continue
        findings = plausibility(calibration)
        against = [finding for finding in findings if finding.speaks_against]
        tilt = any(finding.kind is FindingKind.ROLL for finding in findings)
        counts["accused"] += bool(against)
        counts["asked"] += not against and any(finding.is_question for finding in findings)
        counts["right"] += telling and tilt and not against
        counts["wrong"] += any(finding.suspicion is not None for finding in against)
        misses.append(abs(calibration.distance_at(camera.row_at(40.0)) / 40 - 1))
        for place, distance_m in enumerate(PLACES_M):
            low_m, high_m = calibration.distance_interval(camera.row_at(distance_m))
            inside[place] += low_m <= distance_m <= high_m
    rolled = "usual" if roll_deg is None else f"{roll_deg:+.0f}"
    told = ""
    if roll_deg is not None:
        right = counts["right"] / max(counts["can be told"], 1)
        told = f"  can be told {counts['can be told'] / trials:4.0%}, right {right:4.0%}"
    parts = "  ".join(f"{part:4.0%}" for part in inside / trials)
    sys.stdout.write(
        f"{name:14} {side_m:3.1f} m aside, roll {rolled:5}  refused {counts['refused'] / trials:5.1%}  "
        f"accused {counts['accused'] / trials:5.1%}, of a mistake {counts['wrong'] / trials:5.1%}  "
        f"asked {counts['asked'] / trials:5.1%}  at 40 m {np.median(misses):5.1%}  inside {parts}{told}\n"
    )
    sys.stdout.flush()


def _is_seen(point: GroundPoint) -> bool:
    """Nobody clicks a mark outside the picture."""
    inside = -0.5 <= (point.column_px or 0.0) <= SIZE.width - 0.5
    return inside and -0.5 <= point.row_px <= SIZE.height - 0.5


def _calibrated(points: Points, height_m: float) -> Calibration:
    """As the page and the command line do it."""
    known = Known(Evidence(points), SIZE, Gaussian(height_m, HEIGHT_SIGMA * height_m))
    try:
        calibrate(points, SIZE, height_m)
    except PointsError as error:
        return tilted_instead(known, error)
    return calibrate_jointly(known)


def _tilt_is_told(points: Points, height_m: float) -> bool:
    """Whether the points are twenty times as likely with a roll as without, whatever the tape was."""
    said = [h for h in hypotheses(points, 0.0) if h.fault is Fault.NONE]
    beliefs = beliefs_of(said, [TAPE_ERROR * scale for scale in TAPE_SCALES], SIZE, 1.0, Priors())
    sigmas = beliefs.sigmas.copy()
    sigmas[:, ROLL] = LEVEL_SIGMA
    rows = rows_of(points, SIZE, height_m)
    tilted, level = (
        float(log_sum(fit(rows, of).log_evidence + np.log(CAREFUL)))
        for of in (beliefs, replace(beliefs, sigmas=sigmas))
    )
    return tilted - level > math.log(TELLING_RATIO)


if __name__ == "__main__":
    main()
