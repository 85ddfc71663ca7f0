"""What is wrong with what somebody said, beside the marks that cause it, and the edits that would mend it."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from fcw.camera.calibration import Calibration, Gaussian, Priors
from fcw.camera.plausibility import FindingKind, plausibility
from fcw.camera.points import PARAMETER_COUNT, PointsError, PointsFault
from fcw.camera.verdicts.hypotheses import Fault
from fcw.camera.verdicts.judgement import Suspicion, judge_points
from fcw.camera.verdicts.words import JUDGED
from fcw.errors import UserError
from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.document import words
from fcw_viz.calibrate_app.document.besides.knowledge import SetBent
from fcw_viz.calibrate_app.document.besides.rectangles import SetSides
from fcw_viz.calibrate_app.document.document import Document, Mark
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
from fcw_viz.calibrate_app.document.numbers_text import with_lengths
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
TOLD_FINDINGS = frozenset((FindingKind.PERIOD, FindingKind.VEHICLES, FindingKind.ROLL, FindingKind.HEIGHT))
"""Said in the finding's own words."""
OFFSET_DECIMALS = 2
"""Nobody measures a car more finely than to a centimetre."""
HEIGHT_RANGE_M = (0.6, 3.5)
"""Of a lens behind a windscreen, from a low sports car to a lorry."""
UNITS_M = {
    "metres": 1.0,
    "feet": 1 / FEET_PER_METRE,
    "centimetres": 0.01,
    "inches": 0.0254,
    "millimetres": 0.001,
}


def degenerate_troubles(
    document: Document, error: UserError, priors: Priors, calibrate: Calibrate, thorough: bool
) -> tuple[Trouble, ...]:
    """Why a document determines no camera.

    Args:
        document: what was said.
        error: what calibrating it raised.
        priors: what was said of lens and horizon.
        calibrate: tries what a mend would make of it.
        thorough: whether to look for a mend.
    """
    if not isinstance(error, PointsError):
        return (Trouble(_sentence(str(error))),)
    marks = _marks_of(document, error)
    text = words.degenerate(error, marks, document.imperial)
    ids = tuple(mark.id for mark in marks)
    if thorough and (verdict := _verdict(document, error, priors)):
        told = [mark for mark in document.marks if mark.ground_point is not None]
        mend = _mend(document, told, verdict, verdict.offset_m)
        if mend and _makes_plausible(document, mend, calibrate):
            text = words.degenerate(error, marks, document.imperial, guess=False)
            return (Trouble(f"{text} {words.verdict_cause(document, told, verdict)}", ids, mend),)
    mend = _point_mend(document, error, marks, calibrate) if thorough else None
    return (Trouble(text, ids, mend),)


def _verdict(document: Document, error: PointsError, priors: Priors) -> Suspicion | None:
    """The mistake that explains points without a camera, where one does."""
    points = [mark.ground_point for mark in document.marks if mark.ground_point is not None]
    if error.fault not in JUDGED or len(points) < PARAMETER_COUNT or document.height_m is None:
        return None
    return judge_points(
        points,
        document.image_size,
        document.height_m,
        document.reference_offset_m or 0.0,
        document.row_sigma_px,
        priors,
        document.tape_error,
        document.imperial,
    ).named


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
    troubles: list[Trouble] = [*_height_troubles(document), *_rectangle_troubles(document, result)]
    calibration = result.calibration
    if any(finding.kind in CAMERA_FINDINGS for finding in result.findings):
        troubles.append(_camera_trouble(document, marks, result))
    by_point = dict(zip(calibration.points, marks, strict=True))
    for finding in result.findings:
        if finding.kind in (FindingKind.CAUSE, FindingKind.RECTANGLE):
            continue
        if finding.kind is FindingKind.LENS:
            mend = Mend(words.FIT_LENS_LABEL, (SetBent(True),))
            troubles.append(Trouble(f"{_sentence(finding.text)} {words.LENS_WAY_OUT}", mend=mend))
            continue
        if finding.kind in TOLD_FINDINGS:
            troubles.append(Trouble(_sentence(with_lengths(finding.text, document.imperial))))
            continue
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


def _camera_trouble(document: Document, marks: Sequence[Mark], result: Result) -> Trouble:
    """What cannot be true of the camera, and the verdict on why, with the mend that it names."""
    text = words.camera_trouble(result.calibration, result.findings)
    cause = next((finding for finding in result.findings if finding.kind is FindingKind.CAUSE), None)
    named = cause and cause.suspicion
    if cause is None or named is None:
        if any(finding.kind is FindingKind.RECTANGLE for finding in result.findings):
            return Trouble(text)  # why, is said of the rectangle
        likely = "" if cause is None else _sentence(with_lengths(cause.text, document.imperial))
        return Trouble(f"{text} {likely or words.UNKNOWN_CAUSE}".strip())
    wrong = [marks[k] for k in named.points]
    offset_m = named.offset_m if cause.offset is None else cause.offset.offset_m
    mend = _mend(document, marks, named, offset_m)
    if named.fault is Fault.BUMPER and cause.offset is not None:
        likely = words.offset_cause(document, cause.offset)
    else:
        likely = words.verdict_cause(document, marks, named)
    if cause.is_question:
        likely = f"{likely} {words.noise_would_do(document.tape_error)}"
    return Trouble(f"{text} {likely}".strip(), tuple(mark.id for mark in wrong), mend)


def _mend(document: Document, marks: Sequence[Mark], named: Suspicion, offset_m: float) -> Mend | None:
    """The edits that make what was said what the verdict takes it for; None where a person must measure."""
    wrong = [marks[k] for k in named.points]
    match named.fault:
        case Fault.BUMPER:
            offset_m = round(offset_m, OFFSET_DECIMALS)
            if offset_m < 0:  # no bumper is behind its camera
                return None
            return Mend(words.offset_label(document, offset_m), (SetReference(True, offset_m),))
        case Fault.SWAPPED:
            first, second = wrong
            return Mend(words.swap_label(first, second), _exchanged((first, second), (second, first)))
        case Fault.SLIP_OF_TEN:
            meant_m = named.distances_m[named.points[0]]
            edit = SetDistance(wrong[0].id, meant_m)
            return Mend(words.distance_label(wrong[0], meant_m, document.imperial), (edit,))
        case Fault.FEET:
            return _unit_mend(document)
        case Fault.POINT if len(marks) > PARAMETER_COUNT:
            return _leave_out(wrong[0])
        case _:
            return None


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


def _rectangle_troubles(document: Document, result: Result) -> Iterator[Trouble]:
    """A rectangle that is not as it was said: whatever else is odd may come of that."""
    for finding in result.findings:
        if finding.kind is not FindingKind.RECTANGLE:
            continue
        mend = None
        if finding.swapped_sides is not None:
            exchanged = document.whole_rectangles[finding.swapped_sides].swapped
            edit = SetSides(finding.swapped_sides, *exchanged.sides_m)
            mend = Mend(words.EXCHANGE_LABEL, (edit,))
        yield Trouble(_sentence(with_lengths(finding.text, document.imperial)), mend=mend)


def _unit_mend(document: Document) -> Mend:
    """The distances taken for the other unit; of the height its range tells."""
    scale = FEET_PER_METRE if document.imperial else 1 / FEET_PER_METRE
    distances: tuple[Edit, ...] = tuple(
        SetDistance(mark.id, mark.distance_m * scale)
        for mark in document.marks
        if mark.distance_m is not None
    )
    edits = (*distances, SetUnits(not document.imperial))
    return Mend(words.unit_label(document.imperial), edits)


def _prior_trouble(document: Document, calibration: Calibration, field: str) -> Trouble:
    prior: Gaussian = getattr(calibration.priors, field)
    if field == "field_of_view_rad":
        assert document.field_of_view is not None
        name, unit, unit_name = "field of view", math.degrees(1), "°"
        value = calibration.field_of_view_rad
        edits: tuple[Edit, ...] = (SetFieldOfView(replace(document.field_of_view, enabled=False)),)
    elif field == "principal_row_px":
        assert document.principal_row is not None
        name, unit, unit_name = "lens axis", 1.0, ""
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
        if calibration is not None and not speaks_against(calibration):
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
    return calibration is not None and not speaks_against(calibration)


def speaks_against(calibration: Calibration) -> bool:
    """Whether anything does, besides questions."""
    return any(finding.speaks_against for finding in plausibility(calibration))


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
