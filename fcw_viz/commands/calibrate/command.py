"""`fcw calibrate`: with points on the command line, or as the page that they are clicked on."""

from dataclasses import fields

from fcw.errors import UserError
from fcw_viz.commands.calibrate.options import CalibrateCommand


def run_calibrate(command: CalibrateCommand) -> int:
    """Run `fcw calibrate`, with points, or as a page until it is interrupted; returns the exit code.

    Raises:
        UserError: the input is wrong or determines no camera; nothing is saved then.
    """
    from fcw_viz.commands.calibrate.evidence import check_reference_offset

    check_reference_offset(command.reference_offset)
    if command.from_drive is not None:
        _check_taken(command, "--from-drive", "from_drive", "points", "export", "units")
        from fcw_viz.commands.calibrate.from_drive import run_calibrate_from_drive

        return run_calibrate_from_drive(command, command.from_drive)
    if command.chessboard is not None:
        _check_taken(command, "--chessboard", "chessboard")
        from fcw_viz.commands.calibrate.chessboard import run_calibrate_chessboard

        return run_calibrate_chessboard(command, command.chessboard)
    if command.from_clip:
        from fcw_viz.commands.calibrate.from_clip import run_calibrate_from_clip

        return run_calibrate_from_clip(command)
    if command.speed is not None:
        raise UserError("--speed: only with --from-clip; the page asks for it in the way of a known speed")
    if command.source is not None and not marked(command):
        from fcw_viz.commands.calibrate.page import run_calibrate_page

        return run_calibrate_page(command, command.source)
    from fcw_viz.commands.calibrate.points import run_calibrate_points

    return run_calibrate_points(command)


def _check_taken(command: CalibrateCommand, way: str, *taken: str) -> None:
    """Refuse options that a way to calibrate has no use for: ignored in silence they would seem to count.

    Raises:
        UserError: naming the option.
    """
    always = ("source", "save", "json", "port", "no_open", "dark")
    for field in fields(command):
        if field.name not in (*always, *taken) and getattr(command, field.name) != field.default:
            raise UserError(f"--{field.name.replace('_', '-')}: {way} does not use it; leave it out")


def marked(command: CalibrateCommand) -> bool:
    """Whether something of the road is stated."""
    marks = (command.points, command.lane_line, command.dashes, command.rectangle, command.plate)
    return any(marks) or command.horizon_line is not None
