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
    """Port of the page on this computer; by default 8080, or the next free one."""
    no_open: bool = False
    """Do not open a browser or window; the address is printed."""
    reviewer: Annotated[str | None, tyro.conf.arg(metavar="NAME")] = None
    """In whose name verdicts and notes are kept on the page; by default the login name."""
    dark: bool = False
    """Begin with dark colours."""
    rerun: bool = False
    """Use the rerun viewer: in a window, or without a display in the browser."""
    summary: bool = False
    """Print what people's verdicts come to, of a drive or of all drives below a folder: warnings per hour,
    share judged false, why."""
    json: bool = False
    """With --summary: as JSON on stdout, alone."""
