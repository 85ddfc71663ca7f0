"""Points in the sky: told of the point itself, by the horizon that all others give."""

from collections.abc import Callable, Sequence

from fcw.camera.calibration import Calibration, Gaussian, GroundPoint
from fcw.camera.plausibility import FindingKind, plausibility
from fcw.camera.uncertainty import camera_sigmas
from fcw.camera.verdicts.hypotheses import Fault
from fcw.errors import UserError

SURE_SIGMAS = 3.0
"""A point this far above the horizon is in the sky, and not a far point of the road that was clicked
badly."""
KEEP_HORIZON = frozenset((Fault.BUMPER, Fault.FEET, Fault.AXIS))
"""Mistakes that shift or stretch all distances alike, or the picture: the horizon stays where it is."""


def lies_in_sky(
    column_px: float | None,
    row_px: float,
    distance_m: float | None,
    others: Sequence[GroundPoint],
    calibrate: Callable[[], Calibration | None],
    click_sigma_px: float,
) -> bool:
    """Whether a point lies above the horizon which everything but that point gives.

    Args:
        column_px: of the point; None straight ahead.
        row_px: of it.
        distance_m: as it was said; None where it was not.
        others: all other points that take part.
        calibrate: the calibration without the point; None where something is missing; raises UserError where
            none follows.
        click_sigma_px: standard deviation of a clicked row.
    """
    if any(other.row_px <= row_px for other in others):
        return False
    try:
        calibration = calibrate()
    except UserError:
        return False
    if calibration is None:
        return False
    ahead_px = calibration.camera.principal_column_px
    _, straight_row_px = calibration.straight_place(ahead_px if column_px is None else column_px, row_px)
    horizon = Gaussian(calibration.horizon_row_px, camera_sigmas(calibration).horizon_row_px)
    if not is_above(straight_row_px, horizon, click_sigma_px):
        return False
    # One that is said to be nearer than a lower one may be right, and that one's distance be wrong.
    in_order = distance_m is None or all(other.distance_m < distance_m for other in others)
    return _tells_horizon(calibration, in_order)


def is_above(row_px: float, horizon: Gaussian, click_sigma_px: float) -> bool:
    """Whether a row lies clearly above the horizon."""
    return row_px < horizon.value - SURE_SIGMAS * (horizon.sigma + click_sigma_px)


def _tells_horizon(calibration: Calibration, in_order: bool) -> bool:
    """Points that contradict each other put the horizon anywhere; a mistake of them all may leave it."""
    findings = plausibility(calibration)
    if any(finding.kind is FindingKind.ROLL and finding.is_question for finding in findings):
        return False  # the camera is level more likely, and a distance wrong
    against = [finding for finding in findings if finding.speaks_against]
    if not against or not in_order:
        return not against
    named = {finding.suspicion.fault for finding in against if finding.suspicion is not None}
    return bool(named) and named <= KEEP_HORIZON and not any(finding.point for finding in against)
