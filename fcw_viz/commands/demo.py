"""`fcw demo`: the whole job on the drive that ships with the program, what it is worth, and its review."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fcw.errors import UserError
from fcw_viz.commands.run.report import report_drive
from fcw_viz.exit_codes import EXIT_INTERRUPTED

if TYPE_CHECKING:
    from rich.console import Console

    from fcw.evaluation.simulated import SimulatedComparison

_PACKAGE = Path(__file__).parents[1]
DEMO_FOLDERS = (_PACKAGE / "demo_drive", _PACKAGE.parent / "recordings" / "demo")
"""In an installed package, and in a checkout."""


@dataclass(frozen=True, slots=True)
class DemoCommand:
    """Run everything on the shipped drive, compare it with the truth, and open the review page on it."""

    no_serve: bool = False
    """End after the run, without the review page."""
    out: Path = Path("recordings/demo/out")
    """Folder for the logs and summary.json."""


def demo_folder() -> Path:
    """Folder of the shipped drive.

    Raises:
        UserError: the installation is not whole.
    """
    for folder in DEMO_FOLDERS:
        if (folder / "drive.mp4").is_file():
            return folder
    raise UserError(f"{DEMO_FOLDERS[-1]}/drive.mp4: the shipped drive is missing; install fcw again")


def run_demo(command: DemoCommand) -> int:
    """Run `fcw demo`; returns the exit code."""
    from fcw.evaluation.simulated import compare_with_truth
    from fcw.job import DriveJob
    from fcw.logs.mcap.reader import DriveLog
    from fcw.logs.names import MCAP_NAME
    from fcw.simulation.truth.file import read_truth
    from fcw_viz.console import RESULTS
    from fcw_viz.jobs.drive import run_on_console

    folder = demo_folder()
    truth = read_truth(folder / "truth.csv")
    job = DriveJob(source=folder / "drive.mp4", out=command.out, ego_speed=str(folder / "drive.speed.csv"))
    outcome = run_on_console(job)
    console = RESULTS
    if not outcome.interrupted:
        results = list(DriveLog(command.out / MCAP_NAME).results())
        print_comparison(compare_with_truth(results, truth), console)
    report_drive(outcome, command.out, console)
    if outcome.interrupted:
        return EXIT_INTERRUPTED
    if command.no_serve:
        return 0
    from fcw_viz.commands.review.command import run_review
    from fcw_viz.commands.review.options import ReviewCommand

    console.print()
    return run_review(ReviewCommand(command.out))


def print_comparison(comparison: "SimulatedComparison", console: "Console") -> None:
    """Print what was measured beside what is true."""
    import numpy as np
    from rich.table import Table

    from fcw.evaluation.simulated import FARTHEST_M, NEAREST_M
    from fcw.warning.types import WarningLevel

    table = Table("against the simulation's truth", "", box=None, title_justify="left")
    for what, errors in (
        (f"distance of the lead, {comparison.lead_frames} frames", comparison.lead_errors),
        ("distance of all followed vehicles", comparison.track_errors),
    ):
        median, p90 = np.quantile(np.abs(errors), (0.5, 0.9)) if errors else (float("nan"),) * 2
        table.add_row(what, f"off by {median:.1%} (median), {p90:.1%} (9 of 10)")
    table.add_row(
        f"vehicles from behind, {NEAREST_M:.0f} to {FARTHEST_M:.0f} m",
        f"{comparison.detection_rate:.1%} of {comparison.vehicles} found, "
        f"{comparison.false_positives_per_frame:.3f} false/frame",
    )
    for due in comparison.due:
        if due.warned_s is None:
            verdict = "never came"
        elif due.in_window:
            verdict = f"came at {due.warned_s:.2f} s, {due.due_s - due.warned_s:.2f} s before the end"
        else:
            off_s = max(due.earliest_s - due.warned_s, due.warned_s - due.due_s)
            verdict = f"came at {due.warned_s:.2f} s, {off_s:.2f} s too {'early' if due.in_time else 'late'}"
        window = f"{due.earliest_s:.2f} to {due.due_s:.2f} s"
        table.add_row(f'warning of "{due.vehicle}", due from {window}', verdict)
    table.add_row(
        "unneeded warnings",
        str(sum(warning.level == WarningLevel.WARNING for warning in comparison.needless))
        + f"; of oncoming vehicles: {comparison.warnings_of_oncoming}",
    )
    console.print(table)
