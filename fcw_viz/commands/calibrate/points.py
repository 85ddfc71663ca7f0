"""`fcw calibrate --points`: the calibration from points on the command line; it needs no browser."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from rich.text import Text

from fcw.bounded.pictures import LONGEST_SIDE_PX
from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.export import export_text
from fcw.camera.file import default_path, write_calibration
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.points import (
    PARAMETER_COUNT,
    PointsError,
    PointsFault,
    check_points,
    distinct_distances,
)
from fcw.camera.prior_sigmas import UNKNOWN_HEIGHT_M
from fcw.camera.solve import calibrate
from fcw.camera.verdicts.sky import lies_in_sky
from fcw.camera.verdicts.tilt import tilted_instead
from fcw.camera.verdicts.words import cause_of
from fcw.errors import UserError
from fcw.files import write_whole
from fcw.frame import ImageSize
from fcw_viz.commands.calibrate.evidence import (
    check_height,
    evidence_warnings,
    stated_evidence,
    stated_height,
)
from fcw_viz.commands.calibrate.options import CalibrateCommand
from fcw_viz.commands.calibrate.priors import stated_lens, stated_priors
from fcw_viz.commands.calibrate.summary import calibration_summary, print_report
from fcw_viz.console import MESSAGES, RESULTS, print_json
from fcw_viz.outputs import check_distinct


def run_calibrate_points(command: CalibrateCommand) -> int:
    """Solve, save and print; returns the exit code.

    Raises:
        UserError: the input is wrong or determines no camera; nothing is saved then.
    """
    save = command.save
    if save is None and command.source is not None:
        save = default_path(command.source)
    calibration = _calibration(command)
    return save_and_report(calibration, save, command, evidence_warnings(command, calibration))


def save_and_report(
    calibration: Calibration, save: Path | None, command: CalibrateCommand, causes: Sequence[str] = ()
) -> int:
    """Save and print a calibration; returns the exit code.

    Args:
        calibration: the result.
        save: where to; None does not.
        command: how to print it, and what else to write.
        causes: what is known to be wrong with what was said.

    Raises:
        UserError: what is to be exported has no place in that format; nothing is saved then.
    """
    summary = calibration_summary(calibration, bool(command.dashes), causes)
    if save is not None and command.export is not None:
        check_distinct(("export", command.export[1]), ("save", save))  # which may be the default
    exported = None if command.export is None else export_text(calibration, command.export[0])
    if save is not None:
        write_calibration(calibration, save)
    if command.export is not None and exported is not None:
        write_whole(command.export[1], exported)

    for warning in summary["warnings"]:
        text = Text.assemble(("warning:", "yellow"), f" {warning}")
        MESSAGES.print(text, soft_wrap=not MESSAGES.is_terminal)
    if command.json:
        result = summary | {"saved": save and str(save)}
        print_json(result)
    else:
        taped = bool(command.points) or not (command.from_clip or command.from_drive)
        print_report(calibration, save, RESULTS, command.units == "imperial", taped)
    return 0


def _calibration(command: CalibrateCommand) -> Calibration:
    evidence = stated_evidence(command)
    if evidence is None and not command.points:
        raise UserError(
            "no points: name a video or a picture to click them in, or give at least three as --points "
            "DISTANCE:ROW ..., for example --points 8:594 15:513 40:455 --image-size 1280x720 --height 1.2"
        )
    rectangles = () if evidence is None else evidence.rectangles
    sized = bool(command.plate) or any(rectangle.has_size for rectangle in rectangles)
    if command.height is not None:
        check_height(command.height)
    elif not sized:
        raise UserError("--height is missing: the height of the camera's lens above the road, in metres")
    points = tuple(ground_point(text) for text in command.points)
    size = _image_size(command)
    lens = stated_lens(command, size)
    everything = evidence or Evidence()
    known = Known(
        replace(everything, points=points) if points else everything,
        size,
        stated_height(command),
        command.reference_offset,
        command.row_sigma,
        stated_priors(command, size),
        lens,
        command.tape_error,
    )
    calibration = _of_rows(command, known, sized) if points else None
    if command.exact:
        if calibration is None or evidence is not None or lens is not None:
            raise UserError(
                "--exact: takes only --points; leave out all other knowledge of the camera and the road"
            )
        return calibration
    return calibration if calibration is not None and known.is_of_rows else calibrate_jointly(known)


def _of_rows(command: CalibrateCommand, known: Known, sized: bool) -> Calibration | None:
    """What the points alone say, whose mistakes are so found also where much else is known.

    Args:
        command: with all that was said.
        known: the same, for one fit.
        sized: whether something else besides tells how large everything is.

    Returns:
        None where all else makes up for points that are too few, or for what its lens does to them.
    """
    points, size, priors = known.evidence.points, known.image_size, known.priors
    height_m = UNKNOWN_HEIGHT_M if command.height is None else command.height

    def of(taped: Sequence[GroundPoint]) -> Calibration:
        return calibrate(
            taped,
            size,
            height_m,
            command.reference_offset,
            command.row_sigma,
            priors.field_of_view_rad,
            priors.principal_row_px,
            priors.horizon_row_px,
            tape_error=command.tape_error,
            exact=command.exact,
        )

    told = len(distinct_distances([point.distance_m for point in points])) + priors.count
    # A lens is its focal length and its axis; two lines meet on the horizon.
    besides = 2 * (known.lens is not None)
    besides += len(known.evidence.lines) > 1 or known.evidence.horizon is not None
    try:
        if told < PARAMETER_COUNT and (sized or told + besides >= PARAMETER_COUNT):
            check_points(points, size, command.row_sigma, PARAMETER_COUNT)
            return None
        return of(points)
    except PointsError as error:
        if known.lens is not None and error.fault is PointsFault.SAME_DISTANCE:
            return None  # beside each other, a lens that bends the picture moves them
        for k, point in enumerate(points):
            others = points[:k] + points[k + 1 :]
            place = (point.column_px, point.row_px, point.distance_m)
            if lies_in_sky(*place, others, lambda others=others: of(others), command.row_sigma):
                raise UserError(
                    f"the point {point} lies above the horizon that the other points give, in the sky; "
                    "click a mark on the road"
                ) from None
        if not command.exact:
            with suppress(PointsError):
                return tilted_instead(known, error)
        cause = cause_of(
            error,
            points,
            size,
            height_m,
            command.reference_offset,
            command.row_sigma,
            priors,
            command.tape_error,
        )
        raise (error if cause is None else error.with_cause(cause)) from None


def _image_size(command: CalibrateCommand) -> ImageSize:
    stated = None if command.image_size is None else _stated_size(command.image_size)
    if command.source is None:
        if stated is None:
            raise UserError(
                "--image-size is missing: width and height of the picture that the points were clicked in, "
                "for example --image-size 1280x720"
            )
        return stated
    from fcw.sources import open_source  # decoders, which points alone do not need

    size = open_source(command.source, topic=command.topic).image_size
    if stated is not None and stated != size:
        raise UserError(
            f"--image-size {stated}: the pictures of {command.source} are {size}; "
            "click the points in one of them and leave --image-size out"
        )
    return size


def ground_point(text: str) -> GroundPoint:
    """A point from `DISTANCE:ROW` or `DISTANCE:ROW:COLUMN`."""
    try:
        distance_m, row_px, *rest = (float(part) for part in text.split(":"))
        (column_px,) = rest or (None,)
    except ValueError:
        raise UserError(
            f"--points {text}: expected DISTANCE:ROW or DISTANCE:ROW:COLUMN, metres and pixels, "
            "for example 8:594 or 8:594:640 (a video or folder is named before --points)"
        ) from None
    return GroundPoint(distance_m, row_px, column_px)


def _stated_size(text: str) -> ImageSize:
    """An image size from `WIDTHxHEIGHT`."""
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        raise UserError(
            f"--image-size {text}: expected WIDTHxHEIGHT in pixels, for example 1280x720"
        ) from None
    if not 1 <= min(width, height) <= max(width, height) <= LONGEST_SIDE_PX:
        raise UserError(f"--image-size {text:.60}: expected sides from 1 to {LONGEST_SIDE_PX} pixels")
    return ImageSize(width, height)
