"""`fcw calibrate --from-drive`: what a drive taught of the mount becomes the calibration."""

from pathlib import Path

from fcw.camera.calibration import Calibration
from fcw.errors import UserError
from fcw.motion.mount import calibration_of_mount
from fcw.motion.state import Mount
from fcw_viz.commands.calibrate.options import CalibrateCommand
from fcw_viz.commands.calibrate.points import save_and_report


def run_calibrate_from_drive(command: CalibrateCommand, drive: Path) -> int:
    """Take the mount that a drive believed at its end; returns the exit code.

    Raises:
        UserError: points were given too, there is nowhere to save to, or the drive has no own motion.
    """
    if command.points or command.source is not None:
        raise UserError("--from-drive: takes the drive's own camera; leave out the source and --points")
    if command.save is None:
        raise UserError(
            "--from-drive: --save is missing: the calibration file to write, e.g. the one beside the video"
        )
    calibration, mount = _believed(drive)
    return save_and_report(calibration_of_mount(calibration, mount), command.save, command)


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
