"""What follows from a document: the camera, its uncertainty, what is still missing and what is wrong."""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint, Priors
from fcw.camera.joint.known import Known
from fcw.camera.joint.odd_rectangle import odd_rectangle
from fcw.camera.joint.rectangle import RECTANGLE_FACTS
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.plausibility import (
    OUTLIER_SIGMAS,
    Finding,
    FindingKind,
    height_finding,
    plausibility,
    vehicle_finding,
)
from fcw.camera.points import (
    PARAMETER_COUNT,
    PointsError,
    check_order,
    check_reach,
    check_repeats,
    distinct_distances,
)
from fcw.camera.prior_sigmas import CAR_CAMERA_HEIGHT_M, UNKNOWN_HEIGHT_SIGMA_M
from fcw.camera.solve import calibrate
from fcw.camera.uncertainty import best_next_click, camera_sigmas, relative_errors, row_sigmas
from fcw.camera.vanishing import combined, vanishing_row
from fcw.camera.verdicts.tilt import tilted_instead
from fcw.errors import UserError
from fcw.logs.overlay import ROW_DISTANCES_M
from fcw.units import FEET_PER_METRE
from fcw_viz.calibrate_app.document import words
from fcw_viz.calibrate_app.document.besides.joint_fit import (
    FEWEST_VEHICLES,
    bent_lens,
    broken_period,
    stated,
    with_lane_horizon,
)
from fcw_viz.calibrate_app.document.document import FEWEST_PLATES, Document, Mark
from fcw_viz.calibrate_app.document.edits import SetHorizon
from fcw_viz.calibrate_app.document.sky import sky_troubles
from fcw_viz.calibrate_app.document.state import (
    BeliefEffect,
    DistanceRow,
    MarkResidual,
    Mend,
    Result,
    Solution,
    Status,
    Trouble,
)
from fcw_viz.calibrate_app.document.troubles import degenerate_troubles, implausible_troubles
from fcw_viz.calibrate_app.document.ways.height import with_height_error

ASSUMED_OFFSET_M = 1.8
"""From a lens at the mirror to the front bumper of an ordinary car, for the preview until somebody says it;
the height is that of such a lens (`CAR_CAMERA_HEIGHT_M`)."""
EFFECT_DISTANCE_M = 40.0
"""Where the effect of a belief is told, and the quality: a warning at 90 km/h comes from there."""
CONTRADICTIONS = frozenset((FindingKind.RESIDUAL, FindingKind.PRIOR, FindingKind.HEIGHT))
"""What was said disagrees by more than its noise, and the intervals follow from that noise alone."""
ROW_DISTANCES_FT = (15.0, 30.0, 50.0, 75.0, 100.0, 150.0, 200.0, 250.0)


@dataclass(frozen=True, slots=True)
class _Facts:
    """What takes part in a calibration; `besides` counts what the priors have no place for."""

    marks: tuple[Mark, ...]
    priors: Priors
    lane_horizon: Gaussian | None
    besides: int = 0

    @property
    def missing(self) -> int:
        """How many more facts determine a camera."""
        distances_m = [mark.distance_m for mark in self.marks if mark.distance_m is not None]
        told = len(distinct_distances(distances_m)) + self.priors.count + self.besides
        return max(PARAMETER_COUNT - told, 0)


def solve(document: Document, effects: bool = True) -> Solution:
    """What follows from a document.

    Args:
        document: what was said.
        effects: whether to tell the effect of each belief, and to look for mends that take several solutions;
            neither is needed while somebody drags. The status is the same either way.
    """
    lane_horizon, lane_troubles = _lane_horizon(document)
    facts = _facts(document, lane_horizon)

    def sky(fits: bool = False) -> tuple[Trouble, ...]:
        return () if lane_troubles else sky_troubles(document, calibration_of, fits)

    height_assumed = document.height_m is None and not document.has_size
    assumed = height_assumed or document.reference_offset_m is None
    told = _effects(document, lane_horizon) if effects and not assumed else {}
    incomplete = Solution(
        Status.INCOMPLETE,
        None,
        words.hint_incomplete(document, facts.missing),
        lane_troubles,
        lane_horizon,
        height_assumed,
        told,
    )
    try:
        calibration = _calibration(document, facts)
    except UserError as error:
        # What is in the sky explains it: nobody else is to blame.
        troubles = sky() or degenerate_troubles(document, error, facts.priors, calibration_of, effects)
        return replace(
            incomplete,
            status=Status.DEGENERATE,
            hint=words.hint_degenerate(),
            troubles=(*troubles, *lane_troubles),
        )
    if calibration is None:
        return replace(incomplete, troubles=(*sky(), *lane_troubles))
    points = tuple(mark.ground_point for mark in facts.marks if mark.ground_point is not None)
    known = stated(document, points, CAR_CAMERA_HEIGHT_M, ASSUMED_OFFSET_M)
    result = _result(document, facts, calibration, known)
    # Of what is implausible anyway a drag need not tell every reason.
    asks_more = effects or all(f.is_question or f.kind is FindingKind.PERIOD for f in result.findings)
    if asks_more and (bent := bent_lens(document, known)):
        result = replace(result, findings=(*result.findings, Finding(FindingKind.LENS, bent.text)))
    if uneven := broken_period(document, known):
        kept = tuple(f for f in result.findings if f.kind is not FindingKind.PERIOD)
        told_of = Finding(FindingKind.PERIOD, uneven.text, is_question=True)
        result = replace(result, findings=(*kept, told_of))
    if asks_more and (odd := odd_rectangle(known)):
        swapped = odd.index if odd.swapped else None
        told_of = Finding(FindingKind.RECTANGLE, odd.text, swapped_sides=swapped)
        result = replace(result, findings=(*result.findings, told_of))
    in_sky = sky(fits=not any(finding.speaks_against for finding in result.findings))
    if assumed:
        # Without priors the points' misfit is the same for any height and offset; all else follows from them.
        kept = tuple(f for f in result.findings if f.kind in (FindingKind.LENS, FindingKind.RECTANGLE))
        if not facts.priors.count:
            kept += tuple(f for f in result.findings if f.point is not None)
        result = replace(result, findings=kept)
    troubles = in_sky or implausible_troubles(document, facts.marks, result, calibration_of, thorough=effects)
    solution = replace(incomplete, result=result, troubles=(*lane_troubles, *troubles))
    if assumed:
        return solution
    asked = [finding for finding in result.findings if finding.is_question]
    if len(result.findings) > len(asked) or (troubles and not asked):
        return replace(solution, status=Status.IMPLAUSIBLE, hint=words.hint_implausible())
    if asked:
        return replace(solution, status=Status.DOUBTFUL, hint=words.hint_doubtful())
    hint = words.hint_next_click(result.next_click, document.imperial)
    return replace(solution, status=Status.GOOD, hint=hint)


def calibration_of(document: Document) -> Calibration | None:
    """The calibration of a document, with an assumed height or offset where that was not said.

    Returns:
        None where facts are missing.

    Raises:
        UserError: what was said determines no camera.
    """
    return _calibration(document, _facts(document, _lane_horizon(document)[0]))


def _facts(document: Document, lane_horizon: Gaussian | None) -> _Facts:
    horizons = [document.horizon.prior] if document.horizon and document.horizon.enabled else []
    if lane_horizon is not None and document.lane_lines_enabled:
        horizons.append(lane_horizon)
    beliefs = (document.field_of_view, document.principal_row)
    field_of_view, principal_row = (belief.prior if belief and belief.enabled else None for belief in beliefs)
    marks = tuple(mark for mark in document.marks if mark.ground_point is not None)
    # A lens is its field of view and its axis; vehicles show where the horizon is; a speed is the lens.
    besides = 2 * (document.lens is not None) + (len(document.vehicles) >= FEWEST_VEHICLES)
    besides += sum(RECTANGLE_FACTS + r.has_size for r in document.whole_rectangles)
    besides += len(document.whole_plates) >= FEWEST_PLATES
    besides += document.scale_per_mps is not None and document.speed is not None and document.speed.enabled
    return _Facts(marks, Priors(field_of_view, principal_row, combined(horizons)), lane_horizon, besides)


def _calibration(document: Document, facts: _Facts) -> Calibration | None:
    points = [mark.ground_point for mark in facts.marks if mark.ground_point is not None]
    if facts.missing:
        # Nothing follows yet, but two points can already contradict each other.
        check_repeats(points, document.row_sigma_px)
        check_order(points)
        return None
    check_reach(points)  # as the marks have them: of dashes the fit counts from the first
    known = stated(document, tuple(points), CAR_CAMERA_HEIGHT_M, ASSUMED_OFFSET_M)
    # Points that fit no camera are found by their rows, also where much else is known.
    enough = len(distinct_distances([p.distance_m for p in points])) + facts.priors.count >= PARAMETER_COUNT
    bent = known.lens is not None or known.bend is not None
    of_rows = None
    if enough and not (document.paced or bent):
        try:
            of_rows = _of_rows(document, facts.priors, points)
        except PointsError as error:
            return with_lane_horizon(tilted_instead(known, error), document)
    if of_rows is not None and known.is_of_rows:
        return of_rows
    return with_lane_horizon(calibrate_jointly(known), document)


def _of_rows(document: Document, priors: Priors, points: Sequence[GroundPoint]) -> Calibration:
    offset_m = document.reference_offset_m

    def with_height(height_m: float) -> Calibration:
        return calibrate(
            points,
            document.image_size,
            height_m,
            ASSUMED_OFFSET_M if offset_m is None else offset_m,
            document.row_sigma_px,
            priors.field_of_view_rad,
            priors.principal_row_px,
            priors.horizon_row_px,
            tape_error=document.tape_error,
        )

    if document.height_m is None:
        calibration = with_height(CAR_CAMERA_HEIGHT_M)
        with suppress(UserError):  # one so far off may determine no camera
            return with_height_error(calibration, UNKNOWN_HEIGHT_SIGMA_M, with_height)
        return calibration
    calibration = with_height(document.height_m)
    if document.height_sigma_m is None:
        return calibration
    return with_height_error(calibration, document.height_sigma_m, with_height)


def _lane_horizon(document: Document) -> tuple[Gaussian | None, tuple[Trouble, ...]]:
    """Where the lane lines meet, and what is wrong with them."""
    first, second = document.lane_lines
    if first is None or second is None:
        return None, ()
    try:
        horizon = vanishing_row(
            (first.start_px, first.end_px), (second.start_px, second.end_px), document.row_sigma_px
        )
    except UserError as error:
        text = str(error)
        return None, (Trouble(text[0].upper() + text[1:] + "."),)
    dragged = document.horizon
    if dragged is None or not dragged.enabled or not document.lane_lines_enabled:
        return horizon, ()
    apart_px = abs(dragged.prior.value - horizon.value)
    if apart_px <= OUTLIER_SIGMAS * math.hypot(dragged.prior.sigma, horizon.sigma):
        return horizon, ()
    mend = Mend("Switch the horizon off", (SetHorizon(replace(dragged, enabled=False)),))
    return horizon, (Trouble(words.horizons_disagree(dragged.prior, horizon), mend=mend),)


def _result(document: Document, facts: _Facts, calibration: Calibration, known: Known) -> Result:
    found = plausibility(calibration, document.imperial, document.paced)
    # A roll is no fault: the page shows it, and all that is drawn is turned by it. Where a mistake may look
    # like one it is a question, unless somebody has said how the camera is rolled.
    said_roll = document.roll is not None and document.roll.enabled
    asked = [f for f in found if f.is_question and not (said_roll and f.kind is FindingKind.ROLL)]
    findings = [finding for finding in found if finding.speaks_against or finding in asked]
    if document.vehicles and (vehicles := vehicle_finding(calibration, document.vehicles)):
        findings.append(vehicles)
    if height := height_finding(calibration, known.height_m):
        findings.append(height)
    rows_px = calibration.straight_rows_px
    residuals = {
        mark.id: MarkResidual(residual_px, calibration.distance_at(row_px) - point.distance_m)
        for mark, residual_px, row_px, point in zip(
            facts.marks, calibration.residuals_px, rows_px, calibration.points, strict=True
        )
    }
    distances_m = ROW_DISTANCES_M
    if document.imperial:
        distances_m = tuple(feet / FEET_PER_METRE for feet in ROW_DISTANCES_FT)
    low_m, high_m = calibration.distance_interval(calibration.row_at(EFFECT_DISTANCE_M))
    # A camera that looks up has no row for what is near its foot.
    nearest_m = -calibration.reference_offset_m - calibration.camera.pole_m
    shown_m = np.array([distance_m for distance_m in distances_m if distance_m > nearest_m])
    rows_px, sigmas_px = calibration.row_at(shown_m).tolist(), row_sigmas(calibration, shown_m).tolist()
    return Result(
        calibration,
        camera_sigmas(calibration),
        tuple(
            DistanceRow(distance_m, row_px, sigma_px, *calibration.distance_interval(row_px))
            for distance_m, row_px, sigma_px in zip(shown_m.tolist(), rows_px, sigmas_px, strict=True)
        ),
        words.CONTRADICTION
        if any(finding.kind in CONTRADICTIONS for finding in findings)
        else words.quality(EFFECT_DISTANCE_M, low_m, high_m, document.imperial),
        best_next_click(calibration),
        residuals,
        len(facts.marks) + facts.priors.count + facts.besides <= PARAMETER_COUNT,
        tuple(findings),
    )


def _effects(document: Document, lane_horizon: Gaussian | None) -> dict[str, BeliefEffect]:
    effects: dict[str, BeliefEffect] = {}
    for name in ("field_of_view", "principal_row", "horizon", "lane_width", "speed"):
        belief = getattr(document, name)
        if belief is not None:
            effects[name] = _effect(
                replace(document, **{name: replace(belief, enabled=False)}),
                replace(document, **{name: replace(belief, enabled=True)}),
            )
    if lane_horizon is not None:
        effects["lane_lines"] = _effect(
            replace(document, lane_lines_enabled=False), replace(document, lane_lines_enabled=True)
        )
    return effects


def _effect(without: Document, with_it: Document) -> BeliefEffect:
    def solved(document: Document) -> Calibration | None:
        try:
            return calibration_of(document)
        except UserError:
            return None

    def error(calibration: Calibration | None) -> float:
        if calibration is None:
            return math.inf
        return float(relative_errors(calibration, np.array([EFFECT_DISTANCE_M]))[0])

    before, after = solved(without), solved(with_it)
    shift = 0.0
    if before is not None and after is not None:
        shift = after.distance_at(before.row_at(EFFECT_DISTANCE_M)) / EFFECT_DISTANCE_M - 1
    return BeliefEffect(error(before), error(after), shift)
