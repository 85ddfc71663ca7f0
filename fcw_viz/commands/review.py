"""`fcw review`: look at a drive that was logged."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True, slots=True)
class ReviewCommand:
    """Look at a logged drive until Ctrl-C."""

    path: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="PATH")]
    """Folder of a drive, or its drive.mcap or drive.rrd."""
    port: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """Port of the page on this computer; by default a free one."""
    no_open: bool = False
    """Do not open a browser or window; the address is printed."""
    rerun: bool = False
    """Use the rerun viewer: in a window, or without a display in the browser."""


def run_review(command: ReviewCommand) -> int:
    """Run `fcw review`; returns the exit code."""
    from fcw.errors import UserError

    if command.rerun:
        from fcw_viz.commands.review_rerun import review_in_rerun

        return review_in_rerun(command)
    raise UserError(
        f"fcw review {command.path}: the page is not there yet; add --rerun for the rerun viewer, "
        "or open drive.mcap in Foxglove"
    )
