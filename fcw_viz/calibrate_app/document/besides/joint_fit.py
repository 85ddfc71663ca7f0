"""The one fit of everything on the page, where marks and beliefs of rows alone do not hold it."""

from dataclasses import replace

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, NumberPlate, Priors
from fcw.camera.joint.bent import FEWEST_PLACES, WIDE_BEND, BentPicture, bent_picture
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.joint.odd_rectangle import swap_gain
from fcw.camera.joint.rectangle import check_rectangle
from fcw.camera.joint.uneven import UnevenDashes, uneven_dashes
from fcw.camera.prior_sigmas import UNKNOWN_HEIGHT_M, UNKNOWN_HEIGHT_SIGMA_M
from fcw.camera.vanishing import Segment, combined, vanishing_row
from fcw.errors import UserError
from fcw.self_calibration.speed import SPEED_SIGMA
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.document.ways.height import MEASURED_SIGMA_M

FEWEST_VEHICLES = 5
"""Fewer say more of themselves than of the camera."""


def stated(
    document: Document,
    points: tuple[GroundPoint, ...],
    assumed_height_m: float = UNKNOWN_HEIGHT_M,
    assumed_offset_m: float = 0.0,
) -> Known:
    """Everything that was said, for one fit.

    Args:
        document: what was said.
        points: marks that take part, with their distances.
        assumed_height_m: where no height was said, for the preview.
        assumed_offset_m: the same of the bumper.
    """
    if document.height_m is None:
        assumed_m = UNKNOWN_HEIGHT_M if document.has_size else assumed_height_m
        height_m = Gaussian(assumed_m, UNKNOWN_HEIGHT_SIGMA_M)
    else:
        height_m = Gaussian(document.height_m, document.height_sigma_m or MEASURED_SIGMA_M)
    offset_m = document.reference_offset_m
    return Known(
        _evidence(document, points),
        document.image_size,
        height_m,
        assumed_offset_m if offset_m is None else offset_m,
        document.row_sigma_px,
        _priors(document),
        document.lens,
        document.tape_error,
        WIDE_BEND if document.bent else None,
    )


def with_lane_horizon(calibration: Calibration, document: Document) -> Calibration:
    """A calibration among whose priors is where the lane lines meet: what contradicts them is so told.

    Args:
        calibration: of everything; what was said of the horizon's row is of its straight picture.
        document: what was said.
    """
    lines = [
        (calibration.straight_place(*start), calibration.straight_place(*end))
        for start, end in _lines(document)
    ]
    if len(lines) < 2:
        return calibration
    stated_horizon = calibration.priors.horizon_row_px
    try:
        met = vanishing_row(lines[0], lines[1], document.row_sigma_px)
    except UserError:  # that they do not meet ahead is told of them
        return calibration
    horizon = combined([met] if stated_horizon is None else [stated_horizon, met])
    return replace(calibration, priors=replace(calibration.priors, horizon_row_px=horizon))


def bent_lens(document: Document, known: Known) -> BentPicture | None:
    """The lens that bends the picture, where none was said and what was clicked shows it."""
    if document.lens is not None or document.bent:
        return None
    return bent_picture(known)


def broken_period(document: Document, known: Known) -> UnevenDashes | None:
    """Dashes that likely do not keep the period that was said."""
    if not document.paced or document.bent:
        return None
    return uneven_dashes(known)


def sides_are_exchanged(document: Document, rectangle: int) -> bool:
    """Whether a rectangle fits everything else better with its sides exchanged."""
    points = tuple(mark.ground_point for mark in document.marks if mark.ground_point is not None)
    try:
        known = stated(document, points)
        check_rectangle(known.evidence.rectangles[rectangle], document.image_size)
    except UserError:
        return False
    return swap_gain(known, rectangle) > 0


def _evidence(document: Document, points: tuple[GroundPoint, ...]) -> Evidence:
    if document.paced and points:
        first_m = min(point.distance_m for point in points)
        points = tuple(GroundPoint(p.distance_m - first_m, p.row_px, p.column_px) for p in points)
    speed = _stated(document.speed)
    scale = None
    if speed is not None and document.scale_per_mps is not None:
        value = speed.value * document.scale_per_mps
        scale = Gaussian(value, value * (SPEED_SIGMA**2 + (speed.sigma / speed.value) ** 2) ** 0.5)
    return Evidence(
        points,
        document.paced,
        _lines(document),
        _lane_width(document),
        rulers=document.vehicles,
        yaw_rad=_stated(document.yaw),
        roll_rad=_stated(document.roll),
        scale_px_m=scale,
        rectangles=document.whole_rectangles,
        plates=tuple(NumberPlate(places, document.plate_width_m) for places in document.whole_plates),
        edges=tuple(edge for edge in document.edges if len(edge) >= FEWEST_PLACES),
    )


def _priors(document: Document) -> Priors:
    horizon = _stated(document.horizon)
    if document.lens is not None:
        return Priors(None, None, horizon)
    return Priors(_stated(document.field_of_view), _stated(document.principal_row), horizon)


def _stated(belief: Belief | None) -> Gaussian | None:
    return belief.prior if belief is not None and belief.enabled else None


def _lines(document: Document) -> tuple[Segment, ...]:
    """Both lane lines, or the one there is; none where the two do not meet ahead, which is told of them."""
    if not document.lane_lines_enabled:
        return ()
    lines = tuple((line.start_px, line.end_px) for line in document.lane_lines if line is not None)
    try:
        if len(lines) > 1:
            vanishing_row(lines[0], lines[1], document.row_sigma_px)
    except UserError:
        return ()
    return lines


def _lane_width(document: Document) -> Gaussian | None:
    """Where both lines are there that it lies between."""
    return _stated(document.lane_width) if len(_lines(document)) == len(document.lane_lines) else None
