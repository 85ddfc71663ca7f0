"""`fcw recover`: a complete log from the log of a run that was killed."""

from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from fcw.logs.mcap.recovery import RecoveryReport


@dataclass(frozen=True, slots=True)
class RecoverCommand:
    """Write a complete log from the log of a run that was killed, and check it.

    The damaged log is kept. If the log is complete, nothing is written.
    """

    drive: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="DRIVE")]
    """A drive.mcap, or its folder."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="PATH")] = None
    """New log to write. Default: `<name>.recovered.mcap` beside the damaged one."""


def run_recover(command: RecoverCommand) -> int:
    """Run `fcw recover`; returns the exit code."""
    from fcw.logs.mcap.recovery import recover
    from fcw.logs.names import mcap_path, recovered_path
    from fcw_viz.console import RESULTS, progress

    path = mcap_path(command.drive)
    out = command.out or recovered_path(path)
    with progress(path.name, 1.0) as bar:
        report = recover(path, out, bar.reach)
    RESULTS.print(report_text(report, path, out), soft_wrap=True)
    if report.written:
        RESULTS.print(f"\n  review it: fcw review {quote(str(out))}", soft_wrap=True)
    return 0


def report_text(report: "RecoveryReport", path: Path, out: Path) -> str:
    """What was recovered and what was lost, in sentences."""
    from fcw.logs.mcap.format import PICTURES_CHUNK_NS, SIGNALS_CHUNK_NS
    from fcw_viz.console_text import counted

    frames = counted(report.frames, "frame")
    held = f"{frames}, {report.duration_s:.2f} s, {report.pictures} of them with a picture"
    if not report.written:
        return f"{path}: {held}; the log is complete: nothing was lost, and nothing was written"
    text = f"{out}: {held}"
    if report.damaged_chunks:
        text += f"; {report.damaged_chunks} damaged parts of {path.name} were left out"
    if report.was_complete:
        return text
    return (
        f"{text}; of what came after, at most {SIGNALS_CHUNK_NS / 1e9:g} s of signals and "
        f"{PICTURES_CHUNK_NS / 1e9:g} s of pictures are lost ({report.torn_bytes} bytes at the end were torn)"
    )
