"""Moments of a session, solved from points without a picture, for the tests of what is drawn."""

from collections.abc import Sequence
from pathlib import Path

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document.document import Document, Mark
from fcw_viz.calibrate_app.document.solution import solve
from fcw_viz.calibrate_app.document.state import Result, SessionState

SIZE = ImageSize(1280, 720)
TRUE_CAMERA = GroundPlaneCamera(0.03, 1100.0, 359.5, 1.225, 639.5)
"""The camera of notes and tests that predict errors: 5, 10, 20 m give 37.9 to 42.6 m at 40 m."""


def marks_at(
    distances_m: Sequence[float], camera: GroundPlaneCamera = TRUE_CAMERA, errors_px: Sequence[float] = ()
) -> tuple[Mark, ...]:
    """Marks clicked where the camera sees the distances, each with its error."""
    errors = (*errors_px, *[0.0] * len(distances_m))
    return tuple(
        Mark(number, 600.0, camera.row_at(distance_m) + errors[number - 1], distance_m, frame=0)
        for number, distance_m in enumerate(distances_m, start=1)
    )


def document_of(marks: tuple[Mark, ...], row_sigma_px: float = 1.0) -> Document:
    """What somebody says who clicks these marks and knows the camera's height."""
    return Document(SIZE, marks, len(marks) + 1, height_m=1.225, row_sigma_px=row_sigma_px)


def good_document(distances_m: Sequence[float] = (5.0, 10.0, 20.0)) -> Document:
    """Points without error at these distances."""
    return document_of(marks_at(distances_m))


def paper_document() -> Document:
    """The paper's own example, which comes out implausible."""
    rows = ((4.0, 461.0), (5.0, 428.0), (7.0, 383.0))
    marks = (Mark(k, 640.0, row_px, distance_m, frame=0) for k, (distance_m, row_px) in enumerate(rows, 1))
    return document_of(tuple(marks))


def state_of(document: Document, last_good: Result | None = None) -> SessionState:
    """The moment after these words; the last good result is shown where nothing follows from them.

    Without the effects of beliefs and the mends that take several solutions: neither is drawn.
    """
    solution = solve(document, effects=False)
    return SessionState(
        revision=1,
        document=document,
        solution=solution,
        shown=solution.result or last_good,
        current=solution.result is not None,
        can_undo=True,
        can_redo=False,
        save_path=Path("drive.calibration.yaml"),
        saved=False,
        people=("tab 1",),
    )


def shown(state: SessionState) -> Result:
    """The result that the state must have."""
    assert state.shown is not None
    return state.shown
