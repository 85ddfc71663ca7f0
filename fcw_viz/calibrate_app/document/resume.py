"""What a session begins with: the journal of the work so far, a calibration file's points, or nothing."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, Priors
from fcw.camera.file import read_calibration
from fcw.camera.prior_sigmas import ROLL_SIGMA_RAD, YAW_SIGMA_RAD
from fcw.camera.uncertainty import camera_sigmas
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import FEWEST_PLATES, Belief, Document, Mark
from fcw_viz.calibrate_app.document.edits import Load
from fcw_viz.calibrate_app.document.history import Action, Event, History
from fcw_viz.calibrate_app.document.journal import Journal, file_digest, journal_path
from fcw_viz.calibrate_app.document.solution import calibration_of
from fcw_viz.calibrate_app.document.ways.ways import PLATES, RECTANGLE

FILE_PERSON = "calibration file"
"""Who did it, where the file did."""
SURE_RAD, SURE_PX = 1e-3, 0.1
"""A file may call its numbers exact."""
ALIKE_AT_M, ALIKE_PART = (5.0, 10.0, 20.0, 40.0), 0.02
"""Two cameras are alike whose distances there differ by a smaller part."""


@dataclass(frozen=True, slots=True)
class Beginning:
    """What a session begins with.

    Attributes:
        journal: open and locked.
        history: what happened before.
        saved: what the calibration file holds, calibrated anew; None where there is none that can be read, or
            where what it says of its points gives another camera.
        notice: what everybody should know of it; empty where there is nothing.
    """

    journal: Journal
    history: History
    saved: Calibration | None
    notice: str


def now() -> str:
    """The time of an event, with its zone."""
    return datetime.now().astimezone().isoformat(timespec="milliseconds")


def begin(
    source: Path,
    image_size: ImageSize,
    save_path: Path,
    fitted: Callable[[Calibration], Calibration] | None = None,
) -> Beginning:
    """Resume the journal beside `save_path`, else take the points of the calibration there, else none.

    A calibration file that another hand wrote since becomes the journal's last step, which can be undone.

    Raises:
        UserError: the journal cannot be used (see `Journal.open`).
    """
    in_file, notice = _read(save_path, fitted or (lambda calibration: calibration.for_image_size(image_size)))
    loaded = None if in_file is None else document_of(in_file)
    digest = file_digest(save_path)
    start = Document(image_size) if loaded is None else loaded
    journal, existed = Journal.open(journal_path(save_path), source.name, start, digest)
    content = journal.content
    history = content.history
    saved = None if loaded is None else _calibration(loaded)
    if in_file is not None and not (saved and _are_alike(saved, in_file)):
        # Made without what every lens has, or with vehicles or a speed, which no file keeps.
        saved = None
    if existed and in_file is not None and digest == content.saved_digest:
        # The file is this journal's own, which alone knows how sure the height was.
        own = _calibration(history.document)
        saved = own if own == in_file else saved
    if not existed:
        if loaded is not None:
            another = "" if saved else "They alone do not give the camera in that file; saving replaces it."
            notice = f"The points of {save_path.name} were loaded. {another or notice}".strip()
        return Beginning(journal, history, saved, notice)
    steps = f"{content.event_count} step" + ("" if content.event_count == 1 else "s")
    notices = [f"Your earlier work was restored: {steps} from {journal.path.name}."] * bool(
        content.event_count
    )
    if content.torn:
        notices.append(
            "The last step was cut off while being written and is lost: check the last thing you did."
        )
    if notice:
        notices.append(notice)
    foreign = loaded is not None and digest != content.saved_digest
    if loaded is not None and foreign and saved != _calibration(history.document):
        event = Event(now(), FILE_PERSON, Action.STEP, (Load(loaded),))
        history = history.after(event)
        journal.add(event)
        journal.add_saved(digest)
        notices.append(
            f"{save_path.name} was changed elsewhere, so its points are shown; undo brings yours back."
        )
    return Beginning(journal, history, saved, " ".join(notices))


def document_of(calibration: Calibration) -> Document:
    """What somebody must have said for this calibration: its points as marks, its priors as beliefs.

    Without points (of a clip, of vehicles) what nobody stated is that of its camera, as well as it is known.
    """
    middle_px = (calibration.image_size.width - 1) / 2
    marks = tuple(
        Mark(
            number,
            middle_px if point.column_px is None else point.column_px,
            point.row_px,
            point.distance_m,
        )
        for number, point in enumerate(calibration.points, 1)
    )
    priors = calibration.priors
    height_sigma_m = None
    if not (marks or calibration.rectangles or calibration.plates):
        found = _of_camera(calibration)
        priors = Priors(
            priors.field_of_view_rad or found.field_of_view_rad,
            priors.principal_row_px or found.principal_row_px,
            priors.horizon_row_px or found.horizon_row_px,
        )
        height_sigma_m = _height_sigma_m(calibration)
    field_of_view, principal_row, horizon = (
        None if prior is None else Belief(prior)
        for prior in (priors.field_of_view_rad, priors.principal_row_px, priors.horizon_row_px)
    )
    rectangles = calibration.rectangles
    plates = tuple(plate.places_px for plate in calibration.plates)
    has_size = any(rectangle.has_size for rectangle in rectangles) or len(plates) >= FEWEST_PLATES
    along = any(rectangle.along for rectangle in rectangles)
    offset_m, turned = calibration.reference_offset_m, calibration.orientation
    default = Document(calibration.image_size)
    return Document(
        calibration.image_size,
        marks,
        len(marks) + 1,
        # What rectangles and plates tell again is not told twice.
        height_m=None if has_size else calibration.camera.height_m,
        height_sigma_m=height_sigma_m,
        from_bumper=offset_m > 0,
        bumper_offset_m=offset_m if offset_m > 0 else None,
        # A camera known by other means has no clicks, and so no error of one.
        row_sigma_px=calibration.row_sigma_px or default.row_sigma_px,
        field_of_view=field_of_view,
        principal_row=principal_row,
        horizon=horizon,
        tape_error=calibration.tape_error if calibration.points or rectangles else default.tape_error,
        lens=calibration.lens,
        yaw=None if along else _turn(turned.yaw_rad, turned.yaw_sigma_rad, YAW_SIGMA_RAD),
        roll=None if rectangles else _turn(turned.roll_rad, turned.roll_sigma_rad, ROLL_SIGMA_RAD),
        way="" if marks else RECTANGLE if rectangles else PLATES if plates else "",
        rectangles=rectangles,
        plates=plates,
        plate_width_m=calibration.plates[0].width_m if plates else default.plate_width_m,
    )


def _are_alike(one: Calibration, other: Calibration) -> bool:
    """Whether two cameras see all distances nearly alike."""
    rows_px = other.row_at(np.array(ALIKE_AT_M))
    return bool(np.allclose(one.distance_at(rows_px), ALIKE_AT_M, rtol=ALIKE_PART, atol=0.0))


def _turn(value_rad: float, sigma_rad: float, unknown_rad: float) -> Belief | None:
    """What a file says of yaw or roll; None where it only says that nothing is known."""
    if value_rad == 0 and sigma_rad in (0.0, unknown_rad):
        return None
    return Belief(Gaussian(value_rad, sigma_rad or SURE_RAD))


def _height_sigma_m(calibration: Calibration) -> float | None:
    """What the file's rows have uncertain of all distances alike and its view does not say; None for nothing.

    It is of the height, or of a measured lens's focal length, which does to distances what the height would.
    """
    part = camera_sigmas(calibration).focal_y_px / calibration.camera.focal_y_px
    if calibration.lens is None:
        view = calibration.priors.field_of_view_rad
        said = part if view is None else view.sigma / math.sin(view.value)
        part = math.sqrt(max(part**2 - said**2, 0.0))
    return part * calibration.camera.height_m or None


def _of_camera(calibration: Calibration) -> Priors:
    """The camera itself as beliefs."""
    camera, sigmas = calibration.camera, camera_sigmas(calibration)
    half_px = calibration.image_size.width / 2
    view_by_focal = 2 * half_px / (camera.focal_y_px**2 + half_px**2)
    horizon = Gaussian(camera.horizon_row_px, max(sigmas.horizon_row_px, SURE_PX))
    if calibration.lens is not None:
        return Priors(None, None, horizon)
    return Priors(
        Gaussian(calibration.field_of_view_rad, max(view_by_focal * sigmas.focal_y_px, SURE_RAD)),
        Gaussian(camera.principal_row_px, max(sigmas.principal_row_px, SURE_PX)),
        horizon,
    )


def _read(save_path: Path, fitted: Callable[[Calibration], Calibration]) -> tuple[Calibration | None, str]:
    if not save_path.exists():
        return None, ""
    try:
        return fitted(read_calibration(save_path)), ""
    except UserError as error:
        return None, f"The calibration there is not used: {error}. Saving replaces it."


def _calibration(document: Document) -> Calibration | None:
    try:
        return calibration_of(document)
    except UserError:
        return None
