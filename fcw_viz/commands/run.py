"""`fcw run`: the whole job on one drive."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

if TYPE_CHECKING:
    from rich.console import Console

    from fcw_viz.jobs.drive import DriveJob, DriveOutcome

RECORDINGS = Path("recordings")
FOXGLOVE_LAYOUT = Path(__file__).parents[1] / "foxglove_layout.json"
"""Camera, ground view, plots and warnings of a drive.mcap, as Foxglove imports it."""


@dataclass(frozen=True, slots=True)
class RunCommand:
    """Find the vehicles ahead, measure their distance, warn, and write drive.mcap and drive.rrd."""

    source: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SOURCE")]
    """Video or MCAP file, or folder of pictures; with --live also a camera: its number, /dev/video0, or an
    rtsp or http address."""
    calibration: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Calibration file; by default `<name>.calibration.yaml` beside the source, else that in an MCAP file."""
    topic: Annotated[str | None, tyro.conf.arg(metavar="TOPIC")] = None
    """Of an MCAP file: the pictures to run on; needed where it has several topics of pictures."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="FOLDER")] = None
    """Folder for the logs and summary.json; by default recordings/<name>, of a camera with the time. Earlier
    logs there are replaced."""
    detector: Annotated[str, tyro.conf.arg(metavar="acf|acf-full|onnx:FILE")] = "acf"
    """acf searches where the calibration allows a vehicle; acf-full the whole picture; onnx: a YOLO net."""
    detector_classes: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME|NUMBER ...")] = ()
    """Which classes of the ONNX model are vehicles; by default its cars, trucks and buses."""
    ego_speed: Annotated[str | None, tyro.conf.arg(metavar="MPS|FILE")] = None
    """Own speed: metres per second, a CSV file with the columns time_s and speed_mps, or a GPX track; by
    default what an MCAP file says of it."""
    warning_policy: Annotated[str, tyro.conf.arg(metavar="NAME")] = "timely-braking"
    """When to warn: timely-braking, ttc, headway, required-deceleration, euro-ncap-driver, rss."""
    frame_rate: Annotated[float | None, tyro.conf.arg(metavar="HZ")] = None
    """Frames per second of a folder of pictures without time stamps."""
    units: Literal["metric", "imperial"] = "metric"
    """Units of the distances that people are shown."""
    live: bool = False
    """Show the drive in the browser while it runs, at its own rate, with warnings that are heard; then review
    it there. Pictures are left out rather than late."""
    port: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """With --live: port of the page on this computer; by default 8080, or the next free one."""
    no_open: bool = False
    """With --live: do not open a browser; the address is printed."""
    json: bool = False
    """Print the summary as JSON on stdout, alone."""


def run_run(command: RunCommand) -> int:
    """Run `fcw run`; returns the exit code."""
    import json
    import sys

    from rich.console import Console

    from fcw.errors import UserError
    from fcw_viz.jobs.drive import run_drive

    if command.live:
        from fcw_viz.commands.run_live import run_live

        return run_live(command)
    if command.port is not None or command.no_open:
        raise UserError("--port, --no-open: they are for the page of --live; add it, or leave them out")
    path = Path(command.source)
    if not path.exists() and _is_camera(command.source):
        raise UserError(f"{command.source}: a camera runs live only; add --live")
    job = job_of(command, path)
    messages = Console(stderr=True)
    outcome = run_drive(job, messages)
    for note in outcome.notes:
        messages.print(f"note: {note}", highlight=False)
    if command.json:
        sys.stdout.write(json.dumps(outcome.summary, indent=2) + "\n")
    else:
        report_drive(outcome, job.out, Console(), imperial=job.imperial)
    return 130 if outcome.interrupted else 0


def job_of(command: RunCommand, source: Path, out: Path | None = None) -> "DriveJob":
    """What the command asks for.

    Args:
        command: as it was typed.
        source: of the drive.
        out: where its logs go; None for what was typed, or the default.
    """
    from fcw_viz.jobs.drive import DriveJob

    return DriveJob(
        source=source,
        out=out or command.out or RECORDINGS / (source.stem or source.resolve().name),
        calibration=command.calibration,
        topic=command.topic,
        detector=command.detector,
        detector_classes=command.detector_classes,
        ego_speed=command.ego_speed,
        warning_policy=command.warning_policy,
        imperial=command.units == "imperial",
        frame_rate_hz=command.frame_rate,
    )


def _is_camera(source: str) -> bool:
    from fcw.sources.camera import is_camera

    return is_camera(source)


def report_drive(outcome: "DriveOutcome", out: Path, console: "Console", imperial: bool = False) -> None:
    """Print what a drive came to, and how to open its logs."""
    from rich.table import Table

    from fcw.units import distance_text
    from fcw_viz.jobs.drive import MCAP_NAME, RRD_NAME, SUMMARY_NAME

    summary = outcome.summary
    console.print(
        f"[bold]{summary['source']}[/bold]: {summary['frames']} frames, {summary['duration_s']:.1f} s, "
        f"{summary['frames_per_second']:.0f} frames/s, a lead vehicle in {summary['frames_with_lead']} frames"
        + (" [yellow](interrupted)[/yellow]" if outcome.interrupted else ""),
        highlight=False,
    )
    if summary["warnings"]:
        table = Table("level", "from", "to", "smallest TTC", "smallest distance", "track", box=None)
        for span in summary["warnings"]:
            ttc_s, distance_m = span["min_ttc_s"], span["min_distance_m"]
            table.add_row(
                span["level"],
                f"{span['start_s']:.2f} s",
                f"{span['end_s']:.2f} s",
                "-" if ttc_s is None else f"{ttc_s:.1f} s",
                "-" if distance_m is None else distance_text(distance_m, imperial),
                str(span["track_id"]),
            )
        console.print(table)
    else:
        console.print("no warnings")
    console.print(
        f"\n  look at it: fcw review {out}\n\n"
        f"  {out / MCAP_NAME}   open it in Foxglove (https://foxglove.dev, Open local file),\n"
        f"      with the layout {_short(FOXGLOVE_LAYOUT)} (Layouts, Import from file)\n"
        f"  {out / RRD_NAME}    open it with: fcw review {out} --rerun\n"
        f"  {out / SUMMARY_NAME}",
        highlight=False,
        soft_wrap=True,
    )


def _short(path: Path) -> Path:
    """A path as a person here would type it."""
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
