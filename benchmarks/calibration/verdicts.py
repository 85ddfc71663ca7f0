"""How often calibration accuses the innocent, names true mistakes, errs at 40 m, and holds its intervals.

    python benchmarks/calibration/verdicts.py [--trials 500] [--faults 200]

Random plausible cameras of two populations (`random_cameras`), clicks good to 1 px; the thresholds were
chosen on the first. Accused is who is told that something is wrong; asked is who is told what would be wrong
if the marks were laid with care. The data can tell a mistake where its likelihood is twenty times that of
what was said.
"""

import argparse
import math
import platform
import sys
from collections import Counter
from collections.abc import Callable

import numpy as np
from random_cameras import CHOSEN_ON, OTHER, SIZE, Mistakes, Population, clicked

from fcw.camera.calibration import GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.plausibility import plausibility
from fcw.camera.solve import calibrate
from fcw.camera.verdicts.hypotheses import SHARES, Fault
from fcw.camera.verdicts.judgement import Judgement, judge_points
from fcw.errors import UserError

Points = tuple[GroundPoint, ...]
TELLING_RATIO = 20.0
DASH_PERIOD_M = 18.0


def say(text: str) -> None:
    """A line of the report."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=500)
    parser.add_argument("--faults", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    say(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}")
    for population in (CHOSEN_ON, OTHER):
        say(
            f"\n{population.name.upper()}: of {options.trials} innocents, at 10, 20, 40 m inside the interval"
        )
        say("marks          tape (each)   accused   asked   error at 40 m   10 m   20 m   40 m")
        for name in population.marks_m:
            for mistakes in (Mistakes(), Mistakes(0.01), Mistakes(0.01, 0.01)):
                rng = np.random.default_rng(options.seed)
                _innocents(rng, population, name, mistakes, options.trials)
        say(f"of {options.faults} with a mistake: those that can be told, named rightly; all, named wrongly")
        for kind, make in MISTAKES.items():
            for name in population.marks_m:
                rng = np.random.default_rng(options.seed)
                _guilty(rng, kind, make, (population, name), options.faults)
        say("dash ends said to be at 24, 6 and 42 m, with a true period of 18 m:")
        _dashes(np.random.default_rng(options.seed), population, options.faults)


def _innocents(
    rng: np.random.Generator,
    population: Population,
    name: str,
    mistakes: Mistakes,
    trials: int,
) -> None:
    distances_m = population.marks_m[name]
    accused, asked, misses, inside = 0, 0, [], np.zeros(3)
    for _ in range(trials):
        camera = population.seeing(rng, min(distances_m))
        try:
            calibration = calibrate(clicked(rng, camera, distances_m, mistakes), SIZE, camera.height_m)
        except UserError:
            accused += 1
            misses.append(math.inf)
            continue
        findings = plausibility(calibration)
        guilty = any(not finding.is_question for finding in findings)
        accused += guilty
        asked += bool(findings) and not guilty
        misses.append(abs(calibration.distance_at(camera.row_at(40.0)) / 40 - 1))
        for place, distance_m in enumerate((10.0, 20.0, 40.0)):
            low_m, high_m = calibration.distance_interval(camera.row_at(distance_m))
            inside[place] += low_m <= distance_m <= high_m
    parts = "  ".join(f"{part:5.1%}" for part in inside / trials)
    say(
        f"{name:14} {mistakes.tape:4.0%} ({mistakes.uneven:.0%})     {accused / trials:7.1%} "
        f"{asked / trials:7.1%}  {np.median(misses):12.1%}   {parts}"
    )


def _bumper(
    rng: np.random.Generator, population: Population, distances_m: tuple[float, ...]
) -> tuple[GroundPlaneCamera, Points]:
    offset_m = rng.uniform(1.6, 2.4)
    camera = population.seeing(rng, min(distances_m) + offset_m)
    return camera, clicked(rng, camera, distances_m, Mistakes(offset_m=offset_m))


def _changed(
    rng: np.random.Generator,
    population: Population,
    distances_m: tuple[float, ...],
    change: Callable[[np.random.Generator, list[float]], list[float]],
) -> tuple[GroundPlaneCamera, Points]:
    camera = population.seeing(rng, min(distances_m))
    points = clicked(rng, camera, distances_m)
    said = change(rng, [point.distance_m for point in points])
    return camera, tuple(GroundPoint(d, p.row_px) for d, p in zip(said, points, strict=True))


def _swap(rng: np.random.Generator, said: list[float]) -> list[float]:
    first, second = rng.choice(len(said), 2, replace=False)
    said[first], said[second] = said[second], said[first]
    return said


def _slip(rng: np.random.Generator, said: list[float]) -> list[float]:
    place = rng.integers(len(said))
    said[place] *= rng.choice((0.1, 10.0))
    return said


def _feet(_: np.random.Generator, said: list[float]) -> list[float]:
    return [distance_m / 0.3048 for distance_m in said]


Make = Callable[[np.random.Generator, Population, tuple[float, ...]], tuple[GroundPlaneCamera, Points]]
MISTAKES: dict[Fault, Make] = {
    Fault.BUMPER: _bumper,
    Fault.SWAPPED: lambda rng, of, distances_m: _changed(rng, of, distances_m, _swap),
    Fault.SLIP_OF_TEN: lambda rng, of, distances_m: _changed(rng, of, distances_m, _slip),
    Fault.FEET: lambda rng, of, distances_m: _changed(rng, of, distances_m, _feet),
}


def _guilty(
    rng: np.random.Generator, kind: Fault, make: Make, where: tuple[Population, str], trials: int
) -> None:
    population, name = where
    spoken = told = right = wrong = 0
    for _ in range(trials):
        camera, points = make(rng, population, population.marks_m[name])
        judgement = judge_points(points, SIZE, camera.height_m)
        speaking = judgement.question or judgement
        telling = _ratio(judgement.if_careful or judgement, kind) > TELLING_RATIO
        named = speaking.named
        spoken += speaking.is_suspect
        told += telling
        right += telling and named is not None and named.fault is kind
        wrong += named is not None and named.fault is not kind
    say(
        f"{kind.value:12} {name:14} spoken of {spoken / trials:6.1%}  can be told {told / trials:6.1%}  "
        f"right {right / max(told, 1):6.1%}  wrong {wrong / trials:5.1%}"
    )


def _ratio(judgement: Judgement, kind: Fault) -> float:
    """Of the likelihoods of a mistake and of what was said, whatever else may be."""
    posterior = next(s.probability for s in judgement.suspicions if s.fault is kind)
    return (
        math.inf
        if not judgement.as_said
        else (posterior / SHARES[kind] / (judgement.as_said / SHARES[Fault.NONE]))
    )


def _dashes(rng: np.random.Generator, population: Population, trials: int) -> None:
    """Which dash was clicked was guessed wrongly: the first one, or how many lie between."""
    said = (6.0, 24.0, 42.0)
    for steps in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (0, 2, 4), (0, 0.5, 1)):
        words: Counter[str] = Counter()
        for _ in range(trials):
            first_m = rng.uniform(7.0, 16.0)
            true_m = tuple(first_m + DASH_PERIOD_M * step for step in steps)
            camera = population.seeing(rng, first_m)
            rows = [point.row_px for point in clicked(rng, camera, true_m)]
            points = [GroundPoint(d, row) for d, row in zip(said, rows, strict=True)]
            try:
                calibration = calibrate(points, SIZE, camera.height_m)
            except UserError:
                words["refused"] += 1
                continue
            off = calibration.distance_at(camera.row_at(30.0)) / 30 - 1
            findings = plausibility(calibration)
            if findings:
                words["asked of" if all(finding.is_question for finding in findings) else "warned of"] += 1
            else:
                words["green, off by less than 10 %" if abs(off) < 0.1 else "green and wrong"] += 1
        text = ", ".join(f"{word} {count / trials:.0%}" for word, count in words.most_common())
        say(f"  true ends at x + 18 m times {steps}: {text}")


if __name__ == "__main__":
    main()
