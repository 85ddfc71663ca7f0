"""What the tests of documents, journals and sessions share."""

from pathlib import Path

from hypothesis import strategies as st

from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize
from fcw_viz.calibrate_app.document import edits as e
from fcw_viz.calibrate_app.document.document import Belief, Document, Line
from fcw_viz.calibrate_app.document.edits import AddMark, Edit, SetHeight
from fcw_viz.calibrate_app.document.journal import journal_path, read_journal
from fcw_viz.calibrate_app.document.state import Mend, SessionState, Solution, Trouble
from fcw_viz.calibrate_app.session import CalibrationSession

SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(0.05, 1000.0, 359.5, 1.3, 639.5)
"""A plausible one: 65 degrees from side to side, 3 degrees down."""
PAPER_POINTS = ((4.0, 461.0), (5.0, 428.0), (7.0, 383.0))

finite = st.floats(-1e4, 1e4)
positive = st.floats(1e-3, 500)
ids = st.integers(1, 8)
columns, rows = st.floats(-0.5, SIZE.width - 0.5), st.floats(-0.5, SIZE.height - 0.5)
beliefs = st.none() | st.builds(Belief, st.builds(Gaussian, st.floats(1, 700), positive), st.booleans())
angles = st.none() | st.builds(
    Belief, st.builds(Gaussian, st.floats(0.1, 3), st.floats(1e-3, 1)), st.booleans()
)
lines = st.none() | st.builds(Line, st.tuples(columns, rows), st.tuples(columns, rows))
edits: st.SearchStrategy[Edit] = st.one_of(
    st.builds(e.AddMark, columns, rows, st.none() | st.integers(0, 99), st.none() | positive),
    st.builds(e.MoveMark, ids, finite, finite),
    st.builds(e.SetDistance, ids, st.none() | positive),
    st.builds(e.EnableMark, ids, st.booleans()),
    st.builds(e.DeleteMark, ids),
    st.builds(e.PlanDistances, st.lists(positive, max_size=4).map(tuple)),
    st.builds(e.SetHeight, st.none() | positive),
    st.builds(e.SetReference, st.booleans(), st.none() | st.floats(0, 4)),
    st.builds(e.SetRowSigma, positive),
    st.builds(e.SetFieldOfView, angles),
    st.builds(e.SetPrincipalRow, beliefs),
    st.builds(e.SetHorizon, beliefs),
    st.builds(e.SetLaneLine, st.integers(0, 1), lines),
    st.builds(e.EnableLaneLines, st.booleans()),
    st.builds(e.SetUnits, st.booleans()),
)


def said(*points: tuple[float, float], **fields) -> Document:
    """A document with marks at (distance, row)."""
    document = Document(SIZE, **fields)
    for distance_m, row_px in points:
        document = AddMark(600.0, row_px, 0, distance_m).apply(document)
    return document


def untold(*rows_px: float, **fields) -> Document:
    """A document with marks whose distances are not known yet."""
    document = Document(SIZE, **fields)
    for row_px in rows_px:
        document = AddMark(600.0, row_px).apply(document)
    return document


def only_trouble(solution: Solution) -> Trouble:
    """The one that there is."""
    (trouble,) = solution.troubles
    return trouble


def mended(document: Document, mend: Mend | None) -> Document:
    """The document after a proposal is taken."""
    assert mend is not None
    for edit in mend.edits:
        document = edit.apply(document)
    return document


def seen(*distances_m: float) -> list[tuple[float, float]]:
    """(distance, row) as `CAMERA` sees them."""
    return [(distance_m, CAMERA.row_at(distance_m)) for distance_m in distances_m]


def open_session(folder: Path, size: ImageSize = SIZE) -> CalibrationSession:
    """A session on the drive of a folder."""
    return CalibrationSession.open(folder / "drive.mp4", size, save_path(folder))


def save_path(folder: Path) -> Path:
    """Where it saves."""
    return folder / "drive.calibration.yaml"


def nobody(state: SessionState) -> None:
    """A listener that does nothing."""


def tell(session, person, points, height_m=None) -> None:
    for distance_m, row_px in points:
        session.apply(person, AddMark(600.0, row_px, 0, distance_m))
    if height_m is not None:
        session.apply(person, SetHeight(height_m))


def calibrated(session):
    """Somebody who has said all that a good calibration needs."""
    anna = session.join(nobody)
    tell(session, anna, seen(6, 15, 40), height_m=1.3)
    return anna


def kept(folder: Path):
    """The document that the journal says."""
    content = read_journal(journal_path(save_path(folder)))
    assert content is not None
    return content.history.document
