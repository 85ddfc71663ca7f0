"""Draws the figures of docs/theory.md from the shipped drive and its truth.

fcw demo --no-serve
python docs/theory_figures.py recordings/demo/out docs/images
"""

import argparse
import math
import statistics
import sys
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

import fcw
from fcw.charts.chart import Chart, Series
from fcw.logs.records import FrameResult
from fcw.simulation.truth.file import read_truth
from fcw.simulation.truth.truth import FrameTruth

DRAWS = 2000
DISTANCES_M = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0)
EVERY = 5
"""Frames between the points of a curve."""


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("drive", type=Path, help="folder of the shipped drive's log")
    parser.add_argument("out", type=Path, help="folder for the figures")
    options = parser.parse_args()
    draw(options.drive, options.out)


def draw(drive: Path, out: Path) -> None:
    """Write the figures, and print what they come to."""
    log = fcw.read_drive(drive)
    results, truth = list(log.results()), read_truth(drive.parent / "truth.csv")
    times_s = [(result.time_ns - results[0].time_ns) / 1e9 for result in results]
    for name, chart in (
        ("theory-calibration", calibration_chart(log.header.calibration)),
        ("theory-speed", speed_chart(times_s, results)),
        ("theory-distance", distance_chart(times_s, results, truth)),
        ("theory-threat", threat_chart(times_s, results)),
    ):
        (out / f"{name}.svg").write_text(chart.svg(), encoding="utf-8")


def calibration_chart(calibration: fcw.Calibration) -> Chart:
    """Half the width of the 68 % interval of a distance, as stated and as sampled clicks scatter."""
    random = np.random.default_rng(0)
    rows = np.array([calibration.row_at(distance_m) for distance_m in DISTANCES_M])
    sampled = np.array([fitted(calibration, random).distance_at(rows) for _ in range(DRAWS)])
    low_m, high_m = np.quantile(sampled, (0.16, 0.84), axis=0)
    stated = [calibration.distance_interval(row) for row in rows.tolist()]
    said = [(high - low) / 2 / d for (low, high), d in zip(stated, DISTANCES_M, strict=True)]
    seen = ((high_m - low_m) / 2 / np.array(DISTANCES_M)).tolist()
    worst = max(abs(a / b - 1) for a, b in zip(said, seen, strict=True))
    sys.stdout.write(f"interval of the calibration: within {worst:.0%} of {DRAWS} sampled ones\n")
    return Chart(
        "Interval of a row's distance",
        "distance, m",
        "half of the interval, %",
        (0.0, 55.0),
        (0.0, math.ceil(100 * max(said + seen))),
        (
            curve("stated", DISTANCES_M, percent(said), line=True),
            curve("sampled", DISTANCES_M, percent(seen)),
        ),
    )


def fitted(calibration: fcw.Calibration, random: np.random.Generator) -> fcw.Calibration:
    """The calibration of the same marks, taped and clicked again."""
    sigma_px = calibration.row_sigma_px
    tape = 1 + random.normal(0.0, calibration.tape_error)
    points = [
        replace(p, row_px=calibration.row_at(p.distance_m * tape) + random.normal(0.0, sigma_px))
        for p in calibration.points
    ]
    return fcw.calibrate(
        points,
        calibration.image_size,
        calibration.camera.height_m,
        calibration.reference_offset_m,
        sigma_px,
        tape_error=calibration.tape_error,
    )


def speed_chart(times_s: list[float], results: list[FrameResult]) -> Chart:
    """Own speed from the picture beside the one given."""
    pairs = [
        (time_s, result.own_motion.picture_speed_mps, result.ego_speed_mps)
        for time_s, result in zip(times_s, results, strict=True)
        if result.own_motion is not None and result.own_motion.picture_speed_mps is not None
    ]
    errors = [abs(seen / given - 1) for _, seen, given in pairs if given is not None and given > 2]
    sys.stdout.write(f"own speed above 2 m/s: off by {statistics.median(errors):.1%} (median)\n")
    seen = Series("from the picture", [(t, v) for t, v, _ in pairs[::EVERY]])
    given = Series("given", [(t, v) for t, _, v in pairs[::EVERY] if v is not None], line=True)
    return Chart("Own speed", "time, s", "speed, m/s", (0.0, 40.0), (0.0, 20.0), (given, seen))


def distance_chart(times_s: list[float], results: list[FrameResult], truth: list[FrameTruth]) -> Chart:
    """Distance of the lead with its interval, beside the truth."""
    rows = [
        (
            time_s,
            result.lead.distance_low_m,
            result.lead.distance_m,
            result.lead.distance_high_m,
            true.lead.distance_m,
        )
        for time_s, result, true in zip(times_s, results, truth, strict=True)
        if result.lead is not None and true.lead is not None
    ]
    inside = statistics.mean(low <= true <= high for _, low, _, high, true in rows)
    sys.stdout.write(
        f"distance of the lead: truth inside the 68 % interval in {inside:.0%} of {len(rows)} frames\n"
    )
    t, low, mid, high, true = zip(*rows[::EVERY], strict=True)
    estimate = Series(
        "estimate, with its interval",
        list(zip(t, mid, strict=True)),
        line=True,
        band=list(zip(t, low, high, strict=True)),
    )
    series = (estimate, curve("truth", t, true))
    return Chart("Distance of the lead", "time, s", "distance, m", (0.0, 40.0), (0.0, 60.0), series)


def threat_chart(times_s: list[float], results: list[FrameResult]) -> Chart:
    """The braking that the lead asks for while a warning is shown."""
    rows = [
        (time_s, result.told_warning.required_deceleration_mps2, int(result.warning.level))
        for time_s, result in zip(times_s, results, strict=True)
        if result.told_warning.required_deceleration_mps2 is not None
    ]
    t, braking, level = zip(*rows, strict=True)
    shown = [time_s for time_s, one in zip(t, level, strict=True) if one == fcw.WarningLevel.WARNING]
    series = (curve("braking needed", t, braking),)
    bands = ((min(shown), max(shown)),) if shown else ()
    return Chart(
        "Braking needed while the warning is shown",
        "time, s",
        "braking, m/s²",
        (min(t) - 1, max(t) + 1),
        (0.0, 4.0),
        series,
        bands,
    )


def curve(name: str, x: Iterable[float], y: Iterable[float], line: bool = False) -> Series:
    """One series."""
    return Series(name, list(zip(x, y, strict=True)), line=line, dot_px=3)


def percent(values: list[float]) -> list[float]:
    """Of fractions."""
    return [100 * value for value in values]


if __name__ == "__main__":
    main()
