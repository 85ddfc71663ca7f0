"""Points in the sky: said of the point itself, as soon as the others tell where the horizon is."""

from collections.abc import Callable
from dataclasses import replace

from fcw.camera.calibration import Calibration, Gaussian
from fcw.camera.uncertainty import camera_sigmas
from fcw.errors import UserError
from fcw_viz.calibrate_app.document import words
from fcw_viz.calibrate_app.document.document import Document, Mark
from fcw_viz.calibrate_app.document.edits import DeleteMark
from fcw_viz.calibrate_app.document.state import Mend, Trouble
from fcw_viz.calibrate_app.document.troubles import speaks_against

SURE_SIGMAS = 3.0
"""So far above the horizon a point is in the sky, and no far point of the road clicked badly."""


def sky_troubles(
    document: Document, calibrate: Callable[[Document], Calibration | None]
) -> tuple[Trouble, ...]:
    """One for each mark that lies above the horizon which everything but that mark gives.

    Args:
        document: what was said.
        calibrate: the calibration of a document; None where something is missing; raises UserError where none
            follows.
    """
    return tuple(
        Trouble(words.sky_trouble(mark), (mark.id,), Mend(words.delete_label(mark), (DeleteMark(mark.id),)))
        for mark in document.marks
        if mark.enabled and _in_sky(document, mark, calibrate)
    )


def _in_sky(document: Document, mark: Mark, calibrate: Callable[[Document], Calibration | None]) -> bool:
    belief = document.horizon
    if belief is not None and belief.enabled:
        return _is_above(mark.row_px, belief.prior, document)
    others = replace(document, marks=tuple(other for other in document.marks if other is not mark))
    try:
        calibration = calibrate(others)
    except UserError:
        return False
    if calibration is None:
        return False
    row_px = calibration.straight_place(mark.column_px, mark.row_px)[1]
    horizon = Gaussian(calibration.horizon_row_px, camera_sigmas(calibration).horizon_row_px)
    # Others that contradict each other put the horizon anywhere; they are judged last, as that takes longest.
    return _is_above(row_px, horizon, document) and not speaks_against(calibration)


def _is_above(row_px: float, horizon: Gaussian, document: Document) -> bool:
    return row_px < horizon.value - SURE_SIGMAS * (horizon.sigma + document.row_sigma_px)
