"""`fcw demo`: the whole job on the drive that ships with the program."""

from dataclasses import dataclass
from pathlib import Path

from fcw.errors import UserError
from fcw_viz.commands.run import report_drive

_PACKAGE = Path(__file__).parents[1]
DEMO_FOLDERS = (_PACKAGE / "demo_drive", _PACKAGE.parent / "recordings" / "demo")
"""In an installed package, and in a checkout."""


@dataclass(frozen=True, slots=True)
class DemoCommand:
    """Run everything on the shipped drive and say where the logs are."""

    no_serve: bool = False
    """Do not open the review page afterwards (there is none yet: the demo ends by itself either way)."""
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
    from rich.console import Console

    from fcw_viz.drive_job import DriveJob, run_drive

    folder = demo_folder()
    job = DriveJob(source=folder / "drive.mp4", out=command.out, ego_speed=str(folder / "drive.speed.csv"))
    outcome = run_drive(job, Console(stderr=True))
    report_drive(outcome, command.out, Console())
    return 130 if outcome.interrupted else 0
