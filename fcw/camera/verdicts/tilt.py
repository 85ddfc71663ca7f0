"""A camera that comes out tilted, or a mistake in points to both sides: each looks like the other."""

from dataclasses import replace

from fcw.camera.calibration import Calibration
from fcw.camera.joint.known import Known
from fcw.camera.joint.solve import calibrate_jointly
from fcw.camera.points import PARAMETER_COUNT, PointsError
from fcw.camera.prior_sigmas import ROLL_SIGMA_RAD
from fcw.camera.verdicts.judgement import Judgement, judge
from fcw.camera.verdicts.words import JUDGED, SHORT
from fcw.errors import UserError

ODD_ROLL_RAD = 2.0 * ROLL_SIGMA_RAD
"""By more than this few cameras are tilted."""
TOLD_APART_ODDS = 0.15
"""A mistake that is less likely than this beside a tilt is not asked about. Of four points and more a tilt
leaves it a fiftieth; of three to both sides, which cannot tell the two apart, a tenth to a half."""
UNNAMED = "a distance is wrong, or a point sits on the wrong mark"


def if_level(calibration: Calibration, judgement: Judgement | None, imperial: bool = False) -> str:
    """What would be wrong if the camera were level, in words; empty where that is no question.

    It is none where the points tell a tilt from a mistake, or where noise would explain them of a level
    camera, too.

    Args:
        calibration: whose camera came out tilted.
        judgement: of its points, with the roll left open; None where there are too few.
        imperial: the distances were typed in feet.
    """
    if judgement is not None and (judgement.if_careful or judgement).odds < TOLD_APART_ODDS:
        return ""
    is_odd = abs(calibration.orientation.roll_rad) > ODD_ROLL_RAD
    if len(calibration.points) < PARAMETER_COUNT:
        return UNNAMED if is_odd else ""
    rows = tuple(replace(point, column_px=None) for point in calibration.points)
    level = replace(calibration.orientation, roll_rad=0.0)
    rigid = judge(replace(calibration, points=rows, orientation=level), imperial)
    rigid = rigid.question or rigid
    if not rigid.is_suspect:
        return UNNAMED if is_odd else ""
    return SHORT[rigid.named.fault] if rigid.named else UNNAMED


def tilted_instead(known: Known, error: PointsError) -> Calibration:
    """The fit of everything, where a tilt explains points whose rows alone are those of no camera.

    Args:
        known: everything.
        error: what the rows alone say of the points.

    Raises:
        PointsError: that error, where a tilt does not explain them.
    """
    columns = {point.column_px for point in known.evidence.points}
    if error.fault not in JUDGED or len(columns) < 2 or len(known.evidence.points) < PARAMETER_COUNT:
        raise error
    try:
        calibration = calibrate_jointly(known)
    except UserError:
        raise error from None
    judgement = judge(calibration)
    if judgement.is_suspect or judgement.question is not None:
        raise error
    return calibration
