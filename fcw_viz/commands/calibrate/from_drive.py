"""`fcw calibrate --from-drive`: what a drive taught of the mount becomes the calibration."""

import math
from collections.abc import Sequence
from pathlib import Path

from fcw.camera.calibration import Calibration
from fcw.errors import UserError
from fcw.motion.learned import calibration_of_mount
from fcw.motion.mount import SHOWN_AT_M
from fcw.motion.state import Mount
from fcw.units import FEET_PER_METRE, distance_text
from fcw_viz.commands.calibrate.options import CalibrateCommand
from fcw_viz.commands.calibrate.points import save_and_report
from fcw_viz.console import RESULTS

MOVED = (
    "the camera points elsewhere than its calibration says, by more than the errors of both allow: it was "
    "moved, or the calibration was wrong; the pitch is taken from the drive alone"
)
MOST_DECIMALS = 2
GROWN = 1.02
"""An interval that is wider by more than this is said to be."""


def run_calibrate_from_drive(command: CalibrateCommand, drive: Path) -> int:
    """Take the mount that a drive believed at its end; returns the exit code.

    Raises:
        UserError: points were given too, there is nowhere to save to, the drive has no own motion or told
            nothing by it, or its log does not say what was undone of its pictures.
    """
    if command.points or command.source is not None:
        raise UserError("--from-drive: takes the drive's own camera; leave out the source and --points")
    if command.save is None:
        raise UserError(
            "--from-drive: --save is missing: the calibration file to write, e.g. the one beside the video"
        )
    before, mount = _believed(drive)
    learned = calibration_of_mount(before, mount, str(drive))
    after, imperial = learned.calibration, command.units == "imperial"
    known = [_interval_at(SHOWN_AT_M, calibration) for calibration in (before, after)]
    there = distance_text(SHOWN_AT_M, imperial)
    words = _words(known, imperial)
    if not command.json:
        RESULTS.print(
            f"the road at {there} is known to two times in three: {words[0]} by the drive's calibration, "
            f"{words[1]} now",
            highlight=False,
            soft_wrap=not RESULTS.is_terminal,
        )
    warnings = [MOVED] if learned.moved else []
    if known[1][1] - known[1][0] > GROWN * (known[0][1] - known[0][0]) or math.isinf(known[1][1]):
        warnings.append(
            f"this drive does not make distances better known: {there} is {words[1]} now, and was "
            f"{words[0]} by the drive's calibration; keep that calibration unless the camera was moved, or "
            "calibrate again"
        )
    return save_and_report(after, command.save, command, warnings)


def _interval_at(distance_m: float, calibration: Calibration) -> tuple[float, float]:
    return calibration.distance_interval(calibration.row_at(distance_m))


def _words(intervals: Sequence[tuple[float, float]], imperial: bool) -> list[str]:
    """The intervals, all to the same decimals: as many as tell the narrowest one's width to a tenth of it."""
    scale, unit = (FEET_PER_METRE, "ft") if imperial else (1.0, "m")
    narrowest = min((high_m - low_m) * scale for low_m, high_m in intervals)
    decimals = 0
    while decimals < MOST_DECIMALS and 10 * 10**-decimals > narrowest:
        decimals += 1
    return [
        f"{low_m * scale:.{decimals}f} {unit} to "
        + (f"{high_m * scale:.{decimals}f} {unit}" if math.isfinite(high_m) else "unbounded")
        for low_m, high_m in intervals
    ]


def _believed(drive: Path) -> tuple[Calibration, Mount]:
    from fcw.logs.mcap.reader import read_drive

    log = read_drive(drive)
    mount = None
    for result in log.results():
        if result.own_motion is not None and result.own_motion.mount is not None:
            mount = result.own_motion.mount
    if mount is None:
        raise UserError(
            f"{drive}: the pose of the camera was not estimated there; run it without --no-own-motion"
        )
    return log.header.calibration, mount
