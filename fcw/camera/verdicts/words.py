"""A verdict as people read it on the command line and in a file: what is likely wrong, and its mend."""

from collections.abc import Sequence

from fcw.camera.calibration import GroundPoint, Priors
from fcw.camera.points import PARAMETER_COUNT, PointsError, PointsFault
from fcw.camera.verdicts.hypotheses import DASH_PERIODS_M, Fault
from fcw.camera.verdicts.judgement import Judgement, Suspicion, judge_points
from fcw.camera.verdicts.period import PeriodDoubt
from fcw.frame import ImageSize

LISTED = 2
"""Where none stands out, so many likely mistakes are listed."""

JUDGED = frozenset((PointsFault.ORDER, PointsFault.SAME_ROW, PointsFault.HORIZON_BELOW_ROAD))

SHORT = {
    Fault.BUMPER: "the distances do not start where you said (camera or front bumper)",
    Fault.SWAPPED: "two distances are swapped",
    Fault.SLIP_OF_TEN: "a decimal point is missing or in the wrong place",
    Fault.FEET: "the distances are in feet",
    Fault.DASHES: "the first distance or the period of the dashes is wrong",
    Fault.POINT: "one point is on the wrong mark, or on a bump or in a dip of the road",
    Fault.AXIS: "the picture is cropped, so that the lens's axis is not near its middle",
}


def cause_text(
    suspicion: Suspicion, points: Sequence[GroundPoint], offset_m: float, proposal: str = ""
) -> str:
    """What is likely wrong and what to do, one or two sentences.

    Args:
        suspicion: what is named.
        points: as they were said.
        offset_m: the reference offset that was said.
        proposal: where the bumper is, in words; empty says it from the suspicion.
    """
    wrong = [points[k] for k in suspicion.points]
    meant_m = [suspicion.distances_m[k] for k in suspicion.points]
    match suspicion.fault:
        case Fault.BUMPER:
            where = (
                "the reference offset is not what was given"
                if offset_m
                else "the distances were measured from the front bumper and the camera is some way behind it"
            )
            return (
                f"{where}. {proposal or f'A reference offset of {suspicion.offset_m:.1f} m fits'}: measure "
                "from the camera forward to where the distances start, and calibrate again with that "
                f"reference offset{_or_tilted(points)}"
            )
        case Fault.SWAPPED:
            return f"the distances of {wrong[0]} and {wrong[1]} are swapped; swap them back"
        case Fault.SLIP_OF_TEN:
            return f"{wrong[0].distance_m:g} m should be {meant_m[0]:g} m, a slip of the decimal point"
        case Fault.FEET:
            return "the distances are in feet; give them in metres (times 0.3048)"
        case Fault.POINT:
            return (
                f"{wrong[0]} sits on the wrong mark, has a wrong distance, or the road is not flat there; "
                f"leave it out or click it again{_or_tilted(points)}"
            )
        case Fault.DASHES:
            first_m = min(suspicion.distances_m) + suspicion.offset_m
            period = "" if suspicion.period_m is None else f" and repeat every {suspicion.period_m:g} m"
            return (
                "evenly spaced marks whose first distance was guessed: they would begin "
                f"{first_m:.1f} m from the camera{period}. Measure the first distance and the period"
            )
        case _:
            return f"{SHORT[suspicion.fault]}; state the row of the axis, or use an uncropped picture"


def _or_tilted(points: Sequence[GroundPoint]) -> str:
    """Of what a camera's roll looks like where nobody said which marks lie to which side."""
    if all(point.column_px is not None for point in points):
        return ""
    return "; or the camera is tilted: give the columns of the marks, too (DISTANCE:ROW:COLUMN)"


def cause_of(
    error: PointsError,
    points: Sequence[GroundPoint],
    image_size: ImageSize,
    height_m: float,
    reference_offset_m: float,
    row_sigma_px: float,
    priors: Priors,
    tape_error: float,
) -> str | None:
    """Why points determine no camera, where one mistake explains it; arguments as those of `calibrate`."""
    if error.fault not in JUDGED or len(points) < PARAMETER_COUNT:
        return None
    named = judge_points(
        points, image_size, height_m, reference_offset_m, row_sigma_px, priors, tape_error
    ).named
    return named and cause_text(named, points, reference_offset_m)


def unclear_text(judgement: Judgement, points: Sequence[GroundPoint]) -> str:
    """Where something is wrong but the points do not tell what."""
    likely = [SHORT[s.fault] for s in judgement.suspicions[:LISTED]]
    return (
        f"one of these: {'; or '.join(likely)}. The points do not tell which: measure again, and add a point "
        f"far away{_or_tilted(points)}"
    )


def period_text(doubt: PeriodDoubt) -> str:
    """What another period of the dashes would change, and what would tell."""
    place = DASH_PERIODS_M.get(doubt.other_m)
    other = f"repeat every {doubt.other_m:g} m{f' ({place})' if place else ''}"
    if doubt.other_m == doubt.said_m:
        other = "are not next to each other: one was passed over"
    return (
        f"evenly spaced marks do not tell whether their period is {doubt.said_m:.4g} m: if these dashes "
        f"{other}, what reads 40 m is {40 * doubt.scale:.0f} m away. Give the lens's field of view, or "
        "measure the distances; until then the intervals are wider"
    )
