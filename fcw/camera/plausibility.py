"""Whether a calibration can be that of a camera behind a windscreen and, if not, what probably went wrong.

The probable mistake comes from `fcw.camera.verdicts`. Nothing here is an error: the user may know better.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from enum import Enum

import numpy as np

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.joint.evidence import Ruler
from fcw.camera.joint.fit import FLEET_SIGMA, SLOPE_SIGMA_RAD
from fcw.camera.lens.usual import across_picture
from fcw.camera.points import PARAMETER_COUNT
from fcw.camera.solve import exact_solution
from fcw.camera.uncertainty import CameraSigmas, camera_sigmas
from fcw.camera.verdicts.hypotheses import BUMPER_M, BUMPER_SIGMA_M, Fault
from fcw.camera.verdicts.judgement import SMALLEST_SIGMA_PX, Judgement, Suspicion, judge
from fcw.camera.verdicts.period import period_doubt
from fcw.camera.verdicts.tilt import if_level
from fcw.camera.verdicts.words import cause_text, period_text, unclear_text
from fcw.frame import ImageSize

MAXIMUM_PITCH_RAD = math.radians(20.0)
"""A dash camera has the horizon near its middle; this is half of an ordinary vertical field of view."""
FIELD_OF_VIEW_RANGE_RAD = (math.radians(33.0), math.radians(130.0))
"""Along the longer side of the picture. A narrower one is a tele lens; a wider one is not rectilinear."""
PRINCIPAL_ROW_TOLERANCE = 0.25
"""Largest distance of the principal row from the middle of the picture, as a part of the height.
Without cropping it is at most 0.05; the rest allows for the noise of clicks and for cropped pictures."""
TOLD_ROLL_RAD = math.radians(1.0)
"""Least roll that is reported; it is visible."""
TOLD_ROLL_SIGMAS = 2.5
"""Least certainty of a roll that is reported: the points are then twenty times as likely as with no roll."""
SLACK_SIGMAS = 2.0
EXACT = CameraSigmas(0.0, 0.0, 0.0, 0.0)
MAXIMUM_OFFSET_M = 4.0
"""No camera on a windscreen is farther behind the bumper."""
OUTLIER_SIGMAS = 3.0
"""A larger residual is a mistake about that point and not noise."""


class FindingKind(Enum):
    """What a finding is about."""

    PITCH = "pitch"
    FIELD_OF_VIEW = "field_of_view"
    PRINCIPAL_ROW = "principal_row"
    HORIZON = "horizon"
    POINT_OUTSIDE = "point_outside"
    RESIDUAL = "residual"
    PRIOR = "prior"
    CAUSE = "cause"
    PERIOD = "period"
    ROLL = "roll"
    VEHICLES = "vehicles"
    LENS = "lens"
    RECTANGLE = "rectangle"
    HEIGHT = "height"


@dataclass(frozen=True, slots=True)
class OffsetProposal:
    """The reference offset that would explain an implausible camera.

    Attributes:
        offset_m: the offset that puts the principal row in the middle of the picture.
        low_m: smallest offset around it that gives a plausible camera, in tenths of a metre.
        high_m: largest such offset.
    """

    offset_m: float
    low_m: float
    high_m: float


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that the user should know about a calibration, in words.

    Attributes:
        kind: what it is about.
        text: one paragraph.
        offset: the reference offset that would explain it, if one does.
        point: the point it is about, if it is about one.
        prior: the field of `Priors` it is about, if it is about one.
        suspicion: the mistake that it names, if it names one.
        swapped_sides: the rectangle whose sides are exchanged, if they are.
        is_question: nothing is wrong with the calibration itself; only the user can tell whether this holds.
    """

    kind: FindingKind
    text: str
    offset: OffsetProposal | None = None
    point: GroundPoint | None = None
    prior: str | None = None
    suspicion: Suspicion | None = None
    swapped_sides: int | None = None
    is_question: bool = False

    @property
    def speaks_against(self) -> bool:
        """Whether it means that the calibration is probably wrong; a question or a roll does not."""
        return not self.is_question and self.kind is not FindingKind.ROLL


def plausibility(
    calibration: Calibration, imperial: bool = False, paced: bool = False
) -> tuple[Finding, ...]:
    """All that is implausible about a calibration, with the probable cause; empty if all is well.

    Args:
        calibration: the calibration to judge.
        imperial: whether the distances were typed in feet.
        paced: whether the user said that the points are dashes of one period.
    """
    findings = list(_camera_findings(calibration.camera, calibration.image_size, _slack(calibration)))
    judgement = judge(calibration, imperial) if len(calibration.points) >= PARAMETER_COUNT else None
    question = judgement and judgement.question
    if findings or (judgement is not None and judgement.is_suspect):
        findings.append(_cause(calibration, question or judgement))
    elif question is not None:
        findings.append(_question(calibration, question))
    if judgement is None or not judgement.is_suspect:
        findings.extend(_residual_finding(calibration))
        findings.extend(_period_finding(calibration, paced))
    findings.extend(_roll_finding(calibration, judgement, imperial))
    return (*findings, *_outside_findings(calibration), *_prior_findings(calibration))


def offset_proposal(calibration: Calibration) -> OffsetProposal | None:
    """The reference offset that would put the principal row of an exact solution in the picture's middle.

    The row map counted from the reference does not change, nor does any distance. The offset only moves the
    camera behind the reference: C = C_reference - offset. With v0 - B = (K / 2 h) sin(2 a), the offset for a
    given v0 has a closed form.

    Args:
        calibration: the exact solution of three points.

    Returns:
        None if no offset from 0 to `MAXIMUM_OFFSET_M` gives a plausible camera with v0 in the middle.
    """
    camera, size = calibration.camera, calibration.image_size
    scale, height_m = camera.row_scale_m_px, camera.height_m
    sine = 2 * height_m * (_middle_row(size) - camera.horizon_row_px) / scale
    if abs(sine) > 1:
        return None
    reference_pole_m = camera.pole_m + calibration.reference_offset_m
    offset_m = reference_pole_m - height_m * math.tan(math.asin(sine) / 2)

    def plausible(offset_m: float) -> bool:
        shifted = GroundPlaneCamera.from_row_map(
            camera.horizon_row_px, scale, reference_pole_m - offset_m, height_m, camera.principal_column_px
        )
        return not any(_camera_findings(shifted, size))

    if not (0 <= offset_m <= MAXIMUM_OFFSET_M and plausible(offset_m)):
        return None
    # In steps of 0.1 m, as precise as anybody measures it. Every offset from low to high is plausible.
    low_m = high_m = offset_m
    tenths = math.floor(offset_m * 10)
    while tenths >= 0 and plausible(tenths / 10):
        low_m, tenths = tenths / 10, tenths - 1
    tenths = math.ceil(offset_m * 10)
    while tenths <= MAXIMUM_OFFSET_M * 10 and plausible(tenths / 10):
        high_m, tenths = tenths / 10, tenths + 1
    return OffsetProposal(offset_m, low_m, high_m)


def _middle_row(size: ImageSize) -> float:
    return (size.height - 1) / 2


def _slack(calibration: Calibration) -> CameraSigmas:
    """How far the camera may be beyond its limits because it is uncertain; 0 if it is exact."""
    if not calibration.assumed.count:
        return EXACT
    sigmas = camera_sigmas(calibration)
    return CameraSigmas(*(SLACK_SIGMAS * sigma for sigma in astuple(sigmas)))


def _camera_findings(
    camera: GroundPlaneCamera, size: ImageSize, slack: CameraSigmas = EXACT
) -> Iterator[Finding]:
    if abs(camera.pitch_rad) > MAXIMUM_PITCH_RAD + slack.pitch_rad:
        side = "down" if camera.pitch_rad > 0 else "up"
        yield Finding(
            FindingKind.PITCH,
            f"the camera would look {abs(math.degrees(camera.pitch_rad)):.1f} degrees {side}; "
            f"behind a windscreen it is less than {math.degrees(MAXIMUM_PITCH_RAD):.0f}",
        )
    field_of_view = 2 * math.atan(size.width / (2 * camera.focal_y_px))
    narrowest, widest = (across_picture(Gaussian(v, 0.0), size).value for v in FIELD_OF_VIEW_RANGE_RAD)
    longest_px, shortest_px = (size.width / 2 / math.tan(view / 2) for view in (narrowest, widest))
    if not shortest_px - slack.focal_y_px <= camera.focal_y_px <= longest_px + slack.focal_y_px:
        yield Finding(
            FindingKind.FIELD_OF_VIEW,
            f"the focal length of {camera.focal_y_px:.0f} px means a horizontal field of view of "
            f"{math.degrees(field_of_view):.1f} degrees; dash cameras have "
            f"{math.degrees(narrowest):.0f} to {math.degrees(widest):.0f}",
        )
    middle_px = _middle_row(size)
    if (
        abs(camera.principal_row_px - middle_px)
        > PRINCIPAL_ROW_TOLERANCE * size.height + slack.principal_row_px
    ):
        yield Finding(
            FindingKind.PRINCIPAL_ROW,
            f"the optical axis would meet the picture at row {camera.principal_row_px:.0f}, "
            f"far from its middle, row {middle_px:g}",
        )
    beyond_px = max(-0.5 - camera.horizon_row_px, camera.horizon_row_px - size.height + 0.5)
    if beyond_px > slack.horizon_row_px:
        yield Finding(
            FindingKind.HORIZON,
            f"the horizon would be at row {camera.horizon_row_px:.0f}, outside the picture of {size}",
        )


def _question(calibration: Calibration, careful: Judgement) -> Finding:
    """What is probably wrong if the marks were laid with care; if not, their own errors explain it."""
    cause = _cause(calibration, careful)
    nearest_m = min(point.distance_m for point in calibration.points)
    off_cm = 100 * calibration.tape_error * nearest_m
    text = (
        f"{cause.text[:-1]}. Marks that each lie off by {calibration.tape_error:.0%} "
        f"({off_cm:.0f} cm at {nearest_m:g} m) would explain it as well."
    )
    return replace(cause, text=text, is_question=True)


def _period_finding(calibration: Calibration, paced: bool) -> Iterator[Finding]:
    doubt = period_doubt(calibration, paced=paced)
    if doubt is not None:
        yield Finding(FindingKind.PERIOD, period_text(doubt), is_question=True)


def _cause(calibration: Calibration, judgement: Judgement | None) -> Finding:
    named = judgement and judgement.named
    if named:
        proposal = _bumper(calibration, named) if named.fault is Fault.BUMPER else None
        words = ""
        if proposal is not None:
            words = (
                f"A reference offset of {proposal.offset_m:.2f} m would put the optical axis near the "
                f"picture's middle (with exact clicks {proposal.low_m:.1f} to {proposal.high_m:.1f} m "
                "are plausible)"
            )
        text = cause_text(named, calibration.points, calibration.reference_offset_m, words)
        text = f"no camera behind a windscreen fits these points well; likely cause: {text}."
        point = calibration.points[named.points[0]] if named.fault is Fault.POINT else None
        return Finding(FindingKind.CAUSE, text, proposal, point, suspicion=named)
    if judgement is not None and judgement.is_suspect:
        reason = unclear_text(judgement, calibration.points)
    elif judgement is not None:
        sigmas = camera_sigmas(calibration)
        reason = (
            "the clicks do not determine the parameters: the principal row is uncertain by "
            f"{sigmas.principal_row_px:.0f} px; add a point far away, or give the lens's field of view"
        )
    else:
        reason = "a wrong camera, or an image size other than that of its pictures; calibrate with points"
    return Finding(FindingKind.CAUSE, f"likely cause: {reason}.")


def _bumper(calibration: Calibration, named: Suspicion) -> OffsetProposal:
    """Where the bumper is: from the closed solution of three points if that fits a car, else the verdict."""
    low_m, high_m = (BUMPER_M + sign * 2 * BUMPER_SIGMA_M for sign in (-1, 1))
    if len(calibration.points) == PARAMETER_COUNT and not calibration.priors.count:
        exact = exact_solution(calibration)
        proposal = offset_proposal(exact) if exact is not None else None
        if proposal is not None and low_m <= proposal.offset_m <= high_m:
            return proposal
    return OffsetProposal(
        named.offset_m, max(named.offset_m - BUMPER_SIGMA_M, 0.0), named.offset_m + BUMPER_SIGMA_M
    )


def _outside_findings(calibration: Calibration) -> Iterator[Finding]:
    size = calibration.image_size
    for point in calibration.points:
        column_px = 0.0 if point.column_px is None else point.column_px
        if not (-0.5 <= point.row_px <= size.height - 0.5 and -0.5 <= column_px <= size.width - 0.5):
            yield Finding(
                FindingKind.POINT_OUTSIDE,
                f"the point {point} lies outside the picture of {size}",
                point=point,
            )


def _residual_finding(calibration: Calibration) -> Iterator[Finding]:
    # A wrong point also pulls its neighbours off the curve, so only the worst is named.
    distances_m = np.array([point.distance_m for point in calibration.points])
    slopes = calibration.camera.row_slope_at(distances_m + calibration.reference_offset_m)
    # Each mark may be off by the whole error of the tape.
    sigmas_px = np.hypot(calibration.row_sigma_px, calibration.tape_error * distances_m * slopes)
    sigmas_px = np.maximum(sigmas_px, SMALLEST_SIGMA_PX).tolist()
    residual_px, worst, sigma_px = max(
        zip(calibration.residuals_px, calibration.points, sigmas_px, strict=True),
        key=lambda found: abs(found[0]) / found[2],
        default=(0.0, None, 1.0),
    )
    if abs(residual_px) > OUTLIER_SIGMAS * sigma_px:
        yield Finding(
            FindingKind.RESIDUAL,
            f"the point {worst} lies {abs(residual_px):.1f} px {'below' if residual_px > 0 else 'above'} "
            "the row that all points and priors together give it, "
            f"{abs(residual_px) / sigma_px:.1f} times the error of a click and of a mark; "
            "check its distance and click it again",
            point=worst,
        )


def vehicle_finding(calibration: Calibration, rulers: Sequence[Ruler]) -> Finding | None:
    """A finding if vehicles in the picture would have a width that no vehicle has; else None.

    Args:
        calibration: the calibration to judge.
        rulers: vehicles straight ahead, in the picture's pixels, each vehicle only once.
    """
    way, seen = calibration.straightening, []
    slope_px = SLOPE_SIGMA_RAD * calibration.camera.focal_y_px
    for ruler in rulers:
        row_px = ruler.row_px
        if way is not None:
            row_px = float(way.to_straight(np.array([(ruler.column_px, row_px)]))[0, 1])
        left_m = calibration.lateral_at(0.0, row_px)
        width_m = (left_m - calibration.lateral_at(1.0, row_px)) * ruler.width_px
        if math.isfinite(width_m):
            by_slope = slope_px / (row_px - calibration.horizon_row_px)
            seen.append((math.log(width_m / ruler.width_m.value), width_m, ruler, by_slope))
    if not seen:
        return None
    off, width_m, ruler, by_slope = sorted(seen, key=lambda item: item[0])[len(seen) // 2]
    spread = ruler.width_m.sigma / ruler.width_m.value / math.sqrt(len(seen))
    if abs(off) <= OUTLIER_SIGMAS * math.hypot(FLEET_SIGMA, spread, by_slope):
        return None
    seen_at = f"the vehicle at column {ruler.column_px:.0f}, row {ruler.row_px:.0f}"
    which = seen_at if len(seen) == 1 else f"half of the {len(seen)} vehicles taken as rulers"
    than = "" if len(seen) == 1 else " or more" if off > 0 else " or less"
    return Finding(
        FindingKind.VEHICLES,
        f"{which} would be {width_m:.2f} m wide{than}; vehicles are about {ruler.width_m.value:.1f} m: the "
        "camera's height, the horizon, the lens or the distances are off",
    )


def height_finding(calibration: Calibration, stated_m: Gaussian) -> Finding | None:
    """A finding if everything else contradicts the stated camera height; else None."""
    height_m = calibration.camera.height_m
    if abs(height_m - stated_m.value) <= OUTLIER_SIGMAS * stated_m.sigma:
        return None
    return Finding(
        FindingKind.HEIGHT,
        f"the camera height of {stated_m.value:g} ± {stated_m.sigma:.2g} m contradicts the rest, which "
        f"gives {height_m:.2f} m; check it, the distances and the lens",
    )


def _roll_finding(calibration: Calibration, judgement: Judgement | None, imperial: bool) -> Iterator[Finding]:
    turned = calibration.orientation
    if abs(turned.roll_rad) > max(TOLD_ROLL_RAD, TOLD_ROLL_SIGMAS * turned.roll_sigma_rad):
        otherwise = if_level(calibration, judgement, imperial)
        yield Finding(
            FindingKind.ROLL,
            f"the camera is tilted by {math.degrees(abs(turned.roll_rad)):.1f} degrees to the "
            f"{'right' if turned.roll_rad > 0 else 'left'}: this is taken into account; mount it level if "
            f"you can{otherwise and f'; if it is level, {otherwise}'}",
            is_question=bool(otherwise),
        )


def _prior_findings(calibration: Calibration) -> Iterator[Finding]:
    priors, camera = calibration.priors, calibration.camera
    beliefs = (
        (
            "field_of_view_rad",
            "field of view",
            " degrees",
            math.degrees(1),
            priors.field_of_view_rad,
            calibration.field_of_view_rad,
        ),
        ("principal_row_px", "principal row", "", 1.0, priors.principal_row_px, camera.principal_row_px),
        ("horizon_row_px", "horizon row", "", 1.0, priors.horizon_row_px, camera.horizon_row_px),
    )
    for field, name, unit_name, unit, prior, value in beliefs:
        if prior is not None and abs(value - prior.value) > OUTLIER_SIGMAS * prior.sigma:
            yield Finding(
                FindingKind.PRIOR,
                f"the {name} of {prior.value * unit:g} ± {prior.sigma * unit:g}{unit_name} contradicts the "
                f"rest, which gives {value * unit:.1f}; check it, the distances and the camera height",
                prior=field,
            )
