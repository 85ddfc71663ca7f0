"""Names of the files in a drive's folder."""

from pathlib import Path

from fcw.errors import UserError

MCAP_NAME = "drive.mcap"
"""The log. Other MCAP files in a folder need not be drive logs."""
RRD_NAME = "drive.rrd"
"""The same for the rerun viewer, which the application writes."""
SUMMARY_NAME = "summary.json"
FAILED_PREFIX = "failed-"
"""Goes before these names where a run did not come to its end."""
FAILED_MCAP_NAME = f"{FAILED_PREFIX}{MCAP_NAME}"
TRUTH_LOG_NAME = "truth.mcap"
"""The truth of a simulated drive, as a log with the same pictures."""


def recovered_path(path: Path) -> Path:
    """Where a log is recovered to by default: beside it."""
    return path.with_name(f"{path.stem}.recovered{path.suffix}")


def recovered_log(path: Path) -> Path | None:
    """What was recovered of a log, where it was by default; None if nothing was since it was written."""
    recovered = recovered_path(path)
    try:
        return recovered if recovered.stat().st_mtime_ns >= path.stat().st_mtime_ns else None
    except OSError:
        return None


def mcap_path(drive: Path) -> Path:
    """The MCAP log of a drive that somebody names: the log itself, or the folder that holds it.

    Raises:
        UserError: the folder holds only the log of a run that failed, which has to be named itself.
    """
    if not drive.is_dir():
        return drive
    log, failed = drive / MCAP_NAME, drive / FAILED_MCAP_NAME
    if failed.is_file() and not log.exists():
        raise UserError(f"{drive}: its run failed; name what it left of the drive: {failed}")
    return log
