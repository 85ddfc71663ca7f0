"""Points in the sky: said of the point itself, as soon as the others tell where the horizon is."""

from collections.abc import Callable
from dataclasses import replace

from fcw.camera.calibration import Calibration
from fcw.camera.verdicts.sky import is_above, lies_in_sky
from fcw_viz.calibrate_app.document import words
from fcw_viz.calibrate_app.document.document import Document, Mark
from fcw_viz.calibrate_app.document.edits import DeleteMark
from fcw_viz.calibrate_app.document.state import Mend, Trouble


def sky_troubles(
    document: Document, calibrate: Callable[[Document], Calibration | None], fits: bool = False
) -> tuple[Trouble, ...]:
    """One for each mark that lies above the horizon which everything but that mark gives.

    Args:
        document: what was said.
        calibrate: the calibration of a document; None where something is missing; raises UserError where none
            follows.
        fits: nothing speaks against all that was said together, marks with a distance in it: none of these
            lies in the sky then, and the calibration without it need not be looked for.
    """
    return tuple(
        Trouble(words.sky_trouble(mark), (mark.id,), Mend(words.delete_label(mark), (DeleteMark(mark.id),)))
        for mark in document.marks
        if mark.enabled and not (fits and mark.ground_point) and _in_sky(document, mark, calibrate)
    )


def _in_sky(document: Document, mark: Mark, calibrate: Callable[[Document], Calibration | None]) -> bool:
    belief = document.horizon
    if belief is not None and belief.enabled:
        return is_above(mark.row_px, belief.prior, document.row_sigma_px)
    others = replace(document, marks=tuple(other for other in document.marks if other is not mark))
    points = [other.ground_point for other in others.marks if other.ground_point is not None]
    return lies_in_sky(
        mark.column_px, mark.row_px, mark.distance_m, points, lambda: calibrate(others), document.row_sigma_px
    )
