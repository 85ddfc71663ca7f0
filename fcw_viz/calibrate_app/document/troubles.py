"""What is wrong with what somebody said, beside the marks that cause it, and the edits that would mend it."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.plausibility import FindingKind, noise_explains, plausibility
from fcw.camera.points import PARAMETER_COUNT, PointsError, PointsFault
from fcw.errors import UserError
from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.document import words
from fcw_viz.calibrate_app.document.document import Belief, Document, Mark
from fcw_viz.calibrate_app.document.edits import (
    Edit,
    EnableLaneLines,
    EnableMark,
    SetDistance,
    SetFieldOfView,
    SetHeight,
    SetHorizon,
    SetPrincipalRow,
    SetReference,
    SetUnits,
)
from fcw_viz.calibrate_app.document.state import Mend, Result, Trouble

Calibrate = Callable[[Document], Calibration | None]
"""The calibration of a document: None where something is missing; raises UserError where none follows."""

CAMERA_FINDINGS = frozenset(
    (
        FindingKind.PITCH,
        FindingKind.FIELD_OF_VIEW,
        FindingKind.PRINCIPAL_ROW,
        FindingKind.HORIZON,
        FindingKind.CAUSE,
    )
)
OFFSET_DECIMALS = 2
"""Nobody measures a car more finely than to a centimetre."""
NARROWEST_USUAL_RAD = math.radians(40.0)
"""Horizontal; dash cameras see more than this, if not by far."""
HEIGHT_RANGE_M = (0.6, 3.5)
"""Of a lens behind a windscreen, from a low sports car to a lorry."""
UNITS_M = {"metres": 1.0, "feet": 1 / FEET_PER_METRE, "centimetres": 0.01, "inches": 0.0254}
PRINCIPAL_ROW_SIGMA_HEIGHTS = 0.03
"""How far lens and sensor are off centre in ordinary cameras, in picture heights."""


def degenerate_troubles(
    document: Document, error: UserError, calibrate: Calibrate, thorough: bool
) -> tuple[Trouble, ...]:
    """Why a document determines no camera.

    Args:
        document: what was said.
        error: what calibrating it raised.
        calibrate: tries what a mend would make of it.
        thorough: whether to look for a mend.
    """
    if not isinstance(error, PointsError):
        return (Trouble(_sentence(str(error))),)
    marks = _marks_of(document, error)
    mend = _point_mend(document, error, marks, calibrate) if thorough else None
    text = words.degenerate(error, marks, document.imperial)
    return (Trouble(text, tuple(mark.id for mark in marks), mend),)


def implausible_troubles(
    document: Document, marks: Sequence[Mark], result: Result, calibrate: Calibrate, thorough: bool
) -> tuple[Trouble, ...]:
    """What speaks against a result, the likely cause first.

    Args:
        document: what was said.
        marks: those that took part, in the order of the calibration's points.
        result: what followed.
        calibrate: tries what a mend would make of it.
        thorough: whether to look for mends that take several solutions.
    """
    troubles: list[Trouble] = list(_height_troubles(document))
    calibration = result.calibration
    if any(finding.kind in CAMERA_FINDINGS for finding in result.findings):
        troubles.append(_camera_trouble(document, result, calibrate, thorough))
    by_point = dict(zip(calibration.points, marks, strict=True))
    for finding in result.findings:
        if finding.point is not None:
            mark = by_point[finding.point]
            if finding.kind is FindingKind.RESIDUAL:
                residual_px = result.residuals[mark.id].row_px
                text = words.residual_trouble(mark, residual_px, document.row_sigma_px)
                lone = _leave_one_out(document, calibrate) if thorough else None
                mend = lone[1] if lone else _leave_out(mark)
            else:
                text, mend = words.outside_trouble(mark), _leave_out(mark)
            troubles.append(Trouble(text, (mark.id,), mend))
        elif finding.prior is not None:
            troubles.append(_prior_trouble(document, calibration, finding.prior))
    return tuple(troubles)


@dataclass(frozen=True, slots=True)
class _Cause:
    """Why a camera may have come out implausible, and what would mend it."""

    text: str
    mend: Mend
    mark_ids: tuple[int, ...] = ()


def _camera_trouble(document: Document, result: Result, calibrate: Calibrate, thorough: bool) -> Trouble:
    text = words.camera_trouble(result.calibration, result.findings)

    def is_unusual(cause: _Cause) -> bool:
        calibration = _mended(document, cause.mend, calibrate)
        return calibration is None or calibration.field_of_view_rad < NARROWEST_USUAL_RAD

    causes = list(_causes(document, result, calibrate, thorough))
    if thorough:
        # Several may explain it; feet, for one, also look like a tele lens with this or that besides.
        causes.sort(key=is_unusual)
    if causes:
        cause = causes[0]
        return Trouble(f"{text} {cause.text}", cause.mark_ids, cause.mend)
    return Trouble(f"{text} {words.UNKNOWN_CAUSE}")


def _causes(document: Document, result: Result, calibrate: Calibrate, thorough: bool) -> Iterator[_Cause]:
    """What makes a plausible camera of it, the likeliest first."""
    proposal = next((finding.offset for finding in result.findings if finding.offset), None)
    if proposal is not None:
        offset_m = round(proposal.offset_m, OFFSET_DECIMALS)
        mend = Mend(words.offset_label(document, offset_m), (SetReference(True, offset_m),))
        yield _Cause(words.offset_cause(document, proposal), mend)
    if not thorough:
        return
    if noise_explains(result.calibration, result.sigmas):
        middle_px = (document.image_size.height - 1) / 2
        prior = Gaussian(middle_px, PRINCIPAL_ROW_SIGMA_HEIGHTS * document.image_size.height)
        mend = Mend(words.MIDDLE_LABEL, (SetPrincipalRow(Belief(prior)),))
        if _makes_plausible(document, mend, calibrate):
            yield _Cause(words.noise_cause(result.sigmas.principal_row_px), mend)
    for cause, mend in _unit_mends(document):
        if _makes_plausible(document, mend, calibrate):
            yield _Cause(cause, mend)
    if lone := _leave_one_out(document, calibrate):
        mark, mend = lone
        yield _Cause(words.lone_cause(mark), mend, (mark.id,))


def _height_troubles(document: Document) -> Iterator[Trouble]:
    """A height that no windscreen has, and the unit that it may have been meant in."""
    lowest_m, highest_m = HEIGHT_RANGE_M
    height_m = document.height_m
    if height_m is None or lowest_m <= height_m <= highest_m:
        return
    typed = height_m * FEET_PER_METRE if document.imperial else height_m
    meant = {unit: round(typed * unit_m, 4) for unit, unit_m in UNITS_M.items()}
    unit = next((unit for unit, meant_m in meant.items() if lowest_m <= meant_m <= highest_m), None)
    mend = unit and Mend(words.height_label(typed, unit), (SetHeight(meant[unit]),))
    yield Trouble(words.height_trouble(document, height_m), mend=mend or None)


def _unit_mends(document: Document) -> list[tuple[str, Mend]]:
    """What was typed in the other unit: the distances, or everything; of the height alone its range tells."""
    scale = FEET_PER_METRE if document.imperial else 1 / FEET_PER_METRE
    distances: tuple[Edit, ...] = tuple(
        SetDistance(mark.id, mark.distance_m * scale)
        for mark in document.marks
        if mark.distance_m is not None
    )
    units = SetUnits(not document.imperial)
    height: tuple[Edit, ...] = ()
    if document.height_m is not None:
        height = (SetHeight(document.height_m * scale),)
    offset: tuple[Edit, ...] = ()
    if document.from_bumper and document.bumper_offset_m:
        offset = (SetReference(True, document.bumper_offset_m * scale),)
    proposals = [
        ("the distances", (*distances, units)),
        ("all lengths", (*distances, *height, *offset, units)),
    ]
    return [
        (words.unit_cause(what, document.imperial), Mend(words.unit_label(what, document.imperial), edits))
        for what, edits in proposals
        if edits
    ]


def _prior_trouble(document: Document, calibration: Calibration, field: str) -> Trouble:
    prior: Gaussian = getattr(calibration.priors, field)
    if field == "field_of_view_rad":
        assert document.field_of_view is not None
        name, unit, unit_name = "field of view", math.degrees(1), "°"
        value = calibration.field_of_view_rad
        edits: tuple[Edit, ...] = (SetFieldOfView(replace(document.field_of_view, enabled=False)),)
    elif field == "principal_row_px":
        assert document.principal_row is not None
        name, unit, unit_name = "principal row", 1.0, ""
        value = calibration.camera.principal_row_px
        edits = (SetPrincipalRow(replace(document.principal_row, enabled=False)),)
    else:
        name, unit, unit_name = "horizon row", 1.0, ""
        value = calibration.horizon_row_px
        edits = ()
        if document.horizon is not None and document.horizon.enabled:
            edits = (SetHorizon(replace(document.horizon, enabled=False)),)
        if document.lane_lines_enabled and None not in document.lane_lines:
            edits = (*edits, EnableLaneLines(False))
    text = words.prior_trouble(name, prior, value, unit, unit_name)
    return Trouble(text, mend=Mend(words.switch_off_label(name), edits))


def _point_mend(
    document: Document, error: PointsError, marks: Sequence[Mark], calibrate: Calibrate
) -> Mend | None:
    """Distances exchanged or a mark left out: what makes a plausible camera, or at least one."""
    proposals: list[Mend] = []
    if error.fault is PointsFault.ORDER:
        near, far = marks
        proposals.append(Mend(words.swap_label(near, far), _exchanged((near, far), (far, near))))
    if lone := _leave_one_out(document, calibrate):
        proposals.append(lone[1])
    if error.fault is PointsFault.ORDER:
        told = [mark for mark in document.marks if mark.ground_point is not None]
        by_row = sorted(told, key=lambda mark: -mark.row_px)
        by_distance = sorted(told, key=lambda mark: mark.distance_m or 0.0)
        proposals.append(Mend(words.SORT_LABEL, _exchanged(by_row, by_distance)))
    plausible = (mend for mend in proposals if _makes_plausible(document, mend, calibrate))
    solvable = (mend for mend in proposals if _solves(document, mend, calibrate))
    return next(plausible, None) or next(solvable, None)


def _exchanged(marks: Sequence[Mark], givers: Sequence[Mark]) -> tuple[Edit, ...]:
    return tuple(SetDistance(mark.id, giver.distance_m) for mark, giver in zip(marks, givers, strict=True))


def _leave_one_out(document: Document, calibrate: Calibrate) -> tuple[Mark, Mend] | None:
    """The mark without which the others fit best and nothing speaks against them.

    The worst residual alone is a poor witness: a far point pulls the curve to itself.
    """
    marks = [mark for mark in document.marks if mark.ground_point is not None]
    best: tuple[float, Mark, Mend] | None = None
    if len(marks) <= PARAMETER_COUNT + 1:
        # Any three points fit exactly, with or without the wrong one among them.
        return None
    for mark in marks:
        mend = _leave_out(mark)
        calibration = _mended(document, mend, calibrate)
        if calibration is not None and not plausibility(calibration):
            misfit = sum(residual**2 for residual in calibration.residuals_px)
            if best is None or misfit < best[0]:
                best = misfit, mark, mend
    return best and best[1:]


def _leave_out(mark: Mark) -> Mend:
    return Mend(words.leave_out_label(mark), (EnableMark(mark.id, False),))


def _mended(document: Document, mend: Mend, calibrate: Calibrate) -> Calibration | None:
    try:
        for edit in mend.edits:
            document = edit.apply(document)
        return calibrate(document)
    except UserError:
        return None


def _solves(document: Document, mend: Mend, calibrate: Calibrate) -> bool:
    try:
        for edit in mend.edits:
            document = edit.apply(document)
        calibrate(document)
    except UserError:
        return False
    return True


def _makes_plausible(document: Document, mend: Mend, calibrate: Calibrate) -> bool:
    calibration = _mended(document, mend, calibrate)
    return calibration is not None and not plausibility(calibration)


def _marks_of(document: Document, error: PointsError) -> list[Mark]:
    """The marks behind the points of an error, in its order."""
    marks = [mark for mark in document.marks if mark.ground_point is not None]
    found: list[Mark] = []
    for point in error.points:
        mark = next(mark for mark in marks if mark.ground_point == point and mark not in found)
        found.append(mark)
    return found


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:].rstrip('.')}."
