"""The figures of a benchmark as a folder: the tables as text, all of it as JSON, and three pictures."""

import io
import json
import statistics
from pathlib import Path

from rich.console import Console
from rich.table import Table

from fcw.charts.chart import Chart, Series
from fcw.charts.svg import MARK
from fcw.errors import UserError
from fcw.files import check_kind, write_whole
from fcw_viz.benchmark.against import EarlierFigures
from fcw_viz.benchmark.figures import Figures
from fcw_viz.benchmark.picture_cases import FARTHEST_M, PITCH_TOLERANCES_DEG, PRIOR_PREFIX, prior_name
from fcw_viz.benchmark.stages_bar import stages_bar

TEXT_NAME, JSON_NAME = "bench.txt", "bench.json"
WINDOWS_NAME, PITCH_NAME, STAGES_NAME = "speed-windows.svg", "speed-pitch.svg", "speed-stages.svg"
MARKS = {
    TEXT_NAME: b"ms a picture, one thread",
    JSON_NAME: b'"ms_per_frame"',
    WINDOWS_NAME: MARK,
    PITCH_NAME: MARK,
    STAGES_NAME: MARK,
}
"""What stands in every file of a report."""
TEXT_COLUMNS = 120
ROOM = 1.08
"""How far the axes go beyond what is drawn."""


def print_figures(figures: Figures, console: Console, earlier: EarlierFigures | None = None) -> None:
    """Print the figures for a person, beside those of an earlier run where there are any."""
    console.print(figures.heading, highlight=False)
    numbers = ("median", "least")
    pictures = Table("ms a picture, one thread", *numbers, "/ Luv", "/ plain", "windows", box=None)
    for row in figures.picture_rows():
        pictures.add_row(*row)
    drives = Table("ms a frame, by the clock", *numbers, "frames/s", box=None)
    for row in figures.drive_rows():
        drives.add_row(*row)
    stages = Table("ms a frame, stage by stage in one thread", "median", "part", box=None)
    for row in figures.stage_rows():
        stages.add_row(*row)
    ratios = Table("ratio, median of the rounds", "", box=None)
    for name, value in figures.ratios():
        ratios.add_row(name, f"{value:.2f}")
    tables = [pictures, drives, stages, ratios]
    if earlier is not None:
        against = Table(f"against {earlier.path.name}", "before", "now", "now / before", box=None)
        for change in earlier.changes(figures):
            against.add_row(change.name, f"{change.before:.2f}", f"{change.now:.2f}", f"{change.ratio:.2f}")
        tables.append(against)
        console.print(f"\nearlier: {earlier.heading}", highlight=False)
        console.print("now / before: less than 1 is faster for times, more than 1 for rates", highlight=False)
    for table in tables:
        table.columns[0].no_wrap = True
        for column in table.columns[1:]:
            column.justify = "right"
        console.print()
        console.print(table, highlight=False)


def report_folder(folder: Path) -> Path:
    """The folder of a report, made if need be; a new one replaces nothing but an earlier report.

    Raises:
        UserError: it cannot be made, or a file of a report's name in it is none of a report.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"--report {folder}: cannot make this folder ({error.strerror})") from error
    for name, mark in MARKS.items():
        check_kind(folder / name, "report of this command", (mark,))
    return folder


def write_report(figures: Figures, folder: Path, earlier: EarlierFigures | None = None) -> list[Path]:
    """Write the report into its folder; returns its files.

    Raises:
        UserError: a file cannot be written.
    """
    text = io.StringIO()
    console = Console(file=text, width=TEXT_COLUMNS, markup=False, emoji=False)  # names may hold brackets
    print_figures(figures, console, earlier)
    files = {
        TEXT_NAME: text.getvalue(),
        JSON_NAME: json.dumps(figures.as_json(), indent=2) + "\n",
        WINDOWS_NAME: windows_chart(figures).svg(),
        PITCH_NAME: pitch_chart(figures).svg(),
        STAGES_NAME: stages_bar(
            {name: statistics.median(values) for name, values in figures.stages_ms.items()}
        ),
    }
    for name, content in files.items():
        write_whole(folder / name, content)
    return [folder / name for name in files]


def windows_chart(figures: Figures) -> Chart:
    """Time against the number of windows."""
    points = {
        case: (windows / 1e3, statistics.median(figures.picture_ms[case]))
        for case, windows in figures.windows_per_frame.items()
    }
    prior = [point for case, point in points.items() if case.startswith(PRIOR_PREFIX)]
    plain = [point for case, point in points.items() if not case.startswith(PRIOR_PREFIX)]
    return Chart(
        "Time and windows",
        "thousands of windows",
        "ms a picture, one thread",
        (0.0, ROOM * max(x for x, _ in points.values())),
        (0.0, ROOM * max(y for _, y in points.values())),
        (Series(PRIOR_PREFIX, prior, dot_px=4.0), Series("plain ACF", plain, dot_px=4.0)),
    )


def pitch_chart(figures: Figures) -> Chart:
    """Cost against the pitch tolerance, for each range."""
    lines = [
        Series(
            f"4 to {farthest_m:g} m",
            [
                (deg, statistics.median(figures.picture_ms[prior_name(farthest_m, deg)]))
                for deg in PITCH_TOLERANCES_DEG
            ],
            line=True,
        )
        for farthest_m in FARTHEST_M
    ]
    highest_ms = max(y for line in lines for _, y in line.points)
    return Chart(
        "Cost of the pitch tolerance",
        "pitch tolerance, degrees up and down",
        "ms a picture, one thread",
        (0.0, ROOM * PITCH_TOLERANCES_DEG[-1]),
        (0.0, ROOM * highest_ms),
        lines,
    )
