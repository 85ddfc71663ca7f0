"""Charts of a distance evaluation: errors against distance, honesty of the intervals, TTC against time."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fcw.charts.chart import Chart, Series
from fcw.charts.svg import MARK
from fcw.evaluation.distance.kitti import DistanceEvaluation, DistanceSample
from fcw.evaluation.distance.kitti_tracking import FRAME_RATE_HZ
from fcw.files import check_kind, write_whole

ERROR_NAME, COVERAGE_NAME = "error.svg", "coverage.svg"
CHART = "chart of this command"
SHOWN_ERROR = 0.4
SHOWN_TTC_S = 10.0
COVERAGE_BIN_M = 5.0
CHARTED_VEHICLES = 6
"""TTC charts are of the vehicles that come nearest to a collision, one each."""


def check_report_folder(folder: Path) -> None:
    """See before long work that the charts replace nothing but earlier ones.

    Raises:
        UserError: a file in the folder that has a chart's name is none.
    """
    for name in (ERROR_NAME, COVERAGE_NAME):
        check_kind(folder / name, CHART, (MARK,))


def write_report(result: DistanceEvaluation, folder: Path) -> list[Path]:
    """Write the charts as SVG files; returns their paths.

    Raises:
        UserError: the folder cannot be written, or has a file of a chart's name that is none.
    """
    charts = {ERROR_NAME: error_chart(result.samples), COVERAGE_NAME: coverage_chart(result.samples)}
    charts |= ttc_charts(result.samples, result.warnings)
    for name in charts:
        check_kind(folder / name, CHART, (MARK,))
    paths = []
    for name, chart in charts.items():
        write_whole(folder / name, chart.svg())
        paths.append(folder / name)
    return paths


def error_chart(samples: Sequence[DistanceSample]) -> Chart:
    """Signed relative errors of the tracker and of the two plain methods against the true distance."""
    methods = (("row alone", "row_m"), ("width 1.70 m", "width_m"), ("tracker", "estimated_m"))
    series = [
        Series(name, [(s.true_m, getattr(s, field) / s.true_m - 1) for s in samples])
        for name, field in methods
    ]
    return Chart(
        "Distance error", "true distance, m", "relative error", (0, 80), (-SHOWN_ERROR, SHOWN_ERROR), series
    )


def coverage_chart(samples: Sequence[DistanceSample]) -> Chart:
    """Part of the true distances inside the 1-sigma interval, against the true distance."""
    true_m = np.array([s.true_m for s in samples])
    inside = np.array([s.low_m <= s.true_m <= s.high_m for s in samples], float)
    points = []
    for low_m in np.arange(0.0, 80.0, COVERAGE_BIN_M):
        chosen = (true_m >= low_m) & (true_m < low_m + COVERAGE_BIN_M)
        if chosen.any():
            points.append((low_m + COVERAGE_BIN_M / 2, float(inside[chosen].mean())))
    return Chart(
        "Inside the 1-sigma interval",
        "true distance, m",
        "part of the samples",
        (0, 80),
        (0, 1),
        [Series("tracker", points, line=True), Series("honest", [(0.0, 0.68), (80.0, 0.68)], line=True)],
    )


def ttc_charts(
    samples: Sequence[DistanceSample], warnings: Sequence[tuple[str, int, int]]
) -> dict[str, Chart]:
    """TTC of the vehicles that came nearest to a collision against time, warnings marked.

    Args:
        samples: of the evaluation.
        warnings: sequence, frame and true track of every frame with `warning`.
    """
    by_vehicle: dict[tuple[str, int], list[DistanceSample]] = {}
    for sample in samples:
        by_vehicle.setdefault((sample.sequence, sample.track), []).append(sample)
    nearest = sorted(
        by_vehicle.items(), key=lambda item: min(_ttc_s(s.true_m, s.true_closing_mps) for s in item[1])
    )
    charts = {}
    for (sequence, track), seen in nearest[:CHARTED_VEHICLES]:
        times_s = [s.frame / FRAME_RATE_HZ for s in seen]
        bands = [
            (frame / FRAME_RATE_HZ, (frame + 1) / FRAME_RATE_HZ)
            for name, frame, warned in warnings
            if name == sequence and warned == track
        ]
        true = [(t, _ttc_s(s.true_m, s.true_closing_mps)) for t, s in zip(times_s, seen, strict=True)]
        believed = [
            (t, _ttc_s(s.estimated_m, s.estimated_closing_mps)) for t, s in zip(times_s, seen, strict=True)
        ]
        charts[f"ttc-{sequence}-{track}.svg"] = Chart(
            f"Sequence {sequence}, vehicle {track}: time to collision, warning marked",
            "time, s",
            "TTC, s",
            (math.floor(times_s[0]), math.ceil(times_s[-1] + 0.1)),
            (0, SHOWN_TTC_S),
            [Series("true", true, line=True), Series("tracker", believed)],
            bands,
        )
    return charts


def _ttc_s(distance_m: float, closing_mps: float) -> float:
    return distance_m / closing_mps if closing_mps > 0 else math.inf
