"""What a drive came to, as it is printed at its end."""

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from fcw.job import DriveOutcome

FOXGLOVE_LAYOUT = Path(__file__).parents[2] / "foxglove_layout.json"
"""Camera, ground view, plots and warnings of a drive.mcap, as Foxglove imports it."""

SHORTEST_S = 1.0
"""In less a vehicle is hardly found, followed and warned of (`fcw.warning.evidence`)."""


def report_drive(
    outcome: "DriveOutcome", out: Path, console: "Console", imperial: bool = False, rerun_log: bool = True
) -> None:
    """Print what a drive came to, and how to open its logs."""
    from rich.table import Table
    from rich.text import Text

    from fcw.logs.names import MCAP_NAME, RRD_NAME, SUMMARY_NAME
    from fcw.summary import BLANK_TOLD_S
    from fcw.units import distance_text
    from fcw_viz.console_text import counted, one_line

    summary = outcome.summary
    console.print(
        Text.assemble(
            (one_line(summary["source"]), "bold"),
            f": {counted(summary['frames'], 'frame')}, {summary['duration_s']:.1f} s, "
            f"{summary['frames_per_second']:.0f} frames/s, "
            f"a lead vehicle in {counted(summary['frames_with_lead'], 'frame')}",
            (" (interrupted)" if outcome.interrupted else "", "yellow"),
        )
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
    elif summary["blind_s"] >= BLANK_TOLD_S:
        console.print(
            f"no warnings, but blind for {summary['blind_s']:.1f} s of {summary['duration_s']:.1f} s",
            style="yellow",
        )
    elif summary["duration_s"] < SHORTEST_S:
        console.print(
            "no warnings, but the drive is too short for any: a vehicle is followed for about a second "
            "before the first one"
        )
    else:
        console.print("no warnings")
    recording = f"  {out / RRD_NAME}    open it with: fcw review {quote(str(out))} --rerun\n"
    console.print(
        f"\n  review it: fcw review {quote(str(out))}\n\n"
        f"  {out / MCAP_NAME}   open it in Foxglove (https://foxglove.dev, Open local file),\n"
        f"      with the layout {_short(FOXGLOVE_LAYOUT)} (Layouts, Import from file)\n"
        f"{recording if rerun_log else ''}"
        f"  {out / SUMMARY_NAME}",
        highlight=False,
        soft_wrap=True,
    )


def _short(path: Path) -> Path:
    """A path as a person here would type it."""
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
