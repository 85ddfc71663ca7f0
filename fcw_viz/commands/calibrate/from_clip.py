"""`fcw calibrate SOURCE --from-clip`: a recorded clip calibrated without any mark on the road."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, Priors
from fcw.camera.file import default_path
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.lens.model import Lens
from fcw.camera.points import check_each, check_priors
from fcw.camera.straight import LEVEL
from fcw.errors import UserError
from fcw.files import CALIBRATION, check_kind, check_place
from fcw.frame import Source
from fcw.warning.ego_speed import speed_fault
from fcw_viz.commands.calibrate.evidence import evidence_warnings, stated_evidence, stated_height
from fcw_viz.commands.calibrate.options import CalibrateCommand
from fcw_viz.commands.calibrate.points import ground_point, save_and_report
from fcw_viz.commands.calibrate.priors import stated_lens, stated_priors
from fcw_viz.console import progress

if TYPE_CHECKING:
    from fcw.self_calibration.clip import ClipCalibration

LENS_SIGMA = 0.01
"""Of the focal length of a lens that is given, as a part."""
SAID_SIGMAS = 2.0
"""A contradiction that chance makes one time in twenty."""
NO_ROAD = (
    "nothing in this clip shows where the road lies in the picture: no straight driving, no lane lines, "
    "hardly a vehicle. The camera is assumed to point as most do, and distances may be off by a factor of "
    "two; for better ones give --horizon-row, points or lane lines, or a clip of a straight road by day"
)
NO_MOTION = (
    "the motion of the camera could not be used: too few pictures, or the car stands, turns or is in the "
    "dark; the result rests on everything else that the clip shows"
)


def run_calibrate_from_clip(command: CalibrateCommand) -> int:
    """Look through the clip, solve, save and print; returns the exit code.

    Raises:
        UserError: there is no source, or what it shows and what was said does not determine a camera.
    """
    from fcw.self_calibration.clip import VEHICLE_HEIGHTS_M
    from fcw.sources import open_source
    from fcw.sources.bars import without_bars

    given = _checked_source(command)
    height_m = VEHICLE_HEIGHTS_M[command.vehicle_class]
    if command.height is not None:
        height_m = stated_height(command)
    source = open_source(given, topic=command.topic)
    save = command.save or default_path(given)
    check_place(save, "" if command.save else "--save FILE")
    check_kind(save, *CALIBRATION)
    size = source.image_size
    priors = stated_priors(command, size)
    check_priors(priors)
    evidence = stated_evidence(command) or Evidence()
    if command.points:
        points = tuple(ground_point(text) for text in command.points)
        check_each(points, size)
        evidence = replace(evidence, points=points)
    lens = stated_lens(command, size)
    source, cut = without_bars(source)
    if cut is not None:
        # What is said of the field of view is said of the camera, whose picture has no bars.
        rows = replace(priors, field_of_view_rad=None).through(cut, size)
        priors = replace(rows, field_of_view_rad=priors.field_of_view_rad)
        evidence = evidence.moved(cut.places, (size.width - 1) / 2)
        lens = None if lens is None else lens.through(cut)
    notes: tuple[str, ...] = ()
    with progress(source.name, None) as bar:
        look = partial(_look, command, source, height_m, evidence, priors, bar.advance)
        found = look(lens, LENS_SIGMA)
        if found.lens is not None and found.focal_px is not None:
            part = found.focal_px.sigma / found.focal_px.value
            notes = (_bends(found.lens, part, evidence == Evidence()),)
            if evidence == Evidence():
                lens = found.lens
                found = look(lens, part)
                lens = _refocused(lens, found.calibration.camera.focal_y_px)
    calibration = found.calibration
    if lens is not None:
        calibration = _of_pictures(calibration, lens, evidence)
    if cut is not None:
        calibration = calibration.through(cut.back(size))
    notes += source.notes
    if not evidence.has_distances:
        notes += _assumed(command, height_m, calibration.assumed, found.focal_px)
    notes += tuple(_notes_of(found))
    notes += tuple(evidence_warnings(command, calibration))
    return save_and_report(calibration, save, command, notes)


def _checked_source(command: CalibrateCommand) -> Path:
    """The source, once the options are checked that need nothing of it."""
    if command.source is None:
        raise UserError("--from-clip: name the video or folder of pictures to calibrate")
    if command.exact:
        raise UserError("--exact: takes only --points; leave out --from-clip")
    if command.speed is not None and not command.speed > 0:
        raise UserError(f"--speed {command.speed:g}: expected metres a second above 0")
    if command.speed is not None and (fault := speed_fault(command.speed)):
        raise UserError(f"--speed {command.speed:g}: {fault}")
    return command.source


def _notes_of(found: "ClipCalibration") -> Iterator[str]:
    """What a person should know of how a clip was calibrated."""
    if not found.shows_road:
        yield NO_ROAD
    elif not found.by_motion:
        yield NO_MOTION
    if found.contradiction is not None and found.contradiction.sigmas > SAID_SIGMAS:
        yield _contradicts(found.contradiction.apart_rad)
    if found.piece_words:
        yield _cut(found.piece_words) if found.is_cut else _jump(found.piece_words)


def _look(
    command: CalibrateCommand,
    source: Source,
    height_m: Gaussian,
    evidence: Evidence,
    priors: Priors,
    on_frame: Callable[[], None],
    lens: Lens | None,
    lens_sigma: float,
) -> "ClipCalibration":
    """Look through a clip, and through its lens where it is known, to `lens_sigma` of its focal length."""
    from fcw.camera.straight import Straightening
    from fcw.detection.choice import searching_detector
    from fcw.self_calibration.clip import calibrate_clip, rough_calibration
    from fcw.sources.straight import StraightSource

    size, column_px = source.image_size, None
    guess = rough_calibration(size, height_m.value, priors)
    if lens is not None:
        column_px = lens.column_px
        camera = replace(
            guess.camera,
            focal_y_px=lens.focal_y_px,
            principal_row_px=lens.row_px,
            principal_column_px=column_px,
        )
        way = Straightening(camera, LEVEL, lens, size)
        source = StraightSource(source, way)
        evidence = evidence.moved(
            lambda places: tuple(
                (column, row) for column, row in way.to_straight(np.array(places, float)).tolist()
            ),
            column_px,
        )
        guess = replace(guess, camera=camera)
        view_rad = guess.field_of_view_rad
        view = Gaussian(view_rad, lens_sigma * math.sin(view_rad))
        priors = Priors(view, Gaussian(lens.row_px, 3.0), priors.horizon_row_px)
    detector = searching_detector(guess)
    stated = Known(
        evidence,
        size,
        height_m,
        command.reference_offset,
        command.row_sigma,
        priors,
        tape_error=command.tape_error,
        axis_column_px=column_px,
    )
    return calibrate_clip(source, detector, stated, command.speed, on_frame)


def _of_pictures(calibration: Calibration, lens: Lens, evidence: Evidence) -> Calibration:
    """The calibration of the pictures as they are, where it is of those made straight through the lens.

    Args:
        calibration: of the straight pictures.
        lens: that was undone.
        evidence: as it was clicked.
    """
    points = tuple(
        replace(clicked, distance_m=point.distance_m)
        for clicked, point in zip(evidence.points, calibration.points, strict=True)
    )
    return replace(
        calibration, lens=lens, points=points, rectangles=evidence.rectangles, plates=evidence.plates
    ).with_residuals()


def _refocused(lens: Lens, focal_px: float) -> Lens:
    """A measured lens with the focal length that the fit gave the straight picture, so that both stay one."""
    return replace(lens, focal_x_px=focal_px, focal_y_px=focal_px)


def _bends(lens: Lens, part: float, taken: bool) -> str:
    """That the lens bends the picture, as its turns tell, and what comes of it."""
    edge = lens.undistorted(np.array([[0.0, lens.row_px]]))[0, 0]
    view_deg = 2 * math.degrees(math.atan(-edge))
    told = (
        f"the lens bends straight lines: the turns in the clip show that it sees about {view_deg:.0f} "
        f"degrees from side to side, with a focal length of {lens.focal_y_px:.0f} px ± {100 * part:.0f} %"
    )
    if taken:
        return (
            f"{told}; its distortion is saved with the calibration and corrected; give a more precise lens "
            "with --lens"
        )
    return f"{told}; the values that you gave are used as if it did not: give the lens with --lens"


def _assumed(
    command: CalibrateCommand, height_m: Gaussian, assumed: Priors, focal_px: Gaussian | None
) -> tuple[str, ...]:
    """What nobody said of the camera, to which every distance is proportional, and how to say it."""
    taken, options = [], []
    if command.height is None and command.speed is None:
        taken.append(
            f"a height of {height_m.value:.2f} ± {height_m.sigma:.2f} m (of a {command.vehicle_class})"
        )
        options.append("--height (metres from the road up to the lens)")
    view = assumed.field_of_view_rad
    if view is not None:
        value_deg, sigma_deg = math.degrees(view.value), math.degrees(view.sigma)
        taken.append(f"a field of view of {value_deg:.0f} ± {sigma_deg:.0f} degrees (of any camera)")
        options.append("--field-of-view (degrees from side to side, by the data sheet)")
    if not taken:
        return ()
    text = f"rough: this assumes {' and '.join(taken)}, and distances are as uncertain as that"
    if view is not None and focal_px is not None:
        part = 100 * focal_px.sigma / focal_px.value
        text = (
            f"rough: this assumes {' and '.join(taken)}, and takes the focal length from the turns in the "
            f"clip: {focal_px.value:.0f} px ± {part:.0f} %"
        )
    return (f"{text}; give {' and '.join(options)}",)


def _contradicts(apart_rad: float) -> str:
    return (
        f"the direction of travel and the vehicles ahead give horizons {math.degrees(apart_rad):.1f} "
        "degrees apart: one of them is wrong, and distances are known no better than that; give "
        "--horizon-row, points or lane lines"
    )


def _cut(piece: str) -> str:
    return (
        f"this clip is cut, as by editing; the calibration is that of its longest part, {piece}, and holds "
        "for the others only if they are from the same camera; split the file there and calibrate each part"
    )


def _jump(piece: str) -> str:
    return (
        "the horizon jumps in this clip: the camera was moved, or the road gets very steep; the "
        f"calibration holds {piece}, and distances are wrong in the rest; split the clip there and "
        "calibrate each part"
    )
