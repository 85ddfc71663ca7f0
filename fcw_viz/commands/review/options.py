"""What `fcw review` is told on the command line."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True, slots=True)
class ReviewCommand:
    """Look at logged drives in the browser and judge their warnings, until Ctrl-C."""

    path: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="PATH")]
    """A drive.mcap, its folder, or a folder of such folders; with --rerun one drive, or its drive.rrd."""
    port: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """Port of the page on this computer. Default: 8080, or the next free one."""
    no_open: bool = False
    """Do not open a browser or window, only print the address."""
    reviewer: Annotated[str | None, tyro.conf.arg(metavar="NAME")] = None
    """Name under which verdicts and notes are saved. Default: the login name."""
    dark: bool = False
    """Start with dark colours."""
    rerun: bool = False
    """Use the rerun viewer, in a window or, without a display, in the browser."""
    summary: bool = False
    """Print a summary of the verdicts on one drive, or on all drives below a folder: warnings per hour, share
    judged false, reasons."""
    json: bool = False
    """With --summary: print it as JSON, and nothing else on stdout."""
