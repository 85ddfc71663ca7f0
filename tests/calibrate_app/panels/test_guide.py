"""The line over the picture, where it follows from more than the document."""

from dataclasses import replace
from types import SimpleNamespace

from session_helpers import SIZE

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.evidence import VEHICLE_WIDTH_M, Ruler
from fcw_viz.calibrate_app.document.document import Belief, Document
from fcw_viz.calibrate_app.document.solution import solve
from fcw_viz.calibrate_app.document.ways.ways import VEHICLES
from fcw_viz.calibrate_app.panels.camera.besides import LOOKING_WORDS, looked_words
from fcw_viz.calibrate_app.panels.guide import vehicle_words
from fcw_viz.calibrate_app.proposals.drive_look import Look

TOO_FEW = Look(None, "1 vehicle found.", instead="Use the horizon that the drive shows instead.")


def words(document: Document, running: bool = False, look: Look | None = None) -> str:
    state = SimpleNamespace(document=document, solution=solve(document))
    return vehicle_words(state, running, look)  # pyright: ignore[reportArgumentType] - only these are read


def test_who_looks_for_vehicles_is_told_how_that_goes_and_what_else_would_do():
    document = Document(SIZE, way=VEHICLES)
    assert words(document) == ""
    assert words(document, running=True) == LOOKING_WORDS
    assert words(document, look=TOO_FEW) == "1 vehicle found. Use the horizon that the drive shows instead."
    # The horizon is there instead: what is missing is asked for, and no longer the vehicles.
    with_horizon = replace(document, horizon=Belief(Gaussian(310.0, 3.0)))
    assert "the camera's height above the road" in words(with_horizon, look=TOO_FEW)
    assert looked_words(document, TOO_FEW).endswith("instead.")
    assert looked_words(with_horizon, TOO_FEW) == "1 vehicle found."


def test_vehicles_that_were_taken_are_not_offered_again():
    rulers = tuple(Ruler(column_px, 400.0, 90.0, VEHICLE_WIDTH_M, 1.0) for column_px in (500.0, 640.0))
    offered = Look(None, "2 vehicles found; press again to use them as rulers.", vehicles=rulers)
    document = Document(SIZE, way="clip")
    assert looked_words(document, offered) == offered.words
    assert looked_words(replace(document, vehicles=rulers), offered) == "2 vehicles are used as rulers."


def test_no_other_way_is_told_of_vehicles():
    assert words(Document(SIZE, way="clip"), running=True, look=TOO_FEW) == ""
