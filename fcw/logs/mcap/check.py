"""A log that was just closed: is it what was written?"""

from pathlib import Path

from fcw.errors import UserError
from fcw.logs.mcap.reader import DriveLog


def check_log(path: Path, frames: int) -> None:
    """Look at a log that was just closed: that it is there, and holds what was written.

    Raises:
        UserError: it is not, or does not.
    """
    try:
        log = DriveLog(path)
        found = len(log.series())
        if log.complete and found == frames:
            return
        trouble = f"it holds {found} of {frames} frames"
    except UserError as error:
        trouble = str(error)
    raise UserError(
        f"{path}: the log is not what was written ({trouble}); something removed or changed it "
        "during the run: run again, into a folder that nothing else writes to"
    )
